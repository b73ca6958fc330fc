"""Ways to spread circles of confusion over an image; one class each, made by `make_kernel`."""

from __future__ import annotations

import moderngl

from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.kernels.base import BlurKernel
from vrcomfort.render.kernels.vrcomfort import VrcomfortKernel

__all__ = ["BlurKernel", "make_kernel"]

_KERNELS = {"vrcomfort": VrcomfortKernel}


def make_kernel(
    ctx: moderngl.Context, colour: moderngl.Texture, defocus: Defocus, settings: DepthOfField
) -> BlurKernel:
    """Return the kernel that `settings` name, reading `colour` and the points of `defocus`."""
    return _KERNELS[settings.kernel](ctx, colour, defocus, settings)
