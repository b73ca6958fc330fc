"""Which tiles are drawn: those that are seen, and what passes read around them."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.geometry import Fov, HiddenArea
from vrcomfort.gpu.passes import Pass, PassImage
from vrcomfort.gpu.visible_area import (
    ANYWHERE,
    DRAWN,
    TILE_PX,
    corners,
    covering,
    hidden_pixels,
    margins,
    texels_of,
    visible_tiles,
    widened,
)

FOV = Fov(-0.9, 0.7, 0.8, -0.6)


def image(name: int, reach_px: float = ANYWHERE) -> PassImage:
    return PassImage(name, (64, 64), 0.0, reach_px=reach_px)


def step(source: PassImage, target: int, texel_px: int = 1) -> Pass:
    return Pass("a", (source,), (image(target),), texel_px=(texel_px, texel_px))


def test_margins_add_up_along_the_way_to_what_is_seen():
    chain = [step(image(1, 0.0), 2), step(image(2, 9.0), 3), step(image(3, 0.0), 4)]
    assert margins(chain) == {4: 0, 3: 0, 2: 2, 1: 2}
    assert margins(reversed(chain)) == margins(chain)
    assert margins([*chain, step(image(1, 30.0), 4)])[1] == 4


def test_narrow_pixels_make_reach_longer():
    assert margins([step(image(1, 8.0), 2)]) == {1: 1, 2: 0}
    assert margins([step(image(1, 8.0), 2)], 1.2)[1] == 2


def test_a_texel_that_goes_on_beyond_a_tile_counts():
    assert margins([step(image(1, 0.0), 2, texel_px=2)])[1] == 0
    assert margins([step(image(1, 0.0), 2, texel_px=TILE_PX)])[1] == 0
    assert margins([step(image(1, 0.0), 2, texel_px=12)])[1] == 1
    assert margins([step(image(1, 0.0), 2, texel_px=3 * TILE_PX)])[1] == 2


def test_what_may_be_read_anywhere_is_drawn_whole():
    found = margins([step(image(1, 3.0), 2), step(image(2), 3)])
    assert found == {1: math.inf, 2: math.inf, 3: 0}


def test_passes_in_a_ring_that_reach_farther_each_time_draw_whole_images():
    ring = [step(image(1, 8.0), 2), step(image(2, 0.0), 1), step(image(1, 0.0), 3)]
    assert margins(ring) == {1: math.inf, 2: math.inf, 3: 0}
    assert margins([step(image(1, 0.0), 2), *ring[1:]]) == {1: 0, 2: 0, 3: 0}


def test_a_sum_of_what_is_drawn_asks_for_no_more():
    assert margins([step(image(1, DRAWN), 2), step(image(1, 3.0), 3)]) == {1: 1, 2: 0, 3: 0}


def test_all_targets_of_a_pass_are_drawn_in_the_same_tiles():
    both = Pass("a", (image(1, 0.0),), (image(2), image(3)))
    assert margins([both, step(image(2, 3.0), 4)]) == {1: 1, 2: 1, 3: 1, 4: 0}


@given(st.integers(0, 2**32 - 1))
def test_hidden_pixels_are_those_with_their_middle_in_a_triangle(seed):
    random = np.random.default_rng(seed)
    size = tuple(random.integers(3, 40, 2))
    low, high = np.tan([FOV.left, FOV.down]), np.tan([FOV.right, FOV.up])
    vertices = random.uniform(low - 0.2, high + 0.2, (6, 2)).astype(np.float32)
    area = HiddenArea(vertices, random.integers(0, 6, (3, 3)).astype(np.uint32))
    middles = [(np.arange(n) + 0.5) / n for n in size]
    x, y = np.meshgrid(*[a + (b - a) * m for a, b, m in zip(low, high, middles, strict=True)])
    expected = np.zeros(x.shape, dtype=bool)
    unclear = np.zeros(x.shape, dtype=bool)
    for triangle in vertices[area.triangles].astype(float):
        sides = []
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            sides.append((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]))
        if np.ptp(triangle, axis=0).prod() == 0:
            unclear |= True  # no area: which pixels its line meets is a matter of rounding
        expected |= np.all(np.array(sides) > 0, axis=0) | np.all(np.array(sides) < 0, axis=0)
        unclear |= np.min(np.abs(sides), axis=0) < 1e-9
    found = hidden_pixels(area, FOV, size)
    assert (found == expected)[~unclear].all()


def test_a_tile_is_seen_where_one_of_its_pixels_is_or_touches_one_that_is():
    # The left half and one pixel more are hidden.
    left, right, up, down = FOV.tangents
    edge = left + (right - left) * (TILE_PX + 1) / (2 * TILE_PX)
    places = [(left, down), (edge, down), (edge, up), (left, up)]
    half = HiddenArea(np.array(places, np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    size = 2 * TILE_PX, TILE_PX
    assert visible_tiles(half, FOV, size).tolist() == [[False, True]]
    edge = left + (right - left) * TILE_PX / (2 * TILE_PX)
    half.vertices[1:3, 0] = edge
    assert visible_tiles(half, FOV, size).tolist() == [[True, True]]
    assert visible_tiles(None, None, (9, 17)).tolist() == [[True, True]] * 3


def test_widened_tiles_have_all_that_are_so_near():
    tiles = np.zeros((7, 9), dtype=bool)
    tiles[3, 4] = True
    assert np.argwhere(widened(tiles, 1)).tolist() == [
        [row, column] for row in (2, 3, 4) for column in (3, 4, 5)
    ]
    assert widened(tiles, math.inf).all()
    assert (widened(tiles, 0) == tiles).all()


@given(st.sampled_from([(1, 1), (2, 2), (8, 8), (16, 4), (12, 12)]), st.integers(0, 2**32 - 1))
def test_rectangles_cover_each_texel_of_the_tiles_once(texel_px, seed):
    random = np.random.default_rng(seed)
    image_px = random.integers(1, 90, 2)
    rows, columns = (math.ceil(n / TILE_PX) for n in image_px[::-1])
    tiles = random.random((rows, columns)) < 0.5
    size = tuple(math.ceil(n / t) for n, t in zip(image_px, texel_px, strict=True))
    counted = np.zeros(size[::-1], dtype=int)
    found = list(covering(tiles, size, texel_px))
    for left, bottom, right, top in found:
        counted[bottom:top, left:right] += 1
    assert (counted == texels_of(tiles, size, texel_px)).all()
    pixels = np.kron(tiles, np.ones((TILE_PX, TILE_PX), bool))[: image_px[1], : image_px[0]]
    for y, x in np.argwhere(pixels)[::7]:
        assert counted[y // texel_px[1], x // texel_px[0]] == 1
    assert corners(found, size).shape == (6 * len(found), 2)
