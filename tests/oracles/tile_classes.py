"""How the discs of each tile of an image may reach others, and the classes of tiles that follow.

NumPy twins of ``shaders/include/tile_dilate.glsl``, ``coc_tile_dilate.frag``,
``classify_ring_tiles.frag``, ``classify_coarse_tiles.frag``, ``classify_tap_tiles.frag`` and
``dilate_tile_classes.frag``. Ranges are (rows, columns, 2): least and greatest signed radius of
each tile, in pixels of image width, negative in front of the focus.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tests.oracles import gather
from vrcomfort.geometry import Array
from vrcomfort.optics.tile_classes import RingTile, TapBounds, TapTile

TileClasses: TypeAlias = NDArray[np.int_]


MOST_SPREAD = 0.5
"""Part of the widest radius by which those of one surface may differ, with a few taps."""


LEAST_WIDE_PX = 1.75
"""What is drawn at half resolution is as blurred as a disc of this radius, at least."""


class Grid(NamedTuple):
    """How tiles lie in an image."""

    tile_px: int
    pixel_aspect: float = 1.0
    """Image pixels per unit, vertical / horizontal."""
    margin_px: float = 0.0
    """How much farther than discs reach others may need something."""

    def reach_px(self, ranges: Array) -> Array:
        """Return the (rows, columns) pixels that discs of these ranges go, at most."""
        tall = max(self.pixel_aspect, 1.0)
        reach: Array = tall * np.abs(ranges).max(axis=-1) + 1 + self.margin_px
        return reach

    def comes(self, away: int, ranges: Array) -> NDArray[np.bool_]:
        """Return, as (rows, columns), whether the discs of tiles come so many tiles far."""
        comes: NDArray[np.bool_] = (away - 1) * self.tile_px <= self.reach_px(ranges)
        return comes


def may_reach(ranges: Array, grid: Grid) -> Array:
    """Return (rows, columns, 2), the range over all tiles that may matter in each.

    Those whose discs come as far, and those that the tile's own discs reach.
    """
    found = np.stack([np.full(ranges.shape[:2], np.inf), np.full(ranges.shape[:2], -np.inf)], -1)
    for away, there in _around(ranges, grid):
        matters = grid.comes(away, ranges) | grid.comes(away, there)
        least = np.minimum(found[..., 0], there[..., 0])
        greatest = np.maximum(found[..., 1], there[..., 1])
        found = np.where(matters[..., None], np.stack([least, greatest], axis=-1), found)
    return found


def ring_tile_classes(reach: Array, grid: Grid, *, small_px: float) -> TileClasses:
    """Return (rows, columns) sums of `RingTile`.

    Parameters
    ----------
    reach
        Of :func:`may_reach`.
    small_px
        Wider discs are drawn at half resolution, which is read beyond discs by the grid's margin.
    """

    def needs(away: int, there: Array) -> TileClasses:
        drawn = _drawn_with_rings(there, small_px)
        halved = np.isin(drawn, (RingTile.WIDE, RingTile.LAYERED))
        points = np.where(drawn == RingTile.SHARP, 0, RingTile.COLOUR_AND_COC)
        read = grid.comes(away, there)
        found: TileClasses = np.where(
            read, points | np.where(halved, RingTile.HALF_RESOLUTION, 0), 0
        )
        return found | np.where(halved, RingTile.LAYERS, 0) if away <= 1 else found

    own = _drawn_with_rings(reach, small_px)
    return own | _all_around(reach, grid, needs)


def coarse_tile_classes(reach: Array, grid: Grid, *, far_px: float) -> TileClasses:
    """Return (rows, columns) sums of `RingTile`: where wider texels and layers of them are drawn.

    Parameters
    ----------
    reach
        Of :func:`may_reach`.
    far_px
        Wider discs are drawn on them, which are read beyond discs by the grid's margin.
    """

    def needs(away: int, there: Array) -> TileClasses:
        wide = np.abs(there).max(axis=-1) > far_px
        found: TileClasses = np.where(wide & grid.comes(away, there), RingTile.HALF_RESOLUTION, 0)
        return found | np.where(wide, RingTile.LAYERS, 0) if away <= 1 else found

    return _all_around(reach, grid, needs)


def tap_tile_classes(reach: Array, bounds: TapBounds) -> TileClasses:
    """Return (rows, columns), the `TapTile` of each tile, for the ranges of :func:`may_reach`."""
    least_signed, greatest_signed = reach[..., 0], reach[..., 1]
    sizes = np.abs(reach)
    widest, least = sizes.max(axis=-1), sizes.min(axis=-1)
    apart = greatest_signed - least_signed > MOST_SPREAD * widest
    alike = ~apart & (np.maximum(least_signed, -greatest_signed) > 0.5)
    mixed = np.where(widest > bounds.apart_px, TapTile.APART, TapTile.MIXED)
    wide = (least > LEAST_WIDE_PX) & (least + widest > 2 * bounds.wide_px)
    classes: TileClasses = np.select(
        [widest <= 0.5, widest <= bounds.slight_px, ~alike, wide, widest <= bounds.few_px],
        [
            TapTile.SHARP,
            TapTile.FEW,
            mixed,
            np.where(widest > bounds.widest_px, TapTile.WIDEST, TapTile.WIDE),
            TapTile.FEW,
        ],
        TapTile.FINE if bounds.fine_reads else mixed,
    )
    return classes


def dilated_tile_classes(reach: Array, classes: TileClasses, grid: Grid) -> TileClasses:
    """Return (rows, columns), the sums of classes of all tiles that read from each."""
    ranges_and_classes = np.concatenate([reach, classes[..., None]], axis=-1)

    def reads(away: int, there: Array) -> TileClasses:
        comes = grid.comes(away, there[..., :2])
        return np.where(comes, there[..., 2].astype(int), 0)

    return _all_around(ranges_and_classes, grid, reads)


def _drawn_with_rings(reach: Array, small_px: float) -> TileClasses:
    widest = np.abs(reach).max(axis=-1)
    least = np.maximum(np.maximum(reach[..., 0], -reach[..., 1]), 0.0)
    alike = gather.is_alike(least, reach[..., 0], reach[..., 1], 1.0)
    wide = np.where(alike & (least > small_px), RingTile.WIDE, RingTile.LAYERED)
    small = np.where(alike, RingTile.ALIKE, RingTile.SMALL)
    classes: TileClasses = np.select(
        [widest <= 0.5, widest > small_px], [RingTile.SHARP, wide], small
    )
    return classes


def _all_around(
    tiles: Array, grid: Grid, found_in: Callable[[int, Array], TileClasses]
) -> TileClasses:
    """Return the bits that are found in any tile around, so many tiles away."""
    found = np.zeros(tiles.shape[:2], dtype=int)
    for away, there in _around(tiles, grid):
        found |= found_in(away, there)
    return found


def _around(tiles: Array, grid: Grid) -> Iterator[tuple[int, Array]]:
    """Yield how many tiles away, and the tiles there; beyond the edge those of the edge."""
    far = int(grid.reach_px(tiles[..., :2]).max() // grid.tile_px) + 1
    rows, columns = tiles.shape[:2]
    for y in range(-far, far + 1):
        for x in range(-far, far + 1):
            row = np.clip(np.arange(rows) + y, 0, rows - 1)
            column = np.clip(np.arange(columns) + x, 0, columns - 1)
            yield max(abs(x), abs(y)), tiles[row[:, None], column]
