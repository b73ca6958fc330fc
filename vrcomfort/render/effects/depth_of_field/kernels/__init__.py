"""Ways to spread circles of confusion over an image; one class each, made by `make_kernel`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import moderngl

from vrcomfort.protocol.conditions import DepthOfField, Kernel
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels.base import BlurKernel
from vrcomfort.render.effects.depth_of_field.kernels.half_resolution_disc import (
    HalfResolutionDiscKernel,
)
from vrcomfort.render.effects.depth_of_field.kernels.half_resolution_rings import (
    HalfResolutionRingsKernel,
)
from vrcomfort.render.effects.depth_of_field.kernels.layered_gather import LayeredGatherKernel
from vrcomfort.render.effects.depth_of_field.kernels.mip import MipKernel
from vrcomfort.render.effects.depth_of_field.kernels.poisson12 import Poisson12Kernel
from vrcomfort.render.effects.depth_of_field.kernels.poisson15_near import Poisson15NearKernel
from vrcomfort.render.effects.depth_of_field.kernels.scatter import ScatterKernel
from vrcomfort.render.effects.depth_of_field.kernels.separable_gaussian import (
    SeparableGaussianKernel,
)

__all__ = ["BlurKernel", "make_kernel"]

_Maker = Callable[[moderngl.Context, CocPasses, DepthOfField], BlurKernel]
_KERNELS: dict[Kernel, _Maker] = {
    "vrcomfort": LayeredGatherKernel,
    "scatter": ScatterKernel,
    "poisson12": Poisson12Kernel,
    "poisson15_near": Poisson15NearKernel,
    "mip": MipKernel,
    "mip_slices": partial(MipKernel, slices=True),
    "half_resolution_disc": HalfResolutionDiscKernel,
    "ring_gather": HalfResolutionRingsKernel,
    "separable_gaussian": SeparableGaussianKernel,
}


def make_kernel(ctx: moderngl.Context, coc: CocPasses, settings: DepthOfField) -> BlurKernel:
    """Return the kernel that `settings` name, reading the points of `coc`."""
    return _KERNELS[settings.kernel](ctx, coc, settings)
