"""What focus looks at: rays ahead, rays around the line of sight, or a zone in the middle.

A probe draws a small depth image from the head centre and says how the shader reads a target out of
it. It never reads an eye's depth buffer: both eyes have one focus.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import moderngl
import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array, Gaze, Pose, View
from vrcomfort.gpu import gl, shaders
from vrcomfort.optics.focus import RAYS, gaze_tangents, ray_tangents
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.gpu_scene import GpuScene

RAY_WIDTH = 1e-4
"""Tangent across a ray's frustum, 0.3 arcmin. Thin enough that alpha masks are read at full size,
as a ray meets them; a pixel's width would read a mip level and see other holes."""

NO_EYE_TRACKER = (
    'focus follows the gaze (method = "gaze"), and this headset has no eye tracker; use one that '
    'has, or write without_gaze = "nine_ray" under [conditions.focus]'
)


class Sight(NamedTuple):
    """Where the head of a frame is and what its eyes see.

    Parameters
    ----------
    world_from_head
        The head centre.
    screen_tangents
        Half width and half height of the image as tangents, the mean of both eyes.
    gaze
        head-from-gaze, None without an eye tracker.
    cut
        The frame before has nothing to do with this one.
    """

    world_from_head: Pose
    screen_tangents: tuple[float, float] = (1.0, 1.0)
    gaze: Gaze | None = None
    cut: bool = False


class Probe(Protocol):
    """What `FocusPass` needs of a way to find the target."""

    @property
    def fragment(self) -> str:
        """The shader that reads the target out of the image, and moves focus towards it."""

    @property
    def defines(self) -> shaders.Defines:
        """Its variant."""

    @property
    def constants(self) -> dict[str, Any]:
        """Its uniforms that never change, texture units included (0 and 1 are taken)."""

    @property
    def rays(self) -> moderngl.Framebuffer | None:
        """The 9 × 1 depth image to be recorded, if there is one."""

    @property
    def triangles(self) -> int:
        """Those of the last look."""

    def look(self, sight: Sight) -> dict[str, Any]:
        """Draw, bind the image to its texture unit, and return the uniforms of this frame."""


def screen_tangents(views: tuple[View, View]) -> tuple[float, float]:
    """Return half width and half height of the image as tangents: the mean of both eyes."""
    pairs = zip(*(view.fov.tangents for view in views), strict=True)
    left, right, up, down = ((one + other) / 2 for one, other in pairs)
    return (right - left) / 2, (up - down) / 2


class NineRays:
    """A ray ahead and eight around it (Carnegie & Rhee 2015, p. 36).

    ::

        head ──────────────● ray 1       Each ray is a frustum one texel wide around it, so the
             ╲╲────────● ray 2..9        centre of texel k of a 9 × 1 depth image lies on ray k.
    """

    fragment = "focus/focus.frag"

    def __init__(
        self, ctx: moderngl.Context, gpu: GpuScene, settings: Focus, *, near_m: float
    ) -> None:
        self._ctx = ctx
        self._gpu = gpu
        self._near_m = near_m
        self._ahead = ray_projections(ray_tangents(settings.ring_deg), near_m)
        self._depth = gl.depth_texture(ctx, (RAYS, 1))
        self.rays = ctx.framebuffer([], self._depth)
        self.triangles = 0
        dioptres = settings.mean == "dioptres"
        self.defines = {"RAYS": RAYS, **({"MEAN_DIOPTRES": 1} if dioptres else {})}
        floor = settings.outlier_floor_dioptre if dioptres else settings.outlier_floor_fraction
        self.constants = {
            "depth": 2,
            "near_m": near_m,
            "infinity_m": settings.infinity_m,
            "outlier_mad": settings.outlier_mad,
            "outlier_floor": floor,
        }

    def look(self, sight: Sight) -> dict[str, Any]:
        """Draw the rays ahead."""
        self.draw(self._ahead, sight.world_from_head)
        return {}

    def draw(self, clips_from_head: Array, world_from_head: Pose) -> None:
        """Draw nine rays given by (9, 4, 4) projections, and bind their depths."""
        ctx = self._ctx
        self.rays.use()
        self.rays.viewport = (0, 0, RAYS, 1)
        self.rays.clear(depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        head_from_relative = rotation_only(world_from_head.rotation.T)
        self.triangles = self._gpu.draw_depth_views(
            clips_from_head @ head_from_relative, world_from_head.position, self._aim
        )
        self.rays.viewport = (0, 0, RAYS, 1)
        ctx.enable_only(moderngl.NOTHING)
        self._depth.use(2)

    def _aim(self, ray: int) -> None:
        self.rays.viewport = (ray, 0, 1, 1)


class GazeRays:
    """Nine rays around the line of sight, whose median counts (Mantiuk et al. 2011, section 4).

    A blink (gaze not valid) keeps the target of before. Where there is none, at the first frame and
    after a cut, the ray straight ahead stands in until the tracker has the eyes.
    """

    fragment = "focus/focus.frag"
    MEAN, MEDIAN, KEEP = range(3)

    def __init__(
        self, ctx: moderngl.Context, gpu: GpuScene, settings: Focus, *, near_m: float
    ) -> None:
        self._rays = NineRays(ctx, gpu, settings, near_m=near_m)
        self._settings = settings
        self._near_m = near_m
        self._has_target = False
        self.rays = self._rays.rays
        self.defines = {**self._rays.defines, "GAZE": 1}
        self.constants = self._rays.constants

    @property
    def triangles(self) -> int:
        """Return those of the last look."""
        return self._rays.triangles

    def look(self, sight: Sight) -> dict[str, Any]:
        """Draw the rays around the line of sight, if there is one.

        Raises
        ------
        InputError
            Without an eye tracker, unless the settings say what else to do.
        """
        if sight.gaze is None:
            if self._settings.without_gaze == "stop":
                raise InputError(NO_EYE_TRACKER)
            self._rays.look(sight)
            return {"estimate": self.MEAN}
        tangents = (
            gaze_tangents(sight.gaze.pose, self._settings.gaze_radius_deg)
            if sight.gaze.valid
            else None
        )
        self._has_target = tangents is not None or (self._has_target and not sight.cut)
        if tangents is None and self._has_target:
            return {"estimate": self.KEEP}
        if tangents is None:
            tangents = gaze_tangents(Pose(), self._settings.gaze_radius_deg)
        assert tangents is not None  # noqa: S101 - straight ahead is always within reach
        self._rays.draw(ray_projections(tangents, self._near_m), sight.world_from_head)
        return {"estimate": self.MEDIAN}


def ray_projections(tangents: Array, near_m: float) -> Array:
    """Return (9, 4, 4) reverse-Z projections of the head's frame, one narrow frustum per ray.

    Depth stays ``near_m / distance`` with distance along the head's forward axis.

    Parameters
    ----------
    tangents
        (9, 2) of the rays (right, up).
    """
    clips = np.zeros((len(tangents), 4, 4))
    clips[:, 0, 0] = clips[:, 1, 1] = 2 / RAY_WIDTH
    clips[:, :2, 2] = tangents * (2 / RAY_WIDTH)
    clips[:, 2, 3] = near_m
    clips[:, 3, 2] = -1.0
    return clips
