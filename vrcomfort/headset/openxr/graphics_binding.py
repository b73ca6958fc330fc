"""Tells the runtime which OpenGL context draws: whichever is current, EGL, GLX or WGL."""

from __future__ import annotations

import ctypes
import sys
from dataclasses import dataclass
from typing import Any

import moderngl
import xr
from xr.utils.gl import GLXGraphicsBinding, WGLGraphicsBinding
from xr.utils.gl.egl_util import EGLGraphicsBinding

from vrcomfort.errors import InputError

OPENGL = xr.KHR_OPENGL_ENABLE_EXTENSION_NAME
EGL_ENABLE = xr.MNDX_EGL_ENABLE_EXTENSION_NAME


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
        pyopenxr's binding; its `pointer` goes into the session.
    """

    platform: str
    extensions: tuple[str, ...]
    structure: Any


class _Current:
    """The current context, in the shape that pyopenxr's bindings ask for."""

    def __init__(self, display: Any = None, context: Any = None, config: Any = None) -> None:
        self.display, self.context, self.config = display, context, config

    def make_current(self) -> None:
        """Do nothing: it is current already."""


def make_current(ctx: moderngl.Context) -> None:
    """Take the context back: a runtime may leave its own, or none, behind."""
    ctx.__enter__()  # type: ignore[no-untyped-call]  # leaving again would restore the runtime's


def current_binding() -> Binding:
    """Describe the OpenGL context that is current in this thread.

    Raises
    ------
    InputError
        If there is none.
    """
    if sys.platform == "win32":
        return Binding("wgl", (OPENGL,), WGLGraphicsBinding(_Current()))
    return _egl_binding() or _glx_binding()


def _egl_binding() -> Binding | None:
    from OpenGL import EGL  # noqa: PLC0415 - loads the system's libEGL

    display, context = EGL.eglGetCurrentDisplay(), EGL.eglGetCurrentContext()
    if not context:
        return None
    number = EGL.EGLint()
    EGL.eglQueryContext(display, context, EGL.EGL_CONFIG_ID, ctypes.byref(number))
    wanted = [EGL.EGL_CONFIG_ID, number.value, EGL.EGL_NONE]
    configs, found = (EGL.EGLConfig * 1)(), EGL.EGLint()
    EGL.eglChooseConfig(display, wanted, configs, 1, ctypes.byref(found))
    current = _Current(display, context, configs[0])
    return Binding("egl", (OPENGL, EGL_ENABLE), EGLGraphicsBinding(current))


def _glx_binding() -> Binding:
    from OpenGL import GLX  # noqa: PLC0415 - loads the system's libGLX

    if not GLX.glXGetCurrentContext():
        raise InputError("no OpenGL context is current; make the headset after the context")
    return Binding("glx", (OPENGL,), GLXGraphicsBinding(_Current()))
