"""How good recorded gaze is: accuracy and precision.

Sources: Holmqvist, Nyström & Mulvey (2012), "Eye tracker data quality: what it is and how to
measure it", ETRA; Niehorster et al. (2020), Behavior Research Methods 52, for both precisions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Array, normalize


class GazeQuality(NamedTuple):
    """Of samples that were to be on one point; degrees, None without samples.

    Parameters
    ----------
    accuracy_deg
        Mean angle between gaze and the way to the point.
    precision_rms_deg
        Root mean square of the angles between two samples that follow each other.
    precision_sd_deg
        Root mean square of the angles from the samples' mean direction.
    """

    accuracy_deg: float | None
    precision_rms_deg: float | None
    precision_sd_deg: float | None


def quality_of(directions: Array, towards: Array) -> GazeQuality:
    """Return the quality of (n, 3) unit directions of gaze, given the (n, 3) unit ways to a point.

    Head and point may move: precision is that of the gaze as turned from the way to the point.
    """
    if not len(directions):
        return GazeQuality(None, None, None)
    accuracy = float(np.mean(angles_deg(directions, towards)))
    off = _as_if_ahead(directions, towards)
    steps = angles_deg(off[1:], off[:-1])
    rms = float(np.sqrt(np.mean(steps**2))) if len(steps) else None
    mean = np.broadcast_to(normalize(off.mean(axis=0)), off.shape)
    return GazeQuality(accuracy, rms, float(np.sqrt(np.mean(angles_deg(off, mean) ** 2))))


def angles_deg(a: Array, b: Array) -> Array:
    """Return (n,) angles between (n, 3) unit vectors; exact for small ones, too."""
    across = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.asarray(np.degrees(np.arctan2(across, (a * b).sum(axis=-1))))


def _as_if_ahead(directions: Array, towards: Array) -> Array:
    """Return the directions in frames that look along −Z to the point, upright in the stage."""
    back = -towards
    right = normalize(np.cross(np.array([0.0, 1.0, 0.0]), back))
    up = np.cross(back, right)
    return np.stack([(directions * axis).sum(axis=-1) for axis in (right, up, back)], axis=-1)
