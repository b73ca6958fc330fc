/* Swapchains: OpenGL textures that are made in the context that the program has bound. */

#include "runtime.h"

#include <stdio.h>
#include <stdlib.h>
#ifndef _WIN32
#include <dlfcn.h>
#endif

#ifdef _WIN32
#define GL_CALL APIENTRY
#else
#define GL_CALL
#endif
#define IMAGES 3
#define MOST_SWAPCHAINS 64
#define MOST_LAYERS 2
#define TEXTURE_2D 0x0DE1
#define TEXTURE_2D_ARRAY 0x8C1A
#define TEXTURE_BINDING_2D 0x8069
#define TEXTURE_BINDING_2D_ARRAY 0x8C1D
#define SRGB8_ALPHA8 0x8C43
#define RGBA8 0x8058
#define DEPTH_COMPONENT32F 0x8CAC

typedef void (*Function)(void);
static Function (*find)(const char *name);
static void *(*current_context)(void);
static void *bound_context;
static struct {
    void(GL_CALL *gen_textures)(int, unsigned *);
    void(GL_CALL *delete_textures)(int, const unsigned *);
    void(GL_CALL *bind_texture)(unsigned, unsigned);
    void(GL_CALL *get_integer)(unsigned, int *);
    void(GL_CALL *tex_storage)(unsigned, int, unsigned, int, int);
    void(GL_CALL *tex_storage_3d)(unsigned, int, unsigned, int, int, int);
} gl;

typedef struct {
    bool exists, lent, waited, drawn;
    XrSwapchainCreateInfo info;
    unsigned textures[IMAGES];
    uint32_t next;
} Swapchain;

static Swapchain swapchains[MOST_SWAPCHAINS];

#ifdef _WIN32

static Function find_wgl(const char *name) {
    Function found = (Function)wglGetProcAddress(name);
    if (found != NULL) return found;
    return (Function)GetProcAddress(GetModuleHandleA("opengl32.dll"), name);
}

static void *current_wgl(void) { return wglGetCurrentContext(); }

static XrResult take_binding(const XrBaseInStructure *binding) {
    if (binding->type != XR_TYPE_GRAPHICS_BINDING_OPENGL_WIN32_KHR)
        return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    const XrGraphicsBindingOpenGLWin32KHR *win32 = (const void *)binding;
    if (win32->hDC != wglGetCurrentDC()) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    bound_context = win32->hGLRC;
    current_context = current_wgl;
    find = find_wgl;
    return XR_SUCCESS;
}

#else

static XrResult take_binding(const XrBaseInStructure *binding) {
    if (binding->type == XR_TYPE_GRAPHICS_BINDING_EGL_MNDX) {
        const XrGraphicsBindingEGLMNDX *egl = (const void *)binding;
        if (!is_enabled(XR_MNDX_EGL_ENABLE_EXTENSION_NAME) || egl->display == NULL)
            return XR_ERROR_GRAPHICS_DEVICE_INVALID;
        bound_context = egl->context;
        find = (Function(*)(const char *))egl->getProcAddress;
        current_context = (void *(*)(void))find("eglGetCurrentContext");
        return XR_SUCCESS;
    }
    if (binding->type == XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR) {
        const XrGraphicsBindingOpenGLXlibKHR *xlib = (const void *)binding;
        void *library = dlopen("libGL.so.1", RTLD_NOW);
        if (library == NULL || xlib->xDisplay == NULL) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
        bound_context = xlib->glxContext;
        *(void **)&find = dlsym(library, "glXGetProcAddressARB");
        *(void **)&current_context = dlsym(library, "glXGetCurrentContext");
        return XR_SUCCESS;
    }
    return XR_ERROR_GRAPHICS_DEVICE_INVALID;
}

#endif

#define LOAD(field, name) (*(Function *)&gl.field = find(name))

XrResult bind_graphics(const void *next) {
    if (next == NULL) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    XrResult taken = take_binding(next);
    if (taken != XR_SUCCESS) return taken;
    if (!is_bound_current()) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    bool found = LOAD(gen_textures, "glGenTextures") && LOAD(bind_texture, "glBindTexture") &&
                 LOAD(delete_textures, "glDeleteTextures") &&
                 LOAD(get_integer, "glGetIntegerv") && LOAD(tex_storage, "glTexStorage2D") &&
                 LOAD(tex_storage_3d, "glTexStorage3D");
    return found ? XR_SUCCESS : XR_ERROR_GRAPHICS_DEVICE_INVALID;
}

bool is_bound_current(void) {
    bool is = current_context != NULL && current_context() == bound_context;
    if (!is) fprintf(stderr, "test runtime: another OpenGL context is current than was bound\n");
    return is;
}

XrResult xrEnumerateSwapchainFormats(XrSession session, uint32_t capacity, uint32_t *count,
                                     int64_t *formats) {
    (void)session;
    ENTER("xrEnumerateSwapchainFormats");
    static const int64_t offered[] = {SRGB8_ALPHA8, RGBA8, DEPTH_COMPONENT32F};
    FILL(capacity, count, formats, 3, offered[i]);
}

XrResult xrCreateSwapchain(XrSession session, const XrSwapchainCreateInfo *info,
                           XrSwapchain *created) {
    (void)session;
    ENTER("xrCreateSwapchain");
    Swapchain *chain = NULL;
    int before;
    for (int i = 0; i < MOST_SWAPCHAINS && chain == NULL; i++)
        if (!swapchains[i].exists) chain = &swapchains[i];
    if (chain == NULL) return XR_ERROR_LIMIT_REACHED;
    if (info->format != SRGB8_ALPHA8 && info->format != RGBA8 &&
        info->format != DEPTH_COMPONENT32F)
        return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
    if (info->width == 0 || info->height == 0 || info->width > 4096 || info->height > 4096)
        return XR_ERROR_SWAPCHAIN_RECT_INVALID;
    if (info->sampleCount != 1 || info->faceCount != 1 || info->arraySize < 1 ||
        info->arraySize > MOST_LAYERS || info->mipCount != 1)
        return XR_ERROR_FEATURE_UNSUPPORTED;
    if (!is_bound_current()) return XR_ERROR_RUNTIME_FAILURE;
    *chain = (Swapchain){.exists = true, .info = *info};
    bool array = info->arraySize > 1;
    unsigned kind = array ? TEXTURE_2D_ARRAY : TEXTURE_2D, format = (unsigned)info->format;
    int width = (int)info->width, height = (int)info->height;
    gl.get_integer(array ? TEXTURE_BINDING_2D_ARRAY : TEXTURE_BINDING_2D, &before);
    gl.gen_textures(IMAGES, chain->textures);
    for (int i = 0; i < IMAGES; i++) {
        gl.bind_texture(kind, chain->textures[i]);
        if (array)
            gl.tex_storage_3d(kind, 1, format, width, height, (int)info->arraySize);
        else
            gl.tex_storage(kind, 1, format, width, height);
    }
    gl.bind_texture(kind, (unsigned)before);
    *created = (XrSwapchain)chain;
    return XR_SUCCESS;
}

XrResult xrDestroySwapchain(XrSwapchain handle) {
    Swapchain *chain = (Swapchain *)handle;
    if (!is_bound_current()) return XR_ERROR_RUNTIME_FAILURE;
    gl.delete_textures(IMAGES, chain->textures);
    chain->exists = false;
    return XR_SUCCESS;
}

XrResult destroy_swapchains(void) {
    for (int i = 0; i < MOST_SWAPCHAINS; i++)
        if (swapchains[i].exists) xrDestroySwapchain((XrSwapchain)&swapchains[i]);
    return XR_SUCCESS;
}

XrResult xrEnumerateSwapchainImages(XrSwapchain handle, uint32_t capacity, uint32_t *count,
                                    XrSwapchainImageBaseHeader *images) {
    ENTER("xrEnumerateSwapchainImages");
    XrSwapchainImageOpenGLKHR *textures = (XrSwapchainImageOpenGLKHR *)images;
    *count = IMAGES;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < IMAGES) return XR_ERROR_SIZE_INSUFFICIENT;
    if (textures[0].type != XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR) return XR_ERROR_VALIDATION_FAILURE;
    for (int i = 0; i < IMAGES; i++) textures[i].image = ((Swapchain *)handle)->textures[i];
    return XR_SUCCESS;
}

XrResult xrAcquireSwapchainImage(XrSwapchain handle, const XrSwapchainImageAcquireInfo *info,
                                 uint32_t *index) {
    (void)info;
    ENTER("xrAcquireSwapchainImage");
    Swapchain *chain = (Swapchain *)handle;
    if (chain->lent) return XR_ERROR_CALL_ORDER_INVALID;
    chain->lent = true;
    chain->waited = false;
    *index = chain->next;
    chain->next = (chain->next + 1) % IMAGES;
    return XR_SUCCESS;
}

XrResult xrWaitSwapchainImage(XrSwapchain handle, const XrSwapchainImageWaitInfo *info) {
    (void)info;
    ENTER("xrWaitSwapchainImage");
    Swapchain *chain = (Swapchain *)handle;
    if (!chain->lent || chain->waited) return XR_ERROR_CALL_ORDER_INVALID;
    chain->waited = true;
    return XR_SUCCESS;
}

XrResult xrReleaseSwapchainImage(XrSwapchain handle, const XrSwapchainImageReleaseInfo *info) {
    (void)info;
    ENTER("xrReleaseSwapchainImage");
    Swapchain *chain = (Swapchain *)handle;
    if (!chain->waited) return XR_ERROR_CALL_ORDER_INVALID;
    chain->lent = chain->waited = false;
    chain->drawn = true;
    return XR_SUCCESS;
}

/* Whether a layer's part lies in an image that has been given back. */
bool was_drawn(const XrSwapchainSubImage *image) {
    const Swapchain *chain = (const Swapchain *)image->swapchain;
    const XrRect2Di *rect = &image->imageRect;
    return chain != NULL && chain->exists && chain->drawn &&
           image->imageArrayIndex < chain->info.arraySize && rect->offset.x >= 0 &&
           rect->offset.y >= 0 && rect->extent.width > 0 && rect->extent.height > 0 &&
           rect->offset.x + rect->extent.width <= (int)chain->info.width &&
           rect->offset.y + rect->extent.height <= (int)chain->info.height;
}
