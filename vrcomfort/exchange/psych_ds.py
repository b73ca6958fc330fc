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
from vrcomfort.records.study import DESCRIPTION, read_description

_README = """# {name}

A comfort study recorded with vrcomfort (protocol `{protocol}`) and exported as Psych-DS.

- `{participants}`: a row for each participant.
- `{trials}`: a row for each attempt at an exposure; participant, session, trial and attempt are
  its key.
- `{questionnaires}`: a row for each answer; participant, session, trial, timepoint, instrument and
  item are its key.
- `{ratings}`: a row for each rating during an exposure.
- `{events}`: a row for each event of a session, in its order. Details that may tell who a
  participant is are blank.
{more}"""

_OPTIONAL: Mapping[type[Row], str] = {
    TaskRow: "- `{tasks}`: a row for each target, shot and sample of a task, and for each trial\n"
    "  that had one.\n",
    TextRow: "- `{texts}`: a row for each answer in one's own words, which may tell who gave it;\n"
    "  in `text`, `\\n` is a line end and `\\\\` a backslash.\n",
    ScreeningRow: "- `{screening}`: a row for each number beyond a screening rule.\n",
    PracticeRow: "- `{practice}`: a row for each exposure of practice, which is no trial.\n",
    DialRow: "- `{dials}`: a row for each turn of a dial, and each sample of a slider.\n",
}
"""What not every study has, and what is said of it."""
_RECORDINGS: Mapping[type[Row], str] = {
    FrameRow: "- `data/study-{label}_subject-*_session-*_description-frames_data.csv`: a row for\n"
    "  each frame of a session.\n",
    GazeRow: "- `data/study-{label}_subject-*_session-*_description-gaze_data.csv`: a row for\n"
    "  each frame of a session whose headset tracked the eyes.\n",
}
"""What has a file for each session, for it is long, and what is said of it."""
_WHOSE = ("participant", "session")
_TABLES = (
    ParticipantRow, TrialRow, QuestionnaireRow, RatingRow, EventRow, *_OPTIONAL, *_RECORDINGS
)  # fmt: skip


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


def export_psych_ds(study: Path, out: Path, choice: Choice = EVERYTHING) -> list[str]:
    """Write a study as a Psych-DS dataset into a new folder; return its omissions.

    Raises
    ------
    InputError
        If the study is an import or not whole, or the folder is there already.
    """
    faults = require_whole(study, choice)
    description = read_description(study)
    name, protocol = str(description.get("name") or study.name), str(description["protocol"])
    label = re.sub("[^A-Za-z0-9]", "", protocol) or "comfort"
    read = Study(study, without=choice.without)
    tables = [_participants(read, label)]
    tables += [_of_sessions(read, label, kind) for kind in (TrialRow, QuestionnaireRow, RatingRow)]
    tables.append(events := _events(read, label))
    some = {kind: _of_sessions(read, label, kind) for kind in _OPTIONAL}
    tables += [table for table in some.values() if table.rows]
    there = [table for table in tables if table.rows]
    with new_folder(study, out) as draft:
        (draft / "data").mkdir(parents=True)
        for table in there:
            with (draft / "data" / table.file).open("w", encoding="utf-8", newline="") as stream:
                csv.writer(stream, lineterminator="\n").writerows([table.columns, *table.rows])
        recordings = list(_write_recordings(read, label, draft / "data"))
        names = {kind: f"data/{_file(label, kind)}" for kind in _KINDS}
        more = [_OPTIONAL[kind].format(**names) for kind, table in some.items() if table.rows]
        more += [_RECORDINGS[kind].format(label=label) for kind in recordings]
        readme = _README.format(name=name, protocol=protocol, more="".join(more), **names)
        readme += said_of(choice, faults)
        (draft / "README.md").write_text(readme, encoding="utf-8")
        columns = [*(each.columns for each in there), *(each.columns() for each in recordings)]
        content = _description(name, protocol, str(description.get("citation") or ""), columns)
        text = json_of(content) + "\n"
        (draft / DESCRIPTION).write_text(text, encoding="utf-8")
    empty = [table.file for table in tables if not table.rows]
    told = [f"{file}: the study has no rows of it" for file in empty]
    return told + [
        f"details of events `{each}`, which this version does not know"
        for each in sorted(set(events.column("name")) - EVENTS.keys())
    ]


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


def _write_recordings(study: Study, label: str, data: Path) -> Iterator[type[Row]]:
    """Write each session's frames and gaze, row by row; yield the kinds of rows there are."""
    for kind in _RECORDINGS:
        columns, there = kind.columns(), False
        for session in _sessions(study):
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


def _description(
    name: str, protocol: str, citation: str, tables: Sequence[Sequence[str]]
) -> dict[str, object]:
    columns = list(dict.fromkeys(column for table in tables for column in table))
    said: dict[str, object] = {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": name,
        "description": f"Comfort study recorded with vrcomfort {__version__}, protocol {protocol}.",
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
    return said | ({"citation": citation} if citation else {})
