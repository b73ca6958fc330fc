"""Motion effects in whole frames: what moves, what is left out, which comes first."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from tests.render.test_pipeline import SIZE, FrameAt, standing
from tests.support.render import at, box, glowing, scene, still_life, wall
from vrcomfort.api.playback import shipped_walk
from vrcomfort.geometry import Pose, rotate, yaw_pitch_roll
from vrcomfort.gpu import shaders
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.conditions import (
    Condition,
    DepthOfField,
    Focus,
    MotionBlur,
    MoveRamp,
    SpeedBlur,
    TurnRamp,
)
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.brute_force import read_rgb

GREEN = glowing((0.0, 1.0, 0.0))
BLUE = glowing((0.0, 0.0, 1.0))
PLAIN = Condition(name="plain")
SPEED = SpeedBlur(
    turning=TurnRamp(from_deg_s=40, to_deg_s=120), moving=MoveRamp(from_m_s=0.5, to_m_s=3)
)


def streaks(mode="full", **settings):
    return Condition(name="mb", motion_blur=MotionBlur(mode=mode, shutter_fraction=1.0, **settings))


def moved_by(node, translation_per_s):
    """Return an animation that moves a node evenly for 10 s."""
    start = node.translation
    keys = np.array([start, start + 10 * np.asarray(translation_per_s, dtype=float)])
    channel = Channel(0, "translation", np.array([0.0, 10.0]), keys, "LINEAR")
    return Animation("slide", (channel,), 10.0)


def sliding(*others, primitives, materials, per_s=(30.0, 0, 0), place=(0.0, 0.8, -4)):
    node = at(*place, moving=True)
    nodes, animations = [node, *others], (moved_by(node, per_s),)
    return scene(nodes, primitives, materials, animations=animations)


def ball():
    return sliding(
        at(0, 0.8, -6, mesh=(1,)), primitives=[box(), wall(9, 1)], materials=[GREEN, BLUE]
    )


def last_eyes(ctx, content, condition, frames):
    """Return (sharp, blurred, velocity) of both eyes in the last frame."""
    renderer, found = StereoRenderer(ctx, SIZE), []
    renderer.build(content, condition)

    def keep(_, images):
        velocity = images.velocity and np.frombuffer(images.velocity.read(), "f2")
        velocity = None if velocity is None else velocity.reshape(SIZE[1], SIZE[0], 2).astype(float)
        found.append((read_rgb(images.pinhole), read_rgb(images.linear), velocity))

    for frame in frames:
        found.clear()
        renderer.render(frame, frame.index / 90, keep)
    return found


@pytest.mark.parametrize("periods", [2, 5])
def test_dropped_frames_make_no_longer_streaks(ctx, periods):
    """The same speed, seen after one period and after several."""
    slow = sliding(primitives=[box()], materials=[GREEN], per_s=(30.0, 0, 0))
    start = 10
    eyes = {
        step: last_eyes(ctx, slow, streaks(), [standing(start - step), standing(start)])
        for step in (1, periods)
    }
    for (sharp, blurred, velocity), (_, after_drop, further) in zip(*eyes.values(), strict=True):
        moved = np.abs(velocity[..., 0]).max()
        assert np.abs(further[..., 0]).max() == pytest.approx(periods * moved, rel=0.01)
        assert np.abs(blurred - sharp).max() > 0.1
        np.testing.assert_allclose(after_drop, blurred, atol=0.01)


@pytest.fixture(scope="session")
def count_primitives(session_context):
    """Return a function: how many primitives OpenGL draws during a call; one for each pass."""
    with session_context:
        query = session_context.query(primitives=True)
        with query:  # OpenGL makes it at its first use, which is in no test
            pass

    def count(call):
        with query:
            call()
        return query.primitives

    return count


@pytest.fixture
def primitives_drawn(ctx, count_primitives):
    """Return a function: how many primitives the last of some frames takes."""

    def drawn(content, condition, frames):
        renderer = StereoRenderer(ctx, SIZE)
        renderer.build(content, condition)
        for frame in frames[:-1]:
            renderer.render(frame, frame.index / 90)
        last = frames[-1]
        return count_primitives(lambda: renderer.render(last, last.index / 90))

    return drawn


@pytest.fixture
def owned(ctx, count_objects):
    """Return a function: how many objects of each kind a condition takes in the still life."""

    def count(condition):
        before = count_objects()
        renderer = StereoRenderer(ctx, SIZE)
        renderer.begin(still_life(), condition)
        after = count_objects()
        return {kind: after[kind] - before[kind] for kind in after}

    return count


def turned():
    return [standing(0, 1.5), standing(1, 0.0)]


REST = [standing(0), standing(1)]
WALK = [standing(0), standing(1, avatar_pose=Pose((0.1, 0, 0)))]


@pytest.mark.parametrize(
    ("mode", "frames", "blurs"),
    [
        ("full", turned(), True),
        ("full", WALK, True),
        ("head_cancelled", turned(), False),
        ("head_cancelled", WALK, True),
        ("rotation_cancelled", turned(), False),
        ("rotation_cancelled", WALK, True),
        ("rotation_cancelled_eye", turned(), True),
        ("rotation_cancelled_eye", WALK, True),
    ],
)
def test_a_frame_in_which_nothing_moved_has_no_pass_and_is_copied_exactly(
    ctx, primitives_drawn, mode, frames, blurs
):
    content = scene([at(0, 0.8, -1.0)], [box(0.8)], [GREEN])
    more = primitives_drawn(content, streaks(mode), frames) > primitives_drawn(
        content, PLAIN, frames
    )
    assert more == blurs
    for sharp, blurred, _ in last_eyes(ctx, content, streaks(mode), frames):
        assert np.array_equal(sharp, blurred) != blurs


@pytest.mark.parametrize("method", ["reconstruction", "per_pixel"])
def test_branches_of_a_gpu_draw_what_loops_of_a_software_rasteriser_draw(ctx, monkeypatch, method):
    both = Condition(
        name="both",
        focus=Focus(method="fixed", fixed_m=0.5),
        depth_of_field=DepthOfField(max_radius_percent=10.0, law="dioptre"),
        motion_blur=MotionBlur(mode="full", shutter_fraction=1.0, method=method),
    )
    images = []
    for software in (True, False):
        monkeypatch.setattr(shaders, "is_software", lambda _, software=software: software)
        images.append(last_eyes(ctx, still_life(), both, WALK))
    for (_, loops, _), (_, branches, _) in zip(*images, strict=True):
        assert np.array_equal(loops, branches)
        assert np.ptp(loops) > 0.1


def test_objects_only_has_no_velocity_and_no_pass_where_nothing_moves(owned):
    assert owned(streaks("objects_only")) == owned(PLAIN)
    planned = {item.name: item for item in plan_passes(still_life(), streaks("objects_only"))}
    assert not planned["velocity"].needed
    assert planned["motion_blur"].reason == "objects_only, and nothing in the scene moves"


def test_objects_only_blurs_what_moves_by_itself_only(ctx):
    walking_and_turning = [standing(0), standing(1, 0.2, avatar_pose=Pose((0.1, 0, 0)))]
    for sharp, blurred, velocity in last_eyes(
        ctx, ball(), streaks("objects_only"), walking_and_turning
    ):
        green = sharp[..., 1] == 1
        assert np.all(np.abs(velocity[green]).max(axis=-1) > 0.1)
        assert np.all(velocity[sharp[..., 2] == 1] == 0)
        assert np.any(blurred != sharp)


def test_a_thing_that_moves_along_with_the_eye_is_still(ctx):
    """Going at 30 m/s beside something that does 30 m/s: its velocity is that of neither."""
    frames = [standing(0), standing(1, avatar_pose=Pose((30 / 90, 0, 0)))]
    for sharp, _, velocity in last_eyes(ctx, ball(), streaks("head_cancelled"), frames):
        green, blue = sharp[..., 1] == 1, sharp[..., 2] == 1
        assert green.sum() > 20
        assert np.abs(velocity[green]).max() < 1e-3
        # 24 px per unit of slope, 1/3 m per frame at 6 m.
        np.testing.assert_allclose(velocity[blue][:, 0], -24 / 3 / 6, rtol=2e-3)


def test_a_hole_in_a_mask_has_the_velocity_of_what_is_behind(ctx):
    holes = still_life()
    grid = holes.materials[3]
    image = holes.images[grid.base_color_image]
    masked = replace(grid, base_color_image=0, emissive=(0.0, 1.0, 0.0))
    content = replace(
        sliding(
            at(0, 0.8, -6, mesh=(1,)),
            primitives=[wall(3), wall(12, 1)],
            materials=[masked, BLUE],
            place=(0.0, 0.8, -2),
        ),
        images=(image,),
    )
    for sharp, _, velocity in last_eyes(ctx, content, streaks("objects_only"), REST):
        middle = velocity[SIZE[1] // 2, SIZE[0] // 2]
        assert sharp[SIZE[1] // 2, SIZE[0] // 2, 2] == 1
        np.testing.assert_array_equal(middle, 0)
        solid = sharp[..., 1] == 1
        np.testing.assert_allclose(
            velocity[solid], [[24 * 30 / 90 / 2, 0]] * solid.sum(), rtol=2e-3
        )


def test_a_head_locked_thing_stays_sharp_before_a_world_that_rushes_by(ctx):
    nodes = [at(0, 0, -1, head_locked=True), at(0, 0.8, -4, mesh=(1,))]
    content = scene(nodes, [wall(0.5), wall(3, 1)], [GREEN, BLUE])
    frames = [standing(0), standing(1, 0.3, avatar_pose=Pose((0.5, 0, 0)))]
    for sharp, blurred, _ in last_eyes(ctx, content, streaks("full"), frames):
        green = sharp[..., 1] == 1
        assert green.sum() > 50
        np.testing.assert_array_equal(blurred[green], sharp[green])
        assert np.any(blurred != sharp)


GLOVE = Pose((0.0, -0.05, -0.5))
"""head-from-hand."""


def gloved(*others):
    """Return a scene with a green glove around the left hand before something blue."""
    nodes = [at(0, 0, 0, hand="left"), at(0, 0.8, -4, mesh=(1,)), *others]
    return scene(nodes, [wall(0.3), wall(9, 1)], [GREEN, BLUE])


def holding(index, yaw_rad=0.0, step_m=0.0, hand=GLOVE):
    """Return a frame of a head that has turned and moved, and of a hand before it."""
    head = Pose((step_m, 0.8, 0), yaw_pitch_roll(yaw_rad, 0, 0))
    return FrameAt(index, head, hands=(hand and head @ hand, None))


WITH_THE_HEAD = [holding(0), holding(1, 0.3, 0.1)]


@pytest.mark.parametrize("mode", get_args(MotionBlur.model_fields["mode"].annotation))
def test_a_hand_that_goes_with_the_head_is_sharp_in_every_mode(ctx, mode):
    """The cure: it counts as far as it moves in the head's frame."""
    for sharp, blurred, velocity in last_eyes(ctx, gloved(), streaks(mode), WITH_THE_HEAD):
        green = (sharp[..., 1] == 1) & (sharp[..., 2] == 0)
        assert green.sum() > 50
        np.testing.assert_allclose(velocity[green], 0, atol=1e-3)
        np.testing.assert_allclose(blurred[green], sharp[green], atol=1e-3)


@pytest.mark.parametrize(("mode", "blurs"), [("head_cancelled", True), ("full", False)])
def test_a_hand_that_counts_in_the_world_blurs_falsely_where_the_head_is_cancelled(
    ctx, mode, blurs
):
    """The article's false blur; with nothing cancelled, head and hand cancel each other."""
    condition = streaks(mode, hands="in_world")
    moved_px = 0.1 / 0.5 * SIZE[0] / 2 if blurs else 0
    for sharp, _, velocity in last_eyes(ctx, gloved(), condition, [holding(0), holding(1, 0, 0.1)]):
        green = (sharp[..., 1] == 1) & (sharp[..., 2] == 0)
        np.testing.assert_allclose(velocity[green], [[moved_px, 0]] * green.sum(), atol=4e-3)


@pytest.mark.parametrize("mode", ["full", "rotation_cancelled", "objects_only"])
def test_a_hand_that_waves_blurs_as_far_as_it_moves_before_the_head(ctx, mode):
    waved = Pose((0.02, -0.05, -0.5))
    frames = [holding(0), holding(1, 0.2, 0.1, hand=waved)]
    for sharp, _, velocity in last_eyes(ctx, gloved(), streaks(mode), frames):
        green = (sharp[..., 1] == 1) & (sharp[..., 2] == 0)
        expected_px = 0.02 / 0.5 * SIZE[0] / 2
        np.testing.assert_allclose(velocity[green], [[expected_px, 0]] * green.sum(), atol=2e-3)


@pytest.mark.parametrize(("name", "blurs"), [("in_world", True), ("with_head", False)])
def test_paddles_of_the_shipped_walk_blur_falsely_in_one_condition_of_the_protocol(
    ctx, name, blurs
):
    """Motion_blur_2020_hands, at the fastest turn of its walk: the paddles go with the head."""
    protocol = load_protocol("motion_blur_2020_hands")
    content, walk = load_scene("depths"), shipped_walk("depths")
    condition = next(each for each in protocol.conditions if each.name == name)
    forward = rotate(walk.head.orientations, np.array([[0.0, 0.0, -1.0]]))
    fastest = int(np.argmin(np.sum(forward[1:] * forward[:-1], axis=1)))
    frames = [walked(walk, fastest + step, step) for step in (0, 1)]
    unheld = [replace(frame, hands=(None, None)) for frame in frames]
    held = last_eyes(ctx, content, condition, frames)
    for (sharp, _, velocity), (empty, _, _) in zip(
        held, last_eyes(ctx, content, condition, unheld), strict=True
    ):
        paddles = np.any(sharp != empty, axis=-1)
        assert paddles.sum() > 20
        speed_px = np.linalg.norm(velocity[paddles], axis=1)
        assert (np.median(speed_px) > 1.0) == blurs
        assert (np.median(speed_px) < 0.5) != blurs


def walked(walk, sample, index):
    """Return what a trace has at a sample as a frame."""
    stage = walk.avatar.pose(sample)
    hands = tuple(stage @ hand.pose(sample) for hand in (walk.left_hand, walk.right_hand))
    return FrameAt(index, stage @ walk.head.pose(sample), avatar_pose=stage, hands=hands)


def test_a_hand_that_nobody_knows_is_not_drawn(ctx):
    """Not in its place in the file either, nor the moment it was last seen."""
    unknown = holding(1, hand=None)
    content = gloved(at(0, 0.02, 0, mesh=(0,), parent=0))
    seen = last_eyes(ctx, content, PLAIN, [holding(0)])
    gone = last_eyes(ctx, content, PLAIN, [holding(0), unknown])
    empty = last_eyes(ctx, scene([at(0, 0.8, -4)], [wall(9)], [BLUE]), PLAIN, [unknown])
    for (with_hand, *_), (without, *_), (expected, *_) in zip(seen, gone, empty, strict=True):
        assert np.any(with_hand[..., 1] == 1)
        np.testing.assert_array_equal(without, expected)


def test_where_head_and_hand_rest_nothing_is_drawn_for_motion_blur(primitives_drawn):
    rest = primitives_drawn(gloved(), streaks(), [holding(0), holding(1)])
    plain = primitives_drawn(gloved(), PLAIN, [holding(0), holding(1)])
    assert rest == plain
    waved = primitives_drawn(
        gloved(), streaks(), [holding(0), holding(1, hand=Pose((0.1, 0, -0.5)))]
    )
    assert waved > rest


def test_the_order_of_the_effects_decides_how_far_a_blurred_rim_reaches(ctx):
    """A near wall, still and out of focus, before a far one that is in focus and slides by.

    Nothing of the sliding wall can be seen to move, as it is blue all over. So where motion blur
    comes first, the rim is that of depth of field alone, but that what is behind the near wall is
    not drawn; where it comes second, the green light that depth of field has put on blue pixels
    goes with their streaks of 2 x 4 px.
    """
    content = sliding(
        at(-2, 0.8, -1, mesh=(1,)),
        primitives=[wall(40, 1), wall(4, 0)],
        materials=[GREEN, BLUE],
        per_s=(8 * 4 / 24 * 90, 0, 0),
        place=(-20.0, 0.8, -4),
    )
    lens = Condition(
        name="lens",
        focus=Focus(method="fixed", fixed_m=4.0),
        depth_of_field=DepthOfField(law="dioptre", full_blur_dioptre=0.5, max_radius_percent=6.0),
    )
    both = lens.model_copy(
        update={"motion_blur": streaks("full", max_radius_percent=20.0).motion_blur}
    )
    rows = {}
    for condition in (
        lens,
        both.model_copy(update={"name": "defocus_first"}),
        both.model_copy(
            update={"name": "streaks_first", "effect_order": ("motion_blur", "depth_of_field")}
        ),
    ):
        sharp, blurred, _ = last_eyes(ctx, content, condition, REST)[0]
        rows[condition.name] = blurred[SIZE[1] // 2, :, 1].astype(float)
    np.testing.assert_allclose(rows["streaks_first"], rows["lens"], atol=0.06)
    edge = int(np.argmax(sharp[SIZE[1] // 2, :, 1] < 0.5))  # the first blue pixel
    lens_row, reach = rows["lens"], int(np.flatnonzero(rows["lens"] > 1e-3)[-1])
    beyond = rows["defocus_first"][reach + 1 : reach + 3]
    assert np.all(beyond > 1e-3)
    # Taps on blue pixels only: green ones are nearer and keep still.
    expected = [lens_row[max(edge, x - 4) : x + 5].mean() for x in range(edge, edge + 12)]
    np.testing.assert_allclose(rows["defocus_first"][edge : edge + 12], expected, atol=0.04)


def test_streaks_fade_with_the_head_but_not_with_the_avatar(ctx):
    fade = {"fade_with_turning": TurnRamp(from_deg_s=10, to_deg_s=90)}
    content = scene([at(0, 0.8, -1.0)], [box(0.8)], [GREEN])
    carried = [
        FrameAt(i, Pose((0, 0.8, 0)), Pose(orientation=yaw_pitch_roll(0.1 * i, 0, 0)))
        for i in range(2)
    ]
    for frames, same in ((turned(), True), (carried, False)):
        for sharp, blurred, _ in last_eyes(ctx, content, streaks("full", **fade), frames):
            assert np.array_equal(sharp, blurred) == same


def test_speed_blur_is_alike_in_both_eyes_and_absent_at_rest(ctx, primitives_drawn):
    content = scene([at(0, 0.8, -50)], [wall(30)], [GREEN])  # no disparity: 24 px * 63 mm / 50 m
    fast = Condition(name="fast", speed_blur=SPEED)
    left, right = last_eyes(ctx, content, fast, turned())
    assert np.any(left[0] != left[1])
    np.testing.assert_allclose(left[1] - left[0], right[1] - right[0], atol=0.02)
    for frames in (REST, turned()[1:], [*turned(), standing(2, 0.0, discontinuity=True)]):
        for sharp, blurred, _ in last_eyes(ctx, content, fast, frames):
            np.testing.assert_array_equal(sharp, blurred)
        assert primitives_drawn(content, fast, frames) == primitives_drawn(content, PLAIN, frames)
    # Two passes for each eye, and nothing else.
    more = primitives_drawn(content, fast, turned())
    assert more == primitives_drawn(content, PLAIN, turned()) + 4


@pytest.mark.parametrize(
    "speed_blur", [None, SpeedBlur(), SPEED.model_copy(update={"max_sigma_arcmin": 0})]
)
def test_a_speed_blur_that_cannot_blur_owns_nothing(owned, speed_blur):
    condition = Condition(name="speed", speed_blur=speed_blur)
    assert owned(condition) == owned(PLAIN)
    planned = plan_passes(still_life(), condition)
    assert [item.needed for item in planned if item.name == "speed_blur"] == [False]


def test_all_programs_are_drawn_with_before_the_first_frame(ctx, count_primitives):
    """The first frame that moves finds its passes compiled, although the warm-up is at rest."""
    renderer = StereoRenderer(ctx, SIZE)
    fast = streaks("full").model_copy(update={"speed_blur": SPEED})
    plain, warm = (
        count_primitives(lambda: renderer.begin(still_life(), condition))  # noqa: B023 - called now
        for condition in (PLAIN, fast)
    )
    # A tile pass, neighbours, the averages of long streaks (in one
    # step: the image is narrow) and of short ones, a point for each of 3 x 3 tiles in which things
    # may pass each other; two Gaussians.
    # Of each eye.
    assert warm - plain == 2 * (1 + 1 + 2 + 9 + 2)


def turned_30_degrees(index, **known):
    """Return a frame after a turn of the avatar about the head, and 2 cm of walking."""
    turn = yaw_pitch_roll(np.radians(30), 0, 0)
    return standing(index, avatar_pose=Pose((0, 0, -0.02), turn), **known)


@pytest.mark.parametrize("mode", ["full", "head_cancelled", "rotation_cancelled"])
def test_a_snap_turn_leaves_no_streak_and_walking_does(ctx, mode):
    """Velocities of the frame are those of a walk of 2 cm, of somebody who had turned already."""
    before = {
        "snap": standing(0),
        "walk": standing(0, avatar_pose=Pose(orientation=yaw_pitch_roll(np.radians(30), 0, 0))),
    }
    velocities = {
        how: [
            velocity
            for *_, velocity in last_eyes(
                ctx, ball(), streaks(mode), [frame, turned_30_degrees(1, snap_turn=how == "snap")]
            )
        ]
        for how, frame in before.items()
    }
    for snap, walk in zip(*velocities.values(), strict=True):
        assert np.abs(walk).max() > 0.05
        np.testing.assert_allclose(snap, walk, atol=1e-3)
    smooth = last_eyes(ctx, ball(), streaks(mode), [standing(0), turned_30_degrees(1)])
    assert all(np.abs(velocity).max() > 10 for *_, velocity in smooth)


def test_a_snap_turn_is_no_speed(ctx):
    """Blur that grows with speed does not flash; the same turn, not told as one, blurs."""
    ramp = SpeedBlur(turning=SPEED.turning, max_sigma_arcmin=120)
    condition = Condition(name="speed", speed_blur=ramp)
    told, untold = (
        last_eyes(ctx, ball(), condition, [standing(0), turned_30_degrees(1, snap_turn=snap)])
        for snap in (True, False)
    )
    for (sharp, blurred, _), (_, flashed, _) in zip(told, untold, strict=True):
        np.testing.assert_array_equal(blurred, sharp)
        assert np.abs(flashed - sharp).max() > 0.05


def test_virtual_turning_alone_can_need_a_pass():
    """Objects only, in a scene in which nothing moves by itself."""
    still = scene([at(0, 0.8, -4)], [box()], [GREEN])
    reasons = {
        turning: next(
            item
            for item in plan_passes(still, streaks("objects_only", virtual_turning=turning))
            if item.name == "motion_blur"
        )
        for turning in ("by_mode", "kept")
    }
    assert not reasons["by_mode"].needed
    assert reasons["kept"].needed
    assert "virtual turning kept" in reasons["kept"].reason
