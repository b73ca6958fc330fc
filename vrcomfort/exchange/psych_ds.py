"""A study as a Psych-DS dataset: its tables, each column described.

Psych-DS 1.5.1 (https://psych-ds.github.io): tables in ``data/`` whose names are keywords and values
and end in ``_data.csv``, and a ``dataset_description.json`` that describes every column.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vrcomfort import __version__
from vrcomfort.exchange.export_checks import new_folder, require_whole, said_of
from vrcomfort.exchange.imports import TABLES as IMPORTED
from vrcomfort.exchange.imports import Import, is_import
from vrcomfort.json_text import json_of
from vrcomfort.records.choice import EVERYTHING, Choice
from vrcomfort.records.events import EVENTS, shared_detail
from vrcomfort.records.exposure_rows import DialRow, PracticeRow, RatingRow, TaskRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.rows import Row
from vrcomfort.records.schema import described, unit_of
from vrcomfort.records.session_rows import (
    EventRow,
    ParticipantRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)
from vrcomfort.records.study import DESCRIPTION

_README = """# {name}

{origin} and exported as Psych-DS.

{files}"""

_SAID: Mapping[type[Row], str] = {
    ParticipantRow: "- `{participants}`: a row for each participant.\n",
    TrialRow: "- `{trials}`: a row for each attempt at an exposure; participant, session, trial\n"
    "  and attempt are its key.\n",
    QuestionnaireRow: "- `{questionnaires}`: a row for each answer; participant, session, trial,\n"
    "  timepoint, instrument and item are its key.\n",
    RatingRow: "- `{ratings}`: a row for each rating during an exposure.\n",
    EventRow: "- `{events}`: a row for each event of a session, in its order. Details that may\n"
    "  tell who a participant is are blank.\n",
    TaskRow: "- `{tasks}`: a row for each target, shot and sample of a task, and for each trial\n"
    "  that had one.\n",
    TextRow: "- `{texts}`: a row for each answer in one's own words, which may tell who gave it;\n"
    "  in `text`, `\\n` is a line end and `\\\\` a backslash.\n",
    ScreeningRow: "- `{screening}`: a row for each number beyond a screening rule.\n",
    PracticeRow: "- `{practice}`: a row for each exposure of practice, which is no trial.\n",
    DialRow: "- `{dials}`: a row for each turn of a dial, and each sample of a slider.\n",
}
"""What is said of each table."""
_EXPECTED = {ParticipantRow, TrialRow, QuestionnaireRow, RatingRow, EventRow}
"""What every study has: where there are no rows of it, it is said."""
_RECORDINGS: Mapping[type[Row], str] = {
    FrameRow: "- `data/study-{label}_subject-*_session-*_description-frames_data.csv`: a row for\n"
    "  each frame of a session.\n",
    GazeRow: "- `data/study-{label}_subject-*_session-*_description-gaze_data.csv`: a row for\n"
    "  each frame of a session whose headset tracked the eyes.\n",
}
"""What has a file for each session, for it is long, and what is said of it."""
_WHOSE = ("participant", "session")
_TABLES = (*_SAID, *_RECORDINGS)


@dataclass(frozen=True)
class _Table:
    """One file of the dataset."""

    file: str
    columns: tuple[str, ...]
    rows: list[list[str]]

    def column(self, name: str) -> list[str]:
        """Return the cells of a column."""
        place = self.columns.index(name)
        return [row[place] for row in self.rows]


@dataclass(frozen=True)
class _Source:
    """An exported study.

    Parameters
    ----------
    origin
        Of the study, as the README says it.
    """

    name: str
    label: str
    origin: str
    citation: str
    tables: Mapping[type[Row], _Table]
    study: Study | None = None
    """With the recordings; an import has none."""


def export_psych_ds(study: Path, out: Path, choice: Choice = EVERYTHING) -> list[str]:
    """Write a study as a Psych-DS dataset into a new folder; return its omissions.

    Raises
    ------
    InputError
        If the study is not whole, or the folder is there already.
    """
    faults = require_whole(study, choice)
    if is_import(study):
        source = _imported(Import(study))
    else:
        source = _recorded(Study(study, without=choice.without))
    there = {kind: table for kind, table in source.tables.items() if table.rows}
    with new_folder(study, out) as draft:
        (draft / "data").mkdir(parents=True)
        for table in there.values():
            with (draft / "data" / table.file).open("w", encoding="utf-8", newline="") as stream:
                csv.writer(stream, lineterminator="\n").writerows([table.columns, *table.rows])
        recordings = list(_write_recordings(source, draft / "data"))
        names = {kind: f"data/{_file(source.label, kind)}" for kind in _KINDS}
        files = [_SAID[kind].format(**names) for kind in there]
        files += [_RECORDINGS[kind].format(label=source.label) for kind in recordings]
        readme = _README.format(name=source.name, origin=source.origin, files="".join(files))
        readme += said_of(choice, faults)
        (draft / "README.md").write_text(readme, encoding="utf-8")
        columns = [each.columns for each in there.values()]
        columns += [each.columns() for each in recordings]
        text = json_of(_description(source, columns)) + "\n"
        (draft / DESCRIPTION).write_text(text, encoding="utf-8")
    return list(_omissions(source))


def _omissions(source: _Source) -> Iterator[str]:
    for kind, table in source.tables.items():
        if kind in _EXPECTED and not table.rows:
            yield f"{table.file}: the study has no rows of it"
    if EventRow in source.tables:
        for each in sorted(set(source.tables[EventRow].column("name")) - EVENTS.keys()):
            yield f"details of events `{each}`, which this version does not know"


def _recorded(study: Study) -> _Source:
    content = study.description
    protocol = str(content["protocol"])
    label = re.sub("[^A-Za-z0-9]", "", protocol) or "comfort"
    tables = {
        kind: _of_sessions(study, label, kind)
        for kind in _SAID
        if kind not in {ParticipantRow, EventRow}
    } | {ParticipantRow: _participants(study, label), EventRow: _events(study, label)}
    return _Source(
        str(content.get("name") or study.folder.name),
        label,
        f"A comfort study recorded with vrcomfort (protocol `{protocol}`)",
        str(content.get("citation") or ""),
        {kind: tables[kind] for kind in _SAID},
        study,
    )


def _imported(source: Import) -> _Source:
    name = source.name
    label = re.sub("[^A-Za-z0-9]", "", name) or "comfort"
    tables: dict[type[Row], _Table] = {}
    for kind in IMPORTED:
        table = source.table(kind)
        kept = [at for at, column in enumerate(table.header) if column != "note"]
        columns = tuple(table.header[at] for at in kept)
        rows = [[row[at] for at in kept] for row in table.rows]
        tables[kind] = _Table(_file(label, Path(kind.FILE).stem), columns, rows)
    origin = "Answers of another program's study, imported with vrcomfort"
    return _Source(name, label, origin, "", tables)


_KINDS = (
    "participants",
    "trials",
    "questionnaires",
    "ratings",
    "events",
    "tasks",
    "dials",
    "texts",
    "screening",
    "practice",
)


def _file(label: str, kind: str, participant: str = "", session: str = "") -> str:
    whose = f"subject-{participant}_session-{session}_" if participant else ""
    return f"study-{label}_{whose}description-{kind}_data.csv"


def _participants(study: Study, label: str) -> _Table:
    rows = study.enrolled
    others = list(dict.fromkeys(name for row in rows for name, _ in row.others))
    own = [name for name in ParticipantRow.columns() if name != "note"]
    cells = [
        [str(getattr(row, name)) for name in own]
        + [dict(row.others).get(name, "") for name in others]
        for row in rows
    ]
    return _Table(_file(label, "participants"), (*own, *others), cells)


def _sessions(study: Study) -> Iterator[Session]:
    for person in study.enrolled:
        yield from study.sessions_of(person.participant)


def _of_sessions(study: Study, label: str, row_type: type[Row]) -> _Table:
    """Return the rows of one kind of file, of all sessions."""
    columns = row_type.columns()
    rows = [
        [row.get(name, "") for name in columns]
        for session in _sessions(study)
        for row in session.text_rows(row_type)
    ]
    return _Table(_file(label, Path(row_type.FILE).stem), columns, rows)


def _events(study: Study, label: str) -> _Table:
    """Return the events of all sessions, without private details."""
    columns = EventRow.columns()
    rows = [
        [session.participant, str(session.number), *(row.get(name, "") for name in columns)]
        for session in _sessions(study)
        for row in map(_without_private_detail, session.text_rows(EventRow))
    ]
    return _Table(_file(label, "events"), (*_WHOSE, *columns), rows)


def _without_private_detail(row: dict[str, str]) -> dict[str, str]:
    return {**row, "detail": shared_detail(row["name"], row["detail"])}


def _write_recordings(source: _Source, data: Path) -> Iterator[type[Row]]:
    """Write each session's frames and gaze, row by row; yield the kinds of rows there are."""
    label = source.label
    sessions = list(_sessions(source.study)) if source.study else []
    for kind in _RECORDINGS:
        columns, there = kind.columns(), False
        for session in sessions:
            rows = session.text_rows(kind)
            if (first := next(rows, None)) is None:
                continue
            there = True
            name = _file(label, Path(kind.FILE).stem, session.participant, str(session.number))
            with (data / name).open("w", encoding="utf-8", newline="") as stream:
                table = csv.writer(stream, lineterminator="\n")
                table.writerow(columns)
                table.writerows([row.get(each, "") for each in columns] for row in (first, *rows))
        if there:
            yield kind


def _description(source: _Source, tables: Sequence[Sequence[str]]) -> dict[str, object]:
    columns = list(dict.fromkeys(column for table in tables for column in table))
    said: dict[str, object] = {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": source.name,
        "description": f"{source.origin}; exported with vrcomfort {__version__}.",
        "variableMeasured": [
            {
                "@type": "PropertyValue",
                "name": column,
                "description": described(column, _TABLES)
                or f"{column}, as entered at the enrolment",
                **({"unitText": unit} if (unit := unit_of(column, _TABLES)) else {}),
            }
            for column in columns
        ],
    }
    return said | ({"citation": source.citation} if source.citation else {})
