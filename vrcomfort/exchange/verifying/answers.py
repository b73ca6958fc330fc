"""Checks answers with the event log: questionnaires, texts, decisions on screening, practice."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from typing import Any

from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.attempts import TOLERANCE_S, before
from vrcomfort.records.tables import RecordedRow

_REFUSED = "rather not say"


def check_answers(
    answers: Sequence[RecordedRow],
    events: Sequence[RecordedRow],
    trials: Sequence[RecordedRow],
    found: Verified,
    *,
    whole: bool,
) -> None:
    """Match ``questionnaires.csv`` with the events `answer`.

    An event is written right after its row; a correction replaces the row and adds an event. So
    the first event of an item that is not before its row has the row's answer, and earlier ones
    since the exposure before were corrected.

    Parameters
    ----------
    whole
        The session has run without an interruption: no event can be missing.
    """
    said: dict[str, list[RecordedRow]] = {}
    for event in events:
        if event["name"] == "answer":
            said.setdefault(event["detail"].rpartition(": ")[0], []).append(event)
    exposed_s = sorted(trial["end_s"] for trial in trials)
    asked: dict[str, list[RecordedRow]] = {}
    for row in answers:
        asked.setdefault(f"{row['timepoint']} {row['instrument']} {row['item']}", []).append(row)
    for key in asked.keys() | said.keys():
        _match(asked.get(key, []), said.get(key, []), exposed_s, found, whole=whole)


def _match(
    rows: Sequence[RecordedRow],
    events: Sequence[RecordedRow],
    exposed_s: Sequence[float],
    found: Verified,
    *,
    whole: bool,
) -> None:
    """Match the rows and the events of one item at one timepoint, over all exposures."""
    times = [event["onset_s"] for event in events]
    taken: set[int] = set()
    later_s: list[float] = []
    for row in rows:
        at = bisect_left(times, row["answered_s"] - TOLERANCE_S)
        if at < len(events) and _place(times[at], exposed_s) == _place(
            row["answered_s"], exposed_s
        ):
            taken.add(at)
            _compare(row, events[at], found)
        elif whole:
            message = "events.csv has no such answer; restore both files from a copy"
            found.fault(row.file, message, row.line)
        else:  # the program was stopped between the row and its event
            later_s.append(row["answered_s"])
    later_s += [times[index] for index in taken]
    for index, event in enumerate(events):
        place = _place(times[index], exposed_s)
        corrected = any(
            before(times[index], each_s) and _place(each_s, exposed_s) == place
            for each_s in later_s
        )
        if index not in taken and not corrected:
            message = f"questionnaires.csv has no row of this answer ({event['detail']})"
            found.fault(event.file, f"{message}; restore that file from a copy", event.line)


def _place(time_s: float, exposed_s: Sequence[float]) -> int:
    """Return after how many exposures something was."""
    return bisect_right(exposed_s, time_s + TOLERANCE_S)


def _compare(row: RecordedRow, event: RecordedRow, found: Verified) -> None:
    said = event["detail"].rpartition(": ")[2]
    response = _REFUSED if row["response"] is None else str(row["response"])
    if said != response:
        message = f"the response is {response}, and events.csv, line {event.line}, says {said}"
        found.fault(row.file, f"{message}; restore the file that was changed", row.line)


def check_places(
    answers: Sequence[RecordedRow],
    trials: Mapping[int, Sequence[RecordedRow]],
    settings: Mapping[str, object],
    found: Verified,
) -> None:
    """Check that answers to an exposure tell of one that was, and came when they could."""
    asks = settings.get("questionnaires")
    after = {
        ask.get("timepoint")
        for ask in (asks if isinstance(asks, list) else [])
        if ask.get("when") == "after_trial"
    }
    for row in answers:
        if before(row["answered_s"], row["asked_s"]):
            found.fault(row.file, "was answered before it was asked; restore the file", row.line)
        if row["trial"] is None:
            continue
        attempts = trials.get(row["trial"], ())
        for column in ("condition", "period", "block"):
            if attempts and row[column] != attempts[0][column]:
                message = f"{column} is {row[column]!r}, and trials.csv says of trial"
                message = f"{message} {row['trial']} {attempts[0][column]!r}"
                found.fault(row.file, f"{message}; restore the file that was changed", row.line)
        if row["timepoint"] in after and not attempts:
            message = f"is the answer to exposure {row['trial']}, which trials.csv does not have"
            found.fault(row.file, f"{message}; restore that file from a copy", row.line)
        elif row["timepoint"] in after and before(row["answered_s"], attempts[0]["end_s"]):
            message = f"was answered before exposure {row['trial']} ended"
            found.fault(row.file, f"{message}; restore the file that was changed", row.line)


def check_texts(
    texts: Sequence[RecordedRow],
    trials: Mapping[int, Sequence[RecordedRow]],
    found: Verified,
) -> None:
    """Check that answers in one's own words tell of an exposure that was, with its condition."""
    for row in texts:
        if before(row["answered_s"], row["asked_s"]):
            found.fault(row.file, "was answered before it was asked; restore the file", row.line)
        attempts = trials.get(row["trial"], ()) if row["trial"] is not None else ()
        if attempts and row["condition"] != attempts[0]["condition"]:
            message = f"condition is {row['condition']!r}, and trials.csv says of trial"
            message = f"{message} {row['trial']} {attempts[0]['condition']!r}"
            found.fault(row.file, f"{message}; restore the file that was changed", row.line)


def check_decisions(rows: Sequence[RecordedRow], found: Verified) -> None:
    """Check that each decision on a screening rule is one."""
    for row in rows:
        if row["decision"] not in {"go_on", "stop"}:
            message = f"the decision is {row['decision']!r}, and can be go_on or stop"
            found.fault(row.file, f"{message}; restore the file", row.line)


_STATUS = ("completed", "skipped", "redone", "withdrawn", "aborted")
_RESTORE = "restore the file"


def check_practice(
    rows: Sequence[RecordedRow], manifest: Mapping[str, Any], found: Verified
) -> None:
    """Check the rows of ``practice.csv`` of one session."""
    blocks = (manifest.get("settings") or {}).get("practice") or []
    known = {str(each["name"]) for each in blocks}
    last: dict[str, tuple[int, int]] = {}
    over: set[str] = set()
    for row in rows:
        name, at = row["practice"], (row["repetition"], row["number"])
        for fault in _faults(row, manifest, known):
            found.fault(row.file, f"{fault}; {_RESTORE}", row.line)
        if name in over:
            message = f"practice {name!r} was over, and goes on here"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)
        if at <= last.get(name, (0, 0)):
            message = f"repetition {at[0]}, exposure {at[1]} of practice {name!r} stands too late"
            found.fault(row.file, f"{message}; {_RESTORE}", row.line)
        last[name] = at
        over |= {name} if row["over"] else set()


def _faults(row: RecordedRow, manifest: Mapping[str, Any], known: set[str]) -> list[str]:
    faults = [
        f"{column} is {row[column]}, and this folder is of {manifest[column]}"
        for column in ("participant", "session")
        if row[column] != manifest[column]
    ]
    if row["practice"] not in known:
        faults.append(f"the protocol has no practice {row['practice']!r}")
    if row["status"] not in _STATUS:
        faults.append(f"{row['status']!r} is no status of practice")
    if before(row["end_s"], row["start_s"]):
        faults.append("ended before it began")
    return faults
