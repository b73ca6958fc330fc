"""Ordinal models of single items: of a plan, on the page, and what a plan may not name."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support.report import ITEMS, analysed, planned_report, write_csv
from vrcomfort.errors import InputError
from vrcomfort.stats.ordinal import ordinal_model

PLAN = """outcomes = ["T"]
mixed_model = []
anova = []
[[ordinal]]
outcome = "nausea"
factors = ["condition", "scene"]
"""
PEOPLE = 14


def answered(folder: Path, *, scenes: tuple[str, ...] = ("hall", "garden")) -> Path:
    """Write a study without baselines in which nausea is stronger under `on`."""
    random = np.random.default_rng(5)
    rows = []
    for person in range(PEOPLE):
        level = random.normal()
        for condition in ("off", "on"):
            for scene in scenes:
                latent = level + 1.5 * (condition == "on") + random.logistic()
                nausea = int(np.digitize(latent, [-0.5, 1.0, 2.5]))
                rows += [
                    {"participant": f"P{person:02d}", "session": 1,
                     "trial": 1 + len(rows) // 16 % 4, "condition": condition,
                     "scene": scene, "timepoint": "post",
                     "instrument": "ssq", "item": item,
                     "response": nausea if item == "nausea" else person % 2}
                    for item in ITEMS
                ]  # fmt: skip
    file = folder / "questionnaires.csv"
    write_csv(file, tuple(rows[0]), rows)
    return folder


@pytest.mark.slow
def test_an_item_of_conditions_and_scenes_has_their_odds_ratios(tmp_path):
    folder = answered(tmp_path / "study")
    (row,) = analysed(folder, PLAN)["ordinal"]
    asked = pd.read_csv(folder / "questionnaires.csv")
    expected = ordinal_model(
        asked[asked["item"] == "nausea"], value="response", participant="participant",
        factors=["condition", "scene"], references={"condition": "off"},
    )  # fmt: skip
    assert (row["instrument"], row["item"], row["n_values"]) == ("ssq", "nausea", 4 * PEOPLE)
    ((name, odds), _) = row["terms"].items()
    one = next(iter(expected.terms.values()))
    sign = 1 if name == "condition: on − off" else -1
    assert odds["estimate"] == pytest.approx(sign * one.estimate)
    assert row["participant_sd"] == pytest.approx(expected.participant_sd)
    assert row["omnibus"]["condition"]["p"] == pytest.approx(expected.omnibus["condition"].p)


def test_a_group_is_a_factor_and_everybody_answers_once(tmp_path):
    folder = tmp_path / "study"
    rows = [
        {"participant": f"P{i:02d}", "condition": "c", "item": item, "response": (i * 7 // 5) % 3}
        for i in range(12)
        for item in ITEMS
    ]
    write_csv(folder / "questionnaires.csv", tuple(rows[0]), rows)
    people = [
        {"participant": f"P{i:02d}", "sequence": "", "status": "completed", "group": "ab"[i % 2]}
        for i in range(12)
    ]
    write_csv(folder / "participants.csv", tuple(people[0]), people)
    text = PLAN.replace('["condition", "scene"]', '["group"]')
    (row,) = analysed(folder, text)["ordinal"]
    assert list(row["terms"]) == ["group: b − a"]
    assert (row["participant_sd"], row["n_participants"]) == (None, 12)


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ('"nausea"', '"nauseous"', r"line 7, column 1: `nauseous` is neither .*`nausea`"),
        ('"scene"]', '"sceen"]', r"line 8.*`sceen` is not a column .*`scene`"),
    ],
)
def test_what_a_plan_may_not_name_is_told_with_its_place(tmp_path, right, wrong, said):
    folder = answered(tmp_path / "study")
    with pytest.raises(InputError, match=said):
        analysed(folder, PLAN.replace(right, wrong))


def test_many_different_values_are_no_ordered_answers(tmp_path):
    folder = answered(tmp_path / "study")
    rows = [
        {"participant": f"P{i:02d}", "condition": "ab"[i % 2], "time": i / 7} for i in range(40)
    ]
    write_csv(folder / "tasks.csv", tuple(rows[0]), rows)
    text = PLAN.replace('["T"]', '["T", "tasks.time"]').replace('"nausea"', '"tasks.time"')
    (row,) = analysed(folder, text)["ordinal"]
    assert row["not_tested"].startswith("it takes 40 different values")


@pytest.mark.slow
def test_the_page_says_odds_ratios_and_their_check(tmp_path):
    folder = answered(tmp_path / "study")
    made = planned_report(folder, out=tmp_path / "report", lines=PLAN)
    page, results = made.index.read_text(), json.loads(made.results.read_text())
    (row,) = results["ordinal"]
    odds = next(iter(row["terms"].values()))
    assert f"{odds['odds_ratio']:.2f}" in page
    assert "One ratio for all answers: χ²" in page
    assert "McCullagh" in page
    assert any("odds ratio of a higher answer" in line for line in made.headlines)
    assert {"ordinal.csv", "ordinal_by_cut.csv"} <= {path.name for path in made.tables}
