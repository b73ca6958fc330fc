"""glTF extensions and textures that a scene may have: pixels that can be computed by hand."""

from __future__ import annotations

import json

import moderngl
import numpy as np
import pytest

from tests.support.render import clips_of, eye
from tests.support.scene_files import Gltf, png
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.gpu import gl, shaders
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.output import read_depth, read_linear
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import MOST_LAMPS, UvMap
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
    gpu.draw_depth(clips_of(eye()), np.zeros(3))
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


def lit(path, lights, nodes, side_car=""):
    """Write a white, rough floor of 8 m at y = 0 under lights; the sky gives none."""
    file = Gltf()
    square = {
        "attributes": {
            "POSITION": file.accessor([[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]]),
            "NORMAL": file.accessor([[0, 1, 0]] * 4),
        },
        "indices": file.accessor([0, 1, 2, 0, 2, 3], "uint8"),
        "material": 0,
    }
    surface = {"metallicFactor": 0, "roughnessFactor": 1, "baseColorFactor": [0.5, 0.5, 0.5, 1]}
    placed = [
        {**node, "extensions": {"KHR_lights_punctual": {"light": light}}} for light, node in nodes
    ]
    file.save(
        path,
        meshes=[{"primitives": [square]}],
        materials=[{"pbrMetallicRoughness": surface}],
        nodes=[{"mesh": 0}, *placed],
        scenes=[{"nodes": list(range(len(placed) + 1))}],
        extensions={"KHR_lights_punctual": {"lights": lights}},
    )
    dark = "[sky]\nzenith = [0, 0, 0]\nhorizon = [0, 0, 0]\nground = [0, 0, 0]\n"
    path.with_suffix(".toml").write_text(dark + side_car)
    return path


DOWN = {"rotation": [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]}
"""Turns −Z to −Y."""
NO_SUN = "[sun]\nirradiance = [0, 0, 0]\n"
ABOVE = eye((0, 4, 0), axis_angle([1.0, 0.0, 0.0], -np.pi / 2))
"""Looks down at the floor, 8 m of it, with north up: a pixel is 1/8 m."""


def floor_light(ctx, path):
    """Return the (64, 64) red radiance of the floor, less highlights: seen from right above."""
    scene_pass = ScenePass(ctx, load_scene(path), SIZE, velocity=False)
    scene_pass.render(ABOVE, 0.0)
    return read_linear(scene_pass.colour)[..., 0]


def test_the_first_directional_light_is_the_sun_and_others_shine_too(ctx, tmp_path):
    lights = [{"type": "directional", "intensity": i, "color": [1, 0.5, 0]} for i in (2.0, 3.0)]
    aslant = {"rotation": axis_angle([1.0, 0.0, 0.0], -np.pi / 3).tolist()}
    path = lit(tmp_path / "a.gltf", lights, [(0, DOWN), (1, aslant)])
    environment = load_scene(path).environment
    np.testing.assert_allclose(environment.sun_direction, [0, 1, 0], atol=1e-12)
    assert environment.sun_irradiance == (2.0, 1.0, 0.0)
    both = floor_light(ctx, path)[32, 32]
    one = floor_light(ctx, lit(tmp_path / "b.gltf", lights, [(0, DOWN)]))[32, 32]
    # The second comes in 30° above the floor's plane: cos 30° = sin 60° of it arrives, less a
    # highlight that the first has and the second, which is not mirrored to the eye, hardly has.
    diffuse = 0.5 / np.pi
    assert both - one == pytest.approx(3.0 * np.sin(np.pi / 3) * diffuse, rel=0.06)
    assert one == pytest.approx(2.0 * diffuse, rel=0.1)


def test_a_sun_in_the_side_car_takes_the_place_of_the_files(tmp_path):
    path = lit(tmp_path / "a.gltf", [{"type": "directional"}], [(0, DOWN)], NO_SUN)
    environment = load_scene(path).environment
    assert environment.sun_irradiance == (0.0, 0.0, 0.0)
    assert environment.directional_lights == ()


def test_a_spot_light_fades_between_its_cones(ctx, tmp_path):
    light = {
        "type": "spot",
        "intensity": 40.0,
        "range": 1e6,
        "spot": {"innerConeAngle": np.radians(20), "outerConeAngle": np.radians(40)},
    }
    spot = {**DOWN, "translation": [0, 3, 0]}
    path = lit(tmp_path / "a.gltf", [light], [(0, spot)], NO_SUN)
    point = lit(tmp_path / "b.gltf", [{**light, "type": "point"}], [(0, spot)], NO_SUN)
    found, whole = floor_light(ctx, path), floor_light(ctx, point)
    across_m = (np.arange(64) + 0.5 - 32) / 8
    angle = np.arctan(np.hypot(across_m, across_m[32]) / 3)
    inner, outer = np.cos(np.radians([20, 40]))
    share = np.clip((np.cos(angle) - outer) / (inner - outer), 0, 1) ** 2
    np.testing.assert_allclose(found[32] / whole[32], share, atol=0.01)
    assert (share == 0).sum() > 10
    assert (share == 1).sum() > 10


def test_a_spot_light_shines_along_its_nodes_minus_z_whatever_its_scale(ctx, tmp_path):
    light = {"type": "spot", "intensity": 9.0, "spot": {"outerConeAngle": 0.3}}
    aside = {
        "rotation": axis_angle([1.0, 0.0, 0.0], -np.pi / 4).tolist(),
        "translation": [0, 2, 2],
        "scale": [3, 1, 0.5],
    }
    found = floor_light(ctx, lit(tmp_path / "a.gltf", [light], [(0, aside)], NO_SUN))
    brightest = np.unravel_index(np.argmax(found), found.shape)
    assert abs(brightest[0] - 32) <= 4, "down and north from (0, 2, 2) is the origin"
    assert abs(brightest[1] - 32) <= 2


def test_more_lamps_than_are_drawn_are_refused(tmp_path):
    lights = [{"type": "spot"}, {"type": "directional"}, {"type": "point"}]
    nodes = [(0, {}), (1, {}), *[(2, {"translation": [i, 1, 0]}) for i in range(15)]]
    load_scene(lit(tmp_path / "a.gltf", lights, nodes))  # the directional one is the sun
    path = lit(tmp_path / "b.gltf", lights, [*nodes, (1, {})])
    with pytest.raises(
        InputError, match=r"b\.gltf.* has 17 lamps besides the sun.*16 are the most"
    ):
        load_scene(path)
    assert shaders.block_dtype("light.glsl", "Light")["lamp_position"].shape[0] == MOST_LAMPS


@pytest.mark.parametrize(
    ("light", "message"),
    [
        ({"spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}}, "inner cone that is not within"),
        ({"spot": {"outerConeAngle": 2.0}}, r"outerConeAngle should be less than or equal to"),
    ],
)
def test_a_broken_cone_is_told_with_its_place(tmp_path, light, message):
    path = lit(tmp_path / "a.gltf", [{"type": "spot", **light}], [(0, {})])
    with pytest.raises(InputError, match=rf"lights\[0\].*{message}"):
        load_scene(path)


def test_a_light_without_a_direction_is_refused(tmp_path):
    path = lit(tmp_path / "a.gltf", [{"type": "spot"}], [(0, {"name": "lamp", "scale": [1, 1, 0]})])
    with pytest.raises(InputError, match="'lamp' has a light, but a scale of 0"):
        load_scene(path)


def test_lamps_that_move_are_named(tmp_path):
    path = lit(tmp_path / "a.gltf", [{"type": "point"}], [(0, {})])
    root = json.loads(path.read_text())
    file = Gltf()
    file.root = root
    times, values = file.accessor([0.0, 1.0]), file.accessor([[0, 1, 0], [0, 2, 0]])
    root["animations"] = [
        {
            "samplers": [{"input": times, "output": values}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
        }
    ]
    path.write_text(json.dumps(root))
    (warning,) = load_scene(path).warnings
    assert "lamps that move" in warning
