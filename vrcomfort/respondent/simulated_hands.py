"""How simulated participants do tasks: they see what is wanted, point at it, and press."""

from __future__ import annotations

import math

import numpy as np

from vrcomfort.geometry import Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.protocol import Simulation
from vrcomfort.tasks import Demand

_HAND_M = (0.15, -0.3, -0.25)
"""Where the right hand is held, in the head's frame."""
_AGAIN = 0.5
"""Share of a reaction time after which a miss is mended."""


class SimulatedHands:
    """The hands of one simulated participant in one exposure.

    Reaction times are log-normal; where they point is spread alike along two axes (and, as with
    people, not where they look).
    """

    def __init__(self, settings: Simulation, condition: str, random: np.random.Generator) -> None:
        self._settings = settings
        self._worse = settings.task_effects.get(condition, 1.0)
        self._random = random
        self._since_s: float | None = None
        self._due_s = math.inf

    def act(self, demand: Demand | None, head: Pose, time_s: float) -> Pose | None:
        """Return world-from-ray of a press in this frame, if there is one."""
        if demand is None or not demand.press:
            self._since_s = None
            return None
        if demand.since_s != self._since_s:
            self._since_s = demand.since_s
            self._due_s = time_s + self._reaction_s()
        if time_s < self._due_s:
            return None
        self._due_s = time_s + _AGAIN * self._reaction_s()
        hand = head.position + head.rotation @ np.array(_HAND_M)
        right, up = np.radians(self._settings.aim_sd_deg * self._worse) * (
            self._random.standard_normal(2)
        )
        aim = Pose(hand, turn_to(normalize(demand.position_m - hand)))
        return aim @ Pose(orientation=yaw_pitch_roll(-right, up, 0.0))

    def _reaction_s(self) -> float:
        settings = self._settings
        spread = math.exp(settings.reaction_sigma * self._random.standard_normal())
        return settings.reaction_s * self._worse * spread
