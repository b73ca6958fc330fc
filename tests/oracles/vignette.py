"""A field-of-view restrictor: NumPy twin, in float64, of ``shaders/vignette/vignette.frag``."""

import numpy as np


def angles_rad(fov, size_px, head_from_eye):
    """Return (h, w) angles from the head's forward axis, bottom row first."""
    width, height = size_px
    left, right, up, down = fov.tangents
    x = left + (right - left) * (np.arange(width) + 0.5) / width
    y = down + (up - down) * (np.arange(height) + 0.5) / height
    x, y = np.meshgrid(x, y)
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1) @ head_from_eye.matrix()[:3, :3].T
    return np.arctan2(np.hypot(rays[..., 0], rays[..., 1]), -rays[..., 2])


def cover(angle_rad, clear_deg, feather_deg):
    """Return how much of the image is covered: 0 in the clear field, 1 beyond its border."""
    t = np.clip((angle_rad - np.radians(clear_deg) / 2) / np.radians(feather_deg), 0, 1)
    return t * t * (3 - 2 * t)
