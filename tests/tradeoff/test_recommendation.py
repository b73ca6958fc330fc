"""What to choose for a budget: the closest on the front that fits, in milliseconds of both eyes."""

import matplotlib as mpl
import pytest

from vrcomfort.tradeoff import tables
from vrcomfort.tradeoff.figures import STYLE, draw_front
from vrcomfort.tradeoff.recommendation import recommendations

PLAIN_MS = {"temple": 4.0, "mountain": 5.0}  # of one eye


def row(scene, method, family, cost, rms):
    where = {"scene": scene, "effect": "depth_of_field", "lens": "3.5"}
    return {**where, "method": method, "family": family, "cost": cost, "rms": rms, "flip": rms}


def found(*methods):
    """Return results of one eye in two scenes: (name, family, cost, RMS in the temple)."""
    again = [
        {"scene": scene, "effect": "depth_of_field", "lens": "3.5", "plain_ms": plain_ms}
        for scene, plain_ms in PLAIN_MS.items()
    ]
    table = [
        row(scene, name, family, cost, rms)
        for scene in PLAIN_MS
        for name, family, cost, rms in (("no blur", "none", 1.0, 0.04), *methods)
    ]
    return {"table": table, "again": again, "scope": {"eyes": 1}}


METHODS = (
    ("separable_gaussian", "source", 1.1, 0.009),
    ("mip", "source", 1.2, 0.01),
    ("ours 36 samples", "ours", 1.5, 0.003),
    ("ours 20 samples", "ours", 1.4, 0.004),
    ("ours 16 views", "dial", 20.0, 0.001),
)


@pytest.mark.parametrize(
    ("budget_ms", "chosen", "fits"),
    [
        (10.9, "separable_gaussian", False),
        (11.1, "separable_gaussian", True),
        (14.5, "ours 20 samples", True),
        (15.1, "ours 36 samples", True),
        (199.0, "ours 36 samples", True),
        (201.0, "ours 16 views", True),
    ],
)
def test_the_closest_that_fits_in_the_slower_scene_is_chosen(budget_ms, chosen, fits):
    (choice,) = recommendations(found(*METHODS), budget_ms)
    assert (choice.front[choice.chosen].method, choice.fits) == (chosen, fits)
    assert choice.plain_ms == pytest.approx(10.0)
    assert [each.method for each in choice.others] == ["mip"]
    said = tables.answer(choice, (640, 800))
    assert said.startswith("For " if fits else "Nothing fits ")
    assert choice.front[choice.chosen].label in said


def test_a_choice_is_told_as_lines_of_a_protocol():
    (choice,) = recommendations(found(*METHODS))
    lines = {each.method: each.lines for each in choice.front}
    assert lines["ours 36 samples"] == ('quality = "balanced"',)
    assert lines["ours 20 samples"] == ("depth_of_field.samples = 20",)
    assert lines["separable_gaussian"] == ('depth_of_field.kernel = "separable_gaussian"',)
    labels = {each.method: each.label for each in choice.front}
    assert labels["ours 36 samples"] == "balanced (ours 36 samples)"


def test_what_one_scene_lacks_is_no_choice():
    results = found(*METHODS)
    results["table"].pop()  # 16 views in the mountain
    (choice,) = recommendations(results, 1000.0)
    assert choice.front[choice.chosen].method == "ours 36 samples"
    assert recommendations(found()) == []


def test_the_figure_names_the_front_and_rings_the_chosen():
    (choice,) = recommendations(found(*METHODS), 14.5)
    with mpl.rc_context(STYLE):
        (axes,) = draw_front(choice).axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    names = {text.get_text(): text.get_fontweight() for text in axes.texts}
    assert set(names) == {each.label for each in choice.front}
    assert [name for name, weight in names.items() if weight == "bold"] == ["ours 20 samples"]
    (ring,) = [line for line in axes.lines if line.get_label() == "to choose"]
    assert ring.get_xydata().tolist() == [[pytest.approx(14.0), 0.004]]
    assert any(list(line.get_xdata()) == [14.5, 14.5] for line in axes.lines), "the budget"
