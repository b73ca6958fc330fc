"""`vrcomfort anonymise`: nothing of the copy tells who took part; it is whole, and reported."""

from __future__ import annotations

import csv
import json
from datetime import datetime
from pathlib import Path

import pytest

from tests.support.exchange import SeesEyes, cell, errors_of
from tests.support.report import build_report
from tests.support.resume import go
from tests.support.study import Scripted
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import RECORD, AnonymisingOptions, anonymise, new_names
from vrcomfort.exchange.bids import export_bids
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import set_status, undo_withdrawal
from vrcomfort.records.shared_columns import AVATAR, EYES, HANDS, HEAD

MOTION = (*HEAD, *EYES, *AVATAR, *HANDS, "focus_m", "focus_raw_m", "ray_1_m", "rays_used")
REASON = "Zebra pressed the wrong key"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Anna77 with gaze and an undone withdrawal, Bert88 interrupted, Cleo99 with a note."""
    place = tmp_path_factory.mktemp("named")
    seeing = {"headset_for": lambda *_: SeesEyes()}
    go(place, Scripted(withdraw_at_s=1.0), participant="Anna77", **seeing)
    undo_withdrawal(place / "S", "Anna77", REASON)
    go(place, participant="Anna77", resume=True, **seeing)
    go(place, participant="Bert88", interrupt=(2, 30))
    go(place, participant="Cleo99", sessions=[1, 2], ipd_measured_m=0.0611)
    set_status(place / "S", "Cleo99", "completed", REASON)
    return place / "S"


def contents(folder: Path) -> dict[str, bytes]:
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


def frames(folder: Path) -> list[dict[str, str]]:
    with (folder / "ses-1" / "frames.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
def test_nothing_in_the_copy_tells_who_it_was(study: Path, tmp_path: Path) -> None:
    before = contents(study)
    anonymise(study, tmp_path / "out", AnonymisingOptions())
    assert contents(study) == before
    copied = contents(tmp_path / "out")
    year = str(datetime.now().year).encode()
    for name, content in copied.items():
        for secret in (b"Anna77", b"Bert88", b"Cleo99", b"Zebra", b"0.0611", year + b"-"):
            assert secret not in content, (name, secret)
            assert secret not in name.encode()
    assert not any("gaze" in name or "lock" in name for name in copied)
    for number in (1, 2, 3):
        for row in frames(tmp_path / "out" / f"sub-P{number:02d}"):
            assert not any(row[name] for name in MOTION)
            assert row["left_fov_up_rad"]


@pytest.mark.parametrize(
    "wishes",
    [AnonymisingOptions(), AnonymisingOptions(dates="remove", keep_motion=True, keep_gaze=True)],
)
def test_the_copy_is_whole(study: Path, tmp_path: Path, wishes: AnonymisingOptions) -> None:
    anonymise(study, tmp_path / "out", wishes)
    found = verify_study(tmp_path / "out")
    assert found.faults == []
    before = verify_study(study)
    for name in ("participants", "sessions completed", "rows of frames.csv", "rows of trials.csv"):
        assert found.counts[name] == before.counts[name]


@pytest.mark.slow
@pytest.mark.smoke
def test_the_copy_is_reported_with_the_same_answers(study: Path, tmp_path: Path) -> None:
    anonymise(study, tmp_path / "out", AnonymisingOptions())
    for source in (study, tmp_path / "out"):
        build_report(source, out=tmp_path / f"report of {source.name}")
    same = [
        json.loads((tmp_path / f"report of {name}" / "results.json").read_text())["descriptives"]
        for name in (study.name, "out")
    ]
    assert same[0] == same[1]


def test_motion_and_gaze_are_kept_on_request_but_for_the_time(study: Path, tmp_path: Path) -> None:
    wishes = AnonymisingOptions(keep_motion=True, keep_gaze=True, seed=3)
    record = anonymise(study, tmp_path / "out", wishes)
    new = new_names(["Anna77", "Bert88", "Cleo99"], 3)["Anna77"]
    was, now = frames(study / "sub-Anna77"), frames(tmp_path / "out" / f"sub-{new}")
    assert [{**row, "xr_time_ns": ""} for row in was] == [{**row, "xr_time_ns": ""} for row in now]
    times = [int(row["xr_time_ns"]) for row in now]
    assert times == [int(row["xr_time_ns"]) - int(was[0]["xr_time_ns"]) for row in was]
    assert (tmp_path / "out" / f"sub-{new}" / "ses-1" / "gaze.csv").exists()
    assert record["still_there"]["people_are_recognised_by"] == ["head and hand motion", "gaze"]
    assert json.loads((tmp_path / "out" / RECORD).read_text()) == record


def test_gaze_alone_tells_nothing_of_the_place_of_the_head(study: Path, tmp_path: Path) -> None:
    anonymise(study, tmp_path / "out", AnonymisingOptions(keep_gaze=True, seed=3))
    new = new_names(["Anna77", "Bert88", "Cleo99"], 3)["Anna77"]
    session = tmp_path / "out" / f"sub-{new}" / "ses-1"
    with (session / "gaze.csv").open(newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["valid"] == "1"]
    for row in rows:
        assert not any(cell for name, cell in row.items() if "origin_" in name)
        assert row["direction_z"]
        assert row["left_direction_z"]
    assert rows
    assert not any(row["max_blur_px"] for row in frames(session.parent))
    assert verify_study(tmp_path / "out").faults == []
    export_bids(tmp_path / "out", tmp_path / "bids")
    assert errors_of(tmp_path / "bids") == []


def test_times_between_sessions_stay_or_go(study: Path, tmp_path: Path) -> None:
    def length_s(folder: Path) -> float:
        said = json.loads((folder / "ses-1" / "manifest.json").read_text())
        began, ended = (datetime.fromisoformat(said[f"{w}_at"]) for w in ("started", "finished"))
        return (ended - began).total_seconds()

    new = new_names(["Anna77", "Bert88", "Cleo99"], 3)["Cleo99"]
    anonymise(study, tmp_path / "shifted", AnonymisingOptions(seed=3))
    anonymise(study, tmp_path / "removed", AnonymisingOptions(seed=3, dates="remove"))
    assert length_s(tmp_path / "shifted" / f"sub-{new}") == length_s(study / "sub-Cleo99")
    assert length_s(tmp_path / "removed" / f"sub-{new}") == 0


def test_new_names_are_a_permutation_that_the_seed_decides() -> None:
    names = [f"P{n:02d}" for n in range(1, 31)]
    new = new_names(names, 5)
    assert sorted(new.values()) == names
    assert new == new_names(names, 5) != new_names(names, 6)
    assert new_names(names, None) != new_names(names, None)


def test_the_key_is_written_where_it_is_asked_for_alone(study: Path, tmp_path: Path) -> None:
    anonymise(study, tmp_path / "out", AnonymisingOptions(key=tmp_path / "key.csv", seed=5))
    lines = (tmp_path / "key.csv").read_text().splitlines()
    new = new_names(["Anna77", "Bert88", "Cleo99"], 5)
    assert lines == ["participant,anonymous", *(",".join(pair) for pair in new.items())]
    for place in (tmp_path / "other" / "key.csv", study / "key.csv"):
        with pytest.raises(InputError, match="choose a place outside"):
            anonymise(study, tmp_path / "other", AnonymisingOptions(key=place))
    assert not (tmp_path / "other").exists()


def test_what_cannot_be_made_is_refused_in_a_sentence(run, study: Path, tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    for out, words in (
        (tmp_path / "full", "is there already"),
        (study / "in", "lies in the study"),
        (tmp_path / "full" / "file" / "out", "file: a file of this name is in the way"),
        (tmp_path / ("o" * 252), f"{'o' * 252}: this name is too long for the disk"),
    ):
        code, _, err = run("anonymise", study, "--out", out)
        assert (code, err.count("\n")) == (2, 1)
        assert words in err
        assert ".part" not in err
    go(tmp_path)
    for line, more in ((2, " (and 1 more)"), (3, " (and 2 more)")):
        cell(tmp_path / "S" / "sub-P01" / "ses-1" / "trials.csv", line, "session", "2")
        code, _, err = run("anonymise", tmp_path / "S", "--out", tmp_path / "out")
        assert code == 2
        assert "this study is not whole: sub-P01/ses-1/trials.csv, line 2: session is 2" in err
        assert f"{more}; see vrcomfort verify" in err
    assert not (tmp_path / "out").exists()


def test_the_command_warns_of_what_is_kept(run, study: Path, tmp_path: Path) -> None:
    code, out, err = run("anonymise", study, "--out", tmp_path / "out", "--keep-gaze")
    assert code == 0
    assert "gaze is kept: people can be recognised by it" in err
    assert str(tmp_path / "out" / RECORD) in out
