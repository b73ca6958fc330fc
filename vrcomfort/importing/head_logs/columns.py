"""Finds time, position and orientation among the columns of a head log, by weighted evidence.

Each line of `WORDS` is one piece of evidence: words of a heading, the role that they speak for, and
their weight. A new kind of log begins with a line there or in `PROGRAMS`.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

from vrcomfort.importing.head_logs.mapping import LogAxes, Order
from vrcomfort.importing.head_logs.reading import LogSample
from vrcomfort.importing.suggest.vocabulary import tokens

Role = Literal["time", "position", "orientation", "head"]
"""`head` speaks for the head as the tracked thing, whatever of it a column says."""


class WordEvidence(NamedTuple):
    """Words of a heading that speak for a role, or (with a weight below 0) against it."""

    role: Role
    weight: int
    words: frozenset[str]


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


WORDS: tuple[WordEvidence, ...] = (
    WordEvidence("time", 40, _words("time timestamp zeit zeitstempel t elapsed seconds clock")),
    WordEvidence("time", 10, _words("ns us ms s sec ticks unix unixtime media game")),
    WordEvidence("time", 60, _words("realtime startup")),
    WordEvidence("time", -20, _words("wall wallclock date system")),
    WordEvidence("time", -30, _words("delta dt duration fps frame frames remaining reaction")),
    WordEvidence("position", 40, _words("pos position p loc location translation trans")),
    WordEvidence("orientation", 40, _words("rot rotation q quat quaternion orientation r ori")),
    WordEvidence("orientation", 30, _words("euler eulerangles angle angles rpy deg rad attitude")),
    WordEvidence("head", 30, _words("head hmd headset camera cam centereye kopf")),
    WordEvidence("head", 20, _words("center centre main viewer user player")),
    WordEvidence("head", -60, _words("left right hand controller ctrl touch wand")),
    WordEvidence("head", -60, _words("gaze eye eyes hit target object body waist foot origin")),
    WordEvidence("head", -40, _words("velocity vel angular acceleration acc delta dir speed")),
)


_COMPONENTS = _words("x y z w yaw pitch roll alpha beta gamma")
_UNITS = _words("m cm mm deg degrees rad radians world global local")
_RUN_ON = re.compile(r"(q|p|r|pos|rot|quat|position|rotation|orientation|head|hmd)([xyzw])")
"""``qx`` and ``posx`` end in a component; ``index`` and ``max`` do not."""
_TURNS = _words("yaw pitch roll")
_GREEK = {"alpha": "x", "beta": "y", "gamma": "z"}


class ComponentColumns(NamedTuple):
    """Columns that differ in a component alone.

    Parameters
    ----------
    stem
        The words that they share.
    columns
        Component (x, y, z, w, or yaw, pitch, roll) → column.
    """

    stem: tuple[str, ...]
    columns: dict[str, str]

    def weight(self, role: Role) -> int:
        """Return the weight of the stem for a role of the head."""
        return weight_of(self.stem, role) + weight_of(self.stem, "head")


def weight_of(words: Sequence[str], role: Role) -> int:
    """Return the weight of words for a role; each line of the table counts once."""
    return sum(line.weight for line in WORDS if line.role == role and line.words & {*words})


def groups_of(headings: Sequence[str]) -> list[ComponentColumns]:
    """Return the columns that are components of one thing, in the order of the file."""
    found: dict[tuple[str, ...], dict[str, str]] = defaultdict(dict)
    for heading in headings:
        named = _component(heading)
        if named is not None:
            stem, component = named
            found[stem].setdefault(component, heading)
    return [ComponentColumns(stem, columns) for stem, columns in found.items()]


def _component(heading: str) -> tuple[tuple[str, ...], str] | None:
    """Return the words of a heading, and its component; None if it has none at its end."""
    words = tokens(heading)
    last = next((n for n in reversed(range(len(words))) if words[n] not in _UNITS), None)
    if last is None:
        return None
    stem, letter = [*words[:last], *words[last + 1 :]], words[last]
    if run_on := _RUN_ON.fullmatch(letter):
        stem, letter = [*stem, run_on[1]], run_on[2]
    if letter not in _COMPONENTS:
        return None
    if letter in _GREEK:
        return (*stem, "euler"), _GREEK[letter]
    return tuple(stem), letter


def quaternions(groups: Sequence[ComponentColumns]) -> list[ComponentColumns]:
    """Return the groups that are quaternions, the likeliest first."""
    found = [g for g in groups if {"x", "y", "z", "w"} <= {*g.columns}]
    return _sorted(found, "orientation")


def turns(groups: Sequence[ComponentColumns]) -> list[ComponentColumns]:
    """Return the groups that are three turns, the likeliest first."""
    named = [g for g in groups if {*g.columns} >= _TURNS]
    lettered = [
        g
        for g in groups
        if {*g.columns} & {"x", "y", "z", "w"} == {"x", "y", "z"}
        and weight_of(g.stem, "orientation") > 0
    ]
    return _sorted([*named, *lettered], "orientation")


def positions(groups: Sequence[ComponentColumns]) -> list[ComponentColumns]:
    """Return the groups that are positions, the likeliest first."""
    found = [
        g
        for g in groups
        if {"x", "y", "z"} <= {*g.columns}
        and "w" not in g.columns
        and weight_of(g.stem, "orientation") <= 0
    ]
    return _sorted(found, "position")


def _sorted(groups: Sequence[ComponentColumns], role: Role) -> list[ComponentColumns]:
    return sorted(groups, key=lambda group: -group.weight(role))


class Program(NamedTuple):
    """A program that writes logs, and the frame of its poses.

    Parameters
    ----------
    order, negated
        Of its turns, where it logs turns.
    """

    name: str
    axes: LogAxes
    order: Order
    negated: tuple[Literal["x", "y", "z"], ...] = ()


UNITY = Program("Unity", LogAxes(), "zxy")
OPENXR = Program("OpenXR, OpenVR, WebXR and Oculus", LogAxes(forward="-z"), "zxy")
UNREAL = Program("Unreal", LogAxes(right="y", up="z", forward="x"), "xyz", ("x", "y"))
RIGHT_HANDED_Z_UP = Program("right-handed, z up", LogAxes(right="-y", up="z", forward="x"), "xyz")
UXF = ("time", "pos_x", "pos_y", "pos_z", "rot_x", "rot_y", "rot_z")
OF_UNITY = ("Time", "x", "y", "z", "alpha", "beta", "gamma")
_NATIVE = _words("openxr openvr steamvr ovr oculus webxr aframe xr")


def written_by(sample: LogSample, vectors: bool) -> Program | None:
    """Return the program that a log tells of; None where it tells of none.

    Parameters
    ----------
    vectors
        Poses stand as ``(0.1, 1.6, 0.2)``, as Unity prints them.
    """
    if vectors or any(sample.headings[: len(each)] == each for each in (UXF, OF_UNITY)):
        return UNITY
    said = {word for name in (*sample.headings, sample.file.stem) for word in tokens(name)}
    if {"unity"} & said:
        return UNITY
    if {"unreal", "ue", "ue4", "ue5"} & said:
        return UNREAL
    return OPENXR if _NATIVE & said else None


def time_columns(headings: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Yield weight and heading of the columns that may be times."""
    for heading in headings:
        weight = weight_of(tokens(heading), "time")
        if weight > 0:
            yield weight, heading
