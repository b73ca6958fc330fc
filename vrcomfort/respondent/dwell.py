"""Choosing by looks alone: a look that rests prepares a cell, and a second one chooses it.

A look counts from when it enters a cell, and none that was there before a page opened: the answer
to the next question stands where the last one was given (the Midas touch of gaze pointing: Jacob
1991, *ACM TOIS* 9:152).
"""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.respondent.panel_layout import Cell

DWELL_S = 1.2
"""So long a look rests without another wish of the protocol."""
DOWN_DEG, DOWN_S = 60.0, 2.0
"""A look down that asks to stop, without another wish of the protocol."""
AWAY_S = 0.25
"""A look that is elsewhere for less, in a blink or at a rim, has not left."""
STEPS = 8
"""In so many steps the progress of a look is drawn."""


@dataclass(frozen=True)
class Progress:
    """What the panel shows of looks.

    Parameters
    ----------
    cell
        The one that is looked at.
    step
        How far the look has come, of `STEPS`.
    prepared
        The cell whose next look chooses it.
    """

    cell: Cell | None = None
    step: int = 0
    prepared: Cell | None = None


class Dwell:
    """Follows where somebody looks on one page.

    Parameters
    ----------
    dwell_s
        So long a look must rest, each of the two times.
    """

    def __init__(self, dwell_s: float = DWELL_S) -> None:
        self._dwell_s = dwell_s
        self.forget()

    def forget(self) -> None:
        """Begin a page: where somebody looks already counts only once they have looked away."""
        self._prepared: Cell | None = None
        self._cell: Cell | None = None
        self._since_s = 0.0
        self._away_since_s: float | None = None
        self._is_new = self._spent = True

    def update(self, cell: Cell | None, now_s: float) -> Cell | None:
        """Take where somebody looks now; return the cell that a second look has chosen."""
        if self._is_new:
            self._is_new, self._cell = False, cell
            return None
        if cell == self._cell:
            self._away_since_s = None
        elif not self._has_left(now_s):
            return None
        else:
            self._cell, self._since_s, self._spent = cell, now_s, False
            self._away_since_s = None
        if cell is None or self._spent or now_s - self._since_s < self._dwell_s:
            return None
        self._spent = True
        if cell != self._prepared:
            self._prepared = cell
            return None
        self._prepared = None
        return cell

    def progress(self, now_s: float) -> Progress:
        """Return what is to be drawn."""
        if self._cell is None or self._spent:
            return Progress(prepared=self._prepared)
        share = (now_s - self._since_s) / self._dwell_s
        return Progress(self._cell, min(int(share * STEPS), STEPS), self._prepared)

    def _has_left(self, now_s: float) -> bool:
        """Return whether somebody has looked elsewhere for long enough."""
        if self._away_since_s is None:
            self._away_since_s = now_s
        return now_s - self._away_since_s >= AWAY_S


class LookDown:
    """A look far down that rests: a request to stop an exposure that needs no button.

    Parameters
    ----------
    least_deg
        So far below the horizon, where nothing of a scene is looked at for long.
    least_s
        For so long.
    """

    def __init__(self, least_deg: float = DOWN_DEG, least_s: float = DOWN_S) -> None:
        self._least_deg, self._least_s = least_deg, least_s
        self.forget()

    def forget(self) -> None:
        """Begin an exposure."""
        self._since_s: float | None = None
        self._away_since_s: float | None = None
        self._asked = False

    def update(self, down_deg: float | None, now_s: float) -> bool:
        """Take where somebody looks now; return whether they have just asked to stop.

        A look ends with one elsewhere, but for a blink, and asks once.
        """
        if down_deg is not None and down_deg >= self._least_deg:
            self._away_since_s = None
            self._since_s = now_s if self._since_s is None else self._since_s
        elif self._away_since_s is None:
            self._away_since_s = now_s
        elif now_s - self._away_since_s >= AWAY_S:
            self.forget()
        rested = self._since_s is not None and now_s - self._since_s >= self._least_s
        if self._asked or not rested or self._away_since_s is not None:
            return False
        self._asked = True
        return True
