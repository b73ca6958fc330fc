"""Choosing on a panel with the keyboard: arrows and number keys move the choice, Enter confirms.

Numbers and letters mean what they mean in the terminal.
"""

from __future__ import annotations

from collections.abc import Sequence

from vrcomfort.respondent import keys
from vrcomfort.respondent.panel_layout import Act, Cell, answer_cells
from vrcomfort.respondent.pointing import Pointing

LETTERS = {
    keys.BACK: Act.BACK,
    keys.DECLINE: Act.DECLINE,
    keys.STOP: Act.STOP,
    keys.YES: Act.WITHDRAW,
    keys.NO: Act.BACK,
}

SIDEWAYS = 2.0
"""A cell that lies this many times as far ahead is preferred to one that lies aside."""


class KeyChoice:
    """The cell that the keyboard has come to on a page, and what has been typed."""

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
        """Return what Enter chooses: where nothing else was chosen, that all answers are right."""
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
