"""How a head got from one frame to the next, and how fast: float64, no OpenGL."""

from __future__ import annotations

from typing import Literal, NamedTuple

from vrcomfort.geometry import Pose
from vrcomfort.optics.motion import ramp, speed_m_s, turn_deg_s
from vrcomfort.protocol.conditions import SpeedRamps


class HeadStep(NamedTuple):
    """The head and the stage in two frames that follow each other.

    `head` is stage-from-head, `avatar` world-from-stage, `seconds` the time between the two
    predicted display times, and `periods` that time in frame periods: more than one where frames
    were dropped.
    """

    head_before: Pose
    head: Pose
    avatar_before: Pose
    avatar: Pose
    seconds: float
    periods: int = 1

    def turn_deg_s(self, of: Literal["head", "avatar", "both"]) -> float:
        """Return the speed of turning of the tracked head, of locomotion, or of their sum."""
        return turn_deg_s(*self._poses(of), seconds=self.seconds)

    def speed_m_s(self, of: Literal["head", "avatar", "both"]) -> float:
        """Return the speed of the head in its room, by locomotion, or in the world."""
        return speed_m_s(*self._poses(of), seconds=self.seconds)

    def _poses(self, of: Literal["head", "avatar", "both"]) -> tuple[Pose, Pose]:
        """Return world-from-head before and now, the other part resting as it is now."""
        head_before = self.head if of == "avatar" else self.head_before
        avatar_before = self.avatar if of == "head" else self.avatar_before
        return avatar_before @ head_before, self.avatar @ self.head


def speed_share(settings: SpeedRamps, step: HeadStep | None) -> float:
    """Return 0 (at rest, or after a cut) to 1 (at full speed), the same for both eyes."""
    if step is None:
        return 0.0
    turning, moving, of = settings.turning, settings.moving, settings.speed_of
    by_turning = turning and ramp(step.turn_deg_s(of), turning.from_deg_s, turning.to_deg_s)
    by_moving = moving and ramp(step.speed_m_s(of), moving.from_m_s, moving.to_m_s)
    return max(by_turning or 0.0, by_moving or 0.0)
