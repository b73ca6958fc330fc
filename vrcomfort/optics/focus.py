"""Where the eye focuses: nine rays ahead or around the line of sight.

Sources: Carnegie & Rhee 2015, p. 36; Mantiuk et al. 2011, section 4. What their print leaves open
is named at each function.
"""

from __future__ import annotations

import numpy as np

from vrcomfort.geometry import Array, Pose, normalize, rotate

RAYS = 9


def ray_tangents(ring_deg: float) -> Array:
    """Return (9, 2) tangents (right, up) of the rays: the centre, then eight from the right.

    The ring runs to the left over the top, in steps of 45°. Each of its rays is `ring_deg` from
    the centre; the paper says "small regular angular deviations" and leaves the angle open.
    """
    around = np.arange(RAYS - 1) * (np.pi / 4)
    ring = np.tan(np.radians(ring_deg)) * np.stack([np.cos(around), np.sin(around)], axis=1)
    return np.concatenate([np.zeros((1, 2)), ring])


GAZE_RING = 0.745
"""Where the eight outer rays around a line of sight lie, in radii of its neighbourhood: each of the
nine then stands for a ninth of its area."""

WIDEST_GAZE = np.sin(np.radians(5.0))
"""Least cosine between a ray and the head's forward axis: nobody looks beyond 85° from it."""


def gaze_tangents(head_from_gaze: Pose, radius_deg: float) -> Array | None:
    """Return (9, 2) tangents (right, up), in the head's frame, of rays around a line of sight.

    Parameters
    ----------
    head_from_gaze
        −Z along the line of sight; its place counts as the head centre.
    radius_deg
        Of the neighbourhood that stands for the error of the eye tracker.

    Returns
    -------
    None where a ray is further than 85° from the head's forward axis: no eye looks there.
    """
    reach = np.tan(np.radians(GAZE_RING * radius_deg))
    around = np.arange(RAYS - 1) * (np.pi / 4)
    in_gaze = np.full((RAYS, 3), -1.0)
    in_gaze[0, :2] = 0.0
    in_gaze[1:, :2] = reach * np.stack([np.cos(around), np.sin(around)], axis=1)
    rays = normalize(rotate(head_from_gaze.orientation, in_gaze))
    if rays[:, 2].max() > -WIDEST_GAZE:
        return None
    tangents: Array = rays[:, :2] / -rays[:, 2:]
    return tangents
