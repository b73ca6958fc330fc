"""Reports of whole study folders."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.report import (
    ONE_SCORE,
    Study,
    analysed,
    answers,
    build_report,
    carnegie_like,
    contents,
    foreign,
    manifest,
    planned_report,
    results_of,
)
from tests.support.resume import go
from tests.support.study import Scripted
from vrcomfort.questionnaire import score, score_file, shipped_instruments
from vrcomfort.report.study_data import trial_s
from vrcomfort.stats.signed_rank import signed_rank


def total_raw(total: int) -> int:
    found = score(shipped_instruments()["ssq"], answers(total))["T"]
    assert found is not None
    return found.raw


@pytest.fixture(scope="module")
def carnegie(tmp_path_factory) -> tuple[dict, Path]:
    folder = tmp_path_factory.mktemp("carnegie")
    carnegie_like(folder / "study")
    made = build_report(folder / "study", out=folder / "out")
    return results_of(made), folder


def test_the_plan_of_the_protocol_is_taken(carnegie):
    results, _ = carnegie
    assert results["plan"]["name"] == "carnegie_2015"
    assert results["score_basis"] == "difference_from_baseline"
    assert [(t["a"], t["b"], t["outcome"]) for t in results["tests"]] == [
        ("dof_off", "dof_on", outcome) for outcome in "TNOD"
    ]


def test_primary_analysis_has_those_with_every_exposure(carnegie):
    results, _ = carnegie
    assert results["participants"]["analysed"] == ["P01", "P02", "P03", "P04", "P06", "P07"]
    left_out = {row["participant"]: row["reason"] for row in results["participants"]["left_out"]}
    assert left_out["P05"].startswith("withdrew in No blur, session 1, exposure 1")
    assert "too sick" in left_out["P05"]
    assert left_out["P08"].startswith("stop rule in Blur, session 2")
    assert results["participants"]["exposures_per_condition"] == {"dof_off": 2, "dof_on": 2}


def test_a_protocol_that_changed_during_the_study_is_told(tmp_path):
    study = Study(tmp_path / "study")
    study.describe("tiny", a="A", b="B")
    for name, text in (("P1", "aa"), ("P2", "bb"), ("P3", "aa")):
        study.person(name, "ab")
        order = [("a", "room", 5), ("b", "room", 4)][:: 1 if text == "aa" else -1]
        folder = study.session(name, 1, 2, order)
        protocol = {"name": "tiny", "sha256": text}
        (folder / "manifest.json").write_text(manifest(name, protocol=protocol))
    summary = planned_report(study.folder, out=tmp_path / "out")
    changed = "the protocol changed during the study: its sessions hold 2 versions of it"
    assert changed in summary.warnings
    assert "hold 2 versions" in summary.index.read_text("utf-8")


def test_whom_the_experimenter_excluded_is_in_no_analysis(tmp_path):
    study = carnegie_like(tmp_path / "study")
    study.people[1] |= {"status": "excluded", "note": "fell asleep"}
    study.person("P09", "off", "enrolled")
    lines = 'outcomes = ["T"]\nanova = []\n'
    results = results_of(planned_report(study.folder, out=tmp_path / "out", lines=lines))
    assert "P02" not in results["participants"]["analysed"]
    reasons = {row["participant"]: row["reason"] for row in results["participants"]["left_out"]}
    assert reasons["P02"] == "excluded by the experimenter (fell asleep)"
    assert "P02" not in (tmp_path / "out" / "tables" / "scores.csv").read_text("utf-8")
    assert results["mixed_models"][0]["n_participants"] == 6  # not P02, nor P05 without answers


def test_differences_are_taken_on_integers_and_tests_match_the_statistics(carnegie):
    results, _ = carnegie
    expected = []
    for i in (0, 1, 2, 3, 5, 6):
        base, off, on = i % 3, 4 + i % 4, 1 + i % 3
        sums = [
            total_raw(base + off) + total_raw(base + off + (i % 2)),
            total_raw(base + on) + total_raw(base + on + (1 - i % 2)),
        ]
        expected.append(sums[0] - sums[1])
    test = signed_rank(expected, 3.74 / 2)
    found = results["tests"][0]
    assert found["p"] == pytest.approx(test.p, rel=1e-9)
    assert found["z"] == pytest.approx(test.z, rel=1e-9)
    assert found["shift"]["estimate"] == pytest.approx(test.shift.estimate)
    assert found["descriptives"]["difference"]["mean"] == pytest.approx(
        sum(expected) / len(expected) * 3.74 / 2
    )


def test_holm_is_over_the_family(carnegie):
    results, _ = carnegie
    for test in results["tests"]:
        assert test["p"] <= test["p_holm"] <= min(1, 4 * test["p"]) + 1e-12


def test_withdrawals_are_counted_by_condition_order_and_position(carnegie):
    found = carnegie[0]["withdrawals"]
    assert [w["participant"] for w in found["list"]] == ["P05", "P08"]
    assert [w["after_s"] for w in found["list"]] == [40.0, 40.0]
    during = {row["level"]: row["during"] for row in found["by_condition"]}
    assert during == {"dof_off": 1, "dof_on": 1}
    first = found["by_first_condition"]
    assert [(r["level"], r["participants"], r["withdrawals"]) for r in first["rows"]] == [
        ("dof_off", 4, 1), ("dof_on", 4, 1),
    ]  # fmt: skip
    assert first["fisher_p"] == 1.0
    positions = [row["level"] for row in found["by_position"]]
    assert positions[0] == "session 1, exposure 1"


def test_sensitivity_adds_who_was_lost(carnegie):
    lines = [s for s in carnegie[0]["sensitivity"] if s["outcome"] == "T"]
    assert [line["n"] for line in lines] == [7, 8, 8]
    primary = carnegie[0]["tests"][0]["p"]
    assert lines[2]["p"] > primary


def test_anova_crosses_blur_and_scene(carnegie):
    total = carnegie[0]["anova"][0]
    assert total["factors"] == {"depth of field": ["off", "on"], "scene": ["mountain", "temple"]}
    assert [e["effect"] for e in total["effects"]] == [
        "depth of field", "scene", "depth of field × scene",
    ]  # fmt: skip
    assert total["n"] == 6


def test_order_effects_are_reported(carnegie):
    crossover = carnegie[0]["crossover"][0]
    assert (crossover["n_ab"], crossover["n_ba"]) == (3, 3)
    terms = carnegie[0]["mixed_models"][0]["terms"]
    assert set(terms) == {
        "condition: dof_off − dof_on", "scene: temple − mountain", "position: 2 − 1",
        "session: 2 − 1",
    }  # fmt: skip


def test_page_is_self_contained_and_complete(carnegie):
    page = (carnegie[1] / "out" / "index.html").read_text("utf-8")
    assert not re.search(r'<(script src|link|img|iframe)\b|url\(["\']?http|src=', page)
    assert "No blur minus Blur" in page
    for words in ("Holm", "Pratt", "Greenhouse", "withdrew", "P05", "3.74"):
        assert words in page
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids))


@pytest.mark.slow
def test_same_input_gives_the_same_bytes(tmp_path):
    study = carnegie_like(tmp_path / "study").folder
    for name in ("one", "other"):
        build_report(study, out=tmp_path / name, forms=("svg",))
    page = (tmp_path / "one" / "index.html").read_text("utf-8")
    assert page.count("<figure>") == page.count('role="img"') == 9
    assert contents(tmp_path / "one") == contents(tmp_path / "other")


@pytest.mark.slow
def test_reports_need_no_graphics():
    code = "import sys, vrcomfort.report; print({'moderngl', 'OpenGL', 'xr'} & set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "set()"


def test_withdrawal_at_a_question_is_of_the_exposure_before(tmp_path):
    study = carnegie_like(tmp_path / "s")
    study.session("P09", 1, 1, [("dof_off", "temple", None)])
    study.person("P09", "off", "withdrawn", "session 1: stopped at the question nausea")
    results = analysed(tmp_path / "s", ONE_SCORE)
    last = results["withdrawals"]["list"][-1]
    assert (last["participant"], last["condition"], last["how"]) == (
        "P09", "dof_off", "after the exposure",
    )  # fmt: skip
    assert {r["level"]: r["after"] for r in results["withdrawals"]["by_condition"]}["dof_off"] == 1


def test_session_without_baseline_is_left_out_with_the_reason(tmp_path):
    study = Study(tmp_path / "s")
    for i, name in enumerate(("P1", "P2", "P10")):
        study.session(name, 1, None if name == "P2" else 1, [("a", "x", 3 + i), ("b", "x", 2)])
    results = analysed(tmp_path / "s", ONE_SCORE)
    assert results["participants"]["analysed"] == ["P1", "P10"]
    reasons = [row["reason"] for row in results["quality"]["excluded_questionnaires"]]
    assert reasons == ["no complete baseline to subtract"] * 2


def test_baseline_of_each_condition(tmp_path):
    rows = [
        f"{p},{c},{t},{item},{answer}"
        for p in "123"
        for c, t, total in (
            ("a", "baseline", 2),
            ("a", "post", 6),
            ("b", "baseline", 5),
            ("b", "post", 6),
        )
        for item, answer in answers(total).items()
    ]
    file = tmp_path / "questionnaires.csv"
    file.write_text("participant,condition,timepoint,item,response\n" + "\n".join(rows) + "\n")
    results = analysed(file, ONE_SCORE)
    means = {
        d["condition"]: d["mean"]
        for d in results["descriptives"]
        if (d["outcome"], d["by"]) == ("T", "primary")
    }
    assert means["a"] == pytest.approx(3.74 * (total_raw(6) - total_raw(2)))
    assert means["b"] == pytest.approx(3.74 * (total_raw(6) - total_raw(5)))


def test_unequal_numbers_of_exposures_stay_exact(tmp_path):
    study = Study(tmp_path / "s")
    for i in range(4):
        study.session(
            f"P{i}", 1, 0, [("a", "x", 3), ("a", "y", 4), ("a", "z", 5), ("b", "x", 2 + i)]
        )
    (found,) = analysed(tmp_path / "s", ONE_SCORE)["tests"]
    mean = sum(total_raw(t) for t in (3, 4, 5)) / 3 * 3.74
    assert found["descriptives"]["a"]["mean"] == pytest.approx(mean)
    assert found["exposures_per_condition"] == {"a": 3, "b": 1}


def test_three_conditions_add_friedman_and_every_pair(tmp_path):
    scores = {f"P{i}": {"a": 3 + i, "b": 2 * i, "c": 5 + i % 3} for i in range(6)}
    summary = build_report(foreign(tmp_path / "questionnaires.csv", scores), out=tmp_path / "o")
    results = results_of(summary)
    assert [(t["a"], t["b"]) for t in results["tests"][::4]] == [("a", "b"), ("a", "c"), ("b", "c")]
    assert results["friedman"][0]["n"] == 6
    epsilon = results["anova"][0]["effects"][0]["sphericity"]["greenhouse_geisser"]
    corrected = f"<td>{2 * epsilon:.2f}, {10 * epsilon:.2f}</td>"
    assert corrected in summary.index.read_text("utf-8")


def test_a_condition_that_nobody_finished_is_said_and_not_tested(tmp_path):
    study = Study(tmp_path / "study")
    study.describe("carnegie_2015", dof_off="No blur", dof_on="Blur")
    for name in ("P1", "P2", "P3"):
        study.session(name, 1, 2, [("dof_off", "temple", 5), ("dof_on", "mountain", None)])
        study.person(name, "off")
    made = build_report(study.folder, out=tmp_path / "o")
    results = results_of(made)
    assert {t["not_tested"] for t in results["tests"]} == {"0 complete pairs: too few for a test"}
    assert results["crossover"][0]["not_tested"] == "no participant finished both conditions"
    assert "too few for a test" in made.index.read_text("utf-8")


def test_one_condition_is_described_and_not_compared(tmp_path):
    scores = {f"P{i}": {"only": i} for i in range(4)}
    results = results_of(
        build_report(foreign(tmp_path / "questionnaires.csv", scores), out=tmp_path / "o")
    )
    assert results["tests"] == []
    assert results["descriptives"][0]["n"] == 4


# --- What interruptions left, and who was real --------------------------------------------------


def recorded(folder: Path, names: dict[str, str]) -> None:
    """Record the small study: participant → kind of respondent."""
    for name, kind in names.items():
        go(folder, Scripted(name=kind), participant=name)


@pytest.mark.slow
def test_a_questionnaire_that_was_finished_after_an_interruption_is_one(tmp_path):
    go(tmp_path, Scripted(interrupt_at_item="nausea"))
    go(tmp_path, Scripted(), resume=True)
    results = analysed(tmp_path / "S")
    assert results["quality"]["excluded_questionnaires"] == []
    assert results["quality"]["questionnaires"] == 5, "two baselines, two posts, one recovery"


def test_an_exposure_after_which_nothing_was_asked_is_told(tmp_path):
    go(tmp_path, Scripted())
    file = tmp_path / "S/sub-P01/ses-1/questionnaires.csv"
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(line for line in lines if not line.startswith("P01,1,1,1,1,")))
    summary = planned_report(tmp_path / "S", out=tmp_path / "out")
    missing = results_of(summary)["quality"]["excluded_questionnaires"]
    assert [row["reason"] for row in missing] == ["no question was answered after this exposure"]
    assert any("no question was answered" in warning for warning in summary.warnings)
    assert "no question was answered" in summary.index.read_text()


@pytest.mark.slow
def test_real_and_simulated_participants_are_kept_apart(tmp_path):
    recorded(tmp_path, {"P01": "scripted", "P02": "scripted", "P03": "simulated"})
    real = build_report(tmp_path / "S", out=tmp_path / "real")
    assert real.participants == 2
    assert any("2 real and 1 simulated" in warning for warning in real.warnings)
    assert "P03" not in (tmp_path / "real" / "results.json").read_text()
    simulated = build_report(tmp_path / "S", out=tmp_path / "simulated", simulated=True)
    assert simulated.participants == 1


def test_what_is_reported_of_a_frozen_exposure_is_its_live_time(tmp_path):
    trial = {"start_s": "10", "end_s": "20", "live_s": "4.5"}
    assert trial_s(trial) == 4.5
    assert trial_s({**trial, "live_s": ""}) == 10.0
    assert trial_s({}) is None


def test_scores_of_a_session_that_was_resumed_have_each_questionnaire_once(tmp_path):
    go(tmp_path, Scripted(interrupt_at_item="nausea"))
    go(tmp_path, Scripted(), resume=True)
    rows = score_file(
        tmp_path / "S/sub-P01/ses-1/questionnaires.csv",
        shipped_instruments()["ssq"],
        coded_from=0,  # all of them are 1
    ).rows
    moments = [row["timepoint"] for row in rows]
    assert moments == ["baseline", "post", "baseline", "post", "recovery"]
    assert all(row["total"] is not None for row in rows)
