"""Both eyes are drawn at once: each has the picture that it has alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.render import still_life
from vrcomfort.geometry import Fov, HiddenArea, Pose, View, yaw_pitch_roll
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.traffic import TrafficCounter
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.output import read_rgb8, read_texture
from vrcomfort.render.pipeline import StereoRenderer, looks_around

SIZE = (72, 80)
FOVS = Fov(-0.85, 0.7, 0.75, -0.8), Fov(-0.65, 0.9, 0.7, -0.9)
"""No headset's eyes are as different."""
CANTED = tuple(
    Pose((side * 0.032, 0.01 * side, -0.01), yaw_pitch_roll(-0.1 * side, 0.03 * side, 0.02 * side))
    for side in (-1, 1)
)
CORNERS = np.array([[-1.5, -1.5], [-0.2, -1.5], [-1.5, -0.2], [1.5, 1.5], [0.3, 1.5], [1.5, 0.1]])
HIDDEN = tuple(
    HiddenArea(np.float32(CORNERS * [side, 1]), np.arange(6, dtype=np.uint32).reshape(2, 3))
    for side in (1, -0.8)
)

DEFOCUS = {"law": "dioptre", "full_blur_dioptre": 0.5, "max_radius_percent": 6.0, "samples": 36}
FAR = {"method": "fixed", "fixed_m": 9.0}
STREAKS = {"mode": "full", "shutter_fraction": 1.0}
SPEED = {"turning": {"from_deg_s": 0, "to_deg_s": 30}, "max_sigma_arcmin": 60}
EFFECTS = {
    "near": {"depth_of_field": DEFOCUS, "focus": FAR},
    "half": {"depth_of_field": DEFOCUS | {"samples": 12}, "focus": FAR},
    "both": {"depth_of_field": DEFOCUS, "focus": FAR, "motion_blur": STREAKS},
    "streaks_first": {
        "depth_of_field": DEFOCUS | {"distance_along": "ray", "peripheral": {}},
        "motion_blur": STREAKS,
        "effect_order": ["motion_blur", "depth_of_field"],
    },
    "views": {"depth_of_field": DEFOCUS | {"views": 3, "samples": 12}, "motion_blur": STREAKS},
    "field": {"vignette": {"open_deg": 50, "restricted_deg": 40}, "speed_blur": SPEED},
    "scatter": {"depth_of_field": DEFOCUS | {"kernel": "scatter"}},
    "gaussian": {"depth_of_field": DEFOCUS | {"kernel": "separable_gaussian"}},
}


def frames(eyes):
    """Return two frames of a head that turns and walks, seen by these eyes."""
    start, _ = looks_around(Pose((0.0, 0.0, 0.5)))
    for index in range(2):
        head = Pose((0.02 * index, 1.0, 0.01 * index), yaw_pitch_roll(0.03 * index, -0.1, 0.01))
        views = tuple(View(head @ CANTED[eye], FOVS[eye]) for eye in eyes)
        yield replace(
            start, index=index, predicted_display_time_ns=11_111_111 * index, period_ns=11_111_111,
            head_pose=head, views=views, discontinuity=False,
        )  # fmt: skip


def drawn(ctx, effects, seen_by, size_px=SIZE, **settings):
    """Return all images of the second frame by eye and name."""
    renderer, found = StereoRenderer(ctx, size_px, **settings), {}
    renderer.build(still_life(), Condition.model_validate({"name": "c", **effects}))

    def keep(eye, images):
        found[eye] = {
            name: read_texture(image)
            for name, image in images._asdict().items()
            if hasattr(image, "read")
        }

    for frame in frames(seen_by):
        found["shown"] = [read_rgb8(eye) for eye in renderer.render(frame, 0.0, keep).eyes]
    return found


def assert_same(found, expected):
    assert found.keys() == expected.keys()
    for name, image in expected.items():
        np.testing.assert_array_equal(found[name], image, err_msg=name)


@pytest.mark.parametrize("name", EFFECTS)
def test_each_eye_has_the_picture_that_it_has_alone(ctx, name):
    both = drawn(ctx, EFFECTS[name], (0, 1), headset_depth="blur_aware")
    for eye in (0, 1):
        alone = drawn(ctx, EFFECTS[name], (eye, eye), headset_depth="blur_aware", eyes=1)
        assert_same(both[eye], alone[0])
        np.testing.assert_array_equal(both["shown"][eye], alone["shown"][0])
    assert not np.array_equal(both["shown"][0], both["shown"][1])


def test_near_things_of_one_eye_change_nothing_in_the_other(ctx):
    """At this size something is behind near things in the left eye, and nothing in the right."""
    odd = (37, 53)
    both = drawn(ctx, EFFECTS["near"], (0, 1), odd)
    for eye in (0, 1):
        assert_same(both[eye], drawn(ctx, EFFECTS["near"], (eye, eye), odd, eyes=1)[0])


@pytest.mark.parametrize(
    ("name", "hidden"),
    [("both", HIDDEN), ("half", (None, None)), ("views", (None, None)), ("field", HIDDEN)],
)
def test_drivers_without_layers_draw_one_eye_after_the_other(ctx, monkeypatch, name, hidden):
    at_once = drawn(ctx, EFFECTS[name], (0, 1), hidden=hidden)
    monkeypatch.setattr(gl, "eyes_at_once", lambda _: None)
    in_turn = drawn(ctx, EFFECTS[name], (0, 1), hidden=hidden)
    np.testing.assert_array_equal(at_once["shown"], in_turn["shown"])


def test_a_pass_of_both_eyes_is_one_draw_and_reads_each_layer(ctx):
    source = gl.eye_texture(ctx, (4, 2), 2)
    light = np.random.default_rng(3).uniform(0, 1, (2, 2, 4, 4)).astype(np.float16)
    light[..., 3] = 1
    source.write(light.tobytes())
    copy = FullscreenPass(
        ctx, "depth_of_field/scaled_copy.frag", size_px=(4, 2), inputs={"image": source},
        constants={"share": 1.0},
    )  # fmt: skip
    with watched(counter := TrafficCounter(ctx)):
        copy.render()
    (one,) = counter.drawn
    assert (one.draws, one.samples, one.bytes) == (1, 16, 2 * 16 * 8)
    assert copy.target.read() == light.tobytes()
    for eye in (0, 1):
        alone = read_texture(gl.of_eye(copy.target, eye))
        np.testing.assert_array_equal(alone, light[eye, ::-1])


def test_depth_of_both_eyes_is_drawn_cleared_and_read(ctx):
    depth = gl.eye_depth(ctx, (3, 2), 2)
    gl.framebuffer(ctx, [], depth).clear(depth=0.25)
    right = gl.of_eye(depth, 1)
    gl.framebuffer(ctx, [], right).clear(depth=0.75)
    assert np.unique(np.frombuffer(gl.read(depth), np.float32)).tolist() == [0.25, 0.75]
    assert np.unique(read_texture(right)).tolist() == [0.75]
