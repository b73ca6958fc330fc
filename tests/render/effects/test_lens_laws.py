"""Circles of confusion in physical units: a camera's lens, an eye, the limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.circle_of_confusion import lens_radius_px
from tests.support.effects import coc_passes_of, seen, square_pixels, textures
from tests.support.render import at, eye, glowing, scene, still_life, wall
from vrcomfort.geometry import Fov, Pose, axis_angle, focal_length_px
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol import Condition, DepthOfField, Focus
from vrcomfort.protocol.conditions import Peripheral
from vrcomfort.render.effects.depth_of_field import lens_radius
from vrcomfort.render.effects.depth_of_field.coc_passes import (
    CocPasses,
    CocTileMinMax,
    DepthToCoc,
)
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.graph import plan_effect
from vrcomfort.tradeoff.brute_force import Reference

NEAR_M = 0.02
LEFT_EYE = Fov(*np.arctan([-1.2, 0.9, 1.0, -1.1]).tolist())
distances = st.floats(0.05, 2e4)

LEVELS = {"EXACT_PX": 3.0, "WIDER": 1.5, "LEVELS": 1, "FADED": 0.85}
"""What tiles are told of levels that nothing here reads."""


def radius_px(distance_m, **settings):
    depth = NEAR_M / np.asarray(distance_m, float)
    wide = {"near_m": NEAR_M, "max_radius_px": 1e12, "infinity_m": 1e6, **settings}
    return lens_radius_px(depth, **wide)


def test_a_camera_lens_by_hand():
    # 50 mm, opening 20 mm, focused at 2 m. On the sensor a point at 4 m has a disc of
    # 0.02 · 0.05 · 2 / (4 · 1.95) m; with 600 px per focal length that is 600 / 0.05 px per metre.
    on_sensor_m = 0.02 * 0.05 * 2.0 / (4.0 * 1.95)
    lens = {"px_per_dioptre": 0.01 * 600, "focal_length_m": 0.05}
    assert radius_px(4.0, focus_m=2.0, **lens) == pytest.approx(on_sensor_m * 600 / 0.05 / 2)
    px = coc.thin_lens_px_per_dioptre(0.02, 0.05, 600, 2.0)
    assert radius_px(4.0, focus_m=2.0, **lens) == pytest.approx(px * (1 / 2 - 1 / 4))


def test_an_eye_by_hand():
    """A 4 mm pupil in front of 916 px of focal length: 3.7 px of diameter per dioptre."""
    px = coc.eye_px_per_dioptre(4.0, 916)
    assert 2 * px == pytest.approx(3.664)
    found = radius_px([0.5, 1.0, 2.0, np.inf], px_per_dioptre=px, focus_m=1.0)
    np.testing.assert_allclose(found, [-1.832, 0, 0.916, 1.832], atol=1e-5)


@given(st.floats(1e-4, 1.0), st.floats(1e-3, 0.2), st.floats(0.0, 1.0), distances, distances)
def test_both_prints_of_the_thin_lens_agree(aperture_m, focal_m, offset_m, focus_m, distance_m):
    """Hillaire's Eq. 1 and Mantiuk's signed one, from the lens: 60 cm behind, in his case."""
    f_d, z = focus_m + offset_m, distance_m + offset_m
    if f_d <= coc.CLOSEST_FOCUS * focal_m:
        return
    hillaire = aperture_m * focal_m * abs(f_d - z) / (z * (f_d - focal_m))
    mantiuk = aperture_m * focal_m / (f_d - focal_m) * (1 - f_d / z)
    found = radius_px(
        distance_m, px_per_dioptre=aperture_m / 2 * 500, focus_m=focus_m, focal_length_m=focal_m,
        distance_offset_m=offset_m,
    )  # fmt: skip
    px_per_m = 500 / focal_m / 2
    tolerance = {"rel": 1e-6, "abs": 1e-6 * aperture_m * 500 / f_d}
    assert abs(found) == pytest.approx(hillaire * px_per_m, **tolerance)
    assert found == pytest.approx(mantiuk * px_per_m, **tolerance)


@pytest.mark.parametrize("focus_m", [0.0001, 0.049, 0.05, 0.05001])
def test_no_lens_is_focused_inside_its_focal_length(focus_m):
    assert coc.lens_focus_m(focus_m, 0.05) == pytest.approx(0.05005)
    found = radius_px(
        [0.0501, 1.0, np.inf], px_per_dioptre=6.0, focus_m=focus_m, focal_length_m=0.05,
        max_radius_px=11.0,
    )  # fmt: skip
    np.testing.assert_allclose(found, [11, 11, 11], rtol=1e-12)


LAWS = {
    "eye": {"law": "eye", "pupil_mm": 7.0},
    "thin_lens": {"law": "thin_lens", "aperture_m": 0.03, "focal_length_m": 0.05},
    "mantiuk": {"law": "thin_lens", "aperture_m": 0.019, "distance_offset_m": 0.6},
    "dioptre": {"law": "dioptre", "full_blur_dioptre": 2.0},
}


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("near_m", [0.001, 0.02, 0.5])
def test_shader_radii_are_the_twins(ctx, name, near_m):
    """Within 1e-5 or 0.001 px of float64, where no radius is beyond 100 px."""
    settings = DepthOfField(max_radius_percent=10, **LAWS[name])
    distance = np.geomspace(max(near_m, 0.05), 3e4, 2000).reshape(40, 50)
    rgb = np.zeros((40, 50, 3))
    colour, depth = textures(ctx, rgb, distance, near_m)
    _, fours = textures(ctx, np.zeros((80, 100, 3)), np.kron(distance, np.ones((2, 2))), near_m)
    z = (near_m / distance).astype("f4").astype(float)
    eye_pose = Pose(np.array([0.03, 0.0, -0.01]))
    focal_px = focal_length_px(LEFT_EYE, (50, 40))[0]
    for focus_m in (0.01, 0.05, 0.6, 2.0, 40.0, 3e4, np.inf):
        focus = ctx.texture((1, 1), 4, np.full(4, focus_m, "f4").tobytes(), dtype="f4")
        reads = {"depth": depth, "focus": focus}
        effect = CocPasses(EffectInputs(ctx, settings, colour, reads, 3e4))
        # The record's shader on tiles of four equal pixels: float32, before any limit.
        radii = DepthToCoc(EffectInputs(ctx, settings, colour, reads | {"depth": fours}, 3e4))
        largest = CocTileMinMax(ctx, radii, size_px=(100, 80), tile_px=2, defines=LEVELS)
        radii.see_with(seen(LEFT_EYE, near_m=near_m, head_from_eye=eye_pose).camera)
        largest.render()
        found = np.frombuffer(largest.target.read(), "f4").reshape(40, 50, 4)[..., 2] / 2
        px = lens_radius.px_per_dioptre(
            settings, focal_px=focal_px, size_px=(50, 40), focus_m=np.inf
        )
        twin = lens_radius_px(
            z, px_per_dioptre=px, focus_m=float(np.float32(focus_m)),
            near_m=np.float64(np.float32(near_m)), max_radius_px=1e9,
            offset_m=float(np.float32(0.01)),
            focal_length_m=settings.focal_length_m if settings.law == "thin_lens" else 0.0,
            distance_offset_m=settings.distance_offset_m,
        )  # fmt: skip
        small = np.abs(twin) <= 100
        np.testing.assert_allclose(found[small], np.abs(twin[small]), rtol=1e-5, atol=1e-3)
        effect.render(seen(LEFT_EYE, near_m=near_m, head_from_eye=eye_pose).camera)
        points = np.frombuffer(effect.colour_and_coc.read(), "f2").reshape(40, 50, 4)[..., 3]
        np.testing.assert_allclose(points, np.clip(twin, -5, 5), rtol=1e-3, atol=2e-3)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("peripheral", [None, Peripheral(unit_diameter_arcmin=300.0)])
def test_tiles_hold_the_radii_of_their_pixels(ctx, name, peripheral):
    """In a canted eye with sides of its own, at a size that is no multiple of the tiles'."""
    size_px = (61, 45)
    distance = np.exp(np.random.default_rng(5).uniform(-1, 5, size_px[::-1]))
    distance[:16] = np.inf
    distance[16:32] = 2.0
    settings = DepthOfField(max_radius_percent=10, peripheral=peripheral, **LAWS[name])
    effect = coc_passes_of(ctx, settings, distance, 2.0, size_px)
    turned = Pose(np.array([0.03, 0.0, -0.01]), axis_angle([0.0, 1.0, 0.0], 0.2))
    effect.render(seen(LEFT_EYE, near_m=NEAR_M, head_from_eye=turned).camera)
    radii = (
        np.frombuffer(effect.colour_and_coc.read(), "f2").reshape(45, 61, 4)[..., 3].astype(float)
    )
    tiles = np.frombuffer(effect.tile_min_max.read(), "f4").reshape(6, 8, 4)
    assert effect.tile_px == 8
    for row, column in np.ndindex(6, 8):
        inside = radii[8 * row : 8 * row + 8, 8 * column : 8 * column + 8]
        least, greatest, largest, _ = tiles[row, column]
        slack = 1e-3 * max(1, largest)
        assert least - slack <= inside.min() <= inside.max() <= greatest + slack
        if peripheral is None:  # and no wider than a tile of a canted eye, or a pixel beside it, is
            around = radii[8 * row : 8 * row + 10, 8 * column : 8 * column + 10]
            assert greatest - around.max() <= 0.5
            assert around.min() - least <= 0.5


def test_the_largest_diameter_can_be_an_angle(ctx):
    size_px = (64, 48)
    focal_px = focal_length_px(square_pixels(size_px), size_px)[0]
    settings = DepthOfField(max_radius_percent=10, max_diameter_arcmin=120.0)
    assert lens_radius.max_radius_of(settings, size_px, focal_px) == pytest.approx(
        np.tan(np.radians(1.0)) * focal_px
    )
    effect = coc_passes_of(ctx, settings, np.inf, 1.0, size_px)
    effect.render(seen(square_pixels(size_px), near_m=NEAR_M, head_from_eye=Pose()).camera)
    points = np.frombuffer(effect.colour_and_coc.read(), "f2").reshape(48, 64, 4)[..., 3]
    np.testing.assert_allclose(points, np.tan(np.radians(1.0)) * focal_px, rtol=1e-3)
    assert effect.max_radius_now_px == pytest.approx(np.tan(np.radians(1.0)) * focal_px)
    # Law `linear`: 10 m of defocus reach the limit; the sky would have 2999.9 times as much.
    max_radius_px = np.tan(np.radians(1.0)) * focal_px
    assert effect.largest_radius_px() == pytest.approx(2999.9 * max_radius_px, rel=1e-5)
    assert effect.clamps() == (
        f"depth of field: circles of confusion of up to {2999.9 * max_radius_px:.1f} px (radius) "
        f"were limited to {max_radius_px:.1f} px",
    )
    effect.reset()
    assert effect.clamps() == ()
    # A narrower field of view has more pixels to the minute of arc; its own limit is the one told.
    effect.render(seen(Fov(-0.2, 0.2, 0.15, -0.15), near_m=NEAR_M, head_from_eye=Pose()).camera)
    narrow_px = np.tan(np.radians(1.0)) * 32 / np.tan(0.2)
    assert effect.clamps()[0].endswith(f"limited to {narrow_px:.1f} px")


@pytest.mark.parametrize("law", ["linear", "dioptre"])
def test_the_smaller_of_both_limits_is_what_full_blur_reaches(ctx, law):
    """At half of the defocus that is full blur, half of r_max, however r_max is given."""
    size_px = (64, 48)
    focal_px = focal_length_px(square_pixels(size_px), size_px)[0]
    settings = DepthOfField(
        law=law,
        full_blur_m=2.0,
        full_blur_dioptre=1.0,
        max_radius_percent=10,
        max_diameter_arcmin=120.0,
    )
    effect = coc_passes_of(ctx, settings, 2.0, 1.0, size_px)
    effect.render(seen(square_pixels(size_px), near_m=NEAR_M, head_from_eye=Pose()).camera)
    points = np.frombuffer(effect.colour_and_coc.read(), "f2").reshape(48, 64, 4)[..., 3]
    np.testing.assert_allclose(points, 0.5 * np.tan(np.radians(1.0)) * focal_px, rtol=1e-3)


def test_a_lens_without_an_opening_needs_no_pass():
    for settings in ({"law": "eye", "pupil_mm": 0.0}, {"law": "thin_lens", "aperture_m": 0.0}):
        for shape, needed in ((None, False), (Peripheral(), True)):
            effect = DepthOfField(peripheral=shape, **settings)
            condition = Condition(name="c", depth_of_field=effect)
            assert plan_effect("depth_of_field", still_life(), condition).needed is needed


@pytest.mark.parametrize("name", ["eye", "thin_lens", "mantiuk"])
def test_the_reference_blurs_as_much_as_the_law_says(ctx, name):
    """Second moments of a small square, less those without a lens: a disc of the law's radius."""
    nodes = [at(0, 0, -2.0)]
    content = scene(nodes, [wall(0.25)], [glowing((1.0, 1.0, 1.0))])
    scale = {
        "eye": {"pupil_mm": 20.0},
        "thin_lens": {"aperture_m": 0.01},
        "mantiuk": {"aperture_m": 0.2},
    }
    effect = DepthOfField(**LAWS[name] | scale[name])
    condition = Condition(name="c", focus=Focus(infinity_m=1e4), depth_of_field=effect)
    size_px = (160, 160)
    camera = eye()
    truth = Reference(ctx, content, condition, size_px)
    pinhole = Reference(ctx, content, Condition(name="p"), size_px)
    blurred = truth.render(camera, 0.0, None, focus_m=0.1, samples=64).image[..., 0]
    sharp = pinhole.render(camera, 0.0, None, focus_m=0.1, samples=1).image[..., 0]
    x = np.arange(160) - 79.5

    def moment(image):
        return (image * x**2).sum() / image.sum()

    focal_px = 80
    px = lens_radius.px_per_dioptre(effect, focal_px=focal_px, size_px=size_px, focus_m=0.1)
    offset_m = effect.distance_offset_m
    radius = px * (1 / (0.1 + offset_m) - 1 / (2.0 + offset_m))
    assert radius > 7
    assert moment(blurred) - moment(sharp) == pytest.approx(radius**2 / 4, rel=0.03)


@pytest.mark.parametrize(
    ("size_px", "corner"),
    [
        ((1, 1), (0, 0)),
        ((7, 5), (-1, -1)),
        ((33, 17), (0, -1)),
        ((33, 17), (-1, 0)),
        ((50, 40), (-1, -1)),
    ],
)
def test_the_largest_radius_is_found_wherever_it_is(ctx, size_px, corner):
    width, height = size_px
    distance = np.full((height, width), 2.0)
    distance[corner] = 0.5
    settings = DepthOfField(law="eye", pupil_mm=20.0, max_radius_percent=1.0)
    effect = coc_passes_of(ctx, settings, distance, 2.0, size_px)
    fov = Fov(-0.5, 0.5, 0.4, -0.4)
    effect.render(seen(fov, near_m=NEAR_M, head_from_eye=Pose()).camera)
    px = coc.eye_px_per_dioptre(20.0, focal_length_px(fov, size_px)[0])
    assert effect.largest_radius_px() == pytest.approx(1.5 * px, rel=1e-5)
    assert effect.clamps()[0].endswith(f"limited to {0.01 * width:.1f} px")
