"""Motion effects in whole frames: what moves, what is left out, which comes first."""

from dataclasses import replace

import numpy as np
import pytest
from test_render_pipeline import SIZE, FrameAt, standing

from tests.support.render import at, box, glowing, scene, still_life, wall
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.protocol.conditions import (
    Condition,
    DepthOfField,
    Focus,
    MotionBlur,
    MoveRamp,
    SpeedBlur,
    TurnRamp,
)
from vrcomfort.render.pipeline import StereoRenderer, plan_passes
from vrcomfort.render.reference import read_rgb
from vrcomfort.scene.animation import Animation, Channel

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
    renderer.begin(content, condition)

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
        renderer.begin(content, condition)
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


def test_the_order_of_the_effects_decides_how_far_a_blurred_rim_reaches(ctx):
    """A near wall, still and out of focus, before a far one that is in focus and slides by.

    Nothing of the sliding wall can be seen to move, as it is blue all over. So where motion blur
    comes first, the rim is that of depth of field alone; where it comes second, the green light
    that depth of field has put on blue pixels goes with their streaks of 2 x 4 px.
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
    np.testing.assert_array_equal(rows["streaks_first"], rows["lens"])
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
    # Two tile passes, their peak over 3 x 3 tiles, neighbours, the plain average, a point for each
    # tile in which things may pass each other; two Gaussians.
    assert warm - plain == 2 + 9 + 1 + 1 + 9 + 2
