"""The mapping of a head log: its columns, units and axes, in TOML."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from vrcomfort.files import read_text
from vrcomfort.importing.mapping import Doubt, Guess, TextRead, Texts, require_answers
from vrcomfort.rotations import Array
from vrcomfort.settings import Problem, Settings, first_problem, parse_settings

TimeUnit = Literal["s", "ms", "us", "ns", "min", "ticks", "clock", "frames"]
LengthUnit = Literal["m", "cm", "mm"]
AngleUnit = Literal["deg", "rad"]
Order = Literal["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"]
Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
METRES: dict[LengthUnit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}
STANDING_M = (0.0, 1.6, 0.0)
"""Where a head is put of which only the orientation was logged."""


class LogRead(TextRead):
    """How the log is read; omitted keys are detected."""

    heading_row: Annotated[int, Field(ge=0)] | None = None
    """The row of the headings, from 1; 0: none, columns are ``column 1`` and so on."""


class LogTime(Settings):
    """When each sample was taken."""

    column: str | None = None
    columns: tuple[str, ...] = ()
    """Several columns that together say it, such as date and time; joined by a space."""
    unit: TimeUnit = "s"
    """`ticks` are 100 ns (.NET), `clock` is ``12:59:59.123``, with or without a date, and `frames`
    are counted at `rate_hz`."""
    rate_hz: Annotated[float, Field(gt=0, le=10_000)] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Return the columns."""
        return self.columns or ((self.column,) if self.column else ())


class LogPosition(Settings):
    """Where the head was, along the log's x, y and z."""

    columns: tuple[str, str, str]
    unit: LengthUnit = "m"


class EulerColumns(Settings):
    """The columns of the turns about the log's x, y and z."""

    x: str
    y: str
    z: str


class LogOrientation(Settings):
    """Where the head looked: a quaternion, or three turns."""

    quaternion: tuple[str, str, str, str] | None = None
    """The columns of x, y, z and w."""
    euler: EulerColumns | None = None
    unit: AngleUnit = "deg"
    order: Order = "zxy"
    """The order of the turns about fixed axes: Unity turns about z first, then x, then y."""
    negated: tuple[Literal["x", "y", "z"], ...] = ()
    """Turns that are positive against the rule of the log's own hand."""

    @property
    def names(self) -> tuple[str, ...]:
        """Return the columns."""
        if self.quaternion is not None:
            return self.quaternion
        return () if self.euler is None else (self.euler.x, self.euler.y, self.euler.z)


class LogAxes(Settings):
    """Which of the log's axes point to the right, up and forward."""

    right: Axis = "x"
    up: Axis = "y"
    forward: Axis = "z"

    @property
    def matrix(self) -> Array:
        """Return (3, 3): OpenXR's coordinates (x right, y up, z back) from the log's."""
        return np.array([_unit(self.right), _unit(self.up), -_unit(self.forward)])

    @property
    def hand(self) -> Literal["left", "right"]:
        """Return the handedness of the log's frame."""
        return "right" if np.linalg.det(self.matrix) > 0 else "left"


def _unit(axis: Axis) -> Array:
    unit: Array = np.eye(3)["xyz".index(axis[-1])]
    return -unit if axis[0] == "-" else unit


class LogMapping(Settings):
    """The mapping of a head log."""

    format_version: Literal[1]
    read: LogRead = Field(default_factory=LogRead)
    time: LogTime
    position: LogPosition | None = None
    position_m: tuple[float, float, float] = STANDING_M
    """Where the head is (x right, y up, z back) if no column says it."""
    orientation: LogOrientation
    axes: LogAxes = Field(default_factory=LogAxes)
    where: dict[str, Texts] = Field(default_factory=dict)
    """Column → text (or texts) that a row has to have there, such as a trial."""
    missing: tuple[str, ...] = ()
    """Texts that mean that nothing was tracked, beside the blank; such rows are left out."""
    longest_step_s: Annotated[float, Field(gt=0)] | None = None
    """After a longer time without a sample the view begins anew: nothing is interpolated. Without
    it, that is five of the usual steps, and at least 0.5 s."""
    repeated_times: Literal["refuse", "leave_out"] = "refuse"
    """`leave_out`: of rows with the same time, the first one counts."""
    doubts: tuple[Doubt, ...] = ()
    guesses: tuple[Guess, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Return every column that is needed, once."""
        position = self.position.columns if self.position else ()
        return tuple(
            dict.fromkeys((*self.time.names, *position, *self.orientation.names, *self.where))
        )


def load_log_mapping(file: Path) -> LogMapping:
    """Read a mapping, and require an answer to each doubt.

    Raises
    ------
    InputError
        If it is missing or wrong, or a doubt is open; with line and column.
    """
    mapping = parse_log_mapping(read_text(file, "mapping"), file)
    require_answers(mapping.doubts, file)
    return mapping


def parse_log_mapping(text: str, file: Path | None) -> LogMapping:
    """Read the text of a mapping; its doubts may be open.

    Raises
    ------
    InputError
        If it is wrong, with line and column.
    """
    mapping = parse_settings(LogMapping, text, file)
    if problems := list(_problems(mapping)):
        raise first_problem(problems, text, file)
    return mapping


def _problems(mapping: LogMapping) -> Iterator[Problem]:
    """Yield problems between keys, which types cannot express."""
    time, orientation, axes = mapping.time, mapping.orientation, mapping.axes
    if (time.column is None) == (not time.columns):
        yield Problem(("time",), "`time` needs column = … or columns = […]; write one of them")
    if (time.unit == "frames") != (time.rate_hz is not None):
        yield Problem(("time",), 'unit = "frames" and rate_hz go together; write both')
    if (orientation.quaternion is None) == (orientation.euler is None):
        message = "`orientation` needs quaternion = […] or euler = {…}; write one of them"
        yield Problem(("orientation",), message)
    letters = {axis[-1] for axis in (axes.right, axes.up, axes.forward)}
    if len(letters) < 3:
        message = "right, up and forward are three different axes; name x, y and z once each"
        yield Problem(("axes",), message)


UNITY_EULER = LogMapping(
    format_version=1,
    time=LogTime(column="Time"),
    position=LogPosition(columns=("x", "y", "z")),
    orientation=LogOrientation(euler=EulerColumns(x="alpha", y="beta", z="gamma")),
)
"""Logs with the columns ``Time x y z alpha beta gamma``, in Unity's frame."""
