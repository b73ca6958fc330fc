"""What changes an answer stands before it: of made studies, each with one such thing."""

import re

import pytest

from tests.support.made_studies import LINES, MADE, totals
from tests.support.report import ONE_SCORE, build_report, foreign, planned_report


def first_screen(page: str) -> str:
    """Return the text above the answers, and the answers themselves, without tags."""
    top = page[page.index("<header>") : page.index('id="tests"')]
    return " ".join(re.sub(r"<[^>]+>", " ", top).split())


@pytest.mark.parametrize("name", MADE)
def test_what_changes_the_answer_stands_first(tmp_path, name):
    made, flag = MADE[name]
    lines = LINES.get(name, ONE_SCORE)
    summary = planned_report(made(tmp_path / "s"), out=tmp_path / "o", lines=lines)
    assert re.search(flag, first_screen(summary.index.read_text("utf-8")), re.I), name
    assert "?." not in first_screen(summary.index.read_text("utf-8"))
    said = " ".join([summary.without_primary, *summary.warnings])
    if name != "a planned primary outcome missing":  # the terminal has its own words for it
        assert re.search(flag, said), name


def test_a_plain_study_has_nothing_of_it(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", totals(20, seed=9))
    summary = build_report(file, out=tmp_path / "o")
    said = " ".join([summary.without_primary, *summary.warnings])
    assert [name for name, (_, flag) in MADE.items() if re.search(flag, said)] == []
