"""Gaze and head motion of a study, by exposure and by condition."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.gaze_and_head.exposures import Motion, read_motion, times_of
from vrcomfort.stats.gaze import Map, fixations, saliency_map, z_scored, zone_ratios, zone_shares
from vrcomfort.stats.head_spectrum import Spectrum, band_power, head_spectrum

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.plan.gaze_and_head import GazeAndHead
    from vrcomfort.report.study_data import StudyData

SIGNALS = ("head_x_m", "head_y_m", "head_z_m", "yaw_deg", "pitch_deg")
BANDS_HZ = ((0.25, 0.5), (0.5, 2.0), (2.0, 8.0))
WHOLE = "whole exposure"
MEANS = {
    "gaze_valid_share": "gaze_valid_share",
    "fixations_per_min": "fixations_per_min",
    "fixation_median_s": "fixation_median_s",
    "yaw_rms_deg": "yaw_deg_rms_0.5_2_hz",
    "frames_filled_share": "frames_filled_share",
}
"""What a condition's means are called → the column of the exposures."""
Row = dict[str, Any]


@dataclass
class Looked:
    """What was found.

    Parameters
    ----------
    exposures, conditions
        A row for each exposure; for each condition, the means of `MEANS` over its exposures.
    zones
        A row for each situation, condition and zone: mean share over exposures, with its error.
    spectra
        A row for each condition, signal and frequency: mean density over exposures.
    z_scores
        A row for each condition.
    maps
        Condition → mean map of the gaze in the head's frame.
    notes
        What could not be read.
    """

    exposures: list[Row] = field(default_factory=list)
    conditions: list[Row] = field(default_factory=list)
    zones: list[Row] = field(default_factory=list)
    spectra: list[Row] = field(default_factory=list)
    z_scores: list[Row] = field(default_factory=list)
    maps: dict[str, Map] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def results(self) -> Row:
        """Return what results.json holds."""
        names = ("exposures", "conditions", "zones", "spectra", "z_scores", "notes")
        outside = {name: found.outside for name, found in self.maps.items()}
        return {**{name: getattr(self, name) for name in names}, "outside_map": outside}


def look_at(study: StudyData, plan: Plan, scored: Exposures, conditions: list[str]) -> Looked:
    """Return gaze and head motion, as far as the plan asks for them and the files have them."""
    found, asked = Looked(), plan.gaze_and_head
    if asked is None:
        return found
    work = _Work(asked)
    sessions: dict[tuple[str, str], list[dict[str, str]]] = defaultdict(list)
    for trial in study.trials:
        sessions[trial["participant"], trial["session"]].append(trial)
    for file in sorted(study.source.rglob("frames.csv")) if study.source.is_dir() else []:
        said = [t for those in sessions.values() for t in those if _is_of(file, t)]
        try:
            work.add(file, said)
        except InputError as error:
            found.notes.append(str(error).replace(f"{study.source}/", ""))
    found.exposures = work.rows
    found.conditions = _means(work.rows, conditions)
    found.zones = work.zone_rows(conditions)
    found.spectra = work.spectrum_rows(conditions)
    found.maps = work.mean_maps(conditions)
    if asked.z_scores and scored.outcomes:
        found.z_scores = _z_scores(scored, conditions)
    return found


def _is_of(file: Path, trial: dict[str, str]) -> bool:
    names = file.parent.parent.name, file.parent.name
    return names == (f"sub-{trial['participant']}", f"ses-{trial['session']}")


def _means(rows: list[Row], conditions: list[str]) -> list[Row]:
    found = []
    for condition in conditions:
        mine = [row for row in rows if row["condition"] == condition]
        mean: Row = {"condition": condition, "exposures": len(mine)}
        for name, column in MEANS.items():
            known = [row[column] for row in mine if row.get(column) is not None]
            mean[name] = sum(known) / len(known) if known else None
        if mine:
            found.append(mean)
    return found


def _z_scores(scored: Exposures, conditions: list[str]) -> list[Row]:
    outcome = scored.outcomes[0].name
    table = scored.table.dropna(subset=[outcome])
    unit = scored.units[outcome]
    values = [float(value) * unit for value in table[outcome]]
    found = z_scored(list(table["participant"]), list(table["condition"]), values)
    return [
        {"condition": name, "outcome": outcome, **found[name]._asdict()}
        for name in conditions
        if name in found
    ]


class _Work:
    """Collects what each exposure says."""

    def __init__(self, asked: GazeAndHead) -> None:
        self._asked = asked
        self.rows: list[Row] = []
        self._shares: dict[tuple[str, str], list[list[float]]] = defaultdict(list)
        self._spectra: dict[str, list[Spectrum]] = defaultdict(list)
        self._maps: dict[str, list[Map]] = defaultdict(list)

    def add(self, file: Path, trials: list[dict[str, str]]) -> None:
        """Look at the exposures of a session."""
        events = {name: times_of(file.parent, name) for name in self._asked.during}
        for trial, motion in zip(trials, read_motion(file, trials), strict=True):
            if motion is None:
                continue
            keys = ("participant", "session", "trial", "condition")
            row: Row = {key: trial[key] for key in keys}
            row |= self._gaze(motion, trial["condition"], events)
            row |= self._head(motion, trial["condition"])
            self.rows.append(row)

    def _gaze(
        self, motion: Motion, condition: str, events: dict[str, list[tuple[float, float]]]
    ) -> Row:
        if motion.in_head is None or motion.in_stage is None:
            return {"gaze_valid_share": None}
        valid, seconds = motion.valid, motion.seconds
        row: Row = {"gaze_valid_share": float(seconds[valid].sum() / seconds.sum())}
        if not valid.any():
            return row
        asked, ways = self._asked, motion.in_head[valid]
        ratios = zone_ratios(ways, motion.half_widths[valid])
        if np.isfinite(motion.half_widths[valid]).all():
            self._zones(condition, WHOLE, ratios, seconds[valid])
            for name, times in events.items():
                now = _during(motion.session_s[valid], times)
                if now.any():
                    self._zones(condition, name, ratios[now], seconds[valid][now])
        self._maps[condition].append(
            saliency_map(ways, seconds[valid], sigma_deg=asked.saliency_sigma_deg)
        )
        return row | self._fixations(motion)

    def _zones(
        self, condition: str, situation: str, ratios: NDArray[Any], seconds: NDArray[Any]
    ) -> None:
        self._shares[situation, condition].append(zone_shares(ratios, seconds, self._asked.zones))

    def _fixations(self, motion: Motion) -> Row:
        asked = self._asked
        assert motion.in_stage is not None  # noqa: S101 - _gaze has looked
        found = fixations(
            motion.time_s,
            motion.in_stage,
            motion.valid & ~motion.cuts,
            algorithm=asked.fixations,
            velocity_deg_s=asked.velocity_deg_s,
            dispersion_deg=asked.dispersion_deg,
            shortest_s=asked.shortest_fixation_s,
        )
        lengths = [each.duration_s for each in found]
        whole_s = float(motion.seconds.sum())
        return {
            "fixations": len(found),
            "fixations_per_min": 60 * len(found) / whole_s,
            "fixation_median_s": float(np.median(lengths)) if found else None,
            "fixated_share": sum(lengths) / whole_s,
        }

    def _head(self, motion: Motion, condition: str) -> Row:
        period_s = float(np.median(motion.seconds))
        if not np.isfinite(motion.head).all():
            return {"spectrum_windows": 0}
        found = head_spectrum(
            motion.time_s, motion.head, motion.cuts, period_s=period_s,
            window_s=self._asked.spectrum_window_s,
        )  # fmt: skip
        if found is None:
            return {"spectrum_windows": 0}
        self._spectra[condition].append(found)
        row: Row = {
            "spectrum_windows": found.windows,
            "frames_filled_share": found.filled,
            "frames_left_out_share": found.left_out,
        }
        for low, high in BANDS_HZ:
            power = band_power(found, low, high)
            for name, value in zip(SIGNALS, power.tolist(), strict=True):
                row[f"{name}_rms_{low:g}_{high:g}_hz"] = float(np.sqrt(value))
        return row

    def zone_rows(self, conditions: Iterable[str]) -> list[Row]:
        """Return the mean share of each zone over exposures, with its standard error."""
        found = []
        for situation in (WHOLE, *self._asked.during):
            for condition in conditions:
                shares = np.array(self._shares.get((situation, condition), []))
                for place, zone in enumerate(self._asked.zones if len(shares) else ()):
                    one = shares[:, place]
                    error = one.std(ddof=1) / np.sqrt(len(one)) if len(one) > 1 else None
                    found.append({
                        "situation": situation, "condition": condition, "zone": zone,
                        "share": float(one.mean()), "standard_error": error, "n": len(one),
                    })  # fmt: skip
        return found

    def spectrum_rows(self, conditions: Iterable[str]) -> list[Row]:
        """Return the mean density over exposures, at the frequencies of the first."""
        found = []
        for condition in conditions:
            each = self._spectra.get(condition, [])
            if not each:
                continue
            grid = each[0].frequency_hz
            for place, signal in enumerate(SIGNALS):
                densities = [np.interp(grid, s.frequency_hz, s.density[:, place]) for s in each]
                mean = np.mean(densities, axis=0)
                found += [
                    {"condition": condition, "signal": signal, "frequency_hz": f, "density": d,
                     "n": len(each)}
                    for f, d in zip(grid.tolist(), mean.tolist(), strict=True)
                    if f > 0
                ]  # fmt: skip
        return found

    def mean_maps(self, conditions: Iterable[str]) -> dict[str, Map]:
        """Return the mean of each condition's maps, every exposure counting alike."""
        return {
            name: maps[0]._replace(
                share=np.mean([each.share for each in maps], axis=0),
                outside=float(np.mean([each.outside for each in maps])),
            )
            for name in conditions
            if (maps := self._maps.get(name))
        }


def _during(at_s: NDArray[Any], times: list[tuple[float, float]]) -> NDArray[np.bool_]:
    inside = np.zeros(at_s.shape, dtype=bool)
    for start, end in times:
        inside |= (at_s >= start) & (at_s <= end)
    return inside
