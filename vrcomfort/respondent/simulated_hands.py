"""The hands of simulated participants: tasks, adjustments and sliders."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.protocol import Simulation
from vrcomfort.protocol.adjustments import Adjustment
from vrcomfort.tasks import Demand

_HAND_M = (0.15, -0.3, -0.25)
"""Where the right hand is held, in the head's frame."""
_AGAIN = 0.5
"""Share of a reaction time after which a miss is mended."""


class SimulatedHands:
    """The hands of one simulated participant in one exposure.

    Reaction times are log-normal; where they point is spread alike along two axes (and, as with
    people, not where they look); where a target moves, they follow it late.

    Parameters
    ----------
    skill
        The person's own factor of all three.
    """

    def __init__(
        self, settings: Simulation, condition: str, random: np.random.Generator, skill: float = 1.0
    ) -> None:
        self._settings = settings
        self._worse = settings.task_effects.get(condition, 1.0) * skill
        self._lag_s = settings.aim_lag_s * self._worse
        self._random = random
        self._since_s: float | None = None
        self._due_s = math.inf

    def next_s(self, demand: Demand | None) -> float:
        """Return when the next press comes; at once where the demand has not been seen yet."""
        if demand is None or not demand.press:
            return math.inf
        return self._due_s if demand.since_s == self._since_s else -math.inf

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
        self._due_s = time_s + max(_AGAIN * self._reaction_s(), demand.every_s)
        hand = head.position + head.rotation @ np.array(_HAND_M)
        right, up = np.radians(self._settings.aim_sd_deg * self._worse) * (
            self._random.standard_normal(2)
        )
        place_m = demand.position_m
        if demand.place_at is not None:
            place_m = demand.place_at(max(time_s - self._lag_s, demand.since_s))
        aim = Pose(hand, turn_to(normalize(place_m - hand)))
        return aim @ Pose(orientation=yaw_pitch_roll(-right, up, 0.0))

    def _reaction_s(self) -> float:
        settings = self._settings
        spread = math.exp(settings.reaction_sigma * self._random.standard_normal())
        return settings.reaction_s * self._worse * spread


SETTLING_S = 0.3
"""Time constant with which simulated participants come to the value that they want."""
WORTHWHILE = 0.03
"""Least change of sickness, in parts of the range, after which they move a slider."""
_CLOSE = 0.005
"""So near to it, in parts of the range, they stop turning."""


class Turn(NamedTuple):
    """The input to a dial in one frame.

    Parameters
    ----------
    stick
        -1 to 1: how far the thumb-stick is pushed.
    steps
        So many steps up.
    confirm
        Whether the button goes down.
    """

    stick: float = 0.0
    steps: int = 0
    confirm: bool = False


class SimulatedAdjuster:
    """Turns the dial of one adjustment to the value that a simulated participant wants.

    Parameters
    ----------
    person, exposure
        Random streams: what the person wants is alike in all exposures but for `adjust_noise`.
    """

    def __init__(
        self,
        settings: Simulation,
        adjustment: Adjustment,
        person: np.random.Generator,
        exposure: np.random.Generator,
    ) -> None:
        median = settings.adjusts_to.get(adjustment.name)
        middle = 0.5 if median is None else adjustment.place_of(median)
        off = settings.adjust_sd * person.standard_normal()
        off += settings.adjust_noise * exposure.standard_normal()
        self._goal = float(np.clip(middle + off, 0.0, 1.0))
        spread = np.exp(settings.reaction_sigma * exposure.standard_normal(2))
        self._begins_s, self._looks_s = (settings.reaction_s * spread).tolist()
        self._sweep_s = adjustment.sweep_s
        self._settled_s = math.inf

    def turn(self, place: float, time_s: float) -> Turn:
        """Turn it towards the goal, then look for as long as a reaction takes, and confirm."""
        if time_s < self._begins_s:
            return Turn()
        error = self._goal - place
        if abs(error) > _CLOSE:
            self._settled_s = math.inf
            return Turn(stick=float(np.clip(error * self._sweep_s / SETTLING_S, -1.0, 1.0)))
        self._settled_s = min(self._settled_s, time_s)
        return Turn(confirm=time_s >= self._settled_s + self._looks_s)


class SimulatedSlider:
    """Puts a slider to the present sickness, now and then: not for small changes.

    Parameters
    ----------
    noise
        Standard deviation of where they put it, in parts of the range.
    """

    def __init__(self, noise: float, random: np.random.Generator) -> None:
        self._noise, self._random = noise, random
        self._felt: float | None = None

    def put(self, place: float, felt: float) -> float:
        """Return where the slider is now, both in parts of the range."""
        if self._felt is not None and abs(felt - self._felt) < WORTHWHILE:
            return place
        self._felt = felt
        return float(np.clip(felt + self._noise * self._random.standard_normal(), 0.0, 1.0))
