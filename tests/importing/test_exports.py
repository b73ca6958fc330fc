"""Exports of survey programs: their own columns, codes, tests, leavers, and answers in JSON."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

from tests.support.layouts import ENGLISH, GERMAN, GERMAN_WORDS, ITEMS, WORDS, write
from vrcomfort.importing.suggest import suggest_mapping

Truth = dict[tuple[str, str, str], list[int]]
"""(participant, condition, timepoint) → answers."""
Made = tuple[list[Path], Truth]
LAYOUTS: dict[str, Callable[[Path, random.Random], Made]] = {}


def layout(make: Callable[[Path, random.Random], Made]) -> Callable[[Path, random.Random], Made]:
    LAYOUTS[make.__name__] = make
    return make


def answers(draw: random.Random, count: int = len(ITEMS), most: int = 3) -> list[int]:
    return [draw.randint(0, most) for _ in range(count)]


def found(files: Sequence[Path]) -> Mapping[tuple[str, str, str], list[int]]:
    suggested = suggest_mapping(files)
    assert suggested.imported is not None, suggested.doubts
    return {
        (m.participant, m.condition, m.timepoint): [
            -1 if answer is None else int(answer) for answer in response.answers.values()
        ]
        for (name, m), response in suggested.imported.responses.items()
        if not name.startswith("own")
    }


@pytest.mark.parametrize("name", LAYOUTS)
def test_answers_are_those_that_were_given(name: str, tmp_path: Path) -> None:
    files, truth = LAYOUTS[name](tmp_path, random.Random(7))  # noqa: S311
    assert found(files) == truth


@layout
def a_remark_in_brackets_behind_the_question_for_the_person(
    folder: Path, draw: random.Random
) -> Made:
    truth: Truth = {}
    head = ["Zeitstempel", "Probanden-Nr. (steht auf dem Zettel)", "Welche Fahrt?"]
    rows: list[Sequence[object]] = [[*head, *(f"Spüren Sie jetzt? [{text}]" for text in GERMAN)]]
    for person in range(1, 13):
        for ride in draw.sample(["Stadt", "Wald"], 2):
            truth[str(person), ride, "post"] = given = answers(draw)
            rows.append(
                [f"{person}.06.2024 10:00:00", person, ride, *(GERMAN_WORDS[g] for g in given)]
            )
    return [write(folder / "Antworten.csv", rows)], truth


@layout
def who_broke_off_is_in_no_group(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    heads = [f"SSQ{when}[SQ{n:03d}]" for when in ("vor", "nach") for n in range(1, 17)]
    rows: list[Sequence[object]] = [["id", "submitdate", *heads, "bed"]]
    for person in range(1, 15):
        group = "" if person == 5 else ("langsam", "schnell")[person % 2]
        truth[str(person), group, "baseline"] = before = answers(draw)
        after: Sequence[object] = [""] * 16
        if group:
            truth[str(person), group, "post"] = after = answers(draw)
        rows.append([person, "2024-11-01 10:00:00" if group else "", *before, *after, group])
    return [write(folder / "results-survey.csv", rows)], truth


@layout
def a_time_stamp_is_no_time_pressure_and_test123_nobody(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    scales = ["mental", "física", "temporal", "Rendimiento", "Esfuerzo", "Frustración"]
    heads = [f"Exigencia {scale}" if scale.islower() else scale for scale in scales]
    rows: list[Sequence[object]] = [
        ["Marca temporal", "Código de participante", "Interfaz", *heads]
    ]
    for person in ["test123", *(f"A{n:02d}" for n in range(1, 13))]:
        for interface in draw.sample(["Mando", "Manos"], 2):
            given = answers(draw, 6, 100)
            if person != "test123":
                truth[person, interface, "post"] = given
            rows.append([f"1/10/2024 11:15:{draw.randint(10, 59)}", person, interface, *given])
    return [write(folder / "respuestas.csv", rows)], truth


@layout
def a_statement_worded_otherwise_ends_the_questionnaire(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    texts = [*ENGLISH[:-1], "Pressure below the ribs"]
    heads = [f"Q{n:02d}. How strong is it? [{text}]" for n, text in enumerate(texts, start=1)]
    rows: list[Sequence[object]] = [["Participant", "Condition", *heads, "Comments"]]
    for person in (f"P{n}" for n in range(1, 13)):
        for condition in draw.sample(["Gaze", "Walk"], 2):
            truth[person, condition, "post"] = given = answers(draw)
            rows.append([person, condition, *(WORDS[g] for g in given), ""])
    return [write(folder / "export.csv", rows)], truth


@layout
def answers_of_a_page_in_one_cell(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    keys = [name.replace("difficulty_", "") for name in ITEMS]
    head = [
        "rt",
        "stimulus",
        "response",
        "trial_type",
        "trial_index",
        "subject",
        "condition",
        "phase",
    ]
    rows: list[Sequence[object]] = [head]
    for number in range(12):
        person, condition = f"k{number}x7", ("fov60", "fov100")[number % 2]
        rows.append([9, "<p>Hi</p>", 0, "html-button-response", 0, person, condition, ""])
        for index, (phase, when) in enumerate((("pre", "baseline"), ("post", "post"))):
            truth[person, condition, when] = given = answers(draw)
            page = json.dumps(dict(zip(keys, given, strict=True)))
            at = 2 * index + 1
            rows.append([900, "", page, "survey-likert", at, person, condition, phase])
            button = "html-button-response"
            rows.append([9, "<p>On</p>", 0, button, at + 1, person, condition, phase])
    return [write(folder / "data_all.csv", rows)], truth


@layout
def initials_of_which_one_could_be_of_two_items(folder: Path, draw: random.Random) -> Made:
    """SA is salivation, where ST is the stomach."""
    truth: Truth = {}
    initials = [
        "GD",
        "FA",
        "HA",
        "ES",
        "DF",
        "SA",
        "SW",
        "NA",
        "DC",
        "FH",
        "BV",
        "DEO",
        "DEC",
        "VE",
        "ST",
        "BU",
    ]
    blocks = ("Baseline", "after STATIC", "after FAN")
    rows: list[Sequence[object]] = [
        ["", *(text for block in blocks for text in (block, *[""] * 15))],
        ["No.", *initials * 3],
    ]
    for person in range(1, 11):
        given = [answers(draw) for _ in blocks]
        truth[str(person), "", "baseline"] = given[0]
        truth[str(person), "STATIC", "post"] = given[1]
        truth[str(person), "FAN", "post"] = given[2]
        rows.append([person, *(answer for block in given for answer in block)])
    return [write(folder / "fan.csv", rows)], truth


@layout
def lists_of_answers_and_of_the_items_in_json(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    people = []
    for uid in ["u-dev", *(f"u-{1000 + 17 * n}" for n in range(1, 11))]:
        sessions = []
        for index, device in enumerate(draw.sample(["Quest 2", "Pico 4"], 2)):
            both = [answers(draw), answers(draw)]
            if uid != "u-dev":
                truth[uid, device, "baseline"], truth[uid, device, "post"] = both
            ssq = dict(zip(("pre", "post"), both, strict=True))
            sessions.append({"index": index, "device": device, "ssq": ssq})
        people.append({"uid": uid, "sessions": sessions})
    scales = {"ssq": {"items": list(ENGLISH)}}
    file = folder / "export.json"
    file.write_text(json.dumps({"scales": scales, "participants": people}), "utf-8")
    return [file], truth


@layout
def titles_above_items_beside_people(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    people = [f"pp{n:02d}" for n in range(1, 11)]
    rows: list[list[object]] = [["Driving simulator", *[""] * 10], ["", *people]]
    scenes = [("still", "moving")[n % 2] for n in range(10)]
    rows.append(["image", *scenes])
    for title, when in (("BEFORE (0 = none)", "baseline"), ("AFTER", "post")):
        given = [answers(draw) for _ in people]
        for person, scene, each in zip(people, scenes, given, strict=True):
            truth[person, scene, when] = each
        rows.append([title, *[""] * 10])
        rows += [[text, *(each[n] for each in given)] for n, text in enumerate(ENGLISH)]
    return [write(folder / "data.csv", rows)], truth


def test_titles_beside_people_are_read_before_those_of_times(tmp_path: Path) -> None:
    people = [f"pp{n:02d}" for n in range(1, 9)]
    rows: list[list[object]] = [["", *people]]
    for title in ("BEFORE", "AFTER"):
        rows.append([title, *[""] * 8])
        rows += [[text, *range(3), *range(3), 0, 1] for text in ENGLISH]
    rows.append(["MISC during the drive (0-10)", *[""] * 8])
    rows += [[f"after {minute} min", *range(minute, minute + 8)] for minute in (1, 2, 3)]
    imported = suggest_mapping([write(tmp_path / "data.csv", rows)]).imported
    assert imported is not None
    given = {(r.administration.participant, r.onset_s): r.response for r in imported.ratings}
    assert len(given) == 24
    assert given["pp01", 60] == 1
    assert given["pp08", 180] == 10


@layout
def loops_of_which_a_column_gives_the_conditions_in_order(
    folder: Path, draw: random.Random
) -> Made:
    truth: Truth = {}
    heads = [
        (f"{loop}_Q14_{n}", text) for loop in (1, 2) for n, text in enumerate(ENGLISH, start=1)
    ]
    rows: list[Sequence[object]] = [
        ["StartDate", "pid", *(code for code, _ in heads), "order"],
        ["Start Date", "Your number", *(f"How do you feel? - {t}" for _, t in heads), "order"],
        [f'{{"ImportId":"QID{n}"}}' for n in range(len(heads) + 3)],
    ]
    for person in range(201, 213):
        order = ("teleport", "walk")[:: (-1) ** person]
        given = [answers(draw) for _ in order]
        for condition, each in zip(order, given, strict=True):
            truth[str(person), condition, "post"] = each
        texts = [WORDS[answer] for each in given for answer in each]
        rows.append(["2024-09-01", person, *texts, "-".join(order)])
    return [write(folder / "study.csv", rows)], truth


def test_numbers_are_items_of_the_questionnaire_beside_them(tmp_path: Path) -> None:
    draw = random.Random(3)  # noqa: S311
    rows: list[Sequence[object]] = [["User", "Condition", "Questionnaire", "QuestionID", "Answer"]]
    for person in range(1, 9):
        for condition in draw.sample(["Baseline", "Vignette", "Grid"], 3):
            rows += [[person, condition, "SSQ", n, draw.randint(0, 3)] for n in range(1, 17)]
            rows += [[person, condition, "NASA-TLX", n, draw.randint(0, 100)] for n in range(1, 7)]
    imported = suggest_mapping([write(tmp_path / "all.csv", rows)]).imported
    assert imported is not None
    given = {(name, m.condition, m.timepoint) for name, m in imported.responses}
    conditions = ("Baseline", "Vignette", "Grid")  # a task is judged after it was done
    assert given == {(name, c, "post") for name in ("ssq", "nasa_tlx") for c in conditions}


def test_an_instrument_that_a_file_names_and_has_no_answers_to_is_asked_about(
    tmp_path: Path,
) -> None:
    rows: list[Sequence[object]] = [["Participant", *ENGLISH, "felt so"]]
    rows += [[f"P{n}", *(WORDS[(n + i) % 4] for i in range(16)), "a bit"] for n in range(8)]
    asked = " ".join(suggest_mapping([write(tmp_path / "ssq_fms.csv", rows)]).doubts)
    assert "The files name the FMS, but no answers to it were found" in asked
    assert "name the SSQ" not in asked


@layout
def loops_whose_texts_name_the_conditions_and_a_baseline_before_them(
    folder: Path, draw: random.Random
) -> Made:
    return loops(folder, draw, {"Blur": "Blur", "NoBlur": "No_Blur"})


@layout
def loops_whose_conditions_are_numbers(folder: Path, draw: random.Random) -> Made:
    return loops(folder, draw, {"60 Hz": "60", "90 Hz": "90"})


def loops(folder: Path, draw: random.Random, names: Mapping[str, str]) -> Made:
    truth: Truth = {}
    ask = "How much is each symptom affecting you right now?"
    heads = [(f"Q5_{n}", f"{ask} - {text}") for n, text in enumerate(ENGLISH, start=1)]
    for loop, name in enumerate(names, start=1):
        texts = enumerate(ENGLISH, start=1)
        heads += [(f"{loop}_Q7_{n}", f"[{name}] {ask} - {text}") for n, text in texts]
    rows: list[Sequence[object]] = [
        ["ResponseId", "PID", *(code for code, _ in heads)],
        ["Response ID", "PID", *(text for _, text in heads)],
        [f'{{"ImportId":"QID{n}"}}' for n in range(2 + len(heads))],
    ]
    for n in range(1, 11):
        given = [answers(draw) for _ in range(3)]
        truth[f"P{n}", "", "baseline"] = given[0]
        for name, each in zip(names.values(), given[1:], strict=True):
            truth[f"P{n}", name, "post"] = each
        rows.append([f"R_{n}x", f"P{n}", *(WORDS[a] for each in given for a in each)])
    return [write(folder / "loops.csv", rows)], truth


@layout
def letters_behind_the_name_of_the_questionnaire_and_nought_before_them(
    folder: Path, draw: random.Random
) -> Made:
    truth: Truth = {}
    heads = [f"SSQ{block}[SQ{n:03d}]" for block in "0AB" for n in range(1, 17)]
    rows: list[Sequence[object]] = [["id", "submitdate", "PID", *heads]]
    for n in range(1, 11):
        given = [answers(draw) for _ in range(3)]
        truth[f"P{n}", "", "baseline"] = given[0]
        truth[f"P{n}", "a", "post"], truth[f"P{n}", "b", "post"] = given[1:]
        rows.append([n, "2024-11-01", f"P{n}", *(f"A{a + 1}" for each in given for a in each)])
    return [write(folder / "results-survey.csv", rows)], truth


@layout
def columns_of_items_and_of_answers_for_each_moment(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    files = []
    forms = [
        f"ssq_{when}.{what}" for when in ("pre", "post") for what in ("itemText", "response", "rt")
    ]
    for n in range(1, 9):
        rows: list[Sequence[object]] = [["condition", *forms, "participant", "frameRate"]]
        for condition in draw.sample(["tunnel", "open"], 2):
            for place, when in enumerate(("baseline", "post")):
                truth[str(n), condition, when] = given = answers(draw)
                for text, answer in zip(ENGLISH, given, strict=True):
                    cells = [text, WORDS[answer], 1.5, "", "", ""]
                    cells = cells[3:] + cells[:3] if place else cells
                    rows.append([condition, *cells, n, 60])
        files.append(write(folder / f"{n}_tunnel.csv", rows))
    return files, truth


@layout
def a_row_behind_the_last_answer_in_which_only_the_first_cell_is_filled(
    folder: Path, draw: random.Random
) -> Made:
    truth: Truth = {}
    before = ["Event Index", *(f"Local {n}" for n in range(12)), "Participant Private ID"]
    rows: list[Sequence[object]] = [[*before, "Trial Number", "cond", "Question Key", "Response"]]
    for person in range(31, 41):
        for condition in ("low", "high"):
            truth[str(person), condition, "post"] = given = answers(draw)
            for place, (text, answer) in enumerate(zip(ENGLISH, given, strict=True), start=1):
                trial = place + 16 * (condition == "high")
                cells = [trial, condition, text, WORDS[answer]]
                rows.append([place, *["x"] * 12, person, *cells])
                rows.append(
                    [place, *["x"] * 12, person, trial, condition, f"{text}-quantised", answer + 1]
                )
    rows.append(["END OF FILE"])
    return [write(folder / "data_questionnaire-zz9y.csv", rows)], truth


@layout
def times_of_answers_beside_them(folder: Path, draw: random.Random) -> Made:
    truth: Truth = {}
    files = []
    names = [f"slider_{name}.{what}" for name in ITEMS for what in ("response", "rt")]
    for n in range(1, 9):
        rows: list[Sequence[object]] = [["condition", *names, "participant", "date"]]
        for condition in draw.sample(["gauss", "bokeh"], 2):
            truth[str(n), condition, "post"] = given = answers(draw)
            cells = [cell for answer in given for cell in (answer, round(draw.random() * 9, 4))]
            rows.append([condition, *cells, n, "2024-03-01"])
        files.append(write(folder / f"{n}_blur.csv", rows))
    return files, truth


@layout
def events_that_are_conditions_beside_moments_in_headings(
    folder: Path, draw: random.Random
) -> Made:
    truth: Truth = {}
    asked = [f"{when} exposure: {text}" for when in ("Before", "After") for text in ENGLISH]
    rows: list[Sequence[object]] = [["Record ID", "Event Name", *asked]]
    for n in range(1, 11):
        for event in ("Fixed (Arm 1)", "Free (Arm 1)"):
            both = [answers(draw), answers(draw)]
            truth[f"P{n}", event, "baseline"], truth[f"P{n}", event, "post"] = both
            rows.append([f"P{n}", event, *(WORDS[a] for each in both for a in each)])
    return [write(folder / "DATA_LABELS.csv", rows)], truth


@layout
def the_round_before_all_others_under_a_question_for_rounds(
    folder: Path, draw: random.Random
) -> Made:
    truth: Truth = {}
    head = ["Zeitstempel", "Probandencode", "Welcher Durchgang war es?"]
    rows: list[Sequence[object]] = [
        [*head, *(f"Was spüren Sie gerade? [{text}]" for text in GERMAN)]
    ]
    for n in range(1, 11):
        rounds = ["Vorher (noch keine Brille)", *draw.sample(["Stadt", "Wald"], 2)]
        for place, name in enumerate(rounds):
            where = (name, "post") if place else ("", "baseline")
            truth[f"P{n}", *where] = given = answers(draw)
            rows.append(["01.03.2024 10:00:12", f"P{n}", name, *(GERMAN_WORDS[a] for a in given)])
    return [write(folder / "Antworten.csv", rows)], truth


def test_statements_without_a_wording_of_ours_are_known_by_their_words(tmp_path: Path) -> None:
    texts = [
        "I had a sense of being there, in a computer generated place",
        "It surrounded me: a virtual world",
    ]
    texts += ["I was just perceiving pictures", "I did not feel present there"]
    texts += [
        "Acting in it, rather than operating something",
        "I felt present in this virtual space",
    ]
    rows: list[Sequence[object]] = [["PID", "Cond", *(f"Q{n}" for n in range(len(texts)))]]
    rows += [["PID", "Cond", *texts], [f'{{"ImportId":"QID{n}"}}' for n in range(2 + len(texts))]]
    rows += [
        [f"P{n}", "ab"[k], *((n * m + k) % 7 for m in range(len(texts)))]
        for n in range(9)
        for k in (0, 1)
    ]
    imported = suggest_mapping([write(tmp_path / "presence.csv", rows)]).imported
    assert imported is not None
    given = next(
        r for (name, m), r in imported.responses.items() if name == "ipq" and m.participant == "P3"
    )
    assert given.answers["ipq_g1"] == 0
    assert given.answers["ipq_sp5"] == 1


def test_times_and_orders_that_survey_programs_write_are_no_measurements(tmp_path: Path) -> None:
    times = [
        "SSQTime",
        "groupTime31",
        "Q3_Page Submit",
        "TIME001",
        "FL_12_DO_Blur",
        "trial.started",
    ]
    rows: list[Sequence[object]] = [
        ["id", "cond", *(f"SSQ[SQ{n:03}]" for n in range(1, 17)), *times]
    ]
    draw = random.Random(5)  # noqa: S311
    for n in range(1, 11):
        for condition in ("low", "high"):
            rows.append([n, condition, *answers(draw), *(draw.randint(10, 99) for _ in times)])
    imported = suggest_mapping([write(tmp_path / "results.csv", rows)]).imported
    assert imported is not None
    assert {name for name, _ in imported.responses} == {"ssq"}
    assert all(not facts for facts in imported.participants.values())
