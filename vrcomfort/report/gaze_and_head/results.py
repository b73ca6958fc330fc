"""Gaze and head motion of a study: by exposure, by person, and by condition or scene."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.gaze_and_head.exposures import HELD, SIGNALS, WHOLE, Row, Seen, look
from vrcomfort.report.gaze_and_head.motion import read_motion, times_of
from vrcomfort.report.gaze_and_head.nodes import node_rows, shown_nodes
from vrcomfort.report.gaze_and_head.viewpoints import Viewpoint, viewpoints
from vrcomfort.report.ordering import natural

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from vrcomfort.records.recording import Memory
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.plan.gaze_and_head import GazeAndHead
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.stats.gaze_and_head import Map

EVERYBODY = ""
"""The situation of all exposures together."""
HALF_HEIGHT = 0.5
PER_MINUTE = {"head_path_m": "head_path_m_per_min", "head_turning_deg": "head_turning_deg_per_min"}
MEANS = (
    "gaze_valid_share", *(f"zone_of_{100 * share:.0f}_percent" for share in HELD),
    "fixations_per_min", "fixation_median_s", *PER_MINUTE.values(), "yaw_deg_rms_0.5_2_hz",
    "frames_filled_share",
)  # fmt: skip
"""Columns of the exposures of which situations have the mean of people's means."""


class Met(NamedTuple):
    """An exposure: whose, in which situation and scene, and what it says."""

    person: str
    situation: str
    scene: str
    seen: Seen


@dataclass
class Looked:
    """What was found.

    Parameters
    ----------
    exposures, situations
        A row for each exposure; for each situation, means over people.
    zones
        A row for each situation, event and zone: mean share over people, with its error.
    nodes, shown
        A row for each situation and node: mean share of the gaze over people, with its error; and
        those of the longest looked at, the others summed.
    spectra
        A row for each situation, signal and frequency: mean density over people.
    fixations
        A row for each fixation.
    maps
        Situation → mean map of the gaze in the head's frame.
    viewpoints
        Maps of the fixations from the viewpoint of each scene.
    notes
        What could not be read.
    """

    exposures: list[Row] = field(default_factory=list)
    situations: list[Row] = field(default_factory=list)
    zones: list[Row] = field(default_factory=list)
    nodes: list[Row] = field(default_factory=list)
    shown: list[Row] = field(default_factory=list)
    spectra: list[Row] = field(default_factory=list)
    fixations: list[Row] = field(default_factory=list)
    maps: dict[str, Map] = field(default_factory=dict)
    viewpoints: list[Viewpoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def results(self) -> Row:
        """Return what results.json holds; fixations and frequencies are in tables alone."""
        names = ("exposures", "situations", "zones", "notes")
        return {
            **{name: getattr(self, name) for name in names},
            "nodes": self.shown,
            "outside_map": {name: found.outside for name, found in self.maps.items()},
            "viewpoints": [each.facts for each in self.viewpoints],
        }


def look_at(
    study: StudyData, plan: Plan, conditions: list[str], memory: Memory | None = None
) -> Looked:
    """Return gaze and head motion, as far as the plan asks for them and the files have them."""
    asked, found = plan.gaze_and_head, Looked()
    if asked is None:
        return found
    met: list[Met] = []
    for file in sorted(study.source.rglob("frames.csv")) if study.source.is_dir() else []:
        trials = [trial for trial in study.trials if _is_of(file, trial)]
        try:
            met += _session(file, trials, asked, found, memory)
        except InputError as error:
            found.notes.append(str(error).replace(f"{study.source}/", ""))
    _add_paths(study, found.exposures)
    there = {each.situation for each in met}
    order = conditions if asked.situations == "condition" else sorted(there, key=natural)
    situations = [name for name in order if name in there]
    found.situations = _means(found.exposures, situations, asked.situations)
    shown = [*situations, *([EVERYBODY] if len(situations) > 1 else [])]
    found.zones = _zone_rows(met, shown, asked)
    found.nodes, found.shown = _nodes(met, situations)
    found.spectra = _spectrum_rows(met, situations)
    found.maps = _mean_maps(met, situations)
    scenes = [(each.scene, each.seen) for each in met]
    found.viewpoints = viewpoints(scenes, asked.viewpoint_within_m, asked.saliency_sigma_deg)
    return found


def _is_of(file: Path, trial: dict[str, str]) -> bool:
    names = file.parent.parent.name, file.parent.name
    return names == (f"sub-{trial['participant']}", f"ses-{trial['session']}")


def _session(
    file: Path,
    trials: list[dict[str, str]],
    asked: GazeAndHead,
    found: Looked,
    memory: Memory | None,
) -> list[Met]:
    """Look at the exposures of a session; nothing of it is kept if a part is damaged."""
    events = {name: times_of(file.parent, name, asked.during_s) for name in asked.during}
    met = []
    for trial, motion in zip(trials, read_motion(file, trials, memory), strict=True):
        if motion is None:
            continue
        seen = look(motion, asked, events)
        keys = {
            key: trial[key] for key in ("participant", "session", "trial", "condition", "scene")
        }
        seen.row = keys | seen.row
        found.exposures.append(seen.row)
        found.fixations += [keys | fixation._asdict() for fixation in seen.fixations]
        met.append(Met(trial["participant"], trial[asked.situations], trial["scene"], seen))
    return met


def _add_paths(study: StudyData, rows: list[Row]) -> None:
    """Add the path and the turning of the head per minute of live time."""
    frames = {}
    for each in sorted(study.frames, key=lambda each: each.attempt):
        frames[each.participant, each.session, str(each.trial)] = each  # the last attempt
    for row in rows:
        said = frames.get((row["participant"], row["session"], row["trial"]))
        for name, column in PER_MINUTE.items():
            whole = getattr(said, name, None)
            row[column] = 60 * whole / said.live_s if said and whole and said.live_s else None


def _means(rows: list[Row], situations: list[str], by: str) -> list[Row]:
    found = []
    for situation in situations:
        mine = [row for row in rows if row[by] == situation]
        people = dict.fromkeys(row["participant"] for row in mine)
        mean: Row = {"situation": situation, "exposures": len(mine), "people": len(people)}
        for name in MEANS:
            own = [_mean(r.get(name) for r in mine if r["participant"] == who) for who in people]
            mean[name] = _mean(own)
        found.append(mean)
    return found


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None and np.isfinite(value)]
    return sum(known) / len(known) if known else None


def _by_person(
    met: list[Met], situation: str, take: Callable[[Seen], NDArray[np.float64] | None]
) -> NDArray[np.float64]:
    """Return (people, …): each person's mean over the exposures of a situation that have it."""
    people: dict[str, list[NDArray[np.float64]]] = defaultdict(list)
    for each in met:
        value = take(each.seen) if situation in (each.situation, EVERYBODY) else None
        if value is not None:
            people[each.person].append(value)
    return np.array([np.mean(values, axis=0) for values in people.values()])


def _zone_rows(met: list[Met], situations: list[str], asked: GazeAndHead) -> list[Row]:
    """Return the mean share of each zone over people, with its standard error."""
    found = []
    for event in (WHOLE, *asked.during):
        for situation in situations:
            shares = _by_person(met, situation, partial(_shares, event))
            for place, zone in enumerate(asked.zones if len(shares) else ()):
                one = shares[:, place]
                error = float(one.std(ddof=1) / np.sqrt(len(one))) if len(one) > 1 else None
                found.append({
                    "situation": situation, "during": event, "zone": zone,
                    "share": float(one.mean()), "standard_error": error, "people": len(one),
                })  # fmt: skip
    return found


def _shares(event: str, seen: Seen) -> NDArray[np.float64] | None:
    return np.array(seen.shares[event]) if event in seen.shares else None


def _nodes(met: list[Met], situations: list[str]) -> tuple[list[Row], list[Row]]:
    """Return the rows of all nodes, and those that stand on the page."""
    names = sorted({name for each in met for name in each.seen.nodes})

    def shares(seen: Seen) -> NDArray[np.float64] | None:
        return np.array([seen.nodes.get(name, 0.0) for name in names]) if seen.nodes else None

    people = {situation: _by_person(met, situation, shares) for situation in situations}
    rows = node_rows(names, people)
    return rows, shown_nodes(rows, names, people)


def _spectrum_rows(met: list[Met], situations: list[str]) -> list[Row]:
    """Return the mean density over people, at the frequencies of the first exposure."""
    known = [each.seen.spectrum for each in met if each.seen.spectrum is not None]
    if not known:
        return []
    grid = known[0].frequency_hz

    def density(seen: Seen) -> NDArray[np.float64] | None:
        one = seen.spectrum
        if one is None:
            return None
        columns = [np.interp(grid, one.frequency_hz, each) for each in one.density.T]
        return np.column_stack(columns)

    found = []
    for situation in situations:
        people = _by_person(met, situation, density)
        mean = people.mean(axis=0) if len(people) else np.empty((0, len(SIGNALS)))
        found += [
            {"situation": situation, "signal": signal, "frequency_hz": f, "density": float(d),
             "people": len(people)}
            for place, signal in enumerate(SIGNALS)
            for f, d in zip(grid.tolist(), mean[:, place].tolist(), strict=bool(len(people)))
            if f > 0
        ]  # fmt: skip
    return found


def _mean_maps(met: list[Met], situations: list[str]) -> dict[str, Map]:
    """Return the mean of each situation's maps, every person counting alike."""
    some = next((each.seen.head_map for each in met if each.seen.head_map is not None), None)
    found: dict[str, Map] = {}
    for situation in situations:
        shares = _by_person(met, situation, lambda s: s.head_map.share if s.head_map else None)
        if some is not None and len(shares):
            share = shares.mean(axis=0)
            found[situation] = some._replace(share=share, outside=1.0 - float(share.sum()))
    return found
