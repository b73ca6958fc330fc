"""Files beside which others say what their columns and numbers mean; and rows of trial runs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from openpyxl import Workbook

from tests.importing.test_wordings import answers_in, imported_from
from tests.support.layouts import ENGLISH, write
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.questionnaire import shipped_instruments

ALPHABETICAL = sorted(range(16), key=ENGLISH.__getitem__)
NAMES = [item.name for item in shipped_instruments()["ssq"].items]
WORDS = ["none", "slight", "moderate", "severe"]


def given(person: int, when: int) -> list[int]:
    return [(person + k * when) % 3 for k in range(16)]


def export(file: Path) -> Path:
    columns = [f"SQ{when:02}_{n:02}" for when in (1, 2) for n in range(1, 17)]
    rows: list[list[object]] = [["CASE", "REF", "MODE", "SD02", *columns, "FM01"]]
    rows.append([210, "", "admin", 99, *[1] * 32, 1])
    for person in range(1, 9):
        answers = [given(person, when)[n] + 1 for when in (1, 2) for n in ALPHABETICAL]
        ref = ("cinema", "flight")[person % 2]
        rows.append([210 + person, ref, "interview", 20 + person, *answers, person + 1])
    return write(file, rows)


def codebook(file: Path) -> Path:
    rows: list[list[object]] = [["VAR", "LABEL", "TYPE"], ["SD02", "Age", "TEXT"]]
    for when, moment in enumerate(("before", "after"), start=1):
        for place, item in enumerate(ALPHABETICAL, start=1):
            label = f"Symptoms {moment} VR: {ENGLISH[item]}"
            rows.append([f"SQ{when:02}_{place:02}", label, "ORDINAL"])
    rows.append(["FM01", "Worst nausea in VR (FMS)", "ORDINAL"])
    return write(file, rows)


def values(file: Path) -> Path:
    rows: list[list[object]] = [["VAR", "RESPONSE", "MEANING"]]
    rows += [[f"SQ{w:02}_{n:02}", a + 1, WORDS[a]] for w in (1, 2) for n in (1, 2) for a in (0, 3)]
    rows += [["FM01", 1, "0 (none)"], *(["FM01", n + 1, n] for n in range(1, 21))]
    return write(file, rows)


def test_codebooks_say_items_moments_and_from_where_answers_count(tmp_path: Path) -> None:
    files = [
        export(tmp_path / "data.csv"),
        codebook(tmp_path / "variables.csv"),
        values(tmp_path / "values.csv"),
    ]
    imported = suggest_mapping(files).imported
    assert imported is not None
    said = {
        (instrument, place.participant, place.condition, place.timepoint): dict(each.answers)
        for (instrument, place), each in imported.responses.items()
    }
    expected: dict[tuple[str, ...], dict[str, int]] = {}
    for person in range(1, 9):
        who, where = str(210 + person), ("cinema", "flight")[person % 2]
        expected["ssq", who, where, "baseline"] = dict(zip(NAMES, given(person, 1), strict=True))
        expected["ssq", who, where, "post"] = dict(zip(NAMES, given(person, 2), strict=True))
        expected["fms", who, where, "post"] = {"fms": person}
    assert said == expected
    assert imported.participants["211"]["age"] == "21"


@pytest.mark.parametrize(
    ("told", "first"),
    [("1 = none; 2 = slight; 3 = moderate; 4 = severe", 1), ("0, none | 1, slight | 3, severe", 0)],
)
def test_a_legend_in_one_row_for_several_columns_says_what_numbers_mean(
    told: str, first: int, tmp_path: Path
) -> None:
    columns = [f"ssq{n:02}" for n in range(1, 17)]
    rows: list[list[object]] = [["id", "group", *columns]]
    rows += [[n, n % 2 + 1, *(first + a for a in given(n, 1))] for n in range(1, 9)]
    rows[1][2] = first + 1  # no answer is the lowest in some columns
    book: list[list[object]] = [["Variable", "Values"], ["group", "1 = blur; 2 = plain"]]
    book += [["ssq01 to ssq16", told], ["id", ""]]
    files = [write(tmp_path / "data.csv", rows), write(tmp_path / "codes.csv", book)]
    imported = suggest_mapping(files).imported
    assert imported is not None
    assert {place.condition for _, place in imported.responses} == {"blur", "plain"}
    assert answers_in(imported)[1] == given(2, 1)


def test_answers_of_which_only_the_later_say_when_are_before_and_after(tmp_path: Path) -> None:
    later = [f"Now, AFTER the virtual tour, how strong is it? - {item}" for item in ENGLISH]
    asked = [f"How strong is it? - {item}" for item in ENGLISH]
    rows: list[list[object]] = [["id", *asked, *later, "headset"]]
    rows += [[n, *given(n, 1), *given(n, 2), "ab"[n % 2]] for n in range(1, 9)]
    file = write(tmp_path / "tour.csv", rows)
    assert {(p.condition, p.timepoint) for _, p in imported_from(file).responses} == {
        (headset, when) for headset in "ab" for when in ("baseline", "post")
    }
    assert any("before exposure?" in doubt for doubt in suggest_mapping([file]).doubts)


def test_answers_in_own_words_are_nobody_s_covariate_and_test_is_nobody(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", "condition", "What is your gender?", *ENGLISH, "Comments?"]]
    for n in range(1, 7):
        rows += [[f"P{n}", c, "fm"[n % 2], *given(n, 1), "too hot" if n < 3 else ""] for c in "ab"]
    rows.append(["Test", "a", "f", *[3] * 16, "does it work"])
    imported = imported_from(write(tmp_path / "form.csv", rows))
    assert imported.participants == {f"P{n}": {"gender": "fm"[n % 2]} for n in range(1, 7)}


def test_a_sheet_of_weights_is_no_condition_and_codes_of_two_sheets_are_one_person(
    tmp_path: Path,
) -> None:
    names = ["Mental", "Physical", "Temporal", "Performance", "Effort", "Frustration"]
    book = Workbook()
    book.active.title = "ratings"
    book.active.append(["Code", "Interface", *names])
    weights, people = book.create_sheet("weights"), book.create_sheet("people")
    weights.append(["Code", *names])
    people.append(["Code", "Age"])
    for n in range(1, 9):
        for place, condition in enumerate(("screen", "headset")):
            code = "p8" if n == 8 else f"P{n}"
            book.active.append([code, condition, *(5 * (n + k + place) for k in range(6))])
        weights.append([f"P{n}", *(([5, 4, 3, 2, 1, 0] * 2)[n % 6 : n % 6 + 6])])
        people.append([f"P{n}", 20 + n])
    book.save(tmp_path / "TLX_study.xlsx")
    imported = imported_from(tmp_path / "TLX_study.xlsx")
    assert {place.condition for _, place in imported.responses} == {"screen", "headset"}
    assert imported.participants == {f"P{n}": {"age": str(20 + n)} for n in range(1, 9)}


def test_an_export_with_a_row_for_each_question_of_two_tasks(tmp_path: Path) -> None:
    head = ["Participant Private ID", "Task Name", "randomiser-h5gk", "Question Key", "Response"]
    files = []
    for task, moment in enumerate(("SSQ before", "SSQ after"), start=1):
        rows: list[list[object]] = [head]
        for person in range(8):
            who = [9714050 + 37 * person, moment, ("Straight", "Curved")[person % 2]]
            rows.append([*who, "BEGIN QUESTIONNAIRE", ""])
            for n, answer in enumerate(given(person, task), start=1):
                rows.append([*who, f"ssq-{n}", WORDS[answer].title()])
                rows.append([*who, f"ssq-{n}-quantised", answer + 1])
        rows.append(["END OF FILE", *[""] * 4])
        files.append(
            write(tmp_path / f"data_questionnaire-{'8xkp' if task < 2 else 'q2lm'}.csv", rows)
        )
    asked = [head, *([9714050 + 37 * n, "Demographics", "", "age", 20 + n] for n in range(8))]
    files.append(write(tmp_path / "data_questionnaire-1t7c.csv", asked))
    imported = suggest_mapping(files).imported
    assert imported is not None
    assert {(p.condition, p.timepoint) for _, p in imported.responses} == {
        (c, t) for c in ("Straight", "Curved") for t in ("baseline", "post")
    }
    assert sorted(answers_in(imported)) == sorted(
        given(person, task) for person in range(8) for task in (1, 2)
    )


def test_two_flags_are_the_condition(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        [
            "pid",
            "trial",
            "vignette",
            "snap",
            "start_misc",
            *(f"misc_{n}" for n in (2, 4, 6)),
            "end_misc",
        ]
    ]
    for n in range(1, 9):
        for trial in range(4):
            flags = divmod((n + trial) % 4, 2)
            rows.append([f"{n:03}", trial + 1, *flags, 0, trial, n, 5, trial])
    imported = imported_from(write(tmp_path / "trials.csv", rows))
    assert {p.participant for _, p in imported.responses} == {f"{n:03}" for n in range(1, 9)}
    single = {(p.condition, p.timepoint) for name, p in imported.responses if name == "misc"}
    assert single == {
        (f"{a}_{b}", when) for a in "01" for b in "01" for when in ("baseline", "post")
    }
    assert {rating.onset_s for rating in imported.ratings} == {120, 240, 360}


def test_questions_of_the_task_load_index_in_german_without_umlauts(tmp_path: Path) -> None:
    asked = {
        "mental_demand": "range_wie_anspruchsvoll_war_die_durchfuehrung_der_aufgabe_fuer_sie",
        "temporal_demand": "range_wie_viel_zeitdruck_hatten_sie_bei_der_durchfuehrung_der_aufgabe",
        "performance": "range_wie_hoch_war_ihr_erfolgserlebnis_bei_der_durchfuehrung_der_aufgabe",
        "effort": "range_wie_hart_mussten_sie_arbeiten__um_ihr_leistungsniveau_zu_erreichen",
    }
    rows: list[list[object]] = [["user_ID", "stimuli_file", "rating_type", "rating"]]
    for n in range(1, 8):
        for stimulus in ("a.mp4", "b.mp4"):
            rows += [
                [n, stimulus, text, (7 * n + 3 * k) % 101] for k, text in enumerate(asked.values())
            ]
            rows.append([n, stimulus, "wie_hoch_war_die_anstrengung_beim_zuhoeren", 3])
    imported = imported_from(write(tmp_path / "_ratings.csv", rows))
    first = next(iter(imported.responses.values()))
    assert dict(first.answers) == {item: 7 + 3 * k for k, item in enumerate(asked)}
    assert {place.condition for _, place in imported.responses} == {"a.mp4", "b.mp4"}


@pytest.mark.parametrize("label", ["Condition", "Group"])
def test_a_table_of_people_says_the_condition_of_others(label: str, tmp_path: Path) -> None:
    people: list[list[object]] = [["ID", "Age", label]]
    people += [[f"S{n}", 20 + n, ("still", "moving")[n % 2]] for n in range(1, 9)]
    rows: list[list[object]] = [["ID", "Session", *ENGLISH]]
    for n in range(1, 9):
        rows += [[f"S{n}", when, *given(n, k)] for k, when in enumerate(("pre", "post"), start=1)]
    files = [write(tmp_path / "ssq.csv", rows), write(tmp_path / "people.csv", people)]
    suggestion = suggest_mapping(files)
    assert suggestion.imported is not None
    assert {(p.participant, p.condition) for _, p in suggestion.imported.responses} == {
        (f"S{n}", ("still", "moving")[n % 2]) for n in range(1, 9)
    }
    assert any("those of other tables" in doubt for doubt in suggestion.doubts)


def test_codes_with_a_letter_are_their_numbers(tmp_path: Path) -> None:
    columns = [f"SSQ{when}[SQ{n:03}]" for when in (1, 2) for n in range(1, 17)]
    rows: list[list[object]] = [["id", "lastpage", "CODE", "GRP", *columns]]
    for n in range(1, 9):
        answers = [f"A{a + 1}" for a in (*[int(a > 1) for a in given(n, 1)], *given(n, 2))]
        rows.append([n + 7, 5, f"KL{n}", f"G{n % 2}", *answers])
    rows[1][-1] = "A4"
    imported = imported_from(write(tmp_path / "results-survey.csv", rows))
    assert {(p.condition, p.timepoint) for _, p in imported.responses} == {
        (group, when) for group in ("G0", "G1") for when in ("baseline", "post")
    }
    assert answers_in(imported)[3] == given(2, 2)


def test_sidecars_say_items_and_levels_and_are_no_tables(tmp_path: Path) -> None:
    columns = [f"ssq_{n:02}" for n in range(1, 17)]
    rows: list[list[object]] = [["participant_id", "session_id", *columns]]
    for n in range(1, 9):
        for when, moment in enumerate(("ses-baseline", "ses-posttask"), start=1):
            rows.append([f"sub-{n:03}", moment, *(given(n, when)[k] for k in ALPHABETICAL)])
    levels = {str(answer): word for answer, word in enumerate(WORDS)}
    said: dict[str, object] = {
        column: {"LongName": ENGLISH[item], "Description": "right now", "Levels": levels}
        for column, item in zip(columns, ALPHABETICAL, strict=True)
    }
    said["session_id"] = {"Description": "when it was asked"}
    (tmp_path / "ssq.json").write_text(json.dumps(said), encoding="utf-8")
    files = [write(tmp_path / "ssq.csv", rows), tmp_path / "ssq.json"]
    imported = suggest_mapping(files).imported
    assert imported is not None
    found = {
        (place.participant, place.timepoint): [each.answers[name] for name in NAMES]
        for (_, place), each in imported.responses.items()
    }
    assert found == {
        (f"sub-{n:03}", moment): given(n, when)
        for n in range(1, 9)
        for when, moment in enumerate(("baseline", "post"), start=1)
    }


def test_ratings_weights_and_products_side_by_side_are_the_ratings(tmp_path: Path) -> None:
    names = ["Mental", "Physical", "Temporal", "Performance", "Effort"]
    blocks = [*names, "Frustration", "", *names, "Fustration", "Total", *names, "Fustration"]
    rows: list[list[object]] = [["SID", "Ver", *blocks, "Sum", "Weighted Rate"]]
    weights = [5, 4, 3, 2, 1, 0]
    for n in range(1, 13):
        ratings = [(35 * n + 15 * k) % 101 // 5 * 5 for k in range(6)]
        own = [weights[(k + n) % 6] for k in range(6)]
        products = [a * b for a, b in zip(ratings, own, strict=True)]
        total = [sum(products), round(sum(products) / 15, 1)]
        rows.append([f"S{n}", f"v{n % 2}", *ratings, "", *own, 15, *products, *total])
    imported = imported_from(write(tmp_path / "nasatlx.csv", rows))
    assert [answers[:6] for answers in answers_in(imported)] == [row[2:8] for row in rows[1:]]
    assert {place.timepoint for _, place in imported.responses} == {"post"}


@pytest.mark.parametrize("heading", ["Experimenter", "Highest degree", "Dominant eye", "Browser"])
def test_what_divides_people_in_two_is_no_condition_where_its_heading_says_so(
    heading: str, tmp_path: Path
) -> None:
    rows: list[list[object]] = [["ID", heading, *ENGLISH]]
    rows += [[f"P{n}", ("left", "right")[n % 2], *given(n, 1)] for n in range(1, 9)]
    imported = imported_from(write(tmp_path / "ssq.csv", rows))
    assert {place.condition for _, place in imported.responses} == {"all"}


def test_glasses_of_which_each_person_wears_two_are_the_condition(tmp_path: Path) -> None:
    rows: list[list[object]] = [["VPN", "Brille", "Runde", *ENGLISH]]
    for n in range(1, 9):
        rows += [[n, g, k, *given(n, k)] for k, g in enumerate(("Quest", "Pico"), start=1)]
    imported = imported_from(write(tmp_path / "ssq.csv", rows))
    assert {place.condition for _, place in imported.responses} == {"Quest", "Pico"}


def test_forms_of_a_codebook_say_conditions_and_moments(tmp_path: Path) -> None:
    book: list[list[object]] = [["Variable / Field Name", "Form Name", "Field Type", "Field Label"]]
    for form, code in enumerate(("base", "narrow_after", "wide_after")):
        for n, item in enumerate(ENGLISH):
            book.append([f"v{form}x_{n}", f"ssq_{code}", "radio", item])
        if form:
            book.append([f"sh{form}", f"ssq_{code}", "text", "How sharp was the picture (0-10)?"])
    columns = [str(row[0]) for row in book[1:]]
    rows: list[list[object]] = [["record_id", *columns]]
    for n in range(1, 9):
        blocks = [given(n, when) for when in (1, 2, 3)]
        rows.append([n, *blocks[0], *blocks[1], n, *blocks[2], n + 1])
    files = [write(tmp_path / "data.csv", rows), write(tmp_path / "dictionary.csv", book)]
    imported = suggest_mapping(files).imported
    assert imported is not None
    assert {(name, p.condition, p.timepoint) for name, p in imported.responses} == {
        ("ssq", "", "baseline"),
        *((name, c, "post") for name in ("ssq", "own_questions") for c in ("narrow", "wide")),
    }


def test_numbers_that_a_codebook_names_are_the_condition_and_not_what_never_differs(
    tmp_path: Path,
) -> None:
    names = [f"SSQ_{n}" for n in range(1, 17)]
    rows: list[list[object]] = [["CASE", "MODE", "ID01", "Cond", *names]]
    for n in range(1, 9):
        rows += [[2 * n + k, "interview", f"P{n}", k + 1, *given(n, k + 1)] for k in (0, 1)]
    book: list[list[object]] = [["VAR", "RESPONSE", "MEANING"]]
    book += [["Cond", 1, "low"], ["Cond", 2, "high"]]
    book += [[name, n, word] for name in names for n, word in enumerate(WORDS)]
    files = [write(tmp_path / "data.csv", rows), write(tmp_path / "values.csv", book)]
    imported = suggest_mapping(files).imported
    assert imported is not None
    assert {place.condition for _, place in imported.responses} == {"low", "high"}
