"""Distances along the ray: what is in focus, and how far all else is out of it, on a sphere."""

import numpy as np
import pytest

from tests.oracles.autofocus_zone import zone_focus_m
from tests.oracles.circle_of_confusion import distance_from_head_m, lens_radius_px
from tests.oracles.focus import estimate_focus, ray_directions
from tests.support.effects import coc_passes_of, seen, textures
from tests.support.render import at, glowing, scene, wall
from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Gaze, Pose, View, axis_angle, focal_length_px, yaw_pitch_roll
from vrcomfort.optics import autofocus_zone
from vrcomfort.protocol import Condition, DepthOfField, Focus
from vrcomfort.render.effects.depth_of_field import lens_radius
from vrcomfort.render.effects.depth_of_field.coc_passes import (
    CocPasses,
    CocTileMinMax,
    DepthToCoc,
)
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.graph import plan_effect
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff.brute_force import Reference

NEAR_M = 0.02
LEFT_EYE = Fov(*np.arctan([-1.2, 0.9, 1.0, -1.1]).tolist())
EYES = [
    Pose(np.array([x, 0.01, -0.02]), axis_angle([0.0, 1.0, 0.0], turn))
    for x, turn in ((-0.032, 0.2), (0.032, -0.2))
]
LAWS = {
    "linear": {"law": "linear"},
    "dioptre": {"law": "dioptre"},
    "eye": {"law": "eye", "pupil_mm": 8.0},
    "thin_lens": {"law": "thin_lens", "aperture_m": 0.1, "distance_offset_m": 0.6},
}

LEVELS = {"EXACT_PX": 3.0, "WIDER": 1.5, "LEVELS": 1, "FADED": 0.85}
"""What tiles are told of levels that nothing here reads."""


def lens(**settings):
    return DepthOfField(distance_along="ray", max_radius_percent=10, **settings)


def places(size_px):
    """The (h, w, 2) middles of an image's pixels, the bottom row first."""
    width, height = size_px
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return np.stack([u, v], axis=-1)


def signed_radii(effect, size_px):
    width, height = size_px
    texels = np.frombuffer(effect.colour_and_coc.read(), "f2").reshape(height, width, 4)
    return texels[..., 3].astype(float)


def twin_px(settings, distance_m, focus_m, size_px, lens_of=None):
    """Radii of what is so far from the head centre: the twin straight ahead, at that distance.

    `lens_of`: settings that give the lens, where those before give the limit alone.
    """
    focal_px = focal_length_px(LEFT_EYE, size_px)[0]
    max_radius_px = lens_radius.max_radius_of(settings, size_px)
    if settings.law == "linear":
        full_m = max(settings.full_blur_m, focus_m)
        radius = (np.minimum(distance_m, 3e4) - focus_m) * max_radius_px / full_m
        return np.clip(radius, -max_radius_px, max_radius_px)
    return lens_radius_px(
        1 / np.asarray(distance_m),
        px_per_dioptre=lens_radius.px_per_dioptre(
            lens_of or settings, focal_px=focal_px, size_px=size_px, focus_m=np.inf
        ),
        focus_m=focus_m,
        near_m=1.0,
        max_radius_px=max_radius_px,
        focal_length_m=settings.focal_length_m if settings.law == "thin_lens" else 0.0,
        distance_offset_m=settings.distance_offset_m,
    )


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize(("place", "focus_m"), [(EYES[0], 0.5), (EYES[1], 2.0), (EYES[0], 3e4)])
def test_the_shader_computes_what_its_twin_does(ctx, name, place, focus_m):
    size_px = (50, 40)
    distance = np.geomspace(0.05, 3e4, 2000)
    distance = np.random.default_rng(2).permutation(distance).reshape(40, 50)
    distance[:2] = np.inf
    settings = lens(**LAWS[name])
    effect = coc_passes_of(ctx, settings, distance, focus_m, size_px)
    effect.render(seen(LEFT_EYE, near_m=NEAR_M, head_from_eye=place).camera)
    depth = (NEAR_M / distance).astype("f4")
    from_head = distance_from_head_m(
        depth, fov=LEFT_EYE, near_m=NEAR_M, head_from_eye=place, uv=places(size_px)
    )
    expected = twin_px(settings, from_head, focus_m, size_px)
    assert np.ptp(expected) > 1.0
    np.testing.assert_allclose(signed_radii(effect, size_px), expected, rtol=1e-3, atol=2e-3)


@pytest.mark.parametrize(
    ("name", "focus_m"), [("dioptre", 0.5), ("eye", 2.0), ("thin_lens", 3e4), ("thin_lens", 0.5)]
)
def test_radii_are_those_of_float64_before_they_are_rounded(ctx, name, focus_m):
    """The record's shader on tiles of four equal pixels: float32, before any limit."""
    size_px, settings = (50, 40), lens(**LAWS[name])
    distance = np.random.default_rng(2).permutation(np.geomspace(0.05, 3e4, 2000)).reshape(40, 50)
    fours = np.kron(distance, np.ones((2, 2)))
    colour, depth = textures(ctx, np.zeros((80, 100, 3)), fours, NEAR_M)
    focus = ctx.texture((1, 1), 4, np.full(4, focus_m, "f4").tobytes(), dtype="f4")
    radii = DepthToCoc(EffectInputs(ctx, settings, colour, {"depth": depth, "focus": focus}, 3e4))
    largest = CocTileMinMax(ctx, radii, size_px=(100, 80), tile_px=2, defines=LEVELS)
    radii.see_with(seen(LEFT_EYE, near_m=NEAR_M, head_from_eye=EYES[0]).camera)
    largest.render()
    found = np.frombuffer(largest.target.read(), "f4").reshape(40, 50, 4)[..., 2]
    from_head = distance_from_head_m(
        (NEAR_M / distance).astype("f4"),
        fov=LEFT_EYE,
        near_m=NEAR_M,
        head_from_eye=EYES[0],
        uv=places(size_px),
    )
    unlimited = settings.model_copy(update={"max_radius_percent": 1e9})
    twin = np.abs(twin_px(unlimited, from_head, focus_m, (100, 80), lens_of=settings))
    np.testing.assert_allclose(found[twin <= 100], twin[twin <= 100], rtol=1e-5, atol=1e-3)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("flat", [False, True])
def test_tiles_hold_the_radii_of_their_pixels(ctx, name, flat):
    """Also where the nearest point of a wall is inside a tile: the head centre looks at it."""
    size_px = (61, 45)
    random = np.exp(np.random.default_rng(5).uniform(-1, 5, size_px[::-1]))
    distance = np.full(size_px[::-1], 0.4) if flat else random
    effect = coc_passes_of(ctx, lens(**LAWS[name]), distance, 0.5, size_px)
    place = Pose(np.array([0.03, 0.02, -0.01])) if flat else EYES[0]
    effect.render(seen(LEFT_EYE, near_m=NEAR_M, head_from_eye=place).camera)
    radii = signed_radii(effect, size_px)
    tiles = np.frombuffer(effect.tile_min_max.read(), "f4").reshape(6, 8, 4)
    assert effect.tile_px == 8
    for row, column in np.ndindex(6, 8):
        inside = radii[8 * row : 8 * row + 8, 8 * column : 8 * column + 8]
        least, greatest = tiles[row, column, :2]
        slack = 1e-3 * max(1, np.abs(inside).max())
        assert least - slack <= inside.min() <= inside.max() <= greatest + slack


def test_the_nearest_point_inside_a_tile_counts(ctx):
    """One tile of 8 x 8 px sees 90°; its corners are 1.6 times as far as its middle."""
    fov, size_px = Fov.symmetric(vertical_rad=np.pi / 2, aspect=1.0), (8, 8)
    effect = coc_passes_of(ctx, lens(law="dioptre"), np.full((8, 8), 1.0), 1.0, size_px)
    effect.render(seen(fov, near_m=NEAR_M, head_from_eye=Pose()).camera)
    least, greatest = np.frombuffer(effect.tile_min_max.read(), "f4")[:2]
    px_per_dioptre, corner_m = 0.8 / 2.0, np.sqrt(1 + 2 * (7 / 8) ** 2)
    middle_m = np.sqrt(1 + 2 / 64)
    assert least == pytest.approx(px_per_dioptre * (1 - 1 / middle_m), rel=1e-4)
    assert greatest == pytest.approx(px_per_dioptre * (1 - 1 / corner_m), rel=1e-4)


def test_a_point_is_as_blurred_in_one_eye_as_in_the_other(ctx):
    """Whatever is seen by both: its distance is the one from the head centre."""
    focus_m = 0.7
    settings = lens(law="eye", pupil_mm=20.0)
    point = np.array([0.25, -0.1, -0.4])
    radii = []
    for eye in EYES:
        x, y, z = (eye.inverse() @ Pose(point)).position
        # A pixel around the point, so that its middle is where the point is.
        tangents = np.array([x / -z - 0.01, x / -z + 0.01, y / -z + 0.01, y / -z - 0.01])
        colour, depth = textures(ctx, np.zeros((1, 1, 3)), -z)
        focus = ctx.texture((1, 1), 4, np.full(4, focus_m, "f4").tobytes(), dtype="f4")
        reads = {"depth": depth, "focus": focus}
        effect = CocPasses(EffectInputs(ctx, settings, colour, reads, 3e4))
        fov = Fov(*np.arctan(tangents).tolist())
        effect.render(seen(fov, near_m=NEAR_M, head_from_eye=eye).camera)
        radii.append(effect.largest_radius_px())
    expected = 0.01 * 50 * abs(1 / focus_m - 1 / np.linalg.norm(point))
    assert radii == pytest.approx([expected, expected], rel=1e-4)


def found(ctx, content, settings, *, along_ray=True, **more):
    gpu = GpuScene(ctx, content)
    focus = make_focus_pass(ctx, gpu, settings, near_m=NEAR_M, along_ray=along_ray)
    gpu.update(0.0, Pose())
    focus.render(HeadView(0, 0, Pose(), **more))
    (sample,) = focus.drain()
    return sample


def a_wall(distance_m, orientation=None):
    node = at(0.0, 0.0, -distance_m, rotation=(orientation or Pose()).orientation,
              scale=np.full(3, 60.0))  # fmt: skip
    return scene([node], [wall()], [glowing((1.0, 1.0, 1.0))])


def gaze_at(yaw_deg, pitch_deg=0.0):
    return Gaze(Pose(np.zeros(3), yaw_pitch_roll(*np.radians([yaw_deg, pitch_deg, 0.0]))))


@pytest.mark.parametrize(("yaw_deg", "pitch_deg"), [(0.0, 0.0), (40.0, 0.0), (-30.0, 25.0)])
def test_focus_under_the_gaze_is_at_the_distance_along_the_line_of_sight(ctx, yaw_deg, pitch_deg):
    settings = Focus(method="gaze", law="instant", gaze_radius_deg=0.0)
    gaze = gaze_at(yaw_deg, pitch_deg)
    sample = found(ctx, a_wall(2.0), settings, gaze=gaze)
    away = 2.0 / (np.cos(np.radians(yaw_deg)) * np.cos(np.radians(pitch_deg)))
    assert sample.focus_m == pytest.approx(away, rel=1e-5)
    np.testing.assert_allclose(sample.rays_m, away, rtol=1e-5)
    planar = found(ctx, a_wall(2.0), settings, gaze=gaze, along_ray=False)
    assert planar.focus_m == pytest.approx(2.0, rel=1e-5)


@pytest.mark.parametrize("mean", ["metres", "dioptres"])
def test_rays_ahead_have_the_distances_along_them(ctx, mean):
    turn = Pose(np.zeros(3), yaw_pitch_roll(0.5, 0.3, 0.0))
    settings = Focus(law="instant", ring_deg=20.0, mean=mean)
    sample = found(ctx, a_wall(3.0, turn), settings)
    rays, normal = ray_directions(20.0), turn.matrix()[:3, 2]
    along = normal @ [0, 0, -3.0] / (rays @ normal) * np.linalg.norm(rays, axis=1)
    np.testing.assert_allclose(sample.rays_m, along, rtol=1e-5)
    expected, used = estimate_focus(sample.rays_m, settings)
    assert sample.focus_m == pytest.approx(expected, rel=1e-6)
    assert sample.used.tolist() == used.tolist()


@pytest.mark.parametrize("statistic", ["mean", "minimum", "maximum"])
@pytest.mark.parametrize("where", ["gpu", "cpu"])
def test_the_zone_has_the_distances_along_its_pixels_rays(ctx, statistic, where):
    settings = Focus(
        method="autofocus_zone", law="instant", zone_statistic=statistic, zone_mean_on=where,
        zone_ratio=0.8, zone_size_px=(33, 20),
    )  # fmt: skip
    sample = found(ctx, a_wall(3.0), settings, screen_tangents=(1.2, 0.9))
    x = np.abs((2 * np.arange(33) + 1) / 33 - 1) * 0.8 * 1.2
    y = np.abs((2 * np.arange(20) + 1) / 20 - 1) * 0.8 * 0.9
    along = 3.0 * np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    if statistic == "mean":
        weights = autofocus_zone.gauss_weights((33, 20), settings)
        expected = (along * weights).sum() / weights.sum()
    else:
        expected = along.min() if statistic == "minimum" else along.max()
    assert sample.focus_m == pytest.approx(expected, rel=1e-5)
    depth, weight = np.full((20, 33), NEAR_M / 3.0), np.full((20, 33), 0.004)
    reduced = autofocus_zone.reduced(depth, weight, NEAR_M, settings, (0.8 * 1.2, 0.8 * 0.9))
    assert zone_focus_m(reduced, NEAR_M, settings) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("method", ["nine_ray", "autofocus_zone", "gaze"])
def test_the_sky_is_at_infinity_in_all_directions(ctx, method):
    settings = Focus(method=method, law="instant", infinity_m=100.0)
    sample = found(ctx, scene([], [], []), settings, gaze=gaze_at(40.0))
    assert sample.focus_m == pytest.approx(100.0, rel=1e-6)
    if method != "autofocus_zone":
        np.testing.assert_allclose(sample.rays_m, 100.0, rtol=1e-6)


@pytest.mark.parametrize("along", ["head_axis", "ray"])
def test_what_is_looked_at_is_sharp_and_the_wall_ahead_only_in_a_plane(ctx, along):
    """Stripes on a wall 0.4 m away, looked at 40° to the left, where it is 0.52 m away."""
    size = np.array([0.01, 9.0, 1.0])
    strips = [at(0.04 * i, 0.0, -0.4, scale=size) for i in range(-20, 21)]
    behind = at(0.0, 0.0, -0.4005, scale=np.full(3, 9.0), mesh=(1,))
    materials = [glowing((1.0, 1.0, 1.0)), glowing((0.0, 0.0, 0.0))]
    content = scene([behind, *strips], [wall(), wall(material=1)], materials)
    blur = DepthOfField(law="eye", pupil_mm=20.0, max_radius_percent=5, distance_along=along)
    focus = Focus(method="gaze", law="instant")
    renderer = StereoRenderer(ctx, (640, 64), samples=4)
    renderer.build(content, Condition(name="gaze", focus=focus, depth_of_field=blur))
    changes = []

    def keep(index, eye):
        sharp, blurred = (
            np.frombuffer(texture.read(), "f2").reshape(64, 640, 4)[..., 0].astype(float)
            for texture in (eye.pinhole, eye.linear)
        )
        changes.append(np.abs(blurred - sharp).max(axis=0))

    fov = Fov(-0.9, 0.9, 0.1, -0.1)
    eyes_m = (-0.03, 0.03)
    eyes = tuple(View(Pose(np.array([x, 0.0, 0.0])), fov) for x in eyes_m)
    renderer.render(Frame(0, 0, 10_000_000, Pose(), eyes, Pose(), gaze=gaze_at(40.0)), 0.0, keep)
    renderer.release()
    for change, eye_m in zip(changes, eyes_m, strict=True):
        aside, ahead = (
            round((1 + (x - eye_m) / 0.4 / np.tan(0.9)) * 320)
            for x in (-0.4 * np.tan(np.radians(40)), 0.0)
        )
        assert change[aside - 12 : aside + 13].max() == 0.0
        assert (change[ahead - 12 : ahead + 13].max() > 0.05) == (along == "ray")


def test_a_plan_says_so_and_what_cannot_be_is_refused(ctx):
    condition = Condition(name="c", depth_of_field=lens(law="eye"))
    content = a_wall(2.0)
    reason = plan_effect("depth_of_field", content, condition).reason
    assert "by the distance along each ray" in reason
    note = Reference(ctx, content, condition, (16, 16)).note
    assert "the distance along each ray is left out" in note
    with pytest.raises(ValueError, match="a plane is in focus"):
        lens(law="eye", views=4)
    accurate = {
        "name": "c",
        "quality": "reference",
        "depth_of_field": {"law": "eye", "distance_along": "ray"},
    }
    assert Condition.model_validate(accurate).depth_of_field.views == 1


def test_without_a_tracker_the_sentence_is_the_same(ctx):
    with pytest.raises(InputError, match="no eye tracker"):
        found(ctx, a_wall(2.0), Focus(method="gaze"))
