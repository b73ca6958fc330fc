"""Files of other labs, in layouts that only a suggested mapping makes sense of."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.support.lab_layouts import LAB_LAYOUTS
from tests.support.layouts import ITEMS, LAYOUTS, WORDS, Truth, write
from tests.support.odd_layouts import ODD_LAYOUTS
from tests.support.report import build_report
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.importing import import_files, load_mapping, write_study
from vrcomfort.importing.rows import Imported
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.questionnaire import score, shipped_instruments
from vrcomfort.report.study_data import read_study


def answered(text: str) -> str:
    """Answer every doubt of a mapping: what is assumed is right."""
    return text.replace('answer = ""', 'answer = "yes"')


def answers_of(imported: Imported) -> Truth:
    return {
        (m.participant, m.condition, m.timepoint): tuple(
            _code(response.answers.get(item)) for item in ITEMS
        )
        for (instrument, m), response in imported.responses.items()
        if instrument == "ssq"
    }


ALL = {**LAYOUTS, **ODD_LAYOUTS, **LAB_LAYOUTS}
"""Of the doubts of each, the most that a person is asked is five."""


def _code(answer: float | None) -> int:
    return -1 if answer is None else int(answer)


@pytest.mark.parametrize("name", ALL)
def test_every_answer_is_read_and_at_most_five_doubts_are_asked_with_their_consequences(
    name: str, tmp_path: Path
) -> None:
    folder = tmp_path / "lab"
    folder.mkdir()
    files, truth = ALL[name](folder)
    text = suggest_mapping(files).text
    doubts = tomllib.loads(text).get("doubts", [])
    assert len(doubts) <= 5
    assert all(doubt["assumed"] and doubt["otherwise"] for doubt in doubts)
    file = tmp_path / "map.toml"
    file.write_text(answered(text), encoding="utf-8")
    mapping = load_mapping(file)
    imported = import_files(files, mapping.mapping)
    assert answers_of(imported) == truth
    study = tmp_path / "study"
    write_study(study, imported, mapping, files)
    read = {
        (s.participant, s.condition, s.timepoint): tuple(_code(s.answers[i]) for i in ITEMS)
        for s in read_study(study).sheets
        if ITEMS[0] in s.answers
    }
    assert read == truth


@pytest.mark.parametrize("name", ["limesurvey", "headerless", "long_numbers", "misspelt"])
def test_open_doubts_are_refused_by_name(name: str, tmp_path: Path) -> None:
    files, _ = LAYOUTS[name](tmp_path)
    suggested = suggest_mapping(files)
    assert suggested.doubts
    file = tmp_path / "map.toml"
    file.write_text(suggested.text, encoding="utf-8")
    with pytest.raises(InputError, match="open in this mapping") as refusal:
        load_mapping(file)
    for question in re.findall(r'^question = "(.*)"$', suggested.text, re.MULTILINE):
        assert question.replace('\\"', '"') in str(refusal.value)


DOUBTS = {
    "limesurvey": ["answers 1 to 4 in place of 0 to 3", "in the published order"],
    "headerless": ["no headings", "tell participants apart", "the condition", "published order"],
    "named_files": ["names of the files"],
    "long_numbers": ["published order", "Comfort"],
    "misspelt": ["salivaton", "Fullnes of head", "Stomach awarness", "Diff. concentrating"],
    "melted": ["Which timepoints are T0, T1?"],
    "asked_twice": ["asked twice in a row"],
    "with_codes": ["999"],
    "side_by_side": ["side by side"],
    "baseline_once": ["'baseline' in 'Phase'"],
    "name_once": ["blank cells of 'Participant'"],
    "item_called_otherwise": ["'Nausea' is exactly the sum of"],
    "from_one_without_the_highest": ["None of 320 answers is 0"],
    "excel_sheets": ["names of the sheets", "'Mean'", "Notes"],
}


@pytest.mark.parametrize("name", DOUBTS)
def test_what_is_not_certain_is_asked(name: str, tmp_path: Path) -> None:
    files, _ = ALL[name](tmp_path)
    doubts = suggest_mapping(files).doubts
    for words in DOUBTS[name]:
        assert any(words in doubt for doubt in doubts), words


def crossover(conditions: list[str]) -> list[list[object]]:
    """A row for each of eight people in each condition, and its heading."""
    rows: list[list[object]] = [["ID", "Condition", *ITEMS]]
    for n in range(8):
        rows += [[f"P{n}", each, *[(n + k) % 4 for k in range(16)]] for each in conditions]
    return rows


def test_a_misspelt_condition_is_asked_about(tmp_path: Path) -> None:
    rows = crossover(["ohne Blende", "mit Blende", "mit Licht"])
    rows[5][1] = "mit Belnde"
    (doubt,) = suggest_mapping([write(tmp_path / "x.csv", rows)]).doubts
    assert "'mit Blende' and 'mit Belnde'" in doubt
    assert '"mit Belnde" = "mit Blende"' in doubt


@pytest.mark.parametrize(
    "conditions",
    [["comfortable", "uncomfortable"], ["Display 1", "Display 2"], ["control", "contrl"]],
)
def test_conditions_that_are_equally_often_met_are_not_misspelt(
    conditions: list[str], tmp_path: Path
) -> None:
    assert not suggest_mapping([write(tmp_path / "x.csv", crossover(conditions))]).doubts


def test_who_has_a_row_twice_is_named(tmp_path: Path) -> None:
    rows = crossover(["a", "b"])
    file = write(tmp_path / "x.csv", [*rows, rows[4]])
    suggested = suggest_mapping([file])
    (doubt,) = suggested.doubts
    assert "Were rows of P1 saved twice (row 18 is the same as row 5)?" in doubt
    assert suggested.imported is not None
    assert any("counted once" in note for note in suggested.imported.notes)


def test_codes_under_name_tell_people_apart_and_names_are_numbered(tmp_path: Path) -> None:
    rows = crossover(["a", "b"])
    rows[0][0] = "Name"
    coded = suggest_mapping([write(tmp_path / "x.csv", rows)])
    assert coded.imported is not None
    assert [*coded.imported.participants] == [f"P{n}" for n in range(8)]
    for row in rows[1:]:
        row[0] = f"Anna {'ABCDEFGH'[int(str(row[0])[1])]}."
    named = suggest_mapping([write(tmp_path / "y.csv", rows)])
    assert "Anna" not in named.text
    assert named.imported is not None
    assert [*named.imported.participants] == [str(n) for n in range(1, 9)]
    assert any("numbered, without their names" in doubt for doubt in named.doubts)


@pytest.mark.parametrize("title", [(), ("Study 3", "", "exported 2024")])
def test_headings_of_three_rows_below_a_title(title: tuple[str, ...], tmp_path: Path) -> None:
    moments = [(c, t) for c in ("Big lens", "Small screen") for t in ("Before", "After")]
    above: list[list[object]] = [["", ""], ["", ""], ["ID", "Age"]]
    for condition, when in moments:
        above[0] += [condition if when == "Before" else "", *[""] * 15]
        above[1] += [when, *[""] * 15]
        above[2] += ITEMS
    people = [[f"P{n}", 20 + n, *[(n + k) % 4 for k in range(64)]] for n in range(6)]
    file = write(tmp_path / "x.csv", [*([text] for text in title), *above, *people])
    suggested = suggest_mapping([file])
    assert suggested.imported is not None
    found = {(m.participant, m.condition, m.timepoint) for _, m in suggested.imported.responses}
    assert {(c, t) for _, c, t in found} == {
        (c, t) for c in ("Big_lens", "Small_screen") for t in ("baseline", "post")
    }
    assert len(found) == len(suggested.imported.responses) == 24
    assert 'Big_lens = "Big lens"' in suggested.text
    assert answers_of(suggested.imported)["P5", "Small_screen", "post"] == tuple(
        (5 + k) % 4 for k in range(48, 64)
    )


def test_numbers_below_conditions_are_headings_beside_any_number_of_texts(tmp_path: Path) -> None:
    upper = ["", "", "", "", *["Big lens"] * 16, *["Small screen"] * 16]
    lower = ["ID", "Age", "Sex", "Group", *range(1, 17), *range(1, 17)]
    people = [[f"P{n}", 20 + n, "fm"[n % 2], "x", *[WORDS[(n + k) % 4] for k in range(32)]]
              for n in range(6)]  # fmt: skip
    suggested = suggest_mapping([write(tmp_path / "ssq.csv", [upper, lower, *people])])
    assert "heading_rows = [1, 2]" in suggested.text


def test_answers_of_the_first_columns_are_found_beside_another_number_in_the_last(
    tmp_path: Path,
) -> None:
    rows = [[*[(n + k) % 4 for k in range(16)], f"P{n}", n % 4] for n in range(8)]
    suggested = suggest_mapping([write(tmp_path / "ssq.csv", rows)])
    assert suggested.imported is not None
    assert {*answers_of(suggested.imported).values()} == {
        tuple((n + k) % 4 for k in range(16)) for n in range(8)
    }


@pytest.mark.parametrize("age", [[], [30]], ids=["no column", "another column"])
def test_an_item_without_a_column_of_answers_is_left_out(tmp_path: Path, age: list[int]) -> None:
    names: list[object] = ["ID", *ITEMS]
    place = names.index("headache")
    rows = [[f"P{n}", *[(n + k) % 4 for k in range(16)]] for n in range(8)]
    for n, row in enumerate([names, *rows]):
        row[place : place + 1] = (["Age"] if n == 0 else [age[0] + n]) if age else []
    suggested = suggest_mapping([write(tmp_path / "x.csv", [names, *rows])])
    assert suggested.imported is not None
    read = answers_of(suggested.imported)
    assert len(read) == 8
    assert [ITEMS[k] for k in range(16) if {each[k] for each in read.values()} == {-1}] == [
        "headache"
    ]


def test_a_first_row_of_one_answer_is_data(tmp_path: Path) -> None:
    rows = [[0] * 16, *([n % 4] * 16 for n in range(9))]
    suggested = suggest_mapping([write(tmp_path / "x.csv", rows)])
    assert "heading_rows = []" in suggested.text
    assert "skip_rows" not in suggested.text


def test_every_column_is_mapped_or_ignored(tmp_path: Path) -> None:
    files, _ = LAYOUTS["qualtrics"](tmp_path)
    text = answered(suggest_mapping(files).text)
    assert "StartDate" in text
    file = tmp_path / "map.toml"
    file.write_text(text.replace('"StartDate", ', ""), encoding="utf-8")
    with pytest.raises(InputError, match="'StartDate': is neither mapped nor listed under ignore"):
        import_files(files, load_mapping(file).mapping)


@pytest.mark.slow
@pytest.mark.smoke
def test_command_line_from_files_to_report(tmp_path: Path) -> None:
    files, truth = LAYOUTS["spss_wide"](tmp_path)
    run = CliRunner()
    mapping, study, report = (tmp_path / name for name in ("map.toml", "study", "report"))
    suggested = run.invoke(app, ["import", str(files[0]), "--suggest", "--out", str(mapping)])
    assert suggested.exit_code == 0, suggested.output
    assert "10 participants, 2 conditions" in suggested.stdout
    mapping.write_text(answered(mapping.read_text("utf-8")), encoding="utf-8")
    made = run.invoke(
        app, ["import", str(files[0]), "--mapping", str(mapping), "--out", str(study)]
    )
    assert made.exit_code == 0, made.output
    assert (study / "questionnaires.csv").read_text().count("\n") == 1 + 16 * len(truth)
    assert (study / "participants.csv").read_text().splitlines()[:2] == [
        "participant,sequence,status,enrolled_at,note,age,sex,group",
        "P01,,enrolled,,,20,f,A",
    ]
    shown = run.invoke(app, ["report", str(study), "--out", str(report), "--figures", "none"])
    assert shown.exit_code == 0, shown.output
    assert (report / "index.html").exists()


def test_real_answers_in_words_give_the_scores_that_are_known() -> None:
    file = Path("tests/data/vrsq/answers.csv")
    suggested = suggest_mapping([file])
    assert any("Items of VRSQ are items of SSQ, too" in doubt for doubt in suggested.doubts)
    imported = suggested.imported
    assert imported is not None
    vrsq = shipped_instruments()["vrsq"]
    scores = [score(vrsq, response.answers) for response in imported.responses.values()]
    points = [[found[name].points for name in ("O", "D", "T")] for found in scores]
    means = [sum(column) / len(points) for column in zip(*points, strict=True)]
    assert means == pytest.approx([15.5556, 7.1111, 11.3333], abs=5e-5)


def test_conditions_in_headings_keep_their_capital_letters(tmp_path: Path) -> None:
    rows = [["ID", *(f"{c} {text}" for c in ("Blur", "NoBlur") for text in ITEMS)]]
    rows += [[f"P{n}", *[n % 4] * 32] for n in range(5)]
    suggested = suggest_mapping([write(tmp_path / "x.csv", rows)])
    assert suggested.imported is not None
    assert suggested.imported.conditions == ["Blur", "No_Blur"]


def questionnaire(folder: Path, name: str, headings: list[str], answers: list[list[int]]) -> Path:
    rows = [["Participant", "Condition", *headings]]
    rows += [[f"P{n // 2}", "ab"[n % 2], *row] for n, row in enumerate(answers)]
    return write(folder / name, rows)


def test_five_answers_are_asked_about_and_are_another_instrument(tmp_path: Path) -> None:
    answers = [[(n * k) % 5 for k in range(16)] for n in range(8)]
    file = questionnaire(tmp_path, "x.csv", [*ITEMS], answers)
    suggested = suggest_mapping([file])
    assert any("from 0 to 4: is this the five-point SSQ?" in each for each in suggested.doubts)
    assert suggested.imported is not None
    assert {name for name, _ in suggested.imported.responses} == {"ssq_five_point"}
    mapping, study = tmp_path / "map.toml", tmp_path / "study"
    mapping.write_text(answered(suggested.text))
    loaded = load_mapping(mapping)
    write_study(study, suggested.imported, loaded, [file])
    summary = build_report(study, out=tmp_path / "report")  # an item and a scale are both nausea
    assert summary.analysed == 4


def test_marks_of_the_task_load_index_are_asked_about(tmp_path: Path) -> None:
    tlx = shipped_instruments()["nasa_tlx"]
    answers = [[(n * k) % 21 for k in range(1, 7)] for n in range(8)]
    names = [item.name for item in tlx.asked]
    suggested = suggest_mapping([questionnaire(tmp_path, "tlx.csv", names, answers)])
    assert any("these 0 to 20: are they marks?" in doubt for doubt in suggested.doubts)
    assert suggested.imported is not None
    found = [[*response.answers.values()] for response in suggested.imported.responses.values()]
    assert found == [[5 * mark for mark in row] for row in answers]


def test_a_labs_own_instrument_is_found_and_travels_with_the_study(tmp_path: Path) -> None:
    own = tmp_path / "glare.toml"
    own.write_text(
        'name = "glare"\ntitle = "Glare"\n[answers]\nlow = 0\nhigh = 5\n'
        + "".join(f'[[items]]\nname = "{name}"\n' for name in ("dazzle", "halo", "tears", "blink"))
    )
    answers = [[(n * k) % 6 for k in range(1, 5)] for n in range(12)]
    file = questionnaire(tmp_path, "x.csv", ["Dazzle", "Halo", "Tears", "Blink"], answers)
    mapping, study = tmp_path / "map.toml", tmp_path / "study"
    run = CliRunner()
    asked = ["import", str(file), "--suggest", "--instrument", str(own), "--out", str(mapping)]
    assert run.invoke(app, asked).exit_code == 0
    made = run.invoke(app, ["import", str(file), "--mapping", str(mapping), "--out", str(study)])
    assert made.exit_code == 0, made.output
    assert (study / "instruments" / "glare.toml").read_text() == own.read_text()
    found = [[*response.answers.values()] for response in read_study(study).sheets]
    assert found == answers


def test_headings_that_are_made_alike_are_said_in_one_template(tmp_path: Path) -> None:
    files, _ = LAYOUTS["spss_wide"](tmp_path)
    text = suggest_mapping(files).text
    assert text.count("[[tables.questionnaires]]") == 1
    assert 'heading = "{condition}_{timepoint}_{item}"' in text
    assert 'timepoint = { values = { pre = "baseline", post = "post" } }' in text


@pytest.mark.parametrize("heading", ["Trial", "Run"])
def test_a_number_of_rows_is_not_that_of_each_condition_in_them(
    tmp_path: Path, heading: str
) -> None:
    rows = [["ID", heading, *(f"{c}_{item}" for c in ("dull", "blur") for item in ITEMS)]]
    rows += [[f"P{n // 2}", n % 2 + 1, *[n % 4] * 16, *[(n + 1) % 4] * 16] for n in range(12)]
    suggested = suggest_mapping([write(tmp_path / "x.csv", rows)])
    (doubt,) = suggested.doubts
    assert f"'{heading}' numbers rows of several conditions each" in doubt
    assert suggested.imported is not None
    met = {
        m.trial: (m.condition, set(response.answers.values()))
        for (_, m), response in suggested.imported.responses.items()
        if m.participant == "P1"
    }
    assert met == {"1": ("dull", {2}), "2": ("blur", {3}), "3": ("dull", {3}), "4": ("blur", {0})}


def test_headings_that_one_template_would_mistake_are_listed(tmp_path: Path) -> None:
    names = ("no_blur", "blur")  # {condition}_{item} would find a condition no, and its blur_nausea
    rows = [["ID", *(f"{c}_{item}" for c in names for item in ITEMS)]]
    rows += [[f"P{n}", *[n % 4] * 16, *[(n + 1) % 4] * 16] for n in range(6)]
    suggested = suggest_mapping([write(tmp_path / "x.csv", rows)])
    assert suggested.imported is not None
    found = answers_of(suggested.imported)
    assert found["P2", "no_blur", "post"] == (2,) * 16
    assert found["P2", "blur", "post"] == (3,) * 16


def test_seconds_of_ratings_tell_no_exposures_apart(tmp_path: Path) -> None:
    rows = [
        f"P{person},{condition},{10 * place},{place + person}"
        for person in range(4)
        for condition in "ab"
        for place in range(6)
    ]
    file = tmp_path / "ratings.csv"
    file.write_text("\n".join(["participant,condition,time_s,FMS", *rows, ""]), "utf-8")
    suggested = suggest_mapping([file])
    assert not suggested.doubts
    map_file = tmp_path / "map.toml"
    map_file.write_text(suggested.text, encoding="utf-8")
    imported = import_files([file], load_mapping(map_file).mapping)
    courses = {r.administration._replace(timepoint="") for r in imported.ratings}
    assert len(imported.ratings) == 48
    assert len(courses) == 8


def test_ratings_side_by_side_are_courses_of_exposures(tmp_path: Path) -> None:
    minutes = range(5)
    rows: list[list[object]] = [
        ["PID", *(f"{c} FMS {minute} min" for c in ("near", "far") for minute in minutes)]
    ]
    rows += [[f"P{n}", *(minute + n for minute in minutes), *[n] * 5] for n in range(6)]
    suggested = suggest_mapping([write(tmp_path / "x.csv", rows)])
    assert any("minutes after its start" in doubt for doubt in suggested.doubts)
    imported = suggested.imported
    assert imported is not None
    ratings = [
        (r.onset_s, r.response)
        for r in imported.ratings
        if r.administration[0] == "P3" and r.administration.condition == "near"
    ]
    assert ratings == [(60.0 * minute, minute + 3) for minute in minutes]
    found = {(m.participant, m.condition): s.answers for (_, m), s in imported.responses.items()}
    assert found["P3", "near"] == {"peak": 7, "mean": 5, "last": 7}
    assert found["P3", "far"] == {"peak": 3, "mean": 3, "last": 3}


def test_a_mapping_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    files, _ = LAYOUTS["german"](tmp_path)
    mapping = tmp_path / "map.toml"
    mapping.write_text("# read for an hour")
    with pytest.raises(InputError, match="is there already"):
        CliRunner().invoke(
            app,
            ["import", str(files[0]), "--suggest", "--out", str(mapping)],
            catch_exceptions=False,
        )
    assert mapping.read_text() == "# read for an hour"


def test_raised_digits_in_headings_are_letters(tmp_path: Path) -> None:
    """``SSQ ³`` has a digit that is no number: `int` does not read it."""
    headings = [f"SSQ {n}" for n in (*range(1, 16), "³")]
    file = tmp_path / "lab.csv"
    rows = [",".join(["P01", *"0123012301230123"]), ",".join(["P02", *"1111000022223333"])]
    file.write_text("\n".join([",".join(["id", *headings]), *rows, ""]), encoding="utf-8")
    assert "SSQ ³" in suggest_mapping([file]).text


def test_raw_sums_stand_beside_a_weighted_total(tmp_path: Path) -> None:
    """N, O and D are raw sums, TS is weighted, before and after; physiology is none of these."""
    head = ["n", "o", "d", "TS", "n_p", "o_p", "d_p", "TS_p", "OverallHR", "OverallGSR", "Dig"]
    rows: list[list[object]] = [[*head]]
    for k in range(12):
        n, o, d = k % 5, (k * 7) % 6, (k * 3) % 4
        after = n + 2, o + 1, d + k % 2
        scores = [n, o, d, round(3.74 * (n + o + d), 2), *after, round(3.74 * sum(after), 2)]
        rows.append([*scores, 80 + k / 7, 1 + k / 9, k])
    found = suggest_mapping([write(tmp_path / "SSQ_scores.csv", rows)]).imported
    assert found is not None
    kept = {(name, m.timepoint): [*r.answers.values()] for (name, m), r in found.responses.items()}
    assert {key for key, _ in kept.items()} == {
        (name, when) for name in ("ssq_raw_sums", "ssq_scores") for when in ("baseline", "post")
    } | {("own_measures", "post")}
    assert kept["ssq_raw_sums", "post"] == [11 % 5 + 2, 77 % 6 + 1, 33 % 4 + 1]
    assert kept["ssq_scores", "baseline"] == [round(3.74 * (11 % 5 + 77 % 6 + 33 % 4), 2)]


def test_means_over_conditions_are_no_condition(tmp_path: Path) -> None:
    scales = [f"SSQ_{scale}_{c}" for c in ("FP", "H", "AVG") for scale in ("N", "O", "D", "TS")]
    rows: list[list[object]] = [["ID", *scales]]
    for k in range(9):
        a = [round(9.54 * (k % 3), 2), 7.58, 13.92, 35.68 + k]
        b = [0, round(7.58 * (k % 4), 2), 0, 28.3 + k]
        rows.append([f"P{k}", *a, *b, *((x + y) / 2 for x, y in zip(a, b, strict=True))])
    suggested = suggest_mapping([write(tmp_path / "scores.csv", rows)])
    assert suggested.imported is not None
    assert suggested.imported.conditions == ["FP", "H"]
    assert "SSQ_N_AVG: a mean of the others" in suggested.text


def suggested_import(files: list[Path], folder: Path) -> tuple[Imported, str]:
    """Import files with the suggested mapping, all doubts answered; return the mapping, too."""
    file = folder / "suggested.toml"
    file.write_text(answered(suggest_mapping(files).text), encoding="utf-8")
    return import_files(files, load_mapping(file).mapping), file.read_text("utf-8")


def test_seconds_in_the_first_column_without_headings_are_times_of_ratings(tmp_path: Path) -> None:
    files = [
        write(
            tmp_path / f"P{person:02d}_{condition}_FMS.csv",
            [[10.0 * place, place // 2 + person % 3] for place in range(8)],
        )
        for person in range(1, 5)
        for condition in ("blur", "plain")
    ]
    imported, text = suggested_import(files, tmp_path)
    courses: dict[tuple[str, str], list[float]] = {}
    for each in imported.ratings:
        key = each.administration.participant, each.administration.condition
        courses.setdefault(key, []).append(each.onset_s)
    assert courses.keys() == {(f"P{n:02d}", c) for n in range(1, 5) for c in ("blur", "plain")}
    assert all(times == [10.0 * place for place in range(8)] for times in courses.values())
    assert "in seconds since the exposure began" in text


def test_a_count_of_rows_tells_no_exposures_apart(tmp_path: Path) -> None:
    rows: list[list[object]] = [["id", "condition", "idx", "EndTimeStamp", "fms"]]
    rows += [[f"P{n}", c, t, 2 * t + 2, t] for n in range(4) for c in "ab" for t in range(9)]
    imported, text = suggested_import([write(tmp_path / "log.csv", rows)], tmp_path)
    assert len({r.administration for r in imported.ratings}) == 8
    assert 'time = "EndTimeStamp"' in text


def test_numbered_conditions_say_those_of_ratings_with_their_number(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["Participant", "MISC_0", "MISC_1", "Condition_1", "Comment", "MISC_2", "Condition_2"]
    ]
    for n in range(8):
        first, second = ("near", "far") if n % 2 else ("far", "near")
        rows.append([f"P{n}", 0, 1 + n % 3, first, f"comment {n}", 4 + n % 2, second])
    imported, _ = suggested_import([write(tmp_path / "form.csv", rows)], tmp_path)
    found = {
        (m.participant, m.condition, m.timepoint): response.answers["misc"]
        for (_, m), response in imported.responses.items()
    }
    assert found["P1", "", "baseline"] == 0
    assert (found["P1", "near", "post"], found["P1", "far", "post"]) == (2, 5)
    assert (found["P2", "far", "post"], found["P2", "near", "post"]) == (3, 4)
    assert len(found) == 24


def test_questions_glued_to_the_names_of_items_are_one_questionnaire(tmp_path: Path) -> None:
    head = [
        "Participant ID", "Mental DemandHow mentally demanding was the task?  []",
        "Physical DemandHow physically demanding was the task?  []",
        "Temporal DemandHow hurried or rushed was the pace of the task?  []",
        "PerformanceHow successful were you in accomplishing what you were asked to do?  []",
        "EffortHow hard did you have to work to accomplish your level of performance?  []",
        "FrustrationHow insecure, discouraged and annoyed were you?  []",
    ]  # fmt: skip
    rows: list[list[object]] = [head]
    rows += [[n, *((n + k) % 10 + 1 for k in range(6))] for n in range(1, 9)]
    imported, _ = suggested_import([write(tmp_path / "NASA-TLX.csv", rows)], tmp_path)
    (first, *_) = imported.responses.values()
    assert len(imported.responses) == 8
    assert [*first.answers.values()] == [20, 30, 40, 50, 60, 70]


def test_numbered_scores_that_rise_from_the_first_are_timepoints(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Subject", "SSQ 1", "SSQ 2", "SSQ 3"]]
    rows += [[f"{n}F", 3.74 * (n % 2), 3.74 * (5 + n), 3.74 * (1 + n)] for n in range(8)]
    imported, text = suggested_import([write(tmp_path / "totals.csv", rows)], tmp_path)
    assert {m.timepoint for _, m in imported.responses} == {"baseline", "post", "recovery"}
    assert 'kind = "score"' in text


def test_leaving_times_in_words_become_ends_of_exposures(tmp_path: Path) -> None:
    said = ["Y - 11m 56s", "N", "Yes, -8min 43s", "No", "Yes 3 min", "N", "No", "N"]
    rows: list[list[object]] = [["Participant", "Condition", "Discontinued"]]
    rows += [[n, "Road" if n % 2 else "Oval", text] for n, text in enumerate(said, start=1)]
    rows.append(["Participant", "Condition", "Discontinued"])
    imported, text = suggested_import([write(tmp_path / "left.csv", rows)], tmp_path)
    left = {e.administration.participant: e.end_s for e in imported.ends if e.left}
    assert left == {"1": 716.0, "3": 523.0, "5": 180.0}
    assert {e.end_s for e in imported.ends if not e.left} == {None}
    assert {e.administration.condition for e in imported.ends} == {"Road", "Oval"}
    assert 'Participant = ["Participant"]' in text


def test_words_in_front_are_the_condition_where_nothing_tells_people_apart(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        [
            "$created",
            "song",
            "mental",
            "physical",
            "temporal",
            "performance",
            "effort",
            "frustration",
        ]
    ]
    rows += [
        [f"0{n % 2 + 6}.05.2025", song, *((n + k) % 9 + 1 for k in range(6))]
        for song in "ABC"
        for n in range(5)
    ]
    imported, _ = suggested_import([write(tmp_path / "nasatlx.csv", rows)], tmp_path)
    assert {m.condition for _, m in imported.responses} == {"A", "B", "C"}
    assert len(imported.responses) == 15


def test_three_items_are_a_short_form_where_the_file_names_the_questionnaire(
    tmp_path: Path,
) -> None:
    rows: list[list[object]] = [["id", "GeneralDiscomfort", "Fatigue", "EyeStrain"]]
    rows += [[f"P{n}", n % 4, (n + 1) % 4, (n + 2) % 4] for n in range(8)]
    imported, _ = suggested_import([write(tmp_path / "ssq.csv", rows)], tmp_path)
    assert len(imported.responses) == 8
    assert not suggest_mapping([write(tmp_path / "notes.csv", rows)]).text.count('"ssq"')
