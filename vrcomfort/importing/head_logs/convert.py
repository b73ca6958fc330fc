"""Converts head logs of other programs to traces, as a mapping says."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from decimal import Decimal
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import number_or_none, plain_digits, shortened
from vrcomfort.errors import InputError
from vrcomfort.geometry import FARTHEST_M
from vrcomfort.importing.head_logs.mapping import METRES, LogMapping, LogOrientation, TimeUnit
from vrcomfort.importing.head_logs.reading import LogPart, parts_of
from vrcomfort.importing.mapping import texts_of
from vrcomfort.rotations import Array, axis_angle, normalize, quaternion_multiply
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace

NANOSECONDS: Mapping[TimeUnit, int] = {
    "s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1, "min": 60 * 10**9, "ticks": 100,
}  # fmt: skip
_MOST_DIGITS = 19
"""Of nanoseconds: 64 bits hold no more."""
_UNIX_TICKS = 621_355_968_000_000_000
"""Ticks of .NET, which count from the year 1, at the start of 1970."""
_DAY_NS = 86_400 * 10**9
_CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})(?:[.,:](\d{1,9}))?\s*([AaPp][Mm])?")
_DATE = re.compile(r"(\d{4})-(\d{2})-(\d{2})")
_LONGEST_S = 0.5
ROUNDED = 0.02
"""The length of a quaternion with few decimals may be so far from 1."""


@dataclass
class _Samples:
    """The samples of a log, part by part."""

    lines: list[int] = field(default_factory=list)
    times: list[int] = field(default_factory=list)
    gaps: list[bool] = field(default_factory=list)
    """Whether a row before each one was left out, as nothing was tracked."""
    positions: list[Array] = field(default_factory=list)
    orientations: list[Array] = field(default_factory=list)
    untracked: int = 0
    elsewhere: int = 0


class LogConverter:
    """Converts the rows of one log."""

    def __init__(self, file: Path, mapping: LogMapping) -> None:
        self._file = file
        self._mapping = mapping
        self._missing = {"", *mapping.missing}
        self._where = {name: {*texts_of(texts)} for name, texts in mapping.where.items()}
        self._nanoseconds = _time_reader(mapping)
        self._found = _Samples()
        self._after_gap = False

    def add(self, part: LogPart) -> None:
        """Convert some rows.

        Raises
        ------
        InputError
            If a cell is no number, with line and column.
        """
        rows = self._tracked(part)
        lines = [part.lines[row] for row in rows]
        cells = {name: [column[row] for row in rows] for name, column in part.cells.items()}
        mapping, found = self._mapping, self._found
        time = [
            " ".join(each) for each in zip(*(cells[n] for n in mapping.time.names), strict=True)
        ]
        column = ", ".join(mapping.time.names)
        for line, text in zip(lines, time, strict=True):
            found.times.append(self._time(text, line, column))
        found.lines += lines
        count = (len(rows), 1)
        if mapping.position is None:
            found.positions.append(np.tile(mapping.position_m, count))
        else:
            names = mapping.position.columns
            metres = self._numbers(names, cells, lines) * METRES[mapping.position.unit]
            found.positions.append(self._near(metres @ mapping.axes.matrix.T, names, lines))
        turned = self._numbers(mapping.orientation.names, cells, lines)
        found.orientations.append(self._orientations(turned, lines))

    def _tracked(self, part: LogPart) -> list[int]:
        """Return the rows that count, and note those that do not."""
        mapping, found = self._mapping, self._found
        position = mapping.position.columns if mapping.position else ()
        pose = [part.cells[n] for n in (*mapping.time.names, *position, *mapping.orientation.names)]
        quaternion = mapping.orientation.quaternion
        turned = [part.cells[name] for name in quaternion or ()]
        kept = []
        for row in range(len(part.lines)):
            if any(part.cells[n][row] not in texts for n, texts in self._where.items()):
                found.elsewhere += 1
            elif any(column[row] in self._missing for column in pose) or _is_nothing(turned, row):
                found.untracked += 1
                self._after_gap = True
            else:
                kept.append(row)
                found.gaps.append(self._after_gap)
                self._after_gap = False
        return kept

    def _time(self, text: str, line: int, column: str) -> int:
        found = self._nanoseconds(text)
        if found is None or not -(2**63) <= found < 2**63:
            unit = self._mapping.time.unit
            what = {"clock": "a clock time such as 12:59:59.123", "frames": "a number of a frame"}
            wanted = what.get(unit, f"a time in {unit}")
            raise self._fault(f"{shortened(text)} is not {wanted}", line, column)
        return found

    def _numbers(
        self, names: Sequence[str], cells: Mapping[str, list[str]], lines: Sequence[int]
    ) -> Array:
        columns = []
        for name in names:
            values = [number_or_none(cell) for cell in cells[name]]
            if None in values:
                row = values.index(None)
                message = f"{shortened(cells[name][row])} is not a finite number; texts that mean"
                raise self._fault(f"{message} nothing go under missing", lines[row], name)
            columns.append(values)
        return np.array(columns, dtype=np.float64).T.reshape(-1, len(names))

    def _near(self, metres: Array, names: Sequence[str], lines: Sequence[int]) -> Array:
        far = np.argwhere(np.abs(metres) > FARTHEST_M)
        if len(far):
            message = f"{np.abs(metres[tuple(far[0])]):g} m is more than {FARTHEST_M / 1e3:.0f} km"
            raise self._fault(f"{message} away; is the unit right?", lines[far[0][0]], names[0])
        return metres

    def _orientations(self, turned: Array, lines: Sequence[int]) -> Array:
        orientation, axes = self._mapping.orientation, self._mapping.axes.matrix
        if orientation.quaternion is None:
            quaternions = from_euler(turned, orientation)
        else:
            lengths = np.linalg.norm(turned, axis=1)
            bad = np.flatnonzero(np.abs(lengths - 1) > ROUNDED)
            if len(bad):
                message = f"this quaternion has length {lengths[bad[0]]:.6g}; a rotation needs 1"
                column = orientation.quaternion[0]
                raise self._fault(message, lines[bad[0]], column)
            quaternions = normalize(turned)
        # A rotation R of the log's frame is M R Mᵀ in ours; the vector part of a quaternion is
        # axial, so where M mirrors (another hand), it changes its sign as well.
        vectors = quaternions[:, :3] @ axes.T * np.linalg.det(axes)
        return np.concatenate([vectors, quaternions[:, 3:]], axis=1)

    def trace(self) -> Trace:
        """Return the trace.

        Raises
        ------
        InputError
            If no row counts, or time does not rise, with the line.
        """
        found, mapping = self._found, self._mapping
        if not found.times:
            chosen = "; is `where` right?" if found.elsewhere else ""
            raise InputError(f"there is no row with a pose{chosen}", file=self._file)
        time_ns = np.array(found.times, dtype=np.int64)
        if mapping.time.unit == "clock":
            time_ns = time_ns + _DAY_NS * np.cumsum(
                np.diff(time_ns, prepend=time_ns[:1]) < -_DAY_NS // 2
            )
        keep = self._rising(time_ns)
        time_ns = time_ns[keep]
        steps_s = np.diff(time_ns) * 1e-9
        longest_s = mapping.longest_step_s or max(_LONGEST_S, 5 * float(np.median([0, *steps_s])))
        late = steps_s > longest_s
        cuts = np.array(found.gaps)[keep]
        cuts[0] = True
        cuts[1:] |= late
        head = PoseTrack(
            np.concatenate(found.positions)[keep], np.concatenate(found.orientations)[keep]
        )
        return Trace(time_ns, head, cuts, warnings=tuple(self._notes(cuts, keep)))

    def _rising(self, time_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return the samples that count; raise `InputError` where time does not rise."""
        steps = np.diff(time_ns)
        keep = np.ones(len(time_ns), dtype=bool)
        if self._mapping.repeated_times == "leave_out":
            keep[1:] = steps != 0
        wrong = np.flatnonzero(np.diff(time_ns[keep]) <= 0)
        if len(wrong):
            row = np.flatnonzero(keep)[wrong[0] + 1]
            step = time_ns[row] - time_ns[row - 1]
            what = "stands still" if step == 0 else f"goes back by {-step / 1e9:g} s"
            cure = (
                'write repeated_times = "leave_out" if rows repeat a sample'
                if step == 0
                else "if trials follow each other in the file, choose one by where"
            )
            raise self._fault(
                f"time {what}; samples must be in order, each later: {cure}",
                self._found.lines[row], ", ".join(self._mapping.time.names),
            )  # fmt: skip
        return keep

    def _notes(self, cuts: NDArray[np.bool_], keep: NDArray[np.bool_]) -> list[str]:
        found, name = self._found, self._file.name
        notes = []
        if found.untracked:
            notes.append(f"{name}: {found.untracked} rows without a pose were left out")
        if repeated := int(np.sum(~keep)):
            notes.append(f"{name}: {repeated} rows with the time of the row before were left out")
        if gaps := int(np.sum(cuts[1:])):
            notes.append(f"{name}: the view begins anew after {gaps} gaps")
        return notes

    def _fault(self, message: str, line: int, column: str) -> InputError:
        return InputError(message, file=self._file, line=line, column=column)


def _is_nothing(quaternion: Sequence[Sequence[str]], row: int) -> bool:
    """Return whether all four components are 0, as trackers write that lost the head."""
    return bool(quaternion) and not any(number_or_none(column[row]) != 0 for column in quaternion)


def from_euler(angles: Array, orientation: LogOrientation) -> Array:
    """Return (n, 4) quaternions of (n, 3) turns about the log's x, y and z."""
    signs = [-1.0 if axis in orientation.negated else 1.0 for axis in "xyz"]
    radians = angles * signs if orientation.unit == "rad" else np.radians(angles * signs)
    found = np.tile([0.0, 0.0, 0.0, 1.0], (len(angles), 1))
    for axis in orientation.order:
        place = "xyz".index(axis)
        found = quaternion_multiply(axis_angle(np.eye(3)[place], radians[:, place]), found)
    return found


def _time_reader(mapping: LogMapping) -> Callable[[str], int | None]:
    """Return what reads a time as nanoseconds; None where a text is none."""
    unit = mapping.time.unit
    if unit == "clock":
        return clock_ns
    scale = Decimal(NANOSECONDS.get(unit, 0))
    if mapping.time.rate_hz is not None:
        scale = Decimal(10**9) / Decimal(str(mapping.time.rate_hz))
    since = _UNIX_TICKS if unit == "ticks" else 0

    def read(text: str) -> int | None:
        # Decimal keeps what the file says: a float64 of seconds since 1970 is 200 ns coarse.
        try:
            value = Decimal(plain_digits(text))
            value -= since if value > since else 0
            nanoseconds = (value * scale).to_integral_value()
        except (ArithmeticError, ValueError):
            return None
        fits = nanoseconds.is_finite() and nanoseconds.adjusted() < _MOST_DIGITS
        return int(nanoseconds) if fits else None

    return read


def clock_ns(text: str) -> int | None:
    """Return the nanoseconds of a clock time, since 1970 where a date stands before it."""
    found = _CLOCK.search(text)
    if found is None:
        return None
    hours, minutes, seconds = int(found[1]), int(found[2]), int(found[3])
    if found[5]:
        hours = hours % 12 + (12 if found[5].casefold() == "pm" else 0)
    if hours > 23 or minutes > 59 or seconds > 60:
        return None
    whole = (hours * 60 + minutes) * 60 + seconds
    day = _DATE.search(text)
    try:
        days = (date(*map(int, day.groups())) - date(1970, 1, 1)).days if day else 0
    except ValueError:
        return None
    return (days * 86_400 + whole) * 10**9 + int((found[4] or "0").ljust(9, "0"))


def import_log(file: Path, mapping: LogMapping) -> Trace:
    """Read the head poses of a log as its mapping says.

    Raises
    ------
    InputError
        If a column is not there, a cell is no number, or time does not rise; with the line.
    """
    converter = LogConverter(file, mapping)
    for part in parts_of(file, mapping.read, mapping.names):
        converter.add(part)
    return converter.trace()
