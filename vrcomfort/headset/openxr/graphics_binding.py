"""Tells the runtime which OpenGL context draws: whichever is current, EGL, GLX or WGL.

The libraries of a window system exist on that system alone: each is imported where it is used.
"""

from __future__ import annotations

import ctypes
import sys
from dataclasses import dataclass
from typing import Any

import moderngl
import xr

from vrcomfort.errors import InputError

OPENGL = xr.KHR_OPENGL_ENABLE_EXTENSION_NAME
EGL_ENABLE = xr.MNDX_EGL_ENABLE_EXTENSION_NAME

FRAMEBUFFER_SRGB = 0x8DB9

NO_CONTEXT = "no OpenGL context is current; make the headset after the context"


@dataclass(frozen=True)
class Binding:
    """The current context as OpenXR takes it.

    Parameters
    ----------
    platform
        ``egl``, ``glx`` or ``wgl``.
    extensions
        What the runtime must offer for it.
    structure
        OpenXR's graphics binding, which goes behind `xr.SessionCreateInfo`.
    """

    platform: str
    extensions: tuple[str, ...]
    structure: Any

    @property
    def pointer(self) -> ctypes.c_void_p:
        """Return the address of the structure, which must live until the session is made."""
        return ctypes.cast(ctypes.pointer(self.structure), ctypes.c_void_p)


def make_current(ctx: moderngl.Context) -> None:
    """Take the context back: a runtime may leave its own, or none, behind.

    `XR_KHR_opengl_enable` lets it use the context in the calls that make and end sessions, frames
    and images. Our images are encoded already: drawing and copying must not do it once more.
    """
    ctx.__enter__()  # type: ignore[no-untyped-call]  # leaving again would restore the runtime's
    ctx.disable_direct(FRAMEBUFFER_SRGB)


def current_binding() -> Binding:
    """Describe the OpenGL context that is current in this thread.

    Raises
    ------
    InputError
        If there is none, or the libraries of the window system are not there.
    """
    if sys.platform == "win32":
        return wgl_binding(ctypes.WinDLL("opengl32"))
    return _egl_binding() or _glx_binding()


def wgl_binding(opengl32: Any) -> Binding:
    """Describe the current context of Windows.

    `XR_KHR_opengl_enable` wants the device context and the rendering context that are current
    where the session is made.

    Parameters
    ----------
    opengl32
        The system's library. Handles are pointers: 32-bit integers, which ctypes takes results
        for unless told, would cut them.

    Raises
    ------
    InputError
        If no context is current.
    """
    handles = {}
    for name in ("wglGetCurrentDC", "wglGetCurrentContext"):
        function = getattr(opengl32, name)
        function.argtypes, function.restype = [], ctypes.c_void_p
        handles[name] = function()
    if not all(handles.values()):
        raise InputError(NO_CONTEXT)
    structure = xr.GraphicsBindingOpenGLWin32KHR()
    structure.h_dc = handles["wglGetCurrentDC"]
    structure.h_glrc = handles["wglGetCurrentContext"]
    return Binding("wgl", (OPENGL,), structure)


def _egl_binding() -> Binding | None:
    try:
        from OpenGL import EGL  # noqa: PLC0415 - loads the system's libEGL
    except (ImportError, AttributeError):  # PyOpenGL has no EGL for this platform
        return None
    display, context = EGL.eglGetCurrentDisplay(), EGL.eglGetCurrentContext()
    if not context:
        return None
    number = EGL.EGLint()
    EGL.eglQueryContext(display, context, EGL.EGL_CONFIG_ID, ctypes.byref(number))
    wanted = [EGL.EGL_CONFIG_ID, number.value, EGL.EGL_NONE]
    configs, found = (EGL.EGLConfig * 1)(), EGL.EGLint()
    EGL.eglChooseConfig(display, wanted, configs, 1, ctypes.byref(found))
    structure = xr.GraphicsBindingEGLMNDX(
        get_proc_address=ctypes.cast(EGL.eglGetProcAddress.load(), xr.PFN_xrEglGetProcAddressMNDX),
        display=display,
        config=configs[0],
        context=context,
    )
    return Binding("egl", (OPENGL, EGL_ENABLE), structure)


def _glx_binding() -> Binding:
    try:
        from OpenGL import GLX  # noqa: PLC0415 - loads the system's libGLX
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"neither EGL nor GLX can be loaded ({error}); install the graphics libraries: on "
            "Debian or Ubuntu 'apt-get install libegl1 libgl1'"
        ) from error
    if not GLX.glXGetCurrentContext():
        raise InputError(NO_CONTEXT)
    structure = xr.GraphicsBindingOpenGLXlibKHR(
        x_display=GLX.glXGetCurrentDisplay(),
        glx_drawable=GLX.glXGetCurrentDrawable(),
        glx_context=GLX.glXGetCurrentContext(),
    )
    return Binding("glx", (OPENGL,), structure)
