"""Speed of the head, and the effects that follow it.

Sampling of motion blur, ramps over speed, the vignette's strength and clear field, and the widths
of speed blur and relocation blur.
"""

from __future__ import annotations

import math
from math import atan2, degrees, radians, tan
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Fov, Pose

# Streaks are longer, in pixels, in wider images: they need more reads for the same spacing.
_NARROW_PX, _WIDE_PX = 400, 1000
_READS_BY_SAMPLES = (
    (2, (1, 3), (1, 3), (1, 3)),
    (4, (1, 5), (1, 5), (1, 5)),
    (8, (3, 3), (3, 3), (3, 3)),
    (16, (1, 11), (5, 3), (5, 5)),
    (32, (5, 5), (5, 5), (7, 7)),
    (64, (7, 7), (7, 7), (9, 9)),
)
"""Most samples, then taps and parts of narrow images, of others, and of wide ones: chosen by error
and cost with ``python -m bench.motion_blur`` (docs/motion_blur.md)."""
_HALVES_UP_TO = 8
"""Samples up to which two pixels share an average: more are close enough to each other without, and
would only be softened (``python -m bench.motion_blur``)."""
_CUBIC_ABOVE = 16
"""Samples above which each read is cubic across the streak."""

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
    halves: bool
    """Whether two pixels along a streak share an average, in frames that move along one axis."""
    cubic: bool
    """Whether each read is sharper across the streak: three reads in place of one."""
    stride_px: int
    """Between samples that seek a foreground: 1 or 3."""
    most_taps: int
    """Of these, to each side."""
    jump: float
    """Part of the shorter half velocity: a larger difference is a velocity discontinuity."""

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
    by_width = next(rest for most, *rest in _READS_BY_SAMPLES if samples <= most)
    taps, parts = by_width[(width_px > _NARROW_PX) + (width_px > _WIDE_PX)]
    stride_px, most_taps, jump = (3, 32, 0.2) if samples <= 8 else (1, 64, 0.1)
    halves = taps > 1 and samples <= _HALVES_UP_TO
    return Sampling(taps, parts, halves, samples > _CUBIC_ABOVE, stride_px, most_taps, jump)


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
    """Return 0 up to `start`, 1 from `end` on, linear between."""
    return min(max((value - start) / (end - start), 0.0), 1.0)


def moved_towards(
    strength: float, wanted: float, /, *, elapsed_s: float, attack_s: float, release_s: float
) -> float:
    """Return the strength after some time, which closes and opens at a constant rate.

    Parameters
    ----------
    strength, wanted
        0 (open) to 1 (restricted).
    attack_s, release_s
        Seconds from 0 to 1 and from 1 to 0; 0 is at once. Frames of any length that add up to the
        same time give the same strength, as long as `wanted` is the same in them.
    """
    elapsed_s = max(elapsed_s, 0.0)
    duration_s = attack_s if wanted > strength else release_s
    if elapsed_s >= duration_s * abs(wanted - strength):
        return wanted
    return strength + math.copysign(elapsed_s / duration_s, wanted - strength)


def clear_deg(open_deg: float, restricted_deg: float, strength: float) -> float:
    """Return the diameter of the clear field, which is linear in the strength."""
    return open_deg + (restricted_deg - open_deg) * strength


def widest_angle_deg(fov: Fov, centre_from_eye: Pose) -> float:
    """Return the largest angle from the field's axis in an eye's image: a corner's.

    Parameters
    ----------
    centre_from_eye
        The axis is its −Z. Only its rotation counts: canted displays look past the head's axis.
    """
    left, right, up, down = fov.tangents
    rays = np.array([(x, y, -1.0) for x in (left, right) for y in (up, down)])
    x, y, z = centre_from_eye.matrix()[:3, :3] @ rays.T
    return float(np.degrees(np.arctan2(np.hypot(x, y), -z)).max())


def sigma_px(sigma_arcmin: float, focal_px: float) -> float:
    """Return a Gaussian's standard deviation in pixels, in the middle of an image.

    For ``shaders/speed_blur/gaussian.frag``.
    """
    return focal_px * tan(radians(sigma_arcmin / 60))


def level_after(level: float, /, *, elapsed_s: float, duration_s: float) -> float:
    """Return relocation blur's MIP level some time after a cut: it falls to 0 at a constant rate.

    Parameters
    ----------
    level
        At the cut; a texel of level k is 2^k px wide.
    """
    return level * min(max(1 - elapsed_s / duration_s, 0.0), 1.0)


def halvings(level: float, /) -> int:
    """Return how many halvings of the image a level is made of: the two around it."""
    return math.ceil(level)
