"""Extremes of data, each through a report with a plan: a defined result, and a word why."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support.report import HEAD, ITEMS, ONE_SCORE, foreign, planned_report, results_of
from vrcomfort.errors import InputError
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.results import analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study
from vrcomfort.stats.anova import anova
from vrcomfort.stats.mixed import mixed_model

PLAN = """\
scores = "raw"
outcomes = ["T", "N", "O", "D"]
[[contrasts]]
a = "a"
b = "b"
[[families]]
name = "all"
outcomes = ["T", "N", "O", "D"]
analyses = ["tests", "anova"]
[[anova]]
name = "condition"
column = "condition"
"""


RATED = PLAN.replace('["T", "N", "O", "D"]', '["fms"]')


def rated(file: Path, answers: list[tuple[object, object]], instrument: str = "fms") -> Path:
    """One file with a single-item scale: participant → answers under a and b."""
    lines = [
        f"P{i},{c},{instrument},{x},{instrument}"
        for i, pair in enumerate(answers)
        for c, x in zip("ab", pair, strict=True)
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(["participant,condition,item,response,instrument", *lines]) + "\n")
    return file


def report(source: Path, tmp_path: Path, plan: str = PLAN) -> tuple[dict, str]:
    """Return results.json and the page."""
    summary = planned_report(source, out=tmp_path / "out", lines=plan)
    return results_of(summary), summary.index.read_text("utf-8")


def people(n: int, a, b) -> dict[str, dict[str, int]]:
    return {f"P{i:03d}": {"a": a(i), "b": b(i)} for i in range(n)}


def kinds(results: dict) -> set[str]:
    return {found["kind"] for found in results["deviations"]}


def test_all_zeros(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", people(9, lambda _: 0, lambda _: 0))
    results, _ = report(file, tmp_path)
    for test in results["tests"]:
        assert (test["p"], test["z"], test["effect"], test["t_test"]) == (1.0, None, None, None)
        assert (test["shift"]["estimate"], test["shift"]["low"], test["shift"]["high"]) == (0, 0, 0)
    assert all(effect["f"] is None for found in results["anova"] for effect in found["effects"])
    assert "no variance" in results["mixed_models"][0]["not_tested"]
    assert kinds(results) == {"not_tested"}


def test_all_differences_alike(tmp_path):
    file = rated(tmp_path / "questionnaires.csv", [(i + 2, i) for i in range(8)])
    results, _ = report(file, tmp_path, RATED)
    test = results["tests"][0]
    assert test["p"] == pytest.approx(2 / 2**8)
    assert (test["shift"]["low"], test["shift"]["estimate"], test["shift"]["high"]) == (2, 2, 2)
    assert test["t_test"] is None, "no difference varies"
    assert results["anova"][0]["effects"][0]["f"] is None


@pytest.mark.parametrize("n", [1, 2])
def test_very_few_people(tmp_path, n):
    file = foreign(tmp_path / "questionnaires.csv", people(n, lambda i: 5 + i, lambda _: 2))
    results, page = report(file, tmp_path)
    test = results["tests"][0]
    if n == 1:
        assert test["not_tested"] == "1 complete pair: too few for a test"
        assert "too few for a test" in page
        assert "not_tested" in kinds(results)
    else:
        assert test["p"] == pytest.approx(2 / 2**n)
        assert (test["shift"]["low"], test["shift"]["high"]) == (None, None)
        assert test["p_holm"] >= test["p"]


def test_nobody(tmp_path):
    file = tmp_path / "questionnaires.csv"
    file.write_text("participant,condition,item,response\n")
    with pytest.raises(InputError, match="no answers to a known questionnaire"):
        report(file, tmp_path)


def test_a_condition_that_nobody_met(tmp_path):
    foreign(tmp_path / "s/questionnaires.csv", {f"P{i}": {"a": i + 1} for i in range(5)})
    text = json.dumps({"name": "S", "conditions": {"a": "A", "b": "B"}})
    (tmp_path / "s/dataset_description.json").write_text(text)
    results, page = report(tmp_path / "s", tmp_path)
    assert {t["not_tested"] for t in results["tests"]} == {"0 complete pairs: too few for a test"}
    assert "too few for a test" in page
    assert results["anova"][0]["not_tested"] == "no factor has two levels in the data"
    assert kinds(results) == {"not_tested"}


def grouped(tmp_path: Path, group, a, b) -> Path:
    folder = tmp_path / "s"
    foreign(folder / "questionnaires.csv", people(8, a, b))
    rows = [f"P{i:03d},{group(i)}" for i in range(8)]
    (folder / "participants.csv").write_text("\n".join(["participant,group", *rows]) + "\n")
    return folder


BETWEEN = PLAN + '[[anova]]\nname = "group"\ncolumn = "group"\n'


def test_a_group_whose_scores_are_constant(tmp_path):
    source = grouped(
        tmp_path, lambda i: "xy"[i % 2], lambda i: 0 if i % 2 else i, lambda i: 0 if i % 2 else 3
    )
    results, _ = report(source, tmp_path, BETWEEN)
    total = results["anova"][0]
    assert [e["effect"] for e in total["effects"]] == ["group", "condition", "group × condition"]
    assert all(e["f"] is not None and 0 <= e["p"] <= 1 for e in total["effects"])


def test_a_grouping_with_one_group(tmp_path):
    source = grouped(tmp_path, lambda _: "x", lambda i: i, lambda _: 3)
    results, _ = report(source, tmp_path, BETWEEN)
    assert list(results["anova"][0]["factors"]) == ["condition"]
    assert [d["text"] for d in results["deviations"] if d["kind"] == "factor_left_out"] == [
        "group has one level in the data and is not in the ANOVA"
    ]


def test_perfect_separation(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", people(7, lambda i: 20 + i, lambda i: i // 2))
    (test,) = report(file, tmp_path, ONE_SCORE)[0]["tests"]
    assert (test["effect"]["estimate"], test["effect"]["high"]) == (1.0, 1.0)
    assert test["effect"]["low"] < 1
    assert test["p"] == pytest.approx(2 / 2**7)


def test_the_limits_of_the_scale(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", people(6, lambda _: 48, lambda _: 0))
    results, _ = report(file, tmp_path)
    shifts = {t["outcome"]: t["shift"]["estimate"] for t in results["tests"]}
    assert shifts == pytest.approx({"T": 235.62, "N": 200.34, "O": 159.18, "D": 292.32})
    assert all(effect["f"] is None for found in results["anova"] for effect in found["effects"])


@pytest.mark.slow
def test_thirty_thousand_people(tmp_path):
    answers = [((7 * i + i // 11) % 21, (5 * i + i // 7) % 20) for i in range(30_000)]
    file = rated(tmp_path / "questionnaires.csv", answers)
    results = as_json(analyse(read_study(file), read_plan(HEAD + RATED, None))[0])
    test = results["tests"][0]
    assert (test["n"], test["method"]) == (30_000, "asymptotic")
    assert test["shift"]["low"] <= test["shift"]["estimate"] <= test["shift"]["high"]
    assert "other_method" in kinds(results)
    assert results["anova"][0]["n"] == 30_000


def test_the_largest_offset_that_answers_may_have_changes_nothing(tmp_path):
    answers = [((3 * i) % 8 + 2, (5 * i) % 7) for i in range(10)]
    plain, _ = report(rated(tmp_path / "plain/questionnaires.csv", answers), tmp_path, RATED)
    base = 1_000_000 - 20
    moved = rated(
        tmp_path / "moved/questionnaires.csv", [(base + a, base + b) for a, b in answers], "big"
    )
    (moved.parent / "instruments").mkdir()
    (moved.parent / "instruments/big.toml").write_text(
        f'name = "big"\nshort = "Big"\ntitle = "Big"\ninstruction = "?"\n'
        f'[answers]\nlow = {base}\nhigh = {base + 20}\nlabels = ["low", "high"]\n'
        '[[items]]\nname = "big"\ntext = "Big"\n'
    )
    found, _ = report(moved.parent, tmp_path, RATED.replace('"fms"', '"big"'))
    for name in ("p", "z", "w_plus"):
        assert found["tests"][0][name] == plain["tests"][0][name]
    assert found["tests"][0]["shift"]["estimate"] == plain["tests"][0]["shift"]["estimate"]
    assert found["tests"][0]["t_test"]["t"] == pytest.approx(plain["tests"][0]["t_test"]["t"])
    f = [results["anova"][0]["effects"][0]["f"] for results in (found, plain)]
    assert f[0] == pytest.approx(f[1], rel=1e-9)


def test_offsets_of_nine_digits_change_nothing():
    a = np.array([(3 * i) % 8 + 2 for i in range(10)])
    b = np.array([(5 * i) % 7 for i in range(10)])
    long = pd.DataFrame({
        "who": np.tile(np.arange(10).astype(str), 2), "condition": np.repeat(["a", "b"], 10),
    })  # fmt: skip
    found = []
    for base in (0, 10**9):
        scores = np.concatenate([a, b]) + base
        within = anova(
            long.assign(y=scores.astype(float)), value="y", participant="who", within=["condition"]
        )
        model = mixed_model(
            long.assign(y=scores.astype(float)),
            value="y", participant="who", factors=["condition"],
        )  # fmt: skip
        effect = model.terms["condition: b − a"]
        found.append((within.effects[0].f, effect.estimate, effect.standard_error, effect.p))
    assert found[1] == pytest.approx(found[0], rel=1e-6)


def test_duplicates_are_refused_with_their_place(tmp_path):
    file = foreign(tmp_path / "questionnaires.csv", people(3, lambda i: i, lambda _: 1))
    text = file.read_text()
    file.write_text(text + text.splitlines()[1] + "\n")
    with pytest.raises(InputError, match="answered twice") as caught:
        report(file, tmp_path)
    assert caught.value.line == 2 + 3 * 2 * len(ITEMS)


def test_nan_is_no_answer_and_no_covariate(tmp_path):
    file = foreign(tmp_path / "s/questionnaires.csv", people(3, lambda i: i, lambda _: 1))
    (tmp_path / "s/participants.csv").write_text("participant,age\nP000,NaN\nP001,30\nP002,31\n")
    with pytest.raises(InputError, match="covariate `age` of participant P000 is `NaN`"):
        report(tmp_path / "s", tmp_path, PLAN.replace("scores =", 'covariates = ["age"]\nscores ='))
    file.write_text(file.read_text().replace("P001,a,fatigue,0", "P001,a,fatigue,NaN"))
    with pytest.raises(InputError, match="`NaN` is not a whole number") as caught:
        report(tmp_path / "s", tmp_path)
    assert caught.value.column == "response"
