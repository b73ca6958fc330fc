"""`vrcomfort export --format psych-ds`: the tables are the study's, and the schema's rules hold.

The rules are those of Psych-DS' published schema 1.5.1 that are errors, checked here one by one.
"""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

from tests.support.exchange import with_gaze
from tests.support.resume import go
from tests.support.study import Scripted
from vrcomfort.exchange.psych_ds import export_psych_ds

NAME = re.compile(r"([a-z]+-[a-zA-Z0-9]+)(_[a-z]+-[a-zA-Z0-9]+)*_data\.csv")
KEYWORDS = {
    "study", "site", "subject", "session", "task", "condition", "trial", "stimulus", "description",
}  # fmt: skip


def table(file: Path) -> tuple[list[str], list[list[str]]]:
    with file.open(encoding="utf-8", newline="") as stream:
        header, *rows = list(csv.reader(stream))
    return header, rows


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("study")
    with_gaze(place)
    go(place, Scripted(withdraw_at_s=1.0), participant="P02")
    return place / "S"


@pytest.fixture(scope="module")
def dataset(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("psych") / "dataset"
    assert export_psych_ds(study, out) == []
    return out


def test_every_rule_of_the_schema_that_is_an_error_holds(dataset: Path) -> None:
    said = json.loads((dataset / "dataset_description.json").read_text(encoding="utf-8"))
    assert (said["@context"], said["@type"]) == ("https://schema.org/", "Dataset")
    assert said["name"]
    assert said["description"]
    variables = [each["name"] for each in said["variableMeasured"]]
    assert len(variables) == len(set(variables))
    assert all(each["@type"] == "PropertyValue" for each in said["variableMeasured"])
    columns: set[str] = set()
    for file in (dataset / "data").iterdir():
        assert NAME.fullmatch(file.name)
        assert {part.split("-")[0] for part in file.name.split("_")[:-1]} <= KEYWORDS
        header, rows = table(file)
        assert rows
        assert len(header) == len(set(header)) > 0
        assert {len(row) for row in rows} == {len(header)}
        columns |= set(header)
    assert columns == set(variables)
    assert (dataset / "README.md").stat().st_size


def test_the_tables_are_those_of_the_study(study: Path, dataset: Path) -> None:
    for name in ("trials", "questionnaires", "ratings"):
        header, rows = table(dataset / "data" / f"study-tiny_description-{name}_data.csv")
        recorded = [
            row for file in sorted(study.glob(f"sub-*/ses-*/{name}.csv")) for row in table(file)[1]
        ]
        assert header == table(study / "sub-P01" / "ses-1" / f"{name}.csv")[0]
        assert rows == recorded


def test_every_column_is_described(dataset: Path) -> None:
    said = json.loads((dataset / "dataset_description.json").read_text(encoding="utf-8"))
    for each in said["variableMeasured"]:
        assert "as entered" not in each["description"], each["name"]


def test_notes_stay_out(study: Path, dataset: Path) -> None:
    assert "note" in (study / "participants.csv").read_text().splitlines()[0].split(",")
    header, rows = table(dataset / "data" / "study-tiny_description-participants_data.csv")
    assert "note" not in header
    assert [row[0] for row in rows] == ["P01", "P02"]


def test_the_command_says_what_is_left_out(run, tmp_path: Path) -> None:
    go(tmp_path, Scripted(withdraw_at_s=1.0))
    code, out, err = run(
        "export", tmp_path / "S", "--format", "psych-ds", "--out", tmp_path / "dataset"
    )
    assert code == 0
    assert "study-tiny_description-ratings_data.csv: the study has no rows of it" in err
    assert "a dataset in psych-ds" in out
