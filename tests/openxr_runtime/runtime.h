/* Declarations that the parts of the test runtime share, and what older OpenXR headers lack. */

#ifndef RUNTIME_H
#define RUNTIME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef _WIN32
#include <windows.h>
#include <unknwn.h>
#define XR_USE_PLATFORM_WIN32
#define EXPORTED __declspec(dllexport)
#else
#include <time.h>
#define XR_USE_TIMESPEC
#define XR_USE_PLATFORM_EGL
#define XR_USE_PLATFORM_XLIB
#define EXPORTED __attribute__((visibility("default")))
typedef void *EGLDisplay, *EGLConfig, *EGLContext; /* what the bindings of OpenXR are made of */
typedef unsigned int EGLenum;
typedef void (*(*PFNEGLGETPROCADDRESSPROC)(const char *))(void);
typedef struct _XDisplay Display;
typedef void *GLXFBConfig, *GLXContext;
typedef unsigned long GLXDrawable;
#endif
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_EXTENSION_PROTOTYPES
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#ifndef XR_EXT_user_presence
#define XR_EXT_USER_PRESENCE_EXTENSION_NAME "XR_EXT_user_presence"
#define XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT ((XrStructureType)1000470000)
#define XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT ((XrStructureType)1000470001)
typedef struct {
    XrStructureType type;
    const void *next;
    XrSession session;
    XrBool32 isUserPresent;
} XrEventDataUserPresenceChangedEXT;
typedef struct {
    XrStructureType type;
    void *next;
    XrBool32 supportsUserPresence;
} XrSystemUserPresencePropertiesEXT;
#endif
#ifndef XR_EXT_local_floor
#define XR_EXT_LOCAL_FLOOR_EXTENSION_NAME "XR_EXT_local_floor"
#define XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT ((XrReferenceSpaceType)1000426000)
#endif

/* Between the loader and a runtime; the headers that distributions ship leave it out. */
typedef struct {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t minInterfaceVersion, maxInterfaceVersion;
    XrVersion minApiVersion, maxApiVersion;
} LoaderInfo;
typedef struct {
    uint32_t structType, structVersion;
    size_t structSize;
    uint32_t runtimeInterfaceVersion;
    XrVersion runtimeApiVersion;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
} RuntimeRequest;

#define HANDS 2
#define MOST_RATES 16

/* pose.c: stage-from-something, in float64. */
typedef struct {
    double p[3], q[4];
} Pose;
extern const Pose IDENTITY;
Pose pose_of(const XrPosef *pose);
XrPosef pose_to_xr(const Pose *pose);
Pose pose_times(const Pose *a, const Pose *b);
Pose pose_inverse(const Pose *pose);
bool pose_is_valid(const XrPosef *pose);

/* script.c: what the script says of a frame. */
typedef enum {
    HEAD, HAND, GAZE, ORIGIN, ACTIVE, PRESS, STATE, PRESENT, NOT_DRAWN, INVALID, UNTRACKED,
    PERIOD, MASK, RATE, LATE, ANSWER, HANG, INSTANCE_LOSS, KINDS
} Kind;
typedef struct {
    char headset[64], runtime[64], profiles[HANDS][64], log[512];
    uint32_t width, height;
    double period_ns, ipd_m, speed, rates_hz[MOST_RATES];
    uint32_t rates;
    uint32_t seed;
    bool eyes;
} Settings;
extern Settings settings;
bool read_script(void);
bool script_has(const char *extension);
/* The values of the last line of a kind that holds in a frame, and has that key; or NULL. */
const double *scripted(Kind kind, const char *key, int frame);
const char *scripted_state(int frame);
Pose scripted_pose(Kind kind, const char *key, int frame, Pose otherwise);
bool scripted_share(Kind kind, int frame);
/* The result that a function is to give in the present frame; hangs where it is to hang. */
XrResult scripted_result(const char *function);
#define ENTER(function)                                  \
    do {                                                 \
        XrResult answer = scripted_result(function);     \
        if (answer != XR_SUCCESS) return answer;         \
    } while (0)

/* clock.c */
int64_t machine_ns(void);
void sleep_ns(int64_t duration_ns);
XrTime display_now(void);
XrTime display_of_machine(int64_t machine);
int64_t machine_of_display(XrTime time);

/* instance.c */
extern bool enabled_presence;
bool is_enabled(const char *extension);
XrPath path_of(const char *text);
const char *text_of(XrPath path);

/* session.c */
int present_frame(void);
bool is_focused(void);
XrTime frame_time(void);
void push_event(const void *event, size_t size);
void note(const char *format, ...);

/* actions.c */
void forget_actions(void);
void update_profiles(XrSession session);
typedef struct Action Action;
Pose aim_of(const Action *action, XrPath hand, bool *known);
bool is_gaze(const Action *action);

/* graphics.c */
XrResult bind_graphics(const void *next);
bool is_bound_current(void);
bool was_drawn(const XrSwapchainSubImage *image);
XrResult destroy_swapchains(void);

/* Writes an array in OpenXR's way: capacity 0 asks for the number. */
#define FILL(capacity, count, array, number, expression)                   \
    do {                                                                   \
        *(count) = (uint32_t)(number);                                     \
        if ((capacity) == 0) return XR_SUCCESS;                            \
        if ((capacity) < (uint32_t)(number)) return XR_ERROR_SIZE_INSUFFICIENT; \
        for (uint32_t i = 0; i < (uint32_t)(number); i++) (array)[i] = (expression); \
        return XR_SUCCESS;                                                 \
    } while (0)

#endif
