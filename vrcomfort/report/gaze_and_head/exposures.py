"""Gaze and head motion of one exposure: read from its frames, and summarised."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.records.exposure_rows import TaskRow
from vrcomfort.records.frame_rows import CUT
from vrcomfort.records.recording import Categories, Memory, Recording
from vrcomfort.records.session_rows import EventRow
from vrcomfort.report.rows import INLINE
from vrcomfort.rotations import rotate
from vrcomfort.seen_time import unseen_rows
from vrcomfort.stats.gaze_and_head import (
    GazeFixation,
    Map,
    Spectrum,
    angles_deg,
    band_power,
    fixations,
    head_spectrum,
    saliency_map,
    zone_holding,
    zone_ratios,
    zone_shares,
)

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from vrcomfort.csv_table import CsvTable
    from vrcomfort.records.reader import Session
    from vrcomfort.report.gaze_and_head.settings import GazeAndHead

    Floats = NDArray[np.float64]

_POSE = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
_HEAD = tuple(f"head_{part}" for part in _POSE)
_AVATAR = tuple(f"avatar_{part}" for part in _POSE)
_SIDES = ("left", "right", "up", "down")
_FOV = tuple(f"{eye}_fov_{side}_rad" for eye in ("left", "right") for side in _SIDES)
_FRAMES = ("session_s", "xr_time_ns", "period_ns", "trial", "discontinuity", "head_valid",
           "should_render", "paused", "user_present", *_HEAD, *_AVATAR, *_FOV)  # fmt: skip
_GAZE = ("xr_time_ns", "valid", "direction_x", "direction_y", "direction_z")
# Exposures begin and end at frames, whose times are rounded apart from theirs.
_ROUNDING_S = 1e-6
_FORWARD = (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Motion:
    """The recording of n frames that were seen, with a known pose of the head.

    Parameters
    ----------
    time_s, session_s, seconds
        (n,) display time, session time, and period of each frame.
    cuts
        (n,) whether a discontinuity, or a frame that was not seen, lies between a frame and the
        one before.
    head
        (n, 5) position in the stage in metres, yaw (to the right, without jumps) and pitch in
        degrees.
    place, forward
        (n, 3) position of the head in the world, and its viewing direction.
    half_widths
        (n, 2) tangents of half an eye's image in width and height; NaN where not recorded.
    in_head, in_world
        (n, 3) directions of the gaze; NaN where it was not valid. None without an eye tracker.
    nodes
        The node under the gaze, of n frames; None where it was not recorded.
    """

    time_s: Floats
    session_s: Floats
    seconds: Floats
    cuts: NDArray[np.bool_]
    head: Floats
    place: Floats
    forward: Floats
    half_widths: Floats
    in_head: Floats | None
    in_world: Floats | None
    nodes: Categories | None = None

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Return (n,) whether the gaze was valid."""
        if self.in_world is None:
            return np.zeros(self.time_s.shape, dtype=bool)
        return np.isfinite(self.in_world[:, 0])

    @cached_property
    def seen_s(self) -> Floats:
        """Return (n,) the seen seconds before each frame."""
        passed = np.where(self.cuts[1:], self.seconds[:-1], np.diff(self.time_s))
        return np.append(0.0, np.cumsum(passed))


def read_motion(
    frames: Path, trials: list[dict[str, str]], memory: Memory | None = None
) -> list[Motion | None]:
    """Return the frames of each of a session's trials, their last attempts; None without any.

    Raises
    ------
    InputError
        If a recording is damaged, with its place.
    """
    memory = memory or Memory()
    table = Recording.find(frames).columns(_FRAMES, memory)
    gaze_file = frames.with_name("gaze.csv")
    if not gaze_file.is_file():
        return [_motion(table, None, None, trial) for trial in trials]
    recording = Recording.find(gaze_file)
    samples = recording.columns(_GAZE, memory)
    rows = _aligned(table["xr_time_ns"], samples)
    ways = np.column_stack([samples[f"direction_{axis}"] for axis in "xyz"])
    gaze = np.where(rows[:, None] < 0, np.nan, ways[rows])
    nodes = recording.categories("hit_node", memory)
    if nodes is not None:
        nodes = nodes._replace(codes=np.where(rows < 0, -1, nodes.codes[rows]))
    return [_motion(table, gaze, nodes, trial) for trial in trials]


def _aligned(time_ns: Floats, gaze: dict[str, Floats]) -> NDArray[np.int64]:
    """Return (n,) the row of the gaze at each frame's time; −1 where none is valid."""
    # Frames and gaze samples have the same display times where they belong together.
    found = np.full(len(time_ns), -1)
    known = np.flatnonzero(gaze["valid"] == 1)
    place = np.searchsorted(time_ns, gaze["xr_time_ns"][known])
    there = place < len(time_ns)
    there[there] = time_ns[place[there]] == gaze["xr_time_ns"][known][there]
    found[place[there]] = known[there]
    return found


def _motion(
    table: dict[str, Floats], gaze: Floats | None, nodes: Categories | None, trial: dict[str, str]
) -> Motion | None:
    start, end = float(trial["start_s"]) - _ROUNDING_S, float(trial["end_s"]) + _ROUNDING_S
    at = table["session_s"]
    mine = (table["trial"] == int(trial["trial"])) & (at >= start) & (at <= end)
    unseen = unseen_rows(table)
    # Counted over all frames, so that the cut of a left-out frame stays with the next one kept.
    cuts_so_far = np.cumsum(np.asarray(table["discontinuity"] == CUT) | unseen)
    known = np.isfinite(np.column_stack([table[name] for name in _HEAD])).all(axis=1)
    mine = mine & known & ~unseen & (table["head_valid"] != 0)
    if mine.sum() < 2:
        return None
    part = {name: values[mine] for name, values in table.items()}
    cuts = cuts_so_far[mine]
    position, turns = _pose(part, _HEAD)
    forward = rotate(turns, np.broadcast_to(_FORWARD, position.shape))
    yaw, pitch = angles_deg(forward)
    carried, carrying = _avatar(part)
    directions = None if gaze is None else gaze[mine]
    back = turns * [-1.0, -1.0, -1.0, 1.0]  # the conjugate: from the stage to the head
    return Motion(
        time_s=part["xr_time_ns"] / 1e9,
        session_s=part["session_s"],
        seconds=part["period_ns"] / 1e9,
        cuts=np.append(True, np.diff(cuts) > 0),
        head=np.column_stack([position, np.unwrap(yaw, period=360.0), pitch]),
        place=carried + rotate(carrying, position),
        forward=rotate(carrying, forward),
        half_widths=_half_widths(part),
        in_head=None if directions is None else rotate(back, directions),
        in_world=None if directions is None else rotate(carrying, directions),
        nodes=None if nodes is None else nodes._replace(codes=nodes.codes[mine]),
    )


def _pose(part: dict[str, Floats], names: tuple[str, ...]) -> tuple[Floats, Floats]:
    """Return (n, 3) positions and (n, 4) orientations."""
    columns = np.column_stack([part[name] for name in names])
    return columns[:, :3], columns[:, 3:]


def _avatar(part: dict[str, Floats]) -> tuple[Floats, Floats]:
    """Return the pose of the stage in the world; where it was not recorded, the identity."""
    position, turns = _pose(part, _AVATAR)
    known = np.asarray(np.isfinite(np.column_stack([position, turns])).all(axis=1))
    unknown = ~known[:, None]
    return np.where(unknown, 0.0, position), np.where(unknown, [0.0, 0.0, 0.0, 1.0], turns)


def _half_widths(part: dict[str, Floats]) -> Floats:
    """Return the half width and height of an eye's image in tangents, the mean of both eyes.

    The frusta of eyes are asymmetric: half of left and right together is the half width.
    """
    tangents = {name: np.tan(part[name]) for name in _FOV}
    half = [
        sum(tangents[f"{eye}_fov_{high}_rad"] - tangents[f"{eye}_fov_{low}_rad"]
            for eye in ("left", "right")) / 4
        for low, high in (("left", "right"), ("down", "up"))
    ]  # fmt: skip
    return np.column_stack(half)


def times_of(session: Session, name: str) -> Times:
    """Return begin and length, in session time, of the events or task rows of a name.

    The length is 0 where none was recorded.

    Parameters
    ----------
    name
        Of an event (events.csv), or of a kind of task rows (`kind` of tasks.csv, as ``shot``).

    Raises
    ------
    InputError
        If a file is damaged, with its place.
    """
    return [
        *_begun(session.table(EventRow), "name", name),
        *_begun(session.table(TaskRow), "kind", name),
    ]


def _begun(table: CsvTable, column: str, name: str) -> Times:
    """Return onset and duration of the rows of a name; none of a table without these columns."""
    if not {column, "onset_s"} <= set(table.header):
        return []
    lasting = "duration_s" in table.header
    lengths_s = table.numbers("duration_s", blank=0.0) if lasting else [0.0] * len(table.rows)
    begun = zip(table.dicts(), table.numbers("onset_s"), lengths_s, strict=True)
    return [(onset_s, length_s) for row, onset_s, length_s in begun if row[column] == name]


SIGNALS = ("head_x_m", "head_y_m", "head_z_m", "yaw_deg", "pitch_deg")
BANDS_HZ = ((0.25, 0.5), (0.5, 2.0), (2.0, 8.0))
HELD = (0.75, 0.9)
"""Shares of the gaze; see `GazeZones`."""
NOTHING = ""
"""Name of the sky, which is no node."""
WHOLE = ""
"""Key of the whole exposure among events."""
Times = list[tuple[float, float]]


@dataclass(frozen=True)
class GazeZones:
    """Heights, as shares of the image's, of the zones that hold `HELD` of the gaze."""

    zone_of_75_percent: float
    zone_of_90_percent: float


@dataclass(frozen=True)
class FixationStatistics:
    """Number and lengths of fixations; per minute and share are of the time of known gaze."""

    fixations: int
    fixations_per_min: float
    fixation_median_s: float | None
    fixated_share: float


@dataclass(frozen=True)
class HeadBands:
    """Root mean squares of `SIGNALS` in `BANDS_HZ`, and the share of frames behind them."""

    frames_filled_share: float
    frames_left_out_share: float
    rms: dict[str, float] = field(metadata=INLINE)
    """By signal and band; see `rms_name`."""


def rms_name(signal: str, low_hz: float, high_hz: float) -> str:
    """Return the column of a signal's root mean square in a band."""
    return f"{signal}_rms_{low_hz:g}_{high_hz:g}_hz"


@dataclass(frozen=True)
class GazeSummary:
    """The gaze of an exposure.

    Parameters
    ----------
    zones
        None where the size of the images was not recorded.
    shares
        Event, or `WHOLE` → share of the gaze in each of the plan's zones.
    nodes
        Node → share of the gaze on it; empty where that is not known.
    head_map
        Map of the gaze in the frame of the head.
    fixations
        In the world.
    """

    zones: GazeZones | None
    shares: dict[str, list[float]]
    nodes: dict[str, float]
    head_map: Map
    fixations: list[GazeFixation]
    statistics: FixationStatistics


@dataclass(frozen=True)
class ExposureSummary:
    """Gaze and head motion of an exposure.

    Parameters
    ----------
    gaze_valid_share
        None without an eye tracker.
    gaze
        None where the gaze was never valid.
    viewpoint_m, reach_m, forward
        Median position of the head in the world, its distance from there in nine tenths of the
        frames, and its mean direction.
    spectrum
        Of `SIGNALS`; `bands` are its parts.
    """

    gaze_valid_share: float | None
    gaze: GazeSummary | None
    viewpoint_m: Floats
    reach_m: float
    forward: Floats
    spectrum: Spectrum | None
    bands: HeadBands | None


def summarise_exposure(
    motion: Motion, asked: GazeAndHead, events: dict[str, Times]
) -> ExposureSummary:
    """Summarise an exposure; `events` are those of its session, by name."""
    middle = np.median(motion.place, axis=0)
    away_m = np.linalg.norm(motion.place - middle, axis=1)
    spectrum = head_spectrum(
        motion.time_s, motion.head, motion.cuts, period_s=float(np.median(motion.seconds)),
        window_s=asked.spectrum_window_s,
    )  # fmt: skip
    return ExposureSummary(
        gaze_valid_share=_valid_share(motion),
        gaze=_summarise_gaze(motion, asked, events) if motion.valid.any() else None,
        viewpoint_m=middle,
        reach_m=float(np.quantile(away_m, 0.9)),
        forward=motion.forward.mean(axis=0),
        spectrum=spectrum,
        bands=None if spectrum is None else _bands(spectrum),
    )


def _valid_share(motion: Motion) -> float | None:
    if motion.in_world is None:
        return None
    return float(motion.seconds[motion.valid].sum() / motion.seconds.sum())


def _summarise_gaze(motion: Motion, asked: GazeAndHead, events: dict[str, Times]) -> GazeSummary:
    valid = motion.valid
    assert motion.in_head is not None  # noqa: S101 - some gaze is valid
    ways, seconds = motion.in_head[valid], motion.seconds[valid]
    zones, shares = _zones(motion, asked, events)
    found = _fixations(motion, asked)
    return GazeSummary(
        zones=zones,
        shares=shares,
        nodes=node_shares(motion),
        head_map=saliency_map(ways, seconds, sigma_deg=asked.saliency_sigma_deg),
        fixations=found,
        statistics=_fixation_statistics(found, float(seconds.sum())),
    )


def _zones(
    motion: Motion, asked: GazeAndHead, events: dict[str, Times]
) -> tuple[GazeZones | None, dict[str, list[float]]]:
    """Return the zones that hold shares of the gaze, and the gaze's shares in the plan's zones."""
    valid = motion.valid
    assert motion.in_head is not None  # noqa: S101 - some gaze is valid
    ways, seconds, half = motion.in_head[valid], motion.seconds[valid], motion.half_widths[valid]
    if not np.isfinite(half).all():
        return None, {}
    ratios = zone_ratios(ways, half)
    shares = {WHOLE: zone_shares(ratios, seconds, asked.zones)}
    for name, times in events.items():
        now = during(motion, times, asked.during_s)[valid]
        if now.any():
            shares[name] = zone_shares(ratios[now], seconds[now], asked.zones)
    return GazeZones(*(zone_holding(ratios, seconds, share) for share in HELD)), shares


def during(motion: Motion, times: Times, otherwise_s: float) -> NDArray[np.bool_]:
    """Return (n,) whether each frame lies within any of the given times.

    Parameters
    ----------
    times
        Onset and length of each, in session time.
    otherwise_s
        Seen seconds from the onset on, of those whose length is 0.
    """
    at_s, inside = motion.session_s, np.zeros(motion.time_s.shape, dtype=bool)
    for onset_s, length_s in times:
        if length_s:
            inside |= (at_s >= onset_s) & (at_s <= onset_s + length_s)
        elif (first := int(np.searchsorted(at_s, onset_s))) < len(at_s):
            waited_s = 0.0 if motion.cuts[first] else at_s[first] - onset_s
            since_s = motion.seen_s - motion.seen_s[first] + waited_s
            inside |= (at_s >= onset_s) & (since_s <= otherwise_s)
    return inside


def node_shares(motion: Motion) -> dict[str, float]:
    """Return node → share of the time in which the gaze was known.

    Empty where the nodes are not known: they were not recorded, or the gaze met none at all.
    """
    if motion.nodes is None:
        return {}
    places, seconds = motion.nodes.codes[motion.valid], motion.seconds[motion.valid]
    if not (places >= 0).any():
        return {}
    # Blank cells are −1: the first of the sums is that of nothing.
    sums = np.bincount(places + 1, weights=seconds, minlength=1 + len(motion.nodes.names))
    names = (NOTHING, *motion.nodes.names)
    return {
        name: share
        for name, share in zip(names, (sums / sums.sum()).tolist(), strict=True)
        if share
    }


def _fixations(motion: Motion, asked: GazeAndHead) -> list[GazeFixation]:
    assert motion.in_world is not None  # noqa: S101 - some gaze is valid
    return fixations(
        motion.time_s,
        motion.in_world,
        motion.valid,
        cuts=motion.cuts,
        algorithm=asked.fixations,
        velocity_deg_s=asked.velocity_deg_s,
        dispersion_deg=asked.dispersion_deg,
        shortest_s=asked.shortest_fixation_s,
    )


def _fixation_statistics(found: list[GazeFixation], known_s: float) -> FixationStatistics:
    lengths = [each.duration_s for each in found]
    return FixationStatistics(
        fixations=len(lengths),
        fixations_per_min=60 * len(lengths) / known_s,
        fixation_median_s=float(np.median(lengths)) if lengths else None,
        fixated_share=sum(lengths) / known_s,
    )


def _bands(spectrum: Spectrum) -> HeadBands:
    rms = {}
    for low, high in BANDS_HZ:
        power = band_power(spectrum, low, high)
        for name, value in zip(SIGNALS, power.tolist(), strict=True):
            rms[rms_name(name, low, high)] = float(np.sqrt(value))
    return HeadBands(spectrum.filled, spectrum.left_out, rms)
