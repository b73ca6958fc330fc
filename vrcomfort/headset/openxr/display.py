"""The display: refresh rates, its clock, and the area that the lenses hide."""

from __future__ import annotations

import ctypes
import sys
import time
from collections.abc import Container
from typing import Any

import numpy as np
import xr

from vrcomfort.errors import InputError
from vrcomfort.geometry import HiddenArea, HiddenAreas
from vrcomfort.headset.openxr.instance import (
    CONVERTS_TIMESPEC,
    CONVERTS_WIN32,
    STEREO,
    Runtime,
    call_extension,
)
from vrcomfort.headset.openxr.native import watched

REFRESH_RATE = xr.FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME
VISIBILITY_MASK = xr.KHR_VISIBILITY_MASK_EXTENSION_NAME
SECOND_NS = 1_000_000_000
HIDDEN = xr.VisibilityMaskTypeKHR.HIDDEN_TRIANGLE_MESH


def refresh_rates_hz(session: xr.Session) -> list[float]:
    """Return the rates that the runtime can switch to."""
    return [float(rate) for rate in watched(xr.enumerate_display_refresh_rates_fb, session)]


def current_refresh_hz(session: xr.Session) -> float:
    """Return the rate that the display runs at now; 0 where the runtime does not know."""
    return float(watched(xr.get_display_refresh_rate_fb, session).value)


def request_refresh_rate(session: xr.Session, wanted_hz: float) -> None:
    """Switch the display.

    Raises
    ------
    InputError
        If it has no such rate.
    """
    offered = refresh_rates_hz(session)
    nearest = min(offered, key=lambda rate: abs(rate - wanted_hz), default=0.0)
    if abs(nearest - wanted_hz) > 0.5:
        raise _not_offered(wanted_hz, offered)
    try:
        watched(xr.request_display_refresh_rate_fb, session, nearest)
    except xr.exception.DisplayRefreshRateUnsupportedFBError as error:
        raise _not_offered(wanted_hz, offered) from error


def _not_offered(wanted_hz: float, offered: list[float]) -> InputError:
    rates = ", ".join(f"{rate:g}" for rate in offered)
    there = f"it offers {rates} Hz" if rates else "it offers no rates to choose from"
    return InputError(
        f"the headset does not switch to {wanted_hz:g} Hz; {there}: change or leave out "
        "--refresh-hz"
    )


def hidden_areas(session: xr.Session, extensions: Container[str]) -> HiddenAreas:
    """Return each eye's hidden area; None if it has none, or the runtime does not tell."""
    if VISIBILITY_MASK not in extensions:
        return None, None
    return hidden_area(session, 0), hidden_area(session, 1)


def mask_facts(areas: HiddenAreas, extensions: Container[str]) -> list[dict[str, Any] | None] | str:
    """Return the visibility mask for the manifest, or the reason why there is none.

    `headset.visibility_mask` of a manifest is read back by :func:`geometry.hidden_areas_of`.
    """
    if VISIBILITY_MASK not in extensions:
        return f"none: the runtime lacks {VISIBILITY_MASK}"
    if areas == (None, None):
        return "none: the runtime hides nothing"
    return [None if area is None else area.facts for area in areas]


def hidden_area(session: xr.Session, eye: int) -> HiddenArea | None:
    """Return the hidden area of eye 0 (left) or 1 (right), or None if it has none."""
    mask = watched(xr.get_visibility_mask_khr, session, STEREO, eye, HIDDEN)
    if mask.vertex_count_output == 0 or mask.index_count_output == 0:
        return None
    vertices = (xr.Vector2f * mask.vertex_count_output)()
    indices = (ctypes.c_uint32 * mask.index_count_output)()
    _fill_mask(session, eye, vertices, indices)
    points = np.array([(each.x, each.y) for each in vertices], dtype=np.float32)
    return HiddenArea(points, np.array(indices, dtype=np.uint32).reshape(-1, 3))


def _fill_mask(
    session: xr.Session,
    eye: int,
    vertices: ctypes.Array[xr.Vector2f],
    indices: ctypes.Array[ctypes.c_uint32],
) -> None:
    mask = xr.VisibilityMaskKHR(
        vertex_capacity_input=len(vertices),
        vertices=vertices,
        index_capacity_input=len(indices),
        indices=indices,
    )
    eye_and_kind = STEREO.value, eye, HIDDEN.value
    instance, name = session.instance, "xrGetVisibilityMaskKHR"
    call_extension(instance, name, session, *eye_and_kind, ctypes.byref(mask))


def clock_extension(runtime: Runtime) -> str:
    """Return the extension by which a runtime tells its clock; blank where it does not."""
    taken = (name for name in (CONVERTS_TIMESPEC, CONVERTS_WIN32) if name in runtime.extensions)
    return next(taken, "")


def display_now_ns(runtime: Runtime) -> int | None:
    """Return the present moment as a display time; None where the runtime does not tell.

    The extension converts the system's monotonic clock, on Windows the performance counter.

    Raises
    ------
    xr.exception.ResultException
        If the runtime refuses, or is gone.
    """
    instance, told = runtime.instance, ctypes.c_int64()
    if clock_extension(runtime) == CONVERTS_TIMESPEC:
        seconds, rest_ns = divmod(time.clock_gettime_ns(time.CLOCK_MONOTONIC), SECOND_NS)
        moment = xr.timespec(tv_sec=seconds, tv_nsec=rest_ns)
        name = "xrConvertTimespecTimeToTimeKHR"
        call_extension(instance, name, instance, ctypes.byref(moment), ctypes.byref(told))
        return told.value
    if sys.platform == "win32" and clock_extension(runtime) == CONVERTS_WIN32:
        counter = ctypes.c_int64()
        ctypes.windll.kernel32.QueryPerformanceCounter(ctypes.byref(counter))
        name = "xrConvertWin32PerformanceCounterToTimeKHR"
        call_extension(instance, name, instance, ctypes.byref(counter), ctypes.byref(told))
        return told.value
    return None
