"""How people answered: how long it took them, and whether they gave one answer to everything."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from vrcomfort.report.study_data import StudyData

FAST_S = 2.0
"""Seconds per question below which answers are suspected to be given without reading (Huang et
al., 2012)."""
FEWEST_ITEMS = 3
_WHOSE = ("participant", "session", "trial", "timepoint", "instrument")


def answering(study: StudyData, files: Iterable[Path]) -> dict[str, Any]:
    """Return what answering times and patterns say; `times` is None where none were recorded."""
    whole = [s for s in study.sheets if len(s.answers) >= FEWEST_ITEMS]
    alike = [s for s in whole if len(set(s.answers.values())) == 1]
    same = [s for s in alike if not {0, None} & set(s.answers.values())]
    return {
        "questionnaires": len(whole),
        "all_zero": sum(set(s.answers.values()) == {0} for s in alike),
        "straight_lined": [
            {"participant": s.participant, "questionnaire": s.name, "place": s.place,
             "answer": next(iter(s.answers.values()))}
            for s in same
        ],
        "times": _times(files, {s.participant for s in study.sheets}),
    }  # fmt: skip


def _times(files: Iterable[Path], people: set[str]) -> dict[str, Any] | None:
    """Describe the seconds from one question to its answer, by questionnaire."""
    parts = [part for file in files if (part := _seconds(file)) is not None]
    if not parts:
        return None
    rows = pd.concat(parts)
    rows = rows[rows["participant"].isin(people) & (rows["seconds"] >= 0)]
    if rows.empty:
        return None
    each = rows.groupby(list(_WHOSE))["seconds"].median()
    fast = each[each < FAST_S].reset_index()
    low, median, high = np.percentile(rows["seconds"], [5, 50, 95])
    return {
        "answers": len(rows),
        "p5_s": float(low),
        "median_s": float(median),
        "p95_s": float(high),
        "questionnaires": len(each),
        "fast": len(fast),
        "fast_people": sorted(fast["participant"].unique()),
        "fast_s": FAST_S,
    }


def _seconds(file: Path) -> pd.DataFrame | None:
    """Read when each question of a file was asked and answered; it has been read as a whole."""
    table = pd.read_csv(
        file, dtype=str, keep_default_na=False, encoding_errors="replace", on_bad_lines="skip",
        encoding="utf-8-sig", skipinitialspace=True,
    )  # fmt: skip
    table.columns = table.columns.str.strip().str.lower()
    if not {"asked_s", "answered_s", "participant"} <= set(table.columns):
        return None
    asked, answered = (pd.to_numeric(table[c], errors="coerce") for c in ("asked_s", "answered_s"))
    whose = {name: table[name].str.strip() if name in table else "" for name in _WHOSE}
    return pd.DataFrame({**whose, "seconds": answered - asked}).dropna(subset=["seconds"])
