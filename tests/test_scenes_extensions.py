"""glTF extensions and textures that a scene may have: pixels that can be computed by hand."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from tests.support.render import eye
from tests.support.scene_files import Gltf, png
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.output import read_depth, read_linear
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import UvMap
from vrcomfort.scene.load import load_scene

SIZE = (64, 64)
TEXELS = np.array(
    [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8
).repeat(16, axis=0).repeat(16, axis=1)  # fmt: skip
"""Red, green; blue, white: large enough that mipmaps and bilinear filtering do not matter."""
RED, GREEN, BLUE, WHITE = np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], np.ones(3)


def textured(
    path, *, info, sampler=None, extensions=None, uvs_1=None, mode="OPAQUE", pixels=TEXELS
):
    """Write a square, 2 m wide at z = −1, that fills the view; image (0, 0) is its upper left."""
    file = Gltf()
    attributes = {
        "POSITION": file.accessor([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]]),
        "TEXCOORD_0": file.accessor([[0, 1], [1, 1], [1, 0], [0, 0]]),
    }
    if uvs_1 is not None:
        attributes["TEXCOORD_1"] = file.accessor(uvs_1)
    square = {"attributes": attributes, "indices": file.accessor([0, 1, 2, 0, 2, 3], "uint8")}
    material = {
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, **info}},
        "extensions": {"KHR_materials_unlit": {}, **(extensions or {})},
        "alphaMode": mode,
    }
    return file.save(
        path,
        meshes=[{"primitives": [square | {"material": 0}]}],
        materials=[material],
        textures=[{"source": 0, "sampler": 0}],
        samplers=[sampler or {}],
        images=[{"bufferView": file.view(png(pixels))}],
        extensionsRequired=["KHR_texture_transform", "KHR_materials_unlit"],
    )


def drawn(ctx, path):
    """Return the linear image of the scene, upper row first, seen from the origin along −z."""
    scene = load_scene(path)
    assert scene.warnings == ()
    scene_pass = ScenePass(ctx, scene, SIZE, velocity=False)
    scene_pass.render(eye(), 0.0)
    return read_linear(scene_pass.colour)


def quarters(image):
    """Return the colours in the middles of the upper two and the lower two quarters."""
    return image[[16, 16, 48, 48], [16, 48, 16, 48]]


def transformed(**transform):
    return {"extensions": {"KHR_texture_transform": transform}}


CASES = {
    "as it is": ({}, [RED, GREEN, BLUE, WHITE]),
    "moved by half": (transformed(offset=[0.5, 0]), [GREEN, RED, WHITE, BLUE]),
    "upside down": (transformed(offset=[0, 1], scale=[1, -1]), [BLUE, WHITE, RED, GREEN]),
    "one quarter": (transformed(offset=[0.5, 0.5], scale=[0.5, 0.5]), [WHITE] * 4),
    "twice": (transformed(scale=[2, 1], offset=[0.25, 0]), [GREEN, GREEN, WHITE, WHITE]),
    # The example of the extension: the lower left quarter alone, turned clockwise.
    "its example": (transformed(offset=[0, 1], rotation=np.pi / 2, scale=[0.5, 0.5]), [BLUE] * 4),
    "turned": (transformed(offset=[0, 1], rotation=np.pi / 2), [BLUE, RED, WHITE, GREEN]),
}


@pytest.mark.parametrize("case", CASES)
def test_texture_transform(ctx, tmp_path, case):
    info, expected = CASES[case]
    image = drawn(ctx, textured(tmp_path / "a.gltf", info=info))
    np.testing.assert_allclose(quarters(image), expected, atol=2e-3)


def test_a_texture_transform_moves_the_holes_of_a_mask_in_depth_too(ctx, tmp_path):
    """Shadows and the rays that find the focus go through the holes that are seen."""
    holed = np.concatenate([TEXELS, np.full((32, 32, 1), 255, np.uint8)], axis=2)
    holed[:, 16:, 3] = 0
    info = transformed(offset=[0.5, 0])
    path = textured(tmp_path / "a.gltf", info=info, mode="MASK", pixels=holed)
    gpu = GpuScene(ctx, load_scene(path))
    depth = gl.depth_texture(ctx, SIZE)
    target = ctx.framebuffer([], depth)
    target.use()
    target.clear(depth=0.0)
    ctx.enable_only(moderngl.DEPTH_TEST)
    ctx.depth_func = gl.DEPTH_FUNC
    gpu.update(0.0, Pose())
    gpu.draw_depth(eye().clip_from_relative(), np.zeros(3))
    open_at = read_depth(depth)[32, [16, 48]] == 0
    np.testing.assert_array_equal(open_at, [True, False])


@pytest.mark.parametrize("by", ["texCoord", "extension"])
def test_second_texture_coordinates(ctx, tmp_path, by):
    info = {"texCoord": 1} if by == "texCoord" else transformed(texCoord=1)
    uvs = [[1, 1], [0, 1], [0, 0], [1, 0]]  # left and right changed over
    image = drawn(ctx, textured(tmp_path / "a.gltf", info=info, uvs_1=uvs))
    np.testing.assert_allclose(quarters(image), [GREEN, RED, WHITE, BLUE], atol=2e-3)


def test_mirrored_repeat(ctx, tmp_path):
    sampler = {"wrapS": 33648, "wrapT": 10497}
    info = transformed(scale=[2, 1])
    image = drawn(ctx, textured(tmp_path / "a.gltf", info=info, sampler=sampler))
    np.testing.assert_allclose(image[16, [8, 24, 40, 56]], [RED, GREEN, GREEN, RED], atol=2e-3)
    plain = drawn(ctx, textured(tmp_path / "b.gltf", info=info))
    np.testing.assert_allclose(plain[16, [8, 24, 40, 56]], [RED, GREEN, RED, GREEN], atol=2e-3)


def test_unlit_surfaces_show_their_colour_whatever_the_light(ctx, tmp_path):
    path = textured(tmp_path / "a.gltf", info={})
    (material, _) = load_scene(path).materials
    assert material.unlit
    np.testing.assert_allclose(quarters(drawn(ctx, path))[3], WHITE, atol=2e-3)


def test_the_matrix_of_a_uv_map_is_offset_times_rotation_times_scale():
    uv_map = UvMap(0, (0.1, 0.2), np.pi / 6, (2.0, 3.0))
    c, s = np.cos(np.pi / 6), 0.5
    expected = [[2 * c, 3 * s, 0.1], [-2 * s, 3 * c, 0.2]]
    np.testing.assert_allclose(uv_map.matrix(), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("info", "message"),
    [
        ({"texCoord": 2}, r"materials\[0\]\.pbrMetallicRoughness\.baseColorTexture\.texCoord"),
        (transformed(scale=[1]), r"KHR_texture_transform\.scale has 1 numbers, but needs 2"),
        (transformed(rotation="x"), r"KHR_texture_transform\.rotation should be"),
    ],
)
def test_a_broken_texture_is_told_with_its_place(tmp_path, info, message):
    path = textured(tmp_path / "a.gltf", info=info)
    with pytest.raises(InputError, match=message):
        load_scene(path)
