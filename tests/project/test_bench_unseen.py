"""Scenes that nothing was tuned for: made alike from a seed, and an oracle of their own."""

import numpy as np
import pytest

from bench import unseen, unseen_motion
from bench.unseen_scenes import build
from vrcomfort.tradeoff.brute_force import Reference
from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.methods import no_blur


def test_a_seed_makes_the_same_scene_again(tmp_path):
    first, again, other = (tmp_path / f"{name}.glb" for name in ("first", "again", "other"))
    build(5, first)
    build(5, again)
    build(6, other)
    assert first.read_bytes() == again.read_bytes() != other.read_bytes()
    side_cars = [each.with_suffix(".toml").read_text() for each in (first, again, other)]
    assert side_cars[0] == side_cars[1] != side_cars[2]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_two_oracles_agree(tmp_path, seed):
    """Sheared frusta of ordinary cameras see what the engine's own lens does, lamps too."""
    case = unseen.case(seed, tmp_path, whole_px=(480, 503), window_px=96)
    ours = unseen.through_the_lens(case, 256)
    condition = unseen.of_part(case.view.condition(), case.window.width_px / case.whole_px[0])
    reference = Reference(context(), case.scene, condition, case.window.size_px)
    sharp = unseen.drawn_with(case, no_blur("depth_of_field"))
    fov = unseen.sub_frustum(case.view.fov, case.window, case.whole_px)
    camera = unseen.EyeCamera(sharp.camera.world_from_eye, fov, world_from_head=case.view.head)
    other = reference.render(
        camera, unseen.TIME_S, None, focus_m=case.view.focus_m, samples=256
    ).image
    grain = np.abs(unseen.through_the_lens(case, 256, seed=1) - ours)
    judged = case.window.within(case.drawn)
    blurred = np.abs(ours - sharp.sharp[judged])
    apart = np.abs(ours - other)
    assert apart.mean() < 2 * grain.mean() + 1e-3
    assert apart.mean() < 0.2 * blurred.mean()


def cuts(image, true):
    """Count cuts beside a reference that has no noise."""
    return unseen.cuts(image, true, np.stack([true, true]))


def test_a_cut_along_a_column_is_found_and_a_slanted_edge_is_not():
    row, column = np.mgrid[:96, :96]
    straight = np.where(column < 40, 0.0, 0.03)
    slanted = np.where(column + row / 6 < 50, 0.0, 0.03)
    slope = np.clip(0.01 * (column - 40), 0, 0.1)
    flat = np.zeros((96, 96))
    assert cuts(straight, flat) > 70
    assert cuts(straight.T, flat) > 70
    assert cuts(slanted, flat) == cuts(slope, flat) == 0
    assert cuts(np.random.default_rng(1).normal(0, 0.02, (96, 96)), flat) < 10


def test_a_step_that_the_reference_has_is_no_cut():
    """Also where the image has less of it; a higher one and one the other way are."""
    _, column = np.mgrid[:96, :96]
    straight = np.where(column < 40, 0.0, 0.03)
    assert cuts(straight, straight) == cuts(0 * straight, straight) == 0
    assert cuts(2 * straight, straight) > 70
    assert cuts(-straight, straight) > 70


def test_another_reference_has_no_cut_and_a_cut_beside_its_noise_has():
    """A blurred line along a column: where the views of a reference have it is left to chance."""
    views = np.zeros((3, 64, 96, 96))
    places = 20 + np.random.default_rng(1).integers(0, 25, views.shape[:2])
    for reference, at in zip(views, places, strict=True):
        reference[np.arange(64), :, at] = 0.6
    first, last, other = views[0].mean(axis=0), views[1].mean(axis=0), views[2].mean(axis=0)
    true, halves = (first + last) / 2, np.stack([first, last])
    assert unseen.cuts(other, true, np.stack([true, true])) > 70
    assert unseen.cuts(other, true, halves) == 0
    column = np.arange(96)
    assert unseen.cuts(other + 0.012 * (column >= 72), true, halves) > 70
    assert unseen.cuts(other + 0.2 * (column >= 32), true, halves) > 70


def test_a_shutter_that_is_open_for_an_instant_sees_the_sharp_image(tmp_path):
    """The oracle's cameras and times are the engine's."""
    case, size_px = unseen_motion.moving_case(1, tmp_path), (96, 80)
    sharp = unseen_motion.captured(case, size_px)
    instant = unseen_motion.through_the_shutter(case, 1, size_px)
    np.testing.assert_allclose(instant, sharp.sharp, rtol=1e-2, atol=1e-3)
    open_long = unseen_motion.through_the_shutter(case, 16, size_px)
    near = unseen_motion.jumps(np.asarray(sharp.velocity_px, dtype=np.float64))
    changed = np.abs(open_long - sharp.sharp).sum(axis=-1) > 0.02
    assert near.any()
    assert changed[near].mean() > 5 * changed[~near].mean()
