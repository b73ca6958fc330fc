"""Gaze and head motion of a study: by exposure, by person, and by condition or scene."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.report.gaze_and_head.exposures import (
    HELD,
    NOTHING,
    SIGNALS,
    WHOLE,
    ExposureSummary,
    read_motion,
    summarise_exposure,
    times_of,
)
from vrcomfort.report.ordering import natural
from vrcomfort.stats.gaze_and_head import Map, angles_deg, saliency_map, unit_vectors

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from vrcomfort.records.reader import Session
    from vrcomfort.records.recording import Memory
    from vrcomfort.report.gaze_and_head.exposures import ExposureSummary
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.plan.gaze_and_head import GazeAndHead
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.stats.gaze_and_head import Map


Row = dict[str, Any]
SHOWN = 10
"""Nodes that stand on the page; the others are summed."""


def node_rows(names: Sequence[str], people: Mapping[str, NDArray[np.float64]]) -> list[Row]:
    """Return a row for each situation and node: the mean share over people, with its error.

    Parameters
    ----------
    names
        Nodes, and `NOTHING`.
    people
        Situation → (people, names) share of each person.

    Returns
    -------
    list of dict
        In the order of the mean of all situations, the longest looked at first; `NOTHING` is last.
    """
    known = {name: shares for name, shares in people.items() if len(shares)}
    if not known:
        return []
    over_all = np.mean([shares.mean(axis=0) for shares in known.values()], axis=0)
    order = sorted(
        range(len(names)), key=lambda at: (names[at] == NOTHING, -over_all[at], names[at])
    )
    return [
        _row(situation, "node" if names[at] else "nothing", names[at], shares[:, at])
        for situation, shares in known.items()
        for at in order
    ]


def shown_nodes(
    rows: Sequence[Row], names: Sequence[str], people: Mapping[str, NDArray[np.float64]]
) -> list[Row]:
    """Return the rows of the longest looked at; the others are one row, summed for each person."""
    nodes = list(dict.fromkeys(row["node"] for row in rows if row["kind"] == "node"))
    few, rest = nodes[:SHOWN], nodes[SHOWN:]
    at = [place for place, name in enumerate(names) if name in set(rest)]
    found = [row for row in rows if row["node"] in few or row["kind"] == "nothing"]
    if rest:
        label = f"{len(rest)} others"
        found += [
            _row(situation, "others", label, shares[:, at].sum(axis=1))
            for situation, shares in people.items()
            if len(shares)
        ]
    return found


def _row(
    situation: str,
    kind: Literal["node", "others", "nothing"],
    name: str,
    shares: NDArray[np.float64],
) -> Row:
    error = float(shares.std(ddof=1) / np.sqrt(len(shares))) if len(shares) > 1 else None
    return {
        "situation": situation, "kind": kind, "node": name, "share": float(shares.mean()),
        "standard_error": error, "people": len(shares),
    }  # fmt: skip


@dataclass(frozen=True)
class SceneViewpoint:
    """The fixations of everybody who looked at a scene from one place.

    Parameters
    ----------
    position_m
        (3,) in the world.
    centre_deg
        Azimuth in the world of the middle of the map: where heads faced on average.
    exposures, elsewhere
        Those in the map, and those in which the head was elsewhere or moved about.
    fixations
        How many; each counts for its length.
    """

    scene: str
    position_m: NDArray[np.float64]
    centre_deg: float
    exposures: int
    elsewhere: int
    fixations: int
    map: Map

    @property
    def facts(self) -> dict[str, Any]:
        """Return everything but the map."""
        return {
            "scene": self.scene,
            "position_m": self.position_m.tolist(),
            "centre_deg": self.centre_deg,
            "exposures": self.exposures,
            "elsewhere": self.elsewhere,
            "fixations": self.fixations,
            "outside": self.map.outside,
        }


def viewpoints(
    exposures: Iterable[tuple[str, ExposureSummary]], within_m: float, sigma_deg: float
) -> list[SceneViewpoint]:
    """Return the map of each scene, of which there are fixations from one place.

    Parameters
    ----------
    exposures
        Scene, and what was seen in it.
    within_m
        How far the median position of a head may be from the median of the scene's, and how far
        from its own the head may be in nine tenths of the frames.
    sigma_deg
        Of the Gaussian that a fixation is spread by.
    """
    scenes: dict[str, list[ExposureSummary]] = defaultdict(list)
    for scene, seen in exposures:
        if seen.fixations:
            scenes[scene].append(seen)
    names = sorted(scenes, key=natural)
    found = (_viewpoint(name, scenes[name], within_m, sigma_deg) for name in names)
    return [each for each in found if each is not None]


def _viewpoint(
    scene: str, exposures: list[ExposureSummary], within_m: float, sigma_deg: float
) -> SceneViewpoint | None:
    places = np.array([seen.viewpoint_m for seen in exposures])
    middle = np.median(places, axis=0)
    still = np.array([seen.reach_m for seen in exposures]) <= within_m
    near = still & (np.linalg.norm(places - middle, axis=1) <= within_m)
    here = [seen for seen, is_near in zip(exposures, near, strict=True) if is_near]
    if not here:
        return None
    centre_deg = float(angles_deg(np.sum([seen.forward for seen in here], axis=0)[None])[0][0])
    fixated = [each for seen in here for each in seen.fixations]
    ways = unit_vectors(
        np.array([each.azimuth_deg for each in fixated]),
        np.array([each.elevation_deg for each in fixated]),
    )
    seconds = np.array([each.duration_s for each in fixated])
    shown = saliency_map(ways, seconds, centre_deg=centre_deg, sigma_deg=sigma_deg)
    return SceneViewpoint(
        scene, middle, centre_deg, len(here), len(exposures) - len(here), len(fixated), shown
    )


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


class SituatedExposure(NamedTuple):
    """An exposure: whose, in which situation and scene, and what it says."""

    person: str
    situation: str
    scene: str
    seen: ExposureSummary


@dataclass
class GazeAndHeadAnalysis:
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
    viewpoints: list[SceneViewpoint] = field(default_factory=list)
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


def analyse_gaze_and_head(
    study: StudyData, plan: Plan, conditions: list[str], memory: Memory | None = None
) -> GazeAndHeadAnalysis:
    """Return gaze and head motion, as far as the plan asks for them and the files have them."""
    asked, found = plan.gaze_and_head, GazeAndHeadAnalysis()
    if asked is None:
        return found
    met: list[SituatedExposure] = []
    for session in study.recorded_sessions:
        trials = [trial for trial in study.trials if _is_of(session, trial)]
        try:
            met += _session(session, trials, asked, found, memory)
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


def _is_of(session: Session, trial: dict[str, str]) -> bool:
    names = session.folder.parent.name, session.folder.name
    return names == (f"sub-{trial['participant']}", f"ses-{trial['session']}")


def _session(
    session: Session,
    trials: list[dict[str, str]],
    asked: GazeAndHead,
    found: GazeAndHeadAnalysis,
    memory: Memory | None,
) -> list[SituatedExposure]:
    """Look at the exposures of a session; nothing of it is kept if a part is damaged."""
    events = {name: times_of(session, name, asked.during_s) for name in asked.during}
    met = []
    for trial, motion in zip(
        trials, read_motion(session.folder / FrameRow.FILE, trials, memory), strict=True
    ):
        if motion is None:
            continue
        seen = summarise_exposure(motion, asked, events)
        keys = {
            key: trial[key] for key in ("participant", "session", "trial", "condition", "scene")
        }
        seen.row = keys | seen.row
        found.exposures.append(seen.row)
        found.fixations += [keys | fixation._asdict() for fixation in seen.fixations]
        met.append(
            SituatedExposure(trial["participant"], trial[asked.situations], trial["scene"], seen)
        )
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
    met: list[SituatedExposure],
    situation: str,
    take: Callable[[ExposureSummary], NDArray[np.float64] | None],
) -> NDArray[np.float64]:
    """Return (people, …): each person's mean over the exposures of a situation that have it."""
    people: dict[str, list[NDArray[np.float64]]] = defaultdict(list)
    for each in met:
        value = take(each.seen) if situation in (each.situation, EVERYBODY) else None
        if value is not None:
            people[each.person].append(value)
    return np.array([np.mean(values, axis=0) for values in people.values()])


def _zone_rows(met: list[SituatedExposure], situations: list[str], asked: GazeAndHead) -> list[Row]:
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


def _shares(event: str, seen: ExposureSummary) -> NDArray[np.float64] | None:
    return np.array(seen.shares[event]) if event in seen.shares else None


def _nodes(met: list[SituatedExposure], situations: list[str]) -> tuple[list[Row], list[Row]]:
    """Return the rows of all nodes, and those that stand on the page."""
    names = sorted({name for each in met for name in each.seen.nodes})

    def shares(seen: ExposureSummary) -> NDArray[np.float64] | None:
        return np.array([seen.nodes.get(name, 0.0) for name in names]) if seen.nodes else None

    people = {situation: _by_person(met, situation, shares) for situation in situations}
    rows = node_rows(names, people)
    return rows, shown_nodes(rows, names, people)


def _spectrum_rows(met: list[SituatedExposure], situations: list[str]) -> list[Row]:
    """Return the mean density over people, at the frequencies of the first exposure."""
    known = [each.seen.spectrum for each in met if each.seen.spectrum is not None]
    if not known:
        return []
    grid = known[0].frequency_hz

    def density(seen: ExposureSummary) -> NDArray[np.float64] | None:
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


def _mean_maps(met: list[SituatedExposure], situations: list[str]) -> dict[str, Map]:
    """Return the mean of each situation's maps, every person counting alike."""
    some = next((each.seen.head_map for each in met if each.seen.head_map is not None), None)
    found: dict[str, Map] = {}
    for situation in situations:
        shares = _by_person(met, situation, lambda s: s.head_map.share if s.head_map else None)
        if some is not None and len(shares):
            share = shares.mean(axis=0)
            found[situation] = some._replace(share=share, outside=1.0 - float(share.sum()))
    return found


Results = dict[str, Any]
Paragraph = tuple[str, str, tuple[str, ...]]
"""Title, text, and the keys of what it cites."""


def gaze_paragraphs(results: Results) -> list[Paragraph]:
    """Return the paragraphs on what this report holds of these."""
    found = results["gaze_and_head"]
    if not found or not found["exposures"]:
        return []
    asked = results["plan"]["gaze_and_head"]
    seen = any(row["gaze_valid_share"] for row in found["exposures"])
    return [*([_gaze(asked, found)] if seen else []), _head(asked)]


def _gaze(asked: Results, found: Results) -> Paragraph:
    rule = (
        f"slower than {asked['velocity_deg_s']:g}° per second from sample to sample (I-VT"
        if asked["fixations"] == "i_vt"
        else f"within a dispersion of {asked['dispersion_deg']:g}° (I-DT"
    )
    text = (
        "The gaze is the headset’s, in the frames in which it was valid, and counts for each "
        "frame’s period. A centred zone of ratio r has r times the height and width of an eye’s "
        "image (Hillaire et al., 2008). Fixations are stretches of the line of sight in the world "
        f"{rule}; Salvucci & Goldberg, 2000), of at least {asked['shortest_fixation_s']:g} s. "
    )
    cited = ["hillaire_2008", "salvucci_2000"]
    if found["viewpoints"]:
        text += (
            "Fixation maps are those of exposures that were seen from one place (Mantiuk et al., "
            "2011); each fixation counts for its length. "
        )
        cited.append("mantiuk_2011")
    if found["nodes"]:
        text += (
            "What was looked at is the node of the scene that the line of sight meets first; a "
            "node’s share is of the time in which the gaze was known and the scene drawn. "
        )
    return "Gaze", f"{text}Every person counts alike.", tuple(cited)


def _head(asked: Results) -> Paragraph:
    text = (
        "Spectra of the head’s position and orientation in the stage are Welch’s (1967), with Hann "
        f"windows of {asked['spectrum_window_s']:g} s that overlap by half and are without their "
        "means. Dropped frames are filled by linear interpolation; a gap of more than four "
        "refreshes, or a jump, ends a stretch."
    )
    return "Head motion", text, ("welch_1967",)
