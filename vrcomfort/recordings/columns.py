"""What the columns of recorded frames and gazes hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

from vrcomfort.records.frame_rows import FrameRow, GazeRow, gaze_columns

Kind = Literal["BIGINT", "DOUBLE", "VARCHAR"]

_WHOLE = {
    "xr_time_ns", "period_ns", "trial", "should_render", "head_valid", "head_tracked", "dropped",
    "missed_refreshes", "discontinuity", "resumed", "valid", "left_valid", "right_valid",
}  # fmt: skip
_TEXT = {"session_state", "rays_used", "hit_node", "effect_centre"}
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
    known = {*FrameRow.columns(), *GazeRow.columns()}
    return {name: _kind(name) if name in known else "VARCHAR" for name in header}


def _kind(name: str) -> Kind:
    if name in _WHOLE:
        return "BIGINT"
    return "VARCHAR" if name in _TEXT else "DOUBLE"
