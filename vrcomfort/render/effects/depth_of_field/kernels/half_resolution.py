"""What the kernels of engines share: half an image, and how it is put over the sharp one."""

from __future__ import annotations

from math import ceil

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses


def half_size(size_px: tuple[int, int]) -> tuple[int, int]:
    """Return half a size, rounded up."""
    width, height = size_px
    return ceil(width / 2), ceil(height / 2)


def halved(ctx: moderngl.Context, coc: CocPasses, *, firefly: bool) -> FullscreenPass:
    """Return the pass that draws half of an image with its radii (``half_resolution.frag``)."""
    return FullscreenPass(
        ctx,
        "depth_of_field/half_resolution.frag",
        size_px=half_size(coc.size_px),
        inputs={"colour_and_coc": coc.colour_and_coc},
        defines={"FIREFLY": 1} if firefly else {},
    )


def composite(
    ctx: moderngl.Context,
    coc: CocPasses,
    half_image: moderngl.Texture,
    *,
    fade_px: tuple[float, float],
    own_radius: bool = False,
    half_front: moderngl.Texture | None = None,
) -> FullscreenPass:
    """Return the pass that puts half an image over the whole (``half_resolution_composite.frag``).

    Parameters
    ----------
    fade_px
        Between these radii of its own a pixel goes from sharp to blurred.
    """
    fronts = {} if half_front is None else {"half_front": half_front}
    return FullscreenPass(
        ctx,
        "depth_of_field/half_resolution_composite.frag",
        size_px=coc.size_px,
        inputs={"colour_and_coc": coc.colour_and_coc, "half_image": half_image, **fronts},
        filtered={"half_image", *fronts},
        defines={
            "FAR_FROM_PX": float(fade_px[0]),
            "FAR_TO_PX": float(fade_px[1]),
            **({"OWN_RADIUS": 1} if own_radius else {}),
            **({"FRONT": 1} if fronts else {}),
        },
    )
