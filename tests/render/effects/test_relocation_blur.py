"""The blur at a relocation: how blurred it is, for how long, and that both eyes agree."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.mip_level import at_level
from tests.render.test_pipeline import SIZE, standing
from tests.support.effects import rgb_of, seen, textures
from tests.support.render import still_life
from vrcomfort.geometry import Pose
from vrcomfort.optics.motion import level_after
from vrcomfort.protocol.conditions import Condition, RelocationBlur
from vrcomfort.render.camera import HeadStep
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.effects.relocation_blur import RelocationBlurPass
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.output import read_rgb8
from vrcomfort.render.pipeline import StereoRenderer

RESTING = HeadStep(Pose(), Pose(), Pose(), Pose(), 1 / 90)
SECOND_NS = 1_000_000_000
ODD_PX = (67, 45)
"""No power of two divides it."""


@pytest.fixture
def relocation(ctx):
    """Return a function that makes a pass over random colours, and those."""

    def make(size_px=ODD_PX, rgb=None, **settings):
        if rgb is None:
            rgb = np.random.default_rng(1).uniform(0, 4, (size_px[1], size_px[0], 3))
        rgb = rgb.astype("f2")
        colour, _ = textures(ctx, rgb, 2.0)
        wanted = RelocationBlur(**settings)
        return RelocationBlurPass(EffectInputs(ctx, wanted, colour)), rgb

    return make


def after_cut(effect, elapsed_s):
    """Return the image some time after a cut."""
    effect.render(seen(time_ns=5 * SECOND_NS))
    if elapsed_s:
        effect.render(seen(time_ns=5 * SECOND_NS + round(elapsed_s * 1e9), step=RESTING))
    return rgb_of(effect.target)


@pytest.mark.parametrize(
    ("level", "share_left"), [(0.3, 1.0), (1.0, 0.75), (2.5, 1.0), (6.0, 0.75), (6.0, 0.1)]
)
def test_the_image_is_that_of_a_level_which_falls_with_time(relocation, level, share_left):
    effect, rgb = relocation(level=level, duration_s=2.0)
    found = after_cut(effect, 2 * (1 - share_left))
    np.testing.assert_allclose(found, at_level(rgb.astype(float), level * share_left), atol=8e-3)


def test_a_sharp_image_is_not_changed_in_any_bit(relocation):
    effect, rgb = relocation(duration_s=0.5)
    np.testing.assert_array_equal(after_cut(effect, 0.5), rgb)
    effect.reset()
    effect.render(seen(time_ns=99 * SECOND_NS, step=RESTING))
    np.testing.assert_array_equal(rgb_of(effect.target), rgb)


@pytest.mark.parametrize("value", [0.0, 1 / 3, 65504.0])
def test_an_even_image_stays_even(relocation, value):
    effect, rgb = relocation(rgb=np.full((45, 67, 3), value), level=4.7)
    np.testing.assert_allclose(after_cut(effect, 0.05), rgb, rtol=1e-3)


@given(
    st.floats(0, 9), st.floats(0.001, 10), st.lists(st.floats(0, 3), min_size=1, max_size=9),
)  # fmt: skip
def test_the_level_only_falls_and_ends_at_zero(level, duration_s, times_s):
    found = [level_after(level, elapsed_s=t, duration_s=duration_s) for t in sorted(times_s)]
    assert found == sorted(found, reverse=True)
    assert level_after(level, elapsed_s=0, duration_s=duration_s) == level
    assert level_after(level, elapsed_s=duration_s, duration_s=duration_s) == 0
    assert level_after(level, elapsed_s=duration_s / 4, duration_s=duration_s) == pytest.approx(
        0.75 * level
    )


def test_frames_between_change_nothing(relocation):
    """Few frames or many: the same image at the same time."""
    pictures = []
    for frames in (1, 2, 16):
        effect, _ = relocation(duration_s=1.0)
        effect.render(seen(time_ns=0))
        for number in range(1, frames + 1):
            time_ns = SECOND_NS * number // (2 * frames)
            for eye_index in (0, 1):
                effect.render(seen(eye_index=eye_index, time_ns=time_ns, step=RESTING))
        pictures.append(rgb_of(effect.target))
    np.testing.assert_array_equal(pictures[0], pictures[1])
    np.testing.assert_array_equal(pictures[0], pictures[2])


@pytest.mark.parametrize("counts", [True, False])
def test_snap_turns_are_relocations_where_the_condition_says_so(relocation, counts):
    effect, rgb = relocation(snap_turns=counts)
    np.testing.assert_array_equal(after_cut(effect, 1.0), rgb)
    snap = RESTING._replace(snap_turn=True)
    for eye_index in (0, 1):
        effect.render(seen(eye_index=eye_index, time_ns=9 * SECOND_NS, step=snap))
        blurred = rgb_of(effect.target)
        assert np.array_equal(blurred, rgb) is not counts


def test_a_session_sharpens_after_each_cut_in_both_eyes(ctx):
    """A frame lasts 11.1 ms, the blur 30 ms: four frames after a cut it is over."""
    blur = RelocationBlur(level=3, duration_s=0.03)
    frames = [standing(index, discontinuity=index in (0, 5)) for index in range(10)]
    shown = {}
    for name, settings in (("plain", None), ("blurred", blur)):
        renderer = StereoRenderer(ctx, SIZE)
        renderer.build(still_life(), Condition(name=name, relocation_blur=settings))
        shown[name] = [
            [read_rgb8(eye).astype(int) for eye in renderer.render(frame, 0.0).eyes]
            for frame in frames
        ]
    for eye in (0, 1):
        error = [np.abs(a[eye] - b[eye]).mean() for a, b in zip(*shown.values(), strict=True)]
        for cut in (0, 5):
            assert error[cut] > error[cut + 1] > error[cut + 2] > 0.1
            assert error[cut + 3 : cut + 5] == [0, 0]
        assert error[:5] == error[5:]


def test_the_plan_says_how_blurred_and_for_how_long():
    condition = Condition(name="c", relocation_blur=RelocationBlur(level=4, snap_turns=True))
    (found,) = [
        item for item in plan_passes(still_life(), condition) if item.name == "relocation_blur"
    ]
    assert found.needed
    assert found.reason == "MIP level 4 at a cut or a snap turn, sharp after 0.5 s"
