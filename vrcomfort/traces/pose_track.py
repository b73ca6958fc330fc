"""Poses over time, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose

Times: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PoseTrack:
    """Poses of one thing at the times of a trace.

    Parameters
    ----------
    positions
        (n, 3) metres.
    orientations
        (n, 4) unit quaternions (x, y, z, w), target-from-source.
    """

    positions: Array
    orientations: Array

    def __getitem__(self, samples: slice | NDArray[np.bool_]) -> PoseTrack:
        """Return a part of the track."""
        return PoseTrack(self.positions[samples], self.orientations[samples])

    def pose(self, index: int) -> Pose:
        """Return one pose."""
        return Pose(self.positions[index], self.orientations[index])

    def cells(self) -> Array:
        """Return (n, 7): positions, then quaternions, as they stand in a file."""
        return np.concatenate([self.positions, self.orientations], axis=1)
