"""The setting to choose for a budget of milliseconds: the closest on the front that fits it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.quality import level_of
from vrcomfort.settings import toml_value
from vrcomfort.tradeoff.methods import EFFECTS, Effect, base_condition, methods
from vrcomfort.tradeoff.results import Key, Point, front, key_of_row, title

BUDGET_MS = 0.9 * 1000 / 90
"""Nine tenths of a 90 Hz period: the rest is the runtime's."""


class Option(NamedTuple):
    """A method with its price and its error over all scenes.

    Parameters
    ----------
    label
        Its quality level, or its name.
    lines
        Lines of a protocol that set it.
    frame_ms
        Of a stereo frame with the effect, in the scene where it takes longest.
    cost
        The same in plain frames.
    rms, flip
        Means over scenes (RMS: quadratic).
    """

    method: str
    label: str
    lines: tuple[str, ...]
    family: str
    frame_ms: float
    cost: float
    rms: float
    flip: float


class Recommendation(NamedTuple):
    """The recommended level of one effect.

    Parameters
    ----------
    key
        Of the first scene's rows.
    plain_ms
        A stereo frame without the effect, in the scene where it takes longest.
    sharp_rms
        Error of no blur.
    others
        Methods that are not on the front.
    front
        Methods of which none is both cheaper and closer, the cheapest first.
    """

    key: Key
    title: str
    budget_ms: float
    plain_ms: float
    sharp_rms: float
    others: tuple[Option, ...]
    front: tuple[Option, ...]

    @property
    def fits(self) -> bool:
        """Return whether anything on the front fits the budget."""
        return self.front[0].frame_ms <= self.budget_ms

    @property
    def chosen(self) -> int:
        """Return the place on the front of the closest that fits; of the cheapest, if none does."""
        fitting = [i for i, each in enumerate(self.front) if each.frame_ms <= self.budget_ms]
        return fitting[-1] if fitting else 0


def recommendations(found: dict[str, Any], budget_ms: float = BUDGET_MS) -> list[Recommendation]:
    """Return one for each effect and lens of a run's results; none where nothing was timed."""
    made: dict[tuple[str, str], dict[str, list[dict[str, Any]]]] = {}
    for row in found["table"]:
        by_method = made.setdefault((row["effect"], row["lens"]), {})
        by_method.setdefault(row["method"], []).append(row)
    plain = _plain_ms(found)
    maybe = [_recommendation(rows, plain, budget_ms) for rows in made.values()]
    return [each for each in maybe if each is not None]


def _plain_ms(found: dict[str, Any]) -> dict[Key, float]:
    """Return the milliseconds of a plain stereo frame, by scene, effect and lens."""
    times: dict[Key, list[float]] = {}
    for each in found["again"]:
        times.setdefault(key_of_row(each), []).append(each["plain_ms"])
    both = 2 / found["scope"]["eyes"]
    return {key: both * float(np.median(values)) for key, values in times.items()}


def _recommendation(
    rows: dict[str, list[dict[str, Any]]], plain: dict[Key, float], budget_ms: float
) -> Recommendation | None:
    scenes = max(len(each) for each in rows.values())
    key = key_of_row(next(iter(rows.values()))[0])
    conditions = {method.name: method.condition for method in methods(_effect(key[1]))}
    options = [
        _option(name, each, conditions[name], plain)
        for name, each in rows.items()
        if name in conditions and len(each) == scenes and _is_priced(each)
    ]
    if not options:
        return None
    points = front([Point(each.method, each.frame_ms, each.rms) for each in options])
    by_name = {each.method: each for each in options}
    on_front = tuple(by_name[point.name] for point in points)
    return Recommendation(
        key,
        title(key).partition(", ")[2],
        budget_ms,
        max(plain[key_of_row(row)] for row in rows["no blur"]),
        _quadratic([row["rms"] for row in rows["no blur"]]),
        tuple(each for each in options if each not in on_front),
        on_front,
    )


def _effect(name: str) -> Effect:
    return next(each for each in EFFECTS if each == name)


def _is_priced(rows: Sequence[dict[str, Any]]) -> bool:
    return all(row["family"] != "none" and row["cost"] and row["rms"] is not None for row in rows)


def _option(
    name: str,
    rows: Sequence[dict[str, Any]],
    condition: Condition,
    plain: dict[Key, float],
) -> Option:
    level = level_of(condition)
    return Option(
        name,
        name if level is None else f"{level} ({name})",
        (f'quality = "{level}"',) if level else _lines(condition, _effect(rows[0]["effect"])),
        rows[0]["family"],
        max(row["cost"] * plain[key_of_row(row)] for row in rows),
        max(row["cost"] for row in rows),
        _quadratic([row["rms"] for row in rows]),
        float(np.mean([row["flip"] for row in rows])),
    )


def _lines(condition: Condition, effect: Effect) -> tuple[str, ...]:
    """Return a condition's settings but for the strength of its blur, as lines of a protocol."""
    base, found = base_condition(effect), []
    if condition.effect_order != base.effect_order:
        found.append(f'effect_order = "{condition.effect_order}"')
    for name in ("depth_of_field", "motion_blur"):
        own, common = getattr(condition, name), getattr(base, name)
        if own is not None:
            usual = common.model_dump()
            changed = {k: v for k, v in own.model_dump().items() if v != usual[k]}
            found += [f"{name}.{key} = {toml_value(value)}" for key, value in changed.items()]
    return tuple(found) or ("# as set by default",)


def _quadratic(values: Sequence[float]) -> float:
    return math.sqrt(float(np.mean(np.square(values))))
