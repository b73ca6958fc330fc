"""Folders of the first version still read; those of a version to come are refused."""

import csv
import json
import shutil
from pathlib import Path

import pytest

from tests.support.places import ROOT
from vrcomfort.cli import main
from vrcomfort.records import FrameRow, GazeRow
from vrcomfort.records.disk import OWNER
from vrcomfort.records.interrupted import repair_table
from vrcomfort.records.schema import SCHEMA_VERSION, columns_of_version
from vrcomfort.records.shared_columns import HANDS
from vrcomfort.traces.gaze_track import read_gaze
from vrcomfort.traces.trace import read_trace

FIRST = ROOT / "tests" / "data" / "study_of_schema_1"
SMALL = ("--size", "64x80", "--refresh-hz", "40", "--quiet")


@pytest.fixture
def study(tmp_path: Path) -> Path:
    return Path(shutil.copytree(FIRST, tmp_path / "study"))


@pytest.fixture
def vrcomfort(monkeypatch: pytest.MonkeyPatch):
    def run(*words: object) -> None:
        monkeypatch.setattr("sys.argv", ["vrcomfort", *map(str, words)])
        main()

    return run


def succeeds(call, *words: object) -> None:
    with pytest.raises(SystemExit) as ended:
        call(*words)
    assert not ended.value.code


def resume(call, study: Path) -> None:
    """Continue P02, with the text of the protocol that the study was begun with."""
    manifest = json.loads((study / "sub-P02/ses-1/manifest.json").read_text())
    protocol = study.with_name("smoke.toml")
    protocol.write_text(manifest["protocol"]["text"])
    words = ("--participant", "P02", "--out", study, "--respondent", "simulated", "--resume")
    call("run", protocol, *words, *SMALL)


def rows(file: Path) -> list[dict[str, str]]:
    with file.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_study_of_the_first_version_is_reported(study, vrcomfort, tmp_path):
    succeeds(vrcomfort, "report", study, "--figures", "none", "--out", tmp_path / "report")
    results = json.loads((tmp_path / "report" / "results.json").read_text())
    assert results


@pytest.mark.slow
def test_its_frames_are_a_trace_and_play(study, vrcomfort, tmp_path):
    frames = study / "sub-P01/ses-1/frames.csv"
    assert len(read_trace(frames)) == len(rows(frames))
    words = ("--scene", "temple", "--out", tmp_path / "played")
    succeeds(vrcomfort, "play", frames, *words, "--size", "64x80", "--frames", "3")
    assert len(rows(tmp_path / "played" / "frames.csv")) == 3


def test_a_file_of_the_second_version_gets_the_columns_of_the_third(study):
    session = study / "sub-P02/ses-1"
    second = columns_of_version(2, "frames.csv", FrameRow.columns())
    later = (*HANDS, "user_present", "paused", "wait_ms", "swapchain_wait_ms")
    assert set(FrameRow.columns()) - set(second) == set(later)
    frames = [{name: row.get(name, "") for name in second} for row in rows(session / "frames.csv")]
    with (session / "frames.csv").open("w", newline="") as stream:
        writer = csv.DictWriter(stream, second, lineterminator="\n")
        writer.writeheader()
        writer.writerows(frames)
    before = (session / "frames.csv").read_bytes()
    assert repair_table(session, FrameRow, OWNER) is None
    assert (session / "frames.csv.schema2").read_bytes() == before
    blank = dict.fromkeys(later, "")
    assert rows(session / "frames.csv") == [
        {name: {**row, **blank}[name] for name in FrameRow.columns()} for row in frames
    ]


@pytest.mark.slow
def test_gaze_of_the_third_version_gets_the_columns_of_each_eye_and_is_read(study):
    session = study / "sub-P02/ses-1"
    third = columns_of_version(3, "gaze.csv", GazeRow.columns())
    assert third[-2:] == ("hit_m", "resumed")
    file = session / "gaze.csv"
    file.write_text(",".join(third) + "\n0.1,5,1,0.0,1.6,0.0,0.0,0.0,-1.0,2.5,0\n")
    before = file.read_bytes()
    assert read_gaze(file).at(5).eyes == (None, None)
    assert repair_table(session, GazeRow, OWNER) is None
    assert (session / "gaze.csv.schema3").read_bytes() == before
    (row,) = rows(file)
    assert tuple(row) == GazeRow.columns()
    cells = [row[name] for name in ("hit_m", "hit_node", "left_valid", "resumed")]
    assert cells == ["2.5", "", "", "0"]
    assert read_gaze(file).at(5).eyes == (None, None)


@pytest.mark.slow
def test_its_interrupted_session_goes_on_with_the_new_columns(study, vrcomfort):
    session = study / "sub-P02/ses-1"
    before = {name: (session / name).read_bytes() for name in ("trials.csv", "frames.csv")}
    succeeds(resume, vrcomfort, study)
    for name, text in before.items():
        assert (session / f"{name}.schema1").read_bytes() == text, "what was there is kept"
    trials = rows(session / "trials.csv")
    assert [row["status"] for row in trials] == [
        "completed", "completed", "aborted", "completed", "completed"
    ]  # fmt: skip
    assert {row["missed_refreshes"] for row in trials[:2]} == {""}, "it was not recorded"
    frames = rows(session / "frames.csv")
    assert len(read_trace(session / "frames.csv")) == len(frames)
    old = list(csv.DictReader(before["frames.csv"].decode().splitlines()))
    kept = [{name: row[name] for name in old[0]} for row in frames[: len(old)]]
    assert kept == old
    assert json.loads((session / "manifest.json").read_text())["schema_version"] == SCHEMA_VERSION


@pytest.mark.parametrize(
    ("what", "version"),
    [
        *(("manifest", each) for each in (SCHEMA_VERSION + 1, "two", 0, 1.5, None, True)),
        *(("description", each) for each in (SCHEMA_VERSION + 1, "two", 0)),
    ],
)
def test_what_a_later_version_wrote_is_refused(study, vrcomfort, capsys, version, what):
    of_session = study / "sub-P02/ses-1/manifest.json"
    file = of_session if what == "manifest" else study / "dataset_description.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps({**content, "schema_version": version}))
    with pytest.raises(SystemExit) as ended:
        resume(vrcomfort, study)
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert file.name in said.replace("\n", "")
    assert "version" in said
