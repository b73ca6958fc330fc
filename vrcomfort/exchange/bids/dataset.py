"""The whole dataset: description, participants, and for each session motion, gaze and events.

BIDS 1.11.1 (Gorgolewski et al. 2016, Sci. Data 3:160044), with Motion-BIDS (Jeung et al. 2024,
Sci. Data 11:716) and its eye tracking.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from vrcomfort import __version__
from vrcomfort.exchange.bids.runs import (
    SYSTEMS,
    Run,
    read_runs,
    recorded,
    write_gazes,
    write_json,
    write_motion,
    write_tsv,
)
from vrcomfort.exchange.export_checks import from_damaged, said_of
from vrcomfort.exchange.verifying.findings import Finding
from vrcomfort.questionnaire import Instrument, instruments_in, shipped_instruments
from vrcomfort.records.choice import Choice
from vrcomfort.records.events import EVENTS, shared_detail
from vrcomfort.records.exposure_rows import PracticeRow
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.rows import Column, declared
from vrcomfort.records.schema import full_meaning
from vrcomfort.records.session_rows import QuestionnaireRow


def write_phenotype(study: Study, out: Path, participants: Iterable[str]) -> None:
    """Write a table and its sidecar for each instrument that was answered.

    Raises
    ------
    InputError
        If a table is damaged.
    """
    known = {**shipped_instruments(), **instruments_in([study.folder])}
    tables: dict[str, dict[str, dict[str, str]]] = {}
    columns: dict[str, dict[str, dict[str, Any]]] = {}
    for name in participants:
        for session in study.sessions_of(name):
            asked_in = _languages(session)
            for row in session.text_rows(QuestionnaireRow):
                instrument = row["instrument"]
                cells = tables.setdefault(instrument, {}).setdefault(f"sub-{name}", {})
                said = columns.setdefault(instrument, {})
                for column, value, meaning in _cells(row, known.get(instrument)):
                    cells[column] = value
                    said.setdefault(column, meaning)
                if instrument in asked_in:
                    column = f"ses-{row['session']}_language"
                    cells[column] = asked_in[instrument]
                    text = f"Language in which it was asked in session {row['session']}"
                    said.setdefault(column, {"Description": text})
    for instrument, rows in tables.items():
        write_instrument(out / "phenotype", instrument, rows, columns[instrument], known)


def _languages(session: Session) -> dict[str, str]:
    """Return instrument → language in which a session asked it, as its manifest says."""
    wordings = session.manifest.get("wordings") or []
    return {str(each["instrument"]): str(each["language"]) for each in wordings}


def _cells(row: Mapping[str, str], instrument: Instrument | None) -> Iterable[tuple[str, str, Any]]:
    """Yield column, value and meaning of an answer, and of the condition that it is of."""
    place = f"ses-{row['session']}"
    when = f"session {row['session']}, {row['timepoint']}"
    if row["trial"]:
        place += f"_trial-{row['trial']}"
        when += f", exposure {row['trial']}"
        text = f"Condition of exposure {row['trial']} of session {row['session']}"
        yield f"{place}_condition", row["condition"], {"Description": text}
    yield (
        f"{place}_{row['timepoint']}_{row['item']}",
        row["response"],
        meaning_of_answer(row, when, instrument),
    )


def meaning_of_answer(
    row: Mapping[str, str], when: str, instrument: Instrument | None
) -> dict[str, Any]:
    """Return the sidecar's entry of the column of an answer."""
    item = instrument.item(row["item"]) if instrument else None
    if instrument is None or item is None:
        return {"Description": f"{row['item']} ({when})"}
    text = f"{item.text} ({when}); n/a: rather not say, or not asked"
    answers = item.answers
    if len(answers.labels) != len(answers.asked):
        return {"Description": text, "Minimum": answers.low, "Maximum": answers.high}
    levels = zip(map(str, answers.asked), answers.labels, strict=True)
    return {"Description": text, "Levels": dict(levels)}


def write_instrument(
    folder: Path,
    name: str,
    rows: Mapping[str, Mapping[str, str]],
    columns: Mapping[str, dict[str, Any]],
    known: Mapping[str, Instrument],
) -> None:
    """Write the table of an instrument, and its sidecar."""
    table = [(who, *(cells.get(column, "") for column in columns)) for who, cells in rows.items()]
    write_tsv(folder / f"{name}.tsv", ("participant_id", *columns), table)
    instrument = known.get(name)
    tool = {"Description": name}
    if instrument is not None:
        tool = {"Description": f"{instrument.title} ({instrument.short}). {instrument.citation}"}
    write_json(folder / f"{name}.json", {"MeasurementToolMetadata": tool, **columns})


_OF_THE_NAME = ("participant", "session")


def write_practice(session: Session, folder: Path, whose: str, task: str) -> None:
    """Write the practice of one session, if it had any.

    Parameters
    ----------
    folder
        Of the session in the dataset.
    whose
        Beginning of its files' names.
    task
        Label of what the exposures are; practice is told from it by its own.

    Raises
    ------
    InputError
        If the table is damaged.
    """
    rows = list(session.text_rows(PracticeRow))
    if not rows:
        return
    label = f"{task}practice"
    described = [each for each in declared(PracticeRow) if each.name not in _OF_THE_NAME]
    columns = [each.name for each in described]
    stem = folder / "beh" / f"{whose}_task-{label}_beh"
    table = ([row.get(name, "") for name in columns] for row in rows)
    write_tsv(stem.with_suffix(".tsv"), columns, table)
    write_json(
        stem.with_suffix(".json"),
        {
            "TaskName": label,
            "TaskDescription": "Practice before the exposures of a session, of which it is none",
            **{each.name: described_column(each) for each in described},
        },
    )


def described_column(column: Column) -> dict[str, str]:
    """Return the sidecar's entry of a column."""
    return {
        "Description": full_meaning(column),
        **({"Units": column.unit} if column.unit else {}),
    }


BIDS_VERSION = "1.11.1"
_EVENT_COLUMNS = ("onset", "duration", "trial_type", "value", "condition", "scene")
_EVENTS = {
    "onset": {"Description": "Since the first frame of the run", "Units": "s"},
    "duration": {"Description": "0 for a moment; of a rating: until it was given", "Units": "s"},
    "trial_type": {
        "Description": "exposure: the whole run; rating: a question in it, named after the "
        "instrument; others: what the headset or the session noted"
    },
    "value": {
        "Description": "The rating, or how the exposure ended, or the detail of an event; n/a: "
        "missed, or none, or a detail that people may have typed"
    },
    "condition": {"Description": "Of the protocol"},
    "scene": {"Description": "Of the protocol"},
    "StimulusPresentation": {"SoftwareName": "vrcomfort", "SoftwareVersion": __version__},
}
_README = """# {name}

A comfort study recorded with vrcomfort (protocol `{protocol}`) and exported as BIDS {bids}.

- `motion/`: each exposure is a run, numbered as it was shown. `tracksys-head`, and `tracksys-hands`
  where hands were recorded, in metres and quaternions (x, y, z, w) in the OpenXR stage.
- `*_recording-cyclopean_physio.tsv.gz`: gaze, where it was recorded; `recording-left` and
  `recording-right` where the eye tracker tells them apart.
- `*_events.tsv`: the exposure, the ratings in it, and what the headset noted.
- `beh/*practice_beh.tsv`: a row for each exposure of practice, where there was any.
- `phenotype/`: a table for each questionnaire, a row for each participant, a column for an answer.

Head motion, hand motion and gaze can identify people. Times are the study's own: `vrcomfort
anonymise` moves them, before an export.
"""


def write_dataset(study: Path, out: Path, choice: Choice, faults: Sequence[Finding]) -> list[str]:
    """Write a recorded study as a dataset; return a sentence for each omission.

    Raises
    ------
    InputError
        If a session is too damaged.
    """
    recorded = Study(study, without=choice.without)
    description = recorded.description
    name, protocol = str(description.get("name") or study.name), str(description["protocol"])
    write_json(
        out / "dataset_description.json",
        {
            "Name": name,
            "BIDSVersion": BIDS_VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [{"Name": "vrcomfort", "Version": __version__}],
        },
    )
    readme = _README.format(name=name, protocol=protocol, bids=BIDS_VERSION)
    readme += said_of(choice, faults)
    (out / "README.md").write_text(readme, encoding="utf-8")
    people = recorded.enrolled
    task = re.sub("[^A-Za-z0-9]", "", protocol) or "exposure"
    left_out: list[str] = []
    begun = [row for row in people if recorded.sessions_of(row.participant)]
    for row in begun:
        for session in recorded.sessions_of(row.participant):
            with from_damaged(session, faults):
                left_out += _session(session, out, task)
    others = list(dict.fromkeys(key for row in begun for key, _ in row.others))
    columns = ("participant_id", "sequence", "status", *others)
    table = [
        (f"sub-{row.participant}", row.sequence, row.status,
         *(dict(row.others).get(key, "") for key in others))
        for row in begun
    ]  # fmt: skip
    write_tsv(out / "participants.tsv", columns, table)
    write_json(out / "participants.json", _columns_of_participants(others))
    write_phenotype(recorded, out, [row.participant for row in begun])
    nobody = len(people) - len(begun)
    return [*left_out, *([f"{nobody} enrolled without a session"] if nobody else [])]


def _columns_of_participants(others: list[str]) -> dict[str, Any]:
    return {
        "sequence": {"Description": "The order of conditions and scenes, as the protocol names it"},
        "status": {
            "Description": "Where the participant is in the study",
            "Levels": {
                "enrolled": "Sessions are still to come",
                "completed": "All sessions are recorded",
                "withdrawn": "Stopped taking part",
                "excluded": "Left out of analyses",
            },
        },
        **{name: column_of_participants(name, "as entered at the enrolment") for name in others},
    }


def column_of_participants(name: str, origin: str) -> dict[str, str]:
    """Return the sidecar's entry of a covariate."""
    return {"Description": f"{name}, {origin}"}


def _session(session: Session, out: Path, task: str) -> list[str]:
    """Write one session; return a sentence for each omission."""
    who, number, manifest = session.participant, session.number, session.manifest
    folder = session_folder(out, who, number)
    scans: list[tuple[str, str]] = []
    left_out = []
    runs = read_runs(session)
    for run in runs:
        if not run.frames:
            left_out.append(f"sub-{who}/ses-{number}: exposure {run.number} has no frames")
            continue
        moved = [system for system in SYSTEMS if recorded(run, system)]
        place = folder / ("motion" if moved else "beh")
        whose = f"sub-{who}_ses-{number}_task-{task}"
        for system in moved:
            stem = place / f"{whose}_tracksys-{system.label}_run-{run.number}"
            facts = _facts(run, manifest, task)
            scans.append(
                (_name(write_motion(stem, run, system, facts), folder), _when(run, manifest))
            )
        stem = place / f"{whose}_run-{run.number}"
        if run.gaze:
            device = str(manifest["headset"].get("headset") or manifest["headset"].get("name", ""))
            files = write_gazes(stem, run, _nominal_hz(manifest), device)
            scans += [(_name(file, folder), _when(run, manifest)) for file in files]
        _write_events(stem, run)
    if scans:
        write_tsv(folder / f"sub-{who}_ses-{number}_scans.tsv", ("filename", "acq_time"), scans)
    write_practice(session, folder, f"sub-{who}_ses-{number}", task)
    unknown = {each["name"] for run in runs for each in run.events} - EVENTS.keys()
    return [
        *left_out,
        *(
            f"sub-{who}/ses-{number}: details of events `{name}`, which this version does not know"
            for name in sorted(unknown)
        ),
    ]


def _name(file: Path, folder: Path) -> str:
    return file.relative_to(folder).as_posix()


def _nominal_hz(manifest: Mapping[str, Any]) -> float:
    """Return the nominal rate of a session's frames."""
    return float(manifest["headset"].get("refresh_hz", 0.0))


def _facts(run: Run, manifest: Mapping[str, Any], task: str) -> dict[str, Any]:
    length_s = float(run.frames[-1]["session_s"]) - run.start_s
    effective_hz = round((len(run.frames) - 1) / length_s, 6) if length_s > 0 else "n/a"
    return {
        "TaskName": task,
        "TaskDescription": f"Scene {run.trial['scene']}, condition {run.trial['condition']}",
        "SamplingFrequency": _nominal_hz(manifest),
        "SamplingFrequencyEffective": effective_hz,
        "RecordingType": "continuous",
        "RecordingDuration": round(length_s, 6),
        "MissingValues": "n/a",
        "Manufacturer": "n/a",
        "ManufacturersModelName": str(manifest["headset"].get("name", "n/a")),
        "SoftwareVersions": f"vrcomfort {manifest['versions'].get('vrcomfort', 'n/a')}",
    }


def _when(run: Run, manifest: Mapping[str, Any]) -> str:
    """Return when a run began; a session that was interrupted does not know it."""
    if manifest.get("earlier_runs"):
        return ""
    began = datetime.fromisoformat(manifest["started_at"]).replace(tzinfo=None)
    return (began + timedelta(seconds=run.start_s)).isoformat(timespec="microseconds") + "Z"


def _write_events(stem: Path, run: Run) -> None:
    condition, scene = run.trial["condition"], run.trial["scene"]
    start_s = run.start_s
    rows: list[tuple[float, str, str, str]] = []
    begin_s, end_s = float(run.trial["start_s"]), float(run.trial["end_s"])
    rows.append((begin_s, f"{end_s - begin_s:.6f}", "exposure", run.trial["status"]))
    rows += [
        (
            float(each["onset_s"]),
            each["latency_s"],
            f"rating {each['instrument']}",
            each["response"],
        )
        for each in run.ratings
    ]
    rows += [
        (float(each["onset_s"]), each["reaction_s"], f"{each['task']} {each['kind']}", each["hit"])
        for each in run.tasks
        if each["kind"] in {"target", "shot"}
    ]
    rows += [
        (float(each["onset_s"]), "0", f"dial {each['dial']} {each['kind']}", each["value"])
        for each in run.dials
    ]
    rows += [
        (
            float(each["onset_s"]),
            each["duration_s"],
            each["name"],
            shared_detail(each["name"], each["detail"]),
        )
        for each in run.events
    ]
    table = [
        (f"{onset_s - start_s:.6f}", length, kind, value, condition, scene)
        for onset_s, length, kind, value in sorted(rows)
    ]
    write_tsv(stem.with_name(f"{stem.name}_events.tsv"), _EVENT_COLUMNS, table)
    kinds = sorted({kind for _, _, kind, _ in rows})
    levels = {kind: EVENTS[kind].meaning if kind in EVENTS else kind for kind in kinds}
    columns = {**_EVENTS, "trial_type": {**_EVENTS["trial_type"], "Levels": levels}}
    write_json(stem.with_name(f"{stem.name}_events.json"), columns)
