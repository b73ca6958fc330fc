"""Choosing on a panel: by pointing, by looks that rest (dwell), and by keyboard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from vrcomfort.respondent import keyboard
from vrcomfort.respondent.panel_layout import Act, Cell, answer_cells
from vrcomfort.respondent.panel_picture import STEPS, DwellProgress, Picture


@dataclass(frozen=True)
class Pointing:
    """The participant's input to the panel in one frame.

    Parameters
    ----------
    point
        Where they point, as fractions (right, down) of the panel; None beside it.
    select, back, stop
        True in the one frame in which the button goes down.
    held
        True as long as the button of `select` is down.
    dwelling
        True where they point with their eyes or their head and have no button.
    unable
        True where nothing is seen that could point.
    down_deg
        How far below the horizon they look; None where that is not known.
    looked
        Where they look, as `point`, whatever they point with: to answer what a look has asked.
    fist
        Whether a bare hand is a fist.
    hand
        Which controller points (0 left, 1 right).
    arrow, digits, letters, enter
        Presses of arrow keys (right, down), number keys, other keys and Enter in this frame.
    """

    point: tuple[float, float] | None = None
    select: bool = False
    back: bool = False
    stop: bool = False
    held: bool = False
    dwelling: bool = False
    unable: bool = False
    down_deg: float | None = None
    looked: tuple[float, float] | None = None
    fist: bool = False
    hand: int = 1
    arrow: tuple[int, int] = (0, 0)
    digits: str = ""
    letters: str = ""
    enter: bool = False


class Screen(Protocol):
    """A panel in a headset (or a window)."""

    def show(self, picture: Picture | None) -> None:
        """Show a picture from the next frame on, or nothing."""

    def point_at(self, point: tuple[float, float] | None) -> None:
        """Put the pointer at fractions (right, down) of the picture, or take it away."""

    def pointing(self) -> Pointing:
        """Return the participant's input in the current frame."""

    def next_frame(self) -> None:
        """Let a frame pass: for questions outside of exposures."""

    def allow_absence(self, duration_s: float) -> None:
        """Expect no looks for a duration: the headset may be taken off."""

    def tick(self, hand: int) -> None:
        """Confirm an answer to the hand that gave it."""


DWELL_S = 1.2
"""Dwell time without another wish of the protocol."""
DOWN_DEG, DOWN_S = 60.0, 2.0
"""A look down that asks to stop, without another wish of the protocol."""
AWAY_S = 0.25
"""A look that is elsewhere for less, in a blink or at a rim, has not left."""


class Dwell:
    """Follows the gaze on one page: a look that rests prepares a cell, a second one chooses it.

    A look counts from when it enters a cell, and none that was there before a page opened: the
    answer to the next question stands where the last one was given (the Midas touch of gaze
    pointing: Jacob 1991, *ACM TOIS* 9:152).

    Parameters
    ----------
    dwell_s
        So long a look must rest, each of the two times.
    """

    def __init__(self, dwell_s: float = DWELL_S) -> None:
        self._dwell_s = dwell_s
        self.forget()

    def forget(self) -> None:
        """Begin a page: the present look counts only after a look elsewhere."""
        self._prepared: Cell | None = None
        self._cell: Cell | None = None
        self._since_s = 0.0
        self._away_since_s: float | None = None
        self._is_new = self._spent = True

    def update(self, cell: Cell | None, now_s: float) -> Cell | None:
        """Take the cell under the gaze; return a cell that a second look has chosen."""
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

    def progress(self, now_s: float) -> DwellProgress:
        """Return the progress to be drawn."""
        if self._cell is None or self._spent:
            return DwellProgress(prepared=self._prepared)
        share = (now_s - self._since_s) / self._dwell_s
        return DwellProgress(self._cell, min(int(share * STEPS), STEPS), self._prepared)

    def _has_left(self, now_s: float) -> bool:
        """Return whether the gaze has been elsewhere for long enough."""
        if self._away_since_s is None:
            self._away_since_s = now_s
        return now_s - self._away_since_s >= AWAY_S


FIST_S = 2.0
"""A fist that one bare hand makes and holds asks to stop."""


class Rest:
    """Detects an input held for a while (a look, a fist). It triggers once per hold.

    Parameters
    ----------
    least_s
        For so long.
    anew
        What is there from the beginning does not count, until it was away: hands that lie in a lap
        may be fists.
    """

    def __init__(self, least_s: float, *, anew: bool = False) -> None:
        self._least_s, self._anew = least_s, anew
        self.forget()

    def forget(self) -> None:
        """Begin an exposure."""
        self._leave()
        self._asked = self._anew

    def _leave(self) -> None:
        self._since_s: float | None = None
        self._away_since_s: float | None = None
        self._asked = False

    def update(self, holds: bool, now_s: float) -> bool:
        """Take a frame; return whether the hold has just triggered. A blink does not end it."""
        if holds:
            self._away_since_s = None
            self._since_s = now_s if self._since_s is None else self._since_s
        elif self._away_since_s is None:
            self._away_since_s = now_s
        elif now_s - self._away_since_s >= AWAY_S:
            self._leave()
        rested = self._since_s is not None and now_s - self._since_s >= self._least_s
        if self._asked or not rested or self._away_since_s is not None:
            return False
        self._asked = True
        return True


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
        self._least_deg, self._rest = least_deg, Rest(least_s)

    def forget(self) -> None:
        """Begin an exposure."""
        self._rest.forget()

    def update(self, down_deg: float | None, now_s: float) -> bool:
        """Take the angle of the gaze; return whether the look has just asked to stop.

        A look ends with one elsewhere, but for a blink, and asks once.
        """
        return self._rest.update(down_deg is not None and down_deg >= self._least_deg, now_s)


LETTERS = {
    keyboard.BACK: Act.BACK,
    keyboard.DECLINE: Act.DECLINE,
    keyboard.STOP: Act.STOP,
    keyboard.YES: Act.WITHDRAW,
    keyboard.NO: Act.BACK,
}

SIDEWAYS = 2.0
"""A cell that lies this many times as far ahead is preferred to one that lies aside."""


class KeyChoice:
    """The keyboard's choice on a page, and the digits typed so far.

    Numbers and letters mean what they mean in the terminal.
    """

    def __init__(self) -> None:
        self.cell: Cell | None = None
        self._typed = ""

    def forget(self) -> None:
        """Start again, on a new page."""
        self.cell, self._typed = None, ""

    def move(
        self, cells: Sequence[Cell], arrow: tuple[int, int], digits: str, chosen: int | None
    ) -> None:
        """Move the choice.

        Parameters
        ----------
        arrow
            (right, down); the first press comes to the answer given before, else to what confirms
            all answers, else to the first cell.
        digits
            The answer, or on the list of all answers the number of the one to correct.
        chosen
            The answer given before.
        """
        for digit in digits:
            self._type(cells, digit)
        for step in _steps(arrow):
            self._typed = ""
            self.cell = (
                _first(cells, chosen) if self.cell is None else beside(cells, self.cell, step)
            )

    def _type(self, cells: Sequence[Cell], digit: str) -> None:
        """Move to the answer that is typed; a second digit that makes no answer begins anew."""
        numbered = {str(each.value): each for each in answer_cells(cells)}
        numbered |= {str(each.value + 1): each for each in cells if each.act is Act.CORRECT}
        for typed in (self._typed + digit, digit):
            if typed in numbered:
                self.cell, self._typed = numbered[typed], typed
                return
            if any(each.startswith(typed) for each in numbered):  # 1 of 15, where 1 is no answer
                self._typed = typed
                return

    def entered(self, cells: Sequence[Cell]) -> Cell | None:
        """Return the cell that Enter chooses: the chosen one, else the one that confirms all."""
        confirming = (each for each in cells if each.act is Act.CONFIRM)
        return self.cell or next(confirming, None)


def by_button(cells: Sequence[Cell], pointing: Pointing) -> Cell | None:
    """Return the cell that a button or a letter stands for, if the page has it."""
    wanted = [LETTERS[letter] for letter in pointing.letters if letter in LETTERS]
    wanted += [Act.BACK] * pointing.back + [Act.STOP] * pointing.stop
    return next((each for act in wanted for each in cells if each.act is act), None)


def beside(cells: Sequence[Cell], cell: Cell, step: tuple[int, int]) -> Cell:
    """Return the nearest cell in a direction (right, down), or the same if there is none."""
    ahead = [(each, *_offset(cell, each, step)) for each in cells]
    found = [(along + SIDEWAYS * aside, each) for each, along, aside in ahead if along > 0]
    return min(found, key=lambda pair: pair[0])[1] if found else cell


def _offset(start: Cell, end: Cell, step: tuple[int, int]) -> tuple[float, float]:
    """Return how far `end` lies ahead, from edge to edge, and how far aside of a straight way."""
    axis = 0 if step[0] else 1
    sign = step[axis]
    lows, highs = (start.box[axis], end.box[axis]), (start.box[axis + 2], end.box[axis + 2])
    along = lows[1] - highs[0] if sign > 0 else lows[0] - highs[1]
    across = 1 - axis
    gap = max(end.box[across] - start.box[across + 2], start.box[across] - end.box[across + 2], 0)
    middle = abs(sum(end.box[across::2]) - sum(start.box[across::2])) / 2
    return along + 1.0 if along >= 0 else -1.0, gap + middle / 1000


def _steps(arrow: tuple[int, int]) -> list[tuple[int, int]]:
    right, down = arrow
    sideways = [(1 if right > 0 else -1, 0)] * abs(right)
    return sideways + [(0, 1 if down > 0 else -1)] * abs(down)


def _first(cells: Sequence[Cell], chosen: int | None) -> Cell:
    given = [each for each in answer_cells(cells) if each.value == chosen]
    confirming = [each for each in cells if each.act is Act.CONFIRM]
    return [*given, *confirming, cells[0]][0]
