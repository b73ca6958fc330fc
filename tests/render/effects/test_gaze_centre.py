"""Effects that are centred on the gaze: what they follow, and what they do when it is lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles import circle_of_confusion as coc
from tests.oracles.autofocus_zone import zone_focus_m
from tests.oracles.vignette import angles_rad, cover
from tests.support.effects import coc_passes_of, rgb_of, seen, textures
from tests.support.render import at, glowing, scene, still_life, wall
from tests.support.study import read_rows, tiny_protocol
from vrcomfort.api.playback import require_eye_tracker
from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Gaze, Pose, View, axis_angle, focal_length_px, yaw_pitch_roll
from vrcomfort.optics import autofocus_zone as zone
from vrcomfort.optics.focus import AHEAD, GazeFollower
from vrcomfort.protocol import Condition, DepthOfField
from vrcomfort.protocol.conditions import Focus, Peripheral, Vignette
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.effects.vignette import VignettePass
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer

NEAR_M = 0.02
LEFT_EYE = Fov(*np.arctan([-1.2, 0.9, 1.0, -1.1]).tolist())
CANTED = Pose((-0.03, 0.0, 0.0), axis_angle([0, 1, 0], np.radians(10)))
ZONE = Focus(method="autofocus_zone", law="instant")
MS = 1_000_000


def looking(yaw_deg, pitch_deg=0.0, *, valid=True):
    turn = yaw_pitch_roll(*np.radians([yaw_deg, pitch_deg, 0.0]))
    return Gaze(Pose(np.zeros(3), turn), valid=valid)


BLINK = looking(0.0, valid=False)


def test_a_gaze_that_is_lost_is_held_and_then_the_head_counts():
    centre, aside = GazeFollower(0.2), looking(15.0, -5.0)
    assert centre.at(BLINK, 0).source == "head"  # never seen yet
    followed = centre.at(aside, 10 * MS)
    assert followed.source == "gaze"
    np.testing.assert_allclose(followed.direction, aside.pose.forward)
    for time_ns, source in ((20, "held"), (210, "held"), (211, "head"), (400, "head")):
        found = centre.at(BLINK, time_ns * MS)
        assert found.source == source
        expected = aside.pose.forward if source == "held" else AHEAD
        np.testing.assert_allclose(found.direction, expected)
    assert centre.at(aside, 410 * MS).source == "gaze"
    assert centre.at(None, 420 * MS).source == "held"  # a tracker that went away
    assert centre.at(BLINK, 5 * MS).source == "head"  # another exposure: time goes back


def test_nobody_looks_behind():
    assert GazeFollower(1.0).at(looking(100.0), 0).source == "head"
    assert GazeFollower(1.0).at(looking(60.0), 0).tangents[0] == pytest.approx(-np.sqrt(3))


tangent = st.floats(-4, 4)


@given(tangent, tangent, st.floats(0.3, 2), st.floats(0.3, 2), st.floats(0.01, 1))
def test_a_zone_stays_in_the_image_and_moves_no_further_than_it_must(x, y, width, height, ratio):
    found = zone.kept_within((x, y), (width, height), ratio)
    for at_m, wanted, side in zip(found, (x, y), (width, height), strict=True):
        assert abs(at_m) + ratio * side <= side * (1 + 1e-9)
        if abs(wanted) + ratio * side <= side:
            assert at_m == wanted


def board_aside():
    """A board of 0.3 m at 2 m whose middle is at tangents (0.45, 0.2), before a wall at 10 m."""
    nodes = [
        at(0.0, 0.0, -10.0, scale=np.full(3, 60.0)),
        at(0.9, 0.4, -2.0, scale=np.full(3, 0.3), semantic_weight=1.0),
    ]
    return scene(nodes, [wall()], [glowing((1.0, 1.0, 1.0))])


def focus_of(ctx, settings, centre, *, along_ray=False):
    gpu = GpuScene(ctx, board_aside())
    focus = make_focus_pass(ctx, gpu, settings, near_m=NEAR_M, along_ray=along_ray)
    gpu.update(0.0, Pose())
    focus.render(HeadView(0, 0, Pose(), screen_tangents=(1.0, 0.8), zone_centre=centre))
    (found,) = focus.drain()
    return found.focus_m


def by_hand(settings, centre, *, along_ray):
    """The same picture, painted: which texels of the zone the board covers."""
    width, height = settings.zone_size_px
    half = settings.zone_ratio, 0.8 * settings.zone_ratio
    x = centre[0] + ((2 * np.arange(width) + 1) / width - 1) * half[0]
    y = centre[1] + ((2 * np.arange(height) + 1) / height - 1) * half[1]
    hit = (np.abs(x - 0.45) < 0.075)[None, :] & (np.abs(y - 0.2) < 0.075)[:, None]
    depth, weights = NEAR_M / np.where(hit, 2.0, 10.0), np.where(hit, 1.0, 0.004)
    place = (half, centre) if along_ray else ()
    return zone_focus_m(zone.reduced(depth, weights, NEAR_M, settings, *place), NEAR_M, settings)


@pytest.mark.parametrize("along_ray", [False, True])
@pytest.mark.parametrize("where", ["gpu", "cpu"])
@pytest.mark.parametrize("statistic", ["mean", "minimum"])
def test_the_zone_is_where_the_eyes_look(ctx, where, statistic, along_ray):
    settings = ZONE.model_copy(update={"zone_mean_on": where, "zone_statistic": statistic})
    looked = focus_of(ctx, settings, (0.45, 0.2), along_ray=along_ray)
    assert looked == pytest.approx(by_hand(settings, (0.45, 0.2), along_ray=along_ray), rel=2e-5)
    assert looked < 3.0
    ahead = focus_of(ctx, settings, (0.0, 0.0), along_ray=along_ray)
    assert ahead > 9.0  # the board is outside of the zone
    # At the image's border the zone stops: its middle is at 0.75 of the way, not beyond.
    beyond = focus_of(ctx, settings, (3.0, 0.2), along_ray=along_ray)
    assert beyond == pytest.approx(focus_of(ctx, settings, (0.75, 0.2), along_ray=along_ray))


@pytest.mark.parametrize("head_from_eye", [Pose(), CANTED])
def test_peripheral_blur_grows_from_where_the_eyes_look(ctx, head_from_eye):
    size_px = (60, 48)
    shape = Peripheral(exponent=2.0, unit_diameter_arcmin=300.0)
    settings = DepthOfField(law="eye", pupil_mm=0.0, max_radius_percent=10, peripheral=shape)
    effect = coc_passes_of(ctx, settings, 3.0, 2.0, size_px)
    axis = looking(20.0, 10.0).pose.forward
    camera = seen(LEFT_EYE, near_m=NEAR_M, head_from_eye=head_from_eye).camera
    effect.render(replace(camera, peripheral_axis=axis))
    found = read_texture(effect.colour_and_coc)[..., 3][::-1]
    left, right, up, down = LEFT_EYE.tangents
    x = left + (right - left) * (np.arange(60) + 0.5) / 60
    y = down + (up - down) * (np.arange(48) + 0.5) / 48
    rays = np.stack([*np.meshgrid(x, y), np.full((48, 60), -1.0)], axis=-1)
    in_head = rays @ head_from_eye.matrix()[:3, :3].T
    cosine = in_head @ axis / np.linalg.norm(rays, axis=-1)
    unit_px = np.tan(np.radians(2.5)) * focal_length_px(LEFT_EYE, size_px)[0]
    twin = coc.with_peripheral_px(
        np.zeros_like(cosine), cosine, unit_px=unit_px, exponent=2, max_radius_px=6
    )
    np.testing.assert_allclose(found, twin, rtol=2e-3, atol=2e-3)
    row, column = np.unravel_index(np.argmin(found), found.shape)
    assert x[column] < -0.1  # the least blur is to the left, where they look
    assert y[row] > 0.0


@pytest.mark.parametrize("head_from_eye", [Pose(), CANTED])
def test_the_vignettes_field_is_round_the_gaze(ctx, head_from_eye):
    rgb = np.random.default_rng(1).uniform(0, 4, (48, 64, 3)).astype("f2")
    colour, _ = textures(ctx, rgb, 2.0)
    settings = Vignette(open_deg=50.0, restricted_deg=50.0, feather_deg=12.0)
    effect = VignettePass(EffectInputs(ctx, settings, colour))
    eye = seen(LEFT_EYE, head_from_eye=head_from_eye)
    turned = looking(-18.0, 6.0).pose
    camera = eye.camera.__class__(
        eye.camera.world_from_eye, LEFT_EYE, NEAR_M, Pose(), vignette_axis=turned.forward
    )
    effect.render(eye._replace(camera=camera))
    angles = angles_rad(LEFT_EYE, (64, 48), turned.inverse() @ head_from_eye)
    expected = rgb * (1 - cover(angles, 50, 12.0))[..., None]
    np.testing.assert_allclose(rgb_of(effect.target), expected, atol=4e-3)


EVERYTHING = {
    "focus": ZONE,
    "depth_of_field": DepthOfField(peripheral=Peripheral(unit_diameter_arcmin=300.0)),
    "vignette": Vignette(open_deg=60.0),
}
PERIPHERAL_ONLY = DepthOfField(
    law="eye",
    pupil_mm=0.0,
    max_radius_percent=10.0,
    peripheral=Peripheral(unit_diameter_arcmin=3000.0),
)
ALL = ("autofocus_zone", "peripheral", "vignette")


def shown(index, gaze):
    head = Pose((0.0, 1.5, 3.0))
    views = tuple(
        View(head @ Pose((x, 0.0, 0.0)), Fov(-0.7, 0.7, 0.7, -0.7)) for x in (-0.03, 0.03)
    )
    in_stage = None if gaze is None else Gaze(head @ gaze.pose, gaze.valid)
    return Frame(index, index * 100 * MS, 100 * MS, head, views, Pose(), gaze=in_stage)


@pytest.fixture
def drawn(ctx):
    """Return a function that draws frames of a condition, and gives their images and centres."""

    def draw(gazes, **settings):
        renderer = StereoRenderer(ctx, (48, 48), samples=2)
        renderer.build(still_life(), Condition(name="c", **{**EVERYTHING, **settings}))
        images, centres = [], []
        for index, gaze in enumerate(gazes):
            rendered = renderer.render(shown(index, gaze), 0.0)
            images.append(np.stack([read_texture(eye) for eye in rendered.eyes]))
            centres.append(rendered.effect_centre)
        focus = [sample.focus_raw_m for sample in renderer.drain()]
        renderer.release()
        return images, centres, focus

    return draw


def test_looking_ahead_is_the_same_as_no_centre_and_a_lost_gaze_holds_then_returns(drawn):
    plain, none, plain_focus = drawn([looking(0.0)] * 3)
    assert none == [None] * 3
    table = {"of": ALL, "hold_s": 0.1}
    ahead, centres, focus = drawn([looking(0.0)] * 3, gaze_centre=table)
    assert centres == ["gaze"] * 3
    np.testing.assert_array_equal(ahead, plain)
    assert focus == plain_focus
    aside = looking(25.0, 5.0)
    images, centres, _ = drawn([aside, BLINK, BLINK, aside], gaze_centre=table)
    assert centres == ["gaze", "held", "head", "gaze"]
    assert not np.array_equal(images[0], plain[0])
    np.testing.assert_array_equal(images[1], images[0])
    np.testing.assert_array_equal(images[2], plain[2])


@pytest.mark.parametrize("name", ALL)
def test_each_of_them_moves_alone(drawn, name):
    aside = [looking(25.0, 5.0)]
    # Beside the blur of a lens, peripheral blur changes next to nothing in so small an image.
    own = {"depth_of_field": PERIPHERAL_ONLY} if name == "peripheral" else {}
    plain, _, plain_focus = drawn(aside, **own)
    moved, _, focus = drawn(aside, gaze_centre={"of": [name]}, **own)
    assert np.abs(np.subtract(moved, plain, dtype=int)).max() > 10
    assert (focus != plain_focus) == (name == "autofocus_zone")


def test_without_an_eye_tracker_it_stops_or_the_head_counts(drawn):
    with pytest.raises(InputError, match='write without_gaze = "head"'):
        drawn([None], gaze_centre={"of": ALL})
    images, centres, _ = drawn([None], gaze_centre={"of": ALL, "without_gaze": "head"})
    assert centres == ["head"]
    np.testing.assert_array_equal(images, drawn([looking(0.0)])[0])


def test_a_headset_without_eyes_is_refused_before_a_session():
    strict = Condition(name="aside", **EVERYTHING, gaze_centre={"of": ALL})
    calm = Condition(name="calm", **EVERYTHING, gaze_centre={"of": ALL, "without_gaze": "head"})
    idle = Condition(name="idle", gaze_centre={"of": ALL})
    require_eye_tracker([calm, idle], lambda: pytest.fail("nobody needs to know"))
    message = "effects are centred on the gaze in aside, and this headset has no eye tracker"
    with pytest.raises(InputError, match=message):
        require_eye_tracker([calm, strict], lambda: False)


def test_the_plan_says_what_is_centred_on_the_gaze():
    condition = Condition(name="c", **EVERYTHING, gaze_centre={"of": ALL})
    said = {each.name: each.reason for each in plan_passes(still_life(), condition)}
    for name in ("focus", "depth_of_field", "vignette"):
        assert "centred on the gaze" in said[name]
    plain = Condition(name="c", **EVERYTHING)
    assert not any("gaze" in each.reason for each in plan_passes(still_life(), plain))


PROTOCOL = """\
name = "centred"
title = "Blur round the gaze"
exposure_s = 1.5
scenes = ["temple"]

[[conditions]]
name = "plain"

[[conditions]]
name = "round"
[conditions.focus]
method = "autofocus_zone"
law = "low_pass"
[conditions.depth_of_field]
law = "dioptre"
[conditions.depth_of_field.peripheral]
[conditions.gaze_centre]
of = ["autofocus_zone", "peripheral"]

[order]
rule = "latin_square"

[[questionnaires]]
timepoint = "post"
when = "session_end"

[simulation]
hazard_per_min = 0.0
question_hazard = 0.0
[simulation.eyes]
blink_every_s = 0.5
blink_s = 0.1
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"peripheral"]', '"peripheral", "vignette"]', "centres `vignette`, which is not there"),
        ('method = "autofocus_zone"\nlaw', "law", "centres `autofocus_zone`, which is not there"),
        ("[conditions.depth_of_field.peripheral]\n", "", "write a table depth_of_field.peripheral"),
    ],
)
def test_what_is_not_there_cannot_be_centred(tmp_path, old, new, words):
    tiny_protocol(tmp_path, PROTOCOL)
    with pytest.raises(InputError, match=words):
        tiny_protocol(tmp_path, PROTOCOL.replace(old, new))


@pytest.mark.slow
def test_a_session_says_for_each_frame_what_the_centre_was(run, tmp_path):
    file = tmp_path / "centred.toml"
    file.write_text(PROTOCOL)
    out = tmp_path / "S"
    shown_small = ("--size", "32x40", "--refresh-hz", 30, "--quiet")
    code, _, err = run("simulate", file, "-n", 1, "--out", out, *shown_small)
    assert code == 0, err
    folder = out / "sub-P01/ses-1"
    trials = {row["trial"]: row["condition"] for row in read_rows(folder / "trials.csv")}
    frames, gaze = read_rows(folder / "frames.csv"), read_rows(folder / "gaze.csv")
    centres = {"plain": set(), "round": set()}
    for one, other in zip(frames, gaze, strict=True):
        centres[trials[one["trial"]]].add((other["valid"], other["effect_centre"]))
        assert bool(other["hit_node"]) == (other["valid"] == "1")
    assert centres["plain"] <= {("0", ""), ("1", "")}
    assert {("1", "gaze"), ("0", "held")} <= centres["round"]
    assert centres["round"] <= {("1", "gaze"), ("0", "held"), ("0", "head")}
    code, said, _ = run("verify", out)
    assert code == 0, said
