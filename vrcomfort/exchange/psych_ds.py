"""A study as a Psych-DS dataset: its tables, each column described.

Psych-DS 1.5.1 (https://psych-ds.github.io): tables in ``data/`` whose names are keywords and values
and end in ``_data.csv``, and a ``dataset_description.json`` that describes every column.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vrcomfort import __version__
from vrcomfort.csv_table import CsvTable
from vrcomfort.exchange.room import new_folder, require_whole
from vrcomfort.records.json_file import read_json
from vrcomfort.records.manifest_shape import DescriptionShape
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.rows import (
    DialRow,
    ParticipantRow,
    QuestionnaireRow,
    RatingRow,
    Row,
    ScreeningRow,
    TaskRow,
    TextRow,
    TrialRow,
)
from vrcomfort.records.study import DESCRIPTION, read_participants, recorded_sessions

_README = """# {name}

A comfort study recorded with vrcomfort (protocol `{protocol}`) and exported as Psych-DS.

- `{participants}`: a row for each participant.
- `{trials}`: a row for each attempt at an exposure; participant, session, trial and attempt are
  its key.
- `{questionnaires}`: a row for each answer; participant, session, trial, timepoint, instrument and
  item are its key.
- `{ratings}`: a row for each rating during an exposure.
{more}
Frames, gaze and events are not in it: the study has them, and `vrcomfort export --format bids`.
"""

_OPTIONAL: Mapping[type[Row], str] = {
    TaskRow: "- `{tasks}`: a row for each target, shot and sample of a task, and for each trial\n"
    "  that had one.\n",
    TextRow: "- `{texts}`: a row for each answer in one's own words, which may tell who gave it;\n"
    "  in `text`, `\\n` is a line end and `\\\\` a backslash.\n",
    ScreeningRow: "- `{screening}`: a row for each number beyond a screening rule.\n",
    DialRow: "- `{dials}`: a row for each turn of a dial, and each sample of a slider.\n",
}
"""What not every study has, and what is said of it."""

_MEANINGS: Mapping[str, str] = {
    "participant": "Identifier of a participant",
    "sequence": "The order of conditions and scenes, as the protocol names it",
    "status": "Of a participant: enrolled, completed, withdrawn or excluded. Of a trial: "
    "completed, withdrawn (by the participant), stopped (by the stop rule), "
    "skipped (by an operator) or aborted",
    "enrolled_at": "When the participant was enrolled, ISO 8601",
    "group": "Level of the between-subject factor",
    "session": "Number of the session, from 1",
    "period": "Place of the exposure among all of the participant's, from 1",
    "block": "Number of the block in the session, from 1",
    "trial": "Number of the exposure in the session, from 1; blank where the session is meant",
    "condition": "Condition of the protocol; blank where the session is meant",
    "scene": "Scene that was shown",
    "start_s": "Begin of the exposure on the session's clock, in seconds",
    "end_s": "End of the exposure on the session's clock, in seconds",
    "abort_code": "What ended an exposure early",
    "attempt": "1, and one more each time that the exposure was begun again",
    "resumed": "1 where it was recorded after the session was resumed",
    "frames": "Frames that were shown",
    "dropped": "Frames whose interval exceeded 1.2 times the frame period",
    "missed_refreshes": "Refreshes of the display without a new frame",
    "live_s": "Seconds in which frames came",
    "frozen_s": "Seconds in which the picture stood still",
    "hidden_s": "Seconds in which the participant saw nothing of the frames",
    "unfocused_s": "Seconds in which a menu of the headset's was in front",
    "part": "Part of the study, where it has parts with orders of their own",
    "timepoint": "When in the session it was asked, as the protocol names it",
    "instrument": "Questionnaire or rating scale",
    "item": "Question of the instrument",
    "response": "The answer, as the instrument codes it; blank: rather not say, or missed",
    "asked_s": "When it was asked on the session's clock, in seconds",
    "answered_s": "When it was answered on the session's clock, in seconds",
    "order": "Place in the presentation, from 1",
    "onset_s": "When it began, or was asked, on the session's clock, in seconds",
    "latency_s": "Seconds until the rating came; blank where it was missed",
    "missed": "0 where a rating came in time, else 1, or the protocol's `missed_code`",
    "task": "What was done during the exposure, as the protocol names it",
    "kind": "Of a row of a task: target, shot, sample or (the whole) trial; of a dial: start, "
    "change, sample, confirmed or end",
    "dial": "The dial that was turned, as the protocol names it",
    "rule": "What was beyond which bound of a screening rule",
    "decision": "What the experimenter decided: go_on or stop",
    "decided_s": "When it was decided on the session's clock, in seconds",
    "question": "What was asked to be answered in one's own words, as the protocol names it",
    "text": "The answer in one's own words, in one line; blank: nothing was said",
    "setting": "What an adjustment changes in the condition",
    "value": "Where the dial stood from then on, in the unit of what it changes; of a screening "
    "rule, the number that was beyond its bound",
    "number": "Counts the rows of one kind in an attempt, from 1",
    "what": "Name of the target",
    "reaction_s": "Seconds from the beginning of a target until it was met",
    "hit": "1 for a target that was met and a shot that met one, else 0",
    "error_deg": "Degrees between where was pointed or looked and the middle of the target",
    "distance_m": "Metres to the target, from the path, or of the way that was gone",
    "x_m": "Place of the target, or of the head in a sample, in metres (right)",
    "y_m": "The same, upwards",
    "z_m": "The same, backwards",
    "targets": "Targets of a trial",
    "hits": "Targets that were met in a trial",
    "shots": "Shots of a trial",
    "score": "What the task is about, of a trial",
}


@dataclass(frozen=True)
class _Table:
    """One file of the dataset."""

    file: str
    columns: tuple[str, ...]
    rows: list[list[str]]


def export_psych_ds(study: Path, out: Path) -> list[str]:
    """Write a study as a Psych-DS dataset into a new folder; return what was left out.

    Raises
    ------
    InputError
        If the study is an import or not whole, or the folder is there already.
    """
    require_whole(study)
    description = read_json(study / DESCRIPTION, DescriptionShape, "study description")
    name, protocol = str(description.get("name") or study.name), str(description["protocol"])
    label = re.sub("[^A-Za-z0-9]", "", protocol) or "comfort"
    tables = [_participants(study, label)]
    tables += [_of_sessions(study, label, kind) for kind in (TrialRow, QuestionnaireRow, RatingRow)]
    some = {kind: _of_sessions(study, label, kind) for kind in _OPTIONAL}
    tables += [table for table in some.values() if table.rows]
    there = [table for table in tables if table.rows]
    with new_folder(study, out) as draft:
        (draft / "data").mkdir(parents=True)
        for table in there:
            with (draft / "data" / table.file).open("w", encoding="utf-8", newline="") as stream:
                csv.writer(stream, lineterminator="\n").writerows([table.columns, *table.rows])
        names = {kind: f"data/{_file(label, kind)}" for kind in _KINDS}
        more = "".join(_OPTIONAL[k].format(**names) for k, table in some.items() if table.rows)
        readme = _README.format(name=name, protocol=protocol, more=more, **names)
        (draft / "README.md").write_text(readme, encoding="utf-8")
        content = _description(name, protocol, str(description.get("citation") or ""), there)
        text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
        (draft / DESCRIPTION).write_text(text, encoding="utf-8")
    empty = [table.file for table in tables if not table.rows]
    return [f"{file}: the study has no rows of it" for file in empty]


_KINDS = (
    "participants",
    "trials",
    "questionnaires",
    "ratings",
    "tasks",
    "dials",
    "texts",
    "screening",
)


def _file(label: str, kind: str) -> str:
    return f"study-{label}_description-{kind}_data.csv"


def _participants(study: Path, label: str) -> _Table:
    rows = read_participants(study)
    others = list(dict.fromkeys(name for row in rows for name, _ in row.others))
    own = [name for name in ParticipantRow.columns() if name != "note"]
    cells = [
        [str(getattr(row, name)) for name in own]
        + [dict(row.others).get(name, "") for name in others]
        for row in rows
    ]
    return _Table(_file(label, "participants"), (*own, *others), cells)


def _of_sessions(study: Path, label: str, row_type: type[Row]) -> _Table:
    """Return the rows of one kind of file, of all sessions."""
    columns = row_type.columns()
    rows = [
        [row.get(name, "") for name in columns]
        for file in _files(study, row_type.FILE)
        if file.exists()
        for row in CsvTable.read(file, appended=True).dicts()
    ]
    return _Table(_file(label, Path(row_type.FILE).stem), columns, rows)


def _files(study: Path, name: str) -> Iterator[Path]:
    for row in read_participants(study):
        for number in recorded_sessions(study, row.participant):
            yield session_folder(study, row.participant, number) / name


def _description(
    name: str, protocol: str, citation: str, tables: Sequence[_Table]
) -> dict[str, object]:
    columns = list(dict.fromkeys(column for table in tables for column in table.columns))
    said: dict[str, object] = {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": name,
        "description": f"Comfort study recorded with vrcomfort {__version__}, protocol {protocol}.",
        "variableMeasured": [
            {
                "@type": "PropertyValue",
                "name": column,
                "description": _MEANINGS.get(column, f"{column}, as entered at the enrolment"),
                **({"unitText": "s"} if column.endswith("_s") else {}),
            }
            for column in columns
        ],
    }
    return said | ({"citation": citation} if citation else {})
