"""Writes a mapping from a head log, with the doubts that it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from vrcomfort.csv_table import number_or_none
from vrcomfort.errors import InputError
from vrcomfort.importing.head_logs.columns import (
    OF_UNITY,
    OPENXR,
    RIGHT_HANDED_Z_UP,
    UNITY,
    UNREAL,
    ComponentColumns,
    Program,
    groups_of,
    positions,
    quaternions,
    time_columns,
    turns,
    written_by,
)
from vrcomfort.importing.head_logs.convert import NANOSECONDS, clock_ns, import_log
from vrcomfort.importing.head_logs.mapping import (
    METRES,
    STANDING_M,
    LengthUnit,
    LogRead,
    TimeUnit,
    parse_log_mapping,
)
from vrcomfort.importing.head_logs.reading import SAMPLE_BYTES, LogSample, sample_of
from vrcomfort.importing.suggest.draft import OpenDoubt, Stake, listed, write_doubts
from vrcomfort.importing.suggest.vocabulary import tokens
from vrcomfort.importing.text_files import content_of
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.json_text import escape_surrogates
from vrcomfort.rotations import Array, rotate
from vrcomfort.traces.table import TIME
from vrcomfort.traces.trace import Trace

FORWARD = (0.0, 0.0, -1.0)
_TOP = (
    "How to read this log as head poses, as `vrcomfort import-trace --suggest` understood it.",
    "Read it, mend what is wrong, and write an answer in each [[doubts]] below: while one is",
    "open, the import is refused. Every key: `vrcomfort docs import_traces`.",
)
_UNIT_WORDS: dict[str, TimeUnit] = {
    "ns": "ns", "us": "us", "µs": "us", "ms": "ms", "msec": "ms", "milliseconds": "ms", "s": "s",
    "sec": "s", "seconds": "s", "sekunden": "s", "ticks": "ticks", "min": "min",
}  # fmt: skip
_SINCE_1970_S = (0.9e9, 3e9)
"""Seconds since 1970 of recordings of headsets: 1998 to 2065."""
_USUAL_HZ, _POSSIBLE_HZ = (25.0, 250.0), (2.0, 2500.0)
_HEIGHTS_M = (0.7, 2.3)
"""Where heads are, sitting and standing."""
# A whole turn in radians, with room for rounding: larger angles are degrees.
TURN = 2 * np.pi + 0.02
_HEAD_IN_NAMES = ("head", "hmd", "camera", "xrcam", "centereye", "kopf", "player")
_TELLING = 0.2
"""Agreement of motion and view from which a frame is likely; its mirror image has its negative."""


def _way_of_turns(hand: str) -> OpenDoubt:
    """Return the doubt that yaw, pitch and roll leave by their names."""
    ways = {
        "left": "yaw to the right, pitch down, roll to the left, as Unity's are",
        "right": "by the right-hand rule: yaw to the left, pitch up, roll to the left",
    }
    question = "Which way are yaw, pitch and roll positive?"
    wrong = "the head would turn the other way; `negated` in the mapping turns them round"
    return OpenDoubt(question, ways[hand], Stake(wrong, 85))


@dataclass(frozen=True)
class LogSuggestion:
    """A mapping of a log that is to be read by a person.

    Parameters
    ----------
    text
        TOML.
    doubts
        The questions that it leaves open.
    trace
        What the mapping makes of the log as it stands; None where it is refused.
    """

    text: str
    doubts: tuple[OpenDoubt, ...]
    trace: Trace | None


class _Turned(NamedTuple):
    """The columns of the orientation."""

    kind: Literal["quaternion", "euler"]
    group: ComponentColumns


def suggest_log_mapping(file: Path) -> LogSuggestion:
    """Write a mapping from a log.

    Raises
    ------
    InputError
        If the file cannot be read, is a trace already, or has no columns of poses.
    """
    return _LogDraft(file).suggestion()


class _LogDraft:
    def __init__(self, file: Path) -> None:
        self._file = file
        self._sample = sample = sample_of(file, LogRead())
        if {TIME, "head_qw"} <= {*sample.headings}:
            raise InputError("this is a trace already; play it as it is", file=file)
        self._doubts: list[OpenDoubt] = []
        self._draft = TomlDraft({"format_version": 1})
        for line in _TOP:
            self._draft.note(line, "format_version")
        if not sample.read.heading_row:
            self._sample = sample = self._named_by_place(sample)
        groups = groups_of(sample.headings)
        self._position = next(iter(self._usable(positions(groups))), None)
        self._turned = self._orientation(groups)
        self._used: list[str] = []
        self._write()

    def _named_by_place(self, sample: LogSample) -> LogSample:
        """Call the columns of a log without headings by the usual order, and ask."""
        width = len(sample.headings)
        usual = {7: "position, then turns about x, y and z", 8: "position, then x, y, z and w"}
        if width not in usual:
            message = f"this log has no headings and {width} columns; give it a row of headings"
            raise InputError(
                f"{message}, such as time, pos_x, pos_y, pos_z, qx, qy, qz, qw", file=self._file
            )
        names = ["time", "pos_x", "pos_y", "pos_z", "rot_x", "rot_y", "rot_z", "rot_w"][:width]
        self._doubt(
            "The log has no headings: which column is which?",
            f"time, then {usual[width]}", "every pose would be another", 90,
        )  # fmt: skip
        self._places = dict(zip(names, sample.headings, strict=True))
        return sample._replace(headings=tuple(names))

    _places: dict[str, str] = {}  # noqa: RUF012 - replaced, never changed

    def _column(self, name: str) -> str:
        """Return a column as the mapping has to call it."""
        return self._places.get(name, name)

    def _doubt(self, question: str, assumed: str, otherwise: str, rank: int) -> None:
        self._doubts.append(OpenDoubt(question, assumed, Stake(otherwise, rank)))

    def _usable(self, groups: Sequence[ComponentColumns]) -> list[ComponentColumns]:
        """Return the groups whose cells are numbers, mostly, and that speak of the head at all."""
        return [
            group
            for group in groups
            if all(
                len(self._values(name)) * 2 > len(self._sample.rows)
                for name in group.columns.values()
            )
            and group.weight("head") > -40
        ]

    def _values(self, name: str) -> Array:
        place = self._sample.headings.index(name)
        found = [number_or_none(row[place]) for row in self._sample.rows]
        return np.array([value for value in found if value is not None])

    def _orientation(self, groups: Sequence[ComponentColumns]) -> _Turned:
        whole, three = self._usable(quaternions(groups)), self._usable(turns(groups))
        both = [_Turned("quaternion", group) for group in whole[:1]]
        both += [_Turned("euler", group) for group in three[:1]]
        if not both:
            message = "no columns of an orientation were found: four that end in x, y, z and w, or"
            message = f"{message} three called rotation x, y, z, or yaw, pitch and roll"
            raise InputError(f"{message}; rename them in the first row", file=self._file)
        return max(both, key=lambda each: each.group.weight("head"))

    def _write(self) -> None:
        draft, read = self._draft, self._sample.read
        draft.tables["read"] = TomlDraft(
            {"encoding": read.encoding, "separator": read.separator, "decimal": read.decimal,
             "heading_row": read.heading_row}
        )  # fmt: skip
        self._time()
        vectors = any("(" in line for line in self._first_lines())
        self._program = written_by(self._sample, vectors)
        if self._program is not None:
            self._doubts += self._in_frame(self._program)
        else:
            self._compare((UNREAL, RIGHT_HANDED_Z_UP) if self._up_is_z() else (UNITY, OPENXR))
        self._whose_head()
        self._missing()
        rest = [name for name in self._sample.headings if name not in self._used]
        if rest:
            draft.note(f"Not taken: {listed(rest, 12)}.", "format_version")

    def _first_lines(self) -> list[str]:
        encoding = self._sample.read.encoding or "utf-8"
        content = content_of(self._file, first=SAMPLE_BYTES)
        return content.decode(encoding, errors="replace").splitlines()[:20]

    def _take(self, *names: str) -> list[str]:
        self._used += names
        return [self._column(name) for name in names]

    # -- time

    def _time(self) -> None:
        found = sorted(time_columns(self._sample.headings), key=lambda each: -each[0])
        rising = [name for _, name in found if self._rises(name)]
        if not rising:
            raise InputError(
                "no column of times was found: one that rises from row to row, called time or "
                "timestamp; rename it in the first row, or write a mapping with the number of the "
                "frame (unit = \"frames\", rate_hz)", file=self._file,
            )  # fmt: skip
        name = rising[0]
        unit, sure = self._unit(name)
        (column,) = self._take(name)
        self._draft.tables["time"] = TomlDraft({"column": column, "unit": unit})
        if len(rising) > 1:
            self._draft.tables["time"].note(f"{', '.join(rising[1:])} would do as well")
        if not sure:
            hz = self._hz(name, unit)
            self._doubt(
                f"Is {name!r} in {unit}?", f"it is: that is {hz:.3g} samples a second",
                "the trace would run at another speed", 80,
            )  # fmt: skip
        if unit != "clock" and np.any(np.diff(self._values(name)) == 0):
            self._draft.put(
                "repeated_times", "leave_out", "some rows have the time of the row before"
            )

    def _rises(self, name: str) -> bool:
        values = self._values(name)
        if len(values) * 2 > len(self._sample.rows):
            steps = np.diff(values)
            return not len(steps) or (float(np.mean(steps >= 0)) > 0.95 and bool(steps.any()))
        place = self._sample.headings.index(name)
        return all(clock_ns(row[place]) is not None for row in self._sample.rows[:20])

    def _unit(self, name: str) -> tuple[TimeUnit, bool]:
        """Return the unit of a column of times, and whether it is sure."""
        values = self._values(name)
        if not len(values):
            return "clock", True
        said = next((_UNIT_WORDS[word] for word in tokens(name) if word in _UNIT_WORDS), None)
        if said is not None:
            return said, _POSSIBLE_HZ[0] < self._hz(name, said) < _POSSIBLE_HZ[1]
        for unit, ns in NANOSECONDS.items():
            since = values[0] * ns * 1e-9 - (62_135_596_800 if unit == "ticks" else 0)
            if _SINCE_1970_S[0] < since < _SINCE_1970_S[1] and unit != "min":
                return unit, True
        rates = {unit: self._hz(name, unit) for unit in ("s", "ms", "us", "ns", "ticks")}
        usual = [unit for unit, hz in rates.items() if _USUAL_HZ[0] < hz < _USUAL_HZ[1]]
        possible = [unit for unit, hz in rates.items() if _POSSIBLE_HZ[0] < hz < _POSSIBLE_HZ[1]]
        chosen: TimeUnit = (usual or possible or ["s"])[0]  # type: ignore[assignment]
        return chosen, len(usual) == 1 or (not usual and len(possible) == 1)

    def _hz(self, name: str, unit: TimeUnit) -> float:
        steps = np.diff(self._values(name))
        steps = steps[steps > 0]
        return 1e9 / (float(np.median(steps)) * NANOSECONDS[unit]) if len(steps) else 0.0

    # -- frame

    def _up_is_z(self) -> bool:
        """Return whether z is the height: heads are at 0.7 to 2.3 m and move less up than along."""
        if self._position is None:
            return False
        columns = self._position.columns
        y, z = self._values(columns["y"]), self._values(columns["z"])
        return not _is_height(y) and _is_height(z)

    def _in_frame(self, program: Program) -> list[OpenDoubt]:
        """Draft the poses as those of a program's frame; return the doubts that this leaves."""
        doubts = [*self._draft_position(program), *self._draft_orientation(program)]
        axes = program.axes
        table = TomlDraft({"right": axes.right, "up": axes.up, "forward": axes.forward})
        table.note(f"{axes.hand}-handed: {program.name}")
        self._draft.tables["axes"] = table
        return doubts

    def _draft_position(self, program: Program) -> list[OpenDoubt]:
        if self._position is None:
            self._draft.put("position_m", list(STANDING_M))
            question = "No column says where the head was: is it to stand still?"
            assumed = f"it is, {STANDING_M[1]} m above the floor"
            return [OpenDoubt(question, assumed, Stake("nothing moves past the head", 60))]
        names = [self._position.columns[axis] for axis in "xyz"]
        up = names["xyz".index(program.axes.up[-1])]
        unit = _length_unit(self._values(up), names)
        table = TomlDraft({"columns": self._take(*names), "unit": unit})
        height = float(np.median(self._values(up))) * METRES[unit]
        if not _HEIGHTS_M[0] < height < _HEIGHTS_M[1]:
            table.note(f"the height is {height:.2f} m: from the start, or of another unit?", "unit")
        self._draft.tables["position"] = table
        return []

    def _draft_orientation(self, program: Program) -> list[OpenDoubt]:
        kind, group = self._turned
        if kind == "quaternion":
            names = self._take(*(group.columns[axis] for axis in "xyzw"))
            self._draft.tables["orientation"] = TomlDraft({"quaternion": names})
            return []
        axes, by_axis, doubts = program.axes, dict(group.columns), []
        if "yaw" in by_axis:
            about = {"yaw": axes.up, "pitch": axes.right, "roll": axes.forward}
            by_axis = {axis[-1]: group.columns[turn] for turn, axis in about.items()}
            if program is not UNREAL:
                doubts.append(_way_of_turns(axes.hand))
        names = [by_axis[axis] for axis in "xyz"]
        high = max(float(np.max(np.abs(self._values(name)), initial=0)) for name in names)
        unit, sure = self._angle_unit(names, high)
        own = dict(zip("xyz", self._take(*names), strict=True))
        values: dict[str, object] = {"euler": own, "unit": unit, "order": program.order}
        if program.negated:
            values["negated"] = list(program.negated)
        self._draft.tables["orientation"] = TomlDraft(values)
        if not sure:
            question = f"Are the angles in degrees or radians? They go up to {high:.3g}."
            assumed = {"deg": "degrees", "rad": "radians"}[unit]
            wrong = "turns would be 57 times as large or as small"
            doubts.append(OpenDoubt(question, assumed, Stake(wrong, 85)))
        return doubts

    def _angle_unit(self, names: Sequence[str], high: float) -> tuple[Literal["deg", "rad"], bool]:
        said = {word for name in names for word in tokens(name)}
        if {"deg", "degrees", "grad"} & said or high > TURN:
            return "deg", True
        if {"rad", "radians"} & said:
            return "rad", True
        return ("deg", True) if self._program is UNITY else ("rad", False)

    def _whose_head(self) -> None:
        """Ask whether it is the head that was tracked, where no word says so."""
        group, stem = self._turned.group, self._file.stem.casefold()
        said = group.weight("head") > 0 or any(word in stem for word in _HEAD_IN_NAMES)
        if not said and self._sample.headings != OF_UNITY:
            name = next(iter(group.columns.values()))
            self._doubt(
                f"Are {name!r} and the like poses of the head?", "they are",
                "the picture would follow a hand or an object", 70,
            )  # fmt: skip

    def _missing(self) -> None:
        """List the texts among the poses that are no numbers."""
        texts: dict[str, None] = {}
        for name in self._used[1:]:
            place = self._sample.headings.index(name)
            cells = {row[place] for row in self._sample.rows}
            texts |= dict.fromkeys(sorted(c for c in cells if c and number_or_none(c) is None))
        if texts:
            self._draft.put("missing", [*texts][:20], "rows with one of these are left out")

    def _compare(self, frames: tuple[Program, Program]) -> None:
        """Take the frame in which the head moves the way it looks, and ask."""
        scores = {}
        for frame in frames:
            self._in_frame(frame)
            trace, _ = self._tried()
            scores[frame] = 0.0 if trace is None else moves_as_it_looks(trace)
        best = max(frames, key=lambda frame: scores[frame])
        (other,) = (frame for frame in frames if frame is not best)
        self._doubts += self._in_frame(best)
        shown = f"{best.name}: the head moves the way it looks, as heads do"
        if abs(scores[best]) < _TELLING:
            shown = f"{best.name}, though the motion hardly tells"
        self._doubt(
            f"Which frame is it: {best.name} ({best.axes.hand}-handed) or {other.name} "
            f"({other.axes.hand}-handed)?",
            f"{shown} ({scores[best]:.2f} of 1, otherwise {scores[other]:.2f})",
            "left and right turns, or steps ahead and back, would be exchanged", 95,
        )  # fmt: skip

    def _tried(self) -> tuple[Trace | None, str]:
        try:
            return import_log(self._file, parse_log_mapping(self._draft.text(), None)), ""
        except InputError as error:
            return None, str(error)

    def suggestion(self) -> LogSuggestion:
        """Return the mapping, with what it makes of the log."""
        trace, refusal = self._tried()
        if refusal:
            question = "As it stands, the import refuses the log; mend this:"
            self._doubt(question, refusal, "nothing is imported", 100)
        asked = write_doubts(self._draft, self._doubts)
        return LogSuggestion(escape_surrogates(self._draft.text()), tuple(asked), trace)


def _is_height(values: Array) -> bool:
    median = float(np.median(values)) if len(values) else 0.0
    return any(_HEIGHTS_M[0] < median * scale < _HEIGHTS_M[1] for scale in METRES.values())


def _length_unit(heights: Array, names: Sequence[str]) -> LengthUnit:
    said = {word for name in names for word in tokens(name)}
    named = next((unit for unit in METRES if unit in said), None)
    if named is not None:
        return named
    median = float(np.median(heights)) if len(heights) else 0.0
    fits = (u for u, scale in METRES.items() if _HEIGHTS_M[0] < median * scale < _HEIGHTS_M[1])
    return next(fits, "m")


def moves_as_it_looks(trace: Trace) -> float:
    """Return how far a head moves the way it looks, −1 to 1.

    People walk the way they look, and the eyes, in front of the neck, move to the side to which
    the head turns. Both hold in the right frame alone; in its mirror image they are reversed.
    """
    every = max(1, round(1e9 / _LOOKED_HZ / trace.median_period_ns))
    track = trace.head[slice(None, None, every)]
    if len(track.positions) < 3:
        return 0.0
    looks = rotate(track.orientations, np.tile(FORWARD, (len(track.positions), 1)))[:, [0, 2]]
    moved, turned = np.diff(track.positions[:, [0, 2]], axis=0), np.diff(looks, axis=0)
    walks = np.linalg.norm(moved, axis=1) * _LOOKED_HZ > _WALKING_M_S
    turns_fast = np.linalg.norm(turned, axis=1) * _LOOKED_HZ > _TURNING_PER_S
    ahead = _cosine(moved[walks], looks[1:][walks])
    aside = _cosine(moved[turns_fast], turned[turns_fast])
    return max(ahead, aside, key=abs)


_LOOKED_HZ, _WALKING_M_S, _TURNING_PER_S = 5, 0.3, 0.5


def _cosine(a: Array, b: Array) -> float:
    size = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / size if size > 0 else 0.0


def described(trace: Trace) -> list[str]:
    """Return what a trace holds, in lines that a person can check."""
    places = trace.head.positions
    gaps = int(np.sum(trace.cuts[1:]))
    hz = 1e9 / trace.median_period_ns
    low, high = places.min(axis=0), places.max(axis=0)
    names = ("right", "up", "back")
    ranges = ", ".join(
        f"{n} {a:.2f} to {b:.2f} m" for n, a, b in zip(names, low, high, strict=True)
    )
    looks = rotate(trace.head.orientations, np.tile(FORWARD, (len(places), 1)))
    lines = [f"{len(trace)} samples over {trace.duration_s:.1f} s, {hz:.1f} a second, {gaps} gaps"]
    lines += [f"head: {ranges}"]
    for row in dict.fromkeys((0, len(trace) // 2, len(trace) - 1)):
        x, y, z = looks[row]
        yaw, pitch = np.degrees(np.arctan2(-x, -z)), np.degrees(np.arcsin(np.clip(y, -1, 1)))
        side = "left" if yaw >= 0 else "right"
        way = "up" if pitch >= 0 else "down"
        at = (trace.time_ns[row] - trace.time_ns[0]) * 1e-9
        lines.append(
            f"at {at:.1f} s it looks {abs(yaw):.0f}° to the {side}, {abs(pitch):.0f}° {way}"
        )
    return lines
