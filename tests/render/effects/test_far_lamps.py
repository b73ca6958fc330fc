"""Near things cut the discs of lamps behind the focus, as those of near lamps."""

import numpy as np
import pytest

from tests.render.effects.test_near_things import (
    DARK_LIGHT,
    FOCAL_PX,
    LAMP_LIGHT,
    LAMP_SIDE_PX,
    WIDE_PX,
    condition,
    drawn,
    place_m,
    rms,
)
from tests.support.render import at, glowing, mesh, scene, wall
from vrcomfort.protocol.conditions import Focus

FOCUS_M, PX = 0.5, 12.8
"""A dioptre is 12.8 px of radius."""
LAMP_AT, LAMP_DISC_PX, NEAR_DISC_PX = np.array([3.0, -2.0]), 9.0, 20.0
LAMP_M = 1 / (1 / FOCUS_M - LAMP_DISC_PX / PX)
NEAR_M = 1 / (1 / FOCUS_M + NEAR_DISC_PX / PX)
ACROSS = np.array([0.4, 1.0]) / np.hypot(0.4, 1.0)
THINGS = {"edge": (-400.0, 6.0), "bar": (-2.0, 14.0), "bar beside": (12.0, 22.0)}
"""From where to where they reach across, pixels from the lamp's middle."""


def content_of(*, thing=None, lamp_light=LAMP_LIGHT, lamp_m=LAMP_M):
    """A square lamp on a wall as dark as the near thing before it."""
    side = np.array([LAMP_SIDE_PX * lamp_m / FOCAL_PX] * 2 + [1.0])
    nodes = [at(0, 0, -1.001 * lamp_m), at(*place_m(LAMP_AT, lamp_m), mesh=(1,), scale=side)]
    things = []
    if thing is not None:
        along = 400 * np.array([ACROSS[1], -ACROSS[0]])
        low, high = (LAMP_AT + each * ACROSS for each in THINGS[thing])
        corners = [low - along, low + along, high + along, high - along]
        things = [mesh([place_m(each, NEAR_M) for each in corners], [0, 1, 2, 0, 2, 3])]
        nodes.append(at(0, 0, 0, mesh=(2,)))
    shine = [glowing((light,) * 3, double_sided=True) for light in (DARK_LIGHT, lamp_light)]
    return scene(nodes, [wall(40), wall(1, 1), *things], shine)


def part_of_disc(thing):
    """Return (h, w) of the lamp's light: of each of its points, where the thing lets it pass.

    A point u of the lens sees a far point q at q + u R, R its disc's radius, and a near one n at
    n - u N. So where p shows q, that of the near thing is in front of it which is at p + u N.
    """
    y, x = np.mgrid[: WIDE_PX[1], : WIDE_PX[0]] + 0.5 - np.array(WIDE_PX)[::-1, None, None] / 2
    spots = (np.arange(8) + 0.5) / 8 * LAMP_SIDE_PX - LAMP_SIDE_PX / 2
    low, high = THINGS[thing]
    found = np.zeros(x.shape)
    for right, up in LAMP_AT + np.stack(np.meshgrid(spots, spots), axis=-1).reshape(-1, 2):
        lens = np.stack([x - right, y - up]) / LAMP_DISC_PX
        before = np.stack([x, y]) + lens * NEAR_DISC_PX - LAMP_AT[:, None, None]
        across = np.tensordot(ACROSS, before, axes=1)
        found += (np.hypot(*lens) < 1) & ((across < low) | (across > high))
    return found / len(spots) ** 2 * LAMP_LIGHT * LAMP_SIDE_PX**2 / (np.pi * LAMP_DISC_PX**2)


def light_of(ctx, content, samples):
    """Return (h, w) of the light that the wall has not, and the passes."""
    wanted = condition(Focus(method="fixed", fixed_m=FOCUS_M), samples=samples)
    found, passes = drawn(ctx, content, wanted, size_px=WIDE_PX)
    return found["linear"][..., 0] - DARK_LIGHT, passes


@pytest.mark.parametrize(("samples", "error"), [(16, 0.22), (96, 0.12)])
@pytest.mark.parametrize("thing", THINGS)
def test_a_near_thing_cuts_the_disc_of_a_lamp_behind_the_focus(ctx, thing, samples, error):
    """It takes the light that it hides from each point of the lens, and veils no other."""
    ours, _ = light_of(ctx, content_of(thing=thing), samples)
    true = part_of_disc(thing)
    assert rms(ours - true) < error * rms(true)
    assert ours.sum() == pytest.approx(true.sum(), rel=0.1)


@pytest.mark.parametrize(("thing", "lamp_light"), [("bar", LAMP_LIGHT), ("bar", 1.0), (None, 9.0)])
def test_discs_are_cut_only_where_a_lamp_is_behind_something_near(ctx, thing, lamp_light):
    """The tiles that are drawn so read the discs of near things; without those none is sought."""
    _, passes = light_of(ctx, content_of(thing=thing, lamp_light=lamp_light), 36)
    sought = {"depth_of_field/lamp_tiles.frag", "depth_of_field/cut_tiles.frag"}
    assert passes.keys() & sought == (sought if thing else set())
    cut = passes.get("depth_of_field/complex.frag")
    near = passes.get("depth_of_field/near_gather.frag")
    is_cut = cut and near and near.declared.writes[0].name in {x.name for x in cut.declared.reads}
    assert bool(is_cut) == (thing is not None and lamp_light == LAMP_LIGHT)


@pytest.mark.parametrize("edge_px", [-12.0, 4.0, 15.0])
def test_a_lamp_in_focus_loses_what_is_hidden_of_the_lens(ctx, monkeypatch, edge_px):
    """All rays of a point meet in its pixel: it is dimmed evenly by the part of the lens."""
    monkeypatch.setitem(THINGS, "edge", (-400.0, edge_px))
    lit, _ = light_of(ctx, content_of(thing="edge", lamp_m=FOCUS_M), 36)
    alone, _ = light_of(ctx, content_of(lamp_m=FOCUS_M), 36)
    free = edge_px / NEAR_DISC_PX
    free = (np.arccos(free) - free * np.sqrt(1 - free**2)) / np.pi
    assert lit.sum() / alone.sum() == pytest.approx(free, abs=0.03)
