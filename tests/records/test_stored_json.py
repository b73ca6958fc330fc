"""Odd content of manifest.json and dataset_description.json is a sentence in every command."""

from __future__ import annotations

import ast
import json
import shutil
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

import vrcomfort
from tests.support.exchange import PRACTICE, SeesEyes
from tests.support.odd_json import GONE, odd_versions, with_odd
from tests.support.resume import go
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.records.checksums import write_checksums
from vrcomfort.records.disk import OWNER

OF_STUDY = "dataset_description.json"
WHOLE, RESUMED = (f"sub-{name}/ses-1/manifest.json" for name in ("P01", "P02"))
Place = tuple[str | int, ...]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """P01 with gaze; P02, who was interrupted twice."""
    place = tmp_path_factory.mktemp("recorded")
    protocol = tiny_protocol(place, PROTOCOL + PRACTICE)
    go(place, headset_for=lambda *_: SeesEyes(), protocol=protocol)
    go(place, participant="P02", interrupt=(3, 30), protocol=protocol)
    go(place, participant="P02", interrupt=(2, 30), resume=True, protocol=protocol)
    return place


@pytest.fixture
def study(recorded: Path, tmp_path: Path) -> Path:
    shutil.copy(recorded / "tiny.toml", tmp_path)
    (tmp_path / "room.glb").touch()
    return Path(shutil.copytree(recorded / "S", tmp_path / "S"))


def commands(study: Path) -> dict[str, tuple[object, ...]]:
    """Return everything that reads a study, in words of the command line."""
    protocol, session, out = study.parent / "tiny.toml", study / "sub-P01/ses-1", study.parent
    who = ("--participant", "P02", "--respondent", "terminal", "--out", study, "--resume")
    return {
        "verify": ("verify", study),
        "status": ("status", study),
        "design": ("design", protocol, "--study", study),
        "pack": ("pack", study),
        "bids": ("export", study, "--format", "bids", "--out", out / "bids"),
        "psych-ds": ("export", study, "--format", "psych-ds", "--out", out / "psych"),
        "anonymise": ("anonymise", study, "--out", out / "anonymous"),
        "report": ("report", study, "--out", out / "report", "--figures", "none"),
        "play": ("play", session, "--out", out / "played"),
        "run": ("run", protocol, *who),
        "simulate": ("simulate", protocol, "-n", 2, "--out", study, "--no-draw"),
    }


def odd(study: Path, file: str, place: Place, value: Any) -> None:
    """Damage one value, and let the checksums fit: what reads the file is to find it."""
    content = json.loads((study / file).read_text())
    (study / file).write_text(json.dumps(with_odd(content, place, value), indent=1))
    if file != OF_STUDY:
        write_checksums((study / file).parent, OWNER)


Run = Callable[..., tuple[int, str, str]]


def check(run: Run, study: Path, names: tuple[str, ...] = ()) -> dict[str, str]:
    """Run commands; return what each said that refused. A traceback is raised by `run`."""
    said = {}
    for name, words in commands(study).items():
        if names and name not in names:
            continue
        code, out, err = run(*words)
        assert code in ((0, 1) if name == "verify" else (0, 2)), (name, code, err)
        refusals = [line for line in err.splitlines() if line.startswith("error:")]
        assert len(refusals) == (code == 2), (name, err)
        assert all(len(each) < 1000 for each in refusals), (name, err[:2000])
        said[name] = refusals[0] if refusals else out if code else ""
        for folder in study.parent.iterdir():
            if folder.is_dir() and folder != study:
                shutil.rmtree(folder)
    return said


FELL: tuple[tuple[str, Place, Any, str, str, str], ...] = (
    (OF_STUDY, ("protocol",), [], "psych-ds", "`protocol`: should be a string", "line 8"),
    (WHOLE, ("settings", "practice", 0), {}, "verify", "`settings.practice.0.name`", "line "),
    (WHOLE, ("settings", "consent"), 7, "verify", "`settings.consent`", "line "),
    (WHOLE, ("settings", "questionnaires", 0), 7, "anonymise", "questionnaires.0`", "line "),
    (WHOLE, ("settings", "views"), ["x"], "play", "`settings.views.0`", "line "),
    (WHOLE, ("wordings",), 7, "bids", "`wordings`: should be a list", "line "),
    (WHOLE, ("headset", "image_size_px"), GONE, "play", "the size of the images", "json: "),
    (RESUMED, ("earlier_runs", 0, "started_at"), [], "anonymise", "earlier_runs.0.start", "line "),
    (WHOLE, ("settings", "flag_above_percent", "frozen"), {}, "verify", "percent.frozen`", "line "),
    (RESUMED, ("started_at",), "9999-01-01T00:00:00+00:00", "anonymise", "the years", "line "),
)  # fmt: skip


@pytest.mark.parametrize(
    ("file", "place", "value", "command", "says", "where"), FELL, ids=lambda each: str(each)[:20]
)
def test_what_fell_once_is_told_with_its_place(
    run, study, file, place, value, command, says, where
):
    odd(study, file, place, value)
    said = check(run, study, (command,))[command]
    assert says in said
    assert where in said


def test_a_report_says_what_it_does_not_use(run, study):
    told = (
        (OF_STUDY, ("protocol",), ["x"], "study description: `protocol`: should be a string"),
        (WHOLE, ("settings", "order", "sequences", 0), {}, "sequences.0.sessions` is missing"),
        (RESUMED, ("settings", "groups"), [{}], "manifest: `settings.groups.0.name` is missing"),
    )
    for file, place, value, _ in told:
        odd(study, file, place, value)
    code, _, err = run(*commands(study)["report"])
    assert code == 0
    for file, *_, says in told:
        assert f"{file}, line " in err
        assert says in " ".join(err.split())


def odd_studies(study: Path) -> Iterator[tuple[str, Place, Any]]:
    for file in (OF_STUDY, WHOLE, RESUMED):
        content = json.loads((study / file).read_text())
        yield from ((file, place, value) for place, value in odd_versions(content))


@pytest.mark.slow
def test_whatever_stands_there_no_command_falls(run, study, monkeypatch):
    monkeypatch.setattr("os.fsync", lambda _: None)  # many cases, and no power cut
    monkeypatch.setattr("os.fdatasync", lambda _: None)
    whole = {file: file.read_bytes() for file in study.rglob("*") if file.is_file()}
    for file, place, value in islice(odd_studies(study), 7, None, 1000):
        odd(study, file, place, value)
        check(run, study)
        for each in study.rglob("*"):
            if each.is_file() and each not in whole:
                each.unlink()
        for each, content in whole.items():
            each.write_bytes(content)


CHECKED_ELSEWHERE = {
    "importing/text_files.py": "tables of other programs, whose mapping says what they mean",
    "records/json_file.py": "the reader",
    "records/checksums.py": "keys of a description, to name those that were changed",
    "records/disk.py": "whoever holds a lock is named where that can be read",
    "report/writing.py": "names of files to remove, each checked against a pattern",
    "scene/gltf/file.py": "scenes",
    "tradeoff/files.py": "the same as of a report",
}
"""Who calls `parse_json` itself, and of what."""


def test_stored_json_is_read_with_its_shape():
    root = Path(vrcomfort.__file__).parent
    texts = ((file, file.read_text("utf-8")) for file in root.rglob("*.py"))
    found = {
        file.relative_to(root).as_posix()
        for file, text in texts
        if "parse_json" in text
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "parse_json"
    }
    assert found == set(CHECKED_ELSEWHERE)
