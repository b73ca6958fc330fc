"""Files, columns and events of a study are declared once: exports and copies derive from that."""

from __future__ import annotations

import ast
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import vrcomfort
from tests.support.exchange import PRACTICE, with_gaze
from tests.support.report import build_report
from tests.support.study import read_rows
from vrcomfort.exchange.anonymising import Wishes, anonymise
from vrcomfort.exchange.bids import export_bids, practice
from vrcomfort.exchange.meanings import MEANINGS
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.operator_interface import ALLOWED
from vrcomfort.records import schema
from vrcomfort.records.consents import ConsentRow
from vrcomfort.records.disk import OWNER
from vrcomfort.records.events import EVENTS
from vrcomfort.records.exposure_rows import DialRow, PracticeRow, RatingRow, TaskRow, TrialRow
from vrcomfort.records.mend import mend
from vrcomfort.records.privacy import ALWAYS, BOTH, GAZE, MOTION, SHARED
from vrcomfort.records.row_files import OPTIONAL_ROWS, SESSION_ROWS
from vrcomfort.records.session_rows import (
    FACTS,
    ParticipantRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)
from vrcomfort.replay.recorded import read_session

ROOT = Path(__file__).resolve().parent.parent
ALL = (*SESSION_ROWS, *OPTIONAL_ROWS, ParticipantRow, ConsentRow)
NOT_WRITTEN_OUT = {
    "headset/openxr/lifecycle.py": {"focused", "unfocused", "headset_on", "headset_off"},
    "headset/openxr/messages.py": {"openxr_error", "openxr_warning"},
    "headset/openxr/presence.py": {"controller_found", "controller_lost"},
    "headset/openxr/tracking.py": {"tracking_found", "tracking_lost"},
    "session/event_log.py": set(),  # names that it is given
    "session/eye_height.py": {"eye_height"},
    "session/flow.py": {"ended", "withdrawn", "runtime_hung"},
    "session/gaze_validation.py": {"gaze_validation"},
    "session/operator_control.py": {
        f"operator_{each}" for step in ALLOWED.values() for each in step
    },
}
"""Modules that name an event by other means than a text in place → those names."""


def names_written() -> Iterator[tuple[str, str | None]]:
    """Yield each place that makes an event: its module, and the name where that is a text."""
    root = Path(vrcomfort.__file__).parent
    for file in root.rglob("*.py"):
        text = file.read_text("utf-8")
        module = file.relative_to(root).as_posix()
        for node in ast.walk(ast.parse(text)) if "vent" in text else ():
            if not isinstance(node, ast.Call):
                continue
            called = getattr(node.func, "attr", getattr(node.func, "id", ""))
            own = called == "_write" and module == "session/operator_control.py"
            if own or called in {"event", "event_soon", "HeadsetEvent", "EventRow"}:
                name = node.args[2 if called == "EventRow" else 0]
                written = isinstance(name, ast.Constant)
                yield module, str(name.value) if isinstance(name, ast.Constant) else None
                assert written or module in NOT_WRITTEN_OUT, (module, ast.unparse(node))


def test_every_event_is_declared_with_what_becomes_of_its_detail():
    found = list(names_written())
    named = {name for _, name in found if name is not None}
    named |= {name for names in NOT_WRITTEN_OUT.values() for name in names}
    assert {module for module, name in found if name is None} == NOT_WRITTEN_OUT.keys()
    assert named - EVENTS.keys() == set(), "declare them in vrcomfort/records/events.py"
    assert EVENTS.keys() - named == set(), "nothing writes these"


def test_the_page_of_events_has_each():
    text = (ROOT / "docs" / "events.md").read_text("utf-8")
    rows = [
        f"| `{name}` | {kind.meaning} | {kind.private or 'kept'} |"
        for name, kind in sorted(EVENTS.items())
    ]
    assert re.findall(r"^\| `.*$", text, re.MULTILINE) == rows


def test_every_file_and_column_is_declared_with_what_a_copy_has_to_keep_for_it():
    assert {each.FILE for each in ALL} == SHARED.keys()
    for row_type in ALL:
        more = ("group", *FACTS) if row_type is ParticipantRow else ()
        declared = SHARED[row_type.FILE].columns
        assert set(declared) == {*row_type.columns(), *more}, row_type.FILE


def test_every_column_of_exported_tables_is_described():
    tables = (
        TrialRow, QuestionnaireRow, RatingRow, TaskRow, DialRow, TextRow, ScreeningRow, PracticeRow,
    )  # fmt: skip
    assert {name for each in tables for name in each.columns()} <= MEANINGS.keys()


OF_THE_GAZE = re.compile("gaze|pupil|accuracy|precision")
OF_THE_FOCUS = re.compile("^(focus|ray)")


def test_what_tells_of_gaze_or_focus_needs_them_to_be_kept():
    for name, file in SHARED.items():
        for column, needs in file.columns.items():
            if OF_THE_GAZE.search(f"{name} {column}"):
                assert "gaze" in needs | file.needs, (name, column)
            if OF_THE_FOCUS.search(column):
                assert needs | file.needs == BOTH, (name, column)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_gaze(tmp_path_factory.mktemp("recorded"), PRACTICE)


@pytest.fixture
def study(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "S"))


def with_all_files(study: Path) -> None:
    """Add what a session can have besides: a row of each, every number 0."""
    session = study / "sub-P01/ses-1"
    (frame, *_), (trial, *_) = (read_rows(session / f"{name}.csv") for name in ("frames", "trials"))
    times = {name: frame[name] for name in ("session_s", "xr_time_ns")}
    words = {"kind": "sample", "eye": "left", "decision": "go_on", "number": "1", "resumed": "0"}
    known = {**trial, **times, **words, "onset_s": trial["end_s"]}
    for row_type in OPTIONAL_ROWS:
        file = session / row_type.FILE
        if not file.exists():
            cells = (known.get(name, "0") for name in row_type.columns())
            file.write_text(f"{','.join(row_type.columns())}\n{','.join(cells)}\n")
    (session / "checksums.sha256").unlink()
    people = (study / "participants.csv").read_text().splitlines()
    (study / "participants.csv").write_text(f"{people[0]},{FACTS[0]},age\n{people[1]},1.25,30\n")


@pytest.mark.parametrize(
    ("wishes", "kept"),
    [
        (Wishes(), ALWAYS),
        (Wishes(keep_motion=True), MOTION),
        (Wishes(keep_gaze=True), GAZE),
        (Wishes(keep_motion=True, keep_gaze=True), BOTH),
    ],
)
def test_a_copy_has_what_is_declared_and_says_so(study, tmp_path, wishes, kept):
    with_all_files(study)
    record = anonymise(study, tmp_path / "out", wishes)
    session = tmp_path / "out/sub-P01/ses-1"
    said = record["still_there"]["columns"]
    for row_type in (*SESSION_ROWS, *OPTIONAL_ROWS):
        name, file = row_type.FILE, session / row_type.FILE
        assert file.exists() == (SHARED[name].needs <= kept) == (name in said), name
        assert (name in record["files_left_out"]) != (name in said)
        if not file.exists():
            continue
        header, *lines = (line.split(",") for line in file.read_text().splitlines())
        filled = {c for row in lines for c, value in zip(header, row, strict=False) if value}
        assert filled <= set(said[name]), name
        assert set(header) - set(said[name]) == set(record["columns_blank"].get(name, ()))
    people = (tmp_path / "out" / "participants.csv").read_text()
    assert ("1.25" in people) == (FACTS[0] in people) == (kept >= GAZE)
    assert ",30" in people
    assert json.loads((tmp_path / "out" / "anonymised.json").read_text()) == record


def test_an_event_that_is_not_known_is_told_and_not_silently_blank(study, tmp_path, run):
    session = study / "sub-P01/ses-1"
    lines = (session / "events.csv").read_text().splitlines(keepends=True)
    place = next(n for n, line in enumerate(lines) if ",exposure," in line)
    onset_s = lines[place].split(",")[0]
    lines.insert(place + 1, f"{onset_s},0.0,of_the_future,a secret,0\n")
    (session / "events.csv").write_text("".join(lines))
    (session / "checksums.sha256").unlink()
    code, _, err = run("anonymise", study, "--out", tmp_path / "out")
    assert code == 0
    assert "details of events `of_the_future` are left out" in " ".join(err.split())
    (told,) = export_bids(study, tmp_path / "bids")
    assert "details of events `of_the_future`, which this version does not know" in told
    written = [*(tmp_path / "bids").rglob("*_events.tsv"), *(tmp_path / "out").rglob("events.csv")]
    assert any("of_the_future" in file.read_text() for file in written)
    assert not any("a secret" in file.read_text() for file in written)


NOVEL = "novel_m"


@pytest.fixture
def _a_column_more(monkeypatch):
    """A version to come, in which each file of a session has another column."""
    version = schema.SCHEMA_VERSION + 1
    files = {each.FILE: (NOVEL,) for each in (*SESSION_ROWS, *OPTIONAL_ROWS)}
    monkeypatch.setattr(schema, "ADDED_COLUMNS", {**schema.ADDED_COLUMNS, version: files})
    for name, module in list(sys.modules.items()):
        if name.startswith("vrcomfort") and hasattr(module, "SCHEMA_VERSION"):
            monkeypatch.setattr(module, "SCHEMA_VERSION", version)
    for row_type in (*SESSION_ROWS, *OPTIONAL_ROWS):
        columns = (*row_type.columns(), NOVEL)
        monkeypatch.setattr(row_type, "columns", classmethod(lambda _, c=columns: c))


@pytest.mark.slow
@pytest.mark.usefixtures("_a_column_more")
def test_an_older_study_is_whole_without_a_column_that_came_later(
    study, tmp_path, run, monkeypatch
):
    monkeypatch.setattr(practice, "MEANINGS", {**MEANINGS, NOVEL: "Something new"})
    session = study / "sub-P01/ses-1"
    assert NOVEL not in (session / "trials.csv").read_text()
    found = verify_study(study)
    assert found.faults == []
    notes = [each.message for each in found.notes if each.file == "sub-P01/ses-1/manifest.json"]
    old, new = schema.SCHEMA_VERSION - 1, schema.SCHEMA_VERSION
    assert notes[0].startswith(f"recorded in schema version {old} (now {new}), without")
    assert f"trials.csv: {NOVEL}; " in notes[0]
    assert build_report(study, out=tmp_path / "report").index.exists()
    assert len(read_session(session).exposures) == 2
    assert export_bids(study, tmp_path / "bids") == []
    assert run("export", study, "--format", "psych-ds", "--out", tmp_path / "psych")[0] == 0
    anonymise(study, tmp_path / "out", Wishes())
    assert verify_study(tmp_path / "out").faults == []
    for row_type in SESSION_ROWS:  # as where the session goes on
        before = (session / row_type.FILE).read_bytes()
        assert mend(session, row_type, OWNER) is None
        assert (session / f"{row_type.FILE}.schema{old}").read_bytes() == before
    assert NOVEL in (session / "trials.csv").read_text().splitlines()[0]


SNAPSHOTS = ROOT / "tests" / "data" / "columns_of_schema"


@pytest.mark.parametrize("version", range(1, schema.SCHEMA_VERSION + 1))
def test_the_columns_of_a_version_stay_what_they_are(version):
    """A column that is not declared as a later version's would make older studies damaged."""
    file = SNAPSHOTS / f"{version}.json"
    now = {
        each.FILE: list(schema.columns_of_version(version, each.FILE, each.columns()))
        for each in (*SESSION_ROWS, *OPTIONAL_ROWS)
    }
    then = json.loads(file.read_text("utf-8"))
    hint = "declare new columns in ADDED_COLUMNS, in a new version"
    assert {name: now[name] for name in then} == then, hint
