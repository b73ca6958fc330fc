"""Gaze and head motion of a study: by exposure, by person, and by condition or scene."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.names import natural
from vrcomfort.report.gaze_and_head.exposures import (
    NOTHING,
    SIGNALS,
    WHOLE,
    ExposureSummary,
    FixationStatistics,
    GazeSummary,
    GazeZones,
    HeadBands,
    read_motion,
    rms_name,
    summarise_exposure,
    times_of,
)
from vrcomfort.report.rows import INLINE
from vrcomfort.stats.gaze_and_head import Map, angles_deg, saliency_map, unit_vectors

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from vrcomfort.records.reader import Session
    from vrcomfort.records.recording import Memory
    from vrcomfort.report.gaze_and_head.settings import GazeAndHead
    from vrcomfort.report.study_data import StudyData

    Floats = NDArray[np.float64]

NO_TASK = "none"
"""The task of an exposure without one, as protocols write it."""
EVERYBODY = ""
"""The situation of all exposures together."""
SHOWN = 10
"""Nodes on the page; the others are summed."""


@dataclass(frozen=True)
class ExposureKeys:
    """The place of an exposure in the study."""

    participant: str
    session: str
    trial: str
    condition: str
    scene: str


@dataclass(frozen=True)
class ExposureRow:
    """Gaze and head motion of one exposure; columns are missing where they are not known."""

    keys: ExposureKeys = field(metadata=INLINE)
    gaze_valid_share: float | None
    zones: GazeZones | None = field(metadata=INLINE)
    fixations: FixationStatistics | None = field(metadata=INLINE)
    spectrum_windows: int
    bands: HeadBands | None = field(metadata=INLINE)
    head_path_m_per_min: float | None
    head_turning_deg_per_min: float | None


@dataclass(frozen=True)
class SituationRow:
    """Means over people of a situation: a condition or a scene."""

    situation: str
    exposures: int
    people: int
    means: dict[str, float | None] = field(metadata=INLINE)


@dataclass(frozen=True)
class ZoneShare:
    """The share of the gaze within a zone during an event, over people."""

    situation: str
    during: str
    zone: float
    share: float
    standard_error: float | None
    people: int


@dataclass(frozen=True)
class NodeShare:
    """The share of the gaze on a node, over people."""

    situation: str
    kind: Literal["node", "others", "nothing"]
    node: str
    share: float
    standard_error: float | None
    people: int


@dataclass(frozen=True)
class SpectrumPoint:
    """The density of a signal at one frequency, over people."""

    situation: str
    signal: str
    frequency_hz: float
    density: float
    people: int


@dataclass(frozen=True)
class FixationRow:
    """One fixation."""

    keys: ExposureKeys = field(metadata=INLINE)
    start_s: float
    duration_s: float
    azimuth_deg: float
    elevation_deg: float
    samples: int


@dataclass(frozen=True)
class ViewpointRow:
    """The fixations of all exposures that saw a scene from one place.

    Parameters
    ----------
    position_m
        In the world.
    centre_deg
        Azimuth in the world of the middle of the map: the mean direction of heads.
    exposures, elsewhere
        Those in the map, and those with the head elsewhere or moving about.
    fixations
        Each counts for its length.
    outside
        Share of the time outside the map.
    """

    scene: str
    position_m: list[float]
    centre_deg: float
    exposures: int
    elsewhere: int
    fixations: int
    outside: float


@dataclass(frozen=True)
class SceneViewpoint:
    """The map of the fixations from the viewpoint of a scene."""

    row: ViewpointRow
    map: Map


@dataclass(frozen=True)
class SituatedExposure:
    """An exposure and its situation: its condition or its scene."""

    row: ExposureRow
    situation: str
    summary: ExposureSummary

    @property
    def person(self) -> str:
        """Return the participant."""
        return self.row.keys.participant


@dataclass(frozen=True)
class GazeAndHeadResults:
    """Gaze and head motion; key `gaze_and_head` of results.json.

    Parameters
    ----------
    nodes
        Those on the page.
    outside_map
        Situation → share of the time outside the map.
    """

    exposures: list[ExposureRow]
    situations: list[SituationRow]
    zones: list[ZoneShare]
    notes: list[str]
    nodes: list[NodeShare]
    outside_map: dict[str, float]
    viewpoints: list[ViewpointRow]


@dataclass(frozen=True)
class GazeAndHeadAnalysis:
    """Gaze and head motion of a study.

    Parameters
    ----------
    nodes, shown
        Shares of all nodes; and those on the page, where the least looked at are summed.
    fixations, spectra
        In tables alone.
    maps
        Situation → mean map of the gaze in the head's frame.
    notes
        Damaged recordings.
    asked
        The plan's settings; None: nothing was asked for.
    """

    exposures: list[ExposureRow] = field(default_factory=list)
    situations: list[SituationRow] = field(default_factory=list)
    zones: list[ZoneShare] = field(default_factory=list)
    nodes: list[NodeShare] = field(default_factory=list)
    shown: list[NodeShare] = field(default_factory=list)
    spectra: list[SpectrumPoint] = field(default_factory=list)
    fixations: list[FixationRow] = field(default_factory=list)
    maps: dict[str, Map] = field(default_factory=dict)
    viewpoints: list[SceneViewpoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    asked: GazeAndHead | None = None

    @property
    def results(self) -> GazeAndHeadResults | None:
        """Return the part of results.json; None where nothing was asked for."""
        if self.asked is None:
            return None
        return GazeAndHeadResults(
            exposures=self.exposures,
            situations=self.situations,
            zones=self.zones,
            notes=self.notes,
            nodes=self.shown,
            outside_map={name: found.outside for name, found in self.maps.items()},
            viewpoints=[each.row for each in self.viewpoints],
        )


def analyse_gaze_and_head(
    study: StudyData,
    asked: GazeAndHead | None,
    conditions: list[str],
    memory: Memory | None = None,
) -> GazeAndHeadAnalysis:
    """Analyse gaze and head motion, as far as the plan asks for them and the files have them."""
    if asked is None:
        return GazeAndHeadAnalysis()
    rates = _head_rates(study)
    tasks = {_key(row): row.get("task", "") for row in study.tasks}
    exposures: list[SituatedExposure] = []
    notes = []
    for session in study.recorded_sessions:
        trials = [
            {**trial, "task": tasks.get(_key(trial), NO_TASK)}
            for trial in study.trials
            if _is_of(session, trial)
        ]
        try:
            exposures += _session(session, trials, asked, rates, memory)
        except InputError as error:  # nothing of a session is kept if a part is damaged
            notes.append(str(error).replace(f"{study.source}/", ""))
    there = dict.fromkeys(each.situation for each in exposures)
    order: Iterable[str] = {
        "condition": conditions,
        "scene": sorted(there, key=natural),
        "task": [name for name in asked.labels.values() if name in there] + list(there),
    }[asked.situations]
    order = dict.fromkeys(order)
    situations = [name for name in order if name in there]
    nodes, shown = _nodes(exposures, situations)
    together = [EVERYBODY] if len(situations) > 1 else []
    return GazeAndHeadAnalysis(
        exposures=[each.row for each in exposures],
        situations=[_situation_row(exposures, name) for name in situations],
        zones=_zone_rows(exposures, [*situations, *together], asked),
        nodes=nodes,
        shown=shown,
        spectra=_spectrum_rows(exposures, situations),
        fixations=[
            FixationRow(each.row.keys, *fixation)
            for each in exposures
            for fixation in (each.summary.gaze.fixations if each.summary.gaze else ())
        ],
        maps=_mean_maps(exposures, situations),
        viewpoints=_viewpoints(exposures, asked.viewpoint_within_m, asked.saliency_sigma_deg),
        notes=notes,
        asked=asked,
    )


def _key(trial: Mapping[str, str]) -> tuple[str, str, str]:
    return trial["participant"], trial.get("session", ""), trial["trial"]


def _is_of(session: Session, trial: dict[str, str]) -> bool:
    names = session.folder.parent.name, session.folder.name
    return names == (f"sub-{trial['participant']}", f"ses-{trial['session']}")


Rates = tuple[float | None, float | None]
"""Path (metres) and turning (degrees) of the head per minute in which the stimulus was seen."""


def _head_rates(study: StudyData) -> dict[tuple[str, str, str], Rates]:
    """Return the rates of each exposure: participant, session, trial."""
    rates = {}
    for each in sorted(study.frames, key=lambda each: each.attempt):
        # Later attempts at an exposure replace earlier ones.
        path, turning = (
            60 * whole / each.seen_s if whole and each.seen_s else None
            for whole in (each.head_path_m, each.head_turning_deg)
        )
        rates[each.participant, each.session, str(each.trial)] = path, turning
    return rates


def _session(
    session: Session,
    trials: list[dict[str, str]],
    asked: GazeAndHead,
    rates: Mapping[tuple[str, str, str], Rates],
    memory: Memory | None,
) -> list[SituatedExposure]:
    """Return the exposures of a session that have frames."""
    events = {name: times_of(session, name) for name in asked.during}
    found = []
    motions = read_motion(session.folder / FrameRow.FILE, trials, memory)
    for trial, motion in zip(trials, motions, strict=True):
        if motion is None:
            continue
        keys = ExposureKeys(
            trial["participant"],
            trial["session"],
            trial["trial"],
            trial["condition"],
            trial["scene"],
        )
        summary = summarise_exposure(motion, asked, events)
        rate = rates.get((keys.participant, keys.session, keys.trial), (None, None))
        row = _exposure_row(keys, summary, rate)
        name = trial[asked.situations]
        found.append(SituatedExposure(row, asked.labels.get(name, name), summary))
    return found


def _exposure_row(keys: ExposureKeys, summary: ExposureSummary, rates: Rates) -> ExposureRow:
    gaze, spectrum = summary.gaze, summary.spectrum
    return ExposureRow(
        keys=keys,
        gaze_valid_share=summary.gaze_valid_share,
        zones=gaze.zones if gaze else None,
        fixations=gaze.statistics if gaze else None,
        spectrum_windows=spectrum.windows if spectrum else 0,
        bands=summary.bands,
        head_path_m_per_min=rates[0],
        head_turning_deg_per_min=rates[1],
    )


_YAW = rms_name("yaw_deg", 0.5, 2.0)
_MEANS: dict[str, Callable[[ExposureRow], float | None]] = {
    "gaze_valid_share": lambda row: row.gaze_valid_share,
    "zone_of_75_percent": lambda row: row.zones.zone_of_75_percent if row.zones else None,
    "zone_of_90_percent": lambda row: row.zones.zone_of_90_percent if row.zones else None,
    "fixations_per_min": lambda row: row.fixations.fixations_per_min if row.fixations else None,
    "fixation_median_s": lambda row: row.fixations.fixation_median_s if row.fixations else None,
    "head_path_m_per_min": lambda row: row.head_path_m_per_min,
    "head_turning_deg_per_min": lambda row: row.head_turning_deg_per_min,
    _YAW: lambda row: row.bands.rms[_YAW] if row.bands else None,
    "frames_filled_share": lambda row: row.bands.frames_filled_share if row.bands else None,
}
"""Columns of exposures of which situations have the mean of people's means."""


def _situation_row(exposures: list[SituatedExposure], situation: str) -> SituationRow:
    mine = [each for each in exposures if each.situation == situation]
    people: dict[str, list[ExposureRow]] = defaultdict(list)
    for each in mine:
        people[each.person].append(each.row)
    means = {
        name: _mean([_mean(map(value, rows)) for rows in people.values()])
        for name, value in _MEANS.items()
    }
    return SituationRow(situation, len(mine), len(people), means)


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None and np.isfinite(value)]
    return sum(known) / len(known) if known else None


def _by_person(
    exposures: list[SituatedExposure],
    situation: str,
    take: Callable[[ExposureSummary], Floats | None],
) -> Floats:
    """Return (people, …): each person's mean over the exposures of a situation that have it."""
    people: dict[str, list[Floats]] = defaultdict(list)
    for each in exposures:
        value = take(each.summary) if situation in (each.situation, EVERYBODY) else None
        if value is not None:
            people[each.person].append(value)
    return np.array([np.mean(values, axis=0) for values in people.values()])


def _over_people(shares: Floats) -> tuple[float, float | None, int]:
    """Return the mean share, its standard error, and the number of people."""
    error = float(shares.std(ddof=1) / np.sqrt(len(shares))) if len(shares) > 1 else None
    return float(shares.mean()), error, len(shares)


def _zone_rows(
    exposures: list[SituatedExposure], situations: list[str], asked: GazeAndHead
) -> list[ZoneShare]:
    found = []
    for event in (WHOLE, *asked.during):
        for situation in situations:
            shares = _by_person(exposures, situation, partial(_shares, event))
            for place, zone in enumerate(asked.zones if len(shares) else ()):
                found.append(ZoneShare(situation, event, zone, *_over_people(shares[:, place])))
    return found


def _shares(event: str, summary: ExposureSummary) -> Floats | None:
    gaze = summary.gaze
    return np.array(gaze.shares[event]) if gaze and event in gaze.shares else None


def _nodes(
    exposures: list[SituatedExposure], situations: list[str]
) -> tuple[list[NodeShare], list[NodeShare]]:
    """Return the shares of all nodes, and those on the page."""
    gazes = [each.summary.gaze for each in exposures if each.summary.gaze]
    names = sorted({name for gaze in gazes for name in gaze.nodes})

    def shares(summary: ExposureSummary) -> Floats | None:
        nodes = summary.gaze.nodes if summary.gaze else {}
        return np.array([nodes.get(name, 0.0) for name in names]) if nodes else None

    people = {name: _by_person(exposures, name, shares) for name in situations}
    known = {name: values for name, values in people.items() if len(values)}
    rows = _node_rows(names, known)
    return rows, _shown_nodes(rows, names, known)


def _node_rows(names: Sequence[str], people: Mapping[str, Floats]) -> list[NodeShare]:
    """Return the share of each situation and node.

    Parameters
    ----------
    names
        Nodes, and `NOTHING`.
    people
        Situation → (people, names) share of each person.

    Returns
    -------
    list of NodeShare
        In the order of the mean of all situations, the longest looked at first; `NOTHING` is last.
    """
    if not people:
        return []
    over_all = np.mean([shares.mean(axis=0) for shares in people.values()], axis=0)
    order = sorted(
        range(len(names)), key=lambda at: (names[at] == NOTHING, -over_all[at], names[at])
    )
    return [
        NodeShare(
            situation,
            "nothing" if names[at] == NOTHING else "node",
            names[at],
            *_over_people(shares[:, at]),
        )
        for situation, shares in people.items()
        for at in order
    ]


def _shown_nodes(
    rows: Sequence[NodeShare], names: Sequence[str], people: Mapping[str, Floats]
) -> list[NodeShare]:
    """Return the longest looked at; the others are one row, summed for each person."""
    nodes = list(dict.fromkeys(row.node for row in rows if row.kind == "node"))
    few, rest = nodes[:SHOWN], nodes[SHOWN:]
    at = [place for place, name in enumerate(names) if name in set(rest)]
    found = [row for row in rows if row.node in few or row.kind == "nothing"]
    if rest:
        label = f"{len(rest)} others"
        found += [
            NodeShare(situation, "others", label, *_over_people(shares[:, at].sum(axis=1)))
            for situation, shares in people.items()
        ]
    return found


def _spectrum_rows(exposures: list[SituatedExposure], situations: list[str]) -> list[SpectrumPoint]:
    """Return the mean density over people, at the frequencies of the first exposure."""
    known = [each.summary.spectrum for each in exposures if each.summary.spectrum is not None]
    if not known:
        return []
    grid = known[0].frequency_hz

    def density(summary: ExposureSummary) -> Floats | None:
        one = summary.spectrum
        if one is None:
            return None
        columns = [np.interp(grid, one.frequency_hz, each) for each in one.density.T]
        return np.column_stack(columns)

    found = []
    for situation in situations:
        people = _by_person(exposures, situation, density)
        mean = people.mean(axis=0) if len(people) else np.empty((0, len(SIGNALS)))
        found += [
            SpectrumPoint(situation, signal, f, float(d), len(people))
            for place, signal in enumerate(SIGNALS)
            for f, d in zip(grid.tolist(), mean[:, place].tolist(), strict=bool(len(people)))
            if f > 0
        ]
    return found


def _mean_maps(exposures: list[SituatedExposure], situations: list[str]) -> dict[str, Map]:
    """Return the mean of each situation's maps; each person has the same weight."""
    gazes = [each.summary.gaze for each in exposures if each.summary.gaze]
    found: dict[str, Map] = {}
    for situation in situations:
        shares = _by_person(
            exposures, situation, lambda s: s.gaze.head_map.share if s.gaze else None
        )
        if len(shares):
            share = shares.mean(axis=0)
            some = gazes[0].head_map  # all maps have the same cells
            found[situation] = some._replace(share=share, outside=1.0 - float(share.sum()))
    return found


def _viewpoints(
    exposures: Iterable[SituatedExposure], within_m: float, sigma_deg: float
) -> list[SceneViewpoint]:
    """Return the map of each scene that has fixations from one place.

    These are the maps of Mantiuk et al. (2011), Figure 3.

    Parameters
    ----------
    within_m
        Largest distance of the median position of a head from the median of the scene's, and of
        the head from its own in nine tenths of the frames.
    sigma_deg
        Of the Gaussian that spreads a fixation.
    """
    scenes: dict[str, list[tuple[ExposureSummary, GazeSummary]]] = defaultdict(list)
    for each in exposures:
        if each.summary.gaze and each.summary.gaze.fixations:
            scenes[each.row.keys.scene].append((each.summary, each.summary.gaze))
    names = sorted(scenes, key=natural)
    found = (_viewpoint(name, scenes[name], within_m, sigma_deg) for name in names)
    return [each for each in found if each is not None]


def _viewpoint(
    scene: str,
    exposures: list[tuple[ExposureSummary, GazeSummary]],
    within_m: float,
    sigma_deg: float,
) -> SceneViewpoint | None:
    places = np.array([summary.viewpoint_m for summary, _ in exposures])
    middle = np.median(places, axis=0)
    still = np.array([summary.reach_m for summary, _ in exposures]) <= within_m
    near = still & (np.linalg.norm(places - middle, axis=1) <= within_m)
    here = [each for each, is_near in zip(exposures, near, strict=True) if is_near]
    if not here:
        return None
    facing = np.sum([summary.forward for summary, _ in here], axis=0)
    centre_deg = float(angles_deg(facing[None])[0][0])
    fixated = [each for _, gaze in here for each in gaze.fixations]
    ways = unit_vectors(
        np.array([each.azimuth_deg for each in fixated]),
        np.array([each.elevation_deg for each in fixated]),
    )
    seconds = np.array([each.duration_s for each in fixated])
    shown = saliency_map(ways, seconds, centre_deg=centre_deg, sigma_deg=sigma_deg)
    row = ViewpointRow(
        scene=scene,
        position_m=middle.tolist(),
        centre_deg=centre_deg,
        exposures=len(here),
        elsewhere=len(exposures) - len(here),
        fixations=len(fixated),
        outside=shown.outside,
    )
    return SceneViewpoint(row, shown)
