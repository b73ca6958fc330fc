"""Light, air, reflection and sky: the shaders' formulas against NumPy in float64."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles import reflection, sky
from tests.render.effects.test_optics import evaluate
from vrcomfort.geometry import Fov, Pose, normalize
from vrcomfort.gpu import gl, shaders
from vrcomfort.render import lighting
from vrcomfort.render.camera import EyeCamera, camera_motion
from vrcomfort.render.scene_pass import EyeBlocks
from vrcomfort.scene.data import Environment, Scene, SpotLight

ENVIRONMENT = Environment(
    sun_direction=normalize([0.3, 0.7, -0.4]),
    cloud_cover=0.6,
    fog_density_per_m=0.02,
    fog_color=(0.3, 0.5, 0.7),
)


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def directions(rng, count=400):
    """Return float32 unit vectors all around, some beside the sun."""
    rays = rng.normal(size=(count, 3))
    rays[::4] = ENVIRONMENT.sun_direction + rng.normal(size=(len(rays[::4]), 3)) * 3e-3
    return normalize(rays).astype("f4")


def with_light(ctx, expression, rows, *, environment=ENVIRONMENT, define="CLOUDS"):
    """Return (n, 4) of a GLSL expression in x (a row), with the light of `environment` bound."""
    program = f"""#version 450 core
#define {define}
#include "light.glsl"
#include "sky.glsl"
uniform sampler2D arguments;
out vec4 result;
void main() {{
    vec4 x = texelFetch(arguments, ivec2(gl_FragCoord.xy), 0);
    result = {expression};
}}
"""
    for include in ("light.glsl", "sky.glsl", "eyes.glsl", "corner.glsl"):
        ctx.includes[include] = shaders.source(f"include/{include}")
    padded = np.zeros((len(rows), 4), "f4")
    padded[:, : rows.shape[1]] = rows
    source = gl.color_texture(ctx, (len(rows), 1), dtype="f4")
    source.write(padded.tobytes())
    target = gl.color_texture(ctx, (len(rows), 1), dtype="f4")
    scene = Scene("light", (), (), (), environment=environment)
    blocks = EyeBlocks(ctx, scene, (1, 1), lens=False, velocity=False)
    eye = EyeCamera(Pose(), Fov(-0.5, 0.5, 0.5, -0.5))
    blocks.write([eye], camera_motion([Pose()], [Pose()]), None)
    blocks.bind()
    ctx.framebuffer([target]).use()
    source.use(0)
    triangle = ctx.vertex_array(ctx.program(shaders.source("common/fullscreen.vert"), program), [])
    triangle.render(vertices=3)
    return np.frombuffer(target.read(), "f4").reshape(-1, 4)


def test_lamps_fall_off(ctx, rng):
    rows = np.zeros((300, 4), "f4")
    rows[:, 0], rows[:, 1] = 10 ** rng.uniform(-4, 4, 300), 10 ** rng.uniform(-3, 3, 300)
    found = evaluate(ctx, "light.glsl", "vec4(lamp_falloff(x.x, x.y))", rows)[:, 0]
    twin = reflection.lamp_falloff(rows[:, 0], rows[:, 1])
    # The window is a difference of numbers beside 1.
    np.testing.assert_allclose(found, twin, rtol=1e-5, atol=1e-6 * 1e4)
    assert (twin <= 1e4).all()


@pytest.mark.parametrize(("inner", "outer"), [(0.0, 0.3), (0.5, 0.9), (0.4, 0.401), (1.2, 1.57)])
def test_cones_are_the_twin(ctx, rng, inner, outer):
    lamp = SpotLight((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 1.0, (0.0, 0.0, -1.0), inner, outer)
    blocks = np.zeros(1, shaders.block_dtype("light.glsl", "Light"))
    environment = replace(ENVIRONMENT, point_lights=(lamp,))
    lighting.Light(Scene("light", (), (), (), environment=environment), blocks)
    angle = np.concatenate([rng.uniform(0, np.pi, 300), rng.uniform(inner, outer, 100)])
    turn = rng.uniform(0, 2 * np.pi, 400)
    shines = [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), -np.cos(angle)]
    rows = np.column_stack([-np.transpose(shines), np.zeros(400)]).astype("f4")
    of_lamp = np.float32(
        [blocks[0]["lamp_direction"][0], [*[0.0] * 3, blocks[0]["lamp_intensity"][0, 3]]]
    )
    found = evaluate(ctx, "light.glsl", "vec4(cone(x.xyz, a, b.w))", rows, constants=of_lamp)[:, 0]
    twin = reflection.cone(angle, inner_rad=inner, outer_rad=outer)
    np.testing.assert_allclose(found, twin, atol=3e-4)  # at most 1000 times a rounded cosine
    assert {0.0, 1.0} <= {*twin} or outer > 1.5 or inner == 0


def test_air_is_the_twin(ctx, rng):
    rows = np.concatenate([rng.uniform(0, 5, (300, 3)), 10 ** rng.uniform(-3, 4.5, (300, 1))], 1)
    rows = rows.astype("f4")
    found = with_light(ctx, "vec4(through_air(x.rgb, x.a), 0.0)", rows)[:, :3]
    twin = reflection.through_air(
        rows[:, :3],
        rows[:, 3],
        fog=ENVIRONMENT.fog_color,
        density_per_m=ENVIRONMENT.fog_density_per_m,
    )
    np.testing.assert_allclose(found, twin, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("alpha", [0.01, 0.3, 1.0])
def test_reflection_is_the_twin(ctx, rng, alpha):
    v = directions(rng)
    n, to_light = normalize([0.2, 0.9, 0.3]), normalize([-0.5, 0.6, 0.2])
    constants = np.float32([[*n, alpha], [*to_light, 0.04]])
    rows = np.concatenate([v, np.zeros((len(v), 1), "f4")], axis=1)
    expression = "vec4(specular(a.xyz, x.xyz, b.xyz, vec3(0.04, 0.5, 1.0), a.w), 0.0)"
    found = evaluate(ctx, "surface.glsl", expression, rows, constants=constants)[:, :3]
    (*n, rounded), (*to_light, _) = constants.astype("f8")
    twin = reflection.specular(n, v, to_light, [0.04, 0.5, 1.0], np.full(len(v), rounded))
    # A narrow highlight is 1 / alpha^2 times as sensitive to a rounded half vector.
    np.testing.assert_allclose(found, twin, rtol=2e-6 / alpha**2 + 2e-5, atol=1e-6)


def test_ambient_reflectance_is_the_twin(ctx, rng):
    rows = rng.uniform(0, 1, (200, 4)).astype("f4")
    expression = "vec4(ambient_reflectance(vec3(x.z, 0.04, 1.0), x.x, x.y), 0.0)"
    found = evaluate(ctx, "surface.glsl", expression, rows)[:, :3]
    f0 = np.stack([rows[:, 2], np.full(200, 0.04), np.ones(200)], axis=-1)
    twin = reflection.ambient_reflectance(f0, rows[:, 0], rows[:, 1])
    np.testing.assert_allclose(found, twin, rtol=1e-4, atol=1e-5)
    assert ((twin > 0) & (twin <= 1.05)).all()


def test_noise_is_the_twin_bit_by_bit_on_the_lattice(ctx, rng):
    cells = rng.integers(-3000, 3000, (300, 2)).astype("f4")
    found = with_light(ctx, "vec4(value_noise(x.xy))", cells)[:, 0]
    np.testing.assert_array_equal(found, sky.value_noise(cells).astype("f4"))


@pytest.mark.parametrize("cover", [0.0, 0.6, 1.0])
def test_sky_is_the_twin(ctx, rng, cover):
    environment = replace(ENVIRONMENT, cloud_cover=cover)
    rays = directions(rng)
    define = "CLOUDS" if cover else "NO_CLOUDS"
    expression = "vec4(sky_radiance(x.xyz), 0.0)"
    found = with_light(ctx, expression, rays, environment=environment, define=define)[:, :3]
    twin = sky.sky_radiance(rays, environment)
    outside = np.abs(rays.astype("f8") @ environment.sun_direction - sky.SUN_COS) > 2e-5
    assert outside.sum() > 300
    # Noise repeats 16 times as fast in its last octave, at coordinates of about 20.
    np.testing.assert_allclose(found[outside], twin[outside], rtol=1e-3, atol=2e-3)
    assert (found <= sky.BRIGHTEST * 1.01).all()
