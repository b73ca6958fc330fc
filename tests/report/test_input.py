"""What a report does with data and plans that are not as they should be."""

import json
import re

import pytest

from tests.support.report import (
    ONE_SCORE,
    Study,
    answers,
    build_report,
    foreign,
    manifest,
    planned_report,
    write_csv,
)
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_file, shipped_instruments
from vrcomfort.records.names import natural
from vrcomfort.report.plan_files import load_plan
from vrcomfort.report.study_data import read_study
from vrcomfort.resources import data_folder

SCORES = {f"P{i}": {"a": 3 + i, "b": 2 + i // 2} for i in range(5)}


def test_minimal_foreign_file_is_raw_and_says_so(tmp_path):
    source = foreign(tmp_path / "questionnaires.csv", SCORES)
    summary = planned_report(source, out=tmp_path / "o")
    results = json.loads(summary.results.read_text("utf-8"))
    assert results["score_basis"] == "raw_post"
    assert "no baseline questionnaire" in summary.index.read_text("utf-8")
    assert (summary.participants, summary.analysed, len(summary.warnings)) == (5, 5, 1)
    assert summary.warnings[0].startswith("with 5 people no p below .0625 exists")
    assert not results["withdrawals"]["recorded"]


def test_files_are_found_at_any_depth(tmp_path):
    foreign(tmp_path / "s/x/y/questionnaires.csv", {"P1": SCORES["P1"]})
    foreign(tmp_path / "s/questionnaires.csv", {"P2": SCORES["P2"]})
    assert len(read_study(tmp_path / "s").sheets) == 4


def test_other_tables_from_elsewhere_are_told_and_not_used(tmp_path):
    foreign(tmp_path / "a" / "questionnaires.csv", {"P1": {"on": 3, "off": 5}})
    (tmp_path / "participants.csv").write_text("participant_id,age\nP1,30\n")
    (tmp_path / "a" / "trials.csv").write_text("trial,rt\n1,0.3\n")
    assert read_study(tmp_path).warnings == (
        "participants.csv: not used, because it has no column participant",
        "a/trials.csv: not used, because it has no column participant",
    )


@pytest.mark.parametrize("tail", ["", "\0" * 4096])  # a power cut leaves the latter
def test_half_written_last_row_is_reported_and_its_questionnaire_left_out(tmp_path, tail):
    file = foreign(tmp_path / "s/questionnaires.csv", SCORES)
    text = file.read_text("utf-8")
    file.write_text(text[:-3] + tail)
    summary = planned_report(tmp_path / "s", out=tmp_path / "o")
    assert summary.analysed == 4
    half, incomplete, *_ = summary.warnings
    assert half.startswith("questionnaires.csv, line 161: the last row is half-written")
    assert "P4" in incomplete
    assert "no answer to burping" in incomplete
    assert "half-written" in summary.index.read_text("utf-8").lower()


def test_blank_answer_excludes_the_questionnaire_with_its_reason(tmp_path):
    study = Study(tmp_path / "s")
    for name in ("P1", "P2", "P3"):
        folder = study.session(name, 1, 0, [("a", "x", 4), ("b", "x", 2)])
    file = folder / "questionnaires.csv"
    lines = file.read_text().splitlines(keepends=True)
    lines[20] = lines[20].replace(",difficulty_focusing,0,", ",difficulty_focusing,,").replace(
        ",headache,0,", ",headache,,"
    ).replace(",eyestrain,0,", ",eyestrain,,")  # fmt: skip
    file.write_text("".join(lines))
    summary = planned_report(tmp_path / "s", out=tmp_path / "o")
    assert summary.analysed == 2
    assert summary.warnings[0].startswith("sub-P3/ses-1/questionnaires.csv, line 18: P3")


@pytest.mark.parametrize(
    ("old", "new", "line", "column"),
    [
        ("P0,a,general_discomfort,3", "P0,a,general_discomfort,4", 2, "response"),
        ("P0,a,fatigue,0", "P0,a,fatigue,None", 3, "response"),
        ("P0,a,fatigue,0", "P0,a,tiredness,0", 3, "item"),
        ("P0,a,headache,0", "P0,a,fatigue,0", 4, "item"),
        ("P0,a,headache,0", ",a,headache,0", 4, "participant"),
    ],
)
def test_wrong_answers_are_errors_with_their_place(tmp_path, old, new, line, column):
    file = foreign(tmp_path / "questionnaires.csv", SCORES)
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        build_report(file, out=tmp_path / "o")
    assert (caught.value.file, caught.value.line, caught.value.column) == (file, line, column)
    assert not (tmp_path / "o").exists()


def test_missing_column_is_named(tmp_path):
    file = tmp_path / "questionnaires.csv"
    file.write_text("participant,item,response\nP1,nausea,1\n")
    with pytest.raises(InputError, match="column 'condition' is missing"):
        build_report(file, out=tmp_path / "o")


def test_semicolons_are_named(tmp_path):
    file = tmp_path / "questionnaires.csv"
    file.write_text("participant;condition;item;response\nP1;a;nausea;1\n")
    with pytest.raises(InputError, match="separated by `;`"):
        build_report(file, out=tmp_path / "o")
    with pytest.raises(InputError, match="separated by `;`"):
        score_file(file, shipped_instruments()["ssq"])


@pytest.mark.parametrize("source", ["nothing", "empty"])
def test_no_data_is_an_error(tmp_path, source):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError):
        build_report(tmp_path / source, out=tmp_path / "o")


def test_nothing_but_incomplete_questionnaires_still_gives_a_report(tmp_path):
    file = tmp_path / "questionnaires.csv"
    file.write_text("participant,condition,item,response\nP1,a,nausea,1\nP1,b,nausea,2\n")
    summary = build_report(file, out=tmp_path / "o")
    assert (summary.analysed, len(summary.warnings)) == (0, 3)


def write_plan(path, text):
    path.write_text('name = "mine"\ntitle = "Mine"\n' + text, encoding="utf-8")
    return path


def test_own_plan_changes_the_tests(tmp_path):
    plan = write_plan(
        tmp_path / "p.toml",
        f'{ONE_SCORE}zeros = "wilcox"\nalternative = "less"\n'
        'contrasts = [{ a = "b", b = "a" }]\nfamilies = [{ name = "t", outcomes = ["T"] }]\n',
    )
    source = foreign(tmp_path / "questionnaires.csv", SCORES)
    (line,) = build_report(source, plan=plan, out=tmp_path / "o").headlines
    assert line.startswith("Total severity: lower under b than under a; ")
    test = json.loads((tmp_path / "o/results.json").read_text("utf-8"))["tests"][0]
    assert (test["zero_method"], test["alternative"], test["a"]) == ("wilcox", "less", "b")
    assert test["p_holm"] == test["p"]


@pytest.mark.parametrize(
    ("text", "words", "line"),
    [
        ("zero = 1\n", "unknown key `zero`", 3),
        ('zeros = "drop"\n', "zeros", 3),
        ('[[anova]]\nname = "x"\n', r"`column` is missing in \[anova\]", 3),
        ("zeros = \n", "not valid TOML", 3),
        ('outcomes = ["t"]\n', "`t` is no score of any instrument; did you mean `T`", 3),
        ('outcomes = "T"\n', "should be a list", 3),
        ('outcomes = ["T", "T"]\n', "`T` is there twice", 3),
        ('outcomes = ["T"]\n[[families]]\nname = "x"\noutcomes = ["N"]\n', "not among", 6),
        ("families = [{ name = 'x', outcomes = [] }]\n", "`outcomes`: needs at least 1", 3),
        ('family = ["T"]\n', r"`family` is now a list of tables, .* write \[\[families\]\]", 3),
        ('contrasts = [{ a = "b", b = "b" }]\n', "compared with itself", 3),
        ('[[anova]]\nname = "score"\ncolumn = "scene"\n', "cannot name a factor", 4),
        ('[[anova]]\nname = "x"\ncolumn = "scene"\n' * 2, "`x` is there twice", 6),
    ],
)
def test_faults_of_a_plan_have_their_place(tmp_path, text, words, line):
    plan = write_plan(tmp_path / "p.toml", text)
    with pytest.raises(InputError, match=words) as caught:
        load_plan(plan)
    assert (caught.value.file, caught.value.line) == (plan, line)


def test_misspelt_timepoints_of_a_plan_are_told(tmp_path):
    study = Study(tmp_path / "study")
    for name, turn in (("P1", 1), ("P2", -1)):
        study.session(name, 1, 2, [("a", "room", 5), ("b", "room", 4)][::turn])
    plan = write_plan(tmp_path / "p.toml", f'{ONE_SCORE}baseline_timepoint = "bsaeline"\n')
    warning, *_ = build_report(study.folder, plan=plan, out=tmp_path / "o").warnings
    assert warning.startswith("2 questionnaires at `baseline` not used")
    plan = write_plan(tmp_path / "p.toml", 'exposure_timepoint = "after"\n')
    with pytest.raises(InputError, match="the data have baseline, post"):
        build_report(study.folder, plan=plan, out=tmp_path / "o")


def test_plan_for_other_conditions_is_an_error(tmp_path):
    plan = write_plan(tmp_path / "p.toml", 'contrasts = [{ a = "x", b = "a" }]\n')
    source = foreign(tmp_path / "questionnaires.csv", SCORES)
    with pytest.raises(InputError, match="condition `x`; the data have a, b"):
        build_report(source, plan=plan, out=tmp_path / "o")


def test_misspelt_levels_of_a_factor_are_an_error(tmp_path):
    plan = write_plan(
        tmp_path / "p.toml",
        '[[anova]]\nname = "blur"\ncolumn = "condition"\nlevels = { a = "off", bb = "on" }\n',
    )
    source = foreign(tmp_path / "questionnaires.csv", SCORES)
    with pytest.raises(InputError, match=r"level `bb` of condition in factor `blur`; .* a, b"):
        build_report(source, plan=plan, out=tmp_path / "o")


def test_shipped_plans_are_valid_and_named_after_their_file():
    plans = list(data_folder("analysis").glob("*.toml"))
    assert [load_plan(plan).name for plan in plans] == [plan.stem for plan in plans]


def test_names_sort_as_people_sort_them():
    assert sorted(["P10", "P2", "p1", "P2b"], key=natural) == ["P2", "P2b", "P10", "p1"]
    assert sorted(["P9", "P09"], key=natural) == sorted(["P09", "P9"], key=natural)


def test_descriptions_from_elsewhere_are_told_and_not_used(tmp_path):
    foreign(tmp_path / "s" / "questionnaires.csv", SCORES)
    (tmp_path / "s" / "dataset_description.json").write_text('{"conditions": ["a", "b"]}')
    (tmp_path / "s" / "manifest.json").write_text('{"name": "an app", "clamps": 3}')
    summary = planned_report(tmp_path / "s", out=tmp_path / "o")
    assert summary.analysed == 5
    said = "line 1: not used, because it is no whole"
    fault = "`conditions` should be an object {...}"
    assert summary.warnings[:2] == (
        f"dataset_description.json, {said} study description: {fault}",
        f"manifest.json, {said} manifest: `participant` is missing",
    )
    (tmp_path / "s" / "manifest.json").write_bytes(b"\xff{}")
    with pytest.raises(InputError, match="not UTF-8; save the manifest as UTF-8"):
        build_report(tmp_path / "s", out=tmp_path / "o")


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        ({"status": []}, "`status`: should be 'running'"),
        ({"status": "ended", "ended": [1]}, "`ended` should be an object"),
        ({"withdrawals_undone": 3}, "`withdrawals_undone`: should be a list"),
        ({"withdrawals_undone": [1]}, "`withdrawals_undone.0` should be an object"),
        ({"withdrawals_undone": [{"trial": 1}]}, "`withdrawals_undone.0.at` is missing"),
        ({"protocol": []}, "`protocol` should be an object"),
    ],
    ids=str,
)
def test_damaged_manifests_are_told_and_not_used(tmp_path, damage, says):
    foreign(tmp_path / "s" / "questionnaires.csv", SCORES)
    (tmp_path / "s" / "manifest.json").write_text(manifest("P1", **damage))
    (warning,) = read_study(tmp_path / "s").warnings
    assert re.match(r"manifest.json, line \d+: not used, because it is no whole manifest", warning)
    assert says in warning


def test_before_and_after_need_no_condition(tmp_path):
    rows = [
        {"participant": f"P{n}", "timepoint": when, "item": item, "response": answer}
        for n in range(8)
        for when, total in (("baseline", n % 3), ("post", 3 + n))
        for item, answer in answers(total).items()
    ]
    file = tmp_path / "questionnaires.csv"
    write_csv(file, ("participant", "timepoint", "item", "response"), rows)
    contrast = '[[contrasts]]\na_timepoint = "post"\nb_timepoint = "baseline"\n'
    lines = f'scores = "raw"\n{ONE_SCORE}{contrast}'
    summary = planned_report(file, out=tmp_path / "r", lines=lines)
    assert "higher under post" in summary.headlines[0]
    assert "n\xa0=\xa08" in summary.headlines[0]


@pytest.mark.parametrize("columns", [(), ("timepoint",)])
def test_one_moment_without_a_condition_is_refused(tmp_path, columns):
    rows = [
        {"participant": "P1", "item": item, "response": answer, **dict.fromkeys(columns, "post")}
        for item, answer in answers(4).items()
    ]
    file = tmp_path / "questionnaires.csv"
    write_csv(file, ("participant", *columns, "item", "response"), rows)
    with pytest.raises(InputError, match="the column 'condition' is missing"):
        build_report(file, out=tmp_path / "r")
