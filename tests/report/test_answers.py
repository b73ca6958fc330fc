"""The page says the answer first, in words that readers know; and what it says is counted right."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.support.report import (
    HEAD,
    ONE_SCORE,
    Study,
    analysed,
    answers,
    build_report,
    carnegie_like,
    foreign,
    planned_report,
    write_csv,
)
from vrcomfort.cli.app import app
from vrcomfort.cli.report import MOST_ANSWERS
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.report import methods, palette
from vrcomfort.report.estimation import MOST_DRAWN, thinned
from vrcomfort.report.references import entries, is_known
from vrcomfort.report.words import bayes_factor
from vrcomfort.resources import data_folder

LABELS = {"q_internal_1": "Calm", "q_internal_2": "Wild"}


def text_of(page: str) -> str:
    """Return what a reader sees: no style, no tags."""
    return re.sub(r"<[^>]*>", " ", re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL))


def results_of(folder: Path) -> dict:
    return json.loads((folder / "results.json").read_text("utf-8"))


@pytest.fixture(scope="module")
def labelled(tmp_path_factory) -> Path:
    """A study with every kind of trouble, and the folder of its report."""
    folder = tmp_path_factory.mktemp("labelled")
    study = Study(folder / "s")
    study.describe("mine", **LABELS)
    for i in range(12):
        order = list(LABELS)[:: 1 if i % 2 else -1]
        more = {"q_internal_1": 0, "q_internal_2": 4 + i % 5}
        exposures = [(name, "room", 3 + i % 4 + more[name]) for name in order]
        if i == 10:
            study.session(f"P{i}", 1, 2, exposures[:1], "withdrawn")
        elif i == 11:
            study.session(f"P{i}", 1, 2, [exposures[0], (exposures[1][0], "room", None)])
        else:
            study.session(f"P{i}", 1, 2, exposures)
        study.person(f"P{i}", "", "withdrawn" if i == 10 else "completed")
    study.person("P12", "", "excluded", "fell asleep")
    build_report(study.folder, out=folder / "o", forms=("svg",))
    return folder / "o"


def test_the_answer_comes_first_with_everything_that_it_rests_on(labelled):
    page = (labelled / "index.html").read_text("utf-8")
    first = page.index('class="answer"')
    assert first < page.index("<figure>") < page.index("<table>")
    sentence = text_of(page[first : page.index("</p>", first)]).replace("\u00a0", " ")
    number = r"−?\d+\.\d\d"
    assert re.search(
        rf"Total severity: lower under Calm than under Wild; the median difference was {number} "
        rf"points, 95 % CI [\[(]{number}, {number}[\])], p = \.\d+, n = 10\.",
        sentence,
    )
    test = results_of(labelled)["tests"][0]
    evidence = text_of(page[page.index('class="evidence"') :].split("</p>")[0])
    means = [test["descriptives"][name]["mean"] for name in ("q_internal_1", "q_internal_2")]
    for mean in (*means, means[0] - means[1]):  # of one quantity: their difference is beside them
        assert f"{mean:.2f}".replace("-", "−") in evidence


def test_what_is_not_shown_is_not_called_absent(tmp_path):
    scores = {f"P{i}": {"a": 4 + i % 3, "b": 4 + (i + 1) % 3} for i in range(9)}
    source = foreign(tmp_path / "questionnaires.csv", scores)
    assert (
        planned_report(source, out=tmp_path / "o")
        .headlines[0]
        .startswith("Total severity: no difference was shown between a and b;")
    )


def test_the_terminal_says_the_first_answers_and_how_many_more_there_are(tmp_path):
    conditions = "abcd"
    scores = {f"P{i}": {c: 4 + (i + k) % 3 for k, c in enumerate(conditions)} for i in range(5)}
    file = foreign(tmp_path / "questionnaires.csv", scores)
    plan = tmp_path / "plan.toml"
    plan.write_text(HEAD + ONE_SCORE.replace('"T"', '"T", "N"'))
    words = ["report", str(file), "--plan", str(plan), "--figures", "none"]
    words += ["--out", str(tmp_path / "o")]
    said = CliRunner().invoke(app, words).stdout.splitlines()
    assert len(said) == MOST_ANSWERS + 2
    few = "Total severity: with so few people, no difference could be shown between a and b;"
    assert said[0].startswith(few)
    tests = results_of(tmp_path / "o")["tests"]
    assert said[-2] == f"… and {len(tests) - MOST_ANSWERS} more on the page."
    assert said[-1].startswith("Report: ")


def test_no_internal_name_of_a_condition_is_on_the_page(labelled):
    text = text_of((labelled / "index.html").read_text("utf-8"))
    assert "q_internal" not in text
    for label in LABELS.values():
        assert label in text
    for figure in (labelled / "figures").glob("*.svg"):
        assert "q_internal" not in figure.read_text("utf-8"), figure.name


def test_the_flow_of_participants_adds_up(labelled):
    flow = {stage["stage"]: stage for stage in results_of(labelled)["flow"]}
    counts = [flow[name]["n"] for name in ("Enrolled", "Exposed", "Completed", "Analysed")]
    assert counts == [13, 12, 11, 10]
    assert flow["Enrolled"]["left"] == [{"reason": "excluded by the experimenter", "n": 1}]
    assert flow["Exposed"]["left"] == [{"reason": "withdrew during an exposure", "n": 1}]
    assert [row["n"] for row in flow["Completed"]["left"]] == [1]
    drawn = (labelled / "figures" / "flow.svg").read_text("utf-8")
    for words in ("Enrolled", "n = 13", "1: withdrew during an exposure", "n = 10"):
        assert f">{words}<" in drawn


def test_somebody_who_withdrew_after_the_exposures_of_a_test_is_in_it(tmp_path):
    study = Study(tmp_path / "s")
    for i in range(8):
        study.session(f"P{i}", 1, 1, [("a", "x", 3 + i), ("b", "x", 2 + i % 3)][:: 1 - 2 * (i % 2)])
        study.person(f"P{i}", "", "withdrawn" if i == 0 else "completed")
    last = analysed(study.folder, ONE_SCORE)["flow"][-1]
    assert (last["n"], last["again"]) == (8, 1)


def test_the_order_that_was_met_is_audited(labelled):
    audit = results_of(labelled)["counterbalancing"]
    assert audit["positions"] == {"q_internal_1": [5, 5], "q_internal_2": [5, 5]}
    assert audit["balanced"]
    assert {(r["before"], r["after"]): r["n"] for r in audit["carry_over"]} == {
        ("q_internal_1", "q_internal_1"): 0, ("q_internal_1", "q_internal_2"): 5,
        ("q_internal_2", "q_internal_1"): 5, ("q_internal_2", "q_internal_2"): 0,
    }  # fmt: skip
    assert sum(order["n"] for order in audit["orders"]) == 10


def test_symptoms_are_those_of_the_answers(tmp_path):
    scores = {f"P{i}": {"a": 1 + i, "b": 2 * (i % 2)} for i in range(6)}
    planned_report(foreign(tmp_path / "questionnaires.csv", scores), out=tmp_path / "o")
    rows = results_of(tmp_path / "o")["symptoms"]
    first = {r["condition"]: r for r in rows if r["item"] == "general_discomfort"}
    given = [answers(1 + i)["general_discomfort"] for i in range(6)]
    assert first["a"]["mean"] == pytest.approx(sum(given) / 6)
    assert (first["a"]["above"], first["b"]["above"], first["b"]["n"]) == (6, 3, 6)
    assert "General discomfort" in text_of((tmp_path / "o" / "index.html").read_text("utf-8"))


def test_recovery_compares_the_same_sessions(tmp_path):
    study = Study(tmp_path / "s")
    for i in range(4):
        folder = study.session(f"P{i}", 1, 1, [("a", "x", 6 + i), ("b", "x", 5)])
        if i == 3:
            continue
        rows = [
            {"participant": f"P{i}", "session": 1, "timepoint": "recovery", "instrument": "ssq",
             "item": item, "response": answer}
            for item, answer in answers(1 if i else 9).items()
        ]  # fmt: skip
        with (folder / "questionnaires.csv").open("a", encoding="utf-8") as stream:
            header = (folder / "questionnaires.csv").read_text("utf-8").splitlines()[0].split(",")
            stream.writelines(
                ",".join(str(row.get(name, "")) for name in header) + "\r\n" for row in rows
            )
    planned_report(study.folder, out=tmp_path / "o")
    total = results_of(tmp_path / "o")["recovery_course"][0]
    assert (total["outcome"], total["sessions"]) == ("T", 3)
    assert (total["fell"], total["no_higher_than_baseline"]) == (2, 2)
    assert "Recovery" in (tmp_path / "o" / "index.html").read_text("utf-8")


def timed(folder: Path, seconds: dict[str, float], same: str) -> Path:
    """One file with answering times; `same` gives 2 to every question."""
    rows = []
    for person, each in seconds.items():
        for condition in ("a", "b"):
            clock = 0.0
            for item, answer in answers(7 + len(rows) % 3).items():
                rows.append(
                    {"participant": person, "condition": condition, "item": item,
                     "response": 2 if person == same else answer,
                     "asked_s": clock, "answered_s": clock + each}
                )  # fmt: skip
                clock += each
    write_csv(folder / "questionnaires.csv", tuple(rows[0]), rows)
    return folder / "questionnaires.csv"


def test_fast_and_uniform_answers_are_told_and_not_left_out(tmp_path):
    seconds = {f"P{i}": 3.0 + i for i in range(6)} | {"P9": 1.0}
    source = timed(tmp_path, seconds, same="P5")
    found = analysed(source, ONE_SCORE)
    times, alike = found["answering"]["times"], found["answering"]["straight_lined"]
    assert (times["questionnaires"], times["fast"], times["fast_people"]) == (14, 2, ["P9"])
    assert times["median_s"] == pytest.approx(5.0)
    assert [(row["participant"], row["answer"]) for row in alike] == [("P5", 2), ("P5", 2)]
    assert {"P5", "P9"} <= set(found["participants"]["analysed"])


def test_a_study_with_another_questionnaire_has_no_ssq_on_its_page(tmp_path):
    items = [item.name for item in shipped_instruments()["vrsq"].asked]
    rows = [
        {"participant": f"P{i}", "condition": condition, "instrument": "vrsq", "item": item,
         "response": (i + k + more) % 4}
        for i in range(8)
        for condition, more in (("a", 0), ("b", 1))
        for k, item in enumerate(items)
    ]  # fmt: skip
    write_csv(tmp_path / "questionnaires.csv", tuple(rows[0]), rows)
    summary = build_report(tmp_path / "questionnaires.csv", out=tmp_path / "o")
    page = summary.index.read_text("utf-8")
    assert not re.search("ssq(?<!vrsq)|simulator sickness|kennedy", page, re.IGNORECASE)
    assert "VRSQ" in page


@pytest.mark.slow
def test_figures_of_a_paper_are_named_in_its_protocol_alone(tmp_path, labelled):
    carnegie_like(tmp_path / "s")
    page = build_report(tmp_path / "s", out=tmp_path / "o", forms=("svg",)).index.read_text("utf-8")
    assert "cf. Carnegie &amp; Rhee (2015), Fig. 9" in page
    assert "cf." not in (labelled / "index.html").read_text("utf-8")


def test_text_in_figures_is_text(labelled):
    for name in ("estimation_T", "symptoms_ssq", "flow", "residuals"):
        svg = (labelled / "figures" / f"{name}.svg").read_text("utf-8")
        assert svg.count("<text") > 3
        assert 'id="DejaVu' not in svg  # no letters drawn as shapes
    assert ">Wild<" in (labelled / "figures" / "estimation_T.svg").read_text("utf-8")
    page = (labelled / "index.html").read_text("utf-8")
    drawn = len(list((labelled / "figures").iterdir()))
    assert page.count("<figure>") == page.count('role="img"') == drawn


def test_figures_on_the_page_have_the_colours_of_day_and_night(labelled):
    page = (labelled / "index.html").read_text("utf-8")
    assert "prefers-color-scheme: dark" in page
    for svg in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        assert not re.search(r"<\w[^<>]*#[0-9a-f]{6}", svg)
    for colour in palette.ALL:
        assert f"{colour.variable}: {colour.light};" in page
        assert f"{colour.variable}: {colour.dark};" in page


def luminance(colour: str) -> float:
    """Relative luminance of the web's accessibility guidelines."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, two: str) -> float:
    high, low = sorted((luminance(one), luminance(two)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def test_colours_can_be_read_on_paper_and_in_the_dark():
    for colour in (*palette.CONDITIONS, palette.INK, palette.SOFT):
        assert contrast(colour.light, palette.PAPER.light) >= 4.5, colour
        assert contrast(colour.dark, palette.PAPER.dark) >= 4.5, colour


def test_conditions_have_a_shape_each_and_no_pair_of_colour_and_shape_twice():
    looks = [(palette.colour_of(i), palette.marker_of(i)) for i in range(36)]
    assert len(set(looks)) == 36
    assert len({shape for _, shape in looks[:6]}) == 6


def test_every_reference_is_of_a_method_and_every_method_has_its_references(labelled):
    known = tomllib.loads((data_folder("analysis") / "report" / "references.toml").read_text())
    written = Path(methods.__file__).parent.rglob("*.py")
    source = "".join(file.read_text("utf-8") for file in written)
    for key in known:
        assert key.startswith("instrument_") or f'"{key}"' in source, key
    page = (labelled / "index.html").read_text("utf-8")
    assert "Friedman, M." not in page  # two conditions: no Friedman test was made
    for author in ("Pratt, J. W.", "Holm, S.", "Kennedy, R. S.", "Hodges, J. L."):
        assert page[: page.index('id="paper"')].count(author) == 1
    assert not is_known("nobody_1900")
    with pytest.raises(KeyError, match="nobody_1900"):
        entries(["nobody_1900"])


def test_the_plan_its_hash_and_what_was_done_otherwise_are_printed(labelled, tmp_path):
    results = results_of(labelled)
    page = (labelled / "index.html").read_text("utf-8")
    assert results["plan"]["sha256"] in page
    assert results["date"] in page
    for name, version in results["software"].items():
        assert f"{name} {version}" in page
    for each in results["deviations"]:
        assert each["text"].split(":")[0] in page


@pytest.mark.parametrize(
    ("value", "written"),
    [(2.078, "2.08"), (123456.0, "1.2\u00a0×\u00a010⁵"),
     (0.00012, "1.2\u00a0×\u00a010⁻⁴"), (None, "–")],
)  # fmt: skip
def test_bayes_factors_of_any_size_can_be_read(value, written):
    assert bayes_factor(value) == written


def test_of_many_people_evenly_spaced_ones_are_drawn():
    drawn = thinned(np.arange(100_000.0))
    assert (drawn.size, drawn[0], drawn[-1]) == (MOST_DRAWN, 0, 99_999)
    assert np.ptp(np.diff(drawn)) <= 1
    assert thinned(np.arange(7.0)).tolist() == list(range(7))


MISSING = "The planned primary outcome (Spatial presence, ipq.spatial) is not in the data"


def test_a_planned_primary_outcome_that_is_missing_comes_before_all_else(tmp_path):
    """A study that was to show presence, and asked for sickness alone."""
    scores = {f"P{i}": {"a": 4 + i, "b": 2 + i % 3} for i in range(8)}
    file = foreign(tmp_path / "questionnaires.csv", scores)
    plan = tmp_path / "plan.toml"
    plan.write_text(HEAD + ONE_SCORE.replace('"T"', '"ipq.spatial", "T", "N"'))
    words = ["report", str(file), "--plan", str(plan), "--figures", "svg"]
    said = CliRunner().invoke(app, [*words, "--out", str(tmp_path / "o")])
    assert said.exit_code == 0
    assert MISSING in " ".join(said.stderr.split("note:")[1].split())
    assert "the IPQ was not answered; the data have the SSQ" in " ".join(said.stderr.split())
    assert all(line.startswith("Secondary: ") for line in said.stdout.splitlines()[:2])
    text = (tmp_path / "o" / "results.json").read_text("utf-8")
    assert text.startswith('{\n  "without_primary": "' + MISSING)

    page = (tmp_path / "o" / "index.html").read_text("utf-8")
    body = page[page.index("</header>") :]
    assert body.index(MISSING) < body.index('<section id="answers">')
    assert body.index("<h2>Secondary outcomes</h2>") < body.index('<p class="answer other">')
    assert '<p class="answer">' not in body
    assert body.index("<figure") > body.index('id="tests"'), "no figure is that of the headline"
    assert "primary analysis" not in body


def test_other_outcomes_that_are_missing_leave_the_headline_to_the_primary(tmp_path):
    scores = {f"P{i}": {"a": 4 + i, "b": 2} for i in range(8)}
    file = foreign(tmp_path / "questionnaires.csv", scores)
    lines = ONE_SCORE.replace('"T"', '"T", "ipq.spatial"')
    summary = planned_report(file, out=tmp_path / "o", lines=lines)
    assert summary.without_primary == ""
    assert results_of(tmp_path / "o")["without_primary"] is None
    assert summary.headlines[0].startswith("Total severity: higher under a")
