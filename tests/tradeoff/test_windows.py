"""Parts of an image show what the whole shows, blurred by as many pixels."""

from dataclasses import replace

import numpy as np
import pytest

from vrcomfort.errors import InputError
from vrcomfort.optics.circle_of_confusion import radius_of_percent
from vrcomfort.tradeoff.captures import capture_views, radius_px
from vrcomfort.tradeoff.cases import (
    ALIGNED_PX,
    HEADSET_PX,
    WINDOWS,
    Case,
    ImageWindow,
    Scope,
    cases,
    condition_of,
    drawn,
    frames,
)
from vrcomfort.tradeoff.measure import judged_area
from vrcomfort.tradeoff.methods import base_condition
from vrcomfort.tradeoff.store import scene_and_hash

SIZE_PX = (128, 160)


@pytest.fixture
def part(monkeypatch):
    """Return a case whose window is a part of a small image."""
    window = ImageWindow("part", 32, 64, 32, 32)
    monkeypatch.setitem(WINDOWS, ("temple", 0), (window,))
    return Case("temple", 0, "still", "depth_of_field", window="part")


def capture(case, scope):
    scene, _ = scene_and_hash(case.scene)
    condition = condition_of(case, scope, base_condition(case.effect))
    size_px = drawn(case, scope).size_px
    (found,) = capture_views(scene, condition, frames(case, scope), size_px, eyes=1)
    return found, condition


@pytest.mark.slow
def test_a_part_shows_what_the_whole_shows_there(part):
    scope = Scope(size_px=SIZE_PX, eyes=1, poses=2)
    whole, whole_condition = capture(Case("temple", 0, "still", "depth_of_field"), scope)
    found, condition = capture(part, scope)
    rows, columns = drawn(part, scope).within(ImageWindow("whole", 0, 0, *SIZE_PX))
    assert found.sharp.shape[0] < SIZE_PX[1]
    difference = np.abs(found.sharp - whole.sharp[rows, columns])
    assert np.quantile(difference, 0.99) < 0.02  # an edge may fall on another sample
    np.testing.assert_allclose(
        radius_px(found, condition), radius_px(whole, whole_condition)[rows, columns], atol=0.05
    )


def test_discs_are_as_wide_in_a_part_as_in_the_whole(part):
    scope = Scope(size_px=SIZE_PX)
    found = condition_of(part, scope, base_condition("both"))
    width = drawn(part, scope).width_px
    lens, shutter = found.depth_of_field, found.motion_blur
    assert radius_of_percent(lens.max_radius_percent, width) == pytest.approx(
        radius_of_percent(3.5, SIZE_PX[0])
    )
    assert shutter.max_radius_percent / 100 * width == pytest.approx(0.2 * SIZE_PX[0])


def test_what_is_drawn_reaches_as_far_as_discs_and_stays_on_the_grid():
    whole = ImageWindow("w", 320, 640, 96, 64)
    found = whole.drawn(HEADSET_PX, reach_px=64.0)
    assert (found.left_px, found.bottom_px) == (320 - 96, 640 - 96)
    assert found.size_px == (96 + 192, 64 + 192)
    assert found.left_px % ALIGNED_PX == found.bottom_px % ALIGNED_PX == 0
    rows, columns = whole.within(found)
    assert (rows, columns) == (slice(96, 160), slice(96, 192))
    corner = ImageWindow("c", 0, 0, 64, 64).drawn(HEADSET_PX, reach_px=10.0)
    assert (corner.left_px, corner.bottom_px, corner.width_px) == (0, 0, 96)


def test_shipped_windows_lie_in_the_image_and_on_the_grid():
    for window in (each for some in WINDOWS.values() for each in some):
        assert 0 <= window.left_px < window.left_px + window.width_px <= HEADSET_PX[0]
        assert 0 <= window.bottom_px < window.bottom_px + window.height_px <= HEADSET_PX[1]
        assert window.left_px % ALIGNED_PX == window.bottom_px % ALIGNED_PX == 0


def test_a_window_is_judged_without_the_margin_of_the_whole_image():
    scope = Scope(size_px=HEADSET_PX, windows=True, pose=0, effects=("depth_of_field",))
    found = {case.window: case for case in cases(scope) if case.scene == "temple"}
    assert set(found) == {"near_rims", "far_edges"}
    far = found["far_edges"]
    rows, columns = judged_area(far, scope)
    margin = 229  # an eighth of 1832
    left = drawn(far, scope).left_px
    assert columns == slice(1216 - left, HEADSET_PX[0] - margin - left)
    assert rows.stop - rows.start == 512


def test_one_place_of_a_walk_is_the_one_that_all_places_have():
    whole = Scope(size_px=SIZE_PX, poses=2, effects=("depth_of_field",), scenes=("temple",))
    assert cases(replace(whole, pose=1)) == cases(whole)[1:]
    with pytest.raises(InputError, match="--view 3: there are 2"):
        cases(replace(whole, pose=2))


def test_windows_are_of_one_size_of_image():
    with pytest.raises(InputError, match="1832x1920"):
        cases(Scope(windows=True))


def test_windows_are_of_the_places_that_they_were_made_for():
    scope = Scope(size_px=HEADSET_PX, windows=True, effects=("depth_of_field",))
    with pytest.raises(InputError, match="places of --views 2"):
        cases(replace(scope, poses=3))
    with pytest.raises(InputError, match="that place of the walk has none"):
        cases(replace(scope, scenes=("mountain",), pose=1))
