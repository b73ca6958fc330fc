"""How the discs of each tile of an image may reach others, and the kinds of work that follow.

NumPy twins of ``shaders/include/tile_reach.glsl``, ``defocus_reach.frag``, ``blur_kinds.frag``,
``far_kinds.frag``, ``tap_reach.frag`` and ``tap_around.frag``. Ranges are (rows, columns, 2): least
and greatest signed radius of each tile, in pixels of image width, negative in front of the focus.
"""

from __future__ import annotations

from enum import IntFlag
from typing import NamedTuple


class RingKind(IntFlag):
    """How a tile is drawn with rings, and what the tiles around need of it."""

    COPIED = 1
    ALIKE = 2
    SMALL = 4
    WIDE = 8
    LAYERED = 16
    POINTS = 32
    HALVES = 64
    LAYERS = 128


class TapKind(IntFlag):
    """How a tile is drawn with taps."""

    COPIED = 1
    FEW = 2
    FINE = 4
    WIDE = 8
    WIDEST = 16
    MIXED = 32
    APART = 64


class Bounds(NamedTuple):
    """Radii that divide the kinds of tiles where discs have a few taps."""

    slight_px: float
    few_px: float
    wide_px: float
    widest_px: float
    apart_px: float
    fine_reads: bool
    """Whether there is a program for what is alike, and neither few nor wide."""
