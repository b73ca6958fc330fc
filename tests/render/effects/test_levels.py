"""On which level a disc is drawn, and what a texel keeps of two surfaces."""

import numpy as np
import pytest

from tests.oracles.levels import level_part
from tests.render.effects.test_optics import evaluate
from tests.support.effects import depth_of_field
from tests.support.kernels import blur
from vrcomfort.optics import blur_kernels

SAMPLES = 9 * np.pi


def test_levels_share_every_disc_and_hand_over_gradually():
    radius = np.linspace(0, 100, 5001)
    parts = np.stack([level_part(level, radius, samples=36, count=4) for level in range(4)])
    np.testing.assert_allclose(parts.sum(axis=0), 1, atol=1e-12)
    assert np.abs(np.diff(parts, axis=1)).max() < 0.05
    assert ((parts > 0).sum(axis=0) <= 2).all()


@pytest.mark.parametrize("samples", [16, 36, 128])
@pytest.mark.parametrize("max_radius_px", [1.0, 5.0, 22.4, 64.0])
def test_no_disc_is_wider_than_its_level_allows(samples, max_radius_px):
    count = blur_kernels.gather_mips(max_radius_px, samples)
    widest = blur_kernels.exact_px(samples) * blur_kernels.WIDER * 2 ** (count - 1)
    assert max_radius_px <= widest or count == blur_kernels.MOST_MIPS


def test_the_shader_shares_discs_as_its_twin(ctx):
    x = np.zeros((200, 4), "f4")
    x[:, 0] = np.linspace(0, 40, 200)
    call = "vec4(level_part(0, x.x), level_part(1, x.x), level_part(3, x.x), float(levels_of(x.x)))"
    *found, bits = evaluate(ctx, "levels.glsl", call, x).T
    parts = [level_part(level, x[:, 0], samples=SAMPLES, count=4) for level in range(4)]
    for level, part in zip((0, 1, 3), found, strict=True):
        np.testing.assert_allclose(part, parts[level], atol=1e-5)
    drawn = sum((part > 1e-5) * 2**level for level, part in enumerate(parts))
    np.testing.assert_array_equal(bits, np.where(x[:, 0] > 0.5, drawn, 0))


def test_a_texel_keeps_two_surfaces_apart(ctx):
    x = np.random.default_rng(1).uniform(0, 9, (50, 4)).astype("f4")
    make = "unpack_layers(pack_layers(Layers(vec4(x.xyz, -x.w), x, 0.75)))"
    front = evaluate(ctx, "coc.glsl layers.glsl", f"{make}.front", x)
    back = evaluate(ctx, "coc.glsl layers.glsl", f"{make}.back", x)
    np.testing.assert_allclose(front[:, :3], x[:, :3], rtol=2e-3)
    np.testing.assert_allclose(front[:, 3], -x[:, 3], rtol=2e-2)
    np.testing.assert_allclose(back, x, rtol=2e-3)
    part = evaluate(ctx, "coc.glsl layers.glsl", f"vec4({make}.coverage)", x)
    np.testing.assert_array_equal(part, 0.75)


@pytest.mark.parametrize("samples", [16, 36, 128])
def test_a_lamp_far_out_of_focus_is_a_disc_without_beads(ctx, samples):
    """Radius 20 px, before a wall that is as far away, with an edge beside it or without."""
    rgb = np.full((96, 128, 3), 0.1)
    rgb[47:49, 63:65] = 500.0
    y, x = np.mgrid[-47.5:48, -63.5:64]
    for distance in (np.inf, np.where(x < -50, 1.0, np.inf)):
        lens = {"law": "dioptre", "full_blur_dioptre": 1.0, "max_radius_percent": 10.0}
        lens["max_diameter_arcmin"] = None
        lit = depth_of_field(ctx, rgb, distance, 1.0, samples=samples, **lens)
        away = np.hypot(x, y)
        inside = lit.astype(float)[..., 0][away < 9] - 0.1
        assert inside.std() <= 0.1 * inside.mean()
        assert inside.mean() == pytest.approx(4 * 500 / (np.pi * 12.8**2), rel=0.1)


LAMP_AT = ((100.3, 80.1), (101.6, 82.2), (103.5, 85.1), (106.2, 87.4))
"""Where it passes from one tile to the next."""


def _lamp(at):
    """Return (160, 400) how much of each pixel a square lamp covers, 2 px wide."""
    x, y = (
        np.clip(1.5 - np.abs(np.arange(size) + 0.5 - middle), 0, 1)
        for size, middle in zip((400, 160), at, strict=True)
    )
    return y[:, None] * x


def _lit_by_lamp(ctx, at, radius_px, samples, bar=slice(0)):
    """Return (160, 400) radiance in parts of the mean of a lamp's disc; `bar` is in focus."""
    distance = np.full((160, 400), np.inf)
    distance[:, bar] = 1.0
    rgb = np.repeat(_lamp(at)[..., None] * 300, 3, axis=-1)
    lens = {"law": "dioptre", "max_radius_percent": 10, "max_diameter_arcmin": None}
    lit = depth_of_field(
        ctx, rgb, distance, 1.0, samples=samples, full_blur_dioptre=40 / radius_px, **lens
    )
    return lit[..., 0].astype(float) * np.pi * radius_px**2 / rgb[..., 0].sum()


@pytest.mark.parametrize(
    ("radius_px", "samples"), [(9.0, 16), (9.0, 96), (17.4, 36), (28.0, 16), (28.0, 96)]
)
def test_a_lamp_keeps_its_light_and_its_disc_is_round_and_cut_nowhere(ctx, samples, radius_px):
    """With something in focus beside it, its disc lies in tiles of two classes."""
    y, x = np.mgrid[:160, :400] + 0.5
    for at in LAMP_AT:
        disc = _lit_by_lamp(ctx, at, radius_px, samples)
        assert disc.sum() / (np.pi * radius_px**2) == pytest.approx(1, abs=0.01)
        bar = slice(int(100 - 1.25 * radius_px) - 14, int(100 - 1.25 * radius_px) - 6)
        assert np.abs(_lit_by_lamp(ctx, at, radius_px, samples, bar) - disc).max() < 0.2
        if samples == 16:
            continue  # too few for a round one
        disc /= disc.sum()
        x_off, y_off = x - (disc * x).sum(), y - (disc * y).sum()
        directions = x_off, y_off, (x_off + y_off) / np.sqrt(2), (x_off - y_off) / np.sqrt(2)
        widths = [2 * np.sqrt((disc * away**2).sum()) / radius_px for away in directions]
        np.testing.assert_allclose(widths, 1, atol=0.04)


@pytest.mark.parametrize("samples", [16, 36, 96])
def test_a_lamp_beside_a_fence_before_a_wall_keeps_its_disc(ctx, samples):
    """Three surfaces in a texel that keeps two: the lamp's light does not take the fence's disc."""
    y, x = np.mgrid[:160, :160] + 0.5
    brightest = 0.0
    for left in (70, 72, 75):
        rgb, radius_px = np.full((160, 160, 3), 0.05), np.full((160, 160), 35.0)
        radius_px[:, left - 18 : left + 2] = 31.0
        lamp = slice(76, 86), slice(left, left + 10)
        rgb[lamp], radius_px[lamp] = 200.0, 7.0
        lit = blur(ctx, "vrcomfort", rgb, radius_px, max_radius_px=35.0, samples=samples).rgb
        away = np.hypot(x - left - 5, y - 81)
        assert lit[away < 4].min() > 50
        brightest = max(brightest, float(lit[away > 22].max()))
    assert brightest < 0.1
