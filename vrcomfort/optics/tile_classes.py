"""Classes of the tiles of an image out of focus: each class has a program of its own.

Renderers on the CPU run both sides of every branch, so one program for all would cost the most
everywhere. Shaders get the numbers as defines (:func:`defines`).
"""

from __future__ import annotations

from enum import IntFlag
from typing import NamedTuple


class RingTile(IntFlag):
    """How a tile is drawn with rings, and what the tiles around need of it."""

    SHARP = 1
    """Nothing is blurred: it is copied."""
    ALIKE = 2
    """Small discs of one surface."""
    SMALL = 4
    """Small discs of several surfaces."""
    WIDE = 8
    """Wide discs of one surface: they are drawn at half resolution."""
    LAYERED = 16
    """Wide discs and others."""
    COLOUR_AND_COC = 32
    """Needed around: colours and radii."""
    HALF_RESOLUTION = 64
    """Needed around: half of them."""
    LAYERS = 128
    """Needed around: wide discs at half resolution."""


class TapTile(IntFlag):
    """How a tile is drawn with taps."""

    SHARP = 1
    """Nothing is blurred: it is copied."""
    FEW = 2
    """Everything is about alike, or nearly sharp, and so small that few reads do."""
    FINE = 4
    """Alike: bilinear reads of the image."""
    WIDE = 8
    """Wide discs of one surface: they are drawn at half resolution."""
    WIDEST = 16
    """Wide discs from a quarter of the image."""
    MIXED = 32
    """Several surfaces, told apart tap by tap."""
    APART = 64
    """The same, with discs so wide that taps are far apart."""


class TapBounds(NamedTuple):
    """Radii that divide the classes of tiles where discs have a few taps."""

    slight_px: float
    few_px: float
    wide_px: float
    widest_px: float
    apart_px: float
    fine_reads: bool
    """Whether there is a program for what is alike, and neither few nor wide."""


def defines(classes: type[RingTile | TapTile]) -> dict[str, int]:
    """Return the classes as defines of a shader."""
    return {each.name or "": each.value for each in classes}
