"""`vrcomfort run --resume` as an experimenter meets it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from study_parts import AheadHeadset, LateFocus, Scripted

from vrcomfort.cli import main
from vrcomfort.protocol import load_protocol
from vrcomfort.records import only_run, read_rows
from vrcomfort.resources import data_folder
from vrcomfort.session import run


def begin(folder: Path, respondent: str, participant: str = "P01") -> Path:
    """Return a study whose only session stopped in its second exposure."""
    begun: list[int] = []

    def headset_for(*_: object) -> AheadHeadset:
        begun.append(1)
        return AheadHeadset(interrupt_at=0 if len(begun) == 2 else None)

    outcome = run(
        load_protocol("smoke"),
        participant,
        study=folder,
        load_scene=lambda source: source,
        headset_for=headset_for,
        renderer=LateFocus(),
        respondent=Scripted(name=respondent),
        seed=7,
        exposure_s=0.2,
    )
    assert outcome.status == "aborted"
    return folder


@pytest.fixture
def study(tmp_path: Path) -> Path:
    return begin(tmp_path / "study", "simulated")


def command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: Any
) -> tuple[int, str]:
    first = ("run", "smoke", "--participant", "P01", "--respondent", "simulated")
    return call(monkeypatch, capsys, *first, *words)


def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: Any
) -> tuple[int, str]:
    arguments = [*map(str, words), "--size", "16x16", "--refresh-hz", "20"]
    monkeypatch.setattr("sys.argv", ["vrcomfort", *arguments])
    code = 0
    try:
        main()
    except SystemExit as end:
        code = int(end.code or 0)
    return code, capsys.readouterr().err


def test_an_interrupted_session_is_refused_and_then_resumed_as_it_was(study, monkeypatch, capsys):
    code, said = command(monkeypatch, capsys, "--out", study)
    assert (code, said.count("\n")) == (2, 1)
    assert "--resume" in said
    for other in (["terminal"], ["panel", "--headset", "openxr"]):
        refused = command(monkeypatch, capsys, "--out", study, "--resume", "--respondent", *other)
        assert refused[0] == 2
        assert f"--respondent simulated, not {other[0]}; resume it with" in refused[1]
    code, said = command(monkeypatch, capsys, "--out", study, "--resume")
    assert code == 0, said
    folder = study / "sub-P01" / "ses-1"
    trials = read_rows(folder / "trials.csv").rows
    assert [(row["trial"], row["attempt"], row["resumed"]) for row in trials] == [
        ("1", "1", "0"),
        ("2", "1", "0"),
        ("2", "2", "1"),
        ("3", "1", "1"),
        ("4", "1", "1"),
    ]
    assert {row["frames"] for row in trials[2:]} == {"4"}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert (manifest["seed"], manifest["exposure_s"]) == (7, 0.2)
    assert [each["respondent"] for each in manifest["earlier_runs"]] == ["simulated"]
    code, said = command(monkeypatch, capsys, "--out", study, "--resume", "--session", 1)
    assert code == 2
    assert "leave --resume out" in said


def test_a_participant_who_is_being_run_is_refused(study, monkeypatch, capsys):
    with only_run(study, "P01"):
        code, said = command(monkeypatch, capsys, "--out", study, "--resume")
    assert (code, said.count("\n")) == (2, 1)
    assert "P01 is being run by process" in said


def statuses(study: Path) -> dict[str, str]:
    rows = read_rows(study / "participants.csv").rows
    return {row["participant"]: row["status"] for row in rows}


def test_simulate_goes_on_where_it_was_stopped(study, monkeypatch, capsys):
    simulate = ("simulate", "smoke", "--out", study, "--exposure-s", 0.2, "-n")
    first = (study / "sub-P01" / "ses-1" / "frames.csv").read_text()
    code, said = call(monkeypatch, capsys, *simulate, 2)
    assert (code, said) == (0, "")
    assert statuses(study) == {"P01": "completed", "P02": "completed"}
    recorded = {file: file.read_bytes() for file in study.glob("sub-*/ses-1/*")}
    assert recorded[study / "sub-P01" / "ses-1" / "frames.csv"].decode().startswith(first)
    code, said = call(monkeypatch, capsys, *simulate, 2)
    assert code == 2
    assert "all sessions of all 2 participants are recorded" in said
    other = study.with_name("other.toml")
    text = (data_folder("protocols") / "smoke.toml").read_text()
    other.write_text(text.replace('name = "smoke"', 'name = "other"', 1))
    code, said = call(monkeypatch, capsys, "simulate", other, "--out", study, "-n", 2)
    assert code == 2
    assert "holds a study with protocol `smoke`, not `other`" in said
    # Killed between the last session's end and the list of participants:
    file = study / "participants.csv"
    file.write_text(file.read_text().replace("P01,s1,completed", "P01,s1,enrolled"))
    assert statuses(study)["P01"] == "enrolled"
    code, said = call(monkeypatch, capsys, *simulate, 3)
    assert (code, said) == (0, "")
    assert statuses(study) == dict.fromkeys(("P01", "P02", "P03"), "completed")
    assert {file: file.read_bytes() for file in recorded} == recorded


def test_simulate_keeps_the_names_of_a_study_that_was_larger(tmp_path, monkeypatch, capsys):
    study = begin(tmp_path / "study", "simulated", "P001")
    simulate = ("simulate", "smoke", "--out", study, "--exposure-s", 0.2, "-n")
    code, _ = call(monkeypatch, capsys, *simulate, 1)
    assert code == 0
    assert list(statuses(study)) == ["P001"]  # and no P01


def test_simulate_leaves_people_alone(tmp_path, monkeypatch, capsys):
    study = begin(tmp_path / "study", "terminal")
    recorded = {file: file.read_bytes() for file in study.rglob("*") if file.is_file()}
    code, said = call(monkeypatch, capsys, "simulate", "smoke", "-n", 2, "--out", study)
    assert (code, said.count("\n")) == (2, 1)
    assert "begun with --respondent terminal; choose another --out" in said
    assert {file: file.read_bytes() for file in recorded} == recorded
