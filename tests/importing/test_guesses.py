"""Layouts that were once read wrong without a doubt, in small."""

from __future__ import annotations

from pathlib import Path

import openpyxl
import pytest

from tests.importing.test_layouts import answered, suggested_import
from tests.support.layouts import write
from vrcomfort.errors import InputError
from vrcomfort.importing import import_files, load_mapping
from vrcomfort.importing.suggest import suggest_mapping

LOAD = (
    "Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort", "Frustration",
)  # fmt: skip
SSQ_SHORT = ("General discomfort", "Fatigue", "Headache", "Eye strain", "Nausea", "Vertigo")


def test_a_mapping_from_which_no_answer_comes_in_is_refused(tmp_path: Path) -> None:
    rows = [["id", "age", "comment"], *([f"P{n}", 20 + n, "fine"] for n in range(1, 7))]
    file = write(tmp_path / "people.csv", rows)
    mapping = tmp_path / "map.toml"
    mapping.write_text(
        'format_version = 1\nname = "x"\n[[tables]]\nfiles = ["*.csv"]\n'
        'participant = { column = "id" }\nparticipants = { age = "age" }\nignore = ["comment"]\n'
    )
    with pytest.raises(InputError, match=r"no answer to a questionnaire.*tables\.questionnaires"):
        import_files([file], load_mapping(mapping).mapping)


def test_items_in_rows_with_sessions_in_front_are_no_people(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Subject", "Session 1", "Session 2", "Session 3", "Response"]]
    rows += [
        [who, *((3 * who + 2 * place + session) % 18 for session in range(3)), item]
        for who in (1, 2, 3, 7, 9)
        for place, item in enumerate(LOAD)
    ]
    imported, _ = suggested_import([write(tmp_path / "nasa_tlx.csv", rows)], tmp_path)
    assert [*imported.participants] == ["1", "2", "3", "7", "9"]
    assert len(imported.responses) == 5 * 3
    first = next(iter(imported.responses.values())).answers
    assert first["effort"] == 5 * ((3 + 8) % 18)


@pytest.mark.parametrize("heading", ["Subject", "x"])
def test_an_identifier_is_no_item_by_its_position(heading: str, tmp_path: Path) -> None:
    rows: list[list[object]] = [[heading, *"abcde", "note"]]
    rows += [[who, *((who * n) % 21 for n in range(1, 6)), "fine"] for who in range(1, 13)]
    found = suggest_mapping([write(tmp_path / "nasa_tlx.csv", rows)])
    assert f'mental_demand = "{heading}"' not in found.text


def test_ragged_ratings_without_headings_are_those_that_the_file_names(tmp_path: Path) -> None:
    rows = [[n, *((n + place) % 9 for place in range(8 + n % 4))] for n in range(12)]
    file = tmp_path / "FMS.csv"
    file.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    imported, text = suggested_import([file], tmp_path)
    given: dict[str, list[float]] = {}
    for each in imported.ratings:
        if each.response is not None:
            given.setdefault(each.administration.participant, []).append(each.response)
    assert given == {str(who): ratings for who, *ratings in rows}
    assert "though the file says no times" in text


def test_a_question_that_repeats_the_moment_leaves_the_condition_to_its_column(
    tmp_path: Path,
) -> None:
    moments = {"pre": "BEFORE THE SESSION", "post": "AFTER THE SESSION"}
    asked = [
        f"SSQ{code} {moment}: how strong is it right now? - {item}"
        for code, moment in moments.items()
        for item in SSQ_SHORT
    ]
    rows: list[list[object]] = [["PID", *asked, "condition"]]
    rows += [
        [100 + n, *((n + k) % 4 for k in range(len(asked))), ("calm", "fast")[n % 2]]
        for n in range(8)
    ]
    imported, _ = suggested_import([write(tmp_path / "survey.csv", rows)], tmp_path)
    told = {(a.participant, a.condition, a.timepoint) for _, a in imported.responses}
    assert told == {
        (str(100 + n), ("calm", "fast")[n % 2], when)
        for n in range(8)
        for when in ("baseline", "post")
    }


def test_a_column_called_condition_is_asked_about_where_headings_say_another(
    tmp_path: Path,
) -> None:
    headings = [f"{c} {item}" for c in ("Blur", "Plain") for item in SSQ_SHORT]
    rows: list[list[object]] = [["PID", *headings, "condition"]]
    rows += [
        [n, *((n + k) % 4 for k in range(len(headings))), ("calm", "fast")[n % 2]]
        for n in range(1, 9)
    ]
    doubts = suggest_mapping([write(tmp_path / "survey.csv", rows)]).doubts
    assert any(each.startswith("'condition' has 'fast', 'calm'") for each in doubts)


def test_scores_below_a_merged_condition_are_no_handedness(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    conditions = ("Controller", "Hand tracking")
    below = ("Mental", "Physical", "Temporal", "Performance", "Effort", "Frustration", "SUS", "Joy")
    sheet.append(["", *(c if not n else None for c in conditions for n in range(len(below)))])
    sheet.append(["ID", *below, *below])
    sheet.merge_cells("B1:I1")
    sheet.merge_cells("J1:Q1")
    for who in range(1, 9):
        answers = [(who * 15 + n * 35) % 105 for n in range(12)]
        scores = [42.5 + 2.5 * who, 90 - 2.5 * who]
        sheet.append(
            [f"P{who}", *answers[:6], scores[0], who % 5, *answers[6:], scores[1], who % 3]
        )
    book.save(tmp_path / "selection.xlsx")
    imported, text = suggested_import([tmp_path / "selection.xlsx"], tmp_path)
    assert "handedness" not in text
    scored = {
        (a.participant, a.condition): response.answers
        for (instrument, a), response in imported.responses.items()
        if instrument == "sus_scores"
    }
    assert [*scored["P3", "Hand_tracking"].values()] == [82.5]
    assert len(scored) == 16


def test_a_question_that_names_an_item_is_none_where_others_share_it(tmp_path: Path) -> None:
    question = "Bitte beurteilen Sie die Aufgabe (Leistung: 0 = gut, 20 = schlecht). "
    items = ("Geistige Anforderung", "Körperliche Anforderung", "Zeitliche Anforderung")
    items = (*items, "Leistung", "Anstrengung", "Frustration")
    rows: list[list[object]] = [["Nummer", "Bedingung", *(f"{question}[{i}]" for i in items)]]
    rows += [
        [f"{n:02d}", c, *((7 * n + k) % 21 for k in range(6))]
        for n in range(1, 9)
        for c in ("Filter", "ohne")
    ]
    imported, _ = suggested_import([write(tmp_path / "umfrage.csv", rows)], tmp_path)
    assert len(imported.responses) == 16
    (_, response), *_ = imported.responses.items()
    assert response.answers["performance"] == 50
    assert response.answers["effort"] == 55


def test_people_in_columns_beside_the_name_of_a_short_form(tmp_path: Path) -> None:
    people = [f"P{n}" for n in range(1, 7)]
    asked = [("A1", "How mentally demanding was it?", "tlx")]
    asked += [("A2", "How physically demanding was it?", "tlx")]
    asked += [("A3", "How hurried or rushed was the pace of the task?", "tlx")]
    asked += [("B1", "How strenuous was it?", "borg"), ("C1", "It was fun.", "likert")]
    rows: list[list[object]] = [["Condition", "QuestionId", "QuestionText", "Scale", *people]]
    rows += [
        [c, *question, *((n * k + place) % 13 for n in range(1, 7))]
        for k, c in enumerate(("Big", "Small"), start=1)
        for place, question in enumerate(asked)
    ]
    imported, text = suggested_import([write(tmp_path / "answers.csv", rows)], tmp_path)
    assert [*imported.participants] == people
    assert imported.conditions == ["Big", "Small"]
    assert {instrument for instrument, _ in imported.responses} == {"borg", "likert", "nasa_tlx"}
    assert len(imported.responses) == 3 * 2 * len(people)
    assert imported.not_asked == {"nasa_tlx": ("performance", "effort", "frustration")}
    assert "be left out?" not in text


def test_conditions_in_columns_beside_what_was_rated(tmp_path: Path) -> None:
    rated = ("Noticed Obstacles", "Know Size", "Cue Helped", "Not Obscuring")
    rows: list[list[object]] = [["Participant ID", "Metric", "Control", "World-Locked"]]
    rows += [
        [who, metric, 1 + (n + k) % 5, 1 + (2 * n + k) % 5]
        for n, who in enumerate(("9786", "8621", "9606", "2762"))
        for k, metric in enumerate(rated)
    ]
    imported, _ = suggested_import([write(tmp_path / "pilot.csv", rows)], tmp_path)
    assert imported.conditions == ["Control", "World_Locked"]
    (instrument, moment), *_ = imported.responses
    assert (moment.participant, moment.condition) == ("9786", "Control")
    answers = imported.responses[instrument, moment].answers
    assert [*answers.values()] == [1, 2, 3, 4]


@pytest.mark.parametrize(("code", "asked"), [("{}", True), ("P{}", False)])
def test_people_who_are_counted_anew_in_each_groups_sheet_are_asked_about(
    code: str, *, asked: bool, tmp_path: Path
) -> None:
    book = openpyxl.Workbook()
    for place, group in enumerate(("Experimental", "Control")):
        sheet = book.create_sheet(group, place)
        sheet.append(["ID", *SSQ_SHORT])
        for n in range(1, 7):
            sheet.append([code.format(n), *((n + k + place) % 4 for k in range(len(SSQ_SHORT)))])
    book.remove(book["Sheet"])
    book.save(tmp_path / "groups.xlsx")
    doubts = suggest_mapping([tmp_path / "groups.xlsx"]).doubts
    assert any("are they the same people?" in each for each in doubts) == asked


@pytest.mark.parametrize("first_of_b", [4, 3], ids=["apart", "one person in both"])
def test_files_that_list_other_people_each_say_the_condition(
    first_of_b: int, tmp_path: Path
) -> None:
    own = ["ID", "CTRL_Move", "CTRL_Walk", "PRE_Real"]
    a: list[list[object]] = [own, *([f"A{n}", n % 5, 2, 3] for n in range(1, 4))]
    b: list[list[object]] = [own, *([f"B{n}", n % 5, 1, 3] for n in range(4, 7))]
    b += [["A3", 1, 1, 1]] if first_of_b == 3 else []
    people = [f"{'AB'[n > 3]}{n}" for n in range(1, 7)]
    scores: list[list[object]] = [["ID", "Score_SUS"]]
    scores += [[who, 27.5 + 7.5 * n] for n, who in enumerate(people)]
    files = [write(tmp_path / "Walk.csv", a), write(tmp_path / "Stick.csv", b)]
    found = suggest_mapping([*files, write(tmp_path / "SUS.csv", scores)])
    assert found.imported is not None
    told = {a.participant: a.condition for _, a in found.imported.responses}
    apart = first_of_b == 4
    assert told == {
        who: (("Walk" if who[0] == "A" else "Stick") if apart else "all") for who in people
    }
    assert any("those of other tables" in doubt for doubt in found.doubts) == apart


def test_items_whose_names_end_in_a_number_stand_beside_another_questionnaire(
    tmp_path: Path,
) -> None:
    presence = [f"IPQ {n}" for n in ("G1", *(f"{scale}{n}" for scale, count in
                (("SP", 5), ("INV", 4), ("REAL", 4)) for n in range(1, count + 1)))]  # fmt: skip
    symptoms = ("General discomfort", "Fatigue", "Eyestrain", "Difficulty focusing", "Headache",
                "Fullness of head", "Blurred vision", "Dizzy (eyes closed)", "Vertigo")  # fmt: skip
    rows: list[list[object]] = [
        ["Participant", "Condition", *presence, *(f"VRSQ {each}" for each in symptoms)]
    ]
    rows += [
        [f"P{who:02}", condition, *((who + place + at) % 7 for place in range(14)),
         *((who * place + at) % 4 for place in range(9))]
        for who in range(1, 9)
        for at, condition in enumerate(("walking", "teleport"))
    ]  # fmt: skip
    imported, _ = suggested_import([write(tmp_path / "study.csv", rows)], tmp_path)
    answers: dict[str, dict[str, float]] = {}
    for (instrument, _), each in imported.responses.items():
        answers.setdefault(instrument, {}).update(each.answers)
    assert len(imported.responses) == 8 * 2 * 2
    assert {*answers} == {"ipq", "vrsq"}
    assert len(answers["ipq"]) == 14
    assert answers["ipq"]["ipq_real4"] == (8 + 13 + 1) % 7


def test_a_flag_is_no_condition_beside_words_that_are(tmp_path: Path) -> None:
    rows: list[list[object]] = [["person", "is_first_drive", "road", *SSQ_SHORT]]
    rows += [
        [f"P{who}", "Yes" if road == at == 0 else "No", ("city", "motorway")[road],
         *((who + road + at + place) % 4 for place in range(6))]
        for who in range(1, 9) for road in (0, 1) for at in (0, 1)
    ]  # fmt: skip
    found = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    assert 'condition = { column = "road" }' in found.text


@pytest.mark.parametrize(
    ("ends", "turned"),
    [("0=Low, 100=High", True), ("0 = very poor; 100 = very good", True),
     ("raw: 0=Misserfolg, 100=Erfolg", True), ("0=perfect, 100=failure", False)],
)  # fmt: skip
def test_the_heading_of_performance_says_which_end_is_good(
    ends: str, turned: bool, tmp_path: Path
) -> None:
    rows: list[list[object]] = [["ID", *(f"{i} ({ends})" for i in LOAD)]]
    rows += [[who, 10, 20, 30, 80, 50, 60 + n] for n, who in enumerate("ABCDEFGH")]
    imported = suggest_mapping([write(tmp_path / "tlx.csv", rows)]).imported
    assert imported is not None
    assert {r.answers["performance"] for r in imported.responses.values()} == {20 if turned else 80}


def test_a_refusal_answered_with_yes_says_the_fault_that_is_there_now(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", *SSQ_SHORT]]
    rows += [[f"P{n}", *((n + k) % 4 for k in range(5)), "odd"] for n in range(1, 9)]
    file = write(tmp_path / "ssq.csv", rows)
    text = answered(suggest_mapping([file]).text)
    mapping = tmp_path / "map.toml"
    mapping.write_text(text)
    with pytest.raises(InputError, match="'odd' is not an answer to vertigo"):
        import_files([file], load_mapping(mapping).mapping)
    mapping.write_text(text.replace('instrument = "ssq"', 'instrument = "ssq"\nmissing = ["odd"]'))
    imported = import_files([file], load_mapping(mapping).mapping)
    assert len(imported.responses) == 8


def test_reverse_coded_beside_words_is_refused(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", *LOAD], *([f"P{n}", *["low", "high"] * 3] for n in "1234")]
    file = write(tmp_path / "tlx.csv", rows)
    mapping = tmp_path / "map.toml"
    mapping.write_text(
        'format_version = 1\nname = "x"\n[[tables]]\nfiles = ["*.csv"]\n'
        'participant = { column = "ID" }\ncondition = { constant = "all" }\n'
        'timepoint = { constant = "post" }\n[[tables.questionnaires]]\n'
        'instrument = "nasa_tlx"\nanswers = { low = 0, high = 100 }\n'
        "item_coding.performance.reverse_coded = true\n[tables.questionnaires.items]\n"
        + "".join(f'{i.lower().replace(" ", "_")} = "{i}"\n' for i in LOAD)
    )
    with pytest.raises(InputError, match=r"'high' has its number from `answers`.*performance"):
        import_files([file], load_mapping(mapping).mapping)


def test_codes_beside_minutes_are_people_in_each_section(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.title = "MISC"
    for condition in ("Reading", "Looking outside"):
        sheet.append([f"Condition: {condition}"])
        sheet.append(["min", *(f"P{n}" for n in range(1, 9))])
        for minute in range(0, 12, 2):
            sheet.append([minute, *((minute + n) // 3 for n in range(8))])
        sheet.append([])
    book.save(tmp_path / "MISC.xlsx")
    imported, text = suggested_import([tmp_path / "MISC.xlsx"], tmp_path)
    assert {each.administration.participant for each in imported.ratings} == {
        f"P{n}" for n in range(1, 9)
    }
    assert {each.onset_s for each in imported.ratings} == {60.0 * m for m in range(0, 12, 2)}
    assert "heading_rows" not in text


def test_words_for_before_count_beside_a_score_called_as_an_item(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", *(f"Before VR [{i}]" for i in SSQ_SHORT), "Nausea"]]
    rows += [[f"P{n}", *((n + k) % 4 for k in range(6)), 9.54 * (n % 4)] for n in range(1, 9)]
    imported, _ = suggested_import([write(tmp_path / "ssq.csv", rows)], tmp_path)
    assert {key.timepoint for _, key in imported.responses} == {"baseline"}


def test_of_two_instruments_with_the_same_items_headings_may_name_one(tmp_path: Path) -> None:
    types = ("Cars", "Buses", "Trains", "Aircraft", "Small boats", "Ships", "Swings",
             "Roundabouts", "Funfair rides")  # fmt: skip
    rows: list[list[object]] = [
        ["ID", *(f"MS ({age}) [{i}]" for age in ("Child", "Adult") for i in types)]
    ]
    rows += [[f"P{n}", *((n + k) % 4 for k in range(18))] for n in range(1, 9)]
    imported, _ = suggested_import([write(tmp_path / "people.csv", rows)], tmp_path)
    found = {(name, key.condition) for name, key in imported.responses}
    assert found == {("mssq_child", "all"), ("mssq_adult", "all")}


def test_a_second_factor_that_is_not_used_is_asked_about(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "Place", "Technique", "Note", *SSQ_SHORT]]
    rows += [
        [f"P{who}", ("coaster", "tower")[at], ("none", "blur", "cave")[(who + at) % 3],
         "late" if who + at == 1 else "in time", *((who + at + k) % 4 for k in range(6))]
        for who in range(9) for at in (0, 1)
    ]  # fmt: skip
    found = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    asked = [each for each in found.doubts if "is it not the condition" in each]
    assert len(asked) == 1
    assert "'Place' has 'coaster', 'tower'" in asked[0]


def test_numbers_beside_words_for_moments_are_conditions(tmp_path: Path) -> None:
    moments = [(when, mark) for mark in ("", " (2)") for when in ("BEFORE", "AFTER")]
    rows: list[list[object]] = [["ID", *(f"{w} [{i}]{m}" for w, m in moments for i in SSQ_SHORT)]]
    rows += [
        [f"P{n}", *((n * (m + 1) + k) % 3 + m % 2 for m in range(4) for k in range(6))]
        for n in range(1, 9)
    ]
    imported, _ = suggested_import([write(tmp_path / "ssq.csv", rows)], tmp_path)
    keys = {(key.condition, key.timepoint) for _, key in imported.responses}
    assert len(keys) == 4
    assert {when for _, when in keys} == {"baseline", "post"}


def test_another_moment_in_headings_than_in_the_draft_is_asked_about(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", *(f"VR体験前 {item}" for item in SSQ_SHORT)]]
    rows += [[f"P{n}", *((n + k) % 4 for k in range(6))] for n in range(1, 9)]
    found = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    assert any("seems to say another moment than post" in each for each in found.doubts)


def test_decimals_tell_no_people_apart_and_numbers_under_s_do(tmp_path: Path) -> None:
    rows: list[list[object]] = [["s", "cond", *LOAD, "speed"]]
    rows += [
        [who, cond, *((who + at + 3 * k) % 21 for k in range(6)), 1.25 + who / 7 + at / 100]
        for who in range(1, 8)
        for at, cond in enumerate("AB")
    ]
    imported, _ = suggested_import([write(tmp_path / "nasa_tlx.csv", rows)], tmp_path)
    assert [*imported.participants] == [*"1234567"]
    rows = [
        ["speed", *row[1:-1]] if n == 0 else [row[-1], *row[1:-1]] for n, row in enumerate(rows)
    ]
    assert (
        "participant = { count = true }" in suggest_mapping([write(tmp_path / "x.csv", rows)]).text
    )


def test_truth_values_and_sentences_are_no_people(tmp_path: Path) -> None:
    rows: list[list[object]] = [["participant sees results", "about the participant", *LOAD]]
    rows += [
        [("true", "false")[n % 2], f"has had a headset for {n} years or so", *range(n, n + 6)]
        for n in range(8)
    ]
    found = suggest_mapping([write(tmp_path / "nasa_tlx.csv", rows)])
    assert "participant = { count = true }" in found.text


def test_which_of_two_items_weighs_more_is_no_condition(tmp_path: Path) -> None:
    rows: list[list[object]] = [["ID", "Which counts more?", *LOAD]]
    rows += [[f"P{n}", ("Effort", "Frustration")[n % 2], *range(n, n + 6)] for n in range(12)]
    found = suggest_mapping([write(tmp_path / "nasa_tlx.csv", rows)])
    assert 'condition = { constant = "all" }' in found.text


def test_rows_in_quotes_as_a_whole_have_people_sessions_and_spellings(tmp_path: Path) -> None:
    """A remark in brackets names no person, and a condition in capitals is the same one."""
    head = ["Time", "Session ID (of this participant)", "Participant ID (below)", "I felt calm"]
    rows = [
        ["10:00", name.upper() if n % 3 else name, f"vr-{n:02}", str(1 + (n + k) % 5)]
        for n in range(1, 13)
        for k, name in enumerate(("alice", "voyager"))
    ]
    lines = [",".join(f'""{cell}""' for cell in row) for row in (head, *rows)]
    file = tmp_path / "during.csv"
    file.write_text("".join(f'"{line}"\r\n' for line in lines), encoding="utf-8")
    found = suggest_mapping([file]).imported
    assert found is not None
    assert found.conditions == ["ALICE", "VOYAGER"]
    assert {key.participant for _, key in found.responses} == {f"vr-{n:02}" for n in range(1, 13)}


def test_a_misspelt_heading_below_a_title_is_no_title(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.worksheets[0]
    for title, person in (("Glasses", "Participant"), ("Screen", "Partcipant")):
        sheet.append([title])
        sheet.append([person, *(f"question {k}" for k in range(1, 4))])
        for n in range(1, 7):
            sheet.append([n, *(1 + (n * k + len(title)) % 5 for k in range(2, 5))])
        sheet.append([])
    book.save(tmp_path / "study.xlsx")
    text = suggest_mapping([tmp_path / "study.xlsx"]).text
    assert "Sheet: Glasses" in text
    assert 'participant = { column = "Partcipant" }' in text


def test_a_total_that_the_answers_do_not_give_in_every_row_is_kept_and_asked_about(
    tmp_path: Path,
) -> None:
    items = ["Mental Demand", "Physical Demand", "Temporal Demand", "Performance", "Effort"]
    answers = [[1 + (7 * n + 5 * k) % 20 for k in range(6)] for n in range(8)]
    totals = [round(sum(each) / 6 * 5, 2) for each in answers]

    def drafted(name: str, totals: list[float]) -> tuple[list[str], str]:
        rows = [["ID", *items, "Frustration", "TLX SCORE"]]
        rows += [[f"P{n}", *each, totals[n]] for n, each in enumerate(answers)]
        found = suggest_mapping([write(tmp_path / name, rows)])
        assert found.imported is not None
        return sorted({instrument for instrument, _ in found.imported.responses}), found.text

    whole, text = drafted("tlx.csv", totals)
    assert whole == ["nasa_tlx"]
    assert "# TLX SCORE: a score made of the answers" in text
    kept, text = drafted("tlx_2.csv", [*totals[:6], 5.0, totals[7]])
    assert kept == ["nasa_tlx", "nasa_tlx_scores"]
    assert "'TLX SCORE' is not in all rows the score of the answers beside it" in text


def test_a_few_names_of_scales_are_no_published_scores_of_a_questionnaire_with_more(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [["ID", "Level", "Ownership", "Frustration", "Performance"]]
    rows += [
        [f"P{n}", level, 1 + (n + k) % 7, 1 + (3 * n + k) % 7, (5 * n + k) % 27]
        for n in range(8)
        for k, level in enumerate(("Body", "Blocks"))
    ]
    imported, _ = suggested_import([write(tmp_path / "questionnaire.csv", rows)], tmp_path)
    assert not any("nasa_tlx" in instrument for instrument, _ in imported.responses)
    found = [value for each in imported.responses.values() for value in each.answers.values()]
    assert sorted(found) == sorted(value for row in rows[1:] for value in row[2:])


def test_numbers_of_two_series_in_a_table_are_the_same_moments_though_one_column_is_constant(
    tmp_path: Path,
) -> None:
    names = "SSQ{} Total Severity Score", "Said they were sick on SSQ{}? (0=No, 1=Yes)"
    head = ["Subject #", *(name.format(k) for k in (1, 2, 3) for name in names)]
    rows: list[list[object]] = [[*head]]
    for n in range(9):
        scores = (3.74 * (n % 2), 3.74 * (5 + n), 3.74 * (1 + n))
        sick = (0, n % 2, int(n % 4 == 1))
        rows.append([f"{n}F", *(cell for pair in zip(scores, sick, strict=True) for cell in pair)])
    imported, text = suggested_import([write(tmp_path / "totals.csv", rows)], tmp_path)
    for own in (True, False):
        found = [m for name, m in imported.responses if name.startswith("own") == own]
        assert {m.timepoint for m in found} == {"baseline", "post", "recovery"}, text
        assert {m.condition for m in found} == {"all"}
