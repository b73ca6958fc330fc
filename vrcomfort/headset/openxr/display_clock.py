"""The clock of display times, read now: what puts them on the system's clock.

`XR_KHR_convert_timespec_time` converts the system's monotonic clock, and
`XR_KHR_win32_convert_performance_counter_time` Windows' performance counter.
"""

from __future__ import annotations

import ctypes
import sys
import time

import xr

from vrcomfort.headset.openxr.instance import CONVERTS_TIMESPEC, CONVERTS_WIN32, Runtime
from vrcomfort.headset.openxr.instance import call_extension as call

SECOND_NS = 1_000_000_000


def extension(runtime: Runtime) -> str:
    """Return the extension by which a runtime tells its clock; blank where it does not."""
    taken = (name for name in (CONVERTS_TIMESPEC, CONVERTS_WIN32) if name in runtime.extensions)
    return next(taken, "")


def now_ns(runtime: Runtime) -> int | None:
    """Return the present moment as a display time; None where the runtime does not tell.

    Raises
    ------
    xr.exception.ResultException
        If the runtime refuses, or is gone.
    """
    instance, told = runtime.instance, ctypes.c_int64()
    if extension(runtime) == CONVERTS_TIMESPEC:
        seconds, rest_ns = divmod(time.clock_gettime_ns(time.CLOCK_MONOTONIC), SECOND_NS)
        moment = xr.timespec(tv_sec=seconds, tv_nsec=rest_ns)
        name = "xrConvertTimespecTimeToTimeKHR"
        call(instance, name, instance, ctypes.byref(moment), ctypes.byref(told))
        return told.value
    if sys.platform == "win32" and extension(runtime) == CONVERTS_WIN32:
        counter = ctypes.c_int64()
        ctypes.windll.kernel32.QueryPerformanceCounter(ctypes.byref(counter))
        name = "xrConvertWin32PerformanceCounterToTimeKHR"
        call(instance, name, instance, ctypes.byref(counter), ctypes.byref(told))
        return told.value
    return None
