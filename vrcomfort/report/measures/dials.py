"""Measures of dials: the value that was confirmed in each exposure."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, ClassVar

from vrcomfort.errors import InputError
from vrcomfort.report.measures.model import Measure, Quantity, Value, number_of
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.report.study_data import StudyData


class Dials:
    """``dials.csv``: any dial by its name."""

    quantities: ClassVar[dict[str, Quantity]] = {}
    of_whole_exposures: ClassVar[bool] = False

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the confirmed value of each exposure that had the dial."""
        names = {row["dial"] for row in study.dials}
        if not names:
            raise InputError(f"the study has no dials.csv, of which `{measure.quantity}` is a dial")
        if measure.quantity not in names:
            hint = did_you_mean(measure.quantity, names)
            raise InputError(f"no dial of dials.csv is called `{measure.quantity}`; {hint}")
        found: dict[tuple[str, ...], dict[str, str] | None] = {}
        for row in study.dials:
            if row["dial"] == measure.quantity:
                key = tuple(row.get(n, "") for n in _KEYS)
                found[key] = row if row["kind"] == "confirmed" else found.get(key)
        conditions = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
        for (who, session, trial, condition), last in found.items():
            known = conditions.get((who, session, trial), {}).get("condition", "")
            number = None if last is None else _number(last)
            reason = "it was not confirmed" if last is None else "its value is blank"
            said = condition or known
            yield Value(who, session, trial, said, number, "" if number is not None else reason)


_KEYS = ("participant", "session", "trial", "condition")


def _number(row: dict[str, str]) -> Fraction | None:
    try:
        return number_of(row["value"])
    except ValueError:
        who, text = row["participant"], row["value"]
        message = f"dials.csv: the value of participant {who} is `{text}`, which is no number"
        raise InputError(f"{message}; an outcome needs numbers") from None
