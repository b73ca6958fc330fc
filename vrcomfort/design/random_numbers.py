"""Random numbers that derive from the study's seed and from what they are for."""

from __future__ import annotations

import numpy as np

_DESIGN_STREAM = 1  # first spawn key of every random choice made here


def generator(seed: int, *key: int) -> np.random.Generator:
    """Return the generator of one choice; the same seed and key give the same numbers."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_DESIGN_STREAM, *key)))
