"""Each question of the questionnaire by condition, and how people were after recovery."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.descriptives import describe, of_the_tested

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import pandas as pd

Row = dict[str, Any]


def symptom_rows(
    table: pd.DataFrame, items: Iterable[str], conditions: Iterable[str], tests: list[Row]
) -> list[Row]:
    """Describe the answers by item and condition, of those tested (of all, if nobody is).

    Returns
    -------
    list of dict
        `n` exposures, `mean`, `sd`, and `above` of them with an answer above 0 (with a baseline:
        above that of the baseline).
    """
    tested = any(test["participants"] for test in tests)
    found = []
    for condition in conditions:
        if tested:
            part = of_the_tested(table, tests, condition)
        else:
            part = table[table["condition"] == condition]
        for item in items if len(part) else ():
            values = part[item].to_numpy(dtype=float)
            deviation = float(np.std(values, ddof=1)) if values.size > 1 else None
            found.append({
                "item": item, "condition": condition, "n": int(values.size),
                "mean": float(values.mean()), "sd": deviation, "above": int((values > 0).sum()),
            })  # fmt: skip
    return found


def recovery_rows(
    after: pd.DataFrame, recovered: pd.DataFrame, units: Mapping[str, float]
) -> list[Row]:
    """Describe scores after the session's exposures and after recovery, of the same sessions.

    Returns
    -------
    list of dict
        `sessions` with both; `exposed`, the last score after an exposure of the session;
        `recovered`; and in how many sessions the score `fell`, was `no_higher_than_baseline`.
    """
    if recovered.empty or after.empty:
        return []
    keys = ["participant", "session"]
    last = after.sort_values("position", kind="stable").groupby(keys).last()
    rest = recovered.groupby(keys).last()
    both = last.index.intersection(rest.index)
    if both.empty:
        return []
    found = []
    for outcome, unit in units.items():
        one = last.loc[both, outcome].to_numpy(dtype=float) * unit
        two = rest.loc[both, outcome].to_numpy(dtype=float) * unit
        found.append({
            "outcome": outcome, "sessions": len(both), "exposed": describe(one),
            "recovered": describe(two), "fell": int((two < one).sum()),
            "no_higher_than_baseline": int((two <= 0).sum()),
        })  # fmt: skip
    return found
