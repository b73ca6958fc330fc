"""Free exploration: nothing is to be done; how far people went is measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from vrcomfort.geometry import Array
from vrcomfort.tasks.base import Result, Surroundings, Task, TaskFrame, TaskSettings, numbers


class Exploration(TaskSettings):
    """Go and look wherever one likes: the way that was gone, seen from above."""

    kind: Literal["exploration"]
    """The kind of task."""
    sample_s: Annotated[float, Field(ge=0.1, le=600)] = 1.0
    """From one row with the place to the next; the way is the sum between them."""

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        del surroundings
        return _Exploration(self.sample_s)


class _Exploration(Task):
    def __init__(self, sample_s: float) -> None:
        self._sample_s = sample_s
        self._samples = 0
        self._gone_m = 0.0
        self._before: Array | None = None

    def step(self, frame: TaskFrame) -> Sequence[Result]:
        if frame.time_s < self._samples * self._sample_s:
            return ()
        here = frame.head.position
        if self._before is not None:
            self._gone_m += float(np.linalg.norm((here - self._before)[[0, 2]]))
        self._before = here
        self._samples += 1
        gone_m = round(self._gone_m, 4)
        return [
            Result(
                "sample", self._samples, "", frame.time_s, distance_m=gone_m,
                position_m=numbers(here),
            )
        ]  # fmt: skip

    def finish(self, time_s: float) -> Sequence[Result]:
        del time_s
        return [Result("trial", 1, "", 0.0, score=round(self._gone_m, 4))]
