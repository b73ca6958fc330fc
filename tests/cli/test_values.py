"""Files and values that a command cannot take: one sentence with what it is about, exit code 2."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from vrcomfort.cli import main

READING = [
    ("play", "FILE", "--scene", "temple", "--out", "made"),
    ("play", "FILE", "--gaze", "FILE", "--scene", "temple", "--out", "made"),
    ("import-trace", "FILE", "--out", "made"),
    ("import", "FILE", "--suggest", "--out", "made"),
    ("report", "FILE", "--out", "made"),
    ("score", "ssq", "FILE"),
    ("run", "smoke", "--participant", "P01", "--trace", "FILE", "--out", "made"),
    ("simulate", "smoke", "-n", "2", "--trace", "FILE", "--out", "made"),
]
RUN = ("run", "smoke", "--participant", "P01", "--out", "made")


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def refusal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> str:
    monkeypatch.setattr("sys.argv", ["vrcomfort", *command])
    with pytest.raises(SystemExit, match="2"):
        main()
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert said.count("\n") == 1
    return said


def about(file: str, command: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(file if word == "FILE" else word for word in command)


@pytest.mark.parametrize("command", READING)
@pytest.mark.parametrize(
    ("file", "words"), [("none.csv", "there is no such file"), ("folder", "folder: ")]
)
def test_a_file_that_is_none_is_told(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: tuple[str, ...],
    file: str,
    words: str,
) -> None:
    Path("folder").mkdir()
    said = refusal(monkeypatch, capsys, about(file, command))
    assert file in said
    assert words in said


@pytest.mark.parametrize("command", READING)
def test_a_file_that_may_not_be_read_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], command: tuple[str, ...]
) -> None:
    file = Path("secret.csv")
    file.touch(mode=0o000)
    allowed = os.access

    def access(path: Any, mode: int, **more: Any) -> bool:  # root may read everything
        return allowed(path, mode, **more) and (mode != os.R_OK or Path(path) != file)

    monkeypatch.setattr(os, "access", access)
    said = refusal(monkeypatch, capsys, about(str(file), command))
    assert f"path '{file}' is not readable; see vrcomfort {command[0]} --help" in said
    assert not Path("made").exists()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (("simulate", "smoke", "-n", "x", "--out", "made"), "value for '--participants' / '-n'"),
        (("simulate", "smoke", "-n", "0", "--out", "made"), "value for '--participants' / '-n'"),
        ((*RUN, "--headset", "hat"), "'--headset'"),
        ((*RUN, "--exposure-s", "0"), "'--exposure-s'"),
        (("run", "smoke", "--out", "made"), "missing option '--participant'"),
        (("render", "--scene", "temple", "--out", ""), "'--out': it is empty; write where"),
        (("run", "smoke", "--participant", "P01", "--out", ""), "'--out': it is empty"),
        (("simulate", "smoke", "-n", "1", "--out", " "), "'--out': it is empty"),
        (("play", "walk.csv", "--scene", "temple", "--out", ""), "'--out': it is empty"),
        (("import-trace", "walk.csv", "--out", ""), "'--out': it is empty"),
        (("report", "study", "--out", ""), "'--out': it is empty"),
        (("tradeoff", "--out", ""), "'--out': it is empty"),
        (("demo", "--out", ""), "'--out': it is empty"),
    ],
)
def test_a_value_that_no_option_takes_is_told(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: tuple[str, ...],
    words: str,
) -> None:
    before = sorted(Path().iterdir())
    said = refusal(monkeypatch, capsys, command)
    assert words in said
    assert sorted(Path().iterdir()) == before
    assert said.endswith(f"; see vrcomfort {command[0]} --help\n")
    assert not Path("made").exists()


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ("9" * 5000 + "x1", "has a side of more than 8192 pixels"),
        ("1x8193", "has a side of more than 8192 pixels"),
        ("x" * 5000, "is not a size; write WIDTHxHEIGHT"),
        ("0x0", "is not a size"),
        ("00x1", "is not a size"),
        ("²x2", "is not a size"),
    ],
)
def test_a_size_that_is_none_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], size: str, words: str
) -> None:
    said = refusal(
        monkeypatch, capsys, ("render", "--scene", "temple", "--size", size, "--out", "made")
    )
    assert words in said
    assert len(said) < 200


def test_a_folder_with_the_name_of_a_scene_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("room.glb").mkdir()
    said = refusal(monkeypatch, capsys, ("render", "--scene", "room.glb", "--out", "made"))
    assert "room.glb: is a folder; a scene is a .glb or .gltf file" in said
