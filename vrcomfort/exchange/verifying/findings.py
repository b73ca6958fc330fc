"""What a verification finds, and where."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.errors import InputError


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or (`fault` is False) that somebody should know.

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
    """

    study: Path
    findings: list[Finding] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def faults(self) -> list[Finding]:
        """Return what is wrong."""
        return [each for each in self.findings if each.fault]

    @property
    def notes(self) -> list[Finding]:
        """Return what is not wrong, and should be known."""
        return [each for each in self.findings if not each.fault]

    def fault(self, file: Path, message: str, line: int | None = None) -> None:
        """Add something that is wrong."""
        self.findings.append(Finding(self._name(file), line, message))

    def note(self, file: Path, message: str) -> None:
        """Add something that should be known."""
        self.findings.append(Finding(self._name(file), None, message, fault=False))

    def refusal(self, error: InputError, file: Path) -> None:
        """Add what a reader says of a file."""
        self.fault(file if error.file is None else Path(error.file), error.message, error.line)

    def unreadable(self, error: OSError, folder: Path) -> None:
        """Add a file or folder, in `folder`, that the system does not let us read."""
        file = Path(error.filename or folder)
        message = f"cannot be read: {error.strerror}; ask for access, or restore it from a copy"
        self.fault(file if file.is_relative_to(folder) else folder, message)

    def _name(self, file: Path) -> str:
        return file.relative_to(self.study).as_posix() if file != self.study else "."
