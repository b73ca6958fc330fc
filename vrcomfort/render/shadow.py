r"""The sun's shadow map: one D32F image of the surroundings, seen along the sunlight.

::

      sun  \   \   \        The map follows the head in steps of whole texels, so its
            \ ___\___\       texels stay on the same points of the world and shadows
             |  head  |     do not crawl. Steps are large: static casters are drawn
             |___x____|     again only when the head leaves the middle of the map.
"""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.geometry import Array, Pose, normalize
from vrcomfort.gpu import gl, passes
from vrcomfort.render.gpu_scene import DEPTH_SHADER, GpuScene
from vrcomfort.render.lighting import ShadowUniforms, relative_to
from vrcomfort.render.materials import SHADOW_UNIT
from vrcomfort.render.scene_buffers import Movement

STEPS = 16
"""The map moves by this part of its width."""

DEPTH_RANGE = 2.0
"""Half of the depth range, in radii; casters nearer to the sun are clamped onto its end."""

_DEPTH_CLAMP = 0x864F


class ShadowMap:
    """Draws the shadow map of a scene with a sun, and gives it to its surfaces.

    Parameters
    ----------
    radius_m
        Half the width of the square that the map covers.
    size_px
        Its number of texels, each way; a multiple of `STEPS`.
    """

    def __init__(
        self, ctx: moderngl.Context, gpu: GpuScene, *, radius_m: float, size_px: int = 1024
    ) -> None:
        self._ctx = ctx
        self._gpu = gpu
        self._radius_m = radius_m
        self._size_px = size_px
        self._light_from_world = light_rotation(gpu.scene.environment.sun_direction)
        self._static = _Map(ctx, size_px, gpu.images)
        self._live = _Map(ctx, size_px, gpu.images) if gpu.moves else self._static
        gpu.add_texture(SHADOW_UNIT, self._live.depth)
        self._copy = gl.copier(ctx, self._static.depth, self._live.depth)
        self._center: list[float] | None = None
        self._drawn_for: tuple[float, Pose] | None = None
        texel_m = 2 * radius_m / size_px
        # The 3 × 3 tent of `sunlight` (scene.frag) reaches 1.5 texels. Lifted by as much along its
        # normal, a surface cannot shade itself at any slant θ to the sun: d / cos θ ≥ d · tan θ.
        self._bias = np.array(
            [1 / size_px, 1.5 * texel_m, 0.2 * texel_m / (2 * DEPTH_RANGE * radius_m), 0]
        )
        self.uniforms = ShadowUniforms(np.eye(4), self._bias)

    def render(self, time_s: float, head: Pose) -> None:
        """Bring the map up to date after `GpuScene.update`, once for both eyes."""
        if self._drawn_for == (time_s, head):
            return
        self._drawn_for = (time_s, head)
        center = self._snapped(head.position)
        if center.tolist() != self._center:
            self._center = center.tolist()
            self._place(center)
            self._draw(self._static, clear=True)
        if self._live is not self._static:
            # Moving casters are drawn over a copy of the static ones, which stay as they are.
            self._copy()
            self._draw(self._live, clear=False)

    @property
    def images(self) -> tuple[passes.PassImage, ...]:
        """Return the map, to declare passes that read it."""
        return self._live.cleared.writes

    def _snapped(self, position_m: Array) -> Array:
        """Return the map's centre in light space: `position_m` rounded to whole steps."""
        step_m = 2 * self._radius_m / STEPS
        light = self._light_from_world @ position_m
        snapped: Array = np.round(light / step_m) * step_m
        return snapped

    def _place(self, center: Array) -> None:
        clip_from_light = np.diag(
            [*[1 / self._radius_m] * 2, 0.5 / (DEPTH_RANGE * self._radius_m), 1]
        )
        clip_from_light[:2, 3] = -center[:2] / self._radius_m
        clip_from_light[2, 3] = 0.5 - center[2] * clip_from_light[2, 2]
        clip_from_world = clip_from_light.copy()
        clip_from_world[:, :3] = clip_from_light[:, :3] @ self._light_from_world
        texture_from_clip = np.diag([0.5, 0.5, 1.0, 1.0])
        texture_from_clip[:2, 3] = 0.5
        self.uniforms = ShadowUniforms(texture_from_clip @ clip_from_world, self._bias)
        self._origin_m = self._light_from_world.T @ center
        self._clip_from_relative = relative_to(clip_from_world, self._origin_m)

    def _draw(self, target: _Map, *, clear: bool) -> None:
        target.target.use()
        target.target.depth_mask = True
        if clear:
            target.cleared.run(target.target.clear, depth=0.0)
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._ctx.enable_direct(_DEPTH_CLAMP)  # casters beyond the range still cast shadows
        self._ctx.depth_func = gl.DEPTH_FUNC
        movement: Movement = "all"
        if self._live is not self._static:
            movement = "static" if clear else "moving"
        origin_m, draw = self._origin_m, self._gpu.draw_shadow
        target.drawn.run(draw, self._clip_from_relative, origin_m, movement=movement)
        self._ctx.disable_direct(_DEPTH_CLAMP)


class _Map:
    """A depth texture that compares (lit where at least as near to the sun), and its target."""

    def __init__(
        self, ctx: moderngl.Context, size_px: int, images: tuple[passes.PassImage, ...]
    ) -> None:
        self.depth = gl.depth_texture(ctx, (size_px, size_px))
        self.depth.compare_func = ">="
        self.depth.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.target = ctx.framebuffer([], self.depth)
        self.cleared = passes.clear([self.depth])
        self.drawn = passes.Pass(DEPTH_SHADER, images, self.cleared.writes)


def light_rotation(to_sun: Array) -> Array:
    """Return the (3, 3) rotation from the world to axes with z towards the sun."""
    z = normalize(to_sun)
    helper = np.array([0.0, 1.0, 0.0]) if abs(z[1]) < 0.99 else np.array([1.0, 0.0, 0.0])
    x = normalize(np.cross(helper, z))
    return np.stack([x, np.cross(z, x), z])
