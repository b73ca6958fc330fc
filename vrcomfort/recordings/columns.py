"""DuckDB types of the columns of frames and gaze."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

from vrcomfort.records.frame_rows import FrameRow, GazeRow, gaze_columns
from vrcomfort.records.rows import declared

Kind = Literal["BIGINT", "DOUBLE", "VARCHAR"]

_KINDS: Mapping[type, Kind] = {int: "BIGINT", float: "DOUBLE", str: "VARCHAR"}
NEEDED: Mapping[str, tuple[str, ...]] = {
    FrameRow.FILE: (
        "session_s", "xr_time_ns", "period_ns", "trial", "dropped", "discontinuity",
        "head_x_m", "head_y_m", "head_z_m", "head_qx", "head_qy", "head_qz", "head_qw",
    ),
    GazeRow.FILE: ("session_s", "xr_time_ns", "valid", *gaze_columns()),
}  # fmt: skip
"""Columns without which a file is no recording."""


def kinds(header: Iterable[str]) -> dict[str, Kind]:
    """Return column → what it holds; columns that are not recorded here are text."""
    known = {each.name: _KINDS[each.type] for each in (*declared(FrameRow), *declared(GazeRow))}
    return {name: known.get(name, "VARCHAR") for name in header}
