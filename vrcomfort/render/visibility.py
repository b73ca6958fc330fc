"""Whether the blur and the streaks of conditions can be seen, and told apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import atan, degrees
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.protocol import Condition, Protocol
from vrcomfort.render.stimulus_size import StimulusSize

LEAST_PX = 1.0
"""What is smaller cannot be seen on the display: no pixel changes place."""
QUANTILE = 0.9
"""Share of the image that may be below."""

Float32: TypeAlias = NDArray[np.float32]


@dataclass(frozen=True)
class Amount:
    """Circles of confusion (diameter) or streaks (length) of a condition in a scene.

    Parameters
    ----------
    shown_percent
        Of the pixels, those where it is at least one pixel.
    """

    median_px: float
    p90_px: float
    median_arcmin: float
    p90_arcmin: float
    shown_percent: float


@dataclass(frozen=True)
class Seen:
    """What a condition shows in a scene; None where it has no such effect."""

    condition: str
    scene: str
    circles: Amount | None
    streaks: Amount | None

    @property
    def p90_px(self) -> float:
        """Return the larger of the two."""
        return max((each.p90_px for each in (self.circles, self.streaks) if each), default=0.0)


def seen(condition: str, scene: str, size: StimulusSize, focal_px: float) -> Seen:
    """Return the amounts of a condition in a scene, in an image with this focal length."""
    parts = (size.circles_px, size.streaks_px)
    circles, streaks = (None if each is None else _amount(each, focal_px) for each in parts)
    return Seen(condition, scene, circles, streaks)


def _amount(values_px: Float32, focal_px: float) -> Amount:
    median, p90 = (float(each) for each in np.quantile(values_px, (0.5, QUANTILE)))
    return Amount(
        median,
        p90,
        arcmin_of(median, focal_px),
        arcmin_of(p90, focal_px),
        float((values_px >= LEAST_PX).mean() * 100),
    )


def arcmin_of(length_px: float, focal_px: float) -> float:
    """Return the angle of a length in the middle of an image."""
    return degrees(2 * atan(length_px / 2 / focal_px)) * 60


@dataclass(frozen=True)
class Fault:
    """A condition that cannot be seen, or two that cannot be told apart, in some scenes."""

    conditions: tuple[str, ...]
    scenes: tuple[str, ...]
    p90_px: float

    @property
    def message(self) -> str:
        """Return the sentence that tells it, and what to do."""
        where = f"in {' and '.join(self.scenes)}"
        limit = f"nine tenths of the image have less than {max(self.p90_px, 0.01):.2f} px"
        if len(self.conditions) == 1:
            return (
                f"`{self.conditions[0]}` cannot be seen {where}: {limit} of blur or streak; make "
                "it stronger, or name it in [visibility] unseen if that is meant"
            )
        first, second = self.conditions
        return (
            f"`{first}` and `{second}` cannot be told apart {where}: {limit} between them; make "
            f'them differ, or write alike = [["{first}", "{second}"]] under [visibility]'
        )


def faults(protocol: Protocol, sizes: Mapping[str, Mapping[str, StimulusSize]]) -> Iterator[Fault]:
    """Yield what cannot be seen or told apart, and is not meant so.

    Parameters
    ----------
    sizes
        Scene → condition → what it does, in the headset's pixels.
    """
    unseen = {
        each.name: [name for name in sizes if _p90(sizes[name][each.name]) < LEAST_PX]
        for each in protocol.conditions
        if _has_sizes(each) and not _others(each)
    }
    for name, scenes in unseen.items():
        if scenes and name not in protocol.visibility.unseen:
            largest = max(_p90(sizes[scene][name]) for scene in scenes)
            yield Fault((name,), tuple(scenes), largest)
    meant = {frozenset(pair) for pair in protocol.visibility.alike}
    for a, b in combinations(protocol.conditions, 2):
        if frozenset((a.name, b.name)) not in meant and _unmeasured(a) == _unmeasured(b):
            yield from _alike(a, b, sizes, unseen)


def _alike(
    a: Condition,
    b: Condition,
    sizes: Mapping[str, Mapping[str, StimulusSize]],
    unseen: Mapping[str, Sequence[str]],
) -> Iterator[Fault]:
    """Yield two conditions that look alike, but where one of them is nothing but unseen."""
    differences = {
        name: _difference_px(found[a.name], found[b.name])
        for name, found in sizes.items()
        if name not in unseen.get(a.name, ()) and name not in unseen.get(b.name, ())
    }
    scenes = tuple(name for name, each in differences.items() if each < LEAST_PX)
    if scenes:
        yield Fault((a.name, b.name), scenes, max(differences[name] for name in scenes))


def _has_sizes(condition: Condition) -> bool:
    return condition.depth_of_field is not None or condition.motion_blur is not None


def _others(condition: Condition) -> dict[str, Any]:
    """Return what blurs besides, whose strength is not measured here."""
    measured = ("depth_of_field", "motion_blur")
    found: dict[str, Any] = {
        name: each for name, each in condition.effects.items() if name not in measured
    }
    if condition.background_blur is not None:
        found["background_blur"] = condition.background_blur
    return found


def _unmeasured(condition: Condition) -> dict[str, Any]:
    """Return that, and what is centred on the gaze: sizes are those of a gaze straight ahead."""
    centred = condition.centred_on_gaze
    return {**_others(condition), **({"gaze_centre": centred} if centred else {})}


def _p90(size: StimulusSize) -> float:
    parts = [each for each in (size.circles_px, size.streaks_px) if each is not None]
    return max((float(np.quantile(each, QUANTILE)) for each in parts), default=0.0)


def _difference_px(a: StimulusSize, b: StimulusSize) -> float:
    """Return what nine tenths of the pixels differ by less than, of circles or streaks."""
    pairs = ((a.circles_px, b.circles_px), (a.streaks_px, b.streaks_px))
    found = [_apart(one, other) for one, other in pairs]
    return max(
        (float(np.quantile(each, QUANTILE)) for each in found if each is not None), default=0.0
    )


def _apart(a: Float32 | None, b: Float32 | None) -> Float32 | None:
    if a is None or b is None:
        return b if a is None else a
    apart: Float32 = np.abs(a - b)
    return apart


def needlessly_meant(
    protocol: Protocol, sizes: Mapping[str, Mapping[str, StimulusSize]]
) -> Iterator[str]:
    """Yield a sentence for everything that [visibility] excuses and that needs no excuse."""
    for name in protocol.visibility.unseen:
        if all(_p90(found[name]) >= LEAST_PX for found in sizes.values()):
            yield f"`{name}` is in [visibility] unseen, and can be seen"
    for a, b in protocol.visibility.alike:
        if all(_difference_px(found[a], found[b]) >= LEAST_PX for found in sizes.values()):
            yield f"`{a}` and `{b}` are in [visibility] alike, and can be told apart"
