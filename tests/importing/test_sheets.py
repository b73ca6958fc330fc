"""Sheets as students lay them out: sections, computed cells, codes, totals, sliders."""

from __future__ import annotations

import csv
import random
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import openpyxl
import pytest

from tests.support.layouts import ENGLISH, ITEMS
from vrcomfort.importing import import_files
from vrcomfort.importing.mapping import parse_mapping
from vrcomfort.importing.suggest import Suggestion, suggest_mapping
from vrcomfort.questionnaire import shipped_instruments

Row = Sequence[object]
Truth = dict[tuple[str, str, str, str], Mapping[str, float]]
"""(instrument, participant, condition, timepoint) → answers."""
Made = tuple[list[Path], Truth]

TLX = [item.name for item in shipped_instruments()["nasa_tlx"].asked]
SUS = [item.name for item in shipped_instruments()["sus"].asked]
LOADS = ["Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort"]
LOADS += ["Frustration"]
PEOPLE = [f"P{number:02d}" for number in range(1, 9)]
RANDOM = random.Random(5)  # noqa: S311 - data of tests
LAYOUTS: dict[str, Callable[[Path], Made]] = {}


def layout(make: Callable[[Path], Made]) -> Callable[[Path], Made]:
    LAYOUTS[make.__name__] = make
    return make


def ssq() -> list[int]:
    return [RANDOM.choice([0, 0, 1, 2, 3]) for _ in ITEMS]


def tlx() -> list[int]:
    return [RANDOM.randrange(0, 101, 5) for _ in TLX]


def sus() -> list[int]:
    return [RANDOM.randint(1, 5) for _ in SUS]


def table(file: Path, rows: Sequence[Row]) -> Path:
    with file.open("w", encoding="utf-8", newline="") as opened:
        csv.writer(opened).writerows(rows)
    return file


def workbook(file: Path, sheets: Mapping[str, Sequence[Row]]) -> Path:
    book = openpyxl.Workbook()
    book.remove(book.worksheets[0])
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append([*row])
    book.save(file)
    return file


@layout
def sections_with_titles(folder: Path) -> Made:
    rows: list[Row] = []
    truth: Truth = {}
    for condition in ("Teleport", "Joystick", "Walking in place"):
        rows += [[condition], ["ID", *LOADS]]
        for person in PEOPLE:
            answers = tlx()
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, answers, strict=True))
            rows.append([person, *answers])
        rows += [["Mean", *[50] * 6], []]
    return [workbook(folder / "NASA-TLX.xlsx", {"Sheet1": rows})], truth


@layout
def titles_in_the_first_heading(folder: Path) -> Made:
    rows: list[Row] = []
    truth: Truth = {}
    for condition in ("Teleport", "Joystick"):
        rows.append([condition, *LOADS])
        for person in PEOPLE:
            answers = tlx()
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, answers, strict=True))
            rows.append([person, *answers])
        rows.append([])
    return [table(folder / "TLX.csv", rows)], truth


@layout
def two_questionnaires_in_one_sheet(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["NASA TLX"], ["Participant", "Condition", *LOADS]]
    for person in PEOPLE:
        for condition in ("A", "B"):
            loads = tlx()
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, loads, strict=True))
            rows.append([person, condition, *loads])
    rows += [[], ["SUS"], ["Participant", "Condition", *(f"Q{n}" for n in range(1, 11))]]
    for person in PEOPLE:
        for condition in ("A", "B"):
            answers = sus()
            truth["sus", person, condition, "post"] = dict(zip(SUS, answers, strict=True))
            rows.append([person, condition, *answers])
    return [workbook(folder / "data.xlsx", {"Sheet1": rows})], truth


@layout
def statistics_below_and_beside(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Participant ID", "Group", *(f"Q{n}" for n in range(1, 11)), "SUS"]]
    for number, person in enumerate(PEOPLE):
        group, answers = ("VR" if number % 2 else "PC"), sus()
        truth["sus", person, group, "post"] = dict(zip(SUS, answers, strict=True))
        rows.append([person, group, *answers, 50])
    rows += [["Average", "", *[3.1] * 10, 61.2], []]
    rows += [["", "", *(round(RANDOM.random(), 4) for _ in range(11))] for _ in range(6)]
    return [workbook(folder / "SUS.xlsx", {"Blad1": rows})], truth


@layout
def scores_beside_each_person_of_a_sheet_on_its_side(folder: Path) -> Made:
    answers = {person: sus() for person in PEOPLE}
    rows: list[Row] = [["Item", *(cell for p in PEOPLE for cell in (p, f"Score {p}"))]]
    for n in range(10):
        cells = [answers[person][n] for person in PEOPLE]
        scores = [cell - 1 if n % 2 == 0 else 5 - cell for cell in cells]
        rows.append([n + 1, *(x for pair in zip(cells, scores, strict=True) for x in pair)])
    rows.append(["Sum", *(cell for _ in PEOPLE for cell in ("", 20))])
    truth = {("sus", p, "all", "post"): dict(zip(SUS, answers[p], strict=True)) for p in PEOPLE}
    return [workbook(folder / "usability.xlsx", {"SUS": rows})], truth


@layout
def legend_beside_people_of_a_sheet_on_its_side(folder: Path) -> Made:
    answers = {person: ssq() for person in PEOPLE}
    rows: list[Row] = [["Symptom", *PEOPLE, "", "0 = none, 3 = severe"]]
    rows += [[text, *(answers[p][n] for p in PEOPLE)] for n, text in enumerate(ENGLISH)]
    truth = {("ssq", p, "all", "post"): dict(zip(ITEMS, answers[p], strict=True)) for p in PEOPLE}
    return [workbook(folder / "symptoms.xlsx", {"SSQ": rows})], truth


@layout
def person_and_moment_in_one_heading(folder: Path) -> Made:
    truth: Truth = {}
    heading, columns = ["Symptom"], []
    for person in PEOPLE:
        for word, moment in (("Pre", "baseline"), ("Post", "post")):
            heading.append(f"{person} {word}")
            columns.append(ssq())
            truth["ssq", person, "all", moment] = dict(zip(ITEMS, columns[-1], strict=True))
    rows = [[text, *(column[n] for column in columns)] for n, text in enumerate(ENGLISH)]
    return [table(folder / "ssq.csv", [heading, *rows])], truth


@layout
def person_and_condition_in_one_code(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["ID", *ENGLISH]]
    for person in PEOPLE:
        for condition in ("VR", "Desktop"):
            answers = ssq()
            truth["ssq", person, condition, "post"] = dict(zip(ITEMS, answers, strict=True))
            rows.append([f"{person}_{condition}", *answers])
    return [table(folder / "answers.csv", rows)], truth


@layout
def baseline_beside_conditions_on_its_side(folder: Path) -> Made:
    truth: Truth = {}
    sheets: dict[str, list[Row]] = {}
    for person in PEOPLE:
        columns = {name: ssq() for name in ("Baseline", "Blur", "Sharp")}
        for name, answers in columns.items():
            known = ("", "baseline") if name == "Baseline" else (name, "post")
            truth["ssq", person, *known] = dict(zip(ITEMS, answers, strict=True))
        rows: list[Row] = [["Symptom", *columns]]
        rows += [[text, *(c[n] for c in columns.values())] for n, text in enumerate(ENGLISH)]
        sheets[person] = rows
    return [workbook(folder / "all.xlsx", sheets)], truth


@layout
def conditions_called_vr_and_ar(folder: Path) -> Made:
    truth: Truth = {}
    moments = [(c, t) for c in ("VR", "AR") for t in ("pre", "post")]
    rows: list[Row] = [["ID", *(f"SSQ{n}_{c}_{t}" for c, t in moments for n in range(1, 17))]]
    for person in PEOPLE:
        cells: list[int] = []
        for condition, when in moments:
            answers, moment = ssq(), "baseline" if when == "pre" else "post"
            truth["ssq", person, condition, moment] = dict(zip(ITEMS, answers, strict=True))
            cells += answers
        rows.append([person, *cells])
    return [table(folder / "wide.csv", rows)], truth


@layout
def baseline_is_a_system(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Respondent", "System", *(f"SUS{n}" for n in range(1, 11))]]
    for person in PEOPLE:
        for system in ("Ours", "Baseline"):
            answers = sus()
            truth["sus", person, system, "post"] = dict(zip(SUS, answers, strict=True))
            rows.append([person, system, *answers])
    return [table(folder / "eval.csv", rows)], truth


@layout
def ratings_weights_and_products(folder: Path) -> Made:
    truth: Truth = {}
    kinds = ("Rating", "Weight", "Product")
    rows: list[Row] = [["Participant", "Condition", *(f"{t} {k}" for t in LOADS for k in kinds)]]
    for person in PEOPLE:
        for condition in ("Blur", "NoBlur"):
            answers, weights = tlx(), RANDOM.sample(range(6), 6)
            pairs = [*zip(answers, weights, strict=True)]
            said = {f"weight_{item}": w for item, w in zip(TLX, weights, strict=True)}
            said |= dict(zip(TLX, answers, strict=True))
            truth["nasa_tlx", person, condition, "post"] = said
            rows.append([person, condition, *(x for a, w in pairs for x in (a, w, a * w))])
    return [table(folder / "tlx.csv", rows)], truth


@layout
def products_of_conditions_with_codes_like_items(folder: Path) -> Made:
    truth: Truth = {}
    conditions, codes = ("pd", "po", "pe"), ("md", "pd", "td", "pe", "ef", "fr")
    rows: list[Row] = [["subject", *(f"{c}-{x}" for c in conditions for x in (*codes, "total"))]]
    for person in PEOPLE:
        cells: list[float] = []
        for condition in conditions:
            weights = RANDOM.sample(range(6), 6)
            products = [a * w for a, w in zip(tlx(), weights, strict=True)]
            total = round(sum(products) / 15, 2)
            truth["nasa_tlx_scores", person, condition, "post"] = {"weighted_tlx": total}
            cells += [*products, total]
        rows.append([person, *cells])
    return [table(folder / "nasa_tlx.csv", rows)], truth


@layout
def names_of_people(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["First name", "Setup", *LOADS]]
    for number, name in enumerate(("Anna", "Ben", "Carla", "Dan", "Eva", "Finn"), start=1):
        for condition in ("A", "B", "C"):
            answers = tlx()
            truth["nasa_tlx", str(number), condition, "post"] = dict(zip(TLX, answers, strict=True))
            rows.append([name, condition, *answers])
    return [table(folder / "tlx.csv", rows)], truth


@layout
def slider_in_twentieths_with_initials(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["scale", "score", "task", "id"]]
    for person in PEOPLE:
        for condition in ("easy", "hard"):
            answers = [RANDOM.randrange(0, 20001) / 1000 for _ in TLX]
            said = [round(5 * answer, 3) for answer in answers]
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, said, strict=True))
            initials = ("ME", "PH", "TI", "PE", "EF", "FR")
            rows += [
                [word, answer, condition, person]
                for word, answer in zip(initials, answers, strict=True)
            ]
    return [table(folder / "load.csv", rows)], truth


@layout
def totals_by_condition(folder: Path) -> Made:
    truth: Truth = {}
    conditions = ("Static", "Dynamic", "None")
    rows: list[Row] = [["Participant", *conditions]]
    for person in PEOPLE:
        totals = [round(3.74 * RANDOM.randint(0, 30), 2) for _ in conditions]
        for condition, total in zip(conditions, totals, strict=True):
            truth["ssq_scores", person, condition, "post"] = {"total": total}
        rows.append([person, *totals])
    return [table(folder / "SSQ_total.csv", rows)], truth


@layout
def rows_without_an_item(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["condition", "question", "slider.response", "participant"]]
    for person in PEOPLE:
        for condition in ("blur", "sharp"):
            answers = ssq()
            truth["ssq", person, condition, "post"] = dict(zip(ITEMS, answers, strict=True))
            rows.append(["", "", "", person])
            rows += [[condition, t, a, person] for t, a in zip(ENGLISH, answers, strict=True)]
    return [table(folder / "experiment.csv", rows)], truth


@layout
def chinese_survey(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [
        ["序号", "提交答卷时间", "1、您的编号", "2、实验条件", "3、一般不适", "4、疲劳", "5、头痛",
         "6、眼睛疲劳", "7、难以聚焦", "8、唾液增多", "9、出汗", "10、恶心", "11、注意力难以集中",
         "12、头部胀满", "13、视力模糊", "14、头晕(睁眼)", "15、头晕(闭眼)", "16、眩晕",
         "17、胃部不适", "18、打嗝"]
    ]  # fmt: skip
    words = ("无", "轻微", "中等", "严重")
    for person in PEOPLE:
        for condition in ("甲", "乙"):
            answers = ssq()
            truth["ssq", person, condition, "post"] = dict(zip(ITEMS, answers, strict=True))
            cells = [words[answer] for answer in answers]
            rows.append([len(rows), "2024/3/12 10:11", person, condition, *cells])
    return [table(folder / "data.csv", rows)], truth


@layout
def sheets_called_after_moments(folder: Path) -> Made:
    truth: Truth = {}
    sheets: dict[str, list[Row]] = {}
    for name, moment in (("Pre", "baseline"), ("Post", "post"), ("30 min later", "recovery")):
        sheets[name] = [["Subject", *ENGLISH]]
        for person in PEOPLE:
            answers = ssq()
            truth["ssq", person, "all", moment] = dict(zip(ITEMS, answers, strict=True))
            sheets[name].append([person, *answers])
    return [workbook(folder / "SSQ_results.xlsx", sheets)], truth


@layout
def as_many_row_numbers_as_items(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["", "Participant", "Condition", *(f"Q{n}" for n in range(1, 17))]]
    for person in PEOPLE:
        for condition in ("1", "2"):
            answers = ssq()
            truth["ssq", person, condition, "post"] = dict(zip(ITEMS, answers, strict=True))
            rows.append([len(rows), person, condition, *answers])
    return [table(folder / "ssq_long.csv", rows)], truth


@layout
def answers_around_zero(folder: Path) -> Made:
    truth: Truth = {}
    items = [item.name for item in shipped_instruments()["ipq"].asked]
    rows: list[Row] = [["PID", "Condition", *(f"IPQ{n}" for n in range(1, 15))]]
    for person in PEOPLE:
        for condition in ("HMD", "CAVE"):
            answers = [RANDOM.randint(-3, 3) for _ in items]
            said = [answer + 3 for answer in answers]
            truth["ipq", person, condition, "post"] = dict(zip(items, said, strict=True))
            rows.append([person, condition, *answers])
    return [table(folder / "presence.csv", rows)], truth


@layout
def letters_beside_initials(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Participant", "Technique", "MD", "PD", "TD", "P", "E", "F", "Total"]]
    for person in PEOPLE:
        for condition in ("Ray", "Hand"):
            answers = tlx()
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, answers, strict=True))
            rows.append([person, condition, *answers, round(sum(answers) / 6, 2)])
    return [workbook(folder / "NASA TLX.xlsx", {"Sheet1": rows})], truth


@layout
def merged_cells_of_person_and_condition(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Participant", "Condition", "Scale", "Rating"]]
    for person in PEOPLE:
        for number, condition in enumerate(("A", "B")):
            answers = tlx()
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, answers, strict=True))
            for n, (text, answer) in enumerate(zip(LOADS, answers, strict=True)):
                who, what = "" if n or number else person, "" if n else condition
                rows.append([who, what, text, answer])
    return [workbook(folder / "TLX raw.xlsx", {"Sheet1": rows})], truth


@layout
def moments_under_session(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["User ID", "Session", *ENGLISH]]
    for person in PEOPLE:
        for session, moment in (("Pre-exposure", "baseline"), ("Post-exposure", "post")):
            answers = ssq()
            truth["ssq", person, "all", moment] = dict(zip(ITEMS, answers, strict=True))
            rows.append([person, session, *answers])
    return [table(folder / "answers.csv", rows)], truth


@layout
def tables_side_by_side_in_orders_of_their_own(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Joystick", *[""] * 7, "Teleport"], ["ID", *LOADS, "", "ID", *LOADS]]
    for number, person in enumerate(PEOPLE):
        other, one, two = PEOPLE[(number + 3) % len(PEOPLE)], tlx(), tlx()
        truth["nasa_tlx", person, "Joystick", "post"] = dict(zip(TLX, one, strict=True))
        truth["nasa_tlx", other, "Teleport", "post"] = dict(zip(TLX, two, strict=True))
        rows.append([person, *one, "", other, *two])
    return [workbook(folder / "tlx.xlsx", {"Sheet1": rows})], truth


@layout
def a_row_for_each_item_and_a_column_for_each_condition(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Participant", "Item", "Blur", "Sharp"]]
    for person in PEOPLE:
        one, two = tlx(), [answer // 10 for answer in tlx()]
        truth["nasa_tlx", person, "Blur", "post"] = dict(zip(TLX, one, strict=True))
        truth["nasa_tlx", person, "Sharp", "post"] = dict(zip(TLX, two, strict=True))
        rows += [[person, *cells] for cells in zip(LOADS, one, two, strict=True)]
    return [table(folder / "tlx_items.csv", rows)], truth


@layout
def a_row_for_each_scale(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["id", "condition", "subscale", "score"]]
    weights = {"nausea": 9.54, "oculomotor": 7.58, "disorientation": 13.92}
    for person in PEOPLE:
        for condition in ("Blur", "Sharp"):
            sums = {scale: RANDOM.randint(0, 9) for scale in weights}
            scores = {scale: round(sums[scale] * weights[scale], 2) for scale in weights}
            scores["total"] = round(sum(sums.values()) * 3.74, 2)
            truth["ssq_scores", person, condition, "post"] = scores
            rows += [[person, condition, s.capitalize(), score] for s, score in scores.items()]
    return [table(folder / "ssq_tidy.csv", rows)], truth


@layout
def a_column_for_each_person(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Condition", "Item", *PEOPLE]]
    for condition in ("A", "B"):
        columns = {person: tlx() for person in PEOPLE}
        for person, answers in columns.items():
            truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, answers, strict=True))
        for n, text in enumerate(LOADS):
            rows.append(["" if n else condition, text, *(columns[p][n] for p in PEOPLE)])
    return [workbook(folder / "tlx.xlsx", {"Sheet1": rows})], truth


@layout
def a_factor_beside_the_interface(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["Participant", "Difficulty", "Interface", *LOADS]]
    for person in PEOPLE:
        for difficulty in ("Easy", "Hard"):
            for interface in ("Menu", "Voice"):
                answers, condition = tlx(), f"{interface}_{difficulty}"
                truth["nasa_tlx", person, condition, "post"] = dict(zip(TLX, answers, strict=True))
                rows.append([person, difficulty, interface, *answers])
    return [table(folder / "exp.csv", rows)], truth


@layout
def totals_of_a_baseline_interface(folder: Path) -> Made:
    truth: Truth = {}
    rows: list[Row] = [["PID", "TLX_Baseline", "TLX_AR", "TLX_VR"]]
    for person in PEOPLE:
        totals = [round(RANDOM.random() * 100, 2) for _ in range(3)]
        for condition, total in zip(("Baseline", "AR", "VR"), totals, strict=True):
            truth["nasa_tlx_scores", person, condition, "post"] = {"raw_tlx": total}
        rows.append([person, *totals])
    return [table(folder / "tlx.csv", rows)], truth


@pytest.fixture(params=LAYOUTS)
def made(request: pytest.FixtureRequest, tmp_path: Path) -> Made:
    RANDOM.seed(5)
    return LAYOUTS[request.param](tmp_path)


def test_answers_are_those_that_a_careful_reader_finds(made: Made) -> None:
    files, truth = made
    suggested = suggest_mapping(files)
    assert suggested.imported is not None, suggested.doubts
    found = {
        (instrument, m.participant, m.condition, m.timepoint): response.answers
        for (instrument, m), response in suggested.imported.responses.items()
    }
    assert {*found} == {*truth}
    for key, answers in truth.items():
        assert found[key] == pytest.approx(answers, abs=0.006), key


def suggested_for(file: Path, rows: Sequence[Row]) -> Suggestion:
    return suggest_mapping([table(file, rows)])


def test_means_of_groups_are_nobodys_answers(tmp_path: Path) -> None:
    rows = [[text, 12.58, 11.33, 0.93, 0.69] for text in LOADS]
    found = suggested_for(tmp_path / "nasa_tlx.csv", [["", "DAW", "VR", "DAW SE", "VR SE"], *rows])
    assert found.imported is None
    assert "this table gives nothing" in found.doubts[0]


def test_other_questions_under_numbers_are_no_usability_scale(tmp_path: Path) -> None:
    about = ["navigation", "contrast", "keyboard", "labels", "errors", "focus", "pictures"]
    about += ["headings", "forms", "timing"]
    rows = [
        [person, f"Q{n}", f"I found that the {what} worked well for me", 1 + n % 5]
        for person in PEOPLE
        for n, what in enumerate(about, start=1)
    ]
    found = suggested_for(
        tmp_path / "accessibility.csv", [["Evaluator", "QuestionID", "Statement", "Rating"], *rows]
    )
    assert found.imported is not None
    assert {name for name, _ in found.imported.responses} == {"own_questions"}
    (own,) = found.imported.instruments.values()
    assert own.items[4].text == "I found that the errors worked well for me"


def test_files_without_answers_are_left_out_with_a_doubt(tmp_path: Path) -> None:
    RANDOM.seed(5)
    answers = table(tmp_path / "ssq.csv", [["id", *ENGLISH], *([p, *ssq()] for p in PEOPLE)])
    log = table(tmp_path / "log.csv", [["t", "x"], [0.1, 2.5], [0.2, 2.7], [0.3, 2.1]])
    found = suggest_mapping([answers, log])
    assert found.imported is not None
    assert len(found.imported.responses) == len(PEOPLE)
    assert any("May the files log.csv be left out?" in doubt for doubt in found.doubts)


def test_long_file_of_one_person_is_one_questionnaire(tmp_path: Path) -> None:
    texts = [item.text for item in shipped_instruments()["sus"].asked]
    rows = [[f"{n}. {text}", 1 + n % 5] for n, text in enumerate(texts, start=1)]
    found = suggested_for(tmp_path / "fourth.csv", [["", "Scale: 1 - 5"], *rows])
    assert found.imported is not None
    ((_, administration),) = found.imported.responses
    assert administration.participant == "fourth"


def test_times_of_ratings_in_minutes_and_numbered_columns(tmp_path: Path) -> None:
    RANDOM.seed(5)
    courses = {(p, c): [RANDOM.randint(0, 12) for _ in range(6)] for p in PEOPLE for c in "AB"}
    long = [[p, c, m, v] for (p, c), course in courses.items() for m, v in enumerate(course)]
    wide = [[p, c, *course] for (p, c), course in courses.items()]
    minutes = suggested_for(
        tmp_path / "x.csv", [["participant", "condition", "minute", "FMS"], *long]
    )
    numbered = suggested_for(
        tmp_path / "FMS_scores.csv",
        [["Participant", "Technique", *(f"t{n}" for n in range(6))], *wide],
    )
    for suggested, seconds in ((minutes, 60), (numbered, 60)):
        assert suggested.imported is not None, suggested.doubts
        found: dict[tuple[str, str], list[tuple[float, object]]] = {}
        for m, _, onset_s, response in suggested.imported.ratings:
            found.setdefault((m.participant, m.condition), []).append((onset_s, response))
        assert found == {
            key: [(seconds * n, answer) for n, answer in enumerate(course)]
            for key, course in courses.items()
        }


def test_what_was_measured_in_a_file_called_tlx_is_no_task_load(tmp_path: Path) -> None:
    rows = [[person, 20.5 + n, 5.5 + n, 30 + n] for n, person in enumerate(PEOPLE)]
    heading = ["Participant", "Task duration", "Distance", "Clicks"]
    found = suggested_for(tmp_path / "tlx_results.csv", [heading, *rows])
    assert found.imported is not None
    assert {name for name, _ in found.imported.responses} == {"own_measures"}


def test_a_row_of_data_below_a_heading_without_a_name_for_rows_is_no_heading(
    tmp_path: Path,
) -> None:
    rows: list[Row] = [["", "Participant", "Glasses", "Condition", "Comfort", *"XYZ"]]
    rows += [
        [str(2 * n + k - 1), f"P{n}", "No", c, 1 + (n + k) % 7, *["NA" if n == 1 else n / 7] * 3]
        for n in range(1, 7)
        for k, c in enumerate(("NA", "Yes"))
    ]
    found = suggest_mapping([table(tmp_path / "averages.csv", rows)])
    assert "heading_rows = [1]" in found.text


def test_a_sheet_under_ignore_sheets_is_left_out_though_a_table_names_it(tmp_path: Path) -> None:
    sheets = {
        name: [["ID", *LOADS], *([f"{name}{person}", *tlx()] for person in PEOPLE)]
        for name in ("First", "Second")
    }
    file = workbook(tmp_path / "tlx.xlsx", sheets)
    text = suggest_mapping([file]).text
    ignoring = text.replace("format_version = 1", 'format_version = 1\nignore_sheets = ["Second"]')
    every = import_files([file], parse_mapping(text, None))
    some = import_files([file], parse_mapping(ignoring, None))
    assert len(every.participants) == 2 * len(some.participants) == 2 * len(PEOPLE)
    assert all("First" in name for name in some.participants)
