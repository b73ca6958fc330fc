"""Whatever is given in the place of a study or a file of answers is refused in one sentence."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.resume import go

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("study")
    go(place)
    return place / "S"


def refusal(run: Call, *words: object) -> str:
    """Return the one sentence with which a command is refused."""
    code, _, err = run(*words)
    assert (code, err.count("\n")) == (2, 1)
    return err


@pytest.mark.parametrize("command", ["status", "verify", "anonymise", "export"])
def test_a_dataset_of_another_format_is_no_damaged_study(run: Call, tmp_path, command) -> None:
    content = {"Name": "Faces", "BIDSVersion": "1.11.1"}
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "dataset_description.json").write_text(json.dumps(content), "utf-8")
    out = {"anonymise": ("--out", tmp_path / "a"), "export": ("--out", tmp_path / "b")}
    form = ("--format", "bids") if command == "export" else ()
    said = refusal(run, command, tmp_path / "d", *out.get(command, ()), *form)
    assert "this describes a dataset, and no study that vrcomfort recorded; give the" in said


def test_a_mistyped_session_is_not_taken_for_a_trace(run: Call, study: Path, tmp_path) -> None:
    mistyped = study / "sub-P01" / "ses-7"
    for options in (("--from-s", "1"), ()):
        said = refusal(run, "play", mistyped, *options, "--out", tmp_path / "o")
        assert said == f"error: {mistyped}: there is no such file or folder\n"


def test_a_pipe_is_no_protocol(run: Call, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    code, _, err = run("design", tmp_path / "pipe.toml")
    assert code == 2
    assert "pipe.toml: this is a pipe, and only files are read; put a file in its place" in err


def test_a_folder_of_files_is_no_file_to_import(run: Call, study: Path) -> None:
    assert "this is a folder; give the files in it" in refusal(run, "import", study, "--suggest")


@pytest.mark.parametrize("content", [b"hello", b"PK\x05\x06" + bytes(18)])
def test_what_is_no_workbook_is_told_in_no_librarys_words(run: Call, tmp_path, content) -> None:
    file = tmp_path / "answers.xlsx"
    file.write_bytes(content)
    said = refusal(run, "import", file, "--suggest")
    assert said.endswith("this is not a workbook that can be read; save it as .xlsx or CSV\n")


def test_headings_alone_are_told_with_their_file(run: Call, tmp_path: Path) -> None:
    file = tmp_path / "answers.csv"
    file.write_text("participant,condition,nausea\n", "utf-8")
    said = refusal(run, "import", file, "--suggest")
    assert said == f"error: {file}: there is no row of data below the headings\n"


def test_an_option_that_takes_no_such_value_is_told_in_our_words(
    run: Call, study, tmp_path
) -> None:
    said = refusal(run, "export", study, "--format", "bidz", "--out", tmp_path / "b")
    assert "'bidz' is not one of 'bids', 'psych-ds'" in said
    assert "Value error" not in said


def test_a_key_wants_a_folder_before_anything_is_copied(run: Call, study: Path, tmp_path) -> None:
    key = tmp_path / "keys" / "key.csv"
    said = refusal(run, "anonymise", study, "--out", tmp_path / "a", "--key", key)
    assert f"{key.parent}: there is no such folder for the key; make it first" in said
    assert not list(tmp_path.iterdir())
