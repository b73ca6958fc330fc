"""The oracle against analysis, and our blurs against the oracle, on a scene made by hand."""

import numpy as np
import pytest

from vrcomfort.geometry import Fov, Pose, axis_angle
from vrcomfort.optics.lens_sampling import concentric_disc, low_discrepancy
from vrcomfort.protocol.conditions import (
    Condition,
    DepthOfField,
    MotionBlur,
    Peripheral,
    SpeedBlur,
    TurnRamp,
)
from vrcomfort.render.camera import EyeCamera, PreviousCamera
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Environment, Material, Node, Primitive, Scene
from vrcomfort.tradeoff.brute_force import Accumulator, Reference, read_rgb

SIZE_PX = (64, 48)
FOV = Fov(*np.arctan([-1.0, 1.0, 0.75, -0.75]))  # focal length 32 px both ways
CAMERA = EyeCamera(Pose(), FOV)
DARK = Environment(
    sun_irradiance=(0, 0, 0), sky_zenith=(0, 0, 0), sky_horizon=(0, 0, 0), ground=(0, 0, 0)
)
LENS = DepthOfField(law="dioptre", max_radius_percent=10.0, full_blur_dioptre=0.8)
"""At 64 px: 8 px of radius per dioptre."""


def half_plane(distance_m, *, head_locked=False):
    """Return a scene: everything left of the middle glows white, at one distance."""
    far = 40 * distance_m
    corners = [[-far, -far, 0], [0, -far, 0], [0, far, 0], [-far, far, 0]]
    quad = Primitive(
        positions=np.array(corners, np.float32),
        normals=np.tile(np.float32([0, 0, 1]), (4, 1)),
        uvs=np.zeros((4, 2), np.float32),
        colors=None,
        indices=np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        material=0,
    )
    black = Material(base_color=(0, 0, 0, 1), emissive=(1, 1, 1), double_sided=True)
    place = Node(
        "wall", translation=np.array([0, 0, -distance_m]), mesh=(0,), head_locked=head_locked
    )
    return Scene("half plane", (place,), (quad,), (black,), environment=DARK)


def accumulate(ctx, scene, *, camera=CAMERA, previous=None, focus_m=1.0, samples=1024, **effects):
    condition = Condition(name="test", **effects)
    reference = Reference(ctx, scene, condition, SIZE_PX)
    return reference.render(camera, 0.0, previous, focus_m=focus_m, samples=samples)


def test_samples_fill_the_disc_evenly():
    points = concentric_disc(low_discrepancy(4096, [0.1, 0.7]))
    radius = np.hypot(*points.T)
    assert radius.max() <= 1
    np.testing.assert_allclose(points.mean(axis=0), 0, atol=2e-3)
    np.testing.assert_allclose(np.mean(radius**2), 0.5, atol=2e-3)
    assert np.all(low_discrepancy(100, [0.0, 0.5, 0.9]) >= 0)


@pytest.mark.slow
@pytest.mark.parametrize("distance_m", [0.6, 2.0])
def test_an_edge_out_of_focus_is_the_disc_integral(ctx, distance_m):
    found = accumulate(ctx, half_plane(distance_m), depth_of_field=LENS)
    radius_px = 8 * abs(1 - 1 / distance_m)
    x = np.clip((np.arange(64) - 31.5) / radius_px, -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    profile = found.image[:, :, 0].mean(axis=0)
    assert np.abs(profile - covered).max() < 0.01


def test_an_edge_in_focus_is_the_pinhole_image(ctx):
    scene = half_plane(1.0)
    found = accumulate(ctx, scene, depth_of_field=LENS, samples=8)
    plain = ScenePass(ctx, scene, SIZE_PX, velocity=False)
    plain.render(CAMERA, 0.0)
    np.testing.assert_allclose(found.image, read_rgb(plain.colour), atol=0.26)  # one MSAA sample
    assert np.mean(np.abs(found.image - read_rgb(plain.colour))) < 1e-3


@pytest.mark.slow
def test_a_moving_edge_is_a_ramp_over_the_open_shutter(ctx):
    """0.5 m per frame to the right at 2 m: the edge moves 8 px to the left, half of it open."""
    previous = PreviousCamera(Pose(np.array([-0.5, 0, 0])), 0.0)
    blur = MotionBlur(mode="full", shutter_fraction=0.5)
    found = accumulate(ctx, half_plane(2.0), previous=previous, motion_blur=blur)
    ramp = np.clip(0.5 - (np.arange(64) - 31.5) / 4, 0, 1)
    np.testing.assert_allclose(found.image[:, :, 0].mean(axis=0), ramp, atol=0.05)


def test_what_is_locked_to_the_head_stays_sharp(ctx):
    turned = PreviousCamera(Pose(np.array([0.1, 0, 0.2]), axis_angle([0, 1, 0], 0.3)), 0.0)
    blur = MotionBlur(mode="full", shutter_fraction=1.0)
    scene = half_plane(2.0, head_locked=True)
    moving = accumulate(ctx, scene, previous=turned, motion_blur=blur, samples=8).image
    still = accumulate(ctx, scene, samples=2).image
    np.testing.assert_allclose(moving, still, atol=1e-3)


def test_halves_agree_better_with_more_samples(ctx):
    scene = half_plane(2.0)
    errors = []
    for samples in (16, 256):
        first, second = accumulate(ctx, scene, depth_of_field=LENS, samples=samples).halves
        errors.append(np.sqrt(np.mean((first - second) ** 2)))
    assert errors[1] < errors[0] / 4


def test_the_linear_law_says_what_it_cannot_do(ctx):
    linear = LENS.model_copy(update={"law": "linear"})
    condition = Condition(name="test", depth_of_field=linear)
    assert "vertices" in Reference(ctx, half_plane(2.0), condition, SIZE_PX).note


def test_what_the_reference_leaves_out_is_named(ctx):
    condition = Condition(
        name="test",
        depth_of_field=LENS.model_copy(update={"law": "eye", "peripheral": Peripheral()}),
        motion_blur=MotionBlur(fade_with_turning=TurnRamp(from_deg_s=60, to_deg_s=180)),
        speed_blur=SpeedBlur(turning=TurnRamp(from_deg_s=40, to_deg_s=90)),
    )
    note = Reference(ctx, half_plane(2.0), condition, SIZE_PX).note
    assert note == (
        "law eye: the lens is exact; r_max does not limit it; peripheral blur is left out; "
        "fading with turning is left out; speed blur is left out"
    )
    plain = condition.model_copy(update={"depth_of_field": None, "speed_blur": None})
    told = Reference(ctx, half_plane(2.0), plain, SIZE_PX).note
    assert told == "no lens; fading with turning is left out"


def test_going_on_gives_the_same_bits_as_drawing_at_once(ctx):
    """From 7 samples, where the halves differ by one, to 20."""
    condition = Condition(name="test", depth_of_field=LENS)
    reference = Reference(ctx, half_plane(2.0), condition, SIZE_PX)
    at_once = reference.render(CAMERA, 0.0, None, focus_m=1.0, samples=20)
    part = reference.render(CAMERA, 0.0, None, focus_m=1.0, samples=7)
    seen = []
    on = reference.render(
        CAMERA,
        0.0,
        None,
        focus_m=1.0,
        samples=20,
        start=Accumulator(SIZE_PX, part.sums.copy(), part.samples),
        on_sample=lambda sums: seen.append(sums.samples),
    )
    np.testing.assert_array_equal(on.sums, at_once.sums)
    assert seen == list(range(8, 21))


def test_the_mean_is_the_mean_of_the_halves():
    sums = Accumulator((1, 1))
    for value in (1.0, 2.0, 4.0, 8.0):
        sums.add(np.full((1, 1, 3), value))
    first, second = sums.halves
    assert (first[0, 0, 0], second[0, 0, 0], sums.image[0, 0, 0]) == (2.5, 5.0, 3.75)


def test_an_identity_changes_with_what_the_picture_depends_on_and_nothing_else(ctx):
    def identity(focus_m=1.0, **settings):
        lens = LENS.model_copy(update=settings)
        reference = Reference(
            ctx, half_plane(2.0), Condition(name="test", depth_of_field=lens), SIZE_PX
        )
        return reference.identity(CAMERA, 0.0, None, focus_m=focus_m)

    assert identity() == identity(samples=16)
    assert identity() != identity(full_blur_dioptre=0.9)
    assert identity() != identity(focus_m=1.1)
