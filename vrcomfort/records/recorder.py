"""Writes a session's rows as they happen. Whatever ends the program, what was written stays."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

from vrcomfort.errors import InputError
from vrcomfort.records.rows import (
    EventRow,
    FrameRow,
    QuestionnaireRow,
    RatingRow,
    Row,
    TrialRow,
    cell_text,
)

_SESSION_ROWS: tuple[type[Row], ...] = (TrialRow, QuestionnaireRow, RatingRow, FrameRow, EventRow)


def session_folder(study: Path, participant: str, session: int) -> Path:
    """Return the folder of one participant's session."""
    return study / f"sub-{participant}" / f"ses-{session}"


class Recorder:
    """The open CSV files of one session; a context manager.

    Every row is flushed when it is written; answers to questionnaires, and the events that tell
    of them, are on the disk (fsync) when `write` returns.

    Raises
    ------
    InputError
        If the session has been recorded before, or the disk refuses a file or a row.
    """

    def __init__(self, study: Path, participant: str, session: int) -> None:
        self.folder = session_folder(study, participant, session)
        self._files: dict[str, io.TextIOWrapper] = {}
        if self.folder.exists() and any(self.folder.iterdir()):
            message = f"session {session} of {participant} has been recorded and is never"
            raise InputError(
                f"{message} overwritten; choose another participant, session or study folder",
                file=self.folder,
            )
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for row_type in _SESSION_ROWS:
                self._open(row_type)
        except OSError as error:
            self.close()
            raise _refused(self.folder, error) from error

    def _open(self, row_type: type[Row]) -> None:
        stream = (self.folder / row_type.FILE).open("x", encoding="utf-8", newline="")
        self._files[row_type.FILE] = stream
        stream.write(csv_line(row_type.columns()))
        stream.flush()

    def write(self, *rows: Row, sync: bool = False) -> None:
        """Append rows and flush them; rows of one call may belong to different files.

        With `sync`, and always for questionnaires, they are on the disk before this returns.

        Raises
        ------
        InputError
            If the disk is full or refuses; rows written before are kept.
        """
        for row in rows:
            try:
                stream = self._files[row.FILE]
                stream.write(csv_line(map(cell_text, row.cells())))
                stream.flush()
            except OSError as error:
                raise _refused(self.folder / row.FILE, error) from error
        for name in {row.FILE for row in rows if sync or isinstance(row, QuestionnaireRow)}:
            self._sync(name)

    def _sync(self, name: str) -> None:
        try:
            os.fsync(self._files[name].fileno())
        except OSError as error:
            raise _refused(self.folder / name, error) from error

    def close(self) -> None:
        """Close all files. Rows are flushed one by one, so a full disk has been told before."""
        for stream in self._files.values():
            try:
                stream.close()
            except OSError:
                continue
        self._files.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def csv_line(cells: Iterable[str]) -> str:
    """Return one CSV line with its line end."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


def replace_text(file: Path, text: str) -> None:
    """Replace a file as a whole: readers see the old text or the new, never half of it.

    Raises
    ------
    InputError
        If the disk is full or refuses; the old file stays.
    """
    draft = file.with_name(f".{file.name}.new")
    try:
        with draft.open("w", encoding="utf-8", newline="") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(file)
    except OSError as error:
        raise _refused(file, error) from error


def _refused(file: Path, error: OSError) -> InputError:
    reason = error.strerror or type(error).__name__
    return InputError(f"cannot write: {reason}; what was written before is kept", file=file)
