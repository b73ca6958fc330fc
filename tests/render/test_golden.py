from dataclasses import replace

import numpy as np
import pytest

from tests.support import golden_images
from tests.support.render import eye, still_life
from vrcomfort.frame import STIMULUS_VERSION
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.camera import PreviousCamera
from vrcomfort.render.display import noise_texture, tone_map_pass
from vrcomfort.render.output import read_rgb8, read_texture, side_by_side
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace

SIZE = (160, 120)


@pytest.mark.smoke
def test_golden_pixels_change_with_the_stimulus_version_alone():
    """A line for each picture, and one more for each version that changed it.

    Whoever changes golden pictures raises `vrcomfort.frame.STIMULUS_VERSION` and adds the lines.
    """
    lines = map(str.split, golden_images.VERSIONS.read_text("utf-8").splitlines())
    told: dict[str, dict[int, str]] = {}
    for name, version, sha256 in lines:
        assert int(version) not in told.get(name, {}), f"{name} has changed: raise the version"
        told.setdefault(name, {})[int(version)] = sha256
    assert max(version for each in told.values() for version in each) <= STIMULUS_VERSION
    last = {name: each[max(each)] for name, each in told.items()}
    assert golden_images.pixels_sha256() == last


@pytest.mark.smoke
def test_still_life(ctx, request, tmp_path):
    """Sun, shadow, lamp, fog, clouds, metal, normal map, mask, blend and velocity in one view."""
    scene_pass = ScenePass(ctx, still_life(), SIZE, velocity=True)
    tone_map = tone_map_pass(
        ctx,
        radiance=scene_pass.colour,
        blue_noise=noise_texture(ctx),
        size_px=SIZE,
        exposure=0.9,
    )
    camera = eye((0.1, 1.1, 0.2), yaw_pitch_roll(0.05, -0.1, 0.02))
    before = Pose((0.0, 1.1, 0.25), yaw_pitch_roll(0.0, -0.1, 0.0))
    scene_pass.render(camera, 0.0, PreviousCamera(before, 0.0))
    tone_map.render()
    golden_images.compare(request, ctx, tmp_path, "still_life", read_rgb8(tone_map.target))
    velocity = read_texture(scene_pass.velocity).astype(float)
    coded = np.clip(128 + 8 * velocity, 0, 255).astype(np.uint8)
    coded = np.concatenate([coded, np.zeros((*coded.shape[:2], 1), np.uint8)], axis=-1)
    golden_images.compare(request, ctx, tmp_path, "still_life_velocity", coded)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["temple", "mountain"])
def test_shipped_scene(ctx, request, tmp_path, name):
    """Both eyes of the second frame of the shipped walk under every effect."""
    scene = load_scene(name)
    blur = MotionBlur(mode="full", shutter_fraction=1.0)
    lens = DepthOfField(law="dioptre", full_blur_dioptre=1.0)
    renderer = StereoRenderer(ctx, (128, 160))
    renderer.begin(scene, Condition(name="both", depth_of_field=lens, motion_blur=blur))
    headset = PlaybackHeadset(
        read_trace(data_folder("scenes") / f"{name}_walk.csv"),
        image_size_px=(128, 160),
        refresh_hz=10,
        spawn=scene.spawn,
        max_frames=40,
    )
    for frame in list(headset.frames())[-2:]:
        left, right = renderer.render(frame, frame.index / 10).eyes
    golden_images.compare(
        request, ctx, tmp_path, name, side_by_side(read_rgb8(left), read_rgb8(right))
    )


BY_THE_CAIRN = Pose((1.2, 1.5, -1.9), yaw_pitch_roll(-0.56, -0.14, 0.0))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "head"), [("temple", None), ("mountain", BY_THE_CAIRN)])
def test_wide_discs(ctx, request, tmp_path, name, head):
    """Radii of up to 24 px in front of what is in focus, and of 10 px behind it."""
    scene, size_px = load_scene(name), (240, 240)
    lens = DepthOfField(law="dioptre", max_radius_percent=10.0, full_blur_dioptre=0.3)
    focus = Focus(method="fixed", fixed_m=8.0)
    renderer = StereoRenderer(ctx, size_px, eyes=1)
    renderer.begin(scene, Condition(name="wide", focus=focus, depth_of_field=lens))
    trace = read_trace(data_folder("scenes") / f"{name}_walk.csv")
    frame = next(iter(PlaybackHeadset(trace, image_size_px=size_px, spawn=scene.spawn).frames()))
    if head is not None:
        view = replace(frame.views[0], pose=head)
        frame = replace(frame, head_pose=head, avatar_pose=Pose(), views=(view, view))
    rendered = renderer.render(frame, 0.0)
    assert rendered.max_blur_px >= 20
    assert renderer.clamps()  # something is that much out of focus
    image = read_rgb8(rendered.eyes[0])
    golden_images.compare(request, ctx, tmp_path, f"{name}_wide_discs", image)
