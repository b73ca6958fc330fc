"""Gaze as BIDS' physiological recording of the type "eyetrack"."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from vrcomfort.exchange.bids.files import write_json, write_samples
from vrcomfort.exchange.bids.runs import Cells, Run

_ANGLES = "of the line of sight of both eyes in the OpenXR stage (+X right, +Y up, +Z backward)"
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
        "Description": "How far what the gaze meets is, where focus follows the gaze",
        "Units": "m",
    },
    "valid": {"Description": "0 where the eye tracker did not see the eyes", "Units": "n/a"},
}


def write_gaze(stem: Path, run: Run, sampling_hz: float, device: str) -> Path:
    """Write the gaze of one run and its sidecar; return the file of the samples."""
    name = f"{stem.name}_recording-cyclopean_physio"
    samples = stem.with_name(f"{name}.tsv.gz")
    start_s = run.start_s
    write_samples(samples, (_sample(row, start_s) for row in run.gaze))
    content: dict[str, Any] = {
        "PhysioType": "eyetrack",
        "SamplingFrequency": sampling_hz,
        "StartTime": 0.0,
        "Columns": list(_COLUMNS),
        "RecordedEye": "cyclopean",
        "SampleCoordinateSystem": "gaze-in-world",
        "DeviceName": device,
        **_COLUMNS,
    }
    write_json(stem.with_name(f"{name}.json"), content)
    return samples


def _sample(row: Cells, start_s: float) -> list[object]:
    angles: list[object] = ["", ""]
    if row["valid"] == "1":
        x, y, z = (float(row[f"direction_{axis}"]) for axis in "xyz")
        angles = [f"{math.atan2(x, -z):.9g}", f"{math.asin(max(-1.0, min(1.0, y))):.9g}"]
    origin = [row[f"origin_{axis}_m"] for axis in "xyz"]
    return [
        f"{float(row['session_s']) - start_s:.6f}", *angles, *origin, row["hit_m"], row["valid"]
    ]  # fmt: skip
