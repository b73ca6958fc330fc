"""One kernel on one small image, with radii given in pixels."""

from typing import NamedTuple

import numpy as np

from tests.support.effects import NEAR_M, rgb_of, seen, square_pixels, textures
from vrcomfort.geometry import Pose
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels import make_kernel
from vrcomfort.render.effects.effect import EffectInputs

FOCUS_M = 1.0


class Blurred(NamedTuple):
    """(h, w, 4) points, (h, w, 3) half floats of the kernel, and the largest radius."""

    points: np.ndarray
    rgb: np.ndarray
    max_radius_px: float


def blur(ctx, kernel, rgb, radius_px, *, max_radius_px, pixel_aspect=1.0, **settings):
    """Blur (h, w, 3) radiance by (h, w) signed radii, as one view of a condition would."""
    height, width, _ = rgb.shape
    _, coc = defocused(ctx, rgb, radius_px, max_radius_px=max_radius_px, **settings)
    lens = DepthOfField(kernel=kernel, law="dioptre", **settings)
    wide = lens.model_copy(update={"max_radius_percent": 100 * max_radius_px / width})
    made = make_kernel(coc, wide)
    made.render(pixel_aspect)
    points = np.frombuffer(coc.colour_and_coc.read(), "f2").reshape(height, width, 4)
    return Blurred(points.astype(float), rgb_of(made.target), coc.max_radius_px)


def defocused(ctx, rgb, radius_px, *, max_radius_px, **more):
    """Return the texture of (h, w, 3) radiance, and what has found its (h, w) signed radii."""
    height, width, _ = rgb.shape
    # 1 dioptre of defocus is the largest radius; behind the focus, infinity is 1 dioptre away.
    distance_m = 1 / np.maximum(
        1 - np.broadcast_to(radius_px, (height, width)) / max_radius_px, 1e-9
    )
    colour, depth = textures(ctx, rgb, distance_m)
    focus = ctx.texture((1, 1), 4, np.full(4, FOCUS_M, "f4").tobytes(), dtype="f4")
    settings = DepthOfField(law="dioptre", full_blur_dioptre=1.0, **more)
    wide = settings.model_copy(update={"max_radius_percent": 100 * max_radius_px / width})
    size_px = (width, height)
    reads = {"depth": depth, "focus": focus}
    coc = CocPasses(EffectInputs(ctx, wide, colour, reads, 3e4))
    coc.render(seen(square_pixels(size_px), near_m=NEAR_M, head_from_eye=Pose()).camera)
    return colour, coc
