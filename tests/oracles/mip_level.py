"""The image at one MIP level: NumPy twin, in float64, of ``shaders/common/mip_level.frag``."""

import numpy as np

from tests.oracles.pyramid import magnified, mean_level


def at_level(image, level):
    """Return (h, w, 3) colours of a level, cross-faded between the two whole ones around it."""
    below = int(np.floor(level))
    share = level - below
    return (1 - share) * _whole(image, below) + share * _whole(image, below + 1)


def _whole(image, level):
    return image if level == 0 else magnified(mean_level(image, level), level, image.shape[:2])
