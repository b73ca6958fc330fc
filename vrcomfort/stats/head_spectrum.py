"""Spectra of head motion by Welch's method, of frames of which some were dropped."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.signal import welch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class Spectrum(NamedTuple):
    """One-sided power spectral density.

    Parameters
    ----------
    frequency_hz
        (k,).
    density
        (k,) or (k, columns), in squared units of the signal per Hz.
    windows
        Windows whose mean it is.
    filled
        Share of the samples that no frame gave: interpolated over dropped frames.
    left_out
        Share of the frames in stretches shorter than a window.
    """

    frequency_hz: Floats
    density: Floats
    windows: int
    filled: float
    left_out: float


def head_spectrum(
    time_s: Floats,
    values: Floats,
    cuts: NDArray[np.bool_],
    *,
    period_s: float,
    window_s: float = 4.0,
    longest_gap_periods: float = 4.5,
) -> Spectrum | None:
    """Return the spectrum of a signal that was sampled once a frame.

    Frames come at multiples of the period; where some were dropped, the signal is interpolated
    linearly at the refreshes in between. A longer gap, or a cut, ends a stretch: each stretch has
    windows of its own (Hann, half overlapping, without their means), and the density is the mean
    of all windows.

    Parameters
    ----------
    time_s
        (n,), rising.
    values
        (n,) or (n, columns).
    cuts
        (n,) where a frame has nothing to do with the one before.
    longest_gap_periods
        A longer gap is not filled.

    Returns
    -------
    Spectrum or None
        None where no stretch is as long as a window.
    """
    signal = values if values.ndim == 2 else values[:, None]
    per_window = max(8, round(window_s / period_s))
    apart = cuts[1:] | (np.diff(time_s) > longest_gap_periods * period_s)
    edges = [0, *(np.flatnonzero(apart) + 1).tolist(), len(time_s)]
    total, windows, filled, grid_points, used = 0.0, 0, 0, 0, 0
    frequency: Floats | None = None
    for first, end in pairwise(edges):
        times = time_s[first:end]
        points = round((times[-1] - times[0]) / period_s) + 1 if end > first else 0
        if points < per_window:
            continue
        grid = times[0] + period_s * np.arange(points)
        even = np.column_stack([np.interp(grid, times, each) for each in signal[first:end].T])
        count = (points - per_window) // (per_window - per_window // 2) + 1
        frequency, density = welch(
            even, fs=1 / period_s, nperseg=per_window, noverlap=per_window // 2, axis=0
        )
        total = total + count * density
        windows, grid_points = windows + count, grid_points + points
        filled, used = filled + max(points - (end - first), 0), used + (end - first)
    if frequency is None:
        return None
    mean = np.asarray(total, dtype=np.float64) / windows
    return Spectrum(
        frequency,
        mean if values.ndim == 2 else mean[:, 0],
        windows,
        filled / grid_points,
        1 - used / len(time_s),
    )


def band_power(spectrum: Spectrum, low_hz: float, high_hz: float) -> Floats:
    """Return the power between two frequencies, shape () or (columns,).

    Each density stands for its bin, half a step of frequency to either side; of a bin at the edge
    of the band, the part inside counts. So the powers of bands that meet add up.
    """
    f = spectrum.frequency_hz
    half = (f[1] - f[0]) / 2
    inside = np.clip(np.minimum(f + half, high_hz) - np.maximum(f - half, low_hz), 0, None)
    return np.asarray(inside @ spectrum.density)
