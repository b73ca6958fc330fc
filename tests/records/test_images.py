"""Hashes of the shown images stand in images.csv, beside the frames they are of."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

from tests.support.exchange import cell
from tests.support.resume import go
from tests.support.study import LateFocus, Picture, read_rows
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import Frame, ImageHash

SESSION = "sub-P01/ses-1"


@dataclass
class Hashing(LateFocus):
    """A renderer that hashes every 30th frame of a condition, and tells four frames late."""

    drawn: int = 0
    hashes: list[tuple[int, ImageHash]] = field(default_factory=list)

    def begin(self, scene, condition):
        super().begin(scene, condition)
        self.drawn = 0

    def render(self, frame: Frame, scene_time_s: float) -> Picture:
        picture = super().render(frame, scene_time_s)
        hashed = self.drawn % 30 == 0
        if hashed:
            of_frame = ImageHash(frame.index, f"{frame.index:016x}", f"{frame.index + 1:016x}")
            self.hashes.append((self.drawn, of_frame))
        self.drawn += 1
        due = [each for at, each in self.hashes if at + 4 < self.drawn]
        self.hashes = [each for each in self.hashes if each[1] not in due]
        return replace(picture, hashed=hashed, image_hashes=tuple(due))

    def drain_hashes(self) -> tuple[ImageHash, ...]:
        due, self.hashes = self.hashes, []
        return tuple(each for _, each in due)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("hashed")
    go(place, renderer=Hashing())
    return place / "S"


def test_every_30th_frame_of_an_exposure_has_its_hashes_with_its_times(study: Path) -> None:
    images, frames = (read_rows(study / SESSION / f"{n}.csv") for n in ("images", "frames"))
    of_frames = {row["xr_time_ns"]: row for row in frames}
    assert [row["trial"] for row in images] == ["0", "1", "1", "1", "2", "2", "2", "2"]
    for row in images:
        frame = of_frames[row["xr_time_ns"]]
        assert (row["session_s"], row["trial"]) == (frame["session_s"], frame["trial"])
        assert int(row["right_hash"], 16) == int(row["left_hash"], 16) + 1
    first = [frames.index(of_frames[row["xr_time_ns"]]) for row in images[:4]]
    assert first == [0, 30, 60, 90]  # training and the first exposure share their frames
    assert [int(row["left_hash"], 16) for row in images[:4]] == first


def test_verify_reads_them_and_finds_a_hash_of_no_frame(study: Path, tmp_path: Path) -> None:
    assert verify_study(study).findings == []
    cell(study / SESSION / "images.csv", 4, "xr_time_ns", "6000000001")
    try:
        told = [str(each) for each in verify_study(study).faults]
    finally:
        cell(study / SESSION / "images.csv", 4, "xr_time_ns", "6000000000")
    assert any("images.csv, line 4: frames.csv has no row of this time" in each for each in told)


@pytest.mark.parametrize("keep_motion", [False, True])
def test_an_anonymous_copy_has_them_only_with_the_motion_they_were_drawn_with(
    study: Path, tmp_path: Path, keep_motion: bool
) -> None:
    anonymise(study, tmp_path / "out", AnonymisingOptions(keep_motion=keep_motion))
    (copy,) = (tmp_path / "out").glob("sub-*/ses-1")
    assert (copy / "images.csv").exists() == keep_motion
    if keep_motion:
        with (copy / "images.csv").open(newline="") as stream:
            assert [row["left_hash"] for row in csv.DictReader(stream)] == [
                row["left_hash"] for row in read_rows(study / SESSION / "images.csv")
            ]


def test_hashes_of_a_session_that_goes_on_are_those_of_both_runs(tmp_path: Path) -> None:
    go(tmp_path, renderer=Hashing(), interrupt=(2, 30))
    go(tmp_path, renderer=Hashing(), resume=True)
    images = read_rows(tmp_path / "S" / SESSION / "images.csv")
    assert [row["trial"] for row in images if row["resumed"] == "0"] == ["0", "1", "1", "1", "2"]
    assert [row["trial"] for row in images if row["resumed"] == "1"] == ["2"] * 4
    assert verify_study(tmp_path / "S").faults == []
