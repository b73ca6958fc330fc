"""How large blur and streaks are, against formulas for a wall, and what is said about them."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.support.protocols import generated
from tests.support.render import at, glowing, scene, wall
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, View, focal_length_px, yaw_pitch_roll
from vrcomfort.headset.playback import default_fovs
from vrcomfort.protocol import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.protocol.conditions import GazeCentre, Peripheral, SpeedBlur, TurnRamp
from vrcomfort.protocol.viewing import Visibility
from vrcomfort.render.stimulus_check import (
    StimulusSize,
    faults,
    measure,
    needlessly_meant,
    seen,
    turning_left,
    turning_twins,
)

SIZE = (64, 64)
FOCAL_PX = focal_length_px(default_fovs(SIZE)[0], SIZE)[0]
PERIOD_NS = 11_111_111


def moment(before: Pose, now: Pose) -> tuple[Frame, Frame]:
    left, right = default_fovs(SIZE)

    def frame(index: int, head: Pose) -> Frame:
        views = (View(head, left), View(head, right))
        return Frame(index, index * PERIOD_NS, PERIOD_NS, head, views, Pose())

    return frame(0, before), frame(1, now)


STILL = moment(Pose(), Pose())


def a_wall(distance_m: float):
    return scene([at(0, 0, -distance_m, mesh=(0,))], [wall(40.0)], [glowing((1.0, 1.0, 1.0))])


def lens(name: str, focus_m: float, **settings) -> Condition:
    focus = Focus(method="fixed", fixed_m=focus_m)
    return Condition(name=name, focus=focus, depth_of_field=DepthOfField(**settings))


def test_circles_are_those_of_the_law(ctx):
    conditions = [
        lens("eye", 2.0, law="eye", pupil_mm=4.0),
        lens("wide", 2.0, law="eye", pupil_mm=8.0),
        lens("focused", 4.0, law="eye", pupil_mm=4.0),
        lens("limited", 2.0, law="eye", pupil_mm=20.0, max_radius_percent=0.05),
        Condition(name="plain"),
    ]
    found = measure(ctx, a_wall(4.0), conditions, [STILL, STILL], SIZE)
    expected = 0.004 * FOCAL_PX * (1 / 2 - 1 / 4)
    assert found["eye"].circles_px.shape == (2 * 64 * 64,)
    np.testing.assert_allclose(found["eye"].circles_px, expected, rtol=1e-3)
    np.testing.assert_allclose(found["wide"].circles_px, 2 * expected, rtol=1e-3)
    np.testing.assert_allclose(found["focused"].circles_px, 0.0, atol=1e-3)
    assert found["limited"].circles_px.max() == pytest.approx(2 * 0.0005 * 64, rel=1e-3)
    assert found["eye"].streaks_px is None
    assert found["plain"].circles_px is found["plain"].streaks_px is None


def test_focus_that_looks_finds_the_wall(ctx):
    ray = Condition(name="rays", depth_of_field=DepthOfField(law="eye"))
    gaze = Condition(
        name="gaze", focus=Focus(method="gaze"), depth_of_field=DepthOfField(law="eye")
    )
    for each in measure(ctx, a_wall(3.0), [ray, gaze], [STILL], SIZE).values():
        np.testing.assert_allclose(each.circles_px, 0.0, atol=2e-3)


def test_streaks_are_the_way_of_a_pixel_while_the_shutter_is_open(ctx):
    step_m = 0.05
    sideways = moment(Pose(), Pose(np.array([step_m, 0.0, 0.0])))
    modes = [
        Condition(name="half", motion_blur=MotionBlur(mode="full", shutter_fraction=0.5)),
        Condition(name="whole", motion_blur=MotionBlur(mode="full", shutter_fraction=1.0)),
        Condition(name="short", motion_blur=MotionBlur(mode="full", max_radius_percent=0.1)),
        Condition(name="things", motion_blur=MotionBlur(mode="objects_only")),
    ]
    found = measure(ctx, a_wall(4.0), modes, [sideways], SIZE)
    way_px = FOCAL_PX * step_m / 4.0
    np.testing.assert_allclose(found["half"].streaks_px, 0.5 * way_px, rtol=5e-3)
    np.testing.assert_allclose(found["whole"].streaks_px, way_px, rtol=5e-3)
    assert found["short"].streaks_px.max() == pytest.approx(2 * 0.001 * 64, rel=1e-3)
    assert found["things"].streaks_px.shape == (64 * 64,)
    assert found["things"].streaks_px.max() == 0.0


def test_streaks_that_fade_with_turning(ctx):
    turn = moment(Pose(), Pose(orientation=yaw_pitch_roll(np.radians(0.5), 0.0, 0.0)))  # 45 deg/s
    ramp = TurnRamp(from_deg_s=0.0, to_deg_s=90.0)
    plain = MotionBlur(mode="full")
    modes = [
        Condition(name="full", motion_blur=plain),
        Condition(name="faded", motion_blur=plain.model_copy(update={"fade_with_turning": ramp})),
        Condition(name="cancelled", motion_blur=MotionBlur(mode="rotation_cancelled")),
    ]
    found = measure(ctx, a_wall(4.0), modes, [turn], SIZE)
    full, faded = found["full"].streaks_px, found["faded"].streaks_px
    np.testing.assert_allclose(faded, full / 2, rtol=1e-3)
    assert np.median(full) > 0.1
    assert found["cancelled"].streaks_px.max() < 1e-3


def sizes(circles=None, streaks=None) -> StimulusSize:
    parts = (None if each is None else np.array(each, np.float32) for each in (circles, streaks))
    return StimulusSize(*parts)


def test_amounts_are_told_in_pixels_and_angles():
    found = seen("c", "s", sizes(circles=range(11)), focal_px=916.0)
    assert found.streaks is None
    assert (found.circles.median_px, found.circles.p90_px) == (5.0, 9.0)
    assert found.circles.shown_percent == pytest.approx(1000 / 11)
    # 916 px are one radian in the middle: 5 px are 18.8 arcmin.
    assert found.circles.median_arcmin == pytest.approx(5 / 916 * 180 / np.pi * 60, rel=1e-4)
    assert sizes(circles=[1.0]).scaled(3.0).circles_px.tolist() == [3.0]


def study(**visibility):
    lens = DepthOfField(law="eye")
    shown = tuple(Condition(name=name, depth_of_field=lens) for name in ("a", "b", "c"))
    return generated("williams", 2).model_copy(
        update={
            "conditions": (Condition(name="none"), *shown),
            "visibility": Visibility(**visibility),
        }
    )


WEAK, MIDDLE, STRONG = [0.9] * 10, [2.0] * 10, [2.5] * 10
FOUND = {"room": {"none": sizes(), "a": sizes(WEAK), "b": sizes(MIDDLE), "c": sizes(STRONG)}}


def test_what_cannot_be_seen_or_told_apart_is_told():
    unseen, alike = faults(study(), FOUND)
    assert (unseen.conditions, unseen.scenes) == (("a",), ("room",))
    assert "`a` cannot be seen in room" in unseen.message
    assert "0.90 px" in unseen.message
    assert alike.conditions == ("b", "c")
    assert "`b` and `c` cannot be told apart in room" in alike.message
    assert 'alike = [["b", "c"]]' in alike.message


def test_what_is_meant_is_no_fault():
    meant = study(unseen=("a",), alike=(("c", "b"),))
    assert list(faults(meant, FOUND)) == []
    assert list(needlessly_meant(meant, FOUND)) == []
    needless = list(needlessly_meant(study(unseen=("c",), alike=(("a", "c"),)), FOUND))
    assert "`c` is in [visibility] unseen, and can be seen" in needless[0]
    assert "`a` and `c` are in [visibility] alike" in needless[1]


def test_a_tenth_of_the_image_is_enough():
    few, more = [0.0] * 89 + [5.0] * 11, [0.0] * 91 + [5.0] * 9
    found = {"room": {"none": sizes(), "a": sizes(few), "b": sizes([9.0] * 100),
                      "c": sizes(more)}}  # fmt: skip
    (fault,) = faults(study(), found)
    assert fault.conditions == ("c",)


def test_effects_that_are_not_measured_may_tell_conditions_apart():
    protocol = study()
    none, *others = protocol.conditions
    blurred = [
        each.model_copy(update={"speed_blur": SpeedBlur(max_sigma_arcmin=10.0 + number)})
        for number, each in enumerate(others)
    ]
    protocol = protocol.model_copy(update={"conditions": (none, *blurred)})
    assert list(faults(protocol, FOUND)) == []


def test_what_follows_the_gaze_is_another_condition_and_can_be_unseen():
    """With the same blur: sizes are those of a gaze straight ahead."""
    protocol = study()
    none, a, b, c = protocol.conditions
    shape = a.depth_of_field.model_copy(update={"peripheral": Peripheral()})
    a, b, c = (each.model_copy(update={"depth_of_field": shape}) for each in (a, b, c))
    followed = c.model_copy(update={"gaze_centre": GazeCentre(of=["peripheral"])})
    protocol = protocol.model_copy(update={"conditions": (none, a, b, followed)})
    assert [fault.conditions for fault in faults(protocol, FOUND)] == [("a",)]
    weak = {"room": {**FOUND["room"], "c": sizes(WEAK)}}
    assert [fault.conditions for fault in faults(protocol, weak)] == [("a",), ("c",)]


def test_two_conditions_without_anything_are_told():
    plain = tuple(Condition(name=name) for name in ("a", "b"))
    protocol = study().model_copy(update={"conditions": plain})
    (fault,) = faults(protocol, {"room": {"a": sizes(), "b": sizes()}})
    assert fault.conditions == ("a", "b")


def turning_notes(ctx, avatar_deg, head_deg, **motion):
    """Return what is told of a condition whose avatar and head turn while it walks."""
    turned = moment(Pose(), Pose(orientation=yaw_pitch_roll(np.radians(head_deg), 0.0, 0.0)))
    before, now = turned
    walked = np.array([0.0, 0.0, -0.01])
    avatar = Pose(walked, yaw_pitch_roll(np.radians(avatar_deg), 0.0, 0.0))
    condition = Condition(name="blur", motion_blur=MotionBlur(**motion))
    protocol = study().model_copy(update={"conditions": (condition,)})
    walk = [(before, replace(now, avatar_pose=avatar))]
    shown = [condition, *turning_twins([condition])]
    found = measure(ctx, a_wall(4.0), shown, walk, SIZE)
    return list(turning_left(protocol, {"room": {k: v.scaled(20.0) for k, v in found.items()}}))


def test_virtual_turns_that_leave_what_full_shows_are_told(ctx):
    (note,) = turning_notes(ctx, avatar_deg=0.8, head_deg=0.1)
    streak_px = 20 * 0.5 * FOCAL_PX * np.radians(0.8)  # in the middle; longer aside
    (left_px,) = re.findall(r"streaks of ([\d.]+) px in room", note)
    assert streak_px < float(left_px) < 1.5 * streak_px
    assert 'virtual_turning = "cancelled"' in note


@pytest.mark.parametrize(
    ("turns", "motion"),
    [
        ((0.8, 0.1), {"virtual_turning": "kept"}),  # decided
        ((0.8, 0.1), {"virtual_turning": "cancelled"}),
        ((0.8, 0.1), {"mode": "full"}),
        ((0.8, 0.1), {"mode": "head_cancelled"}),  # which says that locomotion stays
        ((0.1, 0.8), {}),  # most of what `full` shows is cancelled
        ((0.0, 0.0), {}),  # what is left is of walking
    ],
)
def test_nothing_is_told_of_turns_that_are_decided_or_cancelled(ctx, turns, motion):
    assert turning_notes(ctx, *turns, **motion) == []
