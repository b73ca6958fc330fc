"""From linear light to display values: the NumPy twin of ``shaders/include/tone.glsl``."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array

# Constants of Khronos' PBR Neutral: 0.8 − F90 (0.04), and its desaturation.
COMPRESSION_START = 0.8 - 0.04
DESATURATION = 0.15


def pbr_neutral(color: ArrayLike, /) -> Array:
    """Return (..., 3) linear display colours in [0, 1) of (..., 3) exposed linear colours.

    Base colours lit by neutral light come through unchanged up to 0.8 (less an offset that
    takes out the 4 % reflection of dielectrics); highlights are pressed into [0.8, 1) and fade
    to white. A stimulus keeps its hue and its contrast where it matters.

    Notes
    -----
    Khronos PBR Neutral, https://github.com/KhronosGroup/ToneMapping (2024). Negative colours,
    which no light makes, are not defined.
    """
    color = np.asarray(color, dtype=np.float64)
    # Less 0.04, the reflection of dielectrics at normal incidence, as far as there is that much: a
    # parabola that meets the constant at twice that, with equal slope (6.25 = 1 / (4 · 0.04)).
    least = color.min(axis=-1, keepdims=True)
    color = color - np.where(least < 0.08, least - 6.25 * least**2, 0.04)
    peak = color.max(axis=-1, keepdims=True)
    room = 1 - COMPRESSION_START
    bright = np.maximum(peak, COMPRESSION_START)
    pressed = 1 - room**2 / (bright + room - COMPRESSION_START)
    gray = 1 - 1 / (DESATURATION * (bright - pressed) + 1)
    highlight = color * (pressed / bright) * (1 - gray) + pressed * gray
    return np.where(peak < COMPRESSION_START, color, highlight)


def srgb_encoded(linear: ArrayLike, /) -> Array:
    """Return sRGB-encoded values in [0, 1] of linear ones (clamped to [0, 1]); IEC 61966-2-1."""
    value = np.clip(np.asarray(linear, dtype=np.float64), 0, 1)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)


def tone_mapped(radiance: ArrayLike, /, *, exposure: float) -> Array:
    """Return (..., 3) display values in [0, 1] of linear radiance, as ``tone_map.frag`` does."""
    return srgb_encoded(pbr_neutral(np.asarray(radiance, dtype=np.float64) * exposure))
