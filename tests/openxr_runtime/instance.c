/* Negotiation with the loader, the instance, its system, paths, and where functions are found. */

#include "runtime.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SYSTEM ((XrSystemId)1)
#define MOST_PATHS 1024

static const char *const EXTENSIONS[] = {
    XR_KHR_OPENGL_ENABLE_EXTENSION_NAME,
#ifdef _WIN32
    XR_KHR_WIN32_CONVERT_PERFORMANCE_COUNTER_TIME_EXTENSION_NAME,
#else
    XR_MNDX_EGL_ENABLE_EXTENSION_NAME,
    XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
#endif
    XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
    XR_KHR_VISIBILITY_MASK_EXTENSION_NAME,
    XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME,
    XR_EXT_USER_PRESENCE_EXTENSION_NAME,
    XR_EXT_LOCAL_FLOOR_EXTENSION_NAME,
    XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME,
    XR_EXT_HAND_TRACKING_EXTENSION_NAME,
    "XR_EXT_hp_mixed_reality_controller",
    "XR_HTC_vive_focus3_controller_interaction",
    "XR_HTC_vive_cosmos_controller_interaction",
    "XR_BD_controller_interaction",
    "XR_ML_ml2_controller_interaction",
    "XR_FB_touch_controller_pro",
    "XR_META_touch_controller_plus",
    "XR_EXT_samsung_odyssey_controller",
    "XR_BD_ultra_controller_interaction",
    "XR_OPPO_controller_interaction",
    "XR_YVR_controller_interaction",
    "XR_VARJO_xr4_controller_interaction",
    "XR_HUAWEI_controller_interaction",
    "XR_LOGITECH_mx_ink_stylus_interaction",
    "XR_KHR_generic_controller",
    "XR_EXT_hand_interaction",
    "XR_MSFT_hand_interaction",
};
#define MOST_EXTENSIONS (sizeof EXTENSIONS / sizeof *EXTENSIONS)

static bool enabled[MOST_EXTENSIONS];
static char *paths[MOST_PATHS];
static int path_count;
static int made; /* any address will do for a handle */

bool is_enabled(const char *extension) {
    for (size_t i = 0; i < MOST_EXTENSIONS; i++)
        if (strcmp(EXTENSIONS[i], extension) == 0) return enabled[i];
    return false;
}

XrPath path_of(const char *text) {
    for (int i = 0; i < path_count; i++)
        if (strcmp(paths[i], text) == 0) return (XrPath)(i + 1);
    if (path_count == MOST_PATHS) return XR_NULL_PATH;
    char *copy = malloc(strlen(text) + 1);
    if (copy == NULL) return XR_NULL_PATH;
    paths[path_count] = strcpy(copy, text);
    return (XrPath)++path_count;
}

const char *text_of(XrPath path) {
    return path >= 1 && path <= (XrPath)path_count ? paths[path - 1] : NULL;
}

XrResult xrEnumerateInstanceExtensionProperties(const char *layer, uint32_t capacity,
                                                uint32_t *count,
                                                XrExtensionProperties *properties) {
    const char *offered[MOST_EXTENSIONS];
    uint32_t number = 0;
    if (layer != NULL) return XR_ERROR_API_LAYER_NOT_PRESENT;
    for (size_t i = 0; i < MOST_EXTENSIONS; i++)
        if (script_has(EXTENSIONS[i])) offered[number++] = EXTENSIONS[i];
    *count = number;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < number) return XR_ERROR_SIZE_INSUFFICIENT;
    for (uint32_t i = 0; i < number; i++) {
        snprintf(properties[i].extensionName, XR_MAX_EXTENSION_NAME_SIZE, "%s", offered[i]);
        properties[i].extensionVersion = 1;
    }
    return XR_SUCCESS;
}

XrResult xrCreateInstance(const XrInstanceCreateInfo *info, XrInstance *instance) {
    ENTER("xrCreateInstance");
    memset(enabled, 0, sizeof enabled);
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++) {
        const char *name = info->enabledExtensionNames[i];
        bool found = false;
        for (size_t k = 0; k < MOST_EXTENSIONS; k++)
            if (strcmp(EXTENSIONS[k], name) == 0 && script_has(name)) found = enabled[k] = true;
        if (!found) return XR_ERROR_EXTENSION_NOT_PRESENT;
    }
    *instance = (XrInstance)&made;
    return XR_SUCCESS;
}

XrResult xrDestroyInstance(XrInstance instance) {
    (void)instance;
    forget_actions();
    return XR_SUCCESS;
}

XrResult xrGetInstanceProperties(XrInstance instance, XrInstanceProperties *properties) {
    (void)instance;
    ENTER("xrGetInstanceProperties");
    properties->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
    snprintf(properties->runtimeName, XR_MAX_RUNTIME_NAME_SIZE, "%s", settings.runtime);
    return XR_SUCCESS;
}

XrResult xrGetSystem(XrInstance instance, const XrSystemGetInfo *info, XrSystemId *system) {
    (void)instance;
    ENTER("xrGetSystem");
    if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY)
        return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
    *system = SYSTEM;
    return XR_SUCCESS;
}

XrResult xrGetSystemProperties(XrInstance instance, XrSystemId system,
                               XrSystemProperties *properties) {
    (void)instance;
    ENTER("xrGetSystemProperties");
    if (system != SYSTEM) return XR_ERROR_SYSTEM_INVALID;
    properties->systemId = SYSTEM;
    properties->vendorId = 0;
    snprintf(properties->systemName, XR_MAX_SYSTEM_NAME_SIZE, "%s", settings.headset);
    properties->graphicsProperties = (XrSystemGraphicsProperties){4096, 4096, 16};
    properties->trackingProperties = (XrSystemTrackingProperties){XR_TRUE, XR_TRUE};
    for (XrBaseOutStructure *next = properties->next; next != NULL; next = next->next) {
        XrBool32 *supports = (XrBool32 *)(next + 1); /* the one field of each of these */
        if (next->type == XR_TYPE_SYSTEM_EYE_GAZE_INTERACTION_PROPERTIES_EXT)
            *supports = settings.eyes;
        else if (next->type == XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT ||
                 next->type == XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT)
            *supports = XR_TRUE;
    }
    return XR_SUCCESS;
}

XrResult xrEnumerateViewConfigurations(XrInstance instance, XrSystemId system, uint32_t capacity,
                                       uint32_t *count, XrViewConfigurationType *types) {
    (void)instance, (void)system;
    ENTER("xrEnumerateViewConfigurations");
    FILL(capacity, count, types, 1, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO);
}

XrResult xrGetViewConfigurationProperties(XrInstance instance, XrSystemId system,
                                          XrViewConfigurationType type,
                                          XrViewConfigurationProperties *properties) {
    (void)instance, (void)system;
    properties->viewConfigurationType = type;
    properties->fovMutable = XR_FALSE;
    return XR_SUCCESS;
}

XrResult xrEnumerateViewConfigurationViews(XrInstance instance, XrSystemId system,
                                           XrViewConfigurationType type, uint32_t capacity,
                                           uint32_t *count, XrViewConfigurationView *views) {
    (void)instance, (void)system;
    ENTER("xrEnumerateViewConfigurationViews");
    if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
    XrViewConfigurationView view = {
        XR_TYPE_VIEW_CONFIGURATION_VIEW, NULL, settings.width, 4096, settings.height, 4096, 1, 1,
    };
    FILL(capacity, count, views, 2, view);
}

XrResult xrEnumerateEnvironmentBlendModes(XrInstance instance, XrSystemId system,
                                          XrViewConfigurationType type, uint32_t capacity,
                                          uint32_t *count, XrEnvironmentBlendMode *modes) {
    (void)instance, (void)system, (void)type;
    ENTER("xrEnumerateEnvironmentBlendModes");
    FILL(capacity, count, modes, 1, XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
}

XrResult xrStringToPath(XrInstance instance, const char *text, XrPath *path) {
    (void)instance;
    if (text[0] != '/') return XR_ERROR_PATH_FORMAT_INVALID;
    *path = path_of(text);
    return *path == XR_NULL_PATH ? XR_ERROR_PATH_COUNT_EXCEEDED : XR_SUCCESS;
}

XrResult xrPathToString(XrInstance instance, XrPath path, uint32_t capacity, uint32_t *count,
                        char *buffer) {
    (void)instance;
    const char *text = text_of(path);
    if (text == NULL) return XR_ERROR_PATH_INVALID;
    FILL(capacity, count, buffer, strlen(text) + 1, text[i]);
}

XrResult xrResultToString(XrInstance instance, XrResult value,
                          char buffer[XR_MAX_RESULT_STRING_SIZE]) {
    (void)instance;
    snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "XR_RESULT_%d", value);
    return XR_SUCCESS;
}

XrResult xrStructureTypeToString(XrInstance instance, XrStructureType value,
                                 char buffer[XR_MAX_STRUCTURE_NAME_SIZE]) {
    (void)instance;
    snprintf(buffer, XR_MAX_STRUCTURE_NAME_SIZE, "XR_STRUCTURE_TYPE_%d", value);
    return XR_SUCCESS;
}

XrResult xrGetOpenGLGraphicsRequirementsKHR(XrInstance instance, XrSystemId system,
                                            XrGraphicsRequirementsOpenGLKHR *requirements) {
    (void)instance, (void)system;
    ENTER("xrGetOpenGLGraphicsRequirementsKHR");
    requirements->minApiVersionSupported = XR_MAKE_VERSION(4, 0, 0);
    requirements->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
    return XR_SUCCESS;
}

XrResult xrGetInstanceProcAddr(XrInstance instance, const char *name, PFN_xrVoidFunction *function);

#define ALL(X)                                                                              \
    X(xrGetInstanceProcAddr) X(xrEnumerateInstanceExtensionProperties) X(xrCreateInstance)  \
    X(xrDestroyInstance) X(xrGetInstanceProperties) X(xrPollEvent) X(xrResultToString)      \
    X(xrStructureTypeToString) X(xrGetSystem) X(xrGetSystemProperties)                      \
    X(xrEnumerateEnvironmentBlendModes) X(xrCreateSession) X(xrDestroySession)              \
    X(xrEnumerateReferenceSpaces) X(xrCreateReferenceSpace) X(xrGetReferenceSpaceBoundsRect) \
    X(xrCreateActionSpace) X(xrLocateSpace) X(xrDestroySpace) X(xrEnumerateViewConfigurations) \
    X(xrGetViewConfigurationProperties) X(xrEnumerateViewConfigurationViews)                \
    X(xrEnumerateSwapchainFormats) X(xrCreateSwapchain) X(xrDestroySwapchain)               \
    X(xrEnumerateSwapchainImages) X(xrAcquireSwapchainImage) X(xrWaitSwapchainImage)        \
    X(xrReleaseSwapchainImage) X(xrBeginSession) X(xrEndSession) X(xrRequestExitSession)    \
    X(xrWaitFrame) X(xrBeginFrame) X(xrEndFrame) X(xrLocateViews) X(xrStringToPath)         \
    X(xrPathToString) X(xrCreateActionSet) X(xrDestroyActionSet) X(xrCreateAction)          \
    X(xrDestroyAction) X(xrSuggestInteractionProfileBindings) X(xrAttachSessionActionSets)  \
    X(xrGetCurrentInteractionProfile) X(xrGetActionStateBoolean) X(xrGetActionStateFloat)   \
    X(xrGetActionStateVector2f) X(xrGetActionStatePose) X(xrSyncActions)                    \
    X(xrEnumerateBoundSourcesForAction) X(xrGetInputSourceLocalizedName)                    \
    X(xrApplyHapticFeedback) X(xrStopHapticFeedback) X(xrGetOpenGLGraphicsRequirementsKHR)  \
    X(xrGetVisibilityMaskKHR) X(xrEnumerateDisplayRefreshRatesFB)                           \
    X(xrGetDisplayRefreshRateFB) X(xrRequestDisplayRefreshRateFB) X(xrCreateHandTrackerEXT) \
    X(xrDestroyHandTrackerEXT) X(xrLocateHandJointsEXT) PLATFORM(X)
#ifdef _WIN32
#define PLATFORM(X) \
    X(xrConvertWin32PerformanceCounterToTimeKHR) X(xrConvertTimeToWin32PerformanceCounterKHR)
#else
#define PLATFORM(X) X(xrConvertTimespecTimeToTimeKHR) X(xrConvertTimeToTimespecTimeKHR)
#endif

XrResult xrGetInstanceProcAddr(XrInstance instance, const char *name,
                               PFN_xrVoidFunction *function) {
    (void)instance;
#define FIND(each) {#each, (PFN_xrVoidFunction)each},
    static const struct {
        const char *name;
        PFN_xrVoidFunction function;
    } known[] = {ALL(FIND)};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(known[i].name, name) == 0) {
            *function = known[i].function;
            return XR_SUCCESS;
        }
    *function = NULL;
    return XR_ERROR_FUNCTION_UNSUPPORTED;
}

EXPORTED XRAPI_ATTR XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(const LoaderInfo *info,
                                                                          RuntimeRequest *request);

XrResult xrNegotiateLoaderRuntimeInterface(const LoaderInfo *info, RuntimeRequest *request) {
    if (info->minInterfaceVersion > 1 || !read_script()) return XR_ERROR_INITIALIZATION_FAILED;
    request->runtimeInterfaceVersion = 1;
    request->runtimeApiVersion = XR_MAKE_VERSION(1, 0, 34);
    request->getInstanceProcAddr = xrGetInstanceProcAddr;
    return XR_SUCCESS;
}
