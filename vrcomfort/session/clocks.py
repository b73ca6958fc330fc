"""Reads all clocks at once now and then, so that any time on record can be put on any of them."""

from __future__ import annotations

import time
from dataclasses import dataclass

from vrcomfort.headset.base import Headset, TellsTime
from vrcomfort.records import ClockRow, Recorder
from vrcomfort.session.context import SessionContext

_TRIES = 3
"""The reading that took the least time is kept: others were interrupted."""


@dataclass
class ClockBridge:
    """Writes ``clocks.csv``, and puts display times on the system's monotonic clock meanwhile.

    Simulated participants live in no time of the system's: nothing is read then.
    """

    context: SessionContext
    recorder: Recorder
    _monotonic_minus_display_ns: int | None = None

    def read(self, headset: Headset, recorded_minus_display_ns: int) -> None:
        """Read all clocks, and write them without waiting.

        Parameters
        ----------
        recorded_minus_display_ns
            What is added to the headset's display times in the files of a session.
        """
        if not self.context.clock.is_real:
            return
        row, display_ns = min(
            (self._reading(headset) for _ in range(_TRIES)), key=lambda each: each[0].took_ns
        )
        if display_ns is not None:
            self._monotonic_minus_display_ns = row.monotonic_ns - display_ns
            row = ClockRow(
                row.session_s,
                display_ns + recorded_minus_display_ns,
                row.monotonic_ns,
                row.unix_ns,
                row.lsl_s,
                row.took_ns,
            )
        self.recorder.write_soon(row)

    def monotonic_ns(self, display_ns: int) -> int | None:
        """Return a display time on the system's monotonic clock; None where it is not known."""
        offset_ns = self._monotonic_minus_display_ns
        return None if offset_ns is None else display_ns + offset_ns

    def _reading(self, headset: Headset) -> tuple[ClockRow, int | None]:
        before_ns = time.monotonic_ns()
        display_ns = headset.display_now_ns() if isinstance(headset, TellsTime) else None
        unix_ns = time.time_ns()
        lsl_s = self.context.relay.now_s()
        session_s = self.context.clock.now_s()
        after_ns = time.monotonic_ns()
        middle_ns = (before_ns + after_ns) // 2
        row = ClockRow(session_s, None, middle_ns, unix_ns, lsl_s, after_ns - before_ns)
        return row, display_ns
