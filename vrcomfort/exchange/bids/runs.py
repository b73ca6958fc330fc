"""The exposures of a session as BIDS runs: motion and gaze, each file with its sidecar."""

from __future__ import annotations

import csv
import gzip
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vrcomfort.json_text import json_of
from vrcomfort.records.attempts import Attempt, FramesOfAttempts, within
from vrcomfort.records.exposure_rows import DialRow, RatingRow, TaskRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.reader import Session
from vrcomfort.records.rows import declared
from vrcomfort.records.session_rows import EventRow
from vrcomfort.records.shared_columns import Body, pose_columns

MISSING = "n/a"


def write_json(file: Path, content: Mapping[str, Any]) -> None:
    """Write a sidecar."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json_of(content) + "\n", encoding="utf-8")


def write_tsv(file: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table with a header; blank and None are "n/a"."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(_tsv([columns, *rows]), encoding="utf-8")


def write_samples(file: Path, rows: Iterable[Sequence[object]]) -> None:
    """Write samples without a header, compressed where the name ends in .gz."""
    file.parent.mkdir(parents=True, exist_ok=True)
    text = _tsv(rows)
    if file.suffix == ".gz":
        file.write_bytes(gzip.compress(text.encode(), mtime=0))  # the same bytes each time
    else:
        file.write_text(text, encoding="utf-8")


def _tsv(rows: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n", quoting=csv.QUOTE_NONE,
                        escapechar="\\")  # fmt: skip
    writer.writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue()


def _cell(value: object) -> str:
    text = "" if value is None else " ".join(str(value).split())
    return text or MISSING


_WHOLE = "trial", "attempt", "frames", "resumed"
_TIMES = "session_s", "start_s", "end_s"
Cells = dict[str, str]


@dataclass
class Run:
    """One attempt at an exposure.

    Parameters
    ----------
    number
        Its place in ``trials.csv``, from 1.
    gaze
        A row for each frame, or none.
    """

    number: int
    trial: Cells
    frames: list[Cells] = field(default_factory=list)
    gaze: list[Cells] = field(default_factory=list)
    ratings: list[Cells] = field(default_factory=list)
    tasks: list[Cells] = field(default_factory=list)
    dials: list[Cells] = field(default_factory=list)
    events: list[Cells] = field(default_factory=list)

    @property
    def start_s(self) -> float:
        """Return where the run's time begins: its first frame, or the exposure's start."""
        return float(self.frames[0]["session_s"] if self.frames else self.trial["start_s"])

    @property
    def attempt(self) -> Attempt:
        """Return which it is."""
        return int(self.trial["trial"]), int(self.trial["attempt"])

    def holds(self, time_s: float) -> bool:
        """Return whether a moment of the session lies in the exposure."""
        return within(time_s, float(self.trial["start_s"]), float(self.trial["end_s"]))


def read_runs(session: Session) -> list[Run]:
    """Return the runs of a session.

    Raises
    ------
    InputError
        If a table is damaged.
    """
    runs = [Run(number, row) for number, row in enumerate(session.text_rows(TrialRow), start=1)]
    times: dict[str, Run] = {}
    of_attempt = {run.attempt: run for run in runs}
    attempts = FramesOfAttempts(_numbers(run.trial) for run in runs)
    for row in session.text_rows(FrameRow):
        if (attempt := attempts.add(_numbers(row))) is not None:
            of_attempt[attempt].frames.append(row)
            times[row["xr_time_ns"]] = of_attempt[attempt]
    for row in session.text_rows(GazeRow):
        if (run := times.get(row["xr_time_ns"])) is not None:
            run.gaze.append(row)
    for row in session.text_rows(RatingRow):
        run = _of(runs, row["trial"], float(row["onset_s"]))
        if run is not None:
            run.ratings.append(row)
    for kind in (TaskRow, DialRow):
        for row in session.text_rows(kind):
            run = of_attempt.get((int(row["trial"]), int(row["attempt"])))
            if run is not None:
                (run.tasks if kind is TaskRow else run.dials).append(row)
    for row in session.text_rows(EventRow):
        run = next((each for each in runs if each.holds(float(row["onset_s"]))), None)
        if run is not None and row["name"] not in {"exposure", "answer"}:
            run.events.append(row)
    return runs


def _of(runs: list[Run], trial: str, time_s: float) -> Run | None:
    return next((r for r in runs if r.trial["trial"] == trial and r.holds(time_s)), None)


def _numbers(row: Cells) -> dict[str, float]:
    """Return the numbers that identify a row's attempt."""
    whole = {name: int(row[name]) for name in _WHOLE if name in row}
    return {**whole, **{name: float(row[name]) for name in _TIMES if name in row}}


STAGE = "stage"
_COMPONENTS = ("x", "y", "z", "quat_x", "quat_y", "quat_z", "quat_w")
_FRAME = {
    "Description": "Frame in which the motion data are to be interpreted.",
    "Levels": {
        STAGE: {
            "Description": "The OpenXR stage: +X right, +Y up, +Z backward; its origin is on the "
            "floor, and it does not move. Quaternions turn the body's axes into these.",
            "SpatialAxes": "RUB",
            "RotationRule": "right-hand",
            "RotationOrder": "n/a",
        }
    },
}


@dataclass(frozen=True)
class TrackingSystem:
    """One tracking system in BIDS.

    Parameters
    ----------
    label
        Of the entity `tracksys`.
    bodies
        Columns of ``frames.csv`` → tracked points.
    others
        Whether it has the columns of ``frames.csv`` that are declared as MISC channels, too.
    """

    label: str
    name: str
    bodies: tuple[tuple[Body, str], ...]
    others: bool = False


SYSTEMS = (
    TrackingSystem("head", "headset", (("head", "head"),), others=True),
    TrackingSystem(
        "hands", "controllers", (("left_hand", "left_hand"), ("right_hand", "right_hand"))
    ),
)


def recorded(run: Run, system: TrackingSystem) -> bool:
    """Return whether a run has any pose of a tracking system."""
    names = [pose_columns(body)[0] for body, _ in system.bodies]
    return any(row.get(name) for row in run.frames for name in names)


def write_motion(stem: Path, run: Run, system: TrackingSystem, facts: dict[str, Any]) -> Path:
    """Write samples, channels and sidecars of one run; return the file of the samples.

    Parameters
    ----------
    stem
        Path without ``_motion.tsv``: up to the last entity.
    facts
        Of the sidecar that all tracking systems share.
    """
    declared_as = {each.name: each for each in declared(FrameRow)}
    of_points = [
        (point, component, declared_as[name])
        for body, point in system.bodies
        for component, name in zip(_COMPONENTS, pose_columns(body), strict=True)
    ]
    others = [each for each in declared_as.values() if each.channel == "MISC"]
    others = [each for each in others if system.others and each.name in run.frames[0]]
    columns = [*(column.name for _, _, column in of_points), *(each.name for each in others)]
    samples = stem.with_name(f"{stem.name}_motion.tsv")
    start_s = run.start_s
    write_samples(samples, (_motion_sample(row, columns, start_s) for row in run.frames))
    channels: list[tuple[str, ...]] = [
        (f"{point}_{component}", component, each.channel, point, each.unit, point, STAGE)
        for point, component, each in of_points
    ]
    channels += [(each.name, "n/a", "MISC", "n/a", each.unit, "n/a", "n/a") for each in others]
    channels.append(("latency", "n/a", "LATENCY", "n/a", "s", "n/a", "n/a"))
    header = ("name", "component", "type", "tracked_point", "units", "placement", "reference_frame")
    write_tsv(stem.with_name(f"{stem.name}_channels.tsv"), header, channels)
    write_json(stem.with_name(f"{stem.name}_channels.json"), {"reference_frame": _FRAME})
    points = len(system.bodies)
    write_json(
        stem.with_name(f"{stem.name}_motion.json"),
        {
            **facts,
            "TrackingSystemName": system.name,
            "TrackedPointsCount": points,
            "MotionChannelCount": len(channels),
            "POSChannelCount": 3 * points,
            "ORNTChannelCount": 4 * points,
            "LATENCYChannelCount": 1,
            "ACCELChannelCount": 0,
            "ANGACCELChannelCount": 0,
            "GYROChannelCount": 0,
            "JNTANGChannelCount": 0,
            "MAGNChannelCount": 0,
            "MISCChannelCount": len(others),
            "VELChannelCount": 0,
        },
    )
    return samples


def _motion_sample(row: Cells, columns: Sequence[str], start_s: float) -> list[object]:
    latency_s = float(row["session_s"]) - start_s
    return [*(row.get(name, "") for name in columns), f"{latency_s:.6f}"]


_ANGLES = "of the line of sight in the OpenXR stage (+X right, +Y up, +Z backward)"
_COLUMNS: dict[str, dict[str, str]] = {
    "timestamp": {
        "Description": "Since the first frame of the run; predicted display time of its frame",
        "Units": "s",
        "Origin": "First frame of the run",
    },
    "x_coordinate": {"Description": f"Angle {_ANGLES}, to the right of -Z", "Units": "rad"},
    "y_coordinate": {"Description": f"Angle {_ANGLES}, above the horizon", "Units": "rad"},
    "origin_x": {"Description": "Where the line of sight begins, +X", "Units": "m"},
    "origin_y": {"Description": "Where the line of sight begins, +Y", "Units": "m"},
    "origin_z": {"Description": "Where the line of sight begins, +Z", "Units": "m"},
    "hit_distance": {
        "Description": "How far what the gaze meets is",
        "Units": "m",
    },
    "pupil_size": {"Description": "Diameter of the pupil", "Units": "mm"},
    "valid": {"Description": "0 where the eye tracker did not see the eyes", "Units": "n/a"},
}


_LACKS = {"cyclopean": "pupil_size", "left": "hit_distance", "right": "hit_distance"}
"""The column that a recording has not."""

_EYES = {"cyclopean": "", "left": "left_", "right": "right_"}
"""BIDS' names of recordings, and what columns of theirs begin with."""


def write_gazes(stem: Path, run: Run, sampling_hz: float, device: str) -> list[Path]:
    """Write the gaze of one run, of both eyes together and of each that was told of.

    Returns the files of samples; each has a sidecar.
    """
    told = [name for name, eye in _EYES.items() if any(row.get(f"{eye}valid") for row in run.gaze)]
    return [_write_gaze(stem, run, name, sampling_hz, device) for name in told]


def _write_gaze(stem: Path, run: Run, eye: str, sampling_hz: float, device: str) -> Path:
    name = f"{stem.name}_recording-{eye}_physio"
    samples = stem.with_name(f"{name}.tsv.gz")
    columns = [each for each in _COLUMNS if each != _LACKS[eye]]
    rows = (_gaze_sample(row, _EYES[eye], run.start_s) for row in run.gaze)
    write_samples(samples, ([row[each] for each in columns] for row in rows))
    content: dict[str, Any] = {
        "PhysioType": "eyetrack",
        "SamplingFrequency": sampling_hz,
        "StartTime": 0.0,
        "Columns": columns,
        "RecordedEye": eye,
        "SampleCoordinateSystem": "gaze-in-world",
        "DeviceName": device,
        **{each: _COLUMNS[each] for each in columns},
    }
    write_json(stem.with_name(f"{name}.json"), content)
    return samples


def _gaze_sample(row: Cells, eye: str, start_s: float) -> dict[str, object]:
    """Return column → cell of a sample of both eyes (`eye` is empty), or of one."""
    angles = ["", ""]
    valid = row[f"{eye}valid"]
    if valid == "1":
        x, y, z = (float(row[f"{eye}direction_{axis}"]) for axis in "xyz")
        angles = [f"{math.atan2(x, -z):.9g}", f"{math.asin(max(-1.0, min(1.0, y))):.9g}"]
    return {
        "timestamp": f"{float(row['session_s']) - start_s:.6f}",
        "x_coordinate": angles[0],
        "y_coordinate": angles[1],
        **{f"origin_{axis}": row[f"{eye}origin_{axis}_m"] for axis in "xyz"},
        "hit_distance": row["hit_m"],
        "pupil_size": row.get(f"{eye}pupil_mm", ""),
        "valid": valid,
    }
