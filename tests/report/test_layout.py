"""The page in a browser: nothing of it is cut, on a desk, on a phone, on paper; and it is small."""

import random
from pathlib import Path

import pytest

from tests.support.layout import lay_out
from tests.support.report import Study, build_report, foreign

NAMES = ("No motion blur at all", "Full motion blur", "Head motion cancelled", "Rotation cancelled",
         "Objects only")  # fmt: skip
MOST_BYTES = 3_000_000


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    """The report of a study with five conditions: the widest tables."""
    folder = tmp_path_factory.mktemp("layout")
    chance = random.Random(3)  # noqa: S311 - no secret
    study = Study(folder / "s")
    names = [f"c{i}" for i in range(5)]
    study.describe("mine", **dict(zip(names, NAMES, strict=True)))
    for i in range(15):
        order = names[i % 5 :] + names[: i % 5]
        exposures = [(c, "room", 4 + chance.randrange(9) + 3 * names.index(c)) for c in order]
        gone = i == 7
        status = "withdrawn" if gone else "completed"
        study.session(f"P{i}", 1, 2, exposures[: 3 if gone else None], status)
        study.person(f"P{i}", "", status)
    return build_report(study.folder, out=folder / "o", forms=("svg",)).index


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.parametrize(("width_px", "printed"), [(1240, False), (390, False), (690, True)])
def test_nothing_of_the_page_is_cut(browser, page, width_px, printed):
    found = lay_out(browser, page, width_px, printed=printed)
    assert found["cut"] == []
    assert found["scroll_width"] <= found["width"] + 1
    assert (found["hidden"], found["parts"] > 10) == (0, True)


@pytest.mark.slow
@pytest.mark.browser
def test_a_table_that_does_not_scroll_would_be_found(browser, page):
    broken = page.with_name("broken.html")
    text = page.read_text("utf-8").replace("overflow-x: auto", "overflow-x: visible")
    broken.write_text(text, "utf-8")
    assert any(cut.startswith("TABLE") for cut in lay_out(browser, broken, 390)["cut"])


@pytest.mark.slow
def test_every_table_and_figure_can_be_scrolled(page):
    text = page.read_text("utf-8")
    assert text.count("<table>") == text.count('<div class="scroll" tabindex="0"><table>') > 10
    assert text.count("<svg ") == text.count('<div class="scroll"><svg ') > 5


@pytest.mark.slow
def test_the_page_of_a_thousand_people_is_small(tmp_path):
    chance = random.Random(4)  # noqa: S311 - no secret
    scores = {
        f"P{i}": {c: min(48, chance.randrange(30) + 3 * k) for k, c in enumerate("abcd")}
        for i in range(1000)
    }
    source = foreign(tmp_path / "questionnaires.csv", scores)
    summary = build_report(source, out=tmp_path / "o", forms=("svg",))
    assert summary.analysed == 1000
    assert summary.index.stat().st_size < MOST_BYTES
