"""Imports are handed on like recorded studies: exports, anonymous copies, checksums."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest

from tests.support.exchange import errors_of
from tests.support.psych_ds import errors
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.bids import export_bids
from vrcomfort.exchange.imports import labels_of
from vrcomfort.exchange.psych_ds import export_psych_ds
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.importing import import_files, load_mapping, write_study
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.records.choice import Choice

SSQ = [item.name for item in shipped_instruments()["ssq"].items]
MAPPING = """
format_version = 1
name = "Two rooms"

[[tables]]
files = ["*.csv"]
participant = { column = "code" }
condition = { column = "room" }
participants = { age = "age" }

[[tables.questionnaires]]
instrument = "ssq"
heading = "{item}"
timepoint = "post"
"""


def table(file: Path, delimiter: str = "\t") -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream, delimiter=delimiter))


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an import whose participants have names that BIDS does not take."""
    place = tmp_path_factory.mktemp("answers")
    people = ("VP_1", "VP-1", "vp1")
    rows = [
        f"{who},{room},{20 + at},{','.join(str((at + n) % 4) for n in range(len(SSQ)))}"
        for at, who in enumerate(people)
        for room in ("blue room", "red")
    ]
    (place / "lab.csv").write_text("\n".join([f"code,room,age,{','.join(SSQ)}", *rows, ""]))
    (place / "map.toml").write_text(MAPPING)
    return imported(place / "map.toml", [place / "lab.csv"], place / "study")


def imported(mapping: Path, files: list[Path], study: Path) -> Path:
    loaded = load_mapping(mapping)
    write_study(study, import_files(files, loaded.mapping, loaded.instruments), loaded, files)
    return study


@pytest.fixture(scope="module")
def ratings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an import of published ratings (tests/data/fms), those of a few participants."""
    data, place = Path("tests/data/fms"), tmp_path_factory.mktemp("ratings")
    head, *rows = (data / "ratings.csv").read_text().splitlines(keepends=True)
    people = sorted({row.partition(",")[0] for row in rows})[::12]
    kept = (row for row in rows if row.partition(",")[0] in people)
    (place / "ratings.csv").write_text("".join([head, *kept]))
    mapping = (data / "mapping.toml").read_text().splitlines(keepends=True)
    text = "".join(line for line in mapping if not line.startswith("condition_labels"))
    (place / "mapping.toml").write_text(text)
    return imported(place / "mapping.toml", [place / "ratings.csv"], place / "study")


@pytest.mark.parametrize("name", ["answers", "ratings"])
def test_imports_and_their_anonymous_copies_are_valid_datasets(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    study = request.getfixturevalue(name)
    record = anonymise(study, tmp_path / "copy", AnonymisingOptions(seed=1))
    assert json.loads((tmp_path / "copy" / "anonymised.json").read_text()) == record
    for source in (study, tmp_path / "copy"):
        assert verify_study(source).findings == []
        out = tmp_path / f"{source.name}_bids"
        assert export_bids(source, out) == []
        assert errors_of(out) == []
        export_psych_ds(source, tmp_path / f"{source.name}_psych_ds")
        assert not errors(tmp_path / f"{source.name}_psych_ds")


def test_each_answer_is_in_the_phenotype_table_of_its_participant(
    answers: Path, tmp_path: Path
) -> None:
    export_bids(answers, tmp_path / "bids")
    labels = {row["participant"]: row["participant_id"] for row in
              table(tmp_path / "bids" / "participants.tsv")}  # fmt: skip
    assert labels == {"VP_1": "sub-VP1", "VP-1": "sub-VP11", "vp1": "sub-vp12"}
    rows = {
        row["participant_id"]: row for row in table(tmp_path / "bids" / "phenotype" / "ssq.tsv")
    }
    said = json.loads((tmp_path / "bids" / "phenotype" / "ssq.json").read_text())
    given = table(answers / "questionnaires.csv", ",")
    assert len(given) == 3 * 2 * 16
    for row in given:
        column = f"condition-{row['condition'].replace(' ', '-')}_post_{row['item']}"
        assert rows[labels[row["participant"]]][column] == row["response"]
        assert row["condition"] in said[column]["Description"]


def test_each_rating_is_in_the_table_of_its_participant(ratings: Path, tmp_path: Path) -> None:
    export_bids(ratings, tmp_path / "bids")
    given = table(ratings / "ratings.csv", ",")
    found = [row for file in (tmp_path / "bids").rglob("*_beh.tsv") for row in table(file)]
    assert len(found) == len(given) > 1000
    sums = [sum(float(row["response"]) for row in rows if row["response"] not in {"", "n/a"})
            for rows in (given, found)]  # fmt: skip
    assert sums[0] == pytest.approx(sums[1])


def test_an_anonymous_copy_names_nobody_and_lists_what_stays(answers: Path, tmp_path: Path) -> None:
    key = tmp_path / "key.csv"
    record = anonymise(answers, tmp_path / "copy", AnonymisingOptions(seed=2, key=key))
    files = [file for file in (tmp_path / "copy").rglob("*") if file.is_file()]
    assert not any(b"VP" in file.read_bytes() or b"vp1" in file.read_bytes() for file in files)
    assert not any("lab.csv" in file.read_text() for file in files)
    new = {row["participant"]: row["anonymous"] for row in table(key, ",")}
    for name in ("participants.csv", "questionnaires.csv"):
        columns = record["still_there"]["columns"][name]
        there = table(tmp_path / "copy" / name, ",")
        assert {column for row in there for column in row if row[column]} <= set(columns)
        was = [
            {**row, "participant": new[row["participant"]]} for row in table(answers / name, ",")
        ]
        kept = [{c: row[c] for c in columns} for row in was]
        stays = [{c: row[c] for c in columns} for row in there]
        assert sorted(kept, key=str) == sorted(stays, key=str)
    assert record["still_there"]["columns"]["participants.csv"]["age"] == "covariate"
    assert record["still_there"]["smallest_group_with_the_same_covariates"] == 1


def test_labels_have_letters_and_digits_and_differ() -> None:
    names = ["a_1", "a1", "A1", "ä", "_", "a11"]
    labels = labels_of(names)
    assert all(label.isalnum() and label.isascii() for label in labels.values())
    assert len({label.lower() for label in labels.values()}) == len(names)


def test_a_table_of_an_import_that_is_gone_is_told(answers: Path, tmp_path: Path) -> None:
    study = Path(shutil.copytree(answers, tmp_path / "study"))
    (study / "questionnaires.csv").unlink()
    (fault,) = map(str, verify_study(study).faults)
    assert fault == "questionnaires.csv: is missing; restore it from a copy, or import again"


def test_an_import_whose_list_of_participants_is_empty_is_copied(
    answers: Path, tmp_path: Path
) -> None:
    study = Path(shutil.copytree(answers, tmp_path / "study"))
    people = study / "participants.csv"
    people.write_text(people.read_text().splitlines(keepends=True)[0])
    (study / "questionnaires.csv").unlink()
    (study / "checksums.sha256").unlink()
    record = anonymise(study, tmp_path / "copy", AnonymisingOptions(seed=1))
    assert record["still_there"]["smallest_group_with_the_same_covariates"] is None
    assert export_bids(study, tmp_path / "bids") == []


def test_answers_of_somebody_who_is_not_in_the_list_are_exported_where_that_is_accepted(
    answers: Path, tmp_path: Path
) -> None:
    study = Path(shutil.copytree(answers, tmp_path / "study"))
    people = study / "participants.csv"
    people.write_text("".join(people.read_text().splitlines(keepends=True)[:3]))
    accepted = Choice(accept_flagged=True)
    with pytest.raises(InputError, match="does not list vp1"):
        export_bids(study, tmp_path / "refused")
    assert export_bids(study, tmp_path / "bids", accepted) == []
    rows = {row["participant"]: row["age"] for row in table(tmp_path / "bids/participants.tsv")}
    assert rows == {"VP_1": "20", "VP-1": "21", "vp1": "n/a"}
    anonymise(study, tmp_path / "copy", AnonymisingOptions(seed=1), accepted)
    assert len(table(tmp_path / "copy/questionnaires.csv", ",")) == 3 * 2 * 16
