"""Circles of confusion in the alpha of the scene's own colour: where samples are resolved."""

from dataclasses import replace

import numpy as np
import pytest

from bench import resolve
from tests.support.render import at, eye, glowing, scene, still_life, wall
from tests.support.study import frame
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.protocol import Condition, DepthOfField, MotionBlur
from vrcomfort.protocol.conditions import Peripheral
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.scene_pass import ScenePass

SIZE_PX = (48, 36)
LENSES = {
    "linear": DepthOfField(law="linear", max_radius_percent=10),
    "dioptre": DepthOfField(law="dioptre", max_radius_percent=10),
    "thin_lens": DepthOfField(law="thin_lens", aperture_m=0.1, max_radius_percent=10),
    "along_ray": DepthOfField(law="dioptre", distance_along="ray", max_radius_percent=10),
    "peripheral": DepthOfField(peripheral=Peripheral(), max_radius_percent=10),
}


def canted():
    """An eye that is turned against the head it belongs to, and beside its centre."""
    head = eye((0.1, 1.1, 0.2))
    beside = Pose(np.array([0.03, 0.01, -0.02]), axis_angle([0.0, 1.0, 0.0], 0.2))
    world_from_head = head.world_from_eye
    return EyeCamera(world_from_head @ beside, head.fov, head.near_m, world_from_head)


@pytest.mark.parametrize(
    ("law", "velocity"), [*((law, False) for law in LENSES), ("linear", True), ("along_ray", True)]
)
def test_radii_are_those_that_a_pass_of_their_own_finds(ctx, law, velocity):
    scene_pass = ScenePass(ctx, still_life(), SIZE_PX, velocity=velocity)
    camera = canted()
    scene_pass.render(camera, 0.0)
    colour = read_texture(scene_pass.colour)
    depth = read_texture(scene_pass.depth)
    focus = ctx.texture((1, 1), 4, np.full(4, 1.3, "f4").tobytes(), dtype="f4")
    reads = {"depth": scene_pass.depth, "focus": focus}
    inputs = EffectInputs(ctx, LENSES[law], scene_pass.colour, reads, 3e4)
    alone = CocPasses(inputs)
    alone.render(camera)
    expected = read_texture(alone.colour_and_coc)
    beside = CocPasses(replace(inputs, scene=scene_pass))
    assert beside.colour_and_coc is scene_pass.colour
    scene_pass.render(camera, 0.0)
    found = read_texture(scene_pass.colour)
    np.testing.assert_array_equal(found[..., :3], colour[..., :3])
    np.testing.assert_array_equal(read_texture(scene_pass.depth), depth)
    # The last two bits of a half float are the part of the pixel that is covered.
    radius, alone_px = (np.ascontiguousarray(each[..., 3]) for each in (found, expected))
    covered = radius.view(np.uint16) & 3
    radius -= covered * np.spacing(np.abs(radius)) * np.sign(radius)
    np.testing.assert_allclose(radius.astype("f8"), alone_px.astype("f8"), rtol=4e-3, atol=1e-3)
    assert np.ptp(radius.astype("f8")) > 0.5


def test_depth_of_field_that_is_not_first_has_a_pass_for_them(ctx):
    """Motion blur of nothing that moves leaves the image as it is, whatever comes first."""
    lens = DepthOfField(law="dioptre", max_radius_percent=5)
    images = []
    for order in (("depth_of_field", "motion_blur"), ("motion_blur", "depth_of_field")):
        condition = Condition(
            name="x", depth_of_field=lens, motion_blur=MotionBlur(), effect_order=order
        )
        renderer = StereoRenderer(ctx, SIZE_PX)
        renderer.build(still_life(), condition)
        renderer.render(frame(0), 0.0, lambda _, each: images.append(read_texture(each.linear)))
        renderer.release()
    np.testing.assert_allclose(images[0].astype("f8"), images[2].astype("f8"), rtol=2e-3, atol=1e-4)


def test_samples_weighted_by_brightness_take_the_steps_out_of_a_lamps_edge(ctx, tmp_path):
    """`k` of four samples see a lamp of 8: k · 8 / 4, or that with weights 1/9 and 1."""
    lamps = [resolve.lamp(tmp_path, 8.0, 0.0, 20.0, each) for each in resolve.RESOLVES]
    mean, weighted = (resolve.draw(ctx, each, 1, 1)[0, ..., 0] for each in lamps)
    samples = np.rint(mean / 2)
    assert set(samples.ravel()) == {0, 1, 2, 3, 4}
    np.testing.assert_allclose(mean, 2 * samples, rtol=1e-3)
    expected = samples * (8 / 9) / (samples / 9 + 4 - samples)
    np.testing.assert_allclose(weighted, expected, rtol=1e-3)


def test_a_resolve_by_brightness_is_said_in_passes(tmp_path):
    def reason(how):
        planned = plan_passes(resolve.lamp(tmp_path, 8.0, 0.0, 2.0, how), Condition(name="plain"))
        return next(each.reason for each in planned if each.name == "scene")

    told = ["bright samples weigh less" in reason(how) for how in resolve.RESOLVES]
    assert told == [False, True]


def test_light_of_a_lamp_behind_a_bar_s_edge_keeps_the_lamp_s_radius(ctx):
    """The nearest sample's is the bar's; it would spread the lamp over the bar's disc."""
    bar = at(-0.293, 0.0, -0.5, scale=np.array([0.6, 2.0, 1.0]))
    lamp = at(0.013, 0.0, -1.0, mesh=(1,), scale=np.array([0.3, 0.3, 1.0]))
    shine = [glowing((light,) * 3) for light in (0.1, 100.0)]
    content = scene([bar, lamp], [wall(1, 0), wall(1, 1)], shine)
    drawn = ScenePass(ctx, content, SIZE_PX, velocity=False)
    camera = eye()
    focus = ctx.texture((1, 1), 4, np.full(4, 1.3, "f4").tobytes(), dtype="f4")
    reads = {"depth": drawn.depth, "focus": focus}
    lens = LENSES["dioptre"]
    coc = CocPasses(EffectInputs(ctx, lens, drawn.colour, reads, 3e4, scene=drawn))
    assert coc.colour_and_coc is drawn.colour
    drawn.render(camera, 0.0)
    found = read_texture(drawn.colour).astype("f8")
    distance_m = camera.near_m / np.maximum(read_texture(drawn.depth)[..., 0], 1e-9)
    is_lit = found[..., 0] > 20
    mixed = is_lit & (distance_m < 0.6)
    assert mixed.any()
    inside = is_lit & (found[..., 0] > 99)
    np.testing.assert_allclose(found[mixed, 3], found[inside, 3].mean(), rtol=0.02)
