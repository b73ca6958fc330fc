"""Layers by node: the background is blurred, and what is named is drawn over it, sharp."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.mip_level import at_level
from tests.render.test_pipeline import SIZE, standing
from tests.support.render import still_life
from vrcomfort.errors import InputError
from vrcomfort.protocol.conditions import BackgroundBlur, Condition, DepthOfField
from vrcomfort.render.camera import NEAR_M
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Node

PLAIN = Condition(name="plain")


def blurred(*foreground, level=2.0, **more):
    return Condition(
        name="layers", background_blur=BackgroundBlur(foreground=foreground, level=level), **more
    )


def pictures(ctx, content, condition, samples=1):
    """Return the (h, w, 3) colours and (h, w) depths of both eyes before effects."""
    renderer = StereoRenderer(ctx, SIZE, samples=samples)
    renderer.build(content, condition)
    found = []

    def keep(_, images):
        found.append((read_texture(images.pinhole)[..., :3], read_texture(images.depth)[..., 0]))

    renderer.render(standing(0), 0.0, keep)
    return found


def without(content, *names):
    """Return a scene in which some nodes draw nothing; their shadows go with them."""
    bare = (replace(each, mesh=()) if each.name in names else each for each in content.nodes)
    return replace(content, nodes=tuple(bare))


@pytest.fixture(scope="module")
def shadowless():
    content = still_life()
    nodes = tuple(replace(each, casts_shadow=False) for each in content.nodes)
    return without(replace(content, nodes=nodes), "glass")


@pytest.mark.parametrize(("name", "level"), [("brass", 0.4), ("clay", 1.0), ("grid", 2.5)])
def test_the_foreground_is_sharp_over_a_background_at_its_level(ctx, shadowless, name, level):
    plain = pictures(ctx, shadowless, PLAIN)
    behind = pictures(ctx, without(shadowless, name), PLAIN)
    found = pictures(ctx, shadowless, blurred(name, level=level))
    for (sharp, depth), (back, back_depth), (image, its_depth) in zip(
        plain, behind, found, strict=True
    ):
        np.testing.assert_array_equal(its_depth, depth)
        front = depth != back_depth
        np.testing.assert_array_equal(image[front], sharp[front])
        soft = at_level(back.astype(float)[::-1], level)[::-1]
        np.testing.assert_allclose(image[~front], soft[~front], atol=6e-3)
        assert 10 < front.sum() < front.size / 2


def test_what_the_background_hides_stays_hidden(ctx, shadowless):
    (image, _), _ = pictures(ctx, shadowless, blurred("plaster"))
    (sharp, depth), _ = pictures(ctx, shadowless, PLAIN)
    (_, behind), _ = pictures(ctx, without(shadowless, "plaster"), PLAIN)
    seen = depth != behind
    hidden = depth > NEAR_M / 4  # nearer than four metres: the plaster stands at six
    assert not (seen & hidden).any()
    assert np.abs(image[hidden] - sharp[hidden]).max() > 0.01
    np.testing.assert_array_equal(image[seen], sharp[seen])


def test_names_may_be_patterns_and_take_what_is_below_with_them(ctx, shadowless):
    brass = next(i for i, each in enumerate(shadowless.nodes) if each.name == "brass")
    place = shadowless.nodes[brass]
    child = Node("", parent=brass, mesh=place.mesh, casts_shadow=False)
    tree = replace(
        shadowless,
        nodes=(*(replace(n, mesh=()) if n is place else n for n in shadowless.nodes), child),
    )
    direct = pictures(ctx, shadowless, blurred("brass"))
    for condition in (blurred("brass"), blurred("bra?s"), blurred("nothing", "b*")):
        for (image, _), (wanted, _) in zip(pictures(ctx, tree, condition), direct, strict=True):
            np.testing.assert_array_equal(image, wanted)


def test_samples_at_the_foregrounds_edges_are_of_both(ctx, shadowless):
    (image, depth), _ = pictures(ctx, shadowless, blurred("clay", level=3.0), samples=4)
    (plain, _), _ = pictures(ctx, shadowless, PLAIN, samples=4)
    (back, behind), _ = pictures(ctx, without(shadowless, "clay"), PLAIN, samples=4)
    soft = at_level(back.astype(float)[::-1], 3.0)[::-1]
    front = depth != behind  # in one sample at least
    inside, outside = ~_widened(~front), ~_widened(front)
    np.testing.assert_array_equal(image[inside], plain[inside])
    np.testing.assert_allclose(image[outside], soft[outside], atol=6e-3)
    edge = ~inside & ~outside
    mixed = (np.abs(image - plain) > 0.02).any(axis=-1) & (np.abs(image - soft) > 0.02).any(axis=-1)
    assert mixed[edge].any()
    assert not mixed[~edge].any()


def _widened(mask):
    padded = np.pad(mask, 1)
    height, width = mask.shape
    shifts = [padded[y : y + height, x : x + width] for y in range(3) for x in range(3)]
    return np.any(shifts, axis=0)


def test_effects_see_it_as_the_scene(ctx, shadowless):
    lens = {"depth_of_field": DepthOfField(max_radius_percent=3)}
    alone = pictures(ctx, shadowless, blurred("clay"))
    with_lens = pictures(ctx, shadowless, blurred("clay", **lens))
    for (image, depth), (other, other_depth) in zip(alone, with_lens, strict=True):
        np.testing.assert_array_equal(image, other)
        np.testing.assert_array_equal(depth, other_depth)


def test_a_name_that_the_scene_has_not_is_told_with_the_nearest():
    with pytest.raises(InputError, match=r"'layers'.*no node .* 'bras'; did you mean `brass`"):
        plan_passes(still_life(), blurred("bras"))


def test_the_plan_says_how_much_stays_sharp():
    item = {each.name: each for each in plan_passes(still_life(), blurred("brass", "clay"))}
    assert item["background_blur"].needed
    assert item["background_blur"].reason == "MIP level 2 behind 2 of 6 nodes"
