"""Twin of ``depth_of_field/seen_depth_rows.frag`` and ``seen_depth_columns.frag``."""

from __future__ import annotations

import math

import numpy as np


def seen_depth(depth, radius_px, max_radius_px, taps, pixel_aspect=1.0):
    """Return (height, width) depth of what is seen.

    `radius_px`: signed, negative in front of the focus; `max_radius_px`: the largest there can be.
    """
    rows, reach = np.zeros(depth.shape), np.zeros(depth.shape)
    for offset in offsets(max_radius_px, taps):
        z, radius = moved(depth, offset, 1), moved(-radius_px, offset, 1)
        taken = (z > rows) & ((radius >= abs(offset)) | (offset == 0))
        rows, reach = np.where(taken, z, rows), np.where(taken, np.maximum(radius, 0), reach)
    seen = np.zeros(depth.shape)
    for offset in offsets(max_radius_px * pixel_aspect, taps):
        z, radius = moved(rows, offset, 0), moved(reach, offset, 0)
        taken = (radius * pixel_aspect >= abs(offset)) | (offset == 0)
        seen = np.where(taken, np.maximum(seen, z), seen)
    return seen


def offsets(max_radius_px, taps):
    step = max(1, -(-math.ceil(max_radius_px) // taps))
    return range(-taps * step, taps * step + 1, step)


def moved(image, offset, axis):
    """Return what stands `offset` pixels further; 0 beyond the border."""
    index = np.arange(image.shape[axis]) + offset
    inside = (index >= 0) & (index < image.shape[axis])
    taken = np.take(image, np.clip(index, 0, image.shape[axis] - 1), axis)
    return np.where(np.expand_dims(inside, 1 - axis), taken, 0.0)
