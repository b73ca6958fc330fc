"""Patterns of few bilinear reads that blur as a disc does: no OpenGL. All radii are in pixels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.optics import sampling


class Spread(NamedTuple):
    """How far a pattern is spread for a disc of some radius (:func:`extent_px`)."""

    far_px2: float
    near_px2: float
    per_px: float
    near_px: float


def tap_offsets(taps: int) -> Array:
    """Return (taps, 2) points of the unit disc, evenly spread, with its mean and second moments.

    Notes
    -----
    Up to nine: one in the middle of a ring, at which the mean square distance is the disc's, 1/2.
    From there on the sunflower of `optics.sampling.sunflower`.
    """
    if taps > 9:
        return sampling.sunflower(taps)
    angle = 2 * np.pi * np.arange(taps - 1) / (taps - 1)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * math.sqrt(taps / (taps - 1) / 2)
    return np.concatenate([np.zeros((1, 2)), ring])


def read_variance_px2(texel_px: int, shown_px: int) -> float:
    """Return the variance along an axis that bilinear reads add to the pattern of their taps.

    Parameters
    ----------
    texel_px
        Width of the texels that are read: means of so many pixels, (texel² − 1)/12, read between
        them, texel²/6 on average.
    shown_px
        Width of the texels that are drawn; where above 1, these are read between again.
    """
    return _own_variance_px2(texel_px, shown_px) + texel_px**2 / 6


def spread(taps: int, texel_px: int, shown_px: int) -> Spread:
    """Return how `taps` reads of texels so wide are spread, drawn into texels of `shown_px`.

    Notes
    -----
    A disc has the variance r²/4 along an axis, the pattern that of its taps, extent²/4, and that of
    its reads. Far from its texel's middle a read adds texel²/6 on average. A read that starts at
    the middle (texels as wide as those drawn) and goes less than a texel away, a part a, has the
    variance a·texel² in all: the extent grows with r², and nothing is blurred too much. The larger
    of both extents is taken, this one up to where they meet or are closest.
    """
    far = 4 * read_variance_px2(texel_px, shown_px)
    if texel_px != shown_px:
        return Spread(far, far, 0.0, 0.0)
    mean = float(np.mean(np.abs(tap_offsets(taps))))
    meet = 2 * mean - math.sqrt(max(4 * mean**2 - 2 / 3, 0.0))
    near = 4 * _own_variance_px2(texel_px, shown_px)
    return Spread(far, near, 1 / (4 * mean * texel_px), meet * texel_px)


def _own_variance_px2(texel_px: int, shown_px: int) -> float:
    """Return the variance of texels read at their middles, and read between when they are shown."""
    again = shown_px**2 / 6 if shown_px > 1 else 0.0
    return (texel_px**2 - 1) / 12 + again
