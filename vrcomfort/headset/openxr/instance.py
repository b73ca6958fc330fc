"""The connection to the runtime: extensions, headset, and messages of API layers."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import xr

from vrcomfort.errors import InputError
from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.openxr.native import check, raw_field, watched
from vrcomfort.headset.openxr.profiles import EXTENSIONS as CONTROLLER_EXTENSIONS
from vrcomfort.headset.openxr.settings import OpenXrSettings

DEBUG_UTILS = xr.EXT_DEBUG_UTILS_EXTENSION_NAME
Notify = Callable[[HeadsetEvent], None]
Severity = xr.DebugUtilsMessageSeverityFlagsEXT
Kind = xr.DebugUtilsMessageTypeFlagsEXT
_TEXTS = tuple(
    raw_field(xr.DebugUtilsMessengerCallbackDataEXT, name) for name in ("function_name", "message")
)


class Messenger:
    """Listens to warnings and errors; ``openxr_warning`` and ``openxr_error`` are its events.

    Validation layers need it: best practices says nothing without. OpenXR's part of it goes with
    the instance; to destroy it before is right too, but core validation does not know its handle.

    Parameters
    ----------
    instance
        OpenXR's handle, with `DEBUG_UTILS` switched on.
    notify
        Called with each message.
    """

    def __init__(self, instance: xr.Instance, notify: Notify) -> None:
        self._notify = notify
        self._info = xr.DebugUtilsMessengerCreateInfoEXT(  # kept: it owns the callback
            message_severities=Severity.WARNING_BIT | Severity.ERROR_BIT,
            message_types=Kind.GENERAL_BIT | Kind.VALIDATION_BIT | Kind.CONFORMANCE_BIT,
            user_callback=self._hear,
        )
        xr.create_debug_utils_messenger_ext(instance, self._info)

    def _hear(self, severity: int, kind: int, data: Any, _: object) -> bool:
        del kind
        name = "openxr_error" if severity & Severity.ERROR_BIT else "openxr_warning"
        function, message = ((read(data) or b"").decode() for read in _TEXTS)
        self._notify(HeadsetEvent(name, f"{function}: {message}"))
        return False


CONVERTS_TIMESPEC = "XR_KHR_convert_timespec_time"
CONVERTS_WIN32 = "XR_KHR_win32_convert_performance_counter_time"

HELPFUL_EXTENSIONS = (
    CONVERTS_WIN32 if sys.platform == "win32" else CONVERTS_TIMESPEC,
    xr.EXT_LOCAL_FLOOR_EXTENSION_NAME,
    xr.EXT_USER_PRESENCE_EXTENSION_NAME,
    xr.EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME,
    xr.FB_EYE_TRACKING_SOCIAL_EXTENSION_NAME,
    xr.EXT_HAND_TRACKING_EXTENSION_NAME,
    xr.FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME,
    xr.KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
    xr.KHR_VISIBILITY_MASK_EXTENSION_NAME,
)
WANTED_EXTENSIONS = (*HELPFUL_EXTENSIONS, *CONTROLLER_EXTENSIONS)
"""Taken where the runtime offers them; everything works without."""

LAYERS_VARIABLE = "XR_ENABLE_API_LAYERS"
"""OpenXR's own way to switch API layers on from outside."""

STEREO = xr.ViewConfigurationType.PRIMARY_STEREO
EYES = 2


@dataclass(frozen=True)
class Runtime:
    """An OpenXR instance and the head-mounted display it drives.

    Parameters
    ----------
    instance, system
        OpenXR's handle and number.
    extensions
        Those that are switched on.
    messenger
        Brings what API layers say.
    """

    instance: xr.Instance
    system: int
    extensions: frozenset[str]
    messenger: Messenger | None = None

    @property
    def name(self) -> str:
        """Return the runtime's name and version."""
        return runtime_name(self.instance)

    @cached_property
    def headset_name(self) -> str:
        """Return the runtime's name for the headset."""
        return str(self._system_properties().system_name.decode())

    @cached_property
    def has_gaze(self) -> bool:
        """Return whether the headset tells where both eyes look together."""
        if xr.EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME not in self.extensions:
            return False
        gaze = xr.SystemEyeGazeInteractionPropertiesEXT()
        self._system_properties(gaze)
        return bool(gaze.supports_eye_gaze_interaction)

    @cached_property
    def has_each_eye(self) -> bool:
        """Return whether the headset tells where each eye looks."""
        if xr.FB_EYE_TRACKING_SOCIAL_EXTENSION_NAME not in self.extensions:
            return False
        eyes = xr.SystemEyeTrackingPropertiesFB()
        self._system_properties(eyes)
        return bool(eyes.supports_eye_tracking)

    @cached_property
    def has_hand_joints(self) -> bool:
        """Return whether the headset tells where the joints of hands are."""
        if xr.EXT_HAND_TRACKING_EXTENSION_NAME not in self.extensions:
            return False
        hands = xr.SystemHandTrackingPropertiesEXT()
        self._system_properties(hands)
        return bool(hands.supports_hand_tracking)

    @cached_property
    def _view(self) -> xr.ViewConfigurationView:
        views = watched(xr.enumerate_view_configuration_views, self.instance, self.system, STEREO)
        if len(views) != EYES:
            raise InputError(f"the headset shows {len(views)} views; vrcomfort needs two")
        return views[0]

    @property
    def recommended_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image as the runtime would have it.

        Raises
        ------
        InputError
            If the headset has not two views.
        """
        view = self._view
        return view.recommended_image_rect_width, view.recommended_image_rect_height

    def image_size_px(self, wanted_px: tuple[int, int] | None) -> tuple[int, int]:
        """Return the size of one eye's image: the one that is asked for, or the recommended one.

        Raises
        ------
        InputError
            If the runtime takes no images as large as that.
        """
        size_px = wanted_px or self.recommended_size_px
        view = self._view
        largest_px = view.max_image_rect_width, view.max_image_rect_height
        if any(asked > most > 0 for asked, most in zip(size_px, largest_px, strict=True)):
            asked, most, usual = (
                "x".join(map(str, each)) for each in (size_px, largest_px, self.recommended_size_px)
            )
            raise InputError(
                f"the headset takes no images of {asked} pixels an eye; give a --size up to "
                f"{most}, or leave it out for the headset's own, {usual}"
            )
        return size_px

    def _system_properties(self, chained: ctypes.Structure | None = None) -> xr.SystemProperties:
        properties = xr.SystemProperties(next=chained)
        get = xr.raw_functions.xrGetSystemProperties
        check(get(self.instance, self.system, ctypes.byref(properties)))
        return properties

    def release(self) -> None:
        """Disconnect from the runtime."""
        watched(xr.destroy_instance, self.instance)


def call_extension(instance: xr.Instance, name: str, handle: Any, *arguments: Any) -> None:
    """Call an extension's function that pyopenxr has no usable wrapper for."""
    address = watched(xr.get_instance_proc_addr, instance, name)
    call = ctypes.cast(address, getattr(xr, f"PFN_{name}"))
    check(call(handle, *arguments))


def runtime_name(instance: xr.Instance) -> str:
    """Return the name and version of an instance's runtime."""
    properties = watched(xr.get_instance_properties, instance)
    return f"{properties.runtime_name.decode()} {properties.runtime_version}"


def offered_extensions() -> frozenset[str]:
    """Return the names of the extensions that the active runtime offers."""
    properties = watched(xr.enumerate_instance_extension_properties)
    return frozenset(each.extension_name.decode() for each in properties)


def connect(settings: OpenXrSettings, needed: tuple[str, ...], notify: Notify) -> Runtime:
    """Connect to the active runtime and find its headset.

    Raises
    ------
    InputError
        If the runtime lacks an extension that is needed.
    """
    offered = offered_extensions()
    missing = [name for name in needed if name not in offered]
    if missing:
        raise InputError(
            f"the OpenXR runtime does not offer {', '.join(missing)}, which OpenGL applications "
            "need here; update it, or run in a window with a GLX context"
        )
    layered = settings.api_layers or os.environ.get(LAYERS_VARIABLE)
    wanted = (*WANTED_EXTENSIONS, DEBUG_UTILS) if layered else WANTED_EXTENSIONS
    taken = [*needed, *(name for name in wanted if name in offered)]
    instance = watched(
        xr.create_instance,
        xr.InstanceCreateInfo(
            application_info=xr.ApplicationInfo(
                settings.application, 1, "vrcomfort", 1, xr.Version(1, 0, 0)
            ),
            enabled_api_layer_names=list(settings.api_layers),
            enabled_extension_names=taken,
        ),
    )
    messenger = Messenger(instance, notify) if DEBUG_UTILS in taken else None
    system = _find_headset(instance)
    return Runtime(instance, system, frozenset(taken), messenger)


def _find_headset(instance: xr.Instance) -> int:
    try:
        wanted = xr.SystemGetInfo(xr.FormFactor.HEAD_MOUNTED_DISPLAY)
        system: int = watched(xr.get_system, instance, wanted)
        requirements = xr.GraphicsRequirementsOpenGLKHR()  # the runtime insists on being asked
        name = "xrGetOpenGLGraphicsRequirementsKHR"
        call_extension(instance, name, instance, system, ctypes.byref(requirements))
    except xr.exception.ResultException:
        watched(xr.destroy_instance, instance)
        raise
    return system
