"""What lies behind near things is drawn, and they over it: only where something is near."""

from contextlib import nullcontext

import numpy as np
import pytest

from tests.support.render import RIGHT_ANGLE, at, glowing, scene, wall
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, View
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.traffic import TrafficCounter
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus
from vrcomfort.render.effects.depth_of_field import effect
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.reference import read_rgb

SIZE_PX = (128, 128)
FOCUS_M = 2.0
LENS = {"law": "dioptre", "max_radius_percent": 10.0, "full_blur_dioptre": 2.0}
"""6.4 px of radius for each dioptre: 12.8 px at half a metre, 4.6 px at 0.82 m."""


def stripes(near_m=0.5, width_m=0.04):
    """A bar from top to bottom before stripes of 4 px, which are in focus."""
    bar = at(0.01, 0.0, -near_m, mesh=(0,), scale=np.array([width_m, 2.0, 1.0]))
    far = [
        at(x, 0.0, -FOCUS_M, mesh=(1 + i % 2,), scale=np.array([1 / 8, 6.0, 1.0]))
        for i, x in enumerate(np.arange(-2.5, 2.5, 1 / 8))
    ]
    colours = [(0.9, 0.2, 0.1), (0.05, 0.3, 0.8), (0.2, 0.9, 0.4)]
    return scene([bar, *far], [wall(1, i) for i in range(3)], [glowing(c) for c in colours])


def condition(focus=None, **settings):
    focus = focus or Focus(method="fixed", fixed_m=FOCUS_M)
    return Condition(name="x", focus=focus, depth_of_field=DepthOfField(**LENS, **settings))


def look(index=0):
    eye = View(Pose(), RIGHT_ANGLE)
    return Frame(index, index * 11_111_111, 11_111_111, Pose(), (eye, eye), Pose())


def drawn(ctx, content, wanted, frames=1, *, watch=True):
    """Return the last frame's left eye: pinhole, result and depth, and the passes of that frame."""
    found = {}

    def keep(eye, images):
        if eye == 0:
            depth = np.frombuffer(images.depth.read(), np.float32)
            found.update(pinhole=read_rgb(images.pinhole), linear=read_rgb(images.linear))
            found["depth"] = depth.reshape(SIZE_PX[::-1])

    renderer = StereoRenderer(ctx, SIZE_PX)
    renderer.begin(content, wanted)
    for index in range(frames):
        counter = TrafficCounter(ctx)
        with watched(counter) if watch else nullcontext():
            renderer.render(look(index), index / 90, keep)
    renderer.release()
    return found, [each.declared.name for each in counter.drawn if each.samples]


@pytest.mark.parametrize("samples", [16, 36, 96])
def test_what_a_near_bar_hides_is_what_the_lens_sees(ctx, monkeypatch, samples):
    """Of the error inside the bar's disc less than half is left, and no outline."""
    content = stripes()
    true = drawn(ctx, content, condition(views=256))[0]["linear"]
    ours = drawn(ctx, content, condition(samples=samples))[0]["linear"]
    monkeypatch.setattr(effect, "BEHIND_PX", 1e9)
    alone = drawn(ctx, content, condition(samples=samples))[0]["linear"]
    near = np.s_[20:-20, 48:82]
    left, before = (np.sqrt(np.mean((each - true)[near] ** 2)) for each in (ours, alone))
    assert left < 0.5 * before


def test_pinhole_and_depth_stay_those_of_what_is_near(ctx):
    """The headset's depth layer, motion blur and files read them."""
    plain = drawn(ctx, stripes(), Condition(name="plain"))[0]
    found, names = drawn(ctx, stripes(), condition())
    assert "depth_of_field/near_over.frag" in names
    np.testing.assert_array_equal(found["pinhole"], plain["pinhole"])
    np.testing.assert_array_equal(found["depth"], plain["depth"])


def test_where_nothing_is_near_nothing_is_drawn_for_it(ctx, monkeypatch):
    content = stripes(near_m=1.9)  # 0.17 px
    found, names = drawn(ctx, content, condition())
    again = {"near_layer", "near_limit", "near_gather", "near_over", "near_depth"}
    assert not [name for name in names if any(part in name for part in again)]
    monkeypatch.setattr(effect, "BEHIND_PX", 1e9)
    np.testing.assert_array_equal(found["linear"], drawn(ctx, content, condition())[0]["linear"])


@pytest.mark.parametrize("near_m", [0.5, 1.9])
def test_the_gpu_decides_as_those_do_who_watch(ctx, near_m):
    content = stripes(near_m)
    seen, counted = (drawn(ctx, content, condition(), watch=watch)[0] for watch in (False, True))
    np.testing.assert_array_equal(seen["linear"], counted["linear"])


def test_inside_a_wide_near_thing_nothing_shines_through(ctx):
    """A wall of one colour, wider than its discs, has that colour where the lens sees only it."""
    found = drawn(ctx, stripes(width_m=0.5), condition())[0]
    middle = found["linear"][20:-20, 54:74]
    np.testing.assert_allclose(middle, np.broadcast_to(middle[0, 0], middle.shape), rtol=2e-3)
    np.testing.assert_allclose(middle[0, 0], (0.9, 0.2, 0.1), rtol=3e-3)


def test_autofocus_leaves_out_what_a_fixed_focus_does(ctx):
    """The GPU alone knows where it is: at the bar's 2 m away surroundings, or wherever."""
    rays = Focus(method="nine_ray", law="instant")
    content = stripes(width_m=0.004)  # the rays pass beside it
    fixed, found = (drawn(ctx, content, condition(focus), frames=2) for focus in (None, rays))
    assert "depth_of_field/near_over.frag" in found[1]
    np.testing.assert_allclose(found[0]["linear"], fixed[0]["linear"], atol=0.02)
