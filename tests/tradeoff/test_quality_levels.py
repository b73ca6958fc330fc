"""Each quality level of depth of field is worth its price."""

from itertools import pairwise

import pytest

from vrcomfort.protocol.conditions import Condition
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.costs import traffic_of_method
from vrcomfort.tradeoff.measure import errors_of
from vrcomfort.tradeoff.methods import FOCUS, LENS, BlurMethod
from vrcomfort.tradeoff.store import Store

SCOPE = Scope(samples=64, poses=1, eyes=1)
"""At half the size all discs are so small that `fast` and `balanced` differ little."""


def method(level):
    settings = {"name": level, "quality": level, "focus": FOCUS, "depth_of_field": LENS}
    return BlurMethod(level, "depth_of_field", "ours", Condition.model_validate(settings))


@pytest.mark.slow
def test_each_level_moves_more_and_errs_a_fifth_less(tmp_path):
    """Without `reference`, whose error is smaller than that of a reference of few samples."""
    case = Case("temple", 0, "still", "depth_of_field")
    store = Store(tmp_path)
    levels = [method(level) for level in ("fast", "balanced", "accurate")]
    traffic = [traffic_of_method(each, case, SCOPE) for each in levels]
    errors = [errors_of(case, SCOPE, each, store)["rms"] for each in levels]
    for (cheap, dear), (far, close) in zip(pairwise(traffic), pairwise(errors), strict=True):
        assert cheap["reads_per_pixel"] < dear["reads_per_pixel"]
        assert cheap["bytes_per_pixel"] < dear["bytes_per_pixel"]
        assert close <= 0.8 * far, errors
