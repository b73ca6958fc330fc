"""Opponents: balls that move, hide and shoot back, as in the death match of Hillaire et al. 2008.

Its measures are the paper's Table 2: frags (opponents defeated), deaths, shots and precision.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from vrcomfort.geometry import Array, Pose
from vrcomfort.tasks.aiming import PlaceDraw, Targets, meets
from vrcomfort.tasks.base import Ball, Demand, Result, Surroundings, Task, TaskFrame, numbers

Period = Annotated[float, Field(ge=0.1, le=3600)]
Range = tuple[Period, Period]
Hits = Annotated[int, Field(ge=1, le=1000)]

_OPPONENT, _HURT, _FLASH = (0.9, 0.12, 0.05), (0.9, 0.55, 0.4), (1.0, 0.9, 0.4)
_FLASH_S = 0.08
_FLASH_SHARE = 0.3
"""Radius of the flash of a shot, of the opponent's."""


class Opponents(Targets):
    """Fight opponents that move, hide and shoot back: frags, deaths, shots, precision."""

    kind: Literal["opponents"]
    """The kind of task."""
    opponents: Annotated[int, Field(ge=1, le=8)] = 1
    """How many there are at a time."""
    life_hits: Hits = 5
    """Hits that defeat an opponent; another takes its place after `hidden_s`."""
    shown_s: Range = (2.0, 5.0)
    """Shortest and longest time for which an opponent is seen before it hides, evenly drawn."""
    hidden_s: Range = (1.0, 3.0)
    """The same of the time until it comes again, elsewhere, with the life that it had left. All
    are there at the beginning."""
    sway_deg: Annotated[float, Field(ge=0, le=45)] = 4.0
    """An opponent moves this far to either side of its place, seen from where it appeared to."""
    sway_s: Period = 2.0
    """From one side to the other and back."""
    shot_every_s: Period = 0.2
    """From one shot of the participant to the next, while the trigger is held or pressed again."""
    aims_s: Period = 1.0
    """From the appearance of an opponent to its first shot."""
    shoots_every_s: Period = 0.5
    """From one shot of an opponent to the next."""
    hit_chance: Annotated[float, Field(ge=0, le=1)] = 0.3
    """Chance that a shot of an opponent hits; 0: they do not hit."""
    own_life_hits: Hits = 10
    """Hits that the participant stands; one more life begins with each death."""
    away_s: Period = 3.0
    """After a death: time without opponents."""

    @field_validator("shown_s", "hidden_s")
    @classmethod
    def _shorter_first(cls, value: Range, info: ValidationInfo) -> Range:
        if value[0] > value[1]:
            message = "`{name}` names the shorter time first"
            raise PydanticCustomError("opponents", message, {"name": str(info.field_name)})
        return value

    def start(self, surroundings: Surroundings) -> Task:
        """Return the task at the beginning of an exposure."""
        return _Opponents(self, surroundings)


@dataclass
class _Opponent:
    """One opponent: in view from `since_s` to `until_s`, or hidden until `since_s`.

    Parameters
    ----------
    number
        Of the target, from 1; 0 before the first.
    place_m, aside_m
        (3,) world: the middle of its way, and from there to its end.
    hits_s
        When its next shot hits the participant; infinite where it hides before.
    """

    since_s: float
    life: int
    until_s: float = math.inf
    number: int = 0
    seen: bool = False
    place_m: Array = field(default_factory=partial(np.zeros, 3))
    aside_m: Array = field(default_factory=partial(np.zeros, 3))
    radius_m: float = 0.0
    phase: float = 0.0
    hits_s: float = math.inf


class _Opponents(Task):
    def __init__(self, settings: Opponents, surroundings: Surroundings) -> None:
        self.looks = (_OPPONENT, _HURT, _FLASH) * settings.opponents
        self._settings, self._random = settings, surroundings.random
        self._places = PlaceDraw(settings, surroundings)
        self._life = settings.own_life_hits
        self._opponents = [_Opponent(0.0, settings.life_hits) for _ in range(settings.opponents)]
        self._met = self._frags = self._deaths = self._shots = 0
        self._ready_s = self._time_s = 0.0

    def _between(self, ends: Range) -> float:
        return float(self._random.uniform(*ends))

    def next_s(self) -> float:
        return min(
            min(each.until_s, each.hits_s) if each.seen else each.since_s
            for each in self._opponents
        )

    def step(self, frame: TaskFrame) -> Sequence[Result]:
        self._time_s = time_s = frame.time_s
        results = self._shot(frame)
        for each in self._opponents:
            if each.seen and time_s >= each.hits_s:
                results += self._hit_by(each)
        for each in self._opponents:
            if each.seen and time_s >= each.until_s:
                results.append(self._hide(each))
            elif not each.seen and time_s >= each.since_s:
                self._appear(each, frame.head)
        return results

    def balls(self) -> Sequence[Ball | None]:
        return [ball for each in self._opponents for ball in self._drawn(each)]

    def _drawn(self, each: _Opponent) -> tuple[Ball | None, Ball | None, Ball | None]:
        """Return an opponent whole, an opponent that has been hit, and the flash of its shot."""
        if not each.seen:
            return None, None, None
        ball = Ball(self._place_at(each, self._time_s), each.radius_m)
        hurt = each.life < self._settings.life_hits
        since_s = self._time_s - each.since_s - self._settings.aims_s
        shoots = since_s >= 0 and since_s % self._settings.shoots_every_s < _FLASH_S
        above = ball.position_m + np.array([0.0, each.radius_m, 0.0])
        flash = Ball(above, _FLASH_SHARE * each.radius_m) if shoots else None
        return (None, ball, flash) if hurt else (ball, None, flash)

    def demand(self) -> Demand | None:
        seen = [each for each in self._opponents if each.seen]
        if not seen:
            return None
        first = min(seen, key=lambda each: each.since_s)
        return Demand(
            self._place_at(first, self._time_s),
            first.since_s,
            press=True,
            place_at=partial(self._place_at, first),
            every_s=self._settings.shot_every_s,
        )

    def finish(self, time_s: float) -> Sequence[Result]:
        self._time_s = time_s
        results = [self._hide(each) for each in self._opponents if each.seen]
        whole = Result(
            "trial", 1, "", 0.0, targets=self._met, hits=self._frags, shots=self._shots,
            score=float(self._frags), deaths=self._deaths,
        )  # fmt: skip
        return [*results, whole]

    def _place_at(self, each: _Opponent, time_s: float) -> Array:
        turn = 2 * math.pi * (time_s - each.since_s) / self._settings.sway_s + each.phase
        return np.asarray(each.place_m + math.sin(turn) * each.aside_m)

    def _appear(self, each: _Opponent, head: Pose) -> None:
        settings = self._settings
        self._met += 1
        each.number, each.seen, each.since_s = self._met, True, self._time_s
        each.until_s = self._time_s + self._between(settings.shown_s)
        each.place_m = self._places.next(head)
        each.radius_m = settings.radius_m(each.place_m, head)
        away = each.place_m - head.position
        to_right = np.array([-away[2], 0.0, away[0]])
        each.aside_m = to_right * math.tan(math.radians(settings.sway_deg))
        each.phase = float(self._random.uniform(0.0, 2 * math.pi))
        each.hits_s = self._next_hit_s(each, self._time_s + settings.aims_s)

    def _next_hit_s(self, each: _Opponent, first_s: float) -> float:
        """Draw which of the shots from `first_s` on hits."""
        chance = self._settings.hit_chance
        if not chance:
            return math.inf
        misses = int(self._random.geometric(chance)) - 1
        hits_s = first_s + misses * self._settings.shoots_every_s
        return hits_s if hits_s < each.until_s else math.inf

    def _hit_by(self, each: _Opponent) -> list[Result]:
        """Take a hit; the last one is a death, after which all opponents are away for a time."""
        settings = self._settings
        each.hits_s = self._next_hit_s(each, each.hits_s + settings.shoots_every_s)
        self._life -= 1
        if self._life:
            return []
        self._deaths += 1
        self._life = settings.own_life_hits
        results = [self._hide(other) for other in self._opponents if other.seen]
        for other in self._opponents:
            other.since_s = max(other.since_s, self._time_s + settings.away_s)
        return results

    def _hide(self, each: _Opponent, *, defeated: bool = False) -> Result:
        """End the sight of an opponent; one that is defeated makes room for another."""
        place, since_s = self._place_at(each, self._time_s), each.since_s
        each.seen, each.hits_s, each.until_s = False, math.inf, math.inf
        each.since_s = self._time_s + self._between(self._settings.hidden_s)
        if defeated:
            self._frags += 1
            each.life = self._settings.life_hits
        return Result(
            "target",
            each.number,
            f"opponent_{each.number}",
            since_s,
            reaction_s=round(self._time_s - since_s, 6) if defeated else None,
            hit=int(defeated),
            position_m=numbers(place),
        )

    def _shot(self, frame: TaskFrame) -> list[Result]:
        settings = self._settings
        rays = settings.rays(frame) or settings.rays(frame, held=True)
        if not rays or frame.time_s < self._ready_s:
            return []
        self._ready_s = frame.time_s + settings.shot_every_s
        self._shots += 1
        nearest = self._nearest(rays[0], frame.time_s)
        if nearest is None:
            return [Result("shot", self._shots, "", frame.time_s, hit=0)]
        error, hit, each = nearest
        ball_m = self._place_at(each, frame.time_s)
        shot = Result(
            "shot", self._shots, f"opponent_{each.number}", frame.time_s, hit=int(hit),
            error_deg=round(error, 4),
            distance_m=round(float(np.linalg.norm(ball_m - rays[0].position)), 4),
        )  # fmt: skip
        each.life -= hit
        return [shot] if each.life else [shot, self._hide(each, defeated=True)]

    def _nearest(self, ray: Pose, time_s: float) -> tuple[float, bool, _Opponent] | None:
        """Return the error, whether it hits, and the opponent that a ray is the closest to."""
        found = []
        for each in self._opponents:
            if each.seen:
                hit, error = meets(ray, Ball(self._place_at(each, time_s), each.radius_m))
                found.append((error, hit, each))
        return min(found, key=lambda each: each[0], default=None)
