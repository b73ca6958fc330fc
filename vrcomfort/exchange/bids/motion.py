"""Motion-BIDS: poses of head and hands, a tracking system each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.exchange.bids.files import write_json, write_samples, write_tsv
from vrcomfort.exchange.bids.runs import Cells, Run
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.pose_columns import Body, pose_columns
from vrcomfort.records.rows import declared

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
    """What is one tracking system in BIDS.

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
    write_samples(samples, (_sample(row, columns, start_s) for row in run.frames))
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


def _sample(row: Cells, columns: Sequence[str], start_s: float) -> list[object]:
    latency_s = float(row["session_s"]) - start_s
    return [*(row.get(name, "") for name in columns), f"{latency_s:.6f}"]
