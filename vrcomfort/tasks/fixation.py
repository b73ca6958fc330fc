"""Look at points: how much of the time the eyes (or the head) are on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.tasks.base import (
    Ball,
    Demand,
    Result,
    Surroundings,
    Task,
    TaskFrame,
    TaskSettings,
    angle_deg,
    numbers,
)

Angle = Annotated[float, Field(ge=-60, le=60)]
Metres = Annotated[float, Field(ge=0.2, le=1000)]


class Fixation(TaskSettings):
    """Look at points that appear one after the other, at angles from the view's middle."""

    kind: Literal["fixation"]
    """The kind of task."""
    points: tuple[tuple[Angle, Angle, Metres], ...] = (
        (0.0, 0.0, 1.0),
        (-10.0, 0.0, 1.0),
        (10.0, 0.0, 1.0),
        (0.0, 8.0, 1.0),
        (0.0, -8.0, 1.0),
    )
    """[degrees to the right, degrees up, metres] from where the head looks as each appears."""
    order: Literal["as_written", "shuffled"] = "shuffled"
    """In which order they come; each round is shuffled with the seed. Rounds follow each other as
    long as the exposure lasts."""
    each_s: Annotated[float, Field(ge=0.2, le=600)] = 2.0
    """How long each is shown."""
    settle_s: Annotated[float, Field(ge=0, le=60)] = 0.5
    """After it appeared: time in which the eyes are on their way, and nothing counts."""
    within_deg: Annotated[float, Field(ge=0.1, le=45)] = 3.0
    """So near to the point counts as looking at it."""
    diameter_deg: Annotated[float, Field(ge=0.1, le=10)] = 0.5
    """Angle at which a point is seen."""
    look_with: Literal["gaze", "head"] = "gaze"
    """The measure."""

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        return _Fixation(self, surroundings)


class _Fixation(Task):
    looks = ((0.9, 0.9, 0.9),)

    def __init__(self, settings: Fixation, surroundings: Surroundings) -> None:
        self._settings = settings
        self._random = surroundings.random
        self._left: list[int] = []
        self._ball: Ball | None = None
        self._number = self._hits = 0
        self._since_s = 0.0
        self._errors: list[float] = []
        self._on = self._counted = 0

    def step(self, frame: TaskFrame) -> Sequence[Result]:
        results: list[Result] = []
        if self._ball is None or frame.time_s >= self._since_s + self._settings.each_s:
            results += self._over()
            self._appear(frame)
        ball = self._ball
        ray = frame.gaze if self._settings.look_with == "gaze" else frame.head
        settled = frame.time_s >= self._since_s + self._settings.settle_s
        if ball is not None and ray is not None and settled:
            self._errors.append(angle_deg(ray, ball.position_m))
        return results

    def balls(self) -> Sequence[Ball | None]:
        return (self._ball,)

    def demand(self) -> Demand | None:
        ball = self._ball
        return None if ball is None else Demand(ball.position_m, self._since_s, press=False)

    def finish(self, time_s: float) -> Sequence[Result]:
        del time_s
        results = self._over()
        share = round(self._on / self._counted, 4) if self._counted else None
        whole = Result("trial", 1, "", 0.0, targets=self._number, hits=self._hits, score=share)
        return [*results, whole]

    def _appear(self, frame: TaskFrame) -> None:
        points = self._settings.points
        if not self._left:
            shuffled = self._settings.order == "shuffled"
            order = self._random.permutation(len(points)) if shuffled else np.arange(len(points))
            self._left = order.tolist()
        right_deg, up_deg, away_m = points[self._left.pop(0)]
        look = yaw_pitch_roll(-np.radians(right_deg), np.radians(up_deg), 0.0)
        ray = frame.head @ Pose(orientation=look)
        radius_m = away_m * float(np.sin(np.radians(self._settings.diameter_deg / 2)))
        self._ball = Ball(frame.head.position + ray.forward * away_m, radius_m)
        self._number += 1
        self._since_s = frame.time_s

    def _over(self) -> list[Result]:
        """Return the row of the point that was shown: hit where most of the time was on it."""
        ball, errors, self._errors = self._ball, self._errors, []
        if ball is None:
            return []
        on = sum(error <= self._settings.within_deg for error in errors)
        hit = int(2 * on > len(errors)) if errors else None
        self._on, self._counted = self._on + on, self._counted + len(errors)
        self._hits += hit or 0
        return [
            Result(
                "target",
                self._number,
                f"point_{self._number}",
                self._since_s,
                hit=hit,
                error_deg=round(float(np.mean(errors)), 4) if errors else None,
                position_m=numbers(ball.position_m),
            )
        ]
