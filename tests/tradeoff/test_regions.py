"""Which pixels show what, on images of a few surfaces whose answer is seen at once."""

import numpy as np
import pytest

from vrcomfort.tradeoff.error_measures import (
    LAMP,
    REGIONS,
    PinholeView,
    border,
    region_errors,
    regions,
    within,
)

NEAR, FAR = 0.02 / 1.0, 0.02 / 4.0


def seen(depth, radius, light=None):
    light = np.full((*depth.shape, 3), 0.5) if light is None else light
    return PinholeView(depth, radius, light, whole_width_px=depth.shape[1])


def halves(near_px, far_px, size=60):
    """Return a near surface in columns 0 to 29 and a far one behind it."""
    left = np.arange(size)[None, :].repeat(size, axis=0) < size // 2
    return seen(np.where(left, NEAR, FAR), np.where(left, near_px, far_px))


def columns(mask):
    """Return the first and the last column of a mask that is the same in every row."""
    assert (mask == mask[0]).all()
    found = np.flatnonzero(mask[0])
    return int(found[0]), int(found[-1])


def test_a_reach_is_a_disc():
    reach = np.zeros((21, 21))
    reach[10, 10] = 3
    y, x = np.mgrid[:21, :21] - 10
    np.testing.assert_array_equal(within(reach), x**2 + y**2 <= 9)
    assert not within(np.zeros((4, 4))).any()


def test_a_blurred_front_has_a_rim_as_wide_as_its_disc_on_either_side():
    found = regions(halves(-4.0, 3.0))
    assert columns(found["near_rims"]) == (29 - 5, 30 + 5)  # the disc and a pixel
    assert not found["far_edges"].any()
    assert columns(found["one_surface"]) == (0, 59)
    assert not (found["one_surface"] & found["near_rims"]).any()


def test_beside_what_is_sharp_a_blurred_background_has_a_far_edge():
    found = regions(halves(0.0, 5.0))
    assert columns(found["far_edges"]) == (29 - 6, 30 + 6)
    assert not found["near_rims"].any()
    assert columns(found["in_focus"]) == (0, 22)
    assert columns(found["one_surface"]) == (37, 59)
    between = (np.arange(60) >= 20) & (np.arange(60) < 40) & np.ones((60, 1), dtype=bool)
    found = regions(seen(np.where(between, FAR, NEAR), np.where(between, 5.0, 0.0)))
    assert columns(found["far_edges"]) == (19 - 6, 40 + 6)


def test_nothing_is_in_focus_where_a_front_reaches():
    left = np.arange(60)[None, :].repeat(60, axis=0) < 30
    found = regions(seen(np.where(left, NEAR, FAR), np.where(left, -5.0, 0.0)))
    assert columns(found["in_focus"]) == (37, 59)


def test_a_slanted_surface_has_no_edges():
    depth = np.linspace(FAR, NEAR, 60)[None, :].repeat(60, axis=0)  # affine, as of a plane
    found = regions(seen(depth, np.linspace(9, 1, 60)[None, :].repeat(60, axis=0)))
    assert found["one_surface"].all()


def test_what_is_narrow_is_thin_and_what_is_bright_is_a_lamp():
    depth, light = np.full((60, 60), FAR), np.full((60, 60, 3), 0.5)
    depth[:, 20] = NEAR
    light[40, 45] = 2 * LAMP
    found = regions(seen(depth, np.full((60, 60), 2.0), light))
    assert columns(found["thin"]) == (17, 23)
    assert found["lamps"].sum() == 29  # pixels within 3 of one
    wide = depth.copy()
    wide[:, 19:22] = NEAR  # the least that a window of 60 px keeps
    assert not regions(seen(wide, np.full((60, 60), 2.0)))["thin"].any()


def test_the_border_of_a_part_is_that_of_the_whole():
    assert border((10, 20), (False, False, False, False), 3).sum() == 0
    found = border((10, 20), (False, True, False, False), 3)
    assert columns(found) == (17, 19)
    assert border((10, 20), (True, True, True, True), 2).sum() == 10 * 20 - 6 * 16


def test_errors_are_those_of_the_pixels_of_a_region():
    masks = {name: np.zeros((8, 8), dtype=bool) for name in REGIONS}
    masks["thin"][2, 3:5] = True
    masks["lamps"][0, 0] = True
    error = np.zeros((8, 8, 3))
    error[2, 3] = 0.3
    known = np.ones((8, 8), dtype=bool)
    known[0, 0] = False
    found = region_errors(error, masks, known)
    assert found["thin_rms"] == pytest.approx(0.3 / 2**0.5)
    assert found["thin_px"] == 2
    assert (found["lamps_rms"], found["lamps_px"]) == (None, 0)
    assert found["seams"] is None
