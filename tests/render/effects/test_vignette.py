"""The field-of-view restrictor: how fast it closes, what it covers, and that both eyes agree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tests.oracles.vignette import angles_rad, cover
from tests.render.test_pipeline import SIZE, standing
from tests.support.effects import rgb_of, seen, textures
from tests.support.render import still_life
from vrcomfort.geometry import Fov, Pose, axis_angle
from vrcomfort.optics.motion import clear_deg, moved_towards, widest_angle_deg
from vrcomfort.protocol.conditions import EFFECTS, Condition, MoveRamp, TurnRamp, Vignette
from vrcomfort.render.camera import HeadStep
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.effects.vignette import VignettePass
from vrcomfort.render.pipeline import StereoRenderer

LEFT_EYE = Fov(left=-0.9, right=0.7, up=0.8, down=-0.8)
TURNING = TurnRamp(from_deg_s=0, to_deg_s=100)
CANTED = Pose((-0.03, 0.0, 0.0), axis_angle([0, 1, 0], np.radians(10)))
NOW = {"attack_s": 0.0, "release_s": 0.0}


def turning(deg_s, seconds=0.1):
    head = Pose(orientation=axis_angle([0, 1, 0], np.radians(deg_s * seconds)))
    return HeadStep(Pose(), head, Pose(), Pose(), seconds)


@pytest.fixture
def restrictor(ctx):
    """Return a function that makes a pass over random colours, and those."""

    def make(size_px=(64, 48), **settings):
        rgb = np.random.default_rng(1).uniform(0, 4, (size_px[1], size_px[0], 3)).astype("f2")
        colour, _ = textures(ctx, rgb, 2.0)
        wanted = Vignette(**settings)
        return VignettePass(EffectInputs(ctx, wanted, colour)), rgb

    return make


@pytest.mark.parametrize("head_from_eye", [Pose(), CANTED])
@pytest.mark.parametrize("feather_deg", [0.01, 12.0])
def test_pixels_are_covered_by_their_angle_from_the_heads_axis(
    restrictor, head_from_eye, feather_deg
):
    effect, rgb = restrictor(restricted_deg=50, feather_deg=feather_deg, turning=TURNING, **NOW)
    effect.render(seen(LEFT_EYE, head_from_eye=head_from_eye, step=turning(100)))
    angles = angles_rad(LEFT_EYE, (64, 48), head_from_eye)
    expected = rgb * (1 - cover(angles, 50, feather_deg))[..., None]
    np.testing.assert_allclose(rgb_of(effect.target), expected, atol=4e-3)
    clear = angles < np.radians(25) - 1e-3
    np.testing.assert_array_equal(rgb_of(effect.target)[clear], rgb[clear])


def test_a_field_wider_than_the_image_leaves_every_bit(restrictor):
    corner_deg = widest_angle_deg(LEFT_EYE, CANTED)
    angles_deg = np.degrees(angles_rad(LEFT_EYE, (999, 999), CANTED))
    assert corner_deg == pytest.approx(angles_deg.max(), abs=0.2)
    effect, rgb = restrictor(open_deg=min(2 * corner_deg + 0.01, 180), turning=TURNING)
    effect.render(seen(LEFT_EYE, head_from_eye=CANTED, step=turning(0)))
    np.testing.assert_array_equal(rgb_of(effect.target), rgb)


def test_the_field_closes_and_opens_at_its_own_rates(restrictor):
    effect, _ = restrictor(
        open_deg=100, restricted_deg=50, turning=TURNING, attack_s=0.5, release_s=1.0
    )
    found = []
    for frame, deg_s in enumerate((200, 200, 50, 50, 0, 0)):
        for eye_index in (0, 1):
            effect.render(
                seen(LEFT_EYE, eye_index=eye_index, time_ns=frame, step=turning(deg_s, 0.2))
            )
            found.append(effect.clear_deg)
    assert found[::2] == found[1::2]
    assert found[::2] == pytest.approx([80, 60, 70, 75, 85, 95])
    effect.render(seen(LEFT_EYE, time_ns=99))
    assert effect.clear_deg == 100, "a cut opens the field"


@given(
    st.floats(0, 1), st.floats(0, 1), st.lists(st.floats(0, 1), min_size=1, max_size=20),
    st.floats(0, 3), st.floats(0, 3),
)  # fmt: skip
def test_strength_depends_on_time_alone_not_on_frames(start, wanted, frames_s, attack_s, release_s):
    rates = {"attack_s": attack_s, "release_s": release_s}
    by_frames = start
    for elapsed_s in frames_s:
        by_frames = moved_towards(by_frames, wanted, elapsed_s=elapsed_s, **rates)
    at_once = moved_towards(start, wanted, elapsed_s=sum(frames_s), **rates)
    assert by_frames == pytest.approx(at_once, abs=1e-9)
    assert min(start, wanted) <= at_once <= max(start, wanted)


def test_the_clear_field_is_linear_in_the_strength():
    assert [clear_deg(110, 60, strength) for strength in (0, 0.5, 1)] == [110, 85, 60]


def test_the_cover_may_have_the_scenes_mean_colour_the_same_in_both_eyes(restrictor):
    """Sizes that no power of two divides: each pixel counts once."""
    effect, rgb = restrictor(
        (67, 45), restricted_deg=0, feather_deg=0.01, turning=TURNING, colour="scene", **NOW
    )
    effect.reset()
    effect.render(seen(LEFT_EYE, time_ns=0, step=turning(100)))  # the first moment of a trace
    left = rgb_of(effect.target)[0, 0]
    effect.render(seen(LEFT_EYE, eye_index=1, time_ns=0, step=turning(100)))
    np.testing.assert_array_equal(rgb_of(effect.target)[0, 0], left)
    np.testing.assert_allclose(left, rgb.mean(axis=(0, 1)), rtol=0.02)


def test_a_turning_head_loses_the_border_of_the_scene_and_nothing_of_its_middle(ctx):
    ramp = TurnRamp(from_deg_s=0, to_deg_s=1)
    restricted = Vignette(restricted_deg=40, feather_deg=1, turning=ramp, attack_s=0)
    eyes = {}
    for name, vignette in (("plain", None), ("restricted", restricted)):
        renderer = StereoRenderer(ctx, SIZE)
        renderer.build(still_life(), Condition(name=name, vignette=vignette))
        for frame in (standing(0), standing(1, 0.1)):
            rendered = renderer.render(frame, 0.0)
        eyes[name] = [
            np.frombuffer(eye.read(), "u1").reshape(SIZE[1], SIZE[0], 4)[..., :3]
            for eye in rendered.eyes
        ]
    middle = np.s_[SIZE[1] // 2 - 2 : SIZE[1] // 2 + 2, SIZE[0] // 2 - 2 : SIZE[0] // 2 + 2]
    for plain, image in zip(eyes["plain"], eyes["restricted"], strict=True):
        np.testing.assert_array_equal(image[middle], plain[middle])
        assert image[0, 0].max() == 0
        assert plain[0, 0].max() > 0


def test_a_field_that_widens_with_speed_is_refused():
    with pytest.raises(ValidationError, match="`restricted_deg` must not be more than `open_deg`"):
        Vignette(open_deg=50, restricted_deg=60, moving=MoveRamp(from_m_s=0, to_m_s=1))


def test_effects_come_in_the_conditions_order():
    chosen = Condition(name="c", effect_order=["vignette", "motion_blur"])
    assert chosen.effect_order == (
        "vignette", "motion_blur", "depth_of_field", "speed_blur", "relocation_blur",
    )  # fmt: skip
    assert Condition(name="c").effect_order == EFFECTS
    former = Condition(name="c", effect_order="motion_blur_first")
    assert former.effect_order[:2] == ("motion_blur", "depth_of_field")
    with pytest.raises(ValidationError, match="`vignette` is named more than once"):
        Condition(name="c", effect_order=["vignette", "vignette"])
    with pytest.raises(ValidationError, match="depth_of_field"):
        Condition(name="c", effect_order=["bloom"])
