"""The task `nods`."""

from typing import Annotated

from pydantic import Field

from vrcomfort.tasks import Result, Task, TaskSettings


class CountNods(TaskSettings):
    """Count nods: the head goes down by a number of degrees and up again."""

    kind: str
    depth_deg: Annotated[float, Field(ge=1, le=60)] = 10.0

    def start(self, surroundings):
        return _Counting(self.depth_deg)


class _Counting(Task):
    def __init__(self, depth_deg):
        self.depth, self.nods, self.down = depth_deg / 57.3, 0, False

    def step(self, moment):
        pitch = moment.head.forward[1]
        if self.down and pitch > -self.depth / 2:
            self.nods, self.down = self.nods + 1, False
            return [Result("target", self.nods, "nod", moment.time_s, hit=1)]
        self.down = self.down or pitch < -self.depth
        return []

    def finish(self, time_s):
        return [Result("trial", 1, "", 0.0, hits=self.nods, score=float(self.nods))]
