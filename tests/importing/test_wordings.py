"""Files whose answers are found by more than the exact names of their items."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from openpyxl import Workbook

from tests.support.layouts import ENGLISH, write
from vrcomfort.importing import import_files, load_mapping
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.importing.suggest.item_names import _abbreviated
from vrcomfort.importing.suggest.vocabulary import LabVocabulary
from vrcomfort.questionnaire.instrument_file import read_instrument
from vrcomfort.resources import data_folder

STATEMENTS = [
    "I think I would like to use this viewer frequently",
    "I found the viewer unnecessarily complex",
    "I thought our viewer was easy to use",
    "I would need support of a technical person to be able to use the viewer",
    "The various functions in the viewer were well integrated",
    "There was too much inconsistency in the viewer",
    "I imagine that most engineers would learn to use the viewer very quickly",
    "The viewer was very cumbersome to use",
    "I felt very confident with the viewer",
    "I needed to learn a lot of things before I got going with the viewer",
]
AGREED = ["Strongly disagree", "Disagree", "Neutral", "Agree", "Strongly agree"]
LOAD = [
    "How mentally demanding was the task?",
    "How physically demanding was the task?",
    "How hurried or rushed was the pace of the task?",
    "How successful were you in accomplishing what you were asked to do?",
    "How hard did you have to work to accomplish your level of performance?",
    "How insecure, discouraged, irritated, stressed, and annoyed were you?",
]


def imported_from(file: Path) -> Imported:
    suggestion = suggest_mapping([file])
    assert suggestion.imported is not None, suggestion.doubts
    return suggestion.imported


def answers_in(imported: Imported) -> list[list[float | None]]:
    return [[*response.answers.values()] for response in imported.responses.values()]


def test_statements_about_another_system_are_known_by_their_rare_words(tmp_path: Path) -> None:
    given = [[(row * k + k) % 5 for k in range(10)] for row in range(1, 7)]
    rows: list[list[object]] = [["Time", "Code", *(f"Usability [{s}]" for s in STATEMENTS)]]
    rows += [["1", f"P{n}", *(AGREED[a] for a in each)] for n, each in enumerate(given)]
    imported = imported_from(write(tmp_path / "form.csv", rows))
    assert {instrument for instrument, _ in imported.responses} == {"sus"}
    assert answers_in(imported) == [[answer + 1 for answer in each] for each in given]


def test_the_name_of_a_system_in_most_statements_makes_no_second_questionnaire(
    tmp_path: Path,
) -> None:
    given = [[(row * k + k) % 5 + 1 for k in range(10)] for row in range(1, 7)]
    statements = [
        "I think that I would like to use the CabinApp frequently",
        "I found the CabinApp unnecessarily complex",
        "I thought the CabinApp was easy to use",
        "I think that I would need support of a technical person to be able to use the CabinApp",
        "I found the various functions in the CabinApp were well integrated",
        "I thought there was too much inconsistency in the CabinApp",
        "I would imagine that most people would learn to use the CabinApp very quickly",
        "I found the CabinApp very awkward to use",
        "I felt very confident using the CabinApp",
        "I needed to learn a lot of things before I could get going with the CabinApp",
    ]
    rows: list[list[object]] = [["Time", *statements, "The CabinApp is easy to use"]]
    rows += [[f"10:0{n}", *each, n] for n, each in enumerate(given, start=1)]
    assert answers_in(imported_from(write(tmp_path / "form.csv", rows))) == given


def test_columns_whose_names_differ_in_a_sign_alone_are_both_kept(tmp_path: Path) -> None:
    items = [f"sus{n}" for n in range(1, 11)]
    rows: list[list[object]] = [["ID", "Condition", "View+", "View-", *items]]
    rows += [
        [f"P{n}", condition, n % 4, n % 5, *((n + k) % 5 + 1 for k in range(10))]
        for n in range(1, 9)
        for condition in ("vr", "desktop")
    ]
    imported = imported_from(write(tmp_path / "talks.csv", rows))
    assert {"view", "view_2"} <= {*imported.covariates}


def test_a_sheet_that_says_the_answers_again_is_left_out(tmp_path: Path) -> None:
    given = [[(row * k + k) % 5 for k in range(10)] for row in range(1, 7)]
    book = Workbook()
    book.active.title = "raw"
    book.active.append(["Code", *STATEMENTS])
    recoded = book.create_sheet("from 0")
    recoded.append(["Nr", *STATEMENTS])
    for number, each in enumerate(given):
        book.active.append([f"P{number}", *(AGREED[answer] for answer in each)])
        recoded.append([f"#{number}", *each, "", "a note beside the table" if number else ""])
    book.save(tmp_path / "study.xlsx")
    imported = imported_from(tmp_path / "study.xlsx")
    assert {place.participant for _, place in imported.responses} == {f"P{n}" for n in range(6)}
    assert 'ignore_sheets = ["from 0"]' in suggest_mapping([tmp_path / "study.xlsx"]).text


def test_numbers_with_words_are_marks_like_the_others(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", *LOAD]]
    rows += [[f"P{n}", 11 + n, "1 (Very Low)", 14, "1 (Perfect)", 12, n + 1] for n in range(6)]
    imported = imported_from(write(tmp_path / "tlx.csv", rows))
    assert answers_in(imported)[0] == [55, 5, 70, 5, 60, 5]


def test_numbers_count_from_where_the_words_beside_some_of_them_say(tmp_path: Path) -> None:
    texts = ["1 (none)", "2", "3", "4 (severe)"]
    rows: list[list[object]] = [["id", "condition", *ENGLISH]]
    rows += [[f"P{n}", "a", *(texts[(n + k) % 4] for k in range(16))] for n in range(6)]
    suggested = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    assert suggested.imported is not None
    assert answers_in(suggested.imported)[1] == [(1 + k) % 4 for k in range(16)]
    assert any("as the words beside some of them say" in doubt for doubt in suggested.doubts)


def test_an_unknown_word_in_the_place_of_an_item_is_that_item_and_is_asked(tmp_path: Path) -> None:
    headings = [*ENGLISH]
    headings[9] = "Zsibbadt fej"
    rows: list[list[object]] = [["id", "condition", *headings]]
    rows += [[f"P{n}", "a", *((n + k) % 4 for k in range(16))] for n in range(6)]
    file = write(tmp_path / "ssq.csv", rows)
    assert answers_in(imported_from(file))[0] == [k % 4 for k in range(16)]
    assert any(
        "'Zsibbadt fej' is fullness_of_head" in doubt for doubt in suggest_mapping([file]).doubts
    )


def test_score_alone_is_of_the_instrument_that_names_the_file(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Participant", "Tool", "Score"]]
    rows += [[f"P{n}", tool, 50 + 2.5 * (n + 3 * (tool == "B"))] for n in range(6) for tool in "AB"]
    imported = imported_from(write(tmp_path / "SUS.csv", rows))
    assert {place.condition for _, place in imported.responses} == {"A", "B"}
    assert imported.scores == ["sus_scores"]
    assert not suggest_mapping([write(tmp_path / "notes.csv", rows)]).text.count('"sus"')


def test_codes_that_are_alike_are_one_person_where_conditions_are_not_said_twice(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [["id", "scene", *ENGLISH]]
    rows += [[f"P0{n}", "flat", *((n + k) % 4 for k in range(16))] for n in range(1, 6)]
    rows += [[f"P{n}", "deep", *((n + k) % 4 for k in range(16))] for n in range(1, 6)]
    once = imported_from(write(tmp_path / "ssq.csv", rows))
    assert {place.participant for _, place in once.responses} == {f"P0{n}" for n in range(1, 6)}
    twice = imported_from(write(tmp_path / "again.csv", [*rows, ["P1", "flat", *[1] * 16]]))
    assert len({place.participant for _, place in twice.responses}) == 10


def test_ten_columns_of_answers_beside_their_score_need_no_headings(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        [f"2026-03-{n + 1:02d} 10:00", *(1 + (n * k + k) % 5 for k in range(10)), 52.5 + 2.5 * n]
        for n in range(8)
    ]
    imported = imported_from(write(tmp_path / "SUS.csv", rows))
    assert answers_in(imported)[2] == rows[2][1:11]


def test_the_name_of_a_scale_is_known_where_a_program_has_cut_it(tmp_path: Path) -> None:
    rows: list[list[object]] = [["code", "mis_cpre_a", "mis_cpost_a", "mis_cpre_b", "mis_cpost_b"]]
    rows += [[f"P{n}", 0, n % 4, 0, n % 7] for n in range(8)]
    imported = imported_from(write(tmp_path / "answers.csv", rows))
    said = {(place.condition, place.timepoint) for _, place in imported.responses}
    assert said == {(condition, time) for condition in "ab" for time in ("baseline", "post")}


def test_words_without_accents_are_the_words(tmp_path: Path) -> None:
    headings = ["demanda_mental", "demanda_fisica", "demanda_temporal", "desempenho"]
    headings += ["esforco", "frustracao"]
    rows: list[list[object]] = [["participante", "tarefa", *(f"tlx_{h}" for h in headings)]]
    rows += [[f"P{n}", t, *((n + t + k) % 21 for k in range(6))] for n in range(6) for t in (1, 2)]
    (instrument,) = {i for i, _ in imported_from(write(tmp_path / "r.csv", rows)).responses}
    assert instrument == "nasa_tlx"
    assert "misspellings" not in suggest_mapping([tmp_path / "r.csv"]).text


def test_two_factors_that_tell_rows_apart_together_are_the_condition(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Q1", "Q2", "Q3", *(f"Q4_{n}" for n in range(1, 7))]]
    rows += [
        [f"T0{n}", display, task, *((7 * n + 11 * k + len(display)) % 101 for k in range(6))]
        for n in range(1, 9)
        for display in ("HUD", "none")
        for task in ("fixed", "free")
        if n != 5 or task == "free"
    ]
    imported = imported_from(write(tmp_path / "NASA_TLX.csv", rows))
    said = {place.condition for _, place in imported.responses}
    assert said == {"HUD_fixed", "HUD_free", "none_fixed", "none_free"}
    assert {place.participant for _, place in imported.responses} == {f"T0{n}" for n in range(1, 9)}


def test_rows_of_reckonings_between_those_of_people_are_left_out(tmp_path: Path) -> None:
    rows: list[list[object]] = [["", *(f"Question {n}" for n in range(1, 11)), "SUS Score"]]
    for n in range(1, 9):
        rows.append([f"Participant {n}", *(1 + (n * k) % 5 for k in range(10)), ""])
        rows.append(["NEW VALUE", *((n * k) % 5 for k in range(10)), 50 + n])
    rows.append(["Average SUS score", *[""] * 10, 54.5])
    imported = imported_from(write(tmp_path / "SUS.csv", rows))
    assert {p.participant for _, p in imported.responses} == {
        f"Participant {n}" for n in range(1, 9)
    }
    assert {place.trial for _, place in imported.responses} == {""}


def test_answers_below_numbers_of_items_are_no_repeated_headings(tmp_path: Path) -> None:
    rows: list[list[object]] = [[*range(1, 11)]]
    rows += [[1, 2, 3, 2, 1, n % 5 + 1, 2, 5, 2, 3] for n in range(8)]
    assert len(imported_from(write(tmp_path / "sus.csv", rows)).responses) == 8


def test_tables_side_by_side_with_people_of_their_own_are_read_one_below_the_other(
    tmp_path: Path,
) -> None:
    headings = ["Participant ID", "Which Condition?", *LOAD]
    rows: list[list[object]] = [[*headings, "", *headings]]
    for n in range(1, 9):
        left, right = (
            [p, c, *((p + k) % 7 + 1 for k in range(6))] for p, c in ((n, "a"), (9 - n, "b"))
        )
        rows.append([*left, "", *right])
    file = write(tmp_path / "tlx.csv", rows)
    imported = imported_from(file)
    assert {(p.participant, p.condition) for _, p in imported.responses} == {
        (str(n), condition) for n in range(1, 9) for condition in "ab"
    }
    of_b = next(
        r for (_, p), r in imported.responses.items() if p[:1] == ("8",) and p.condition == "b"
    )
    assert next(iter(of_b.answers.values())) == round(100 / 6 * (8 % 7), 2)
    assert "stack = true" in suggest_mapping([file]).text


def test_a_code_with_a_mark_is_asked_about(tmp_path: Path) -> None:
    marked = ("5", "5(2)", "6", "6(2)", "7", "7(2)")
    rows = [[code, *((n + k) % 5 + 1 for k in range(10))] for n, code in enumerate(marked)]
    alone = [["Participant ID", *STATEMENTS], *rows]
    found = suggest_mapping([write(tmp_path / "SUS.csv", alone)])
    assert found.imported is not None
    assert {*found.imported.participants} == {*marked}
    assert any("'5(2)' participant '5'" in doubt for doubt in found.doubts)


def test_words_under_a_heading_for_a_method_are_the_condition_of_groups(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Code", "Retrieve-Method Methode", *STATEMENTS]]
    rows += [
        [f"P{n}", ("wand", "gaze")[n % 2], *((n + k) % 5 + 1 for k in range(10))] for n in range(9)
    ]
    imported = imported_from(write(tmp_path / "answers.csv", rows))
    assert {place.condition for _, place in imported.responses} == {"wand", "gaze"}


def test_of_several_sums_the_one_that_is_a_score_is_the_score(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", "display", "Usability_sum", "summary_result"]]
    rows += [[n, d, 21.875 + n, 62.5 + 2.5 * n] for n in range(1, 9) for d in ("flat", "deep")]
    text = suggest_mapping([write(tmp_path / "SUS.csv", rows)]).text
    assert 'usability = "summary_result"' in text
    assert 'kind = "score"' in text


def test_a_part_of_a_workbook_that_is_no_xml_is_none_of_ours(tmp_path: Path) -> None:
    book = Workbook()
    book.active.append(["Code", *(f"TLX {n} wand" for n in range(1, 7))])
    for n in range(8):
        book.active.append([f"P{n}", *((3 * n + k) % 21 for k in range(6))])
    book.save(tmp_path / "study.xlsx")
    with zipfile.ZipFile(tmp_path / "study.xlsx", "a") as archive:
        archive.writestr("xl/metadata", b"\x0a\x03 <\x12\x00")
    (instrument,) = {i for i, _ in imported_from(tmp_path / "study.xlsx").responses}
    assert instrument == "nasa_tlx"


def test_grades_behind_the_answers_and_yes_or_no_in_front_are_no_conditions(tmp_path: Path) -> None:
    numbers = [f"Q{n}" for n in range(1, 11)]
    graded: list[list[object]] = [["When", *numbers, "SUS Score", "Grade", "Meaning"]]
    for n in range(8):
        answers = [(n + k) % 5 + 1 for k in range(10)]
        total = 2.5 * sum(a - 1 if k % 2 == 0 else 5 - a for k, a in enumerate(answers))
        when = f"2025-12-2{n} 01:37:27"
        graded.append([when, *answers, total, "BD"[n % 2], ("Good", "Poor")[n % 2]])
    asked: list[list[object]] = [["When", "Q1. Is medicine your field?", *STATEMENTS]]
    asked += [
        [f"6/1{n}/2026 13:14", ("Yes", "No")[n % 2], *((n + k) % 5 + 1 for k in range(10))]
        for n in range(8)
    ]
    for name, rows in (("sus_results.csv", graded), ("answers.csv", asked)):
        places = [p for _, p in imported_from(write(tmp_path / name, rows)).responses]
        assert len(places) == 8
        assert {place.condition for place in places} == {"all"}


def test_a_file_called_after_a_questionnaire_has_it_in_a_run_of_columns(tmp_path: Path) -> None:
    questions = [f"Question.about.world.{letter}" for letter in "abcdefghijklmn"]
    rows: list[list[object]] = [["Participant.ID", "Which.Condition.", *questions, "SP", "INV"]]
    rows += [
        [n, c, *((n + k) % 7 + 1 for k in range(14)), 24 + n, 19 + n]
        for n in range(1, 9)
        for c in ("flat", "deep")
    ]
    file = write(tmp_path / "ipq.csv", rows)
    imported = imported_from(file)
    assert {instrument for instrument, _ in imported.responses} == {"ipq"}
    of_1 = next(r for (_, p), r in imported.responses.items() if p.participant == "1")
    assert of_1.answers["ipq_g1"] == 1  # 2 of 1 to 7
    asked = [str(doubt) for doubt in suggest_mapping([file]).doubts]
    assert any("in published order?" in doubt for doubt in asked)


def test_statements_and_agreement_in_polish_below_row_numbers_of_pandas(tmp_path: Path) -> None:
    words = [
        "zdecydowanie nie zgadzam się",
        "raczej się nie zgadzam",
        "nie mam zdania",
        "raczej się zgadzam",
        "zdecydowanie się zgadzam",
    ]
    long = "Obszary aktywowane przemieszczeniem spojrzenia"
    statements = [f"{n}. Zdanie o tym sposobie, {n * 'x'}" for n in range(1, 11)]
    rows: list[list[object]] = [["", "Kod badanego", "Testowany interfejs", *statements]]
    for n in range(12):
        answers = [words[(n + k) % 5] for k in range(10)]
        rows.append([n, f"sub-{n // 2:02}", (long, "dotyk")[n % 2], *answers])
    imported = imported_from(write(tmp_path / "sus.csv", rows))
    assert {(p.participant, p.condition) for _, p in imported.responses} == {
        (f"sub-{n:02}", c) for n in range(6) for c in (long, "dotyk")
    }
    first = next(iter(imported.responses.values()))
    assert [*first.answers.values()][:5] == [1, 2, 3, 4, 5]


def test_performance_whose_highest_number_is_success_is_asked_for_and_turned(
    tmp_path: Path,
) -> None:
    names = ["Mental", "Physical", "Temporal", "Performance", "Effort", "Frustration"]
    rows: list[list[object]] = [["Code", *(f"TLX {name}" for name in names)]]
    rows += [[f"P{n}", 10 * n, 20, 30, 90, 50, 60] for n in range(1, 7)]
    file = write(tmp_path / "load.csv", rows)
    suggestion = suggest_mapping([file])
    asked = " ".join(str(each) for each in suggestion.doubts)
    assert "Does the highest number of performance mean 'failure'?" in asked
    assert {answers[3] for answers in answers_in(imported_from(file))} == {90}
    mapping = tmp_path / "turned.toml"
    turned = "[tables.questionnaires.item_coding.performance]\nreverse_coded = true\n"
    agreed = suggestion.text.replace('answer = ""', 'answer = "yes"')
    mapping.write_text(f"{agreed}\n{turned}", encoding="utf-8")
    imported = import_files([file], load_mapping(mapping).mapping)
    assert {answers[3] for answers in answers_in(imported)} == {10}


@pytest.mark.parametrize(
    ("words", "instrument"),
    [
        (("None", "Rather not applicable", "Rather applicable", "Often or a lot"), "ssq"),
        (("nie", "selten", "manchmal", "sehr oft"), "ssq"),
        (("not at all", "a little", "moderately", "quite a bit", "extremely"), "ssq_five_point"),
        (("no", "rara vez", "a veces", "siempre"), "ssq"),
    ],
)
def test_words_that_are_as_many_as_the_answers_are_put_in_order_and_asked(
    words: tuple[str, ...], instrument: str, tmp_path: Path
) -> None:
    given = [[(n + k) % len(words) for k in range(16)] for n in range(6)]
    rows: list[list[object]] = [["id", "condition", *ENGLISH]]
    rows += [[f"P{n}", "a", *(words[answer] for answer in each)] for n, each in enumerate(given)]
    file = write(tmp_path / "ssq.csv", rows)
    imported = imported_from(file)
    assert answers_in(imported) == given
    assert {name for name, _ in imported.responses} == {instrument}
    assert any(" < ".join(words) in doubt for doubt in suggest_mapping([file]).doubts)


CHINESE = (
    "全身不适", "疲劳", "头痛", "眼睛疲劳", "难以聚焦", "唾液分泌增多", "出汗", "恶心",
    "注意力难以集中", "头部胀满感", "视线模糊",
    "头晕(睁眼)", "头晕(闭眼)", "眩晕", "胃部不适", "打嗝",
)  # fmt: skip
KOREAN_VRSQ = (
    "전반적인 불편함", "피로감", "눈의 피로", "초점을 맞추기 어려움", "두통", "머리가 무거운 느낌",
    "시야가 흐려짐", "눈을 감았을 때 어지러움", "현기증",
)  # fmt: skip
PORTUGUESE_CSQ = (
    "Você sente náusea (por exemplo, dor de estômago, refluxo ou vontade de vomitar)?",
    "Você sente tontura (por exemplo, cabeça leve ou sensação de giro)?",
    "Você se sente desorientado(a) (por exemplo, confusão espacial ou vertigem)?",
    "Você sente instabilidade postural (isto é, desequilíbrio)?",
    "Você sente fadiga induzida visualmente (por exemplo, cansaço ou sonolência)?",
    "Você sente desconforto induzido visualmente (por exemplo, vista cansada ou dor de cabeça)?",
)


@pytest.mark.parametrize(
    ("instrument", "items", "moments", "lowest"),
    [
        ("ssq", CHINESE, ("体验前", "体验后", "体验后30分钟"), 0),
        ("vrsq", KOREAN_VRSQ, ("체험 전", "체험 후", "30분 후"), 0),
        ("csq_vr", PORTUGUESE_CSQ, ("Antes", "Logo depois", "15 minutos depois"), 1),
    ],
)
def test_items_and_moments_are_known_in_other_languages(
    instrument: str, items: tuple[str, ...], moments: tuple[str, ...], lowest: int, tmp_path: Path
) -> None:
    rows: list[list[object]] = [["ID", "When", "Condition", *(f"Now? [{i}]" for i in items)]]
    for n in range(1, 8):
        for when, moment in enumerate(moments):
            answers = [lowest + (n + k + when) % 4 for k in range(len(items))]
            rows.append([f"{n}번" if n == 5 and when == 1 else n, moment, "a", *answers])
    imported = imported_from(write(tmp_path / "answers.csv", rows))
    assert {i for i, _ in imported.responses} == {instrument}
    assert {(p.participant, p.timepoint) for _, p in imported.responses} == {
        (str(n), when) for n in range(1, 8) for when in ("baseline", "post", "recovery")
    }
    assert [len(answers) for answers in answers_in(imported)] == [len(items)] * 21
    assert answers_in(imported)[0] == [lowest + (1 + k) % 4 for k in range(len(items))]


@pytest.mark.parametrize(("rise", "fact"), [(1, "timepoint"), (0, "condition")])
def test_numbers_of_two_blocks_are_moments_where_answers_rise(
    rise: int, fact: str, tmp_path: Path
) -> None:
    headings = [f"{block}. {item}" for block in (6, 7) for item in ENGLISH]
    rows: list[list[object]] = [["id", *headings]]
    for n in range(8):
        low = [int((n + k) % 4 == 0) for k in range(16)]
        rows.append([f"P{n}", *low, *(answer + rise for answer in low)])
    places = [p for _, p in imported_from(write(tmp_path / "ssq.csv", rows)).responses]
    assert len({getattr(place, fact) for place in places}) == 2


def test_all_but_one_of_sixteen_items_are_no_short_questionnaire(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", "condition", *ENGLISH[:6], "Zweten?", *ENGLISH[7:]]]
    rows += [[f"P{n}", "a", *((n + k) % 4 for k in range(16))] for n in range(6)]
    file = write(tmp_path / "answers.csv", rows)
    assert {instrument for instrument, _ in imported_from(file).responses} == {"ssq"}


@pytest.mark.parametrize(
    ("odd", "answer", "asked"),
    [("moderdo", 2, "misspelt"), ("33", None, "rare"), ("x", None, "rare"), ("stop", None, "rare")],
)
def test_an_odd_cell_among_many_answers_is_asked_about(
    odd: str, answer: int | None, asked: str, tmp_path: Path
) -> None:
    words = ["ninguno", "leve", "moderado", "severo"] if asked == "misspelt" else [*"0123"]
    rows: list[list[object]] = [["id", "condition", *ENGLISH]]
    rows += [[f"P{n}", "a", *(words[(n + k) % 4] for k in range(16))] for n in range(8)]
    rows[1][4] = odd
    if odd == "stop":  # one word may be met more often
        rows[2][9:16] = [odd] * 7
    file = write(tmp_path / "ssq.csv", rows)
    assert answers_in(imported_from(file))[0][:4] == [0, 1, answer, 3]
    assert any(repr(odd) in doubt and asked in doubt for doubt in suggest_mapping([file]).doubts)


def test_the_key_of_a_response_is_a_person_where_others_are_ages(tmp_path: Path) -> None:
    headings = [f"Q{question}_{n}" for question in (3, 9) for n in range(1, 17)]
    rows: list[list[object]] = [["ResponseId", "Cond", "Q1", *headings]]
    for n in range(8):
        low = [int((n + k) % 4 == 0) for k in range(16)]
        rows.append([f"R_{n}x", n % 2, 20 + n * 5 % 8, *low, *(answer + 1 for answer in low)])
    imported = imported_from(write(tmp_path / "SSQ_export.csv", rows))
    assert {(p.participant, p.condition, p.timepoint) for _, p in imported.responses} == {
        (f"R_{n}x", str(n % 2), when) for n in range(8) for when in ("baseline", "post")
    }


@pytest.mark.parametrize(
    ("heading", "moments", "known"),
    [
        ("t", ("t0", "t1"), ("baseline", "post")),
        ("MZP", (1, 2), ("baseline", "post")),
        ("When", ("Pre", "Post 0 min", "Post 20 min"), ("baseline", "post", "recovery")),
        (
            "When",
            ("before", "after", "after 10 min", "after 30 min"),
            ("baseline", "post", "recovery", "later_30"),
        ),
    ],
)
def test_moments_with_numbers_are_known_in_their_order(
    heading: str, moments: tuple[object, ...], known: tuple[str, ...], tmp_path: Path
) -> None:
    rows: list[list[object]] = [["id", "place", heading, *ENGLISH]]
    for n in range(8):
        for place in ("forest", "city"):
            for when, moment in enumerate(moments):
                rows.append([n, place, moment, *((n + k + when) % 4 for k in range(16))])
    imported = imported_from(write(tmp_path / "ssq.csv", rows))
    assert {(p.condition, p.timepoint) for _, p in imported.responses} == {
        (place, when) for place in ("forest", "city") for when in known
    }


def test_a_rating_without_the_name_of_the_questionnaire_is_none_of_its_items(
    tmp_path: Path,
) -> None:
    short = ["gendisc", "fatigue", "eyestrain", "diff_focus", "headache", "fullhead", "blur"]
    short += ["dizzy_closed", "vertigo"]
    rows: list[list[object]] = [["id", "cond", "discomfort_pre", *(f"vrsq_{s}" for s in short)]]
    rows += [[f"P{n}", "ab"[n % 2], 3, *((n + k) % 3 for k in range(9))] for n in range(8)]
    imported = imported_from(write(tmp_path / "answers.csv", rows))
    assert answers_in(imported)[1][:2] == [1, 2]
    assert {name for name, _ in imported.responses} == {"vrsq"}


@pytest.mark.parametrize(
    ("heading", "item"),
    [
        ("fat", None),
        ("fati", "fatigue"),
        ("gendisc", "general_discomfort"),
        ("diff foc", "difficulty_focusing"),
    ],
)
def test_four_letters_or_two_words_abbreviate_an_item(heading: str, item: str | None) -> None:
    vrsq = read_instrument(data_folder("instruments") / "vrsq.toml")
    found = _abbreviated(heading.split(), LabVocabulary([]), vrsq)
    assert found == (None if item is None else (0, len(heading.split()), item))


@pytest.mark.parametrize("unit", ["min", "minutos", "分"])
def test_minutes_of_ratings_are_known_in_any_language(tmp_path: Path, unit: str) -> None:
    rows = [[f"P{n}", m, (n + m) % 4] for n in range(8) for m in range(1, 6)]
    file = write(tmp_path / "fms.csv", [["ID", f"time ({unit})", "FMS"], *rows])
    imported = suggest_mapping([file]).imported
    assert imported is not None
    assert {rating.onset_s for rating in imported.ratings} == {60.0 * n for n in range(1, 6)}
