"""Gaze as BIDS' physiological recording of the type "eyetrack"."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from vrcomfort.exchange.bids.files import write_json, write_samples
from vrcomfort.exchange.bids.runs import Cells, Run

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
    return [_write(stem, run, name, sampling_hz, device) for name in told]


def _write(stem: Path, run: Run, eye: str, sampling_hz: float, device: str) -> Path:
    name = f"{stem.name}_recording-{eye}_physio"
    samples = stem.with_name(f"{name}.tsv.gz")
    columns = [each for each in _COLUMNS if each != _LACKS[eye]]
    rows = (_sample(row, _EYES[eye], run.start_s) for row in run.gaze)
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


def _sample(row: Cells, eye: str, start_s: float) -> dict[str, object]:
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
