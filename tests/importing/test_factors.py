"""Conditions that are every combination of two factors, in columns or in headings."""

from __future__ import annotations

import json
import random
import re
from itertools import product
from pathlib import Path

import pytest

from tests.support.layouts import ENGLISH, write
from tests.support.report import build_report
from vrcomfort.errors import InputError
from vrcomfort.importing import import_files, load_mapping, write_study
from vrcomfort.importing.mapping import MappingFile
from vrcomfort.importing.suggest import Suggestion, suggest_mapping

RANDOM = random.Random(9)  # noqa: S311
MOVES, VIEWS = ("Teleport", "Joystick"), ("60", "110")
LEVELS = {f"{m}_{v}": (m, v) for m in MOVES for v in VIEWS}


def ssq() -> list[int]:
    return [RANDOM.choice((0, 0, 1, 2, 3)) for _ in ENGLISH]


def confirmed(found: Suggestion, folder: Path) -> MappingFile:
    file = folder / "map.toml"
    file.write_text(re.sub('answer = ""', 'answer = "yes"', found.text), encoding="utf-8")
    return load_mapping(file)


def in_rows(move: str, view: str) -> list[list[object]]:
    rows: list[list[object]] = [["id", "trial", move, view, *ENGLISH]]
    for n in range(1, 13):
        cells = RANDOM.sample([*LEVELS.values()], 4)
        rows += [[f"P{n}", k, *cell, *ssq()] for k, cell in enumerate(cells, start=1)]
    return rows


@pytest.mark.parametrize("move", ["Locomotion", "Bewegung"])
def test_two_columns_are_factors_of_the_conditions(tmp_path: Path, move: str) -> None:
    mapping = confirmed(
        suggest_mapping([write(tmp_path / "study.csv", in_rows(move, "Sichtfeld"))]), tmp_path
    )
    assert mapping.mapping.condition_levels == {
        name: {move: m, "Sichtfeld": v} for name, (m, v) in LEVELS.items()
    }


def test_factors_of_conditions_are_those_of_the_analysis(tmp_path: Path) -> None:
    file = write(tmp_path / "study.csv", in_rows("Bewegung", "Sichtfeld"))
    mapping = confirmed(suggest_mapping([file]), tmp_path)
    imported = import_files([file], mapping.mapping)
    assert {*imported.conditions} == {*LEVELS}
    study, out = tmp_path / "study", tmp_path / "report"
    write_study(study, imported, mapping, [file])
    build_report(study, out=out)
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    effects = [each["effect"] for each in results["anova"][0]["effects"]]
    assert effects == ["Bewegung", "Sichtfeld", "Bewegung × Sichtfeld"]


def test_conditions_in_headings_are_crossed(tmp_path: Path) -> None:
    head = ["id", *(f"{name}_{item}" for name in LEVELS for item in ENGLISH)]
    rows = [[f"P{n}", *(answer for _ in LEVELS for answer in ssq())] for n in range(1, 9)]
    found = suggest_mapping([write(tmp_path / "wide.csv", [head, *rows])])
    assert confirmed(found, tmp_path).mapping.condition_levels == {
        name: {"Teleport/Joystick": m, "60/110": v} for name, (m, v) in LEVELS.items()
    }


def test_conditions_that_are_not_every_combination_have_no_factors(tmp_path: Path) -> None:
    names = ["Teleport_60", "Teleport_110", "Joystick_60"]
    head = ["id", *(f"{name}_{item}" for name in names for item in ENGLISH)]
    rows = [[f"P{n}", *(answer for _ in names for answer in ssq())] for n in range(1, 9)]
    found = suggest_mapping([write(tmp_path / "wide.csv", [head, *rows])])
    assert "condition_levels" not in found.text


def test_a_factor_between_people_beside_one_within_is_their_group(tmp_path: Path) -> None:
    rows = [
        [f"P{n}", MOVES[n % 2], view, *ssq()] for n in range(1, 13) for view in ("small", "large")
    ]
    file = write(tmp_path / "x.csv", [["id", "Locomotion", "FOV", *ENGLISH], *rows])
    found = suggest_mapping([file]).imported
    assert found is not None
    assert {*found.conditions} == {"small", "large"}
    assert {n: p["group"] for n, p in found.participants.items()} == {
        f"P{n}": MOVES[n % 2] for n in range(1, 13)
    }


def test_a_count_of_repetitions_is_no_factor(tmp_path: Path) -> None:
    rows = [[f"P{n}", m, k, *ssq()] for n in range(1, 9) for m in MOVES for k in (1, 2)]
    file = write(tmp_path / "x.csv", [["id", "Locomotion", "Rep", *ENGLISH], *rows])
    found = suggest_mapping([file]).imported
    assert found is not None
    assert {*found.conditions} == {*MOVES}


def test_levels_of_a_condition_that_nobody_had_are_refused(tmp_path: Path) -> None:
    file = write(tmp_path / "study.csv", in_rows("Locomotion", "FOV"))
    text = suggest_mapping([file]).text.replace("Teleport_60 =", "Teleport_06 =")
    (tmp_path / "map.toml").write_text(re.sub('answer = ""', 'answer = "y"', text), "utf-8")
    mapping = load_mapping(tmp_path / "map.toml").mapping
    with pytest.raises(InputError, match="no answer is of a condition `Teleport_06`"):
        import_files([file], mapping)


def test_three_crossed_columns_are_three_factors(tmp_path: Path) -> None:
    cells = list(product(MOVES, VIEWS, ("calm", "busy")))
    rows = [[f"P{n}", *cell, *ssq()] for n in range(1, 9) for cell in cells]
    file = write(tmp_path / "x.csv", [["id", "Locomotion", "Sichtfeld", "Umfeld", *ENGLISH], *rows])
    levels = confirmed(suggest_mapping([file]), tmp_path).mapping.condition_levels
    assert {tuple(each) for each in levels.values()} == {("Locomotion", "Sichtfeld", "Umfeld")}
    assert {tuple(each.values()) for each in levels.values()} == {*cells}


def test_levels_with_decimals_are_a_factor_and_what_says_the_same_is_left_out(tmp_path: Path):
    levels = {"0": "3", "3.5": "1", "4": "2.5"}
    rows: list[list[object]] = [["id", "Model", "GR", "TR", "Rating"]]
    for n in range(1, 13):
        shown = RANDOM.sample([*product(("loot", "dancer"), levels)], 6)
        rows += [[f"P{n}", m, level, levels[level], RANDOM.randint(1, 5)] for m, level in shown]
    found = suggest_mapping([write(tmp_path / "ratings.csv", rows)])
    assert found.imported is not None
    assert {*found.imported.conditions} == {f"{m}_{v}" for m in ("loot", "dancer") for v in levels}
    assert "Are conditions made of 'Model', 'GR' together?" in found.doubts[0]
    assert any("May 'TR' be left out" in doubt for doubt in found.doubts)


def test_factors_of_which_everybody_had_the_same_cells_are_one_condition(tmp_path: Path) -> None:
    """At 5 m the quality changes in half of the cells; two things were also seen from 2 m."""
    cells = [*product(("loot", "dancer"), ("r1", "r5"), ("r1", "r5"), ("5",))]
    cells += [(thing, r, r, "2.5") for thing in ("soldier", "red") for r in ("r1", "r5")]
    rows = [
        [f"P{n}", *cell, {"r1": 32, "r5": 16}[cell[1]], RANDOM.randint(1, 7)]
        for n in range(1, 13)
        for cell in RANDOM.sample(cells, len(cells))
    ]
    heads = ["id", "object", "start_quality", "end_quality", "distance", "start_qp", "qoe"]
    found = suggest_mapping([write(tmp_path / "ratings.csv", [heads, *rows])]).imported
    assert found is not None
    assert len({*found.conditions}) == len(cells)
