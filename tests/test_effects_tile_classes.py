"""Which tiles take which work: the shaders against their NumPy twin, on patches out of focus."""

import numpy as np
import pytest

from tests.oracles import tile_classes
from tests.oracles.tile_classes import Grid
from tests.support.effects import texels_of
from tests.support.kernels import defocused
from vrcomfort.optics.tile_classes import RingTile, TapBounds, TapTile
from vrcomfort.render.effects.depth_of_field.kernels.ring_tiles import READ_AROUND_PX, RingTiles
from vrcomfort.render.effects.depth_of_field.kernels.tap_tiles import TapTiles

HALF_FLOAT = 2**-10
"""OpenGL does not say which way it rounds."""

SMALL_PX = 4.7
BOUNDS = TapBounds(
    slight_px=0.5, few_px=2.0, wide_px=4.0, widest_px=8.0, apart_px=6.0, fine_reads=True
)
FADED = TapBounds(
    slight_px=2.0, few_px=2.8, wide_px=2.2, widest_px=3.9, apart_px=1e9, fine_reads=False
)


SURROUNDINGS_PX = 4 * (0.0, -1.2, 3.0, -6.0, 11.0)


def patches(seed, around_px):
    """Return (152, 203) signed radii: patches, some of them in focus, some of them slanted."""
    rng = np.random.default_rng(seed)
    radius_px = np.full((152, 203), around_px)
    for _ in range(2):
        top, left = rng.integers(0, 150, size=2)
        tall, wide = rng.integers(10, 80, size=2)
        level, slope = rng.choice([0.0, 0.4, -1.5, 2.5, 6.0, -12.0]), rng.choice([0, 0.004])
        patch = radius_px[top : top + tall, left : left + wide]
        patch[:] = level * (1 - slope * np.arange(patch.shape[1]))
    return radius_px


def images(ctx, limit_px):
    """Yield what has found the radii of each image, and their ranges."""
    for seed, around_px in enumerate(SURROUNDINGS_PX):
        radius_px = np.clip(patches(seed, around_px), -limit_px, limit_px)
        light = np.ones((*radius_px.shape, 3))
        _, coc = defocused(ctx, light, radius_px, limit_px=limit_px)
        yield coc, texels_of(coc.tile_min_max)[..., :2]


@pytest.mark.parametrize(("limit_px", "pixel_aspect"), [(13.0, 1.0), (13.0, 2.5), (40.0, 0.7)])
def test_tiles_of_rings_are_their_twin(ctx, limit_px, pixel_aspect):
    seen = set()
    for coc, ranges in images(ctx, limit_px):
        tiles = RingTiles(ctx, coc, small_px=SMALL_PX)
        tiles.render(pixel_aspect)
        reach = texels_of(tiles.dilated)[..., :2]
        grid = Grid(coc.tile_px, pixel_aspect)
        twin = tile_classes.may_reach(ranges, grid)
        np.testing.assert_allclose(reach, twin, rtol=HALF_FLOAT)
        around = grid._replace(margin_px=READ_AROUND_PX)
        kinds = tile_classes.ring_tile_classes(reach, around, small_px=SMALL_PX)
        np.testing.assert_array_equal(texels_of(tiles.classes)[..., 0], kinds)
        seen |= {kind for kind in RingTile if np.any(kinds & kind)}
    assert seen == set(RingTile)


@pytest.mark.parametrize("bounds", [BOUNDS, FADED])
@pytest.mark.parametrize(("limit_px", "pixel_aspect"), [(13.0, 1.0), (13.0, 2.5), (40.0, 0.7)])
def test_tiles_of_taps_are_their_twin(ctx, limit_px, pixel_aspect, bounds):
    seen = set()
    for coc, ranges in images(ctx, limit_px):
        tiles = TapTiles(ctx, coc, bounds)
        tiles.render(pixel_aspect)
        found = texels_of(tiles.classes)
        grid = Grid(coc.tile_px, pixel_aspect)
        reach = tile_classes.may_reach(ranges, grid)
        kinds = tile_classes.tap_tile_classes(reach, bounds)
        np.testing.assert_allclose(found[..., :2], reach, rtol=HALF_FLOAT)
        np.testing.assert_array_equal(found[..., 2], kinds)
        around = tile_classes.dilated_tile_classes(found[..., :2], kinds, grid)
        np.testing.assert_array_equal(found[..., 3], around)
        seen |= {kind for kind in TapTile if np.any(kinds == kind)}
    unused = {TapTile.FINE, TapTile.APART} if bounds is FADED else set()
    assert seen == set(TapTile) - unused
