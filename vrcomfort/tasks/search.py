"""Search: things of the scene are named one after the other, and are pointed at."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from vrcomfort.geometry import Pose
from vrcomfort.tasks.base import (
    Demand,
    Pointed,
    Result,
    Surroundings,
    Task,
    TaskFrame,
    angle_deg,
    numbers,
)


class VisualSearch(Pointed):
    """Find a named thing, point at it and press: hits and search times."""

    kind: Literal["search"]
    """The kind of task."""
    things: Annotated[tuple[str, ...], Field(min_length=1)]
    """Names of nodes of the scene. The experimenter says which is looked for: the event
    `task_target` names it."""
    order: Literal["as_written", "shuffled"] = "shuffled"
    """In which order they are looked for; shuffled with the seed."""
    within_s: Annotated[float, Field(ge=0.5, le=3600)] = 30.0
    """Time after which a thing is missed, and the next is looked for."""
    slack_deg: Annotated[float, Field(ge=0, le=30)] = 1.0
    """Tolerance of pointing beside a thing."""

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        return _Search(self, surroundings)


class _Search(Task):
    def __init__(self, settings: VisualSearch, surroundings: Surroundings) -> None:
        self._settings = settings
        things = [(name, surroundings.thing(name)) for name in settings.things]
        if settings.order == "shuffled":
            order = surroundings.random.permutation(len(things))
            things = [things[k] for k in order]
        self._things = things
        self._index = self._found = self._shots = 0
        self._since_s = self._now_s = 0.0

    @property
    def wanted(self) -> str | None:
        """Return the thing to be found; None when all is over."""
        return self._things[self._index][0] if self._index < len(self._things) else None

    @property
    def done(self) -> bool:
        """Return whether all things were found or missed."""
        return self.wanted is None

    def step(self, frame: TaskFrame) -> Sequence[Result]:
        self._now_s = frame.time_s
        results: list[Result] = []
        for ray in self._settings.rays(frame):
            results += self._shot(ray, frame.time_s)
        if self.wanted and frame.time_s >= self._since_s + self._settings.within_s:
            results.append(self._over(frame.time_s, found=False))
        return results

    def demand(self) -> Demand | None:
        if self.wanted is None:
            return None
        ball = self._things[self._index][1](self._now_s)
        return Demand(ball.position_m, self._since_s, True)

    def finish(self, time_s: float) -> Sequence[Result]:
        results = [] if self.wanted is None else [self._over(time_s, found=False)]
        whole = Result(
            "trial", 1, "", 0.0, targets=self._index, hits=self._found, shots=self._shots,
            score=float(self._found),
        )  # fmt: skip
        return [*results, whole]

    def _shot(self, ray: Pose, time_s: float) -> list[Result]:
        self._shots += 1
        if self.wanted is None:
            return [Result("shot", self._shots, "", time_s, hit=0)]
        name, thing = self._things[self._index]
        ball = thing(time_s)
        away_m = float(np.linalg.norm(ball.position_m - ray.position))
        error = angle_deg(ray, ball.position_m)
        wide = float(np.degrees(np.arcsin(min(ball.radius_m / max(away_m, 1e-9), 1.0))))
        hit = error <= wide + self._settings.slack_deg
        shot = Result(
            "shot", self._shots, name, time_s, hit=int(hit), error_deg=round(error, 4),
            distance_m=round(away_m, 4),
        )  # fmt: skip
        return [shot, self._over(time_s, found=True)] if hit else [shot]

    def _over(self, time_s: float, *, found: bool) -> Result:
        name, thing = self._things[self._index]
        result = Result(
            "target", self._index + 1, name, self._since_s,
            reaction_s=round(time_s - self._since_s, 6) if found else None, hit=int(found),
            position_m=numbers(thing(time_s).position_m),
        )  # fmt: skip
        self._index, self._since_s = self._index + 1, time_s
        self._found += found
        return result
