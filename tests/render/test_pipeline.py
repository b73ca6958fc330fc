import gc
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from tests.support.render import RIGHT_ANGLE, at, floor, glowing, scene, still_life, wall
from vrcomfort.geometry import Gaze, Pose, View, yaw_pitch_roll
from vrcomfort.gpu import gl
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.output import read_rgb8, read_texture
from vrcomfort.render.pipeline import StereoRenderer

SIZE = (48, 40)
PLAIN = Condition(name="plain")
DEFOCUS = Condition(name="dof", depth_of_field=DepthOfField(), focus=Focus(law="instant"))
STREAKS = Condition(name="mb", motion_blur=MotionBlur(mode="full"))
BOTH = DEFOCUS.model_copy(update={"name": "both", "motion_blur": STREAKS.motion_blur})


@dataclass(frozen=True)
class FrameAt:
    """A frame of a headset whose eyes look the way the head does."""

    index: int
    head_pose: Pose
    avatar_pose: Pose = field(default_factory=Pose)
    discontinuity: bool = False
    snap_turn: bool = False
    gaze: Gaze | None = None
    hands: tuple[Pose | None, Pose | None] = (None, None)

    @property
    def predicted_display_time_ns(self) -> int:
        return self.index * self.period_ns

    @property
    def period_ns(self) -> int:
        return 11_111_111

    @property
    def views(self) -> tuple[View, View]:
        eyes = [self.head_pose @ Pose((side * 0.0315, 0, 0)) for side in (-1, 1)]
        return View(eyes[0], RIGHT_ANGLE), View(eyes[1], RIGHT_ANGLE)


def standing(index: int, yaw_rad: float = 0.0, **settings) -> FrameAt:
    return FrameAt(index, Pose((0, 0.8, 0), yaw_pitch_roll(yaw_rad, 0, 0)), **settings)


def shown(ctx, content, condition, frames):
    """Return the last frame's two images."""
    renderer = StereoRenderer(ctx, SIZE)
    renderer.build(content, condition)
    for frame in frames:
        result = renderer.render(frame, frame.index / 90)
    return [read_rgb8(eye) for eye in result.eyes]


def needed(content, condition):
    return [item.name for item in plan_passes(content, condition) if item.needed]


def test_the_plan_holds_what_is_needed_and_gives_reasons():
    dark, lit = scene([], [], []), still_life()
    assert needed(dark, PLAIN) == ["scene", "tone_map"]
    assert needed(lit, PLAIN) == ["shadow", "scene", "tone_map"]
    assert needed(dark, DEFOCUS) == ["focus", "scene", "depth_of_field", "tone_map"]
    assert needed(dark, STREAKS) == ["scene", "velocity", "motion_blur", "tone_map"]
    swapped = BOTH.model_copy(update={"effect_order": ("motion_blur", "depth_of_field")})
    assert needed(dark, swapped)[-3:] == ["motion_blur", "depth_of_field", "tone_map"]
    assert all(item.reason for item in plan_passes(lit, BOTH))


@pytest.mark.parametrize(
    "condition",
    [
        DEFOCUS.model_copy(update={"depth_of_field": DepthOfField(max_radius_percent=0)}),
        STREAKS.model_copy(update={"motion_blur": MotionBlur(shutter_fraction=0)}),
    ],
)
def test_an_effect_of_zero_strength_has_no_pass(condition):
    assert needed(scene([], [], []), condition) == ["scene", "tone_map"]


@pytest.mark.smoke
def test_disabled_effects_own_nothing_on_the_gpu(ctx, count_objects):
    content = still_life()
    counts = {}
    for condition in (PLAIN, DEFOCUS, STREAKS, BOTH):
        before = count_objects()
        renderer = StereoRenderer(ctx, SIZE)
        renderer.begin(content, condition)
        after = count_objects()
        counts[condition.name] = {kind: after[kind] - before[kind] for kind in after}
        del renderer
    plain = counts["plain"]
    # Colour and depth, many samples and one; noise, tone-mapped images; shadow map; two arrays.
    # Each eye's colour, depth and image for the display.
    assert plain["Texture"] == 4 + 2 + 1 + 2 + 2 * 3
    for kind in ("Texture", "Framebuffer", "Program"):
        assert counts["dof"][kind] > plain[kind]
        assert counts["mb"][kind] > plain[kind]
    both, dof, streaks = (counts[name]["Texture"] for name in ("both", "dof", "mb"))
    assert both - plain["Texture"] == (dof - plain["Texture"]) + (streaks - plain["Texture"])


def test_beginning_again_releases_what_was_there(ctx, count_objects):
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(still_life(), BOTH)
    renderer.render(standing(0), 0.0)
    once = count_objects()
    for condition in (PLAIN, BOTH):
        renderer.begin(still_life(), condition)
        renderer.render(standing(0), 0.0)
    assert count_objects() == once


def test_the_same_frames_give_the_same_bytes(ctx):
    frames = [standing(index, 0.02 * index) for index in range(3)]
    first = shown(ctx, still_life(), BOTH, frames)
    second = shown(ctx, still_life(), BOTH, frames)
    np.testing.assert_array_equal(first, second)


def test_zero_strength_equals_the_pinhole_image(ctx):
    off = BOTH.model_copy(
        update={
            "depth_of_field": DepthOfField(max_radius_percent=0),
            "motion_blur": MotionBlur(shutter_fraction=0),
        }
    )
    frames = [standing(0), standing(1, 0.1)]
    np.testing.assert_array_equal(
        shown(ctx, still_life(), off, frames), shown(ctx, still_life(), PLAIN, frames)
    )


def test_eyes_see_disparity(ctx):
    content = scene([at(0, 0.8, -1)], [wall(0.5)], [glowing((1.0, 1.0, 1.0))])
    left, right = shown(ctx, content, PLAIN, [standing(0)])
    centers = [np.nonzero(image[20, :, 0] > 128)[0].mean() for image in (left, right)]
    # 63 mm at 1 m, 24 px per unit of slope.
    assert centers[0] - centers[1] == pytest.approx(1.5, abs=0.6)


def test_one_eye_alone_is_the_left_one_and_the_other_is_not_drawn(ctx):
    frame = standing(0)
    drawn, images, targets = [], [], []
    for eyes in (2, 1):
        renderer = StereoRenderer(
            ctx, SIZE, eyes=eyes, on_eye=lambda eye, _, eyes=eyes: drawn.append((eyes, eye))
        )
        renderer.begin(still_life(), BOTH)
        result = renderer.render(frame, 0.0)
        images.append([read_rgb8(eye) for eye in result.eyes])
        targets.append(sum(each.bytes for each in renderer.memory() if each.kind == "target"))
        del renderer, result
    assert drawn == [(2, 0), (2, 1), (1, 0)]
    width, height = SIZE  # colour, depth, velocity and the images of two effects, at least
    assert targets[0] - targets[1] > width * height * (8 + 4 + 4 + 2 * 8)
    assert np.array_equal(images[1][0], images[0][0])
    assert np.array_equal(images[1][1], images[0][0])


def test_motion_blur_smears_turns_but_not_after_a_cut(ctx):
    turn = [standing(0), standing(1, 0.2)]
    sharp = shown(ctx, still_life(), PLAIN, turn)
    smeared = shown(ctx, still_life(), STREAKS, turn)
    cut = shown(ctx, still_life(), STREAKS, [turn[0], replace(turn[1], discontinuity=True)])
    assert np.abs(np.subtract(smeared, sharp, dtype=int)).max() > 40
    np.testing.assert_array_equal(cut, sharp)


def test_focus_arrives_late_with_its_own_frame_index_and_none_is_lost(ctx):
    content = scene([at(0, 0.8, -2)], [wall(4)], [glowing((1.0, 1.0, 1.0))])
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(content, DEFOCUS)
    samples = []
    for index in range(6):
        samples += renderer.render(standing(index), 0.0).focus_samples
    assert len(samples) < 6
    samples += renderer.drain()
    assert [sample.frame_index for sample in samples] == list(range(6))
    assert all(sample.focus_m == pytest.approx(2, rel=1e-5) for sample in samples)


def test_each_eye_can_be_looked_at_before_the_next(ctx):
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(still_life(), BOTH)
    seen = {}
    renderer.render(standing(0), 0.0)
    renderer.render(
        standing(1, 0.1),
        0.01,
        on_eye=lambda index, images: seen.update(
            {index: [read_texture(t) for t in images if hasattr(t, "read")]}
        ),
    )
    assert sorted(seen) == [0, 1]
    assert all(np.isfinite(values).all() for images in seen.values() for values in images)
    assert not np.array_equal(seen[0][0], seen[1][0])


def test_what_nobody_sees_is_not_drawn(ctx):
    nodes = [at(0, 0.8, -3), at(0, 0.8, 3), at(0, 0, 0, mesh=(1,))]
    content = scene(nodes, [wall(1), floor()], [glowing((1.0, 1.0, 1.0))])
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(content, PLAIN)
    # Wall in front (2 triangles) and floor (2), for each eye; the wall behind is culled.
    assert renderer.render(standing(0), 0.0).triangles == 8


@pytest.mark.slow
def test_what_dies_leaves_other_contexts_alone():
    """Names of objects are counted in each context: those of one are those of another."""
    content, condition = still_life(), BOTH
    frames = [standing(0), standing(1)]
    first, second = gl.create_context(), gl.create_context()
    with first:
        renderer = StereoRenderer(first, SIZE)
        renderer.begin(content, condition)
    with second:
        expected = shown(second, content, condition, frames)
        other = StereoRenderer(second, SIZE)
        other.begin(content, condition)
        del renderer
        gc.collect()
        for frame in frames:
            result = other.render(frame, frame.index / 90)
        found = [read_rgb8(eye) for eye in result.eyes]
        gl.check_errors(second)
    np.testing.assert_array_equal(found, expected)


def test_the_first_frame_of_an_exposure_and_every_so_many_after_it_are_hashed(ctx):
    renderer = StereoRenderer(ctx, SIZE, hash_every=2)
    renderer.begin(still_life(), PLAIN)
    rendered = [renderer.render(FrameAt(n, Pose((0, 1.6, 0))), n / 90) for n in range(3)]
    assert [each.hashed for each in rendered] == [True, False, True]
