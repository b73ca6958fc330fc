"""Only what a scene and a condition require is there: counted in passes, objects, bytes and draws.

`bench/requires.py` measures what it costs.
"""

from contextlib import contextmanager
from dataclasses import replace

import moderngl
import pytest

from tests.render.test_pipeline import SIZE, standing
from tests.support.render import still_life
from vrcomfort.gpu import memory as gpu_memory
from vrcomfort.protocol.conditions import (
    BackgroundBlur,
    Condition,
    DepthOfField,
    Focus,
    MotionBlur,
    RelocationBlur,
    SpeedBlur,
    TurnRamp,
    Vignette,
)
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Node

PLAIN = Condition(name="plain")
ZERO_TURN = TurnRamp(from_deg_s=0, to_deg_s=10)

TURNING = (standing(0), standing(1, 0.1))
RESTING = (standing(0), standing(1))

NOTHING_TO_BLUR = {
    "no disc": {"depth_of_field": DepthOfField(max_radius_percent=0)},
    "no opening": {"depth_of_field": DepthOfField(law="eye", pupil_mm=0)},
    "no exposure": {"motion_blur": MotionBlur(shutter_fraction=0)},
    "nothing moves by itself": {"motion_blur": MotionBlur(mode="objects_only")},
    "no blur at any speed": {"speed_blur": SpeedBlur(max_sigma_arcmin=0, turning=ZERO_TURN)},
    "no speed counts": {"speed_blur": SpeedBlur()},
    "nothing narrows the field": {"vignette": Vignette(open_deg=180)},
    "level 0 at a cut": {"relocation_blur": RelocationBlur(level=0)},
    "background at level 0": {"background_blur": BackgroundBlur(foreground=("brass",), level=0)},
    "focus of nothing": {"focus": Focus(method="autofocus_zone")},
    "order of nothing": {"effect_order": ("motion_blur", "depth_of_field")},
    "level of nothing": {"quality": "reference"},
}


@contextmanager
def counted_draws(monkeypatch):
    """Yield a list that gets one entry for each draw call."""
    draws = []
    with monkeypatch.context() as patch:
        for name in ("render", "render_indirect"):
            draw = getattr(moderngl.VertexArray, name)

            def call(array, *arguments, draw=draw, **named):
                draws.append(array)
                return draw(array, *arguments, **named)

            patch.setattr(moderngl.VertexArray, name, call)
        yield draws


@pytest.fixture
def required(ctx, count_objects, monkeypatch):
    """Return a function that says what a condition takes in a scene, in numbers."""

    def measure(content, condition, frames=TURNING):
        before = count_objects()
        renderer = StereoRenderer(ctx, SIZE)
        renderer.begin(content, condition)
        objects = {kind: count - before[kind] for kind, count in count_objects().items()}
        with counted_draws(monkeypatch) as draws:
            for frame in frames:
                rendered = renderer.render(frame, 0.0)
        return {
            **objects,
            "passes": rendered.passes,
            "bytes": gpu_memory.megabytes(renderer.memory())["total"],
            "draws": len(draws),
            "scene draws": rendered.draws,
            "triangles": rendered.triangles,
        }

    return measure


def test_what_blurs_nothing_takes_nothing(required):
    content = still_life()
    plain = required(content, PLAIN)
    for name, settings in NOTHING_TO_BLUR.items():
        assert required(content, Condition(name="case", **settings)) == plain, name


def test_each_effect_takes_what_it_needs_and_not_what_others_need(required):
    content = still_life()
    plain = required(content, PLAIN)
    lens = Condition(name="lens", depth_of_field=DepthOfField())
    fixed = lens.model_copy(update={"focus": Focus(method="fixed")})
    shutter = Condition(name="shutter", motion_blur=MotionBlur(mode="full"))
    both = lens.model_copy(update={"name": "both", "motion_blur": shutter.motion_blur})
    counts = {each.name: required(content, each) for each in (lens, shutter, both)}
    for count in counts.values():
        for kind in ("Texture", "Program", "bytes", "draws"):
            assert count[kind] > plain[kind]
    for kind in ("Texture", "Framebuffer", "bytes", "draws"):
        extra = {name: count[kind] - plain[kind] for name, count in counts.items()}
        assert extra["both"] == pytest.approx(extra["lens"] + extra["shutter"])
    # Focus rays draw the scene once more; a fixed focus draws nothing of it.
    assert counts["lens"]["scene draws"] > plain["scene draws"]
    assert required(content, fixed)["scene draws"] == plain["scene draws"]
    assert "velocity" not in counts["lens"]["passes"]
    assert "focus" not in counts["shutter"]["passes"]


def test_without_a_sun_there_is_no_shadow_map_and_nothing_is_drawn_into_one(required):
    sunny = still_life()
    dark = replace(sunny, environment=replace(sunny.environment, sun_irradiance=(0.0, 0.0, 0.0)))
    lit, unlit = required(sunny, PLAIN), required(dark, PLAIN)
    assert lit["Texture"] - unlit["Texture"] == 1
    assert lit["bytes"] - unlit["bytes"] == pytest.approx(1024 * 1024 * 4 / 1e6, rel=0.01)
    assert lit["draws"] > unlit["draws"]
    assert set(lit["passes"]) - set(unlit["passes"]) == {"shadow"}


def test_a_shadow_map_has_a_second_layer_only_where_something_moves(required):
    content = still_life()
    first, *others = content.nodes
    moving = replace(content, nodes=(replace(first, moving=True), *others))
    assert required(moving, PLAIN)["Texture"] - required(content, PLAIN)["Texture"] == 1


def test_objects_only_has_velocities_only_where_something_moves(required):
    content = still_life()
    first, *others = content.nodes
    moving = replace(content, nodes=(replace(first, moving=True), *others))
    wanted = Condition(name="objects", motion_blur=MotionBlur(mode="objects_only"))
    assert "velocity" not in required(content, wanted)["passes"]
    assert "velocity" in required(moving, wanted)["passes"]


def test_a_frame_in_which_nothing_moved_is_drawn_like_a_plain_one(required):
    content = still_life()
    shutter = Condition(name="shutter", motion_blur=MotionBlur(mode="full"))
    resting, turning = (required(content, PLAIN, each)["draws"] for each in (RESTING, TURNING))
    assert required(content, shutter, RESTING)["draws"] == resting
    assert required(content, shutter, TURNING)["draws"] > turning


def test_blended_surfaces_and_masks_are_compiled_only_where_there_are_any(required):
    content = still_life()
    opaque = tuple(replace(each, alpha_mode="OPAQUE") for each in content.materials)
    plain = required(replace(content, materials=opaque), PLAIN)
    assert plain["Program"] < required(content, PLAIN)["Program"]
    nothing = replace(content, nodes=(Node("empty"),))
    assert required(nothing, PLAIN)["triangles"] == 0
