"""What API layers and the runtime complain about, as events of the record."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import xr

from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.openxr.native import raw_field

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
