"""Capabilities of the active runtime, stage by stage: runtime, headset, session."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import moderngl
import xr

from vrcomfort.headset.openxr.faults import starting
from vrcomfort.headset.openxr.graphics_binding import OPENGL
from vrcomfort.headset.openxr.headset import OpenXrHeadset
from vrcomfort.headset.openxr.instance import (
    HELPFUL_EXTENSIONS,
    connect,
    offered_extensions,
    runtime_name,
)
from vrcomfort.headset.openxr.native import watched
from vrcomfort.headset.openxr.settings import OpenXrSettings
from vrcomfort.headset.timing import Timing, TimingTest, time_frames

WAKE_S = 10.0
"""Time that a headset may take to begin."""


@dataclass(frozen=True)
class RuntimeFacts:
    """A runtime: its name and version, the extensions that it offers, and those we would use."""

    name: str
    extensions: tuple[str, ...]
    wanted: tuple[str, ...] = HELPFUL_EXTENSIONS


@dataclass(frozen=True)
class SystemFacts:
    """A headset: its name, the size of image that it wants per eye, and whether it tracks eyes.

    `each_eye`: whether it tells where each of them looks.
    """

    name: str
    recommended_size_px: tuple[int, int]
    gaze: bool
    each_eye: bool


@dataclass(frozen=True)
class SessionFacts:
    """A session that came about with this machine's OpenGL.

    Parameters
    ----------
    details
        As in the manifest.
    hidden_percent
        Of the area of each eye's image, what the lens never shows (left, right).
    """

    details: dict[str, Any]
    refresh_hz: float
    refresh_rates_hz: tuple[float, ...]
    hidden_percent: tuple[float, float]
    timing: Timing


def find_runtime() -> RuntimeFacts:
    """Find the active runtime.

    Raises
    ------
    InputError
        If there is none, or it does not answer.
    """
    with starting():
        extensions = offered_extensions()
        instance = watched(xr.create_instance, xr.InstanceCreateInfo())
        try:
            return RuntimeFacts(runtime_name(instance), tuple(sorted(extensions)))
        finally:
            watched(xr.destroy_instance, instance)


def find_headset() -> SystemFacts:
    """Find the headset that the active runtime drives.

    Raises
    ------
    InputError
        If it drives none, or takes no OpenGL.
    """
    with starting():
        runtime = connect(OpenXrSettings(), (OPENGL,), lambda _: None)
        try:
            each_eye = runtime.has_each_eye
            return SystemFacts(
                runtime.headset_name,
                runtime.recommended_size_px,
                gaze=runtime.has_gaze or each_eye,
                each_eye=each_eye,
            )
        finally:
            runtime.release()


def try_session(ctx: moderngl.Context) -> SessionFacts:
    """Begin a session, and end it.

    Raises
    ------
    InputError
        If the runtime refuses it.
    """
    with OpenXrHeadset(ctx) as headset:
        left, right = (0.0 if each is None else each.percent for each in headset.hidden_areas)
        return SessionFacts(
            headset.details,
            headset.refresh_hz,
            tuple(headset.refresh_rates_hz),
            (left, right),
            headset.timing,
        )


def try_timing(ctx: moderngl.Context, seconds: float) -> TimingTest | None:
    """Time frames for some seconds; None where the headset sleeps.

    Raises
    ------
    InputError
        If the runtime refuses a session.
    """
    with OpenXrHeadset(ctx) as headset:
        if not headset.wake(WAKE_S):
            return None
        left, right = (ctx.texture(headset.image_size_px, 4) for _ in range(2))
        return time_frames(headset, (left, right), seconds)
