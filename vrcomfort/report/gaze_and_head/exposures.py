"""What one exposure says of gaze and head: numbers, and what maps and curves are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.gaze_and_head.nodes import node_shares
from vrcomfort.stats.gaze_and_head import (
    GazeFixation,
    Map,
    Spectrum,
    band_power,
    fixations,
    head_spectrum,
    saliency_map,
    zone_holding,
    zone_ratios,
    zone_shares,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vrcomfort.report.gaze_and_head.motion import Motion
    from vrcomfort.report.plan.gaze_and_head import GazeAndHead

SIGNALS = ("head_x_m", "head_y_m", "head_z_m", "yaw_deg", "pitch_deg")
BANDS_HZ = ((0.25, 0.5), (0.5, 2.0), (2.0, 8.0))
HELD = (0.75, 0.9)
"""Shares of the gaze of which the zone that holds them is given."""
WHOLE = ""
"""The time of a whole exposure, beside that of events."""
Row = dict[str, Any]
Times = list[tuple[float, float]]


@dataclass
class Seen:
    """What is known of an exposure.

    Parameters
    ----------
    row
        Its numbers, for the table.
    shares
        Event, or `WHOLE` → share of the gaze in each of the plan's zones.
    nodes
        Node → share of the gaze on it; empty where that is not known.
    head_map
        Where the gaze was, seen from the head.
    fixations
        In the world.
    viewpoint_m, reach_m, forward
        Median position of the head in the world, how far from it the head was in nine tenths of
        the frames, and the mean direction that it faced.
    spectrum
        Of `SIGNALS`.
    """

    row: Row
    shares: dict[str, list[float]] = field(default_factory=dict)
    nodes: dict[str, float] = field(default_factory=dict)
    head_map: Map | None = None
    fixations: list[GazeFixation] = field(default_factory=list)
    viewpoint_m: NDArray[np.float64] = field(default_factory=lambda: np.full(3, np.nan))
    reach_m: float = np.nan
    forward: NDArray[np.float64] = field(default_factory=lambda: np.full(3, np.nan))
    spectrum: Spectrum | None = None


def look(motion: Motion, asked: GazeAndHead, events: dict[str, Times]) -> Seen:
    """Return what an exposure says; `events` are those of its session, by name."""
    middle = np.median(motion.place, axis=0)
    away_m = np.linalg.norm(motion.place - middle, axis=1)
    seen = Seen(
        _gaze_known(motion),
        viewpoint_m=middle,
        reach_m=float(np.quantile(away_m, 0.9)),
        forward=motion.forward.mean(axis=0),
    )
    if motion.valid.any():
        _zones(seen, motion, asked, events)
        _fixations(seen, motion, asked)
        seen.nodes = node_shares(motion)
    _spectrum(seen, motion, asked)
    return seen


def _gaze_known(motion: Motion) -> Row:
    if motion.in_world is None:
        return {"gaze_valid_share": None}
    seconds = motion.seconds
    return {"gaze_valid_share": float(seconds[motion.valid].sum() / seconds.sum())}


def _zones(seen: Seen, motion: Motion, asked: GazeAndHead, events: dict[str, Times]) -> None:
    valid = motion.valid
    assert motion.in_head is not None  # noqa: S101 - some gaze is valid
    ways, seconds, half = motion.in_head[valid], motion.seconds[valid], motion.half_widths[valid]
    seen.head_map = saliency_map(ways, seconds, sigma_deg=asked.saliency_sigma_deg)
    if not np.isfinite(half).all():
        return
    ratios = zone_ratios(ways, half)
    seen.shares[WHOLE] = zone_shares(ratios, seconds, asked.zones)
    for share in HELD:
        seen.row[f"zone_of_{100 * share:.0f}_percent"] = zone_holding(ratios, seconds, share)
    for name, times in events.items():
        now = during(motion.session_s[valid], times)
        if now.any():
            seen.shares[name] = zone_shares(ratios[now], seconds[now], asked.zones)


def during(at_s: NDArray[np.float64], times: Times) -> NDArray[np.bool_]:
    """Return which moments are within any of some stretches of time."""
    inside = np.zeros(at_s.shape, dtype=bool)
    for start, end in times:
        inside |= (at_s >= start) & (at_s <= end)
    return inside


def _fixations(seen: Seen, motion: Motion, asked: GazeAndHead) -> None:
    assert motion.in_world is not None  # noqa: S101 - some gaze is valid
    seen.fixations = fixations(
        motion.time_s,
        motion.in_world,
        motion.valid,
        cuts=motion.cuts,
        algorithm=asked.fixations,
        velocity_deg_s=asked.velocity_deg_s,
        dispersion_deg=asked.dispersion_deg,
        shortest_s=asked.shortest_fixation_s,
    )
    lengths = [each.duration_s for each in seen.fixations]
    known_s = float(motion.seconds[motion.valid].sum())
    seen.row |= {
        "fixations": len(lengths),
        "fixations_per_min": 60 * len(lengths) / known_s,
        "fixation_median_s": float(np.median(lengths)) if lengths else None,
        "fixated_share": sum(lengths) / known_s,
    }


def _spectrum(seen: Seen, motion: Motion, asked: GazeAndHead) -> None:
    seen.spectrum = found = head_spectrum(
        motion.time_s, motion.head, motion.cuts, period_s=float(np.median(motion.seconds)),
        window_s=asked.spectrum_window_s,
    )  # fmt: skip
    seen.row["spectrum_windows"] = found.windows if found else 0
    if found is None:
        return
    seen.row |= {"frames_filled_share": found.filled, "frames_left_out_share": found.left_out}
    for low, high in BANDS_HZ:
        power = band_power(found, low, high)
        for name, value in zip(SIGNALS, power.tolist(), strict=True):
            seen.row[f"{name}_rms_{low:g}_{high:g}_hz"] = float(np.sqrt(value))
