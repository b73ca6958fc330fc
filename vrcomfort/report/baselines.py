"""Which baseline belongs to a questionnaire."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.questionnaire import Sheet

Values = dict[str, int | float | Fraction | None]
"""Outcome or item → raw score or answer."""
Moment = tuple[str, str, str, str]
"""Participant, session, number of the exposure, condition; blank where it is not said."""


def number_of(sheet: Sheet) -> str:
    """Return the number of the exposure that a questionnaire belongs to; blank without one."""
    return sheet.trial or sheet.period


def moment_of(sheet: Sheet) -> Moment:
    """Return the moment of a questionnaire."""
    return sheet.participant, sheet.session, number_of(sheet), sheet.condition


@dataclass(frozen=True)
class Baselines:
    """Scores before exposure, by the moment they belong to, and the run of the session.

    Each run of a session that was interrupted began with a baseline of its own; None where that
    is incomplete.
    """

    by_moment: dict[Moment, dict[int, Values | None]]

    @classmethod
    def of_sheets(
        cls, sheets: Iterable[tuple[Sheet, Values | None]], exposures: Iterable[Sheet]
    ) -> Baselines:
        """Index baselines; one with a number that no exposure has is of the whole session."""
        numbered = {moment_of(sheet)[:3] for sheet in exposures}
        found: dict[Moment, dict[int, Values | None]] = {}
        for sheet, values in sheets:
            person, session, number, condition = moment_of(sheet)
            number = number if (person, session, number) in numbered else ""
            found.setdefault((person, session, number, condition), {})[sheet.run] = values
        return cls(found)

    def of(self, sheet: Sheet) -> Values | None:
        """Return the baseline nearest to a questionnaire: of its exposure, session, or study."""
        runs = self._nearest(sheet)
        before = [run for run in runs if run <= sheet.run]
        return runs[max(before)] if before else None

    def _nearest(self, sheet: Sheet) -> dict[int, Values | None]:
        person, number, condition = sheet.participant, number_of(sheet), sheet.condition
        keys = (
            (person, session, exposure, name)
            for session in dict.fromkeys((sheet.session, ""))
            for exposure in dict.fromkeys((number, ""))
            for name in dict.fromkeys((condition, ""))
        )
        return next((self.by_moment[key] for key in keys if key in self.by_moment), {})
