"""`vrcomfort export --format bids`: what was recorded is in the dataset, which is valid."""

from __future__ import annotations

import csv
import gzip
import json
import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.exchange import PRACTICE, cell, errors_of, with_gaze
from tests.support.resume import go
from tests.support.study import AheadHeadset
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.bids import export_bids
from vrcomfort.frame import Frame
from vrcomfort.headset.base import HeadsetEvent

FIRST = "sub-P01_ses-1_task-tiny"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_gaze(tmp_path_factory.mktemp("study"), PRACTICE)


@pytest.fixture(scope="module")
def dataset(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("bids") / "dataset"
    assert export_bids(study, out) == []
    return out


def tsv(file: Path) -> list[dict[str, str]]:
    with file.open(newline="") as stream:
        return list(csv.DictReader(stream, delimiter="\t"))


def samples(file: Path) -> list[list[str]]:
    text = gzip.decompress(file.read_bytes()).decode() if file.suffix == ".gz" else file.read_text()
    return [line.split("\t") for line in text.splitlines()]


def recorded(study: Path, name: str) -> list[dict[str, str]]:
    with (study / "sub-P01" / "ses-1" / name).open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_motion_of_head_and_hands_is_that_of_the_frames(study: Path, dataset: Path) -> None:
    motion = dataset / "sub-P01" / "ses-1" / "motion"
    frames = [row for row in recorded(study, "frames.csv") if row["trial"] == "2"]
    for system, bodies in (("head", ["head"]), ("hands", ["left_hand", "right_hand"])):
        stem = f"{FIRST}_tracksys-{system}_run-2"
        rows = samples(motion / f"{stem}_motion.tsv")
        channels = tsv(motion / f"{stem}_channels.tsv")
        assert len(rows) == len(frames)
        assert {len(row) for row in rows} == {len(channels)}
        for row, frame in zip(rows, frames, strict=True):
            pose = [frame[f"{body}_{end}"] or "n/a" for body in bodies
                    for end in ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")]  # fmt: skip
            assert row[:-1] == pose
            since_s = float(frame["session_s"]) - float(frames[0]["session_s"])
            assert float(row[-1]) == pytest.approx(since_s, abs=1e-6)
        names = [each["name"] for each in channels]
        assert names[:4] == [f"{bodies[0]}_{end}" for end in ("x", "y", "z", "quat_x")]
        said = json.loads((motion / f"{stem}_motion.json").read_text())
        assert said["SamplingFrequency"] == pytest.approx(10.0)
        assert said["MotionChannelCount"] == len(channels)
        assert said["TrackedPointsCount"] == len(bodies)


def test_gaze_has_the_angles_of_the_line_of_sight(study: Path, dataset: Path) -> None:
    stem = f"{FIRST}_run-1_recording-cyclopean_physio"
    folder = dataset / "sub-P01" / "ses-1" / "motion"
    rows = samples(folder / f"{stem}.tsv.gz")
    columns = json.loads((folder / f"{stem}.json").read_text())["Columns"]
    times = {row["xr_time_ns"] for row in recorded(study, "frames.csv") if row["trial"] == "1"}
    gaze = [row for row in recorded(study, "gaze.csv") if row["xr_time_ns"] in times]
    assert len(rows) == len(gaze) == len(times)
    for row, was in zip(rows, gaze, strict=True):
        cells = dict(zip(columns, row, strict=True))
        assert cells["valid"] == was["valid"]
        if was["valid"] == "0":
            assert cells["x_coordinate"] == cells["origin_y"] == "n/a"
            continue
        x, y, z = (float(was[f"direction_{axis}"]) for axis in "xyz")
        assert math.tan(float(cells["x_coordinate"])) == pytest.approx(x / -z)
        assert math.sin(float(cells["y_coordinate"])) == pytest.approx(y)


def test_each_eye_that_was_told_of_has_a_recording(study: Path, dataset: Path) -> None:
    folder = dataset / "sub-P01" / "ses-1" / "motion"
    assert not list(folder.glob("*recording-right*"))
    stem = f"{FIRST}_run-1_recording-left_physio"
    said = json.loads((folder / f"{stem}.json").read_text())
    assert said["RecordedEye"] == "left"
    rows = samples(folder / f"{stem}.tsv.gz")
    gaze = {row["session_s"]: row for row in recorded(study, "gaze.csv")}
    assert len(rows) == len(samples(folder / f"{stem.replace('left', 'cyclopean')}.tsv.gz"))
    seen = [dict(zip(said["Columns"], row, strict=True)) for row in rows]
    assert {each["pupil_size"] for each in seen} == {"3.5"}
    assert {each["valid"] for each in seen} == {row["left_valid"] for row in gaze.values()}
    assert "hit_distance" not in said["Columns"]


def test_events_hold_the_exposure_and_its_ratings(study: Path, dataset: Path) -> None:
    rows = tsv(dataset / "sub-P01" / "ses-1" / "motion" / f"{FIRST}_run-1_events.tsv")
    ratings = [row for row in rows if row["trial_type"] == "rating fms"]
    was = [row for row in recorded(study, "ratings.csv") if row["trial"] == "1"]
    assert [row["value"] for row in ratings] == [row["response"] for row in was]
    start_s = float(recorded(study, "trials.csv")[0]["start_s"])
    assert float(ratings[0]["onset"]) == pytest.approx(float(was[0]["onset_s"]) - start_s, abs=0.11)
    (exposure,) = [row for row in rows if row["trial_type"] == "exposure"]
    assert (exposure["value"], exposure["condition"]) == ("completed", "plain")
    assert [float(row["onset"]) for row in rows] == sorted(float(row["onset"]) for row in rows)


class Notes(AheadHeadset):
    """A headset that notes something in the fifth second."""

    noted = HeadsetEvent("unfocused", "the stop button does not work")

    def frames(self) -> Iterator[Frame]:
        for each in super().frames():
            if each.index == 50:
                self.events.append(self.noted)
            yield each


def test_events_hold_what_the_headset_noted(tmp_path: Path) -> None:
    go(tmp_path, headset_for=lambda *_: Notes())
    export_bids(tmp_path / "S", tmp_path / "dataset")
    rows = tsv(next((tmp_path / "dataset").rglob("*_run-1_events.tsv")))
    told = [row["value"] for row in rows if row["trial_type"] == "unfocused"]
    assert told == [Notes.noted.detail]


def test_columns_of_participants_and_events_are_described(dataset: Path) -> None:
    people = json.loads((dataset / "participants.json").read_text())
    (row,) = tsv(dataset / "participants.tsv")
    assert people.keys() == row.keys() - {"participant_id"}
    assert row["status"] in people["status"]["Levels"]
    files = [*dataset.rglob("*_events.tsv")]
    assert files
    for file in files:
        said, rows = json.loads(file.with_suffix(".json").read_text()), tsv(file)
        assert said.keys() - {"StimulusPresentation"} == rows[0].keys()
        assert said["trial_type"]["Levels"].keys() == {row["trial_type"] for row in rows}


def test_every_answer_is_in_the_phenotype_tables(study: Path, dataset: Path) -> None:
    (row,) = tsv(dataset / "phenotype" / "ssq.tsv")
    said = json.loads((dataset / "phenotype" / "ssq.json").read_text())
    for answer in recorded(study, "questionnaires.csv"):
        place = f"ses-1_trial-{answer['trial']}" if answer["trial"] else "ses-1"
        name = f"{place}_{answer['timepoint']}_{answer['item']}"
        assert row[name] == (answer["response"] or "n/a")
        assert said[name]["Levels"]["0"]
        if answer["trial"]:
            assert row[f"{place}_condition"] == answer["condition"]
    assert row["ses-1_language"] == "en"
    assert set(row) - {"participant_id"} == set(said) - {"MeasurementToolMetadata"}


def test_practice_is_a_table_of_behaviour_with_each_column_described(study, dataset) -> None:
    stem = dataset / "sub-P01" / "ses-1" / "beh" / "sub-P01_ses-1_task-tinypractice_beh"
    said = json.loads(stem.with_suffix(".json").read_text())
    rows, was = tsv(stem.with_suffix(".tsv")), recorded(study, "practice.csv")
    assert len(was) == 2
    assert [list(row.values()) for row in rows] == [
        [value or "n/a" for name, value in row.items() if name not in ("participant", "session")]
        for row in was
    ]
    assert said.pop("TaskName") == "tinypractice"
    assert set(said) - {"TaskDescription"} == set(rows[0])
    assert said["start_s"]["Units"] == "s"


def test_without_practice_there_is_no_table_of_it(tmp_path: Path) -> None:
    go(tmp_path)
    export_bids(tmp_path / "S", tmp_path / "dataset")
    assert not list((tmp_path / "dataset").rglob("*practice*"))


def test_participants_and_scans_name_what_is_there(dataset: Path) -> None:
    (row,) = tsv(dataset / "participants.tsv")
    assert (row["participant_id"], row["sequence"], row["status"]) == ("sub-P01", "ab", "completed")
    for session in ("ses-1", "ses-2"):
        scans = tsv(dataset / "sub-P01" / session / f"sub-P01_{session}_scans.tsv")
        assert len(scans) == 8  # head, hands, gaze, and that of the left eye, of two exposures
        assert all((dataset / "sub-P01" / session / each["filename"]).is_file() for each in scans)


def test_what_cannot_be_exported_is_refused_in_a_sentence(run, study, tmp_path) -> None:
    words = ("export", study, "--format", "bids", "--out")
    assert run(*words, study / "in")[0] == 2
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    with pytest.raises(InputError, match="is there already"):
        export_bids(study, tmp_path / "full")
    go(tmp_path)
    cell(tmp_path / "S" / "sub-P01" / "ses-1" / "trials.csv", 2, "session", "2")
    code, _, err = run("export", tmp_path / "S", "--format", "bids", "--out", tmp_path / "out")
    assert (code, err.count("\n")) == (2, 1)
    assert "this study is not whole" in err
    code, _, err = run("export", study, "--format", "bits", "--out", tmp_path / "out")
    assert (code, err.count("\n")) == (2, 1)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.smoke
def test_a_dataset_with_gaze_and_hands_is_valid(dataset: Path) -> None:
    assert errors_of(dataset) == []


@pytest.mark.slow
def test_an_anonymous_dataset_without_motion_is_valid(study: Path, tmp_path: Path) -> None:
    anonymise(study, tmp_path / "anonymous", AnonymisingOptions())
    export_bids(tmp_path / "anonymous", tmp_path / "dataset")
    assert len(list((tmp_path / "dataset").rglob("*practice_beh.tsv"))) == 2
    assert not list((tmp_path / "dataset").rglob("*_motion.tsv"))
    assert errors_of(tmp_path / "dataset") == []


@pytest.mark.slow
def test_a_simulated_study_is_exported_to_a_valid_dataset(run, tmp_path: Path) -> None:
    simulated, out = tmp_path / "study", tmp_path / "dataset"
    assert run("simulate", "smoke", "-n", 2, "--size", "32x40", "--out", simulated, "-q")[0] == 0
    code, _, err = run("export", simulated, "--format", "bids", "--out", out)
    assert (code, err) == (0, "")
    assert errors_of(out) == []


@pytest.mark.slow
def test_the_validator_finds_a_dataset_that_is_wrong(dataset: Path, tmp_path: Path) -> None:
    import shutil

    broken = Path(shutil.copytree(dataset, tmp_path / "broken"))
    next(broken.rglob("*_motion.json")).unlink()
    assert errors_of(broken)
