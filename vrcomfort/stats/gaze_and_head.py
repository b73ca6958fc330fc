"""Gaze and head motion: centred zones, fixations, saliency maps, spectra."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.signal import welch

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Where people look: shares of a centred zone, fixations, maps. Directions are unit vectors.
#
# +X is right, +Y up, −Z forward; azimuth is to the right, elevation up, in degrees.


Algorithm = Literal["i_vt", "i_dt"]


class GazeFixation(NamedTuple):
    """A fixation, its length, and the mean direction during it."""

    start_s: float
    duration_s: float
    azimuth_deg: float
    elevation_deg: float
    samples: int


class Map(NamedTuple):
    """Share of the time in each cell, shape (elevations, azimuths), with the cells' middles.

    Azimuths are those from the middle of the map.
    """

    share: Floats
    azimuth_deg: Floats
    elevation_deg: Floats
    outside: float
    """Share of the time in which the gaze was outside of the map."""


def angles_deg(directions: Floats) -> tuple[Floats, Floats]:
    """Return azimuth and elevation of (n, 3) directions."""
    x, y, z = directions.T
    return np.degrees(np.arctan2(x, -z)), np.degrees(np.arctan2(y, np.hypot(x, z)))


def unit_vectors(azimuth_deg: Floats, elevation_deg: Floats) -> Floats:
    """Return the (n, 3) directions of azimuths and elevations."""
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    level = np.cos(elevation)
    return np.column_stack([level * np.sin(azimuth), np.sin(elevation), -level * np.cos(azimuth)])


def zone_ratios(directions: Floats, half_widths: Floats) -> Floats:
    """Return the ratio of the smallest centred zone that the gaze is in, shape (n,).

    Parameters
    ----------
    directions
        (n, 3) in the head's frame.
    half_widths
        (n, 2) tangents of half the image's width and height.

    Notes
    -----
    Hillaire et al. 2008, Figure 6: a zone of ratio r has r times the height and width of the image,
    so r² of its area. 1 is the edge of the image; what lies behind the head is infinitely far out.
    """
    forward = -directions[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        out = np.abs(directions[:, :2]) / forward[:, None] / half_widths
    ratios: Floats = np.where(forward > 0, out.max(axis=1), np.inf)
    return ratios


def zone_shares(ratios: Floats, seconds: Floats, zones: Sequence[float]) -> list[float]:
    """Return the share of the time within each zone; NaN without any time."""
    whole = float(seconds.sum())
    return [float(seconds[ratios <= zone].sum()) / whole if whole else np.nan for zone in zones]


def zone_holding(ratios: Floats, seconds: Floats, share: float) -> float:
    """Return the ratio of the smallest zone that holds at least this share of the time.

    Hillaire et al. 2008 set the size of their autofocus zone so: 0.25 for 75 % of the gaze while
    shooting. NaN without any time, infinite where the gaze was behind the head too often.
    """
    if not ratios.size:
        return np.nan
    order = np.argsort(ratios)
    there = np.cumsum(seconds[order])
    place = int(np.searchsorted(there, share * there[-1] * (1 - 1e-12)))
    return float(ratios[order][place])


def runs(
    time_s: Floats, valid: NDArray[np.bool_], cuts: NDArray[np.bool_], longest_gap_s: float
) -> Iterator[slice]:
    """Yield the stretches in which the gaze is known without a gap or a cut."""
    known = np.flatnonzero(valid)
    if known.size == 0:
        return
    apart = (np.diff(known) > 1) | (np.diff(time_s[known]) > longest_gap_s) | cuts[known[1:]]
    ends = [*(np.flatnonzero(apart) + 1).tolist(), known.size]
    start = 0
    for end in ends:
        yield slice(int(known[start]), int(known[end - 1]) + 1)
        start = end


def fixations(
    time_s: Floats,
    directions: Floats,
    valid: NDArray[np.bool_],
    *,
    cuts: NDArray[np.bool_] | None = None,
    algorithm: Algorithm = "i_vt",
    velocity_deg_s: float = 30.0,
    dispersion_deg: float = 1.0,
    shortest_s: float = 0.1,
    longest_gap_s: float = 0.075,
) -> list[GazeFixation]:
    """Return fixations of a gaze, in the frame of the directions (the world: heads turn).

    Parameters
    ----------
    time_s
        (n,), rising.
    directions
        (n, 3) unit vectors; ignored where not valid.
    cuts
        (n,) where a sample has nothing to do with the one before; nowhere without it.
    algorithm
        ``i_vt``: samples slower than `velocity_deg_s` from the one before; ``i_dt``: windows whose
        extents in azimuth (times the cosine of elevation) and elevation sum to at most
        `dispersion_deg`.
    shortest_s
        Shorter ones are none.
    longest_gap_s
        A fixation ends where samples are missing for longer, or the gaze is not valid.

    Notes
    -----
    Salvucci & Goldberg, "Identifying fixations and saccades in eye-tracking protocols", ETRA 2000.
    """
    found: list[GazeFixation] = []
    cuts = np.zeros(valid.shape, dtype=bool) if cuts is None else cuts
    for run in runs(time_s, valid, cuts, longest_gap_s):
        times, ways = time_s[run], directions[run]
        if algorithm == "i_vt":
            parts = _slow(times, ways, velocity_deg_s)
        else:
            parts = _narrow(times, ways, dispersion_deg, shortest_s)
        for first, last in parts:
            length = float(times[last] - times[first])
            if last > first and length >= shortest_s - 1e-9:
                found.append(_fixation(times, ways, first, last))
    return found


def _fixation(times: Floats, ways: Floats, first: int, last: int) -> GazeFixation:
    mean = ways[first : last + 1].mean(axis=0)
    azimuth, elevation = angles_deg(mean[None])
    length = float(times[last] - times[first])
    samples = last - first + 1
    return GazeFixation(
        float(times[first]), length, float(azimuth[0]), float(elevation[0]), samples
    )


def steps_deg(directions: Floats) -> Floats:
    """Return the angles between successive (n, 3) unit vectors, shape (n − 1,)."""
    chords = np.linalg.norm(np.diff(directions, axis=0), axis=1)
    steps: Floats = np.degrees(2 * np.arcsin(np.clip(chords / 2, 0, 1)))
    return steps


def _slow(times: Floats, ways: Floats, limit_deg_s: float) -> Iterator[tuple[int, int]]:
    """Yield first and last sample of each stretch that is slow throughout."""
    slow = steps_deg(ways) < limit_deg_s * np.diff(times)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], slow.astype(np.int8), [0]])))
    yield from ((int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True))


def _narrow(
    times: Floats, ways: Floats, limit_deg: float, shortest_s: float
) -> Iterator[tuple[int, int]]:
    """Yield first and last sample of each window that is narrow, as long as it stays so."""
    azimuth, elevation = angles_deg(ways)
    azimuth = np.unwrap(azimuth, period=360.0)
    first, n = 0, len(times)
    while first < n:
        last = int(np.searchsorted(times, times[first] + shortest_s - 1e-9))
        if last >= n:
            return
        if _dispersion_deg(azimuth[first : last + 1], elevation[first : last + 1]) > limit_deg:
            first += 1
            continue
        while last + 1 < n:
            wider = slice(first, last + 2)
            if _dispersion_deg(azimuth[wider], elevation[wider]) > limit_deg:
                break
            last += 1
        yield first, last
        first = last + 1


def _dispersion_deg(azimuth: Floats, elevation: Floats) -> float:
    across = float(np.ptp(azimuth) * np.cos(np.radians(elevation.mean())))
    return across + float(np.ptp(elevation))


def saliency_map(
    directions: Floats,
    seconds: Floats,
    *,
    centre_deg: float = 0.0,
    half_extent_deg: tuple[float, float] = (50.0, 50.0),
    cell_deg: float = 1.0,
    sigma_deg: float = 1.0,
) -> Map:
    """Return where the gaze was for how much of the time, spread by a Gaussian.

    Parameters
    ----------
    directions
        (n, 3), seen from one viewpoint: in the head's frame, or in the world's.
    seconds
        (n,) how long each stands for.
    centre_deg
        Azimuth of the middle of the map.
    half_extent_deg
        Of the map, in azimuth and elevation.
    sigma_deg
        Of the Gaussian, in degrees of azimuth and elevation; about the fovea's radius.

    Notes
    -----
    Mantiuk et al. 2011, Figure 3. What the Gaussian carries over the edge is reflected, so that the
    shares in the map and `outside` sum to 1.
    """
    azimuth, elevation = angles_deg(directions)
    azimuth = (azimuth - centre_deg + 180.0) % 360.0 - 180.0
    edges = [np.arange(-half, half + cell_deg / 2, cell_deg) for half in half_extent_deg]
    counts, _, _ = np.histogram2d(elevation, azimuth, bins=[edges[1], edges[0]], weights=seconds)
    whole = float(seconds.sum())
    share = gaussian_filter(counts, sigma_deg / cell_deg, mode="reflect") / (whole or 1.0)
    middles = [(each[:-1] + each[1:]) / 2 for each in edges]
    outside = 1.0 - float(counts.sum()) / whole if whole else 0.0
    return Map(share, middles[0], middles[1], outside)


# Spectra of head motion by Welch's method, of frames of which some were dropped.


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
