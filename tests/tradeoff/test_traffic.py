"""What a method's effects send through memory, and what is no part of a method."""

import pytest

from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.costs import a_step, traffic_of, traffic_of_method
from vrcomfort.tradeoff.methods import methods
from vrcomfort.tradeoff.store import scene_and_hash

SCOPE = Scope(size_px=(32, 40), poses=1, eyes=1)
CASE = Case("temple", 0, "still", "depth_of_field")


def method(name):
    return next(each for each in methods("depth_of_field") if each.name == name)


@pytest.mark.slow
def test_a_sources_method_draws_nothing_that_it_does_not_read():
    """Two passes: a mean of radii in squares of eight, and fifteen taps.

    Radii come with the colour: where samples are resolved, by one read of the focus.
    """
    found = traffic_of_method(method("poisson15_near"), CASE, SCOPE)
    assert (found["passes"], found["draws"]) == (2, 2)
    # Per pixel 1 for the focus, 1 for the mean, 17 for the gather.
    assert found["reads_per_pixel"] == pytest.approx(19, abs=0.2)
    assert found["bytes_per_pixel"] == pytest.approx(8 + (8 + 8), abs=0.3)


def test_no_blur_sends_nothing():
    found = traffic_of_method(method("no blur"), CASE, SCOPE)
    assert found == {"reads_per_pixel": 0, "bytes_per_pixel": 0, "passes": 0, "draws": 0}


def test_a_record_of_limits_is_counted_where_it_is_asked_for():
    scene, _ = scene_and_hash("temple")
    condition = method("poisson12").condition
    pair = a_step(scene.spawn, SCOPE.size_px)
    with_records, without = (
        traffic_of(context(), scene, condition, pair, SCOPE.size_px, records=each)
        for each in (True, False)
    )
    assert with_records["depth_of_field"].draws == without["depth_of_field"].draws + 2
    assert without["depth_of_field"].reads is None
    assert {"scene", "tone_map"} <= set(without)
