"""Answers to each question by condition, and scores after recovery."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.descriptives import Description, describe, of_the_tested
from vrcomfort.report.exposures import with_scores
from vrcomfort.report.pairs import in_a_test

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from vrcomfort.questionnaire import Instrument
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.pairs import Tested

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SymptomRow:
    """The answers to an item under one condition.

    Parameters
    ----------
    n
        Exposures.
    above
        Those with an answer above the lowest that there is (with a baseline: above that of the
        baseline).
    """

    instrument: str
    item: str
    condition: str
    n: int
    mean: float
    sd: float | None
    above: int


@dataclass(frozen=True)
class RecoveryRow:
    """Scores of the same sessions after the last exposure and after recovery.

    Parameters
    ----------
    sessions
        Those with both.
    fell, no_higher_than_baseline
        Sessions with a lower score after recovery, and with one no higher than at baseline.
    """

    outcome: str
    sessions: int
    exposed: Description
    recovered: Description
    fell: int
    no_higher_than_baseline: int


def symptom_rows(
    scored: Exposures,
    conditions: Iterable[str],
    tests: Sequence[Tested],
    instruments: Mapping[str, Instrument],
) -> list[SymptomRow]:
    """Describe the answers by item and condition, of the tested people; of all without tests."""
    raw = {o.instrument for o in scored.outcomes if scored.bases[o.name] == "raw_post"}
    lowest = {
        (name, item.name): float(item.answers.low)
        for name in raw
        for item in instruments[name].items
    }
    tested = any(in_a_test(tests, condition) for condition in conditions)
    table = scored.table
    found = []
    for condition in conditions:
        if tested:
            part = of_the_tested(table, tests, condition)
        else:
            part = table[table["condition"] == condition]
        for column, (instrument, item) in scored.items.items():
            values = part[column].dropna().to_numpy(dtype=float)
            if not values.size:
                continue
            deviation = float(np.std(values, ddof=1)) if values.size > 1 else None
            above = int((values > lowest.get((instrument, item), 0.0)).sum())
            n, mean = int(values.size), float(values.mean())
            found.append(SymptomRow(instrument, item, condition, n, mean, deviation, above))
    return found


def recovery_rows(scored: Exposures) -> list[RecoveryRow]:
    """Describe scores after the session's exposures and after recovery, of the same sessions."""
    found = []
    for outcome in scored.units:
        one, two = recovery_course(scored, outcome)
        if not one.size:
            continue
        found.append(
            RecoveryRow(
                outcome=outcome,
                sessions=int(one.size),
                exposed=describe(one),
                recovered=describe(two),
                fell=int((two < one).sum()),
                no_higher_than_baseline=int((two <= 0).sum()),
            )
        )
    return found


def recovery_course(scored: Exposures, outcome: str) -> tuple[Floats, Floats]:
    """Return scores after a session's last exposure and after recovery, of sessions with both."""
    keys, unit = ["participant", "session"], scored.units[outcome]
    after, rest = (with_scores(t, outcome) for t in (scored.table, scored.recovery))
    last = after.sort_values("position", kind="stable").groupby(keys)[outcome].last()
    recovered = rest.groupby(keys)[outcome].last()
    both = last.index.intersection(recovered.index)
    one, two = (each.loc[both].to_numpy(dtype=float) * unit for each in (last, recovered))
    return one, two
