"""Questionnaires that a study asked as a short form: confirmed in the import, or never recorded."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.layouts import ITEMS, PEOPLE, study, write
from tests.support.made_studies import totals
from tests.support.report import (
    WITHOUT_MODELS,
    Study,
    analysed,
    answers,
    planned_report,
    results_of,
    write_csv,
)
from vrcomfort.errors import InputError
from vrcomfort.importing import MappingFile, parse_mapping, write_study
from vrcomfort.importing.convert import import_files
from vrcomfort.questionnaire import score, shipped_instruments, short_form

SSQ = shipped_instruments()["ssq"]
TABLE = """\
format_version = 1
[[tables]]
files = ["{file}"]
participant = {{ column = "who" }}
condition = {{ column = "what" }}
timepoint = {{ column = "when" }}
[[tables.questionnaires]]
instrument = "ssq"
not_asked = {not_asked}
"""
OCULOMOTOR = tuple(term.item for term in SSQ.scale("O").terms)  # type: ignore[union-attr]


def imported(folder: Path, *not_asked: str) -> Path:
    """Return the study of an import of ten people who were asked the other items."""
    kept = [item for item in ITEMS if item not in not_asked]
    rows: list[list[object]] = [["who", "what", "when", *kept]]
    for (who, condition, moment), given in study().items():
        asked = [a for item, a in zip(ITEMS, given, strict=True) if item in kept]
        rows.append([who, condition, moment, *asked])
    folder.mkdir(parents=True, exist_ok=True)
    file = write(folder / "answers.csv", rows)
    text = TABLE.format(file=file.name, not_asked=json.dumps(not_asked))
    mapping = MappingFile(parse_mapping(text, None), folder / "map.toml", text)
    write_study(folder / "study", import_files([file], mapping.mapping), mapping, [file])
    return folder / "study"


def titles(results: dict[str, Any]) -> list[str]:
    return [each["title"] for each in results["outcomes"]]


def test_a_short_form_is_analysed_and_called_one(tmp_path):
    folder = imported(tmp_path, "burping", "vertigo")
    summary = planned_report(folder, out=tmp_path / "o", lines=WITHOUT_MODELS)
    results = results_of(summary)
    assert titles(results) == [
        "Total severity (short form)", "Nausea (short form)", "Oculomotor",
        "Disorientation (short form)",
    ]  # fmt: skip
    assert all(not test["not_tested"] and test["n"] == len(PEOPLE) for test in results["tests"])
    (notice,) = (line for line in results["notices"] if "short form" in line)
    assert notice == (
        "the SSQ is a short form, without vertigo, burping: Nausea (short form) goes from 0 to "
        "171.72, Disorientation (short form) goes from 0 to 250.56, Total severity (short form) "
        "goes from 0 to 213.18; scores of the items that were asked compare conditions of this "
        "study, and nothing with scores or norms of the whole questionnaire"
    )
    page = summary.index.read_text("utf-8")
    assert "without vertigo, burping, which were not asked" in page
    assert "14 items" in page
    assert "Total severity (short form) 0.00 to 213.18" in page
    assert {o["name"]: o["high"] for o in results["outcomes"]}["T"] == pytest.approx(213.18)
    assert {stage["stage"]: stage["n"] for stage in results["flow"]}["Completed"] == len(PEOPLE)
    assert not results["quality"]["excluded_questionnaires"]
    assert {row["item"] for row in results["symptoms"]} == set(ITEMS) - {"vertigo", "burping"}


def test_scores_of_a_short_form_are_those_of_the_items_that_were_asked():
    short = short_form(SSQ, ["burping", "vertigo"])
    given = {item: 1 for item in ITEMS if item not in {"burping", "vertigo"}}
    found = {name: each.raw for name, each in score(short, given).items() if each}
    assert found == {"N": 6, "O": 7, "D": 6, "T": 19}
    whole = score(SSQ, answers(20))
    same = score(short_form(SSQ, []), answers(20))
    assert same == whole
    assert float(short.scale("N").high) == pytest.approx(9.54 * 18)


@pytest.fixture(scope="module")
def without_oculomotor(tmp_path_factory) -> Path:
    return imported(tmp_path_factory.mktemp("short"), *OCULOMOTOR)


def test_what_cannot_be_scored_is_said_once_and_the_rest_is_tested(without_oculomotor):
    results = analysed(without_oculomotor, WITHOUT_MODELS)
    assert titles(results) == ["Nausea (short form)", "Disorientation (short form)"]
    assert all(not test["not_tested"] for test in results["tests"])
    said = "Oculomotor cannot be scored: none of its items was asked"
    assert "\n".join(results["notices"]).count(said) == 1
    assert "Total severity cannot be scored: it is made of O, which has none" in "".join(
        results["notices"]
    )


def test_a_planned_outcome_that_the_short_form_does_not_have_is_a_deviation(without_oculomotor):
    results = analysed(without_oculomotor, f'outcomes = ["N", "O"]\n{WITHOUT_MODELS}')
    kinds = {each["kind"]: each["text"] for each in results["deviations"]}
    assert kinds["outcome_not_found"] == (
        "outcome O is not in the data: the SSQ was asked as a short form, and none of its items "
        "was asked"
    )
    assert kinds["short_form"].startswith("Nausea (short form): the SSQ was asked without general")


def test_a_short_form_without_any_score_is_one_sentence(without_oculomotor):
    with pytest.raises(InputError, match=r"the data have no outcome of the plan \(O: the SSQ was"):
        analysed(without_oculomotor, 'outcomes = ["O"]\n')


@pytest.mark.parametrize(
    ("instrument", "lost", "scored", "why"),
    [
        ("mssq_adult", ["mssq_b_cars", "mssq_b_buses"], {"msb": 9}, ""),
        ("nasa_tlx", ["mental"], {}, "the weight of each"),
        ("vrsq", ["eyestrain"], {}, ""),
    ],
)
def test_each_way_of_scoring_has_its_own_short_form(instrument, lost, scored, why):
    whole = shipped_instruments()[instrument]
    names = [item.name for item in whole.items]
    lost = [next(n for n in names if part in n) for part in lost]
    short = short_form(whole, lost)
    for name, count in scored.items():  # the instrument's own rule for missing items holds
        assert len(short.scale(name).terms) == count
        assert name not in short.shortened
    assert not why or any(why in each for each in short.unscored.values())
    if instrument == "vrsq":  # per cent of what the asked items can give
        given = {item.name: item.answers.high for item in whole.items if item.name not in lost}
        assert {each.points for each in score(short, given).values() if each} == {100.0}


def test_two_tables_of_one_study_may_leave_out_different_items(tmp_path):
    """Only what was asked everywhere can be compared."""
    texts, files = [], []
    for moment, lost in (("baseline", "burping"), ("post", "vertigo")):
        kept = [item for item in ITEMS if item != lost]
        rows: list[list[object]] = [["who", "what", "when", *kept]]
        for (who, condition, when), given in study().items():
            if when == moment:
                asked = [a for item, a in zip(ITEMS, given, strict=True) if item != lost]
                rows.append([who, condition, when, *asked])
        files.append(write(tmp_path / f"{moment}.csv", rows))
        text = TABLE.format(file=files[-1].name, not_asked=json.dumps([lost]))
        texts.append(text.replace("format_version = 1\n", "") if texts else text)
    mapping = MappingFile(parse_mapping("".join(texts), None), tmp_path / "m.toml", "".join(texts))
    write_study(tmp_path / "s", import_files(files, mapping.mapping), mapping, files)
    results = analysed(tmp_path / "s", WITHOUT_MODELS)
    assert results["score_basis"] == "difference_from_baseline"
    assert {test["n"] for test in results["tests"]} == {len(PEOPLE)}
    assert "without vertigo, burping" in "".join(results["notices"])


def without(folder: Path, lost: dict[str, set[str]]) -> Path:
    """Take the rows of items out of the questionnaires of a study, of some people or of all."""
    for file in folder.rglob("questionnaires.csv"):
        with file.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        kept = [r for r in rows if r["item"] not in lost.get(r["participant"], lost.get("", set()))]
        write_csv(file, tuple(rows[0]), kept)
    return folder


def recorded(folder: Path) -> Path:
    study = Study(folder)
    study.describe("tiny", a="A", b="B")
    for place, (name, each) in enumerate(totals(12, seed=7, effect=3).items()):
        study.session(name, 1, 0, [(c, "x", t) for c, t in each.items()][:: 1 - 2 * (place % 2)])
        study.person(name, "ab")
    return folder


def test_an_item_that_no_questionnaire_of_a_study_has_makes_a_short_form(tmp_path):
    folder = without(recorded(tmp_path / "s"), {"": {"burping"}})
    results = analysed(folder, WITHOUT_MODELS)
    assert titles(results)[:2] == ["Total severity (short form)", "Nausea (short form)"]
    assert all(not test["not_tested"] and test["n"] == 12 for test in results["tests"])
    assert not results["quality"]["excluded_questionnaires"]
    (notice,) = (line for line in results["notices"] if "short form" in line)
    assert "without burping: Nausea (short form) goes from 0 to 171.72" in notice


def test_the_items_of_one_subscale_are_scored_alone(tmp_path):
    folder = without(recorded(tmp_path / "s"), {"": {*ITEMS} - {*OCULOMOTOR}})
    results = analysed(folder, WITHOUT_MODELS)
    assert "Oculomotor" in titles(results)
    assert "Total severity (short form)" in titles(results)
    assert all(not test["not_tested"] and test["n"] == 12 for test in results["tests"])
    assert not results["quality"]["excluded_questionnaires"]


def test_an_item_that_some_people_lack_is_missing(tmp_path):
    folder = without(recorded(tmp_path / "s"), {"P03": {"burping"}})
    results = analysed(folder, WITHOUT_MODELS)
    assert titles(results)[0] == "Total severity"
    assert {row["participant"] for row in results["quality"]["excluded_questionnaires"]} == {"P03"}


def test_questionnaires_that_were_cut_short_are_no_short_form(tmp_path):
    cut = {f"P{i + 1:02d}": set(ITEMS[3 + i % 4 :]) for i in range(12)}
    folder = without(recorded(tmp_path / "s"), cut)
    results = analysed(folder, WITHOUT_MODELS)
    assert not any("short form" in line for line in results["notices"])
