"""Ways to spread circles of confusion over an image; one class each, made by `make_kernel`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import moderngl

from vrcomfort.optics.view_points import FEW
from vrcomfort.protocol.conditions import DepthOfField, Kernel
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
from vrcomfort.render.effects.depth_of_field.kernels.base import BlurKernel
from vrcomfort.render.effects.depth_of_field.kernels.mip import MipKernel
from vrcomfort.render.effects.depth_of_field.kernels.poisson12 import Poisson12Kernel
from vrcomfort.render.effects.depth_of_field.kernels.poisson15_near import Poisson15NearKernel
from vrcomfort.render.effects.depth_of_field.kernels.rings import VrcomfortKernel
from vrcomfort.render.effects.depth_of_field.kernels.scatter import ScatterKernel
from vrcomfort.render.effects.depth_of_field.kernels.small_discs import WIDEST_PX, SmallDiscsKernel
from vrcomfort.render.effects.depth_of_field.kernels.taps import TapsKernel

__all__ = ["BlurKernel", "make_kernel"]

_Maker = Callable[[moderngl.Context, moderngl.Texture, Defocus, DepthOfField], BlurKernel]
_KERNELS: dict[Kernel, _Maker] = {
    "vrcomfort": VrcomfortKernel,
    "scatter": ScatterKernel,
    "poisson12": Poisson12Kernel,
    "poisson15_near": Poisson15NearKernel,
    "mip": MipKernel,
    "mip_slices": partial(MipKernel, slices=True),
}


def make_kernel(
    ctx: moderngl.Context, colour: moderngl.Texture, defocus: Defocus, settings: DepthOfField
) -> BlurKernel:
    """Return the kernel that `settings` name, reading `colour` and the points of `defocus`.

    Ours has two: one for an image of its own, one for each of many views whose blur is small: those
    that `lens_views.blur_of_one_view` has limited to small discs.
    """
    if settings.kernel == "vrcomfort" and settings.taps is not None:
        return TapsKernel(ctx, colour, defocus, settings.taps)
    if _small(settings, defocus):
        return SmallDiscsKernel(ctx, defocus)
    return _KERNELS[settings.kernel](ctx, colour, defocus, settings)


def _small(settings: DepthOfField, defocus: Defocus) -> bool:
    many = settings.kernel == "vrcomfort" and settings.views >= FEW
    return many and defocus.limit_px <= WIDEST_PX
