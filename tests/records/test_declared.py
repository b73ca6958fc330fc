"""Files, columns and events of a study are declared once: exports and copies derive from that."""

from __future__ import annotations

import ast
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import NoneType
from typing import Annotated, get_args, get_origin, get_type_hints

import pytest

import vrcomfort
from tests.support.exchange import PRACTICE, errors_of, with_gaze
from tests.support.places import ROOT
from tests.support.report import build_report
from tests.support.study import read_rows
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.bids import export_bids
from vrcomfort.exchange.psych_ds import export_psych_ds
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.headset.timing import RATE_CHANGED, RATE_RESTORED
from vrcomfort.operator_interface import ALLOWED
from vrcomfort.records import rows, schema
from vrcomfort.records.disk import OWNER
from vrcomfort.records.events import EVENTS, EventKind
from vrcomfort.records.interrupted import repair_table
from vrcomfort.records.recording import kinds
from vrcomfort.records.rows import ALWAYS, BOTH, GAZE, MOTION, Column, Row, declared
from vrcomfort.records.schema import (
    OPTIONAL_ROWS,
    SESSION_ROWS,
    TABLES,
    SharedFile,
    data_dictionary,
)
from vrcomfort.records.session_rows import FACTS, QuestionnaireRow
from vrcomfort.replay.recorded import read_session
from vrcomfort.report.study_data import _NEEDED_ELSEWHERE, _NUMBERS, NEEDED

NOT_WRITTEN_OUT = {
    "headset/openxr/instance.py": {"openxr_error", "openxr_warning"},
    "headset/openxr/lifecycle.py": {
        *("focused", "unfocused", "headset_on", "headset_off"),
        *("controller_found", "controller_lost"),
    },
    "headset/timing.py": {RATE_CHANGED, RATE_RESTORED},
    "headset/openxr/tracking.py": {"tracking_found", "tracking_lost"},
    "session/context.py": set(),  # names that it is given
    "session/eye_height.py": {"eye_height"},
    "session/flow.py": {"ended", "withdrawn", "runtime_hung", "session_resumed"},
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


def test_the_data_dictionary_is_up_to_date():
    page = ROOT / "docs" / "data_dictionary.md"
    assert page.read_text("utf-8") == data_dictionary(), "run python scripts/data_dictionary.py"


def test_every_column_is_declared_whole():
    for name, table in TABLES.items():
        hints = get_type_hints(table, include_extras=True)
        for column in (*declared(table), *table.FURTHER):
            assert re.fullmatch(r".+[^.\s]", column.meaning), (name, column.name)
            hint = hints.get(column.name)
            if get_origin(hint) is Annotated and NoneType in get_args(get_args(hint)[0]):
                assert column.blank, f"{name}: say what a blank {column.name} means"
        assert len(set(table.columns())) == len(table.columns()), name


def test_what_the_report_needs_are_columns_of_the_schema():
    """A report reads tables of others, too, so its needs are its own; its words are these."""
    for table, needed in _NEEDED_ELSEWHERE.items():
        assert set(needed) <= set(table.columns()), table.FILE
    known = {column.name: column for table in TABLES.values() for column in declared(table)}
    assert all(known[name].type is not str for name in _NUMBERS)
    assert {*NEEDED} <= set(QuestionnaireRow.columns())


OF_THE_GAZE = re.compile("gaze|pupil|accuracy|precision")
OF_THE_FOCUS = re.compile("^(focus|ray)")


def test_what_tells_of_gaze_or_focus_needs_them_to_be_kept():
    for name, table in TABLES.items():
        file = SharedFile.of(table)
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
        (AnonymisingOptions(), ALWAYS),
        (AnonymisingOptions(keep_motion=True), MOTION),
        (AnonymisingOptions(keep_gaze=True), GAZE),
        (AnonymisingOptions(keep_motion=True, keep_gaze=True), BOTH),
    ],
)
def test_a_copy_has_what_is_declared_and_says_so(study, tmp_path, wishes, kept):
    with_all_files(study)
    record = anonymise(study, tmp_path / "out", wishes)
    session = tmp_path / "out/sub-P01/ses-1"
    said = record["still_there"]["columns"]
    for row_type in (*SESSION_ROWS, *OPTIONAL_ROWS):
        name, file = row_type.FILE, session / row_type.FILE
        assert file.exists() == (kept >= TABLES[name].NEEDS) == (name in said), name
        assert (name in record["files_left_out"]) != (name in said)
        if not file.exists():
            continue
        header, *lines = (line.split(",") for line in file.read_text().splitlines())
        filled = {c for row in lines for c, value in zip(header, row, strict=False) if value}
        assert filled <= set(said[name]), name
        assert set(header) - set(said[name]) == set(record["columns_blank"].get(name, ()))
        classes = {each.name: row_type.NEEDS | each.needs for each in declared(row_type)}
        for column, told in said[name].items():
            assert classes[column] == frozenset(told.split(" and ")) - {"none"}, (name, column)
    assert said["participants.csv"]["age"] == "covariate"
    people = (tmp_path / "out" / "participants.csv").read_text()
    assert ("1.25" in people) == (FACTS[0] in people) == (kept >= GAZE)
    assert ",30" in people
    assert json.loads((tmp_path / "out" / "anonymised.json").read_text()) == record


def test_an_event_that_is_not_known_is_told_and_not_silently_blank(study, tmp_path, run):
    add_event(study / "sub-P01/ses-1", "of_the_future", "a secret")
    code, _, err = run("anonymise", study, "--out", tmp_path / "out")
    assert code == 0
    assert "details of events `of_the_future` are left out" in " ".join(err.split())
    (told,) = export_bids(study, tmp_path / "bids")
    assert "details of events `of_the_future`, which this version does not know" in told
    written = [*(tmp_path / "bids").rglob("*_events.tsv"), *(tmp_path / "out").rglob("events.csv")]
    assert any("of_the_future" in file.read_text() for file in written)
    assert not any("a secret" in file.read_text() for file in written)


NOVEL = "novel_ms"
NOVEL_EVENT = "bell_rang"


def add_event(session: Path, name: str, detail: str) -> None:
    """Add an event at the beginning of the first exposure."""
    file = session / "events.csv"
    header, *lines = file.read_text().splitlines(keepends=True)
    place = next(n for n, line in enumerate(lines) if ",exposure," in line)
    cells = {"onset_s": lines[place].split(",")[0], "duration_s": "0.0", "name": name}
    cells |= {"detail": detail, "resumed": "0"}
    lines.insert(place + 1, ",".join(cells.get(c, "") for c in header.strip().split(",")) + "\n")
    file.write_text("".join([header, *lines]))
    (session / "checksums.sha256").unlink()


def all_text(folder: Path) -> str:
    return "".join(
        f.read_text() for f in folder.rglob("*") if f.suffix in {".tsv", ".csv", ".json"}
    )


def declare(monkeypatch: pytest.MonkeyPatch, table: type[Row], column: Column) -> None:
    """Declare a column of a table, as one more line in the class of its rows does it."""
    new = {**table.__annotations__, NOVEL: Annotated[float | None, column]}
    monkeypatch.setattr(table, "__annotations__", new)
    monkeypatch.setattr(table, NOVEL, 1.5, raising=False)
    monkeypatch.setattr(rows, "_LAYOUTS", {})


@pytest.fixture
def _a_column_more(monkeypatch):
    """A version to come, in which each file of a session has another column."""
    version = schema.SCHEMA_VERSION + 1
    column = Column(
        "Something new", blank="not recorded", since=version, needs=MOTION, channel="MISC"
    )
    for row_type in (*SESSION_ROWS, *OPTIONAL_ROWS):
        declare(monkeypatch, row_type, column)
    for name, module in list(sys.modules.items()):
        if name.startswith("vrcomfort") and hasattr(module, "SCHEMA_VERSION"):
            monkeypatch.setattr(module, "SCHEMA_VERSION", version)


@pytest.mark.slow
@pytest.mark.usefixtures("_a_column_more")
def test_an_older_study_is_whole_without_a_column_that_came_later(study, tmp_path, run):
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
    anonymise(study, tmp_path / "out", AnonymisingOptions())
    assert verify_study(tmp_path / "out").faults == []
    for row_type in SESSION_ROWS:  # as where the session goes on
        before = (session / row_type.FILE).read_bytes()
        assert repair_table(session, row_type, OWNER) is None
        assert (session / f"{row_type.FILE}.schema{old}").read_bytes() == before
    assert NOVEL in (session / "trials.csv").read_text().splitlines()[0]


@pytest.mark.slow
@pytest.mark.usefixtures("_a_column_more")
def test_a_column_and_an_event_are_declared_in_one_place_each(tmp_path, monkeypatch):
    kind = EventKind("A bell rang", private="it may tell where people were")
    monkeypatch.setitem(EVENTS, NOVEL_EVENT, kind)
    study = with_gaze(tmp_path, PRACTICE)
    session = study / "sub-P01/ses-1"
    assert {row[NOVEL] for row in read_rows(session / "frames.csv")} == {"1.5"}
    assert kinds((NOVEL,)) == {NOVEL: "DOUBLE"}
    add_event(session, NOVEL_EVENT, "in the tower")
    assert verify_study(study).faults == []
    assert f"| `{NOVEL}` | number, ms | Something new |" in data_dictionary()
    assert f"| `{NOVEL_EVENT}` | A bell rang |" in data_dictionary()

    assert export_bids(study, tmp_path / "bids") == []
    assert errors_of(tmp_path / "bids") == []
    channels = next((tmp_path / "bids").rglob("*tracksys-head*_channels.tsv")).read_text()
    (line,) = (line for line in channels.splitlines() if line.startswith(f"{NOVEL}\t"))
    assert line.split("\t")[2:5] == ["MISC", "n/a", "ms"]
    events = [json.loads(f.read_text()) for f in (tmp_path / "bids").rglob("*_events.json")]
    assert "A bell rang" in {e["trial_type"]["Levels"].get(NOVEL_EVENT) for e in events}
    assert "in the tower" not in all_text(tmp_path / "bids")

    export_psych_ds(study, tmp_path / "psych")
    description = json.loads((tmp_path / "psych" / "dataset_description.json").read_text())
    (variable,) = (v for v in description["variableMeasured"] if v["name"] == NOVEL)
    assert variable["description"] == "Something new; blank: not recorded"
    assert variable["unitText"] == "ms"
    frames = list((tmp_path / "psych" / "data").glob("*_description-frames_data.csv"))
    assert {row[NOVEL] for file in frames for row in read_rows(file)} == {"1.5"}
    assert f",{NOVEL_EVENT}," in all_text(tmp_path / "psych")
    assert "in the tower" not in all_text(tmp_path / "psych")

    anonymise(study, tmp_path / "out", AnonymisingOptions())
    copy = tmp_path / "out/sub-P01/ses-1"
    assert {row[NOVEL] for row in read_rows(copy / "frames.csv")} == {""}
    assert "in the tower" not in all_text(tmp_path / "out")
    assert verify_study(tmp_path / "out").faults == []


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
    hint = "declare new columns with `since`, in a new version"
    assert {name: now[name] for name in then} == then, hint
