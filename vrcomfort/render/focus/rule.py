"""What a focus rule is to the rest of the renderer: it gives both eyes one focus distance.

A new rule is its settings (`vrcomfort.protocol.conditions.Focus`), a file beside this one, its
shader and the shader's twin, and a place in the list of `rules`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import moderngl

from vrcomfort.frame import FocusSample
from vrcomfort.geometry import Gaze, Pose
from vrcomfort.protocol.conditions import Focus, FocusRuleName
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.planned_pass import PlannedPass


class Sight(NamedTuple):
    """Where the head of a frame is, and what its eyes see.

    Parameters
    ----------
    world_from_head
        The head centre.
    discontinuity
        The frame before has nothing to do with this one.
    screen_tangents
        Half width and half height of the image as tangents, the mean of both eyes.
    gaze
        head-from-gaze, None without an eye tracker.
    scene_time_s
        Of the scene's animations.
    zone_centre
        Tangents (right, up) of where the middle of an autofocus zone is to be.
    """

    frame_index: int
    display_time_ns: int
    world_from_head: Pose
    discontinuity: bool = False
    screen_tangents: tuple[float, float] = (1.0, 1.0)
    gaze: Gaze | None = None
    scene_time_s: float = 0.0
    zone_centre: tuple[float, float] = (0.0, 0.0)


class FocusInputs(NamedTuple):
    """What a rule is built from.

    Parameters
    ----------
    gpu
        The scene; `GpuScene.update` must have been called for the frame that is rendered.
    near_m
        Nearer than this nothing is drawn, for the search as for the eyes.
    along_ray
        Whether distances are those along each ray, or those along the head's forward axis.
    """

    ctx: moderngl.Context
    gpu: GpuScene
    settings: Focus
    near_m: float
    along_ray: bool = False


class FocusPass(Protocol):
    """Finds the focus distance of each frame."""

    @property
    def texture(self) -> moderngl.Texture:
        """1×1 RGBA32F: x = focus, y = target of the refocus law, z = bits of the rays used."""

    @property
    def triangles(self) -> int:
        """Those that the last frame sent."""

    def render(self, sight: Sight) -> tuple[FocusSample, ...]:
        """Find the focus of a frame, and return the samples that have arrived meanwhile."""

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the samples that are still on their way; waits for the GPU."""


@dataclass(frozen=True)
class FocusRule:
    """How focus is found.

    Parameters
    ----------
    name
        What `method` of a protocol calls it.
    plan
        Say whether it draws anything, and why; no OpenGL.
    build
        Make it.
    """

    name: FocusRuleName
    plan: Callable[[Focus], PlannedPass]
    build: Callable[[FocusInputs], FocusPass]
