"""The boxes of what moves, from frame to frame: everything else keeps its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.render import culling
from vrcomfort.render.draw_list import DrawList


class MovingRows:
    """Some rows of a scene.

    Parameters
    ----------
    moving
        (rows of `table`,) which ones; all rows of a node, or none.

    Attributes
    ----------
    rows
        They, in the table.
    with_levels
        Those of them that are not for every distance.
    """

    def __init__(self, table: DrawList, moving: NDArray[np.bool_]) -> None:
        self.rows = np.flatnonzero(moving)
        self._node = table.node[self.rows]
        self._centers, self._halves = table.centers[self.rows], table.halves[self.rows]
        # Rows of a node stand together; those of its finest level say where it is.
        self._finest = np.flatnonzero(table.base_level[self.rows])
        nodes = self._node[self._finest]
        self._first = np.flatnonzero(np.diff(nodes, prepend=-1))
        located = np.isin(self._node, nodes) & table.has_levels[self.rows]
        self.with_levels = self.rows[located]
        self._group = np.searchsorted(nodes[self._first], self._node[located])

    def boxes(self, world_from_node: Array) -> tuple[Array, Array]:
        """Return (rows, 3) centres and half extents of the world-space boxes."""
        return culling.transformed_boxes(world_from_node[self._node], self._centers, self._halves)

    def level_centers(self, centers: Array, halves: Array) -> Array:
        """Return (rows with levels, 3): where from the distance counts that decides a level."""
        if not len(self.with_levels):
            return np.zeros((0, 3))
        center, half = centers[self._finest], halves[self._finest]
        lower = np.minimum.reduceat(center - half, self._first)
        upper = np.maximum.reduceat(center + half, self._first)
        return np.asarray(((lower + upper) / 2)[self._group])
