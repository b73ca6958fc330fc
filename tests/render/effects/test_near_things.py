"""What lies behind near things is drawn, and they over it: only where something is near."""

from contextlib import nullcontext
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import zoom

from tests.render.effects.test_optics import evaluate
from tests.support.render import at, glowing, mesh, scene, wall
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Pose, View
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.traffic import TrafficCounter
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus
from vrcomfort.render.effects.depth_of_field import effect, half_gather
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff.brute_force import read_rgb

SIZE_PX = (128, 64)
FOV = Fov.symmetric(vertical_rad=2 * np.arctan(0.5), aspect=2)
FOCUS_M = 2.0
LENS = {"law": "dioptre", "max_radius_percent": 10.0, "full_blur_dioptre": 2.0}
"""6.4 px of radius for each dioptre: 12.8 px at half a metre, 4.6 px at 0.82 m."""

COLOURS = [(0.9, 0.2, 0.1), (0.05, 0.3, 0.8), (0.2, 0.9, 0.4)]


def bar_before_stripes(near_m=0.5, width_m=0.04, *, upright=True, light=1.0, more=()):
    """A bar from top to bottom before stripes of 4 px, which are in focus."""
    bar = at(0.01, 0.0, -near_m, mesh=(0,), scale=np.array([width_m, 2.0, 1.0]))
    long = np.array([1 / 8, 6.0, 1.0])
    far = [
        at(*((x, 0.0) if upright else (0.0, x)), -FOCUS_M, mesh=(1 + i % 2,), scale=scale)
        for scale in [long if upright else long[[1, 0, 2]]]
        for i, x in enumerate(np.arange(-2.5, 2.5, 1 / 8))
    ]
    shine = [glowing(tuple(light * np.array(colour))) for colour in COLOURS]
    shine.append(glowing((0.3, 0.3, 0.05)))  # of what is in `more`
    return scene([bar, *far, *more], [wall(1, i) for i in range(4)], shine)


def floor_edge(far_m):
    return [(-9.0, -0.25, -far_m), (9.0, -0.25, -far_m)]


def wall_edge(far_m):
    return [(0.25, -9.0, -far_m), (0.25, 0.05, -far_m)]


def receding(edge):
    """A striped plane from 0.3 m to 8 m, between two points that `edge` gives for a distance."""
    strips = [
        mesh([*edge(near_m), *edge(far_m)[::-1]], [0, 1, 2, 0, 2, 3], i % 2)
        for i, (near_m, far_m) in enumerate(pairwise(np.geomspace(0.3, 8.0, 60)))
    ]
    sky = len(strips)
    nodes = [at(0, 0, 0, mesh=tuple(range(sky))), at(0, 0, -9.0, mesh=(sky,))]
    shine = [glowing(colour, double_sided=True) for colour in COLOURS]
    return scene(nodes, [*strips, wall(40, 2)], shine)


def condition(focus=None, **settings):
    focus = focus or Focus(method="fixed", fixed_m=FOCUS_M)
    lens = DepthOfField(**{**LENS, **settings})
    return Condition(name="x", focus=focus, depth_of_field=lens)


def look(index=0, fov=FOV):
    eye = View(Pose(), fov)
    return Frame(index, index * 11_111_111, 11_111_111, Pose(), (eye, eye), Pose())


def drawn(ctx, content, wanted, frames=1, *, watch=True, size_px=SIZE_PX, fov=FOV):
    """Return the last frame's left eye: pinhole, result and depth, and the passes of that frame."""
    found = {}

    def keep(eye, images):
        if eye == 0:
            depth = np.frombuffer(gl.read(images.depth), np.float32)
            found.update(pinhole=read_rgb(images.pinhole), linear=read_rgb(images.linear))
            found["depth"] = depth.reshape(size_px[::-1])

    renderer = StereoRenderer(ctx, size_px, eyes=1)
    renderer.build(content, wanted)
    for index in range(frames):
        counter = TrafficCounter(ctx)
        with watched(counter) if watch else nullcontext():
            renderer.render(look(index, fov), index / 90, keep)
    renderer.release()
    return found, {each.declared.name: each for each in counter.drawn if each.samples}


@pytest.fixture
def in_three_ways(ctx, monkeypatch):
    """Return a function that draws a scene: as it is, without what is behind, through the lens."""

    def result(content, **settings):
        return drawn(ctx, content, condition(**settings), watch=False)[0]["linear"]

    @cache
    def through_the_lens(content):
        return result(content, views=36)

    def draw(content, **settings):
        ours = result(content, **settings)
        with monkeypatch.context() as patch:
            patch.setattr(effect, "BEHIND_PX", 1e9)
            patch.setattr(half_gather, "BEHIND_PX", 1e9)
            alone = result(content, **settings)
        return ours, alone, through_the_lens(content)

    return draw


def rms(image):
    return np.sqrt(np.mean(image**2))


def test_what_a_near_bar_hides_is_what_the_lens_sees(in_three_ways):
    """Of the error inside the bar's disc less than half is left."""
    content, near = bar_before_stripes(), np.s_[20:-20, 48:82]
    for samples in (12, 16, 36, 96):
        ours, alone, true = (each[near] for each in in_three_ways(content, samples=samples))
        assert rms(ours - true) < 0.5 * rms(alone - true), samples


def before_even_stripes(left_px, right_px, radius_px, first_px):
    """A black board from top to bottom before stripes of 2 px that a disc of 12 px makes even."""
    near_m, far_m = 1 / (1 / 0.5 + radius_px / 6.4), 9.0

    def upright(left_px, right_px, distance_m, material):
        x = np.array([left_px, right_px, right_px, left_px]) * distance_m / 64
        y = np.array([-99, -99, 99, 99])
        corners = np.column_stack([x, y, np.full(4, -distance_m)])
        return mesh(corners, [0, 1, 2, 0, 2, 3], material)

    stripes = [upright(x, x + 2, far_m, 1) for x in range(first_px - 200, 200, 4)]
    return scene(
        [at(0, 0, 0, mesh=tuple(range(1 + len(stripes))))],
        [upright(left_px, right_px, near_m, 0), *stripes],
        [glowing((0.0,) * 3), glowing((1.0,) * 3)],
    )


def beside_a_silhouette(ctx, content, samples):
    """Return 14 pixels of a row, from 2 pixels left of the image's middle on."""
    wanted = condition(Focus(method="fixed", fixed_m=0.5), samples=samples)
    return drawn(ctx, content, wanted, watch=False)[0]["linear"][32, 62:76, 0]


def past(edge_px, radius_px):
    """Return of the points of these pixels the part of a disc that is right of an edge."""
    across = np.arange(-2, 12)[:, None] + (np.arange(16) + 0.5) / 16 - edge_px
    part = np.clip(across / max(radius_px, 1e-3), -1, 1)
    return (0.5 + (part * np.sqrt(1 - part**2) + np.arcsin(part)) / np.pi).mean(axis=1)


@pytest.mark.parametrize("samples", [16, 36, 96])
@pytest.mark.parametrize("radius_px", [0.0, 1.0, 1.8])
@pytest.mark.parametrize("first_px", [0, 2])
def test_at_a_silhouette_nothing_behind_it_is_sharp(ctx, samples, radius_px, first_px):
    """Of the pixels at the edge two of four samples see a stripe, or a gap."""
    content = before_even_stripes(-999, 4.5, radius_px, first_px)
    found = beside_a_silhouette(ctx, content, samples)
    np.testing.assert_allclose(found, 0.5 * past(4.5, radius_px), atol=0.08)


@pytest.mark.parametrize("samples", [16, 36, 96])
@pytest.mark.parametrize("first_px", [2, 4])
def test_a_near_wire_hides_as_much_as_it_is_wide(ctx, samples, first_px):
    """It covers half of two pixels, and a pixel's width of the light behind."""
    content = before_even_stripes(4.5, 5.5, 3.0, first_px)
    found = beside_a_silhouette(ctx, content, samples)
    expected = 0.5 * (1 - past(4.5, 3.0) + past(5.5, 3.0))
    np.testing.assert_allclose(found, expected, atol=0.02)


@pytest.mark.parametrize(("near_m", "wide"), [(0.5, True), (0.56, True), (0.58, False)])
def test_twelve_samples_draw_what_only_wide_discs_hide(ctx, near_m, wide):
    """Of a radius of 9.6 px, 8.2 px and 7.8 px: from 8 px on."""
    image, passes = drawn(ctx, bar_before_stripes(near_m), condition(samples=12))
    assert ("depth_of_field/near_depth.frag" in passes) == wide
    apart = {name for name in passes if "near_" in name}
    assert bool(apart) == wide, "without wide discs nothing is looked for"
    unwatched = drawn(ctx, bar_before_stripes(near_m), condition(samples=12), watch=False)[0]
    np.testing.assert_array_equal(unwatched["linear"], image["linear"])


def test_what_lies_close_behind_a_near_surface_goes_on_from_it(ctx):
    """Radii: from -5.5 px on, behind one of -8 px, it is another surface; at -3 px it is wholly."""
    radii = np.array([-9.0, -8.0, -5.5, -4.25, -3.0, 2.0], "f4")
    given = np.column_stack([np.full(6, -8.0, "f4"), radii, *np.zeros((2, 6), "f4")])
    call = "vec4(farther(x.x, x.y), well_behind_px(x.x), 0.0, 0.0)"
    found = evaluate(ctx, "near.glsl", call, given.astype("f4"))
    np.testing.assert_allclose(found[:, 0], [0, 0, 0, 0.5, 1, 1], atol=1e-5)
    np.testing.assert_allclose(found[:, 1], -5.5)


def test_small_near_discs_are_of_pixels_and_wide_ones_of_half_the_image(ctx):
    """From 3.4 to 4 px both have a part; where only wider discs are apart, half the image all."""
    given = np.zeros((4, 4), "f4")
    given[:, 0] = [0.0, -3.4, -3.7, -4.0]
    call = "vec4(pixels_part(x.x))"
    np.testing.assert_allclose(
        evaluate(ctx, "near.glsl", call, given)[:, 0], [1, 1, 0.5, 0], atol=1e-5
    )
    wide = evaluate(ctx, "near.glsl", call, given, defines=[("BEHIND_PX", 8.0)])
    np.testing.assert_array_equal(wide, 0)


def test_discs_of_one_surface_add_up_and_what_is_behind_fills_the_rest(ctx):
    given = np.zeros((1, 4), "f4")
    for call, light in [
        ("limited(vec4(1.5, 0.0, 0.0, 3.0))", [0.5, 0, 0, 1]),
        ("upon(vec4(0.6, 0.0, 0.0, 0.6), vec4(0.0, 1.0, 0.0, 1.0))", [0.6, 0.4, 0, 1]),
        ("past(vec4(0.6, 0.0, 0.0, 0.6), vec4(0.0, 1.0, 0.0, 1.0))", [0.6, 0.4, 0, 1]),
        ("past(vec4(0.6, 0.0, 0.0, 0.6), vec4(0.0, 0.3, 0.0, 0.3))", [0.6, 0.3, 0, 0.9]),
        ("vec4(lesser(0.1, -0.3), lesser(0.6, 0.4), lesser(0.6, 0.7), 0.0)", [0.1, 0.4, 0, 0]),
    ]:
        np.testing.assert_allclose(evaluate(ctx, "near.glsl", call, given)[0], light, atol=1e-6)


def test_nothing_shines_through_a_near_board_behind_a_near_bar(in_three_ways):
    """A board of one colour at 0.75 m (5.3 px) is all that is behind a bar at 0.5 m (9.6 px)."""
    board = at(0.06, 0.0, -0.75, mesh=(3,), scale=np.array([1.0, 2.0, 1.0]))
    near = np.s_[20:-20, 48:82]
    ours, alone, true = (each[near] for each in in_three_ways(bar_before_stripes(more=[board])))
    assert rms(ours - true) < 1.1 * rms(alone - true)


@pytest.mark.parametrize(("samples", "slope"), [(16, 0.25), (96, 1 / 3), (16, 0.4)])
def test_nothing_shines_through_where_two_near_boards_overlap(ctx, samples, slope):
    """They have one colour, and fill the image: so does their blur. Behind them is a bright wall.

    Radii are 12.2, 9 and 2.2 px. Where texels have parts of both boards, none is a slanted surface.
    """
    px_m = 1 / 2.4 / (SIZE_PX[0] / 2)
    left, right = (((0.4 + slope * x) * px_m, x * px_m) for x in (-90.0, 90.0))
    edge = [(x, y, -1 / 2.4) for y, x in (left, right)]
    nearer_board = mesh([*edge, *((x, -1.0, z) for x, _, z in reversed(edge))], [0, 1, 2, 0, 2, 3])
    nodes = [
        at(0, 0, 0, mesh=(0,)),
        at(0, 0, -1 / 1.906, mesh=(1,)),
        at(0, 0, -1 / 0.844, mesh=(2,)),
    ]
    shine = [glowing((light,) * 3, double_sided=True) for light in (0.2, 40.0)]
    content = scene(nodes, [nearer_board, wall(3, 0), wall(6, 1)], shine)
    found = drawn(ctx, content, condition(samples=samples), watch=False)[0]["linear"]
    np.testing.assert_allclose(found, 0.2, atol=0.02)


@pytest.mark.parametrize("samples", [16, 36, 96])
def test_no_line_stands_between_two_near_boards_at_like_distances(ctx, samples):
    """Radii are 12 and 10 px: a texel with both has the farther one as the nearer's continuation.

    Both are dark and end in one row, where each half hides the bright wall: a line of both would
    hide three quarters.
    """
    boards = [
        mesh([(x, y, -1.0) for x, y in ((left, 0), (9, 0), (9, 9), (left, 9))], [0, 1, 2, 0, 2, 3])
        for left in (1 / (SIZE_PX[0] / 2), -9)
    ]
    scales = [1 / (1 / FOCUS_M + radius_px / 6.4) for radius_px in (12, 10)]
    nodes = [at(0, 0, 0, mesh=(i,), scale=np.full(3, scale)) for i, scale in enumerate(scales)]
    shine = [glowing((light,) * 3, double_sided=True) for light in (0.0, 1.0)]
    content = scene([*nodes, at(0, 0, -FOCUS_M, mesh=(2,))], [*boards, wall(40, 1)], shine)
    found = drawn(ctx, content, condition(samples=samples), watch=False)[0]["linear"]
    row = found[SIZE_PX[1] // 2 - 1 : SIZE_PX[1] // 2 + 1, 30:-30].mean(axis=(0, 2))
    np.testing.assert_allclose(row, 0.5, atol=0.03)


@pytest.mark.parametrize("edge_px", [0, 1])
@pytest.mark.parametrize(("nearer_px", "farther_px"), [(4.2, 3.2), (3.7, 2.9), (4.5, 2.2), (9, 3)])
def test_nothing_shines_through_beside_a_board_with_small_discs(
    ctx, nearer_px, farther_px, edge_px
):
    """Whichever of the discs are summed over pixels: two dark boards hide all of a bright wall."""
    nearer_m, farther_m = (1 / (1 / FOCUS_M + px / 6.4) for px in (nearer_px, farther_px))
    left_m = edge_px / 64 * nearer_m
    nodes = [
        at(left_m + 2.0, 0, -nearer_m, mesh=(0,), scale=np.array([4.0, 4.0, 1.0])),
        at(0, 0, -farther_m, mesh=(0,), scale=np.array([8.0, 4.0, 1.0])),
        at(0, 0, -FOCUS_M, mesh=(1,)),
    ]
    shine = [glowing((light,) * 3) for light in (0.0, 1.0)]
    content = scene(nodes, [wall(1, 0), wall(40, 1)], shine)
    lit = drawn(ctx, content, condition(samples=36), watch=False)[0]["linear"]
    np.testing.assert_allclose(lit, 0, atol=0.01)


def test_no_second_outline_stands_inside_a_blurred_bar(in_three_ways):
    """The contrast of rows behind it goes on as through a lens where the bar itself begins."""
    ours, alone, true = (
        np.abs(np.diff(each[20:-20].std(axis=0), axis=0)).max()
        for each in in_three_ways(bar_before_stripes(upright=False))
    )
    assert ours < 1.5 * true
    assert alone > 2.0 * true


def part_beyond(away, radius_px):
    """Return the part of discs (unit: their area) that lies beyond a straight line so far away."""
    at = np.clip(away / radius_px, -1, 1)
    return (np.arccos(at) - at * np.sqrt(1 - at**2)) / np.pi


@pytest.mark.parametrize("samples", [16, 36, 96])
@pytest.mark.parametrize("edge_px", [4, 5])
@pytest.mark.parametrize("radius_px", [2.2, 2.8, 3.4])
def test_a_level_edge_with_small_discs_is_as_soft_wherever_it_lies(
    ctx, radius_px, edge_px, samples
):
    """Between two texels of half the image, or in the middle of one."""
    near_m = 1 / (1 / FOCUS_M + radius_px / 6.4)
    lowest_m = edge_px / 64 * near_m
    board = at(0, lowest_m + 1.0, -near_m, mesh=(0,), scale=np.array([8.0, 2.0, 1.0]))
    content = scene(
        [board, at(0, 0, -FOCUS_M, mesh=(1,))],
        [wall(1, 0), wall(40, 1)],
        [glowing((light,) * 3) for light in (1.0, 0.0)],
    )
    lit = drawn(ctx, content, condition(samples=samples), watch=False)[0]["linear"][:, 64, 0]
    away = 32 + edge_px - (np.arange(SIZE_PX[1]) + 0.5)
    np.testing.assert_allclose(lit, part_beyond(away, radius_px), atol=0.02)


@pytest.mark.parametrize("edge", [floor_edge, wall_edge], ids=["floor", "steep wall"])
def test_a_surface_through_all_radii_is_blurred_once(in_three_ways, edge):
    """Where it leaves the picture behind and where it is drawn over it, its silhouette included."""
    ours, alone, true = in_three_ways(receding(edge))
    assert rms(ours - true) < 1.01 * rms(alone - true)


@pytest.mark.parametrize("radius_px", [1.5, 2.1, 2.5, 3.0])
def test_a_bar_is_in_the_picture_behind_or_over_it(in_three_ways, radius_px):
    """Never in both, or it would be blurred twice, however wide its discs are."""
    content = bar_before_stripes(1 / (1 / FOCUS_M + radius_px / 6.4), 0.2)
    ours, alone, true = in_three_ways(content)
    assert rms(ours - true) < 1.05 * rms(alone - true)


EXTREME = {
    "narrow": {"fov": Fov.symmetric(vertical_rad=np.radians(1), aspect=1)},
    "wide": {"fov": Fov.symmetric(vertical_rad=np.radians(170), aspect=1)},
    "focus at 1 mm": {"focus": Focus(method="fixed", fixed_m=0.001)},
    "focus at 10 km": {"focus": Focus(method="fixed", fixed_m=10_000.0)},
    "one pixel": {"size_px": (1, 1)},
    "one row": {"size_px": (100, 1)},
    "one column": {"size_px": (1, 100)},
    "wide and low": {"size_px": (2048, 16)},
}


@pytest.mark.parametrize("name", EXTREME)
def test_numbers_stay_finite_at_every_extreme(ctx, monkeypatch, name):
    settings = dict(EXTREME[name])
    monkeypatch.setattr(effect, "BEHIND_PX", -1.0)  # a pixel's widest disc is narrower
    wanted = condition(settings.pop("focus", None))
    for light in (6e4, np.inf, np.nan):
        found, _ = drawn(ctx, bar_before_stripes(light=light), wanted, watch=False, **settings)
        assert np.isfinite(found["linear"]).all()
        assert (found["linear"] >= 0).all()


def test_pinhole_and_depth_stay_those_of_what_is_near(ctx):
    """The headset's depth layer, motion blur and files read them."""
    plain = drawn(ctx, bar_before_stripes(), Condition(name="plain"))[0]
    found, passes = drawn(ctx, bar_before_stripes(), condition())
    assert "depth_of_field/near_over.frag" in passes
    np.testing.assert_array_equal(found["pinhole"], plain["pinhole"])
    np.testing.assert_array_equal(found["depth"], plain["depth"])


def test_where_nothing_is_near_nothing_is_drawn_for_it(ctx, monkeypatch):
    content = bar_before_stripes(near_m=1.9)  # 0.17 px
    found, passes = drawn(ctx, content, condition())
    monkeypatch.setattr(effect, "BEHIND_PX", 1e9)
    alone, others = drawn(ctx, content, condition())
    np.testing.assert_array_equal(found["linear"], alone["linear"])
    assert passes.keys() - others.keys() == {
        f"depth_of_field/near_{x}.frag" for x in ("rows", "tiles")
    }
    total, less = (sum(each.bytes for each in frame.values()) for frame in (passes, others))
    assert total - less < 1.0 * SIZE_PX[0] * SIZE_PX[1]


@pytest.mark.parametrize("near_m", [0.5, 1.9])
def test_the_gpu_decides_as_those_do_who_watch(ctx, near_m):
    content = bar_before_stripes(near_m)
    seen, counted = (drawn(ctx, content, condition(), watch=watch)[0] for watch in (False, True))
    np.testing.assert_array_equal(seen["linear"], counted["linear"])


def test_inside_a_wide_near_thing_nothing_shines_through(ctx):
    """A wall of one colour, wider than its discs, has that colour where the lens sees only it."""
    found = drawn(ctx, bar_before_stripes(width_m=0.5), condition())[0]
    middle = found["linear"][20:-20, 54:74]
    np.testing.assert_allclose(middle, np.broadcast_to(middle[0, 0], middle.shape), rtol=2e-3)
    np.testing.assert_allclose(middle[0, 0], (0.9, 0.2, 0.1), rtol=3e-3)


def test_autofocus_leaves_out_what_a_fixed_focus_does(ctx):
    """The GPU alone knows where it is: at the bar's 2 m away surroundings, or wherever."""
    rays = Focus(method="nine_ray", law="instant")
    content = bar_before_stripes(width_m=0.004)  # the rays pass beside it
    fixed, found = (drawn(ctx, content, condition(focus), frames=2) for focus in (None, rays))
    assert "depth_of_field/near_over.frag" in found[1]
    np.testing.assert_allclose(found[0]["linear"], fixed[0]["linear"], atol=0.02)


LAMP_PX, LAMP_LIGHT, ROUND = 7.35, 280.0, 48


def near_lamp(radius_px, samples):
    """A round lamp at half a metre before a dark wall in focus, and the condition it is seen in."""
    turn = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    rim = [(0, 0, 0), *np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])]
    fans = [(0, 1 + i, 1 + (i + 1) % ROUND) for i in range(ROUND)]
    px_m = 0.5 / (SIZE_PX[0] / 2)
    scale = np.array([LAMP_PX * px_m, LAMP_PX * px_m, 1.0])
    lamp = at(5.6 * px_m, -3.8 * px_m, -0.5, mesh=(0,), scale=scale)
    nodes = [lamp, at(0, 0, -FOCUS_M, mesh=(1,))]
    shine = [glowing((light,) * 3) for light in (LAMP_LIGHT, 0.1)]
    lens = {"full_blur_dioptre": (1 / 0.5 - 1 / FOCUS_M) * 12.8 / radius_px, "samples": samples}
    return scene(nodes, [mesh(rim, fans), wall(40, 1)], shine), condition(**lens)


@cache
def disc_of_lamp(radius_px):
    """Return (h, w) of its light in each pixel: of two circles, their overlap."""
    y, x = (np.mgrid[: 8 * SIZE_PX[1], : 8 * SIZE_PX[0]] + 0.5) / 8
    away = np.maximum(np.hypot(x - SIZE_PX[0] / 2 - 5.6, y - SIZE_PX[1] / 2 + 3.8), 1e-3)
    a, b = radius_px, LAMP_PX
    at_a = np.arccos(np.clip((away**2 + a**2 - b**2) / (2 * away * a), -1, 1))
    at_b = np.arccos(np.clip((away**2 + b**2 - a**2) / (2 * away * b), -1, 1))
    shared = a**2 * (at_a - np.sin(2 * at_a) / 2) + b**2 * (at_b - np.sin(2 * at_b) / 2)
    light = LAMP_LIGHT * shared / (np.pi * a**2)
    return light.reshape(SIZE_PX[1], 8, SIZE_PX[0], 8).mean(axis=(1, 3)) + 0.1


def radius_px_of(lit, light):
    inside = zoom(lit.astype(float), 4, order=1, grid_mode=True, mode="nearest") >= light
    return np.sqrt(inside.sum() / 16 / np.pi)


@pytest.mark.parametrize("samples", [16, 36, 96])
@pytest.mark.parametrize("radius_px", [3.5, 5.07])
def test_a_near_lamp_s_disc_is_as_wide_as_the_lens_makes_it(ctx, radius_px, samples):
    """At half its light, and where it is as bright as white, which is what is seen of it."""
    content, wanted = near_lamp(radius_px, samples)
    found, _ = drawn(ctx, content, wanted, watch=False)
    lit, pinhole = found["linear"][..., 0], found["pinhole"][..., 0]
    assert (lit - 0.1).sum() == pytest.approx((pinhole - 0.1).sum(), rel=0.01)
    true = disc_of_lamp(radius_px)
    for light in (1.0, true.max() / 2):
        assert radius_px_of(lit, light) == pytest.approx(radius_px_of(true, light), abs=0.3)


@pytest.mark.parametrize(
    ("radius_px", "samples"), [(6.7, 16), (6.7, 36), (9.0, 16), (9.0, 96), (12.0, 36), (12.0, 96)]
)
def test_a_near_lamp_is_white_as_far_as_through_the_lens(ctx, radius_px, samples):
    """However coarse the level is on which its disc is summed."""
    content, wanted = near_lamp(radius_px, samples)
    lit = drawn(ctx, content, wanted, watch=False)[0]["linear"][..., 0]
    true = disc_of_lamp(radius_px)
    assert radius_px_of(lit, 1.0) == pytest.approx(radius_px_of(true, 1.0), abs=0.2)


WIDE_PX, FOCAL_PX, DARK_LIGHT = (256, 128), 128, 0.1
LAMP_AT, LAMP_SIDE_PX, LAMP_DISC_PX, BOARD_DISC_PX = np.array([3.0, -2.0]), 4, 9.0, 20.0
FREE = np.array([0.4, 1.0]) / np.hypot(0.4, 1.0)
"""From the board's edge to where nothing hides the lamp."""


def place_m(at_px, distance_m):
    return [*(np.array(at_px) * distance_m / FOCAL_PX), -distance_m]


def before_the_wall(lamp_at, *boards):
    """A square lamp before a wall as dark as the boards."""
    lamp_m = 1 / (1 / FOCUS_M + LAMP_DISC_PX / 12.8)
    side = np.array([LAMP_SIDE_PX * lamp_m / FOCAL_PX] * 2 + [1.0])
    nodes = [at(0, 0, -FOCUS_M), at(*place_m(lamp_at, lamp_m), mesh=(1,), scale=side)]
    nodes += [at(0, 0, 0, mesh=(2 + i,)) for i in range(len(boards))]
    shine = [glowing((light,) * 3, double_sided=True) for light in (DARK_LIGHT, LAMP_LIGHT)]
    return scene(nodes, [wall(40), wall(1, 1), *boards], shine)


def board_from(edge):
    """A nearer board that ends at a point of the image, in a slanted edge."""
    along, board_m = np.array([FREE[1], -FREE[0]]), 1 / (1 / FOCUS_M + BOARD_DISC_PX / 12.8)
    ends = [edge - 400 * along, edge + 400 * along]
    corners = [*ends, *(end - 400 * FREE for end in ends[::-1])]
    return mesh([place_m(each, board_m) for each in corners], [0, 1, 2, 0, 2, 3])


def part_of_disc(lamp_at, edge=None):
    """Return (h, w) of the lamp's light: of each of its points, where the board lets it pass."""
    y, x = np.mgrid[: WIDE_PX[1], : WIDE_PX[0]] + 0.5 - np.array(WIDE_PX)[::-1, None, None] / 2
    spots = (np.arange(8) + 0.5) / 8 * LAMP_SIDE_PX - LAMP_SIDE_PX / 2
    found = np.zeros(x.shape)
    for right, up in lamp_at + np.stack(np.meshgrid(spots, spots), axis=-1).reshape(-1, 2):
        away = np.stack([x - right, y - up])
        lit = np.hypot(*away) < LAMP_DISC_PX
        if edge is not None:
            # What of the board the lens's point sees in front of the lamp that it shows here.
            board = np.stack([x, y]) - away * BOARD_DISC_PX / LAMP_DISC_PX
            lit &= np.tensordot(FREE, board - edge[:, None, None], axes=1) > 0
        found += lit
    return found / len(spots) ** 2 * LAMP_LIGHT * LAMP_SIDE_PX**2 / (np.pi * LAMP_DISC_PX**2)


@pytest.mark.parametrize(("samples", "error"), [(16, 0.45), (36, 0.25), (96, 0.2)])
def test_a_near_edge_cuts_a_lamp_s_disc_along_itself(ctx, samples, error):
    """And not along rows and columns of texels, on however coarse a level the disc is summed."""
    edge = LAMP_AT + 3.0 * FREE
    content = before_the_wall(LAMP_AT, board_from(edge))
    found = drawn(ctx, content, condition(samples=samples), watch=False, size_px=WIDE_PX)[0]
    true = part_of_disc(LAMP_AT, edge)
    assert rms(found["linear"][..., 0] - DARK_LIGHT - true) < error * rms(true)


@pytest.mark.parametrize("samples", [16, 36, 96])
def test_a_near_lamp_at_the_image_s_border_does_not_go_on_outside(ctx, samples):
    lamp_at = np.array([(LAMP_SIDE_PX - WIDE_PX[0]) / 2, -2.0])
    content = before_the_wall(lamp_at)
    found = drawn(ctx, content, condition(samples=samples), watch=False, size_px=WIDE_PX)[0]
    ours, true = found["linear"][..., 0] - DARK_LIGHT, part_of_disc(lamp_at)
    assert rms(ours - true) < 0.5 * rms(true)
    assert ours.sum() == pytest.approx(true.sum(), rel=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_a_lamp_s_disc_has_no_holes_between_texels(ctx, seed):
    """No dark pixel at a rim that is many times brighter than white; texels keep their light."""
    random = np.random.default_rng(seed)
    y, x = np.mgrid[:24, :24] + 0.5 - random.uniform(11, 13, 2)[:, None, None]
    inside = np.clip(random.uniform(5, 8) - np.hypot(x, y) + 0.5, 0, 1)
    disc = (inside**2 * (3 - 2 * inside))[..., None] * [40.0, 40.0, 40.0, 0.2]
    near = ctx.texture((24, 24), 4, disc.astype("f2").tobytes(), dtype="f2")
    drawn = FullscreenPass(
        ctx, "depth_of_field/near_over.frag", size_px=(48, 48), inputs={"near": near}
    )
    drawn.render()
    found = np.frombuffer(drawn.target.read(), "f2").reshape(48, 48, 4).astype(float)
    middle_x, middle_y = (int(np.argmax(found[..., 0].sum(axis=axis))) for axis in (0, 1))
    light = found[..., 0]
    for outwards in (light[:, middle_x:], light[:, middle_x::-1], light[middle_y:].T):
        assert not (np.diff(outwards, axis=1)[outwards[:, :-1] < 0.5] > 0.5).any()
    np.testing.assert_allclose(found[..., 3] * 200, light, rtol=0.02, atol=0.02)
    texels = found.reshape(24, 2, 24, 2, 4).mean(axis=(1, 3))
    np.testing.assert_allclose(texels[..., 0], disc[..., 0], atol=4.0)
