"""The interface of tasks: a task sees each frame, shows balls, and returns results.

A task knows nothing of files, headsets or rendering: it gets poses in the world, and gives places
and numbers. Everything left to chance comes from the generator that it is given, so that the same
seed gives the same task.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field

from vrcomfort.geometry import Array, Pose
from vrcomfort.settings import Settings, Word

Rgb = tuple[float, float, float]
Coordinate = Annotated[float, Field(ge=-1e5, le=1e5)]
Point = tuple[Coordinate, Coordinate, Coordinate]
"""x, y and z in the world, in metres."""


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball in the scene.

    Parameters
    ----------
    position_m
        (3,) world.
    radius_m
        Of the ball.
    """

    position_m: Array
    radius_m: float


@dataclass(frozen=True)
class TaskFrame:
    """One frame of an exposure, in the world.

    Parameters
    ----------
    time_s
        Seconds of the exposure that have been shown.
    head
        world-from-head.
    gaze
        world-from-gaze, −Z along the line of sight; None without an eye tracker, or in a blink.
    pressed
        world-from-aim of each button that went down in this frame, −Z along the ray; an entry is
        None where nothing is known of where its hand points.
    held
        The same of each button that is down.
    """

    time_s: float
    head: Pose
    gaze: Pose | None = None
    pressed: tuple[Pose | None, ...] = ()
    held: tuple[Pose | None, ...] = ()


@dataclass(frozen=True, eq=False)
class Demand:
    """The ideal action at the moment; simulated participants follow it.

    Parameters
    ----------
    position_m
        (3,) world: where to look.
    since_s
        When it could first be seen, in seconds of the exposure.
    press
        Whether to point there, too, and press.
    place_at
        Of a target that moves: (3,) world at a time of the exposure.
    every_s
        Presses sooner after another do not count.
    """

    position_m: Array
    since_s: float
    press: bool
    place_at: Callable[[float], Array] | None = None
    every_s: float = 0.0


@dataclass(frozen=True)
class Result:
    """A row of ``tasks.csv``; None where a column does not apply.

    Parameters
    ----------
    kind
        ``target``: something that was to be met, told when it is over; ``shot``: one press of the
        button; ``sample``: a measurement now and then; ``trial``: the whole exposure.
    number
        Counts the rows of one kind from 1.
    what
        Name of the target.
    time_s
        When it began, in seconds of the exposure.
    reaction_s
        Of a target: from its beginning until it was met.
    hit
        1 where a target was met, or a shot met one; else 0.
    error_deg
        Angle between where somebody pointed (or looked) and the middle of the target.
    distance_m
        To the target; from the path.
    position_m
        (3,) world: of a target, or the head's in a sample.
    targets, hits, shots, score, deaths
        Of the whole exposure; `score` is the number that the task is about.
    """

    kind: Literal["target", "shot", "sample", "trial"]
    number: int
    what: str
    time_s: float
    reaction_s: float | None = None
    hit: int | None = None
    error_deg: float | None = None
    distance_m: float | None = None
    position_m: tuple[float, float, float] | None = None
    targets: int | None = None
    hits: int | None = None
    shots: int | None = None
    score: float | None = None
    deaths: int | None = None


SceneObject: TypeAlias = Callable[[float], Ball]
"""A node of the scene: time of the scene in seconds → the ball around it."""


@dataclass(frozen=True)
class Surroundings:
    """A task's view of its scene.

    Parameters
    ----------
    random
        The only source of chance.
    duration_s
        How long the exposure is shown.
    spawn
        world-from-stage of the scene's starting point.
    thing
        Gives a node of the scene by its name; raises `InputError` if there is none.
    free_m
        Takes world-from-ray; how far one sees along it, infinite into the sky.
    """

    random: np.random.Generator
    duration_s: float
    spawn: Pose
    thing: Callable[[str], SceneObject]
    free_m: Callable[[Pose], float]


class Task(ABC):
    """One task in one exposure.

    Attributes
    ----------
    looks
        Linear RGB of each ball that it can show.
    """

    looks: Sequence[Rgb] = ()

    @property
    def wanted(self) -> str | None:
        """Return an instruction for the participant, such as a thing to look for; None: nothing."""
        return None

    @property
    def done(self) -> bool:
        """Return whether nothing is left to do, which may end the exposure."""
        return False

    def next_s(self) -> float | None:
        """Return when something happens next that is no press, in seconds of the exposure.

        None: every frame counts, as where the gaze or the way of the head does.
        """
        return None

    @abstractmethod
    def step(self, frame: TaskFrame) -> Sequence[Result]:
        """Take a frame, before it is drawn; return the results that are complete with it."""

    def balls(self) -> Sequence[Ball | None]:
        """Return where each ball is now, in the order of `looks`; None: it is not shown."""
        return ()

    def demand(self) -> Demand | None:
        """Return the ideal action now; None: nothing."""
        return None

    @abstractmethod
    def finish(self, time_s: float) -> Sequence[Result]:
        """End with the exposure; return open results, and last the row of the trial."""


class TaskSettings(Settings):
    """Settings that all tasks have."""

    name: Word
    """Name of the task in `task`, and in `tasks.csv`."""

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        raise NotImplementedError


class Pointed(TaskSettings):
    """Settings of tasks in which people point."""

    aim_with: Literal["hand", "head", "gaze"] = "hand"
    """Origin of the ray when a button goes down: the hand that presses (a window: the mouse), the
    middle of the head's view, or the eyes. Where a hand or the eyes are not known, the head."""

    def rays(self, frame: TaskFrame, *, held: bool = False) -> list[Pose]:
        """Return world-from-ray of each press of a moment, or of each button that is down."""
        hands = frame.held if held else frame.pressed
        if self.aim_with == "hand":
            return [hand or frame.head for hand in hands]
        looks = frame.gaze if self.aim_with == "gaze" else None
        return [looks or frame.head] * len(hands)


def angle_deg(ray: Pose, position_m: Array) -> float:
    """Return the angle between a ray (−Z of world-from-ray) and the way to a (3,) point."""
    towards = position_m - ray.position
    along = ray.forward
    # By the tangent: a cosine says nothing of angles below a thousandth of a degree.
    (ax, ay, az), (bx, by, bz) = along.tolist(), towards.tolist()
    across = math.hypot(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    return math.degrees(math.atan2(across, ax * bx + ay * by + az * bz))


def numbers(position_m: Array) -> tuple[float, float, float]:
    """Return a (3,) position as plain numbers, to a tenth of a millimetre."""
    x, y, z = np.round(position_m, 4).tolist()
    return x, y, z
