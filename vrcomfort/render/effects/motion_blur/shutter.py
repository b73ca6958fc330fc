"""For how long the shutter is open, as shaders have it."""

from __future__ import annotations

from typing import NamedTuple


class Shutter(NamedTuple):
    """Uniforms of ``include/half_velocity.glsl``."""

    shutter_fraction: float
    """Of the frame period, times the scale of the frame's streaks."""
    radius_limit_px: float
