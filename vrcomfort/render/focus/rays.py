"""Rays from the head centre: focus by nine rays, and the hit of the gaze.

::

    head ──────────────● ray 1       Each ray is a frustum one texel wide around it, so the
         ╲╲────────● ray 2..9        centre of texel k of a 9 × 1 depth image lies on ray k.

Rules: `nine_ray` ahead of the head (Carnegie & Rhee 2015, p. 36: a ray ahead and eight around it,
less outliers), `gaze` around the line of sight (Mantiuk et al. 2011, section 4: their median).
`GazeHits` draws one such ray along the gaze, through the holes of alpha masks and through blended
surfaces, and reads its distance and node back some frames late: no frame waits.
"""

from __future__ import annotations

import ctypes
from collections import deque
from functools import partial
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.frame import GazeHit
from vrcomfort.geometry import Array, Gaze, Pose
from vrcomfort.gpu import gl, passes
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.optics.focus import RAYS, WIDEST_GAZE, gaze_tangents, ray_tangents
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.focus.search import FocusInputs, FocusRule, FocusSearch, HeadView, ProbeResult
from vrcomfort.render.gpu_scene import DEPTH_SHADER, SEMANTIC_SHADER, GpuScene

RAY_WIDTH = 1e-4
"""Tangent across a ray's frustum, 0.3 arcmin. Thin enough that alpha masks are read at full size,
as a ray meets them; a pixel's width would read a mip level and see other holes."""


class NarrowRays:
    """A 9 × 1 reverse-Z depth image, one texel for each ray."""

    def __init__(self, inputs: FocusInputs) -> None:
        self._ctx, self._gpu = inputs.ctx, inputs.gpu
        self._depth = gl.depth_texture(inputs.ctx, (RAYS, 1))
        self.image = inputs.ctx.framebuffer([], self._depth)
        self._cleared = passes.clear([self._depth])
        self._drawn = passes.Pass(DEPTH_SHADER, inputs.gpu.images, self._cleared.writes)
        viewport = gl.function(inputs.ctx, "glViewport", *[ctypes.c_int] * 4)
        self._aims = [partial(viewport, ray, 0, 1, 1) for ray in range(RAYS)]

    def draw(self, clips_from_head: Array, world_from_head: Pose) -> None:
        """Draw nine rays given by (9, 4, 4) projections, and bind their depths to unit 2."""
        ctx = self._ctx
        self.image.use()
        self._cleared.run(self.image.clear, depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        clips = clips_from_head @ rotation_only(world_from_head.rotation.T)
        self._drawn.run(self._gpu.draw_depth, clips, world_from_head.position, self._aims)
        ctx.enable_only(moderngl.NOTHING)
        self._depth.use(2)


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


def ray_lengths(tangents: Array) -> Array:
    """Return (9,) metres along each ray per metre along the head's forward axis."""
    lengths: Array = np.sqrt(1 + (tangents**2).sum(axis=1))
    return lengths


def _decide_nine_ray(_: Focus) -> tuple[bool, str]:
    """Say that it draws nine rays."""
    reason = f"depth of field follows what is in front of the head: {RAYS} rays, a texel each"
    return True, reason


class Aim(NamedTuple):
    """Nine rays.

    Parameters
    ----------
    clips_from_head
        (9, 4, 4) of :func:`ray_projections`.
    lengths
        (9,) metres of each ray's distance per metre along the head's forward axis.
    """

    clips_from_head: Array
    lengths: Array


class NineRays:
    """Rays ahead of the head, and the mean of those that are no outliers."""

    fragment = "focus/focus.frag"

    def __init__(self, inputs: FocusInputs) -> None:
        settings = inputs.settings
        self._narrow = NarrowRays(inputs)
        self._near_m, self._along_ray = inputs.near_m, inputs.along_ray
        self._ahead = self.aimed(ray_tangents(settings.ring_deg))
        dioptres = settings.mean == "dioptres"
        self.defines: dict[str, int] = {
            "RAYS": RAYS,
            **({"MEAN_DIOPTRES": 1} if dioptres else {}),
            **({"ALONG_RAY": 1} if inputs.along_ray else {}),
        }
        floor = settings.outlier_floor_dioptre if dioptres else settings.outlier_floor_fraction
        self.constants: dict[str, Any] = {
            "depth": 2,
            "near_m": inputs.near_m,
            "infinity_m": settings.infinity_m,
            "outlier_mad": settings.outlier_mad,
            "outlier_floor": floor,
        }

    def look(self, view: HeadView) -> ProbeResult:
        """Draw the rays ahead."""
        return self.look_along(self._ahead, view.world_from_head)

    def aimed(self, tangents: Array) -> Aim:
        """Return nine rays with these (9, 2) tangents (right, up)."""
        lengths = ray_lengths(tangents) if self._along_ray else np.ones(RAYS)
        return Aim(ray_projections(tangents, self._near_m), lengths)

    def look_along(self, aim: Aim, world_from_head: Pose) -> ProbeResult:
        """Draw nine rays."""
        self._narrow.draw(aim.clips_from_head, world_from_head)
        uniforms = {"ray_lengths": aim.lengths.tolist()} if self._along_ray else {}
        return ProbeResult(uniforms, self._narrow.image, aim.lengths)


def _build_nine_ray(inputs: FocusInputs) -> FocusSearch:
    """Build the search by rays ahead."""
    return FocusSearch(inputs, NineRays(inputs))


NINE_RAY = FocusRule("nine_ray", _decide_nine_ray, _build_nine_ray)


NO_EYE_TRACKER = (
    'focus follows the gaze (method = "gaze"), and this headset has no eye tracker; use one that '
    'has, or write without_gaze = "nine_ray" under [conditions.focus]'
)


def _decide_gaze(settings: Focus) -> tuple[bool, str]:
    """Say that it draws rays around the line of sight."""
    nine = settings.without_gaze == "nine_ray"
    instead = "nine rays ahead without one" if nine else "the session stops without one"
    reason = f"depth of field follows the gaze: {RAYS} rays, a texel each; needs an eye tracker"
    reason += f"; {instead}"
    return True, reason


class GazeRays:
    """Rays around the line of sight, and their median.

    A blink (gaze not valid) keeps the target of before. Where there is none, at the first frame and
    after a cut, the ray straight ahead stands in until the tracker has the eyes.
    """

    MEAN, MEDIAN, KEEP = range(3)

    def __init__(self, inputs: FocusInputs) -> None:
        self._ahead = NineRays(inputs)
        self._settings = inputs.settings
        self._has_target = False
        self.fragment = self._ahead.fragment
        self.defines = {**self._ahead.defines, "GAZE": 1}
        self.constants = self._ahead.constants

    def look(self, view: HeadView) -> ProbeResult:
        """Draw the rays around the line of sight, if there is one.

        Raises
        ------
        InputError
            Without an eye tracker, unless the settings name a rule to use instead.
        """
        if view.gaze is None:
            if self._settings.without_gaze == "stop":
                raise InputError(NO_EYE_TRACKER)
            return _estimated(self.MEAN, self._ahead.look(view))
        tangents = self._around(view.gaze.pose) if view.gaze.valid else None
        cut = view.discontinuity
        self._has_target = tangents is not None or (self._has_target and not cut)
        if tangents is None and self._has_target:
            return ProbeResult({"estimate": self.KEEP})
        if tangents is None:
            tangents = self._around(Pose())
        assert tangents is not None  # noqa: S101 - straight ahead is always within reach
        look = self._ahead.look_along(self._ahead.aimed(tangents), view.world_from_head)
        return _estimated(self.MEDIAN, look)

    def _around(self, head_from_gaze: Pose) -> Array | None:
        return gaze_tangents(head_from_gaze, self._settings.gaze_radius_deg)


def _estimated(estimate: int, look: ProbeResult) -> ProbeResult:
    return look._replace(uniforms={**look.uniforms, "estimate": estimate})


def _build_gaze(inputs: FocusInputs) -> FocusSearch:
    """Build the search by gaze."""
    return FocusSearch(inputs, GazeRays(inputs))


GAZE = FocusRule("gaze", _decide_gaze, _build_gaze)


_FLOAT_BYTES = 4
"""Bytes."""


class GazeHits:
    """Looks along the gaze of each frame.

    Parameters
    ----------
    gpu
        The scene; `GpuScene.update` must have been called for the frame that is looked at.
    near_m
        Nearer than this nothing is drawn.
    along_ray
        Tell distances along the line of sight, not along the head's forward axis.
    """

    def __init__(
        self, ctx: moderngl.Context, gpu: GpuScene, *, near_m: float, along_ray: bool
    ) -> None:
        self._ctx, self._gpu = ctx, gpu
        self._near_m, self._along_ray = near_m, along_ray
        self._depth = gl.depth_texture(ctx, (1, 1))
        self._number = gl.color_texture(ctx, (1, 1), components=1, dtype="f4")
        self._texel = ctx.framebuffer([self._number], self._depth)
        self._cleared = passes.clear([self._number, self._depth])
        self._drawn = passes.Pass(SEMANTIC_SHADER, gpu.images, self._cleared.writes)
        self._free = [gl.dynamic_buffer(ctx, 2 * _FLOAT_BYTES) for _ in range(LATENCY + 1)]
        self._pending: deque[tuple[int, float, moderngl.Buffer]] = deque()
        self.sought = False
        """Whether the last frame's gaze was known, and is looked along."""

    def look(
        self, frame_index: int, head_from_gaze: Gaze, world_from_head: Pose
    ) -> tuple[GazeHit, ...]:
        """Look along the gaze of a frame, if it is known; return the hit that is due."""
        ahead = head_from_gaze.pose.forward
        self.sought = head_from_gaze.valid and ahead[2] <= -WIDEST_GAZE
        if not self.sought:
            return ()
        tangents = (ahead[:2] / -ahead[2])[None]
        self._draw(tangents, world_from_head)
        buffer = self._free.pop()
        self._texel.read_into(buffer, components=1, attachment=-1, dtype="f4")
        self._texel.read_into(buffer, components=1, dtype="f4", write_offset=_FLOAT_BYTES)
        length = float(ray_lengths(tangents)[0]) if self._along_ray else 1.0
        self._pending.append((frame_index, length, buffer))
        return (self._read(),) if len(self._pending) > LATENCY else ()

    def drain(self) -> tuple[GazeHit, ...]:
        """Return all hits that are still on their way; waits for the GPU."""
        return tuple(self._read() for _ in range(len(self._pending)))

    def _draw(self, tangents: Array, head: Pose) -> None:
        ctx = self._ctx
        clip_from_head = ray_projections(tangents, self._near_m)[0]
        self._texel.use()
        self._cleared.run(self._texel.clear, depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        clip_from_relative = clip_from_head @ rotation_only(head.rotation.T)
        draw = self._gpu.draw_semantic
        self._drawn.run(draw, clip_from_relative, head.position, numbered=True)
        ctx.enable_only(moderngl.NOTHING)

    def _read(self) -> GazeHit:
        frame_index, length, buffer = self._pending.popleft()
        depth, number = np.frombuffer(buffer.read(), dtype=np.float32).tolist()
        self._free.append(buffer)
        if depth <= 0.0 or number < 1.0:
            return GazeHit(frame_index, None, "")
        node = self._gpu.scene.nodes[round(number) - 1]
        return GazeHit(frame_index, self._near_m * length / depth, node.name)
