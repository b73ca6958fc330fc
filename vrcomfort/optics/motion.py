"""How many samples streaks take, and how fast a head goes."""

from __future__ import annotations

from math import atan2, degrees

import numpy as np

from vrcomfort.geometry import Pose

STREAK_OF_SAMPLES_PX = 24.0
"""Length of streak that takes ``MotionBlur.samples`` samples."""

MOST_SAMPLES = 16
"""Along that length; more are not closer. Settings above it read across the streak more finely."""


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
