"""No interval of a report ends where no value can be."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.report import Study, build_report, foreign, write_csv
from vrcomfort.records import RatingRow
from vrcomfort.report.possible import Possible, limited
from vrcomfort.stats.means import MeanInterval

PLAN = """\
name = "p"
title = "P"
outcomes = ["T", "ratings.area"]
[[contrasts]]
a = "a"
b = "b"
[[contrasts]]
a = "a"
b = "b"
test = "paired_t"
[[equivalence]]
outcome = "T"
a = "a"
b = "b"
low = -9.0
high = 9.0
[ratings]
summaries = ["peak", "area", "slope"]
"""
MOST = 235.62
SCORES = {"P1": (0, 48), "P2": (0, 1), "P3": (1, 0), "P4": (0, 48), "P5": (2, 0), "P6": (0, 46)}


def rated(folder: Path) -> Path:
    """Return a study of six very different people, rated every 20 s on the FMS."""
    study = Study(folder)
    study.describe("tiny", a="a", b="b")
    for place, (name, scores) in enumerate(SCORES.items()):
        order = list(zip("ab", "xx", scores, strict=True))[:: 1 - 2 * (place % 2)]
        path = study.session(name, 1, None, order)
        rows = [
            {"participant": name, "session": 1, "trial": trial, "condition": order[trial - 1][0],
             "onset_s": 100.0 * trial + at, "latency_s": 1.0, "instrument": "fms",
             "response": 20 if order[trial - 1][2] > 40 else place * (at // 20) % 6, "missed": 0}
            for trial in (1, 2) for at in range(10, 90, 20)
        ]  # fmt: skip
        write_csv(path / "ratings.csv", RatingRow.columns(), rows)
        study.person(name, "ab")
    return folder


def results_of(tmp_path: Path, source: Path, plan: str) -> dict[str, Any]:
    file = tmp_path / "plan.toml"
    file.write_text(plan, "utf-8")
    summary = build_report(source, plan=file, out=tmp_path / "o")
    found: dict[str, Any] = json.loads(summary.results.read_text("utf-8"))
    return found


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("possible")
    return results_of(folder, rated(folder / "s"), PLAN)


def test_intervals_of_scores_end_within_the_scale(found: dict[str, Any]) -> None:
    of_means = [
        (row["mean_low"], row["mean_high"])
        for row in found["descriptives"]
        if row["by"] == "primary" and row["outcome"] == "T" and row["mean_low"] is not None
    ]
    (t_test,) = (row for row in found["comparisons"] if row["outcome"] == "T")
    (same,) = found["equivalence"]
    (model,) = (row for row in found["mixed_models"] if row["outcome"] == "T")
    assert of_means
    assert all(0 <= low <= high <= MOST + 1e-9 for low, high in of_means)
    assert max(high for _, high in of_means) == pytest.approx(MOST)
    differences = [
        found["tests"][0]["t_test"], t_test["difference"], same,
        *model["terms"].values(), *model["pairwise"]["condition"].values(),
    ]  # fmt: skip
    for each in differences:
        low = -MOST if each["low"] is None else each["low"]
        assert -MOST - 1e-9 <= low <= each["high"] <= MOST + 1e-9
    assert min(each["low"] for each in differences if each["low"] is not None) == pytest.approx(
        -MOST
    )


def test_intervals_of_ratings_end_within_their_scale(found: dict[str, Any]) -> None:
    models = {each["summary"]: each for each in found["ratings"]["models"]}
    for summary, most in (("peak", 20.0), ("area", 20.0)):  # a minute of 20
        means = models[summary]["means"]["condition"].values()
        assert all(0 <= each["low"] <= each["high"] <= most for each in means), summary
        assert any(each["low"] == 0 or each["high"] == most for each in means), summary
    (outcome,) = (each for each in found["outcomes"] if each["name"] == "ratings.area")
    assert (outcome["low"], outcome["high"]) == (0, 20 * 60)
    assert any(each["low"] < 0 for each in models["slope"]["means"]["condition"].values())
    assert all(0 <= p["low"] <= p["high"] <= 20 for p in found["ratings"]["curves"] if p["low"])


def test_what_a_lab_calls_by_its_own_name_has_no_limit(tmp_path: Path) -> None:
    source = foreign(
        tmp_path / "s" / "questionnaires.csv", {f"P{i}": {"a": i, "b": 2} for i in range(8)}
    )
    rows = [
        {"participant": f"P{i}", "condition": c, "bias": (i % 3) ** 4 * (c == "a")}
        for i in range(8) for c in "ab"
    ]  # fmt: skip
    write_csv(tmp_path / "s" / "tasks.csv", ("participant", "condition", "bias"), rows)
    plan = 'name = "p"\ntitle = "P"\noutcomes = ["tasks.bias"]\n'
    results = results_of(tmp_path, source.parent, plan)
    assert [(each["low"], each["high"]) for each in results["outcomes"]] == [(None, None)]
    lows = [row["mean_low"] for row in results["descriptives"] if row.get("mean_low") is not None]
    assert min(lows) < 0


def test_the_end_of_an_interval_beyond_a_limit_is_the_limit() -> None:
    wide = MeanInterval(-45.43, 2000.0)
    assert limited(wide, Possible(1485.0, None)) == MeanInterval(1485.0, 2000.0)
    assert limited(MeanInterval(None, 3.0), Possible(0.0, 2.0)) == MeanInterval(None, 2.0)
    assert limited(wide, Possible()) is wide
    assert limited(MeanInterval(-0.9, -0.1), Possible(0.0, 9.0)) == MeanInterval(None, None)
    assert limited(MeanInterval(0.0, 0.0), Possible(0.0, 9.0)) == MeanInterval(0.0, 0.0)
    assert limited(None, Possible(0.0, 1.0)) is None
    assert Possible(1.0, 4.0).difference == Possible(-3.0, 3.0)
    assert Possible(0.0, None).difference == Possible()
