"""Unseen scenes, summed up: what counts as the best other method, and as kept."""

import pytest

from bench.unseen_summary import summary

NAMES = ("reference of 64", "scatter", "mip", "ring_gather", "ours 16 samples")


def scene(seed, **measures):
    """Rows of a seed; each measure is given in the order of `NAMES`."""
    usual = dict.fromkeys(("rms", "edges", "seams", "cuts", "flicker", "rivalry"), (1,) * 5)
    columns = {**usual, **measures}
    return [
        {"seed": seed, "method": name, **{key: column[i] for key, column in columns.items()}}
        for i, name in enumerate(NAMES)
    ]


def test_scenes_that_keep_to_a_bound_are_counted():
    rows = [
        *scene(1, edges=(0.1, 0.1, 10, 20, 5), seams=(5, 0, 0, 0, 80), cuts=(9, 9, 9, 9, 0)),
        *scene(2, edges=(0.1, 0.1, 30, 20, 18), seams=(5, 0, 0, 0, 81), rivalry=(0, 2, 9, 9, 4)),
    ]
    (found,) = summary(rows).rows
    assert found["method"] == "ours 16 samples"
    assert found["edges / best other, median"] == pytest.approx(0.7)
    assert found["worst"] == pytest.approx(0.9)
    assert found["at most 0.6"] == found["seams"] == found["no cut"] == "1 of 2"
    assert found["rivalry ≤ 1.5 scatter"] == "1 of 2"


def test_a_scene_without_edges_of_near_things_is_none_of_those():
    rows = [*scene(1), *scene(2, edges=(0,) * 5)]
    (found,) = summary(rows).rows
    assert found["at most 0.6"] == "0 of 1"
