"""The period at which frames are due, where a runtime's prediction follows the program."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from statistics import median_low

REMEMBERED = 63
"""Frames whose predicted periods are remembered: under a second of most displays."""
MEASURED = 9
"""Intervals of which the period is measured, where nothing tells it."""


class RefreshPeriod:
    """Takes the usual one of the periods that a runtime has predicted lately.

    Some runtimes predict the program's own period: after a frame that took a second, it is a
    second, and goes back slowly. Measured against that, no frame would ever be late.

    Others predict none (0). Then the display's refresh rate gives the period, or else the median
    interval between the first display times; it is kept, for later intervals are the program's own.

    Parameters
    ----------
    display_hz
        Returns the display's refresh rate as the runtime tells it; 0 where it does not.

    Attributes
    ----------
    source
        Where the period comes from, in words; empty while it is not known.
    """

    def __init__(self, display_hz: Callable[[], float] = lambda: 0.0) -> None:
        self._display_hz = display_hz
        self._predicted_ns: deque[int] = deque(maxlen=REMEMBERED)
        self._otherwise_ns: int | None
        self.forget()

    def update(self, predicted_ns: int, display_ns: int | None = None) -> int:
        """Return the period at which a frame is due, by what is predicted for it.

        Parameters
        ----------
        display_ns
            When the frame is displayed; None where it is not.

        Returns
        -------
        period_ns
            0 while it is not known.
        """
        if predicted_ns > 0:
            self._predicted_ns.append(predicted_ns)
            self.source = "predicted by the runtime"
        if self._predicted_ns:
            return median_low(self._predicted_ns)
        if self._otherwise_ns is None:
            self._otherwise_ns = self._told_ns() or self._measured_ns(display_ns)
        return self._otherwise_ns or 0

    def forget(self) -> None:
        """Begin anew: the display's rate has changed."""
        self._predicted_ns.clear()
        self._intervals_ns: list[int] = []
        self._last_ns: int | None = None
        self._otherwise_ns = None
        self.source = ""

    def _told_ns(self) -> int | None:
        display_hz = self._display_hz()
        if display_hz <= 0:
            return None
        self.source = "the display's refresh rate; the runtime predicts no period"
        return round(1e9 / display_hz)

    def _measured_ns(self, display_ns: int | None) -> int | None:
        before_ns, self._last_ns = self._last_ns, display_ns
        if before_ns is not None and display_ns is not None and display_ns > before_ns:
            self._intervals_ns.append(display_ns - before_ns)
        if len(self._intervals_ns) < MEASURED:
            return None
        self.source = (
            f"measured: the median of {MEASURED} intervals between predicted display times; the "
            "runtime predicts no period"
        )
        return median_low(self._intervals_ns)
