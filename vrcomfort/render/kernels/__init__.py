"""Ways to spread circles of confusion over an image; one class each, made by `make_kernel`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import moderngl

from vrcomfort.optics.view_points import FEW
from vrcomfort.protocol.conditions import DepthOfField, Kernel
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.kernels.base import BlurKernel
from vrcomfort.render.kernels.mip import MipKernel
from vrcomfort.render.kernels.poisson12 import Poisson12Kernel
from vrcomfort.render.kernels.poisson15_near import Poisson15NearKernel
from vrcomfort.render.kernels.scatter import ScatterKernel
from vrcomfort.render.kernels.small_discs import WIDEST_PX, SmallDiscsKernel
from vrcomfort.render.kernels.taps import TapsKernel
from vrcomfort.render.kernels.vrcomfort import VrcomfortKernel

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
    that :func:`vrcomfort.render.lens_views.blur_of_one_view` has limited to small discs.
    """
    if settings.kernel == "vrcomfort" and settings.taps is not None:
        return TapsKernel(ctx, colour, defocus, settings.taps)
    if _small(settings, defocus):
        return SmallDiscsKernel(ctx, defocus)
    return _KERNELS[settings.kernel](ctx, colour, defocus, settings)


def _small(settings: DepthOfField, defocus: Defocus) -> bool:
    many = settings.kernel == "vrcomfort" and settings.views >= FEW
    return many and defocus.limit_px <= WIDEST_PX
