"""How many samples streaks take, and how fast a head goes."""

from __future__ import annotations

from math import atan2, degrees
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Pose

_NARROW_PX, _WIDE_PX = 400, 1000
_DIAL = (
    (2, (1, 3), (1, 3), (1, 3)),
    (4, (1, 5), (1, 5), (1, 5)),
    (8, (3, 3), (3, 3), (3, 3)),
    (16, (1, 11), (5, 3), (5, 5)),
    (32, (5, 5), (5, 5), (7, 7)),
    (64, (7, 7), (7, 7), (9, 9)),
)
"""Up to so many samples: taps and parts of narrow images, of others, and of wide ones."""
_CUBIC_ABOVE = 16

_MOST_PAIRS = 7
"""Reads to each side of a pixel, in one step."""
_ONE_STEP_SPACING_PX = {False: 2.5, True: 1.9}
"""Between the reads of one step along a frame's longest streak, without and with cubic reads: a
wider spacing makes steps in a moving edge, and two steps soften cubic reads less."""


class Sampling(NamedTuple):
    """How streaks are averaged.

    In one step a pixel is the mean of itself and `pairs` reads to each side, which lie so that they
    leave nothing out. In two it is the mean of `parts` means of `taps` reads: `taps` · `parts`
    samples for `taps` + `parts` reads. Two are taken in frames with a half streak longer than
    `one_step_px`; with one tap, `parts` reads that share the streak evenly.
    """

    taps: int
    parts: int
    cubic: bool
    """Whether each read is sharper across the streak: three reads in place of one."""
    stride_px: int
    """Between samples that look for what is in front: 1 or 3."""
    most_taps: int
    """Of these, to each side."""
    jump: float
    """Things pass each other where half velocities differ by this part of the shorter one."""

    @property
    def pairs(self) -> int:
        """Return the reads to each side in one step: no more in all than two steps take."""
        reads = self.taps + self.parts if self.taps > 1 else self.parts
        return min(reads // 2, _MOST_PAIRS)

    @property
    def one_step_px(self) -> float:
        """Return the longest half streak of a frame that is averaged in one step."""
        return _ONE_STEP_SPACING_PX[self.cubic] * (self.pairs + 0.5)


def sampling_of(samples: int, width_px: int) -> Sampling:
    """Return how streaks are averaged with ``MotionBlur.samples`` in an image of this width."""
    by_width = next(rest for most, *rest in _DIAL if samples <= most)
    taps, parts = by_width[(width_px > _NARROW_PX) + (width_px > _WIDE_PX)]
    stride_px, most_taps, jump = (3, 32, 0.2) if samples <= 8 else (1, 64, 0.1)
    return Sampling(taps, parts, samples > _CUBIC_ABOVE, stride_px, most_taps, jump)


def turn_deg_s(before: Pose, now: Pose, /, *, seconds: float) -> float:
    """Return how fast a frame turns, in degrees per second; 0 where no time has passed."""
    *xyz, w = (before.inverse() @ now).orientation
    half_turn_rad = atan2(float(np.linalg.norm(xyz)), abs(float(w)))
    return degrees(2 * half_turn_rad) / seconds if seconds > 0 else 0.0


def speed_m_s(before: Pose, now: Pose, /, *, seconds: float) -> float:
    """Return how fast a frame's origin moves, in metres per second; 0 where no time has passed."""
    moved_m = float(np.linalg.norm(now.position - before.position))
    return moved_m / seconds if seconds > 0 else 0.0


def ramp(value: float, /, start: float, end: float) -> float:
    """Return 0 up to `start`, 1 from `end` on, and what is linear between."""
    return min(max((value - start) / (end - start), 0.0), 1.0)
