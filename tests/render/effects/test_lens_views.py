"""The dial from fast to reference: depth of field as the mean of views through the lens."""

import numpy as np
import pytest
from pydantic import ValidationError

from tests.tradeoff.test_brute_force import FOV, SIZE_PX, half_plane
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, View
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.optics.lens_sampling import FEW_RADIUS, view_radius
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.effects.depth_of_field import effect
from vrcomfort.render.effects.depth_of_field.effect import blur_of_one_view, part_of_one_view
from vrcomfort.render.effects.depth_of_field.lens_radius import (
    max_radius_of,
    radius_per_dioptre_px,
    unlimited,
)
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace
from vrcomfort.tradeoff.brute_force import Reference, read_rgb

LENS_FIRST = ("depth_of_field", "motion_blur")

FOCUS = Focus(method="fixed", fixed_m=1.0)
LENS = {"law": "dioptre", "max_radius_percent": 10.0, "full_blur_dioptre": 0.8}
"""At 64 px: 8 px of radius per dioptre, at most 6.4 px in a filter."""


def condition(views, focus=FOCUS, motion_blur=None, order=LENS_FIRST, **settings):
    return Condition(
        name="views",
        focus=focus,
        depth_of_field=DepthOfField(**LENS, views=views, **settings),
        motion_blur=motion_blur,
        effect_order=order,
    )


def standing(index=0, x_m=0.0):
    head = Pose(np.array([x_m, 0.0, 0.0]))
    eye = View(head, FOV)
    return Frame(index, index * 11_111_111, 11_111_111, head, (eye, eye), Pose())


def drawn(ctx, scene, condition, frames, size_px=SIZE_PX):
    """Return the last frame's left eye: pinhole and result, (h, w, 3) each."""
    found = []
    renderer = StereoRenderer(ctx, size_px)
    renderer.build(scene, condition)
    for frame in frames:
        renderer.render(
            frame,
            frame.index / 90,
            lambda eye, images: eye or found.append((images.pinhole, images.linear)),
        )
    return [read_rgb(texture) for texture in found[-1]]


def test_a_law_without_a_lens_has_one_view():
    with pytest.raises(ValidationError, match='views > 1 needs law = "dioptre"'):
        DepthOfField(views=4)


@pytest.mark.parametrize("distance_m", [0.6, 2.0])
def test_an_edge_is_the_disc_integral_wherever_the_gpu_finds_the_focus(ctx, distance_m):
    """The nine rays meet the wall, so focus is there; fixed focus is a metre away."""
    scene = half_plane(distance_m)
    blurred = drawn(ctx, scene, condition(32), [standing()])[1][:, :, 0]
    x = np.clip((np.arange(64) - 31.5) / (8 * abs(1 - 1 / distance_m)), -1, 1)
    covered = 0.5 - (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi
    assert np.sqrt(np.mean((blurred.mean(axis=0) - covered) ** 2)) < 0.012
    rays = Focus(method="nine_ray", law="instant")
    walk = [standing(index, -0.3) for index in range(2)]
    sharp = drawn(ctx, scene, condition(4, focus=rays), walk)
    np.testing.assert_allclose(sharp[1], sharp[0], atol=0.26)  # one MSAA sample
    assert np.mean(np.abs(sharp[1] - sharp[0])) < 4e-3


@pytest.mark.parametrize("views", [2, 4, 16])
def test_views_leave_the_centre_view_behind(ctx, views):
    """Motion blur, depth layer and files read the pinhole's colour, depth and velocity."""
    one, many = (drawn(ctx, half_plane(2.0), condition(k), [standing()])[0] for k in (1, views))
    np.testing.assert_array_equal(one, many)


@pytest.mark.parametrize("order", [LENS_FIRST, LENS_FIRST[::-1]])
def test_what_is_in_focus_moves_as_without_views(ctx, order):
    blur = MotionBlur(mode="full", shutter_fraction=1.0, max_radius_percent=20.0)
    walk = [standing(), standing(1, 0.2)]
    one, many = (
        drawn(ctx, half_plane(1.0), condition(k, motion_blur=blur, order=order), walk)
        for k in (1, 4)
    )
    assert np.mean(np.abs(one[1] - one[0])) > 0.01
    np.testing.assert_allclose(many[1], one[1], atol=0.26)
    assert np.mean(np.abs(many[1] - one[1])) < 6e-3


@pytest.mark.parametrize(("views", "radii"), [(1, "40.0 px"), (4, "38.8 px")])
def test_the_limit_is_told_of_what_it_limits(ctx, views, radii):
    """The sky, focused at 0.2 m: 5 dioptres of 8 px. 0.97 of that in each of four views."""
    renderer = StereoRenderer(ctx, SIZE_PX, eyes=1)
    renderer.build(half_plane(2.0), condition(views, focus=Focus(method="fixed", fixed_m=0.2)))
    rendered = renderer.render(standing(), 0.0)
    (told,) = renderer.clamps()
    assert radii in told
    many = " in each of 4 views through the lens; their mean has no limit"
    assert told.endswith(f"limited to 6.4 px{'' if views == 1 else many}")
    assert rendered.max_blur_px == (pytest.approx(6.4) if views == 1 else None)


@pytest.mark.slow
def test_views_go_beyond_the_limit_alike_and_one_view_does_not(ctx):
    """2.1 dioptres out of focus: 16.8 px of radius, of which one view may have 6.4."""
    near = Focus(method="fixed", fixed_m=0.385)
    widths = {}
    for views in (1, 16, 64):
        blurred = drawn(ctx, half_plane(2.0), condition(views, focus=near), [standing()])[1]
        profile = blurred[:, :, 0].mean(axis=0)
        widths[views] = np.sum((profile > 0.02) & (profile < 0.98))
    assert widths[1] <= 13
    assert widths[16] >= 2 * widths[1]
    assert abs(int(widths[16]) - int(widths[64])) <= 2


@pytest.mark.parametrize("law", ["dioptre", "eye"])
def test_a_condition_tells_where_its_views_have_no_limit(law):
    """1.75 % of the width: 2 D by definition; 17.5 D of a pupil's 4 mm, 0.1 % of it each."""
    lens = DepthOfField(law=law, views=16, max_radius_percent=1.75)
    dioptre = {"dioptre": 2.0, "eye": 17.5}[law]
    near = Condition(name="n", focus=Focus(method="fixed", fixed_m=0.05), depth_of_field=lens)
    found = unlimited(near)
    assert found.limit_dioptre == pytest.approx(dioptre)
    (only,) = found.ranges
    assert only.nearer_than_m == pytest.approx(1 / (20 + dioptre))
    assert only.farther_than_m == pytest.approx(1 / (20 - dioptre))
    assert ("90° wide" in found.text) == (law == "eye")
    assert unlimited(near.model_copy(update={"focus": Focus()})).ranges[1][0::2] == (1.0, None)
    one = lens.model_copy(update={"views": 1})
    assert unlimited(Condition(name="one", depth_of_field=one)) is None


def test_nothing_is_told_of_limits_nearer_than_anything_is_drawn():
    lens = DepthOfField(law="eye", views=16, pupil_mm=1.0, max_radius_percent=10)
    assert unlimited(Condition(name="far", depth_of_field=lens)) is None


@pytest.mark.slow
def test_views_cost_two_textures_and_the_plan_says_so(ctx, count_objects, monkeypatch):
    monkeypatch.setattr(effect, "BEHIND_PX", 1e9)  # one view alone draws what is behind near things
    scene = half_plane(2.0)
    counts = []
    # A view of 256 with half the blur has at most 0.3 px of it, which is a copy: no filter at all.
    for views in (1, 4, 256):
        before = count_objects()["Texture"]
        renderer = StereoRenderer(ctx, SIZE_PX)
        renderer.build(scene, condition(views, over_blur=0.5 if views > 4 else 1.0))
        counts.append(count_objects()["Texture"] - before)
        del renderer
    one, four, many = counts
    assert four == one + 2
    assert many < one
    reasons = {item.name: item.reason for item in plan_passes(scene, condition(4))}
    assert reasons["depth_of_field"] == "the scene is drawn in 4 views through the lens of each eye"


def test_views_a_pixel_apart_are_not_blurred():
    lens = DepthOfField(law="dioptre", max_radius_percent=3.5, full_blur_dioptre=2.0, views=256)
    assert part_of_one_view(lens, (320, 400)) == 0.0  # 0.7 px at a dioptre
    assert part_of_one_view(lens, (640, 800)) == view_radius(256)
    assert blur_of_one_view(lens, (320, 400)) is None
    one = lens.model_copy(update={"views": 1})
    assert blur_of_one_view(one, (4, 5)) == one


def test_it_is_the_law_that_says_how_little_is_not_blurred():
    """A pupil of 4 mm: 1.8 px of 1832 at a dioptre, whatever the limit."""
    size_px = (1832, 1920)
    pupil = DepthOfField(law="eye", max_radius_percent=10.0, views=64)
    assert part_of_one_view(pupil, size_px) == 0.0  # 0.46 px
    assert part_of_one_view(pupil.model_copy(update={"views": 16}), size_px) == 0.5  # 0.92 px
    few = pupil.model_copy(update={"views": 4})
    assert part_of_one_view(few, (320, 400)) == FEW_RADIUS  # four points would be seen as such


@pytest.mark.parametrize(
    ("settings", "size_px"),
    [
        ({"law": "dioptre", "views": 16, "max_radius_percent": 3.5}, (320, 400)),
        ({"law": "dioptre", "views": 64}, (1832, 1920)),
        ({"law": "eye", "views": 16, "max_radius_percent": 5.0}, (1832, 1920)),
    ],
)
def test_a_view_is_blurred_by_its_part_of_the_lens_up_to_the_same_limit(settings, size_px):
    lens = DepthOfField(**settings)
    one = blur_of_one_view(lens, size_px)
    assert max_radius_of(one, size_px) == max_radius_of(lens, size_px)
    assert one.samples == lens.samples
    if lens.law == "eye":
        assert radius_per_dioptre_px(one, size_px) == pytest.approx(
            part_of_one_view(lens, size_px) * radius_per_dioptre_px(lens, size_px)
        )


@pytest.mark.slow
def test_the_dial_turns_towards_the_reference(ctx):
    """Error falls with every step; two views are none (docs/depth_of_field.md)."""
    size_px = (48, 60)
    scene = load_scene("temple")
    trace = read_trace(data_folder("scenes") / "temple_walk.csv")
    frame = next(iter(PlaybackHeadset(trace, image_size_px=size_px, spawn=scene.spawn).frames()))
    focus = Focus(method="fixed", fixed_m=1.5)
    camera = []

    def image(views):
        blur = condition(views, focus=focus)
        renderer = StereoRenderer(ctx, size_px, eyes=1)
        renderer.build(scene, blur)
        found = []
        renderer.render(
            frame, 0.0, lambda eye, im: eye or found.append((im.camera, read_rgb(im.linear)))
        )
        camera[:] = [found[0][0]]
        return found[0][1]

    images = {views: image(views) for views in (1, 3, 4, 8, 16, 64)}
    reference = Reference(ctx, scene, condition(1, focus=focus), size_px)
    truth = reference.render(camera[0], 0.0, None, focus_m=1.5, samples=256).image
    inside = slice(8, -8)
    errors = [
        np.sqrt(np.mean(np.minimum(abs(image - truth), 1)[inside, inside] ** 2))
        for image in images.values()
    ]
    assert np.all(np.diff(errors) < 0), errors
    assert errors[-1] < 0.6 * errors[0]
