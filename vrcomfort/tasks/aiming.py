"""Aiming: balls appear at places drawn with the seed, and are shot.

After Hillaire et al. 2008, whose players shot at enemies "as precise as possible ... while using as
little ammunition as possible": hits, precision and reaction times are their performance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.geometry import Array, Pose, yaw_pitch_roll
from vrcomfort.tasks.base import (
    Ball,
    Demand,
    Point,
    Pointed,
    Result,
    Surroundings,
    Task,
    TaskFrame,
    angle_deg,
    numbers,
)

Metres = Annotated[float, Field(ge=0.2, le=1000)]
_BEFORE_WALLS = 0.9
"""Share of the distance to the scene behind a target, so that no ball is inside of a wall."""


class Targets(Pointed):
    """Places and sizes of targets that are shot."""

    diameter_deg: Annotated[float, Field(ge=0.1, le=30)] = 2.0
    """Angle at which a target is seen when it appears."""
    field_deg: Annotated[float, Field(ge=0, le=170)] = 40.0
    """Targets appear within this cone around the middle of the view."""
    distance_m: tuple[Metres, Metres] = (1.5, 4.0)
    """Nearest and farthest; nearer where something of the scene is before that."""
    places_m: tuple[Point, ...] = ()
    """Places in the scene from which targets are drawn, instead of the cone; none twice in a row
    where there are several."""

    @field_validator("distance_m")
    @classmethod
    def _nearer_first(cls, value: tuple[float, float]) -> tuple[float, float]:
        if value[0] > value[1]:
            raise PydanticCustomError("aiming", "`distance_m` names the nearer distance first")
        return value

    def radius_m(self, position_m: Array, head: Pose) -> float:
        """Return the radius of a target at a place that is seen from a head."""
        away_m = float(np.linalg.norm(position_m - head.position))
        return away_m * float(np.sin(np.radians(self.diameter_deg / 2)))


class PlaceDraw:
    """Draws the places of an exposure's targets, with the seed."""

    def __init__(self, settings: Targets, surroundings: Surroundings) -> None:
        self._settings, self._around = settings, surroundings
        self._place: int | None = None

    def next(self, head: Pose) -> Array:
        """Draw a place: one of the scene's, or one in view that nothing hides."""
        settings, random = self._settings, self._around.random
        if settings.places_m:
            others = [k for k in range(len(settings.places_m)) if k != self._place] or [0]
            self._place = others[int(random.integers(len(others)))]
            return np.array(settings.places_m[self._place])
        share, turn = random.random(), 2 * np.pi * random.random()
        nearest, farthest = settings.distance_m
        wanted_m = 1 / random.uniform(1 / farthest, 1 / nearest)  # evenly in dioptres
        aside = np.radians(settings.field_deg / 2) * np.sqrt(share)
        look = yaw_pitch_roll(aside * np.cos(turn), aside * np.sin(turn), 0.0)
        ray = head @ Pose(orientation=look)
        seen_m = self._around.free_m(ray)
        return head.position + ray.forward * min(wanted_m, max(_BEFORE_WALLS * seen_m, 0.1))


def meets(ray: Pose, ball: Ball) -> tuple[bool, float]:
    """Return whether a ray meets a ball, and its angle to the ball's middle in degrees."""
    away_m = float(np.linalg.norm(ball.position_m - ray.position))
    error = angle_deg(ray, ball.position_m)
    return error <= np.degrees(np.arcsin(min(ball.radius_m / max(away_m, 1e-9), 1.0))), error


class Aiming(Targets):
    """Shoot targets: hits, precision in degrees, reaction times (Hillaire et al. 2008)."""

    kind: Literal["aiming"]
    """The kind of task."""
    every_s: Annotated[float, Field(ge=0.2, le=3600)] = 4.0
    """From one target to the next."""
    shown_s: Annotated[float, Field(ge=0.1, le=3600)] = 3.0
    """A target disappears when it is hit, or after this time."""
    jitter_s: Annotated[float, Field(ge=0, le=600)] = 0.5
    """Largest random delay of a target, evenly drawn, so that its time cannot be predicted."""

    @model_validator(mode="after")
    def _one_at_a_time(self) -> Aiming:
        if self.shown_s + self.jitter_s > self.every_s:
            message = "`shown_s` + `jitter_s` is more than `every_s`: two targets at a time"
            raise PydanticCustomError("aiming", message)
        return self

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        return _Aiming(self, surroundings)


@dataclass(frozen=True, eq=False)
class _Target:
    number: int
    ball: Ball
    since_s: float
    distance_m: float


class _Aiming(Task):
    looks = ((0.9, 0.12, 0.05),)

    def __init__(self, settings: Aiming, surroundings: Surroundings) -> None:
        self._settings = settings
        self._around = surroundings
        self._target: _Target | None = None
        self._places = PlaceDraw(settings, surroundings)
        self._shown = self._hits = self._shots = 0
        self._next_s = self._due_s(0)

    def _due_s(self, index: int) -> float:
        """Return when target `index` (from 0) comes."""
        wait_s = float(self._around.random.uniform(0.0, self._settings.jitter_s))
        return index * self._settings.every_s + wait_s

    def step(self, frame: TaskFrame) -> Sequence[Result]:
        results: list[Result] = []
        for ray in self._settings.rays(frame):
            results += self._shot(ray, frame.time_s)
        target = self._target
        if target and frame.time_s >= target.since_s + self._settings.shown_s:
            results.append(self._over(None))
        if self._target is None and frame.time_s >= self._next_s:
            self._appear(frame)
        return results

    def next_s(self) -> float | None:
        target = self._target
        return target.since_s + self._settings.shown_s if target else self._next_s

    def balls(self) -> Sequence[Ball | None]:
        return (self._target.ball if self._target else None,)

    def demand(self) -> Demand | None:
        target = self._target
        return None if target is None else Demand(target.ball.position_m, target.since_s, True)

    def finish(self, time_s: float) -> Sequence[Result]:
        del time_s
        results = [] if self._target is None else [self._over(None)]
        whole = Result(
            "trial", 1, "", 0.0, targets=self._shown, hits=self._hits, shots=self._shots,
            score=float(self._hits),
        )  # fmt: skip
        return [*results, whole]

    def _appear(self, frame: TaskFrame) -> None:
        position_m = self._places.next(frame.head)
        away_m = float(np.linalg.norm(position_m - frame.head.position))
        radius_m = self._settings.radius_m(position_m, frame.head)
        self._shown += 1
        self._target = _Target(self._shown, Ball(position_m, radius_m), frame.time_s, away_m)
        self._next_s = self._due_s(self._shown)

    def _shot(self, ray: Pose, time_s: float) -> list[Result]:
        self._shots += 1
        target = self._target
        if target is None:
            return [Result("shot", self._shots, "", time_s, hit=0)]
        hit, error = meets(ray, target.ball)
        away_m = float(np.linalg.norm(target.ball.position_m - ray.position))
        shot = Result(
            "shot", self._shots, f"target_{target.number}", time_s, hit=int(hit),
            error_deg=round(error, 4), distance_m=round(away_m, 4),
        )  # fmt: skip
        return [shot, self._over(time_s)] if hit else [shot]

    def _over(self, hit_s: float | None) -> Result:
        target, self._target = self._target, None
        assert target is not None  # noqa: S101 - callers know
        self._hits += hit_s is not None
        return Result(
            "target",
            target.number,
            f"target_{target.number}",
            target.since_s,
            reaction_s=None if hit_s is None else round(hit_s - target.since_s, 6),
            hit=int(hit_s is not None),
            distance_m=round(target.distance_m, 4),
            position_m=numbers(target.ball.position_m),
        )
