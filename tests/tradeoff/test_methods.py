"""The table of methods, and numbers as text."""

from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.protocol.conditions import Kernel
from vrcomfort.tradeoff.methods import EFFECTS, methods
from vrcomfort.tradeoff.tables import number


@pytest.mark.parametrize("quick", [True, False])
@pytest.mark.parametrize("effect", EFFECTS)
def test_names_are_unique_and_there_is_one_without_blur(effect, quick):
    found = methods(effect, quick=quick)
    assert len({method.name for method in found}) == len(found)
    assert [method.family for method in found].count("none") == 1
    for method in found:
        blurred = method.condition.depth_of_field or method.condition.motion_blur
        assert (blurred is None) is (method.family == "none")


def test_every_kernel_that_is_not_ours_is_a_sources_method():
    sources = {m.name for m in methods("depth_of_field") if m.family == "source"}
    assert sources == set(get_args(Kernel)) - {"vrcomfort"}


def test_quick_takes_some_of_the_same_methods():
    for effect in EFFECTS:
        whole = {method.name for method in methods(effect)}
        assert {method.name for method in methods(effect, quick=True)} <= whole


@given(st.floats(1e-6, 1e5), st.integers(1, 4))
def test_a_number_keeps_its_digits(value, digits):
    shown = number(value, digits)
    assert "e" not in shown
    assert float(shown) == pytest.approx(value, rel=0.5 * 10 ** (1 - digits), abs=1e-9)


def test_nothing_and_zero_are_told_apart():
    assert (number(None, 3), number(0.0, 3), number(123.4, 2)) == ("–", "0", "120")
