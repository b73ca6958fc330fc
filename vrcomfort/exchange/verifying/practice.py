"""Practice: that its rows are of blocks of the protocol, in their order, and end where they say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vrcomfort.exchange.verifying.findings import Verified
from vrcomfort.records.tables import RecordedRow
from vrcomfort.records.times import before

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
