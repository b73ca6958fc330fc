"""The questionnaires of a study scored at once, as whole numbers of steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.questionnaire import score_all

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from vrcomfort.questionnaire import Instrument, Sheet


def items_of(instrument: Instrument) -> tuple[str, ...]:
    """Return the items that scales count; one that is a scale of its own is among the outcomes."""
    alone = {scale.name for scale in instrument.scales if scale.alone}
    return tuple(item.name for item in instrument.asked if item.name not in alone)


class SheetScores:
    """Scores and answers of sheets, each found by its sheet.

    Parameters
    ----------
    outcomes
        The scales that are wanted; without any, those that everybody who answered all has.

    Attributes
    ----------
    outcomes
        The scales, in the order of the plan or of the instrument's reports.
    """

    def __init__(
        self, instrument: Instrument, sheets: Sequence[Sheet], outcomes: Sequence[str] = ()
    ) -> None:
        self._instrument = instrument
        self._place = {id(sheet): place for place, sheet in enumerate(sheets)}
        answers = [sheet.answers for sheet in sheets]
        found = score_all(instrument, answers)
        everybody = np.ones(len(sheets), dtype=bool)
        needed = [found.known[name] for name in instrument.needed]
        complete = np.logical_and.reduce([everybody, *needed])
        usual = [n for n in instrument.outcomes if not (complete & ~found.known[n]).any()]
        self.outcomes = tuple(outcomes) or tuple(usual)
        wanted = [found.known[name] for name in self.outcomes]
        self._whole = np.logical_and.reduce([complete, *wanted])
        self._raw = {name: found.raw[name] for name in self.outcomes}
        self._answers: dict[str, NDArray[np.float64]] = {
            name: np.array([each.get(name) for each in answers], dtype=np.float64)
            for name in items_of(instrument)
        }

    def is_whole(self, sheet: Sheet) -> bool:
        """Return whether every outcome is known."""
        return bool(self._whole[self._place[id(sheet)]])

    def absent(self, sheet: Sheet) -> list[str]:
        """Return the asked items without an answer."""
        asked = self._instrument.asked
        return [item.name for item in asked if sheet.answers.get(item.name) is None]

    def differences(
        self, after: Sequence[Sheet], before: Sequence[Sheet | None]
    ) -> dict[str, NDArray[Any]]:
        """Return outcome or item → its change, shape (n,); where there is no before, what it is.

        Outcomes are whole numbers. So are items, where none is missing.
        """
        late = np.array([self._place[id(sheet)] for sheet in after], dtype=np.int64)
        early = np.array([self._place[id(s)] if s else -1 for s in before], dtype=np.int64)
        columns: dict[str, NDArray[Any]] = {**self._raw, **self._answers}
        return {
            name: _whole_where_possible(column[late] - np.where(early < 0, 0, column[early]))
            for name, column in columns.items()
        }


def _whole_where_possible(column: NDArray[Any]) -> NDArray[Any]:
    """Return the numbers as int64, if they are whole and there."""
    as_it_is = column.astype(np.float64)
    whole = np.isfinite(as_it_is).all() and (as_it_is == np.rint(as_it_is)).all()
    return np.rint(as_it_is).astype(np.int64) if whole else column
