"""The hooks of other passes: depth from any viewpoint, and views through a point of the lens."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.raycast import cast
from tests.support.render import at, clips_of, eye, glowing, scene, still_life, wall
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.gpu import gl
from vrcomfort.render.camera import Lens
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.output import distance_m, read_depth, read_linear
from vrcomfort.render.scene_pass import ScenePass

SIZE = (64, 64)


def test_depth_alone_agrees_with_rays_masks_included(ctx):
    content = still_life()
    camera = eye((0.1, 0.9, 0.2), yaw_pitch_roll(0.05, -0.1, 0.0))
    depth = gl.depth_texture(ctx, SIZE)
    target = ctx.framebuffer([], depth)
    gpu = GpuScene(ctx, content)
    gpu.update(0.0, camera.head)
    target.use()
    target.clear(depth=0.0)
    ctx.enable_only(ctx.DEPTH_TEST)
    ctx.depth_func = gl.DEPTH_FUNC
    gpu.draw_depth(clips_of(camera), camera.world_from_eye.position)
    found = distance_m(read_depth(depth), camera.near_m)

    x, y = np.meshgrid((np.arange(64) + 0.5) / 32 - 1, 1 - (np.arange(64) + 0.5) / 32)
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    rotation = camera.world_from_eye.rotation
    origins = np.tile(camera.world_from_eye.position, (len(rays), 1))
    along_ray = cast(content, 0.0, origins, rays @ rotation.T, head=camera.head)
    expected = (along_ray / np.linalg.norm(rays, axis=1)).reshape(64, 64)
    with np.errstate(invalid="ignore"):
        agree = np.isclose(found, expected, rtol=1e-4) | (found == expected)
    # Where they differ is a pixel wide: the rim of the mask, which mipmaps move by a texel.
    assert agree.mean() > 0.99
    middle = found[36, 37]
    assert middle > 3, "the hole of the masked wall is open"


@pytest.mark.parametrize("law", ["linear", "dioptre"])
def test_a_point_of_the_lens_shifts_what_is_out_of_focus(ctx, law):
    white = glowing((1.0, 1.0, 1.0))
    nodes = [at(-0.5, 0, -1, mesh=(0,)), at(1.0, 0, -2, mesh=(1,))]
    content = scene(nodes, [wall(0.5), wall(1.0)], [white])
    scene_pass = ScenePass(ctx, content, SIZE, velocity=False, lens_law=law)
    lens = Lens((0.0, 0.0), focus_m=1.0, infinity_m=3e4, px_per_defocus=8.0, max_radius_px=9.0)
    images = {}
    for position in ((0.0, 0.0), (1.0, 0.0), (0.0, -0.5)):
        scene_pass.render(eye(lens=replace(lens, position=position)), 0.0)
        images[position] = read_linear(scene_pass.colour)[..., 0]
    # At 2 m with focus at 1 m: 0.5 dioptres or 1 m of defocus, 4 px or 8 px of radius.
    radius = 4 if law == "dioptre" else 8
    pinhole, right, down = images.values()
    near, far = slice(0, 28), slice(32, 56)
    np.testing.assert_array_equal(right[:, near], pinhole[:, near])
    np.testing.assert_allclose(np.roll(right, -radius, axis=1)[:, far], pinhole[:, far], atol=1e-3)
    shifted = np.roll(down, -radius // 2, axis=0)
    np.testing.assert_allclose(shifted[:, far], pinhole[:, far], atol=1e-3)


def test_the_middle_of_the_lens_is_the_pinhole_bit_for_bit(ctx):
    lens = Lens((0.0, 0.0), focus_m=1.0, infinity_m=3e4, px_per_defocus=8.0, max_radius_px=9.0)
    images = []
    for law, camera in ((None, eye((0, 0.8, 0))), ("dioptre", eye((0, 0.8, 0), lens=lens))):
        scene_pass = ScenePass(ctx, still_life(), SIZE, velocity=False, lens_law=law)
        scene_pass.render(replace(camera, world_from_head=Pose((0, 0.8, 0))), 0.0)
        images.append(read_linear(scene_pass.colour))
    np.testing.assert_array_equal(*images)
