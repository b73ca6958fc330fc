"""One session that is not whole is left out of copies and reports, or accepted, and told there."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.support.exchange import cell
from tests.support.report import HEAD, ONE_SCORE
from tests.support.resume import go
from vrcomfort.exchange.verifying import verify_study

BAD = "sub-P01/ses-2"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a study in which one cell of a session has been changed; no test changes it."""
    place = tmp_path_factory.mktemp("flagged")
    for name in ("P01", "P02"):
        go(place, participant=name, sessions=[1, 2], exposure_s=1.0)
    cell(place / "S" / BAD / "trials.csv", 2, "session", "9")
    return place / "S"


def commands(study: Path, out: Path) -> dict[str, tuple[object, ...]]:
    plan = out / "plan.toml"
    plan.write_text(HEAD + ONE_SCORE)
    return {
        "bids": ("export", study, "--format", "bids", "--out", out / "bids"),
        "psych-ds": ("export", study, "--format", "psych-ds", "--out", out / "psych-ds"),
        "copy": ("anonymise", study, "--out", out / "copy", "--seed", "3"),
        "report": ("report", study, "--plan", plan, "--out", out / "report", "--figures", "none"),
    }


def said(folder: Path) -> str:
    names = ("README.md", "anonymised.json", "results.json")
    return "".join((folder / n).read_text() for n in names if (folder / n).exists())


@pytest.mark.parametrize("name", ["bids", "psych-ds", "copy", "report"])
def test_a_session_is_left_out_and_that_is_recorded(run, study, tmp_path, name):
    words = commands(study, tmp_path)[name]
    code, _, err = run(*words, "--without", "P01/ses-2")
    assert code == 0, err
    folder = tmp_path / name
    if name == "copy":
        record = json.loads(said(folder))
        (left,) = record["sessions_left_out"]
        assert record["sessions_with_faults"] == []
        person, session = left.split("/")
        assert not (folder / f"sub-{person}" / session).exists()
        assert (folder / f"sub-{person}" / "ses-1").exists()
        assert verify_study(folder).faults == []
    else:
        assert "left out on request: P01/ses-2" in said(folder)
    if name == "bids":
        assert not (folder / BAD).exists()
        assert (folder / "sub-P01/ses-1").exists()


@pytest.mark.parametrize("name", ["bids", "psych-ds", "copy", "report"])
def test_a_session_with_faults_is_accepted_and_that_is_recorded(run, study, tmp_path, name):
    words = commands(study, tmp_path)[name]
    code, _, err = run(*words, "--accept-flagged")
    assert code == 0, err
    folder = tmp_path / name
    if name == "copy":
        (flagged,) = json.loads(said(folder))["sessions_with_faults"]
        assert flagged.endswith("/ses-2")
    else:
        assert f"accepted as it is: {BAD}/trials.csv, line 2: session is 9" in said(folder)


def test_a_session_whose_manifest_is_lost_can_be_left_out(run, study, tmp_path):
    folder = shutil.copytree(study, tmp_path / "S")
    (folder / BAD / "manifest.json").write_text("{")
    words = commands(folder, tmp_path)
    for name in ("bids", "psych-ds", "copy"):
        code, _, err = run(*words[name])
        assert code == 2
        assert "--without P07/ses-2 leaves a session out" in err
        assert run(*words[name], "--without", "P01/ses-2")[0] == 0


def test_what_names_no_session_is_refused(run, study, tmp_path):
    for words in commands(study, tmp_path).values():
        for text, told in (("P01", "names no session"), ("P01/ses-7", "has no such session")):
            code, _, err = run(*words, "--without", text)
            assert (code, err.count("\n")) == (2, 1), err
            assert told in err
