"""`vrcomfort run --resume` as an experimenter meets it."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.support.session import run
from tests.support.study import AheadHeadset, LateFocus, Scripted, read_rows, smoke_with
from vrcomfort.cli import main
from vrcomfort.protocol import load_protocol
from vrcomfort.records import only_run, set_status
from vrcomfort.resources import data_folder

WALK = data_folder("scenes") / "temple_walk.csv"
MOUNTAIN_WALK = data_folder("scenes") / "mountain_walk.csv"
FULL_S, SHOWN_S = 0.5, 0.2
"""Of the protocol, and as it is shown."""


def begin(
    folder: Path, respondent: str, participant: str = "P01", *, interrupted: bool = True
) -> Path:
    """Return a study whose only session is complete, or stopped in its second exposure."""
    begun: list[int] = []
    details = {"trace_sha256": hashlib.sha256(WALK.read_bytes()).hexdigest()}

    def headset_for(*_: object) -> AheadHeadset:
        begun.append(1)
        return AheadHeadset(
            interrupt_at=0 if interrupted and len(begun) == 2 else None,
            image_size_px=(16, 16),
            refresh_hz=20.0,
            details=details,
        )

    outcome = run(
        load_protocol(smoke_with(folder.parent, FULL_S)),
        participant,
        study=folder,
        load_scene=lambda source: source,
        headset_for=headset_for,
        renderer=LateFocus(),
        respondent=Scripted(name=respondent),
        seed=7,
        exposure_s=SHOWN_S,
    )
    assert outcome.status == ("aborted" if interrupted else "completed")
    return folder


def smoke_of(study: Path) -> Path:
    """Return the protocol that `begin` wrote beside a study."""
    return study.with_name("smoke.toml")


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> dict[bool, Path]:
    """Return studies that nobody changes: whether the session was interrupted → the study."""
    return {
        interrupted: begin(
            tmp_path_factory.mktemp("begun") / "study", "simulated", interrupted=interrupted
        )
        for interrupted in (False, True)
    }


@pytest.fixture
def study(begun: dict[bool, Path], tmp_path: Path) -> Path:
    """Return a copy of the study that was interrupted, and of its protocol."""
    shutil.copytree(begun[True].parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / "study"


def command(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    study: Path,
    *words: Any,
) -> tuple[int, str]:
    first = ("run", smoke_of(study), "--participant", "P01", "--respondent", "simulated")
    return call(monkeypatch, capsys, *first, "--out", study, *words)


def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: Any
) -> tuple[int, str]:
    name, *more = map(str, words)
    arguments = [name, "--size", "16x16", "--refresh-hz", "20", *more]
    monkeypatch.setattr("sys.argv", ["vrcomfort", *arguments])
    code = 0
    try:
        main()
    except SystemExit as end:
        code = int(end.code or 0)
    return code, capsys.readouterr().err


@pytest.mark.slow
def test_an_interrupted_session_is_refused_and_then_resumed_as_it_was(study, monkeypatch, capsys):
    code, said = command(monkeypatch, capsys, study)
    assert (code, said.count("\n")) == (2, 1)
    assert "--resume" in said
    for other in (["terminal"], ["panel", "--headset", "openxr"]):
        refused = command(monkeypatch, capsys, study, "--resume", "--respondent", *other)
        assert refused[0] == 2
        assert f"--respondent simulated, not {other[0]}; resume it with" in refused[1]
    code, said = command(monkeypatch, capsys, study, "--resume")
    assert code == 0, said
    folder = study / "sub-P01" / "ses-1"
    trials = read_rows(folder / "trials.csv")
    assert [(row["trial"], row["attempt"], row["resumed"]) for row in trials] == [
        ("1", "1", "0"),
        ("2", "1", "0"),
        ("2", "2", "1"),
        ("3", "1", "1"),
        ("4", "1", "1"),
    ]
    assert {row["frames"] for row in trials[2:]} == {"4"}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert (manifest["seed"], manifest["exposure_s"]) == (7, SHOWN_S)
    assert [each["respondent"] for each in manifest["earlier_runs"]] == ["simulated"]
    code, said = command(monkeypatch, capsys, study, "--resume", "--session", 1)
    assert code == 2
    assert "leave --resume out" in said


def test_a_participant_who_is_being_run_is_refused(study, monkeypatch, capsys):
    with only_run(study, "P01"):
        code, said = command(monkeypatch, capsys, study, "--resume")
    assert (code, said.count("\n")) == (2, 1)
    assert "P01 is being run by process" in said


def statuses(study: Path) -> dict[str, str]:
    rows = read_rows(study / "participants.csv")
    return {row["participant"]: row["status"] for row in rows}


@pytest.mark.slow
def test_simulate_goes_on_where_it_was_stopped(study, monkeypatch, capsys):
    simulate = ("simulate", smoke_of(study), "--out", study, "--exposure-s", SHOWN_S, "-n")
    first = (study / "sub-P01" / "ses-1" / "frames.csv").read_text()
    code, shortened = call(monkeypatch, capsys, *simulate, 2)
    assert (code, shortened.count("\n")) == (0, 1)
    assert shortened.startswith("note: exposures of 0.5 s are shortened to 0.2 s")
    assert statuses(study) == {"P01": "completed", "P02": "completed"}
    recorded = {file: file.read_bytes() for file in study.glob("sub-*/ses-1/*")}
    assert recorded[study / "sub-P01" / "ses-1" / "frames.csv"].decode().startswith(first)
    code, said = call(monkeypatch, capsys, *simulate, 2)
    assert code == 2
    assert "all sessions of all 2 participants are recorded" in said
    other = study.with_name("other.toml")
    text = smoke_of(study).read_text()
    other.write_text(text.replace('name = "smoke"', 'name = "other"', 1))
    code, said = call(monkeypatch, capsys, "simulate", other, "--out", study, "-n", 2)
    assert code == 2
    assert "holds a study with protocol `smoke`, not `other`" in said
    # Killed between the last session's end and the list of participants:
    file = study / "participants.csv"
    file.write_text(file.read_text().replace("P01,s1,completed", "P01,s1,enrolled"))
    assert statuses(study)["P01"] == "enrolled"
    code, said = call(monkeypatch, capsys, *simulate, 3)
    assert (code, said) == (0, shortened)
    assert statuses(study) == dict.fromkeys(("P01", "P02", "P03"), "completed")
    assert {file: file.read_bytes() for file in recorded} == recorded


SAME = [
    (["--exposure-s", 0.3], "with exposures of 0.2 s, not 0.3 s;"),
    ([], "with exposures of 0.2 s, not 0.5 s;"),
    (["--exposure-s", SHOWN_S, "--size", "20x16"], "with --size 16x16;"),
    (["--exposure-s", SHOWN_S, "--refresh-hz", 10], "with frames at 20 Hz, not 10 Hz;"),
    (["--exposure-s", SHOWN_S, "--trace", MOUNTAIN_WALK], "with another head trace;"),
]


@pytest.mark.parametrize(
    ("interrupted", "others", "words"),
    [*((False, *each) for each in SAME), (True, *SAME[1]), (True, *SAME[-1])],
)
def test_simulate_goes_on_with_the_same_options_alone(
    begun, tmp_path, monkeypatch, capsys, interrupted, others, words
):
    shutil.copytree(begun[interrupted].parent, tmp_path, dirs_exist_ok=True)
    study = tmp_path / "study"
    set_status(study, "P01", "withdrawn")  # nothing is left to simulate of them
    before = {file: file.read_bytes() for file in study.rglob("*") if file.is_file()}
    code, said = call(
        monkeypatch, capsys, "simulate", smoke_of(study), "--out", study, "-n", 2, *others
    )
    assert (code, said.count("\n")) == (2, 1)
    assert f"ses-1: this session was begun {words} go on with the same, or choose" in said
    assert {file: file.read_bytes() for file in study.rglob("*") if file.is_file()} == before


def test_simulate_goes_on_with_the_same_text_of_a_protocol(tmp_path, monkeypatch, capsys):
    study = begin(tmp_path / "study", "simulated", interrupted=False)
    changed = tmp_path / "changed.toml"
    changed.write_text(smoke_of(study).read_text() + "\n# changed\n")
    options = ("--exposure-s", SHOWN_S, "-n", 2, "--out", study)
    code, said = call(monkeypatch, capsys, "simulate", changed, *options)
    assert code == 2
    assert "begun with another text of this protocol; go on with the same" in said
    manifest = study / "sub-P01" / "ses-1" / "manifest.json"
    manifest.write_text('{"status": "completed", "respondent": "simulated"}')
    code, said = call(monkeypatch, capsys, "simulate", smoke_of(study), *options)
    assert code == 2
    assert "manifest.json, line 1" in said
    assert "`participant` is missing: this manifest is damaged; restore it" in said


@pytest.mark.slow
def test_simulate_keeps_the_names_of_a_study_that_was_larger(tmp_path, monkeypatch, capsys):
    study = begin(tmp_path / "study", "simulated", "P001")
    simulate = ("simulate", smoke_of(study), "--out", study, "--exposure-s", SHOWN_S, "-n")
    code, _ = call(monkeypatch, capsys, *simulate, 1)
    assert code == 0
    assert list(statuses(study)) == ["P001"]  # and no P01


def test_simulate_leaves_people_alone(tmp_path, monkeypatch, capsys):
    study = begin(tmp_path / "study", "terminal")
    recorded = {file: file.read_bytes() for file in study.rglob("*") if file.is_file()}
    code, said = call(monkeypatch, capsys, "simulate", smoke_of(study), "-n", 2, "--out", study)
    assert (code, said.count("\n")) == (2, 1)
    assert "begun with --respondent terminal; choose another output folder" in said
    assert {file: file.read_bytes() for file in recorded} == recorded


def test_an_exposure_can_only_be_shortened(tmp_path, monkeypatch, capsys):
    smoke = smoke_with(tmp_path, FULL_S)
    out = tmp_path / "made"
    run_p01 = ("run", smoke, "--participant", "P01", "--respondent", "simulated", "--out", out)
    for words in (run_p01, ("simulate", smoke, "-n", 1, "--out", out)):
        for longer_s, shown in (("0.6", "0.6"), ("1e300", "1e+300"), ("inf", "inf")):
            code, said = call(monkeypatch, capsys, *words, "--exposure-s", longer_s)
            assert (code, said.count("\n")) == (2, 1)
            assert f"an exposure of {shown} s cannot be shown: protocol smoke has" in said
            assert "exposures of 0.5 s, which can only be shortened" in said
            assert not out.exists()


def test_a_session_with_longer_exposures_than_the_protocols_is_not_continued(
    study, monkeypatch, capsys
):
    file = study / "sub-P01" / "ses-1" / "manifest.json"
    manifest = json.loads(file.read_text())
    file.write_text(json.dumps({**manifest, "exposure_s": 5.0}))
    code, said = command(monkeypatch, capsys, study, "--resume")
    assert (code, said.count("\n")) == (2, 1)
    assert "an exposure of 5 s cannot be shown: protocol smoke has exposures of 0.5 s" in said


@pytest.mark.parametrize(
    ("name", "old", "new", "says"),
    [
        ("manifest.json", '"status": "aborted"', '"status": []', "`status`: should be"),
        ("manifest.json", '"memory": null', '"memory": {}', "`memory` is not the state of"),
        ("manifest.json", '"seed": 7', '"seed": 1e300', "`seed`: should be a whole number"),
        ("trials.csv", "P01,1,2,1,2,", "P01,1,2,1,99,", "order has 4 trials, and no 99"),
        ("events.csv", "\n0.0,", "\ninf,", "'inf' is larger than anything recorded"),
    ],
)
def test_a_damaged_session_is_refused_in_one_sentence(
    study, monkeypatch, capsys, name, old, new, says
):
    file = study / "sub-P01" / "ses-1" / name
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    code, said = command(monkeypatch, capsys, study, "--resume")
    assert (code, said.count("\n")) == (2, 1)
    assert f"{name}" in said
    assert says in said


@pytest.mark.slow
def test_a_study_is_opened_to_a_group_by_an_option(tmp_path, monkeypatch, capsys):
    out = tmp_path / "made"
    words = ("simulate", smoke_with(tmp_path, FULL_S), "-n", 1, "--out", out, "--exposure-s", 0.2)
    code, said = call(monkeypatch, capsys, *words, "--group-readable")
    assert code == 0, said
    assert {oct(file.stat().st_mode)[-3:] for file in out.rglob("*") if file.is_file()} == {"640"}
