"""Passes that find what is near, on images of a few texels worked out by hand."""

import numpy as np
import pytest

from tests.support.effects import NEAR_M, coc_passes_of, seen, texels_of
from vrcomfort.geometry import Fov
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import DepthOfField

TILE = 8
IN_FOCUS, NEAR, BEHIND = 0, 1, 2
FAR = 12  # tiles to a silhouette that is not there


def near_tiles(ctx, own_px, rows):
    """Return (h, w, 4) of near_tiles.frag: of radii (h, w), and (away, widest, least) (h, w, 3)."""
    rows = np.dstack([rows, np.zeros(rows.shape[:2])]).astype("f4")
    tiles = np.zeros_like(rows)
    tiles[..., 0] = -np.asarray(own_px)
    size_px = rows.shape[1::-1]
    inputs = {
        name: ctx.texture(size_px, 4, texels.tobytes(), dtype="f4")
        for name, texels in (("tiles", tiles), ("rows", rows))
    }
    found = FullscreenPass(
        ctx,
        "depth_of_field/near_tiles.frag",
        size_px=size_px,
        inputs=inputs,
        defines={"TILE": TILE, "AWAY": float(FAR), "MAX_RADIUS_PX": 40.0},
        dtype="f4",
    )
    found.render(pixel_aspect_of_eye=1.0)
    return texels_of(found.target)


# Of a silhouette so many tiles away there is (away - 1) * 8 px of the same surface between.
@pytest.mark.parametrize(
    ("own_px", "widest_px", "away", "wanted"),
    [
        (1.9, 9.0, 1.0, NEAR),  # its disc is too narrow: up to 2 px
        (2.1, 9.0, 1.0, BEHIND),
        (8.1, 9.0, 3.0, BEHIND),  # 16 px away: twice its own 8.1 px
        (7.9, 9.0, 3.0, NEAR),
        (5.1, 9.0, 2.25, BEHIND),  # 10 px
        (4.9, 9.0, 2.25, NEAR),
        (4.9, 8.1, 6.0, NEAR),  # 40 px away: three times 8 px, and two tiles
        (4.9, 7.9, 6.0, IN_FOCUS),
        (30.0, 10.7, 7.0, BEHIND),  # 48 px: three times 10.7 px, and two tiles
        (30.0, 10.6, 7.0, IN_FOCUS),
        (30.0, 0.0, 1.0, IN_FOCUS),  # no disc comes here
    ],
)
def test_behind_is_drawn_within_two_radii_of_a_silhouette(ctx, own_px, widest_px, away, wanted):
    found = near_tiles(ctx, [[own_px]], np.array([[[away, widest_px, 1.5]]]))[0, 0]
    np.testing.assert_allclose(found, [widest_px, 1.5 if widest_px else 1e4, 0, wanted], rtol=1e-6)


def test_discs_and_silhouettes_of_other_rows_come_as_far_as_they_reach(ctx):
    """Discs of row 6 come 3 rows far, where 16 px lie between: from 15 px on, and up to 23 px.

    Its silhouette is 3 columns away: a row beside it is sqrt(10), two sqrt(13), three sqrt(18).
    """
    rows = np.tile([float(FAR), 0.0, 1e4], (13, 2, 1))
    discs_px = [15.2, 22.8]
    rows[6] = [(3.0, widest_px, 4.0) for widest_px in discs_px]
    # Behind is drawn from half of 8 (away - 1) px on: 8, 8.65, 10.42 and 12.97 px.
    own_px = np.full((13, 2), 30.0)
    own_px[3:10] = np.array([12.9, 10.3, 8.6, 8.1, 8.7, 10.5, 13.0])[:, None]
    found = near_tiles(ctx, own_px, rows)
    reached = np.abs(np.arange(13) - 6) <= 3
    beyond = [IN_FOCUS] * 3
    classes = [*beyond, NEAR, NEAR, NEAR, BEHIND, BEHIND, BEHIND, BEHIND, *beyond]
    for column, widest_px in enumerate(discs_px):
        widest, least, _, kinds = found[:, column].T
        np.testing.assert_allclose(widest, widest_px * reached, rtol=1e-6)
        np.testing.assert_array_equal(least, np.where(reached, 4.0, 1e4))
        np.testing.assert_array_equal(kinds, classes)


LENS = {"law": "dioptre", "full_blur_dioptre": 2.0}
SIZE_PX = (64, 32)
NEARER_D = 2.0 / (0.1 * SIZE_PX[0] / 2.0)
"""Dioptres to a radius of 2 px, where 2 dioptres are 10 % of the width."""


def limits(ctx, fov, **settings):
    """Return the limits (h + 1, w + 1) that near_limit.frag finds, with a focus at 2 m."""
    lens = DepthOfField(**LENS, **settings)
    coc = coc_passes_of(ctx, lens, np.full(SIZE_PX[::-1], 2.0), 2.0, SIZE_PX)
    coc.render(seen(fov).camera)
    radii = coc.depth_to_coc
    found = FullscreenPass(
        ctx,
        "depth_of_field/near_limit.frag",
        size_px=(SIZE_PX[0] // TILE + 1, SIZE_PX[1] // TILE + 1),
        inputs=radii.inputs,
        constants={"size_px": SIZE_PX},
        defines={**radii.defines, "TILE": TILE},
        components=1,
        dtype="f4",
    )
    found.render()
    return texels_of(found.target)[..., 0]


FOV = Fov(-0.8, 0.7, 0.9, -0.6)


def test_near_is_from_two_pixels_of_radius_on(ctx):
    found = limits(ctx, FOV, max_radius_percent=10.0)
    assert found.shape == (5, 9)
    np.testing.assert_allclose(found, NEAR_M * (0.5 + NEARER_D), rtol=1e-6)


def test_along_each_ray_the_limit_is_a_sphere(ctx):
    found = limits(ctx, FOV, max_radius_percent=10.0, distance_along="ray")
    right, up = np.meshgrid(tangents(-0.8, 0.7, 9), tangents(-0.6, 0.9, 5))
    expected = NEAR_M * (0.5 + NEARER_D) * np.sqrt(1 + right**2 + up**2)
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def tangents(low_rad, high_rad, count):
    return np.linspace(np.tan(low_rad), np.tan(high_rad), count)


def test_where_no_disc_is_so_wide_nothing_is_near(ctx):
    assert (limits(ctx, FOV, max_radius_percent=3.0) > 1.0).all()  # 1.92 px
