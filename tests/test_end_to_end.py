"""The three jobs from start to finish, as the command line does them."""

from __future__ import annotations

import csv
import hashlib
import json
import re
from pathlib import Path

import pytest

from vrcomfort.cli.app import app
from vrcomfort.records.checksums import CHECKSUMS

pytestmark = pytest.mark.slow

TIMINGS = {"cpu_ms", "gpu_ms", "cpu_median_ms", "cpu_p95_ms", "cpu_p99_ms"}
TIME_STAMPS = {"started_at", "finished_at", "enrolled_at", "exposure_ended"}


def vrcomfort(*arguments: object) -> None:
    app([str(argument) for argument in arguments], standalone_mode=False)


def rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def fingerprint(folder: Path) -> dict[str, str]:
    """Return a digest per file, without what is allowed to differ: time stamps and timings."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    files = [path for path in files if path.name != CHECKSUMS]  # of the manifest's time stamps
    return {str(path.relative_to(folder)): _digest(path) for path in files}


def _digest(path: Path) -> str:
    if path.suffix == ".csv":
        kept = [
            {k: v for k, v in row.items() if k not in TIMINGS | TIME_STAMPS} for row in rows(path)
        ]
        return hashlib.sha256(repr(kept).encode()).hexdigest()
    if path.name == "manifest.json":
        content = json.loads(path.read_text(encoding="utf-8"))
        return repr({k: v for k, v in content.items() if k not in TIME_STAMPS})
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture(scope="module")
def studies(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return the same small study, simulated twice."""
    folders = [tmp_path_factory.mktemp("study") / "study" for _ in range(2)]
    for folder in folders:
        options = ("-n", 2, "--size", "48x60", "--exposure-s", 0.05, "--seed", 3, "--quiet")
        vrcomfort("simulate", "smoke", *options, "--out", folder)
    return folders


def test_the_same_seed_gives_the_same_study(studies: list[Path]) -> None:
    first, second = map(fingerprint, studies)
    assert first == second


def test_a_study_folder_explains_itself(studies: list[Path]) -> None:
    session = studies[0] / "sub-P01" / "ses-1"
    manifest = json.loads((session / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["exposure_override_s"] == 0.05
    assert "depth_of_field" in manifest["passes"]["dof in temple"]
    assert "depth_of_field" not in manifest["passes"]["plain in temple"]
    assert manifest["shaders"]
    trials, frames = rows(session / "trials.csv"), rows(session / "frames.csv")
    assert [trial["trial"] for trial in trials] == ["1", "2", "3", "4"]
    shown = [frame for frame in frames if frame["trial"] == "1"]
    assert len(shown) == int(trials[0]["frames"])
    blurred = next(trial for trial in trials if trial["condition"] == "dof")
    in_focus = [frame for frame in frames if frame["trial"] == blurred["trial"]]
    assert all(0 < float(frame["focus_m"]) <= 30_000 for frame in in_focus)
    assert all(set(frame["rays_used"]) <= {"0", "1"} for frame in in_focus)


def test_a_session_is_never_overwritten(studies: list[Path]) -> None:
    from vrcomfort.errors import InputError

    before = fingerprint(studies[1])
    options = ("--participant", "P01", "--respondent", "simulated", "--session", 1, "--quiet")
    with pytest.raises(InputError, match="never overwritten"):
        vrcomfort("run", "smoke", *options, "--out", studies[1], "--size", "48x60")
    assert fingerprint(studies[1]) == before


@pytest.mark.smoke
def test_a_study_becomes_a_report(studies: list[Path], tmp_path: Path) -> None:
    vrcomfort("report", studies[0], "--out", tmp_path, "--quiet")
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert not re.search(r"""(src|href)=["']?https?:|url\(["']?https?:""", page), "self-contained"
    assert list((tmp_path / "tables").glob("*.csv"))
    assert list((tmp_path / "figures").glob("*.svg"))


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return the same walk, played twice."""
    from vrcomfort.resources import data_folder

    walk = data_folder("scenes") / "temple_walk.csv"
    folders = [tmp_path_factory.mktemp("played") for _ in range(2)]
    for folder in folders:
        options = ("--frames", 4, "--size", "64x80", "--refresh-hz", 10, "--quiet")
        film = ("--video", folder / "video.mp4")
        vrcomfort("play", walk, "--scene", "temple", *options, *film, "--out", folder)
    return folders


def test_playing_twice_gives_the_same_bytes(played: list[Path]) -> None:
    first, second = map(fingerprint, played)
    assert first == second
    assert {"frames.csv", "video.mp4", "frames/000000.png", "frames/000003.png"} <= set(first)


def test_a_recorded_frame_log_plays_back_as_the_same_pictures(
    played: list[Path], tmp_path: Path
) -> None:
    options = ("--scene", "temple", "--size", "64x80", "--quiet", "--out", tmp_path)
    vrcomfort("play", played[0] / "frames.csv", *options)
    pictures = sorted(path.name for path in (played[0] / "frames").iterdir())
    assert pictures == sorted(path.name for path in (tmp_path / "frames").iterdir())
    for name in pictures:
        assert (tmp_path / "frames" / name).read_bytes() == (
            played[0] / "frames" / name
        ).read_bytes()


@pytest.mark.smoke
def test_a_picture_comes_with_its_numbers_and_its_error(tmp_path: Path) -> None:
    import numpy as np

    options = ("--size", "48x60", "--reference", 8, "--quiet", "--out", tmp_path)
    vrcomfort("render", "--scene", "temple", *options)
    with np.load(tmp_path / "left.npz") as numbers:
        assert numbers["linear"].shape == (60, 48, 3)
        assert np.isfinite(numbers["linear"]).all()
        assert numbers["depth"].shape == (60, 48)
    meta = json.loads((tmp_path / "meta.json").read_text(encoding="utf-8"))
    assert meta["reference"]["samples"] == 8
    assert meta["reference"]["left"]["psnr_db"] > 20
    for name in ("left", "right", "side_by_side", "left_reference", "right_reference"):
        assert (tmp_path / f"{name}.png").stat().st_size > 0


def test_the_sun_in_the_picture_is_not_the_whole_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--pose", "0,1.6,0,40,5,0", "--size", "48x60", "--reference", 8)
    vrcomfort("render", "--scene", "mountain", *options, "--out", tmp_path)
    found = json.loads((tmp_path / "meta.json").read_text(encoding="utf-8"))["reference"]["left"]
    assert found["psnr_db"] > 30
    assert found["left_out_px"] > 0
    told = f"left eye: PSNR {found['psnr_db']:.1f} dB"
    assert told in capsys.readouterr().out


def test_a_single_sample_says_nothing_of_its_own_error(tmp_path: Path) -> None:
    options = ("--size", "24x30", "--reference", 1, "--quiet", "--out", tmp_path)
    vrcomfort("render", "--scene", "temple", *options)
    meta = json.loads((tmp_path / "meta.json").read_text(encoding="utf-8"))
    assert not meta["reference"]["left"]["counts"]
