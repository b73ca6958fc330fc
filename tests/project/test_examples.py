"""The example package, installed into a folder: its effect, its task and its questionnaire run."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.places import ROOT

EXAMPLE = ROOT / "examples" / "my_lab"


@pytest.fixture(scope="module")
def installation(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder into which pip has installed the package."""
    folder = tmp_path_factory.mktemp("installed")
    source = shutil.copytree(EXAMPLE, folder / "source")  # building leaves files behind
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index"]
    told = ["--no-build-isolation", "--disable-pip-version-check", "--target", folder / "packages"]
    subprocess.run([*pip, *told, source], check=True)
    return folder / "packages"


def vrcomfort(packages: Path | None, here: Path, *words: object) -> str:
    path = os.pathsep.join(str(each) for each in (packages, ROOT) if each)
    done = subprocess.run(
        [sys.executable, "-m", "vrcomfort", *map(str, words)],
        cwd=here,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_study_runs_with_what_the_package_adds(installation: Path, tmp_path: Path) -> None:
    study = EXAMPLE / "study.toml"
    vrcomfort(installation, tmp_path, "check", study, "--no-draw")
    short = ["--exposure-s", "0.5", "--refresh-hz", "10", "--size", "16x20"]
    vrcomfort(installation, tmp_path, "simulate", study, "-n", "2", *short, "--out", "study")
    vrcomfort(installation, tmp_path, "verify", "study")
    session = tmp_path / "study" / "sub-P01" / "ses-1"
    manifest = json.loads((session / "manifest.json").read_text("utf-8"))
    assert manifest["task_code"] == {"nods": "my-lab 0.1.0"}
    assert {row["task"] for row in rows_of(session / "tasks.csv")} == {"nod"}
    asked = {row["instrument"] for row in rows_of(session / "questionnaires.csv")}
    assert asked == {"ssq", "room_quality"}
    told = ["--figures", "none", "--out", "report"]
    vrcomfort(installation, tmp_path, "report", "study", *told)


@pytest.mark.slow
def test_the_effect_of_the_package_draws(installation: Path, tmp_path: Path) -> None:
    told = ["--scene", "temple", "--size", "32x40", "--set", "depth_of_field=none"]
    told += ["--set", "motion_blur=none"]
    vrcomfort(installation, tmp_path, "render", *told, "--out", "plain")
    vrcomfort(installation, tmp_path, "render", *told, "--set", "grey.amount=1.0", "--out", "grey")
    plain, grey = (light(tmp_path / name / "left.npz") for name in ("plain", "grey"))
    assert np.ptp(plain, axis=2).max() > 0.05
    assert np.ptp(grey, axis=2).max() <= 2**-10 * grey.max()
    luminance = plain @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(grey[..., 0], luminance, rtol=0.01, atol=1e-3)


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as opened:
        return list(csv.DictReader(opened))


def light(file: Path) -> np.ndarray:
    with np.load(file) as stored:
        return stored["linear"].astype(float)


@pytest.mark.slow
def test_a_package_in_the_present_folder_is_not_installed(
    installation: Path, tmp_path: Path
) -> None:
    """A study's folder may come from anywhere: nothing in it runs by being there."""
    here = shutil.copytree(installation, tmp_path / "study")
    for kind, name in {"effects": "grey", "tasks": "nods", "instruments": "room_quality"}.items():
        assert name in vrcomfort(installation, tmp_path, "list", kind)
        assert name not in vrcomfort(None, here, "list", kind)


def test_a_package_that_cannot_be_read_is_named_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text("raise ValueError('oops')")
    described = tmp_path / "bad_lab-1.0.dist-info"
    described.mkdir()
    (described / "METADATA").write_text("Metadata-Version: 2.1\nName: bad-lab\nVersion: 1.0\n")
    (described / "entry_points.txt").write_text("[vrcomfort.effects]\nodd = bad:Odd\n")
    done = subprocess.run(
        [sys.executable, "-m", "vrcomfort", "list", "effects"],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == (
        "error: the package bad-lab 1.0 cannot be read: ValueError: oops "
        "(entry point vrcomfort.effects: odd = bad:Odd)\n"
    )
