"""Nine rays from the head centre, drawn as nine frusta that are almost lines.

::

    head ──────────────● ray 1       Each ray is a frustum one texel wide around it, so the
         ╲╲────────● ray 2..9        centre of texel k of a 9 × 1 depth image lies on ray k.
"""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.geometry import Array, Pose
from vrcomfort.gpu import gl
from vrcomfort.optics.focus import RAYS
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.focus.rule import FocusInputs

RAY_WIDTH = 1e-4
"""Tangent across a ray's frustum, 0.3 arcmin. Thin enough that alpha masks are read at full size,
as a ray meets them; a pixel's width would read a mip level and see other holes."""


class NarrowRays:
    """A 9 × 1 reverse-Z depth image, one texel for each ray."""

    def __init__(self, inputs: FocusInputs) -> None:
        self._ctx, self._gpu = inputs.ctx, inputs.gpu
        self._depth = gl.depth_texture(inputs.ctx, (RAYS, 1))
        self.image = inputs.ctx.framebuffer([], self._depth)
        self.triangles = 0
        """Those of the last rays."""

    def draw(self, clips_from_head: Array, world_from_head: Pose) -> None:
        """Draw nine rays given by (9, 4, 4) projections, and bind their depths to unit 2."""
        ctx = self._ctx
        self.image.use()
        self.image.viewport = (0, 0, RAYS, 1)
        self.image.clear(depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        head_from_relative = rotation_only(world_from_head.rotation.T)
        self.triangles = self._gpu.draw_depth_views(
            clips_from_head @ head_from_relative, world_from_head.position, self._aim
        )
        self.image.viewport = (0, 0, RAYS, 1)
        ctx.enable_only(moderngl.NOTHING)
        self._depth.use(2)

    def _aim(self, ray: int) -> None:
        self.image.viewport = (ray, 0, 1, 1)


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
