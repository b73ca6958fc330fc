"""`vrcomfort export --format psych-ds`: the tables are the study's, and the schema's rules hold.

The rules (tests/support/psych_ds.py) are those of Psych-DS' published schema 1.5.1 that are errors.
"""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.exchange import PRACTICE, with_gaze
from tests.support.psych_ds import CODES, errors
from tests.support.resume import go
from tests.support.study import Scripted
from vrcomfort.exchange.psych_ds import export_psych_ds
from vrcomfort.records.events import EVENTS


def table(file: Path) -> tuple[list[str], list[list[str]]]:
    with file.open(encoding="utf-8", newline="") as stream:
        header, *rows = list(csv.reader(stream))
    return header, rows


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("study")
    with_gaze(place, PRACTICE)
    go(place, Scripted(withdraw_at_s=1.0), participant="P02")
    return place / "S"


@pytest.fixture(scope="module")
def dataset(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("psych") / "dataset"
    assert export_psych_ds(study, out) == []
    return out


def test_every_rule_of_the_schema_that_is_an_error_holds(dataset: Path) -> None:
    assert errors(dataset) == set()
    said = json.loads((dataset / "dataset_description.json").read_text(encoding="utf-8"))
    variables = [each["name"] for each in said["variableMeasured"]]
    assert len(variables) == len(set(variables))
    assert all(each["@type"] == "PropertyValue" for each in said["variableMeasured"])
    tables = [table(file) for file in (dataset / "data").iterdir()]
    assert all(rows for _, rows in tables)
    assert all(len(header) == len(set(header)) for header, _ in tables)
    assert {column for header, _ in tables for column in header} == set(variables)
    assert (dataset / "README.md").stat().st_size


Change = Callable[[Path], object]
TRIALS = "data/study-tiny_description-trials_data.csv"
DESCRIPTION = "dataset_description.json"


def written(name: str, text: str) -> Change:
    return lambda place: (place / name).write_text(text)


def renamed(name: str) -> Change:
    return lambda place: (place / TRIALS).rename(place / "data" / name)


def described(**changes: object) -> Change:
    def change(place: Path) -> None:
        content = json.loads((place / DESCRIPTION).read_text(encoding="utf-8"))
        content.update({key.replace("at_", "@"): value for key, value in changes.items()})
        kept = {key: value for key, value in content.items() if value is not None}
        (place / DESCRIPTION).write_text(json.dumps(kept))

    return change


def with_row_ids(place: Path) -> None:
    written(TRIALS, "row_id\n1\n1\n")(place)
    described(variableMeasured=[{"name": "row_id"}])(place)
    for file in (place / "data").iterdir():
        if file != place / TRIALS:
            file.unlink()


BROKEN: dict[str, Change] = {
    "MISSING_DATASET_DESCRIPTION": lambda place: (place / DESCRIPTION).unlink(),
    "MISSING_DATA_DIRECTORY": lambda place: shutil.rmtree(place / "data"),
    "MISSING_DATAFILE": lambda place: [each.unlink() for each in (place / "data").iterdir()],
    "JSON_INVALID": written(DESCRIPTION, "{"),
    "JSON_ENCODING_ERROR": lambda place: (place / DESCRIPTION).write_bytes(b'{"name": "\xff"}'),
    "JSON_KEY_REQUIRED": described(description=""),
    "INVALID_JSONLD_FORMATTING": described(at_context=None),
    "MISSING_DATASET_TYPE": described(at_type=None),
    "INCORRECT_DATASET_TYPE": described(at_type="Thing"),
    "FILENAME_KEYWORD_FORMATTING_ERROR": renamed("Trials_data.csv"),
    "FILENAME_UNOFFICIAL_KEYWORD_ERROR": renamed("study-tiny_kind-trials_data.csv"),
    "EXTENSION_MISMATCH": renamed("study-tiny_data.tsv"),
    "CSV_HEADER_MISSING": written(TRIALS, ""),
    "CSV_FORMATTING_ERROR": written(TRIALS, 'trial\n"1"2\n'),
    "CSV_HEADER_LENGTH_MISMATCH": written(TRIALS, "trial,condition\n1\n"),
    "ROWID_VALUES_NOT_UNIQUE": with_row_ids,
    "CSV_COLUMN_MISSING_FROM_METADATA": written(TRIALS, "trial,weather\n1,dull\n"),
}


@pytest.mark.parametrize("code", sorted(CODES))
def test_each_rule_finds_a_dataset_that_breaks_it(dataset: Path, tmp_path: Path, code: str) -> None:
    broken = Path(shutil.copytree(dataset, tmp_path / "broken"))
    BROKEN[code](broken)
    assert errors(broken) == {code}


@pytest.mark.smoke
def test_the_tables_are_those_of_the_study(study: Path, dataset: Path) -> None:
    for name in ("trials", "questionnaires", "ratings", "practice"):
        header, rows = table(dataset / "data" / f"study-tiny_description-{name}_data.csv")
        recorded = [
            row for file in sorted(study.glob(f"sub-*/ses-*/{name}.csv")) for row in table(file)[1]
        ]
        assert header == table(study / "sub-P01" / "ses-1" / f"{name}.csv")[0]
        assert rows == recorded
        assert rows


@pytest.mark.parametrize("name", ["frames", "gaze"])
def test_frames_and_gaze_are_files_of_their_session(study: Path, dataset: Path, name: str) -> None:
    file = f"study-tiny_subject-P01_session-1_description-{name}_data.csv"
    assert table(dataset / "data" / file) == table(study / "sub-P01" / "ses-1" / f"{name}.csv")
    assert f"subject-*_session-*_description-{name}_data.csv" in (dataset / "README.md").read_text()
    others = [each.name for each in (dataset / "data").glob(f"*subject-P02*-{name}_data.csv")]
    assert bool(others) == (name == "frames")  # P02 wore a headset without an eye tracker


def test_events_name_their_session_and_keep_private_details_back(
    study: Path, dataset: Path
) -> None:
    header, rows = table(dataset / "data" / "study-tiny_description-events_data.csv")
    events = [dict(zip(header, row, strict=True)) for row in rows]
    sessions = sorted(study.glob("sub-*/ses-*/events.csv"))
    expected = []
    for file in sessions:
        who, session = file.parts[-3].removeprefix("sub-"), file.parts[-2].removeprefix("ses-")
        names, recorded = table(file)
        for row in recorded:
            said = dict(zip(names, row, strict=True))
            kept = "" if EVENTS[said["name"]].private else said["detail"]
            expected.append({"participant": who, "session": session, **said, "detail": kept})
    assert len(sessions) == 3
    assert events == expected
    assert any(each["name"] == "withdrawn" for each in events)


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
