"""A Gaussian blur whose width is an angle (``shaders/speed_blur/gaussian.frag``)."""

from __future__ import annotations

from math import radians, tan


def sigma_px(sigma_arcmin: float, focal_px: float) -> float:
    """Return the standard deviation in pixels, in the middle of an image of this focal length."""
    return focal_px * tan(radians(sigma_arcmin / 60))
