"""Rows of labels, folders that say something, records of one person, people spelt in two ways."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from pathlib import Path

import openpyxl
import pytest

from tests.support.layouts import ENGLISH, ITEMS, WORDS, write
from vrcomfort.importing.suggest import suggest_mapping

Answers = list[int]
Truth = dict[tuple[str, str, str], Answers]
"""(participant, condition, timepoint) → answers to the SSQ."""
Made = tuple[list[Path], Truth]
PEOPLE = [f"P{number:02d}" for number in range(1, 9)]
RANDOM = random.Random(7)  # noqa: S311 - data of tests
LAYOUTS: dict[str, Callable[[Path], Made]] = {}


def layout(make: Callable[[Path], Made]) -> Callable[[Path], Made]:
    LAYOUTS[make.__name__] = make
    return make


def answers() -> Answers:
    return [RANDOM.choice([0, 0, 1, 2, 3]) for _ in ITEMS]


def table(file: Path, rows: Sequence[Sequence[object]]) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    return write(file, rows)


def exported(folder: Path, *heads: Sequence[object]) -> Made:
    """Write rows of a survey program below these rows of headings: two techniques each."""
    truth: Truth = {}
    rows: list[Sequence[object]] = [*heads]
    for person in PEOPLE:
        for condition in ("Gaze", "Controller"):
            truth[person, condition, "post"] = given = answers()
            rows.append(["2024-03-02 10:00:00", person, condition, *(WORDS[g] for g in given)])
    return [table(folder / "export.csv", rows)], truth


@layout
def b_and_a_before_numbers(folder: Path) -> Made:
    """b1 … b16 before, a1 … a16 after; each person used one display."""
    truth: Truth = {}
    heads = [f"{letter}{number}" for letter in "ba" for number in range(1, 17)]
    rows: list[Sequence[object]] = [("user", "output", *heads)]
    for index, person in enumerate(PEOPLE):
        display = ("Rift", "Wall")[index % 2]
        both = [answers(), answers()]
        for moment, given in zip(("baseline", "post"), both, strict=True):
            truth[person, display, moment] = given
        rows.append((person, display, *both[0], *both[1]))
    return [table(folder / "ssq_data.csv", rows)], truth


@layout
def codes_as_typed_beside_mended_ones(folder: Path) -> Made:
    """P03 typed P02 once more, and P05 its number alone."""
    truth = {(person, "all", "post"): answers() for person in PEOPLE}
    typed = {person: person for person in PEOPLE} | {"P03": "P02", "P05": "5"}
    rows: list[Sequence[object]] = [("participant_id", "question", "answer", "pp")]
    for (person, *_), given in truth.items():
        said = zip(ENGLISH, given, strict=True)
        rows += [(typed[person], text, WORDS[g], person) for text, g in said]
    return [table(folder / "answers.csv", rows)], truth


CODES = ["StartDate", "Q1", "Q2", *(f"Q3_{number}" for number in range(1, 17))]
TEXTS = ["Start Date", "What is your participant ID?", "Which version did you just use?"]
TEXTS += [f"Rate your symptoms - {text}" for text in ENGLISH]
IDS = [f'{{"ImportId":"{code}"}}' for code in CODES]


@layout
def question_texts_below_codes(folder: Path) -> Made:
    return exported(folder, CODES, TEXTS)


@layout
def codes_below_question_texts(folder: Path) -> Made:
    return exported(folder, TEXTS, CODES)


@layout
def import_ids_above_question_texts(folder: Path) -> Made:
    return exported(folder, IDS, TEXTS)


@layout
def folders_of_people(folder: Path) -> Made:
    files, truth = [], Truth()
    for person in PEOPLE:
        for name, moment in (("pre", "baseline"), ("post", "post")):
            truth[person, "all", moment] = given = answers()
            files.append(table(folder / person / f"ssq_{name}.csv", [ENGLISH, given]))
    return files, truth


@layout
def folders_of_conditions(folder: Path) -> Made:
    files, truth = [], Truth()
    for condition in ("Teleport", "Joystick"):
        rows: list[Sequence[object]] = [["ID", *ENGLISH]]
        for person in PEOPLE:
            truth[person, condition, "post"] = given = answers()
            rows.append([person, *given])
        files.append(table(folder / condition / "ssq.csv", rows))
    return files, truth


@layout
def names_of_files_with_dates(folder: Path) -> Made:
    files, truth = [], Truth()
    for day, person in enumerate(PEOPLE, start=10):
        for hour, condition in enumerate(("joystick", "none"), start=10):
            truth[person, condition, "post"] = given = answers()
            name = f"{person}_{condition}_202411{day}-{hour}{day}.csv"
            files.append(table(folder / name, [ENGLISH, given]))
    return files, truth


@layout
def a_record_of_each_person(folder: Path) -> Made:
    files, truth = [], Truth()
    for age, person in enumerate(PEOPLE, start=20):
        truth[person, "all", "post"] = given = answers()
        record = [["Participant", person], ["Age", age], *zip(ENGLISH, given, strict=True)]
        files.append(table(folder / f"{person}.csv", record))
    return files, truth


@layout
def a_record_of_each_exposure(folder: Path) -> Made:
    files, truth = [], Truth()
    for person in PEOPLE:
        for condition in ("blur", "control"):
            truth[person, condition, "post"] = given = answers()
            said = [["ID", person], ["Condition", condition]]
            words = [WORDS[g] for g in given]
            record = [*said, *zip(ENGLISH, words, strict=True)]
            files.append(table(folder / f"{person}_{condition}.csv", record))
    return files, truth


@layout
def people_spelt_in_two_ways_in_two_files(folder: Path) -> Made:
    """The first file is asked once, before all conditions; one person is saved twice."""
    before, after = (
        [["Code", *(f"BEFORE: {text}" for text in ENGLISH)]],
        [["Code", "Way", *ENGLISH]],
    )
    truth = Truth()
    for number, person in enumerate(PEOPLE, start=1):
        truth[person, "", "baseline"] = given = answers()
        before.append([person.lower() if number % 3 else f"P{number}", *map(str, given)])
        for way in ("Teleport", "Walk"):
            truth[person, way, "post"] = given = answers()
            after.append([person, way, *map(str, given)])
    after.insert(5, after[4])
    return [table(folder / "pre.csv", before), table(folder / "post.csv", after)], truth


@layout
def people_with_and_without_letters(folder: Path) -> Made:
    truth = Truth()
    for code, moment in (("P0{}", "baseline"), ("{}", "post")):
        rows: list[Sequence[object]] = [["ID", *ENGLISH]]
        for number, person in enumerate(PEOPLE, start=1):
            truth[person, "all", moment] = given = answers()
            rows.append([code.format(number), *given])
        table(folder / f"ssq_{moment}.csv", rows)
    return sorted(folder.glob("*.csv")), truth


@layout
def two_moments_after_exposure(folder: Path) -> Made:
    truth = Truth()
    rows: list[Sequence[object]] = [["ID", "When", *ENGLISH]]
    moments = {"before": "baseline", "after": "post", "after 15 min": "recovery"}
    for person in PEOPLE:
        for text, moment in moments.items():
            truth[person, "all", moment] = given = answers()
            rows.append([person, text, *given])
    return [table(folder / "ssq.csv", rows)], truth


@layout
def files_on_their_side_of_which_one_has_rows_more(folder: Path) -> Made:
    files, truth = [], Truth()
    for person in PEOPLE:
        given = [answers(), answers()]
        truth |= {(person, c, "post"): each for c, each in zip("ab", given, strict=True)}
        rows: list[Sequence[object]] = [["Condition", "a", "b"], *zip(ENGLISH, *given, strict=True)]
        rows += [["None"] * 3] * 2 if person == "P04" else []
        files.append(table(folder / f"ID_{person}.csv", rows))
    return files, truth


@layout
def files_of_which_some_have_a_column_more(folder: Path) -> Made:
    """Without a word on the moment, but in names of files, which one scheme says."""
    files, truth = [], Truth()
    for name, moment, more in (("pre", "baseline", []), ("post", "post", ["Remarks"])):
        rows: list[Sequence[object]] = [["ID", *more, *ENGLISH]]
        for person in PEOPLE:
            truth[person, "all", moment] = given = answers()
            rows.append([person, *("it was hot today" for _ in more), *given])
        files.append(table(folder / f"{name}.csv", rows))
    return files, truth


@layout
def records_of_people_by_name(folder: Path) -> Made:
    """One person lacks a condition; the names of the records are codes of people."""
    records: dict[str, dict[str, dict[str, int]]] = {}
    truth = Truth()
    for number, person in enumerate(PEOPLE):
        for condition in ("blur", "sharp") if number != 3 else ("blur",):
            truth[person, condition, "post"] = given = answers()
            own = dict(zip(ITEMS, given, strict=True))
            records.setdefault(person, {})[condition] = own
    file = folder / "ssq.json"
    file.write_text(json.dumps(records))
    return [file], truth


@layout
def records_inside_records(folder: Path) -> Made:
    people, truth = [], Truth()
    for person in PEOPLE:
        sessions = []
        for condition in ("A", "B"):
            truth[person, condition, "post"] = given = answers()
            said = [{"item": t, "value": a} for t, a in zip(ENGLISH, given, strict=True)]
            asked = [{"name": "SSQ", "answers": said}]
            sessions.append({"condition": condition, "questionnaires": asked})
        people.append({"id": person, "sessions": sessions})
    file = folder / "study.json"
    file.write_text(json.dumps({"participants": people}))
    return [file], truth


@layout
def answers_among_the_events_of_a_log(folder: Path) -> Made:
    """Nothing says that ``arg1`` is an answer, and the time of the session is no session."""
    files, truth = [], Truth()
    for day, person in enumerate(PEOPLE, start=10):
        for number, condition in enumerate(("joystick", "none"), start=1):
            rows: list[Sequence[object]] = [["sessionTime", "event", "arg0", "arg1"]]
            rows.append([0.02, "AppStart", "", ""])
            for word, moment in (("PRE", "baseline"), ("POST", "post")):
                truth[person, condition, moment] = given = answers()
                rows.append([len(rows) * 1.37, "QuestionnaireOpen", "SSQ", word])
                for text, answer in zip(ENGLISH, given, strict=True):
                    rows.append([len(rows) * 1.37, f"Answer_SSQ_{word}", text, answer])
                rows.append([len(rows) * 1.37, "RideStart", condition, ""])
            name = f"{person}_session{number}_{condition}_202411{day}-1004.csv"
            files.append(table(folder / name, rows))
    return files, truth


@layout
def events_of_a_registry(folder: Path) -> Made:
    """The group stands in each person's first row; rows of ratings lie between those of items."""
    events = {"baseline_arm_1": "baseline", "post_exposure_arm_1": "post"}
    codes = [f"ssq_{number}" for number in range(1, 17)]
    head = ["record_id", "redcap_event_name", "redcap_repeat_instance", "age", "rand_group"]
    rows: list[Sequence[object]] = [[*head, *codes, "ssq_complete", "fms_score", "fms_complete"]]
    truth = Truth()
    for number, person in enumerate(PEOPLE):
        group = ("Sham", "Active")[number % 2]
        rows.append([person, "screening_arm_1", "", 20 + number, group, *[""] * 19])
        for event, moment in events.items():
            truth[person, group, moment] = given = answers()
            rows.append([person, event, "", "", "", *given, 2, "", ""])
        for minute in (1, 2, 3):
            rows.append([person, "exposure_arm_1", minute, *[""] * 19, minute + number, 2])
    return [table(folder / "study_DATA.csv", rows)], truth


@layout
def conditions_and_moments_in_two_rows_above_the_items(folder: Path) -> Made:
    blocks = [(c, m) for c in ("Chair fixed", "Chair moving") for m in MOMENTS]
    head = [["", "Sex"], ["", ""], ["Subject", ""]]
    for condition, moment in blocks:
        head[0] += [condition, *[""] * 15] if moment == "Before" else [""] * 16
        head[1] += [moment, *[""] * 15]
        head[2] += ENGLISH
    rows: list[Sequence[object]] = [*head]
    truth = Truth()
    for person in PEOPLE:
        row: list[object] = [person, "F"]
        for condition, moment in blocks:
            truth[person, condition.replace(" ", "_"), MOMENTS[moment]] = given = answers()
            row += given
        rows.append(row)
    return [table(folder / "chairs.csv", rows)], truth


MOMENTS = {"Before": "baseline", "Right after": "post", "20 min after": "recovery"}


@layout
def answers_before_any_condition_in_a_long_table(folder: Path) -> Made:
    truth = Truth()
    rows: list[Sequence[object]] = [["participant", "display", *ENGLISH]]
    for person in PEOPLE:
        for display in ("", "flat", "curved"):
            truth[person, display, "post" if display else "baseline"] = given = answers()
            rows.append([person, display, *given])
    return [table(folder / "ssq.csv", rows)], truth


@layout
def people_who_are_counted_anew_in_each_sheet(folder: Path) -> Made:
    book, truth = openpyxl.Workbook(), Truth()
    book.remove(book.worksheets[0])
    for place, condition in enumerate(("Control", "Blur")):
        sheet = book.create_sheet(condition)
        sheet.append(["No", "Age", *ENGLISH])
        for number in range(1, 9):
            truth[f"{condition}_{number}", condition, "post"] = given = answers()
            sheet.append([number, 20 + number * (place + 1), *given])
    book.save(folder / "between.xlsx")
    return [folder / "between.xlsx"], truth


@layout
def a_legend_below_the_people(folder: Path) -> Made:
    truth = Truth()
    rows: list[Sequence[object]] = [["No.", "Sex", *ENGLISH]]
    for number in range(1, 13):
        truth[str(number), "all", "post"] = given = answers()
        rows.append([number, "f", *given])
    legend = ["Sex: f = female", "0 = none  1 = slight", "2 = moderate", "3 = severe"]
    rows += [[""] * 18, *([line, *[""] * 17] for line in legend)]
    return [table(folder / "ssq.csv", rows)], truth


@layout
def sessions_of_a_registry_are_no_moments(folder: Path) -> Made:
    codes = [f"ssq_q{number}" for number in range(1, 17)]
    rows: list[Sequence[object]] = [["record_id", "redcap_event_name", "cond", *codes, "complete"]]
    truth = Truth()
    for person in PEOPLE:
        rows.append([person, "enrollment_arm_1", "", *[""] * 16, ""])
        for number, condition in enumerate(("vr", "screen"), start=1):
            truth[person, condition, "post"] = given = answers()
            rows.append([person, f"session_{number}_arm_1", condition, *given, 2])
    return [table(folder / "study_DATA.csv", rows)], truth


@layout
def codes_of_questions_before_their_texts(folder: Path) -> Made:
    """The number of the response is nobody's code; the last letter of SSQV and SSQN is a moment."""
    ask = "How much does each symptom affect you now?"
    head = ["id. Response ID", "CODE. Your code (letters of your mother's name, birthday)"]
    head += ['cond. {if(is_empty(cond),"",cond)}']
    for letter in "VN":
        head += [f"SSQ{letter}[SQ{n:03d}]. {ask} [{t}]" for n, t in enumerate(ENGLISH, start=1)]
    rows: list[Sequence[object]] = [head]
    truth = Truth()
    for number, person in enumerate(PEOPLE):
        condition = ("still", "moving")[number % 2]
        before, after = answers(), answers()
        truth[person, condition, "baseline"] = before
        truth[person, condition, "post"] = after
        rows.append([4 + number * 3 // 2, person, condition, *before, *after])
    return [table(folder / "results-survey.csv", rows)], truth


def found(files: Sequence[Path]) -> Mapping[tuple[str, str, str], Answers]:
    suggested = suggest_mapping(files)
    assert suggested.imported is not None, suggested.doubts
    people = {m.participant for _, m in suggested.imported.responses}
    assert {*suggested.imported.participants} == people
    return {
        (m.participant, m.condition, m.timepoint): [
            -1 if answer is None else int(answer) for answer in response.answers.values()
        ]
        for (instrument, m), response in suggested.imported.responses.items()
        if instrument == "ssq"
    }


@pytest.mark.parametrize("name", LAYOUTS)
def test_answers_are_those_that_were_given(name: str, tmp_path: Path) -> None:
    RANDOM.seed(7)
    files, truth = LAYOUTS[name](tmp_path)
    assert found(files) == truth


def test_blanks_behind_the_last_rating_are_no_missed_ratings(tmp_path: Path) -> None:
    minutes = [f"{c}_min{minute}" for c in ("Short", "Long") for minute in range(1, 11)]
    rows: list[Sequence[object]] = [["Participant", *minutes]]
    for number, person in enumerate(PEOPLE):
        long = [*range(number, number + 10)] if number != 3 else [3, "", 5, *[""] * 7]
        rows.append([person, *range(number, number + 5), *[""] * 5, *long])
    imported = suggest_mapping([table(tmp_path / "FMS ratings.csv", rows)]).imported
    assert imported is not None
    given: dict[tuple[str, str], list[float | None]] = {}
    for rating in imported.ratings:
        m = rating.administration
        given.setdefault((m.participant, m.condition), []).append(rating.response)
    assert len(given) == 2 * len(PEOPLE)
    assert given["P01", "Short"] == [0, 1, 2, 3, 4]
    assert given["P04", "Long"] == [3, None, 5]
    assert any("of ratings ends before the last column" in n for n in imported.notes)


def test_weights_and_products_of_a_task_load_index_stand_beside_its_ratings(
    tmp_path: Path,
) -> None:
    loads = ["Mental", "Physical", "Temporal", "Performance", "Effort", "Frustration"]
    again = [*loads[:-1], "Fustration"]
    rows: list[Sequence[object]] = [
        ["SID", "Ver", "Ratings", *loads, "Ranking", *again, "Total", "Adjusted", *again, "Sum"]
    ]
    for number, person in enumerate(PEOPLE):
        given = [(number * 35 + place * 20) % 101 for place in range(6)]
        weights = [(number + place) % 6 for place in range(6)]
        products = [a * w for a, w in zip(given, weights, strict=True)]
        version = f"v{number % 2}"
        rows.append([person, version, "", *given, "", *weights, 15, "", *products, sum(products)])
    suggested = suggest_mapping([table(tmp_path / "nasatlx.csv", rows)])
    assert suggested.imported is not None, suggested.doubts
    assert suggested.imported.conditions == ["v0", "v1"]
    assert "# Sum: a score made of the answers" in suggested.text
    for response, row in zip(suggested.imported.responses.values(), rows[1:], strict=True):
        assert [*response.answers.values()] == [*row[3:9], *row[10:16]]
    assert not any("What do the answers" in doubt for doubt in suggested.doubts)


@pytest.mark.parametrize(
    ("people", "runs", "time", "score"),
    [("participants", "runs", "t", "score"), ("data", "exposures", "time_s", "value"),
     ("subjects", "rides", "seconds", "rating")],
)  # fmt: skip
def test_names_of_lists_are_no_conditions_and_a_time_beside_a_score_no_rating(
    people: str, runs: str, time: str, score: str, tmp_path: Path
) -> None:
    records, truth = [], Truth()
    for number, person in enumerate(PEOPLE):
        truth[person, "", "baseline"] = before = answers()
        record = {"pid": person, "ssqBefore": dict(zip(ITEMS, before, strict=True)), runs: []}
        for place, condition in enumerate(("vignette", "none"), start=1):
            truth[person, condition, "post"] = given = answers()
            fms = [{time: 60 * minute, score: minute + number} for minute in range(4)]
            said = {"ssq": dict(zip(ITEMS, given, strict=True)), "fms": fms}
            record[runs].append({"run": place, "technique": condition, **said})
        records.append(record)
    file = tmp_path / "export.json"
    file.write_text(json.dumps({"study": "Rest", people: records}))
    assert found([file]) == truth
    imported = suggest_mapping([file]).imported
    assert imported is not None
    ratings = [(r.onset_s, r.response) for r in imported.ratings[:4]]
    assert ratings == [(60 * minute, minute) for minute in range(4)]
    assert len(imported.ratings) == 4 * 2 * len(PEOPLE)


STATEMENTS = [
    ["Frequently use", "Unnecessarily complex", "Easy to use", "Need technical support",
     "Functions integrated", "Too inconsistent", "Learn quickly", "Cumbersome",
     "Confident using", "Need to learn a lot"],
    ["use frequently", "unnecessary complexity", "ease of use", "technical support",
     "well integrated", "too much inconsistency", "quick to learn", "cumbersome to use",
     "felt confident", "learn a lot"],
    ["I would like to use it frequently", "The app is unnecessarily complex",
     "The app is easy to use", "I would need the support of a technical person",
     "Its functions are well integrated", "There is too much inconsistency",
     "Most people would learn it quickly", "Very cumbersome to use",
     "I felt very confident", "I needed to learn a lot of things"],
]  # fmt: skip


@pytest.mark.parametrize("statements", STATEMENTS)
def test_shortened_statements_name_items_and_a_note_across_a_sheet_is_nobody(
    statements: list[str], tmp_path: Path
) -> None:
    book = openpyxl.Workbook()
    sheet = book.worksheets[0]
    sheet.append(["Participant", *(f"Q{n}\n{text}" for n, text in enumerate(statements, start=1))])
    given = [[1 + (n * 3 + place * 2) % 5 for place in range(10)] for n in range(len(PEOPLE))]
    for person, row in zip(PEOPLE, given, strict=True):
        sheet.append([person, *row])
    sheet.append(["Scoring: odd items less one, even items from five, the sum times 2.5."])
    sheet.merge_cells(start_row=len(PEOPLE) + 2, end_row=len(PEOPLE) + 2, end_column=11,
                      start_column=1)  # fmt: skip
    book.save(tmp_path / "usability.xlsx")
    imported = suggest_mapping([tmp_path / "usability.xlsx"]).imported
    assert imported is not None
    assert {instrument for instrument, _ in imported.responses} == {"sus"}
    assert [[*r.answers.values()] for r in imported.responses.values()] == given


LOADS = ["Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort"]
LOADS += ["Frustration"]
CHOICES: list[tuple[Callable[[str, str], str], Callable[[str], str]]] = [
    (lambda one, other: f"{one} vs. {other}", str),
    (lambda one, other: f"Which matters more: {other} or {one}?", str.lower),
    (lambda one, other: f"{one[0]}{other[0]}", lambda item: "".join(w[0] for w in item.split())),
]


@pytest.mark.parametrize("choice", CHOICES)
def test_choices_between_items_are_no_answers_and_ranges_in_brackets_no_conditions(
    choice: tuple[Callable[[str, str], str], Callable[[str], str]], tmp_path: Path
) -> None:
    heading, said = choice
    pairs = list(combinations(LOADS, 2))
    scales = ["(0-100)", "[0 to 100]", "(0 = low, 100 = high)"]
    rows: list[Sequence[object]] = [
        [
            "ID",
            "Condition",
            *(f"{n}. {item} {scales[n // 3]}" for n, item in enumerate(LOADS)),
            *(f"{n}. {heading(*pair)}" for n, pair in enumerate(pairs, start=7)),
        ]
    ]
    for number, person in enumerate(PEOPLE):
        for condition in ("soft", "stiff"):
            given = [(number * 35 + place * 20) % 101 for place in range(6)]
            chosen = [said(pair[(number + n) % 2]) for n, pair in enumerate(pairs)]
            rows.append([person, condition, *given, *chosen])
    suggested = suggest_mapping([table(tmp_path / "nasatlx.csv", rows)])
    assert suggested.imported is not None, suggested.doubts
    assert suggested.imported.conditions == ["soft", "stiff"]
    for response, row in zip(suggested.imported.responses.values(), rows[1:], strict=True):
        assert [*response.answers.values()] == [*row[2:8]]
    assert not any("numbers" in doubt for doubt in suggested.doubts)


def test_items_the_other_way_round_are_no_second_questionnaire(tmp_path: Path) -> None:
    names = ["G1", *(f"SP{n}" for n in range(1, 6)), *(f"INV{n}" for n in range(1, 5))]
    names += [f"REAL{n}" for n in range(1, 5)]
    head = ["subj", *(f"ipq_{name}" for name in names), "ipq_SP2_r", "ipq_INV3_r", "ipq_REAL1_r"]
    rows: list[Sequence[object]] = [head]
    for number, person in enumerate(PEOPLE):
        given = [(number * 3 + place * 2) % 7 for place in range(14)]
        turned = [6 - given[names.index(name)] for name in ("SP2", "INV3", "REAL1")]
        rows.append([person, *given, *turned])
    suggested = suggest_mapping([table(tmp_path / "presence.csv", rows)])
    assert suggested.imported is not None, suggested.doubts
    given_answers = [[*r.answers.values()] for r in suggested.imported.responses.values()]
    assert given_answers == [row[1:15] for row in rows[1:]]
    assert "ipq_SP2_r: the same answers, recoded" in suggested.text


def test_rows_of_a_log_between_ratings_are_no_missed_ratings(tmp_path: Path) -> None:
    rows: list[Sequence[object]] = [["Time", "PlayerID", "Condition", "Event", "FMS", "PosX"]]
    for person in PEOPLE:
        for condition in ("Low", "High"):
            for minute in range(1, 6):
                rows.append([60 * minute - 1, person, condition, "sample", "", 0.3])
                rows.append([60 * minute, person, condition, "rating", minute, 0.2])
    imported = suggest_mapping([table(tmp_path / "unity.csv", rows)]).imported
    assert imported is not None
    assert [r.response for r in imported.ratings] == [1, 2, 3, 4, 5] * 2 * len(PEOPLE)
    assert any("80 rows have no answer" in note for note in imported.notes)


def test_files_of_tests_and_of_broken_starts_are_left_out_and_asked_about(tmp_path: Path) -> None:
    """S01 is the code of a person, and no first session."""
    RANDOM.seed(7)
    files, truth = [], Truth()
    for day, person in enumerate(PEOPLE, start=10):
        for hour, condition in enumerate(("joystick", "none"), start=10):
            code = person.replace("P", "S")
            truth[code, condition, "post"] = given = answers()
            rows = list(zip(ENGLISH, given, strict=True))
            name = f"{code}_{condition}_2024-11-{day}_{hour}h{day}.csv"
            files.append(table(tmp_path / name, [["Question", "Answer"], *rows]))
    rows = [["Question", "Answer"], *zip(ENGLISH[:5], [1] * 5, strict=True)]
    files.append(table(tmp_path / "S01_none_2024-11-10_09h10.csv", rows))
    files.append(table(tmp_path / "TEST_none_2024-11-01_09h10.csv", rows))
    assert found(files) == truth
    left_out = [doubt for doubt in suggest_mapping(files).doubts if "be left out" in doubt]
    assert len(left_out) == 2


def test_ratings_stand_among_the_events_of_a_log(tmp_path: Path) -> None:
    files = []
    for number, person in enumerate(PEOPLE):
        for condition in ("slow", "fast"):
            rows: list[Sequence[object]] = [
                ["time", "event", "arg0", "arg1"],
                [0.5, "start", "", ""],
            ]
            for minute in range(1, 7):
                rows.append([minute * 60.2, "FMS", minute, minute + number])
                rows.append([minute * 60.2 + 4, "collision", "wall", 30 + minute])
            files.append(table(tmp_path / f"{person}_{condition}.csv", rows))
    suggested = suggest_mapping(files)
    assert suggested.imported is not None, suggested.doubts
    given = [(r.onset_s, r.response) for r in suggested.imported.ratings[:6]]
    assert given == [(60 * minute, minute) for minute in range(1, 7)]
    assert len(suggested.imported.ratings) == 2 * 6 * len(PEOPLE)
    assert any("in minutes since the exposure began" in doubt for doubt in suggested.doubts)


def test_scores_of_answers_in_another_sheet_are_left_out_and_asked_about(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    raw, scores = book.worksheets[0], book.create_sheet("Scores")
    raw.append(["ID", "Condition", *ENGLISH])
    scores.append(["ID", "Condition", "Nausea", "Oculomotor", "Disorientation", "Total"])
    for number, person in enumerate(PEOPLE, start=1):
        for condition in ("A", "B"):
            raw.append([person, condition, *answers()])
            scores.append([person, condition, *(number * each for each in SCORE_UNITS)])
    book.save(tmp_path / "ssq.xlsx")
    suggested = suggest_mapping([tmp_path / "ssq.xlsx"])
    assert suggested.imported is not None, suggested.doubts
    assert {instrument for instrument, _ in suggested.imported.responses} == {"ssq"}
    assert any("sheets Scores be left out" in doubt for doubt in suggested.doubts)


SCORE_UNITS = (9.54, 7.58, 13.92, 3.74)


@pytest.mark.parametrize("end", ["\r", "\r\n", "\n"])
@pytest.mark.parametrize(("sign", "declared"), [(";", False), ("\t", False), (";", True)])
def test_separators_are_found_whatever_ends_the_lines(
    tmp_path: Path, end: str, sign: str, declared: bool
) -> None:
    lines = [f"sep={sign}"] if declared else []
    rows = [["ID", "Condition", *ENGLISH]]
    rows += [[person, each, *answers()] for person in PEOPLE for each in ("A", "B")]
    lines += [sign.join(map(str, row)) for row in rows]
    file = tmp_path / "ssq.csv"
    file.write_bytes((end.join(lines) + end).encode())
    suggested = suggest_mapping([file])
    assert suggested.imported is not None, suggested.doubts
    assert len(suggested.imported.responses) == 2 * len(PEOPLE)
