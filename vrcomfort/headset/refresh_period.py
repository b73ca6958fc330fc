"""The period at which frames are due, where a runtime's prediction follows the program."""

from __future__ import annotations

from collections import deque
from statistics import median_low

REMEMBERED = 63
"""Frames whose predicted periods are remembered: under a second of most displays."""


class RefreshPeriod:
    """Takes the usual one of the periods that a runtime has predicted lately.

    Some runtimes predict the program's own period: after a frame that took a second, it is a
    second, and goes back slowly. Measured against that, no frame would ever be late.
    """

    def __init__(self) -> None:
        self._predicted_ns: deque[int] = deque(maxlen=REMEMBERED)

    def update(self, predicted_ns: int) -> int:
        """Return the period at which a frame is due, by what is predicted for it."""
        self._predicted_ns.append(predicted_ns)
        return median_low(self._predicted_ns)

    def forget(self) -> None:
        """Begin anew: the display's rate has changed."""
        self._predicted_ns.clear()
