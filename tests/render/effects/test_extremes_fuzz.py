"""Every shader at the ends of every range, from a seed: finite, and within its bound.

`pytest tests/render/effects/test_extremes_fuzz.py --extreme-cases 2000` tries more.
docs/extremes.md lists the bounds, and the cases of the last long run.
"""

from typing import get_args

import numpy as np
import pytest

from tests.oracles.motion import SPEED_LIMIT_PX
from tests.support.effects import rgb_of, seen, textures
from tests.support.extremes import (
    FOCUS_M,
    HALF_MAX,
    NEAREST_M,
    SIZES,
    SPEEDS_PX,
    choices,
    conditions,
    distances,
    drawn,
    every_choice,
    fov,
    frames,
    hdr,
    scene,
    turn,
)
from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.headset.eye_painter import EyePainter
from vrcomfort.protocol.conditions import (
    Condition,
    DepthOfField,
    Focus,
    MotionBlur,
    RefocusLawName,
)
from vrcomfort.render.display import TONE_CURVE, noise_texture
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.effects.motion_blur import MotionBlurPass
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder

ULP = 1 + 2**-10
"""A half float's rounding."""


@pytest.fixture
def cases(request, record_property):
    """Yield (number, rng) of as many cases as were asked for, and record how many."""
    wanted = request.config.getoption("--extreme-cases")
    record_property("cases", wanted)
    return [(number, np.random.default_rng([7, number])) for number in range(wanted)]


@pytest.mark.slow
def test_whole_frames(ctx, cases):
    """Scenes, focus, all effects in both orders, tone map: from poses to what the display gets."""
    every = conditions(np.random.default_rng(1))
    for number, rng in cases:
        condition = next(every)
        size_px, near_m = SIZES[number % len(SIZES)], float(rng.choice(NEAREST_M))
        renderer = StereoRenderer(ctx, size_px, near_m=near_m, samples=4)
        renderer.build(scene(rng), condition)
        samples = []
        # Without an eye tracker, some settings refuse to go on.
        centre = condition.gaze_centre
        stops = centre is not None and centre.without_gaze == "stop"
        tracked = condition.focus.without_gaze == "stop" or stops or rng.random() < 0.5
        for frame in frames(rng, tracked=tracked, length=2):
            rendered = renderer.render(
                frame,
                frame.predicted_display_time_ns * 1e-9,
                lambda _, images, condition=condition: check_images(images, condition),
            )
            samples += rendered.focus_samples
            for eye in rendered.eyes:
                assert np.isfinite(read_texture(eye)).all()
        for sample in (*samples, *renderer.drain()):
            check_focus(sample, condition.focus)
        assert all("nan" not in clamp and "inf" not in clamp for clamp in renderer.clamps())


def check_images(images, condition):
    sharp, blurred = (rgb_of(each).astype("f8") for each in (images.pinhole, images.linear))
    assert np.isfinite(sharp).all(), condition
    assert np.isfinite(blurred).all(), condition
    assert sharp.min() >= 0
    assert sharp.max() <= HALF_MAX
    assert blurred.min() >= 0, condition
    lens = condition.depth_of_field
    # They may see what is brighter than all that the pinhole does, and so may what is drawn behind.
    elsewhere = lens is not None and (lens.views > 1 or lens.kernel == "vrcomfort")
    # A cover may have the colour of what the other eye sees.
    covered = condition.vignette is not None and condition.vignette.colour == "scene"
    limit = HALF_MAX if elsewhere or covered else min(sharp.max() * ULP + 1e-7, HALF_MAX)
    assert blurred.max() <= limit, condition
    depth = read_texture(images.depth)
    assert (depth >= 0).all()
    assert (depth <= 1).all()
    if images.velocity is not None:
        speed = np.linalg.norm(read_texture(images.velocity)[..., :2].astype("f8"), axis=-1)
        assert (speed <= SPEED_LIMIT_PX * ULP).all(), "finite too: NaN is not at most anything"


def check_focus(sample, focus):
    scripted = [distance_m for _, distance_m in focus.script]
    farthest_m = max(focus.infinity_m, focus.fixed_m, *scripted) * (1 + 1e-6)
    assert 0 < sample.focus_m <= farthest_m
    assert 0 < sample.focus_raw_m <= farthest_m


@pytest.mark.slow
def test_depth_of_field(ctx, cases):
    """Each kernel: no brighter and no darker than what it was given, colour by colour."""
    for number, rng in cases:
        width, height = SIZES[number % len(SIZES)]
        kernels = [value for path, value in choices_of_kernels()]
        settings = drawn(
            DepthOfField,
            rng,
            [(("kernel",), kernels[number % len(kernels)]), (("views",), 1)],
        )
        near_m = float(rng.choice(NEAREST_M))
        rgb = hdr(rng, (height, width, 3))
        # As one of many views, discs of a few pixels have a kernel of their own.
        settings = settings.model_copy(update={"views": int(rng.choice([1, 256]))})
        colour, depth = textures(
            ctx, rgb, np.maximum(distances(rng, (height, width)), near_m), near_m
        )
        lens_m = settings.focal_length_m
        focus_m = rng.choice([*FOCUS_M, lens_m, 1.001 * lens_m, np.inf, np.nan])
        focus = gl.color_texture(ctx, (1, 1), dtype="f4")
        focus.write(np.full(4, focus_m, "f4").tobytes())
        effect = DepthOfFieldPass(
            EffectInputs(ctx, settings, colour, {"depth": depth, "focus": focus})
        )
        eye = Pose(rng.uniform(-0.1, 0.1, 3), turn(rng, 0.5))
        effect.render(seen(fov(rng), near_m=near_m, head_from_eye=eye))
        check_between(rgb_of(effect.target), rgb_of(colour), (settings, focus_m))


def choices_of_kernels():
    return [each for each in choices(DepthOfField) if each[0] == ("kernel",)]


def check_between(found, given, what):
    assert np.isfinite(found).all(), what
    low, high = given.min(axis=(0, 1)).astype("f8"), given.max(axis=(0, 1)).astype("f8")
    assert (found <= np.minimum(high * ULP + 1e-7, HALF_MAX)).all(), what
    assert (found >= low / ULP - 1e-7).all(), what


def test_motion_blur(ctx, cases):
    """Speeds to 1e5 px and beyond what half floats hold: between the darkest and the brightest."""
    for number, rng in cases:
        width, height = SIZES[number % len(SIZES)]
        settings = drawn(MotionBlur, rng)
        rgb = hdr(rng, (height, width, 3))
        colour, depth = textures(ctx, rgb, distances(rng, (height, width)), 0.002)
        velocity = gl.color_texture(ctx, (width, height), components=2)
        speed = rng.choice(SPEEDS_PX, (height, width, 1)) * rng.normal(size=(height, width, 2))
        with np.errstate(over="ignore"):
            field = speed.astype("f2")
        field[rng.random((height, width)) < 0.1] = rng.choice([np.nan, np.inf, -np.inf])
        velocity.write(field.tobytes())
        effect = MotionBlurPass(
            EffectInputs(ctx, settings, colour, {"depth": depth, "velocity": velocity})
        )
        effect.render(seen())
        check_between(rgb_of(effect.target), rgb_of(colour), settings)
        assert all("nan" not in clamp for clamp in effect.clamps())


def test_tone_map(ctx, cases):
    """Any radiance, no numbers too: within [0, 1]."""
    for number, rng in cases:
        width, height = SIZES[number % len(SIZES)]
        rgb = hdr(rng, (height, width, 3))
        rgb[rng.random(rgb.shape) < 0.05] = rng.choice([np.nan, np.inf])
        colour, _ = textures(ctx, rgb, 1.0)
        tone_map = FullscreenPass(
            ctx,
            "display/tone_map.frag",
            defines=TONE_CURVE,
            size_px=(width, height),
            inputs={"radiance": colour, "blue_noise": noise_texture(ctx)},
            constants={"exposure": float(10.0 ** rng.uniform(-4, 4))},
            dtype="f4",
        )
        tone_map.render()
        encoded = read_texture(tone_map.target)
        assert np.isfinite(encoded).all()
        assert encoded.min() >= 0
        assert encoded.max() <= 1
        assert (encoded[..., 3] == 1).all()


def test_picture(ctx, cases):
    """A panel anywhere, also behind or through the eye: no colour that the picture has not."""
    painter = EyePainter(ctx)
    for number, rng in cases:
        size_px = SIZES[number % len(SIZES)]
        picture = gl.color_texture(ctx, (4, 4), dtype="f1")
        texels = rng.integers(0, 256, (4, 4, 4), dtype=np.uint8)
        texels[..., 3] = 255
        picture.write(texels.tobytes())
        target = gl.color_texture(ctx, size_px)
        framebuffer = ctx.framebuffer([target])
        with ctx.scope(framebuffer):
            framebuffer.clear()
            with np.errstate(over="ignore"):
                matrix = rng.normal(size=(4, 4)) * 10.0 ** rng.uniform(-6, 30)
            painter._draw(picture, matrix)
        found = rgb_of(target).astype("f8")
        assert np.isfinite(found).all()
        assert found.min() >= 0
        assert found.max() <= texels[..., :3].max() / 255 * ULP


@pytest.mark.slow
def test_two_frames_at_a_headsets_size(ctx):
    rng = np.random.default_rng(3)
    condition = next(conditions(rng))
    condition = condition.model_copy(
        update={"depth_of_field": DepthOfField(samples=16), "motion_blur": MotionBlur(samples=2)}
    )
    renderer = StereoRenderer(ctx, (1832, 1920), samples=2, eyes=1)
    renderer.build(scene(rng), condition)
    for frame in frames(rng, tracked=True, length=2):
        renderer.render(frame, 0.0, lambda _, images: check_images(images, condition))
    renderer.drain()


@pytest.mark.slow
def test_every_shader_is_tried_here(ctx, monkeypatch):
    """A new shader is reached by a setting, which is tried without doing anything, or needs a test.

    Those of whole frames are compiled for every value of every choice that settings have.
    """
    read = {
        "display/picture.vert",
        "display/picture.frag",  # tried above
        *("common/copy.frag", "scene/hidden_tiles.vert"),  # render/test_visibility_mask.py
        "display/image_hash.comp",  # sums whole numbers of any pixels: render/test_image_hash.py
    }
    source = shaders.source
    monkeypatch.setattr(shaders, "source", lambda name: (read.add(name), source(name))[1])
    rng = np.random.default_rng(2)
    wide = Condition(name="wide", depth_of_field=DepthOfField(max_radius_percent=5))
    few = Condition(name="few", depth_of_field=DepthOfField(samples=16))
    half = Condition(name="half", depth_of_field=DepthOfField(samples=12, max_radius_percent=5))
    focus = Focus(method="autofocus_zone")
    zone = Condition(name="zone", focus=focus, depth_of_field=DepthOfField())
    order = ("motion_blur", "depth_of_field")
    later = zone.model_copy(update={"motion_blur": MotionBlur(), "effect_order": order})
    laws = [
        Condition(name=law, focus=Focus(law=law), depth_of_field=DepthOfField())
        for law in get_args(RefocusLawName)
    ]
    for condition in (*every_choice(rng), *laws, wide, few, half, zone, later):
        # Wide enough for discs of every kind.
        renderer = StereoRenderer(ctx, (320, 5), headset_depth="blur_aware")
        renderer.build(scene(rng), condition)
        renderer.release()
    folder = data_folder("shaders")
    there = {str(file.relative_to(folder)) for file in folder.rglob("*.*")}
    assert there - read == set()
