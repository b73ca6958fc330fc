"""Findings of a verification, and the reading of rows that collects faults as findings."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.records.rows import Row
from vrcomfort.records.schema import OPTIONAL_ROWS, SCHEMA_VERSION, SESSION_ROWS, later_columns
from vrcomfort.records.tables import RecordedRow, read_rows


@dataclass(frozen=True)
class Finding:
    """One fault, or (`fault` is False) one note.

    Parameters
    ----------
    file
        Relative to the study folder.
    line
        1-based; None where the whole file is meant.
    message
        What is wrong and what to do about it.
    """

    file: str
    line: int | None
    message: str
    fault: bool = True

    def __str__(self) -> str:
        """Return the finding as one line."""
        place = self.file if self.line is None else f"{self.file}, line {self.line}"
        return f"{place}: {self.message}"


@dataclass
class Verified:
    """Everything that was found, and how much was looked at.

    Parameters
    ----------
    study
        The folder that the findings' files are in.
    counts
        What was counted → how many: participants, sessions, rows of each kind of file, files whose
        checksum holds.
    intact, altered
        Files that are as their checksum says, and others that have one.
    ends
        Folder of a session that is going on → file name → bytes that are looked at.
    """

    study: Path
    findings: list[Finding] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    intact: set[Path] = field(default_factory=set)
    altered: set[Path] = field(default_factory=set)
    ends: dict[Path, Mapping[str, int]] = field(default_factory=dict)

    @property
    def faults(self) -> list[Finding]:
        """Return the faults."""
        return [each for each in self.findings if each.fault]

    @property
    def notes(self) -> list[Finding]:
        """Return the notes, which are no faults."""
        return [each for each in self.findings if not each.fault]

    def fault(self, file: Path, message: str, line: int | None = None) -> None:
        """Add something that is wrong."""
        self.findings.append(Finding(self._name(file), line, message))

    def note(self, file: Path, message: str) -> None:
        """Add something that should be known."""
        self.findings.append(Finding(self._name(file), None, message, fault=False))

    def add(self, other: Verified) -> None:
        """Add the findings of another part of the study."""
        self.findings += other.findings
        self.counts += other.counts
        self.intact |= other.intact
        self.altered |= other.altered

    def suspect(self, file: Path, other: Path) -> Path:
        """Return which of two files that disagree to name: the one that was altered, if one was."""
        return other if other in self.altered and file not in self.altered else file

    def leave_out_consequences(self) -> None:
        """Leave out findings of intact files where an altered file of that participant has one.

        Files are compared with each other: what is wrong in one is seen in the others, too.
        """
        faulty = {each.file for each in self.faults}
        altered = {_whose(name) for each in self.altered if (name := self._name(each)) in faulty}

        def follows(finding: Finding) -> bool:
            whose = _whose(finding.file)
            return self.study / finding.file in self.intact and bool(
                altered & {whose, ""} if whose else altered
            )

        def compares(finding: Finding) -> bool:
            return finding.fault or finding.file.endswith(".parquet")  # with its CSV

        self.findings = [each for each in self.findings if not (compares(each) and follows(each))]

    def refusal(self, error: InputError, file: Path) -> None:
        """Add a reader's error on a file."""
        self.fault(file if error.file is None else Path(error.file), error.message, error.line)

    def unreadable(self, error: OSError, folder: Path) -> None:
        """Add a file or folder, in `folder`, that the system does not let us read."""
        file = Path(error.filename or folder)
        message = f"cannot be read: {error.strerror}; ask for access, or restore it from a copy"
        self.fault(file if file.is_relative_to(folder) else folder, message)

    def _name(self, file: Path) -> str:
        return file.relative_to(self.study).as_posix() if file != self.study else "."


def _whose(file: str) -> str:
    """Return the folder of a participant that a file is in; blank: it is of all."""
    folder = file.partition("/")[0]
    return folder if folder.startswith("sub-") else ""


def note_version(folder: Path, version: int, found: Verified) -> None:
    """Say of a session of an older schema version which columns it is without."""
    files = (each.FILE for each in (*SESSION_ROWS, *OPTIONAL_ROWS))
    later = later_columns(version, [name for name in files if (folder / name).exists()])
    if later:
        named = "; ".join(f"{name}: {', '.join(columns)}" for name, columns in later.items())
        message = f"recorded in schema version {version} (now {SCHEMA_VERSION}), without {named}"
        found.note(folder / "manifest.json", message)


def read(folder: Path, row_type: type[Row], version: int, found: Verified) -> Iterator[RecordedRow]:
    """Yield the rows of a file that can be read.

    Parameters
    ----------
    version
        Of the schema, as the manifest says: an older one has fewer columns.
    """
    file = folder / row_type.FILE
    if file.is_symlink():
        found.fault(file, "is a symbolic link; put the file itself here")
        return
    if not file.exists():
        found.fault(file, "is missing; restore it from a copy")
        return

    ends = found.ends.get(folder)
    until = math.inf if ends is None else ends.get(row_type.FILE, 0)
    if not until:
        return

    def told(error: InputError) -> None:
        column = "" if error.column is None else f"column {error.column}: "
        found.fault(file, f"{column}{error.message}", error.line)

    for row in read_rows(folder, row_type, version=version, until_bytes=until, told=told):
        found.counts[f"rows of {row_type.FILE}"] += 1
        yield row
