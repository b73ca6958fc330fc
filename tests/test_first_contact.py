"""A stranger's first ten minutes: `new`, `simulate` and `report`, and the page that comes out."""

import csv
import json
import re
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import pytest
from typer.testing import CliRunner

from tests.support.made_studies import totals
from tests.support.page_text import sentences, visible_text, word_count
from tests.support.rated import with_drop_outs
from tests.support.report import build_report, carnegie_like, foreign
from vrcomfort.cli.app import app

MOST_WORDS, LONGEST_SENTENCE = 1500, 35


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return the folder in which a stranger has typed three commands."""
    folder = tmp_path_factory.mktemp("stranger")
    protocol, study, out = folder / "lens.toml", folder / "study", folder / "out"
    for words in (
        ["new", protocol, "--compare", "depth_of_field", "--scene", "temple", "--participants", 4,
         "--exposure-s", 360, "--rating", "fms", "--yes"],
        ["simulate", protocol, "-n", 4, "--no-draw", "--out", study],
        ["report", study, "--out", out, "--figures", "svg"],
    ):  # fmt: skip
        done = CliRunner().invoke(app, [*map(str, words)])
        assert done.exit_code == 0, done.output
    return folder


@pytest.fixture(scope="module")
def page(folder) -> str:
    return (folder / "out" / "index.html").read_text("utf-8")


def test_the_first_screen_has_question_answer_sample_and_contents(page):
    shown = visible_text(page)
    for words in (
        "Does total severity (SSQ) differ between No blur and Depth of field?",
        "4 enrolled 4 exposed 4 completed 4 analysed",
        "FMS ratings during exposure, highest rating:",
        "Contents", "Secondary outcomes", "Text for a paper",
    ):  # fmt: skip
        assert words in shown, words
    assert shown.index("Does total severity") < shown.index("Total severity: ")
    assert shown.count("Total severity: ") == 1
    assert "Nausea: " not in shown, "other outcomes are asked for"
    assert word_count(shown) <= MOST_WORDS < word_count(re.sub(r"<[^>]+>", " ", page))


def test_no_sentence_of_the_page_is_long(page):
    words = {each: len(re.findall(r"[^\W\d_][\w’'-]*", each)) for each in sentences(page)}
    assert len(words) > 60
    assert {each: n for each, n in words.items() if n > LONGEST_SENTENCE} == {}
    assert sorted(words.values())[len(words) // 2] <= 17


def test_every_link_of_the_page_leads_somewhere(folder, page):
    links = [unescape(link) for link in re.findall(r' href="([^"]+)"', page)]
    anchors = set(re.findall(r' id="([^"]+)"', re.sub(r"<svg.*?</svg>", "", page, flags=re.S)))
    assert {"#tests", "#ratings", "#paper", "#methods"} <= {*links}
    for link in links:
        if link.startswith("#"):
            assert link[1:] in anchors, link
        else:
            assert (folder / "out" / unquote(link)).is_file(), link
    for figure in re.findall(r"<figure>.*?</figure>", page, re.DOTALL):
        assert re.search(r'href="figures/[^"]+\.svg" download', figure)
        assert re.search(r'href="tables/[^"]+\.csv" download', figure), "the data of a figure"


def test_ratings_are_many_and_their_threshold_is_the_protocols_stop_rule(folder):
    ratings = json.loads((folder / "out" / "results.json").read_text("utf-8"))["ratings"]
    with (folder / "out" / "tables" / "rating_curves.csv").open(encoding="utf-8") as stream:
        assert len({row["time_s"] for row in csv.DictReader(stream)}) >= 5
    rule = [ratings[f"threshold{key}"] for key in ("", "_in_a_row", "_from")]
    assert rule == [15, 2, "stop rule"]


def test_what_never_came_is_one_line_and_no_table(page):
    part = page[page.index("Time to 2 ratings in a row") :]
    text = part[: part.index("</p>")]
    assert "0 of 8 exposures reached it (the protocol’s stop rule)" in text
    assert "There is no time to analyse." in text
    assert "reached_curves" not in page


def test_the_text_for_a_paper_has_methods_results_and_what_they_cite(folder, page):
    text = (folder / "out" / "paper.txt").read_text("utf-8")
    assert unescape(page[page.index('<pre id="paper_text">') :]).count(text[:300]) == 1
    methods, results, references = (
        text.index(f"{heading}\n") for heading in ("METHODS", "RESULTS", "REFERENCES")
    )
    assert methods < results < references
    assert "Total severity: " in text[results:references]
    assert "4 participants were enrolled." in text
    for author in ("Kennedy, R. S.", "Pratt, J. W."):
        assert author in text[references:]
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize("made", ["several exposures", "drop-outs", "one file"])
def test_other_studies_of_two_conditions_are_as_short_on_load(tmp_path, made):
    if made == "several exposures":
        source = tmp_path / "s"
        carnegie_like(source)
    elif made == "drop-outs":
        source = with_drop_outs().write(tmp_path / "s")
    else:
        source = foreign(tmp_path / "questionnaires.csv", totals(20, seed=9))
    plan = tmp_path / "plan.toml"
    plan.write_text('name = "p"\ntitle = "P"\noutcomes = ["ratings.mean"]\nscores = "raw"\n')
    summary = build_report(
        source, plan=plan if made == "drop-outs" else None, out=tmp_path / "o", forms=()
    )
    assert word_count(visible_text(summary.index.read_text("utf-8"))) <= MOST_WORDS
