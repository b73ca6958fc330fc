"""Reads ``frames.csv`` for a replay: the trace, and what a trace does not keep."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import whole_or_none
from vrcomfort.geometry import Array
from vrcomfort.records.frame_rows import CUT
from vrcomfort.traces.table import TraceTable
from vrcomfort.traces.trace import Trace, read_trace


@dataclass(frozen=True, eq=False)
class FrameFacts:
    """What a trace does not keep of ``frames.csv``.

    Parameters
    ----------
    session_s, trial
        (n,) of each frame.
    drawn
        (n,) bool: the runtime wanted a picture.
    missed_refreshes
        (n,) refreshes that passed before each frame; -1 where only `dropped` says that some did.
    """

    session_s: Array
    trial: NDArray[np.int64]
    drawn: NDArray[np.bool_]
    missed_refreshes: NDArray[np.int64]


def read_frames(file: Path) -> tuple[Trace, FrameFacts]:
    """Return the trace, and the rest.

    Raises
    ------
    InputError
        If a column is missing, or a cell is not what its column holds.
    """
    parts: list[tuple[Any, ...]] = []

    def take(table: TraceTable) -> None:
        if not parts:
            table.require(["session_s", "trial", "should_render", "discontinuity", "dropped"])
        parts.append(_columns(table))

    trace = read_trace(file, also=take)
    cuts, *facts = (np.concatenate(column) for column in zip(*parts, strict=True))
    cuts[0] = True
    return replace(trace, cuts=cuts), FrameFacts(*facts)


def _columns(table: TraceTable) -> tuple[Any, ...]:
    dropped = table.integers("dropped")
    if table.has(["missed_refreshes"]):
        cells = table.text("missed_refreshes")
        known = [whole_or_none(cell) for cell in cells]
        counts = np.array([-1 if each is None or each < 0 else each for each in known], np.int64)
        missed = np.where(dropped > 0, counts, 0)
    else:
        missed = np.where(dropped > 0, -1, 0)
    return (
        # Not as a trace has it: training goes over into the first exposure without a cut.
        table.integers("discontinuity") == CUT,
        table.floats(["session_s"])[:, 0],
        table.integers("trial"),
        table.integers("should_render") != 0,
        missed,
    )
