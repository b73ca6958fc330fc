"""Follow a path: how far from it people walk while a ball goes ahead of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from vrcomfort.geometry import Array
from vrcomfort.tasks.base import (
    Ball,
    Demand,
    Point,
    Result,
    Surroundings,
    Task,
    TaskFrame,
    TaskSettings,
    numbers,
)


class FollowPath(TaskSettings):
    """Walk along a path behind a ball: the distance from the path, seen from above."""

    kind: Literal["follow_path"]
    """The kind of task."""
    path_m: Annotated[tuple[Point, ...], Field(min_length=2)]
    """Points of the scene, at the height at which the ball goes."""
    speed_m_s: Annotated[float, Field(ge=0.01, le=20)] = 1.0
    """How fast the ball goes; at the end it stays."""
    diameter_m: Annotated[float, Field(ge=0.01, le=2)] = 0.1
    """Of the ball."""
    sample_s: Annotated[float, Field(ge=0.05, le=60)] = 0.5
    """From one row with the distance to the next."""

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        del surroundings
        return _FollowPath(self)


class _FollowPath(Task):
    looks = ((0.05, 0.5, 0.9),)

    def __init__(self, settings: FollowPath) -> None:
        self._settings = settings
        self._points = np.array(settings.path_m)
        steps = np.linalg.norm(np.diff(self._points, axis=0), axis=1)
        self._along_m = np.concatenate([[0.0], np.cumsum(steps)])
        self._samples = self._frames = 0
        self._sum_m = self._time_s = 0.0

    def step(self, frame: TaskFrame) -> Sequence[Result]:
        self._time_s = frame.time_s
        away_m = self._away_m(frame.head.position)
        self._sum_m += away_m
        self._frames += 1
        if frame.time_s < self._samples * self._settings.sample_s:
            return ()
        self._samples += 1
        where = numbers(frame.head.position)
        away_m = round(away_m, 4)
        return [
            Result("sample", self._samples, "", frame.time_s, distance_m=away_m, position_m=where)
        ]

    def balls(self) -> Sequence[Ball | None]:
        return (Ball(self._ahead(), self._settings.diameter_m / 2),)

    def demand(self) -> Demand | None:
        return Demand(self._ahead(), 0.0, press=False)

    def finish(self, time_s: float) -> Sequence[Result]:
        del time_s
        mean_m = round(self._sum_m / self._frames, 4) if self._frames else None
        return [Result("trial", 1, "", 0.0, score=mean_m)]

    def _ahead(self) -> Array:
        gone_m = self._settings.speed_m_s * self._time_s
        return np.array([np.interp(gone_m, self._along_m, axis) for axis in self._points.T])

    def _away_m(self, position_m: Array) -> float:
        """Return the distance from the path, seen from above."""
        here = position_m[[0, 2]]
        starts, ends = self._points[:-1, [0, 2]], self._points[1:, [0, 2]]
        legs = ends - starts
        squares = np.maximum((legs**2).sum(axis=1), 1e-12)
        share = np.clip(((here - starts) * legs).sum(axis=1) / squares, 0.0, 1.0)
        nearest = starts + share[:, None] * legs
        return float(np.linalg.norm(here - nearest, axis=1).min())
