"""Results as flat CSV tables."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import pandas as pd

from vrcomfort.report.analyses import csv_tables
from vrcomfort.report.analyses.anova import ANOVA
from vrcomfort.report.exposures import Exposures, column_of
from vrcomfort.report.flow import FlowStage
from vrcomfort.report.rows import Cells, as_json, cells
from vrcomfort.report.sections import Section, section_tables
from vrcomfort.report.symptoms import RecoveryRow

if TYPE_CHECKING:
    from vrcomfort.report.results import Results

_FORMULA = re.compile(r"'*[=+\-@\t\r\n]")
"""How a text begins that a spreadsheet would compute, or might once it has cut the blank off; and,
so that one apostrophe can be taken off again, a text that begins with apostrophes before that."""
_NUMBER = re.compile(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")


def all_tables(
    results: Results,
    scored: Exposures,
    sections: Iterable[Section],
    drawn: Mapping[str, Sequence[Cells]],
) -> dict[str, str]:
    """Return file name → CSV text; `drawn` are the tables that figures alone are drawn from."""
    columns = ["participant", "session", "position", "condition", "scene", "early"]
    weights = results.weights
    factors = model_columns(results, scored)
    exposures = [
        {
            **{c: row[c] for c in columns},
            **{name: values[place] for name, values in factors.items()},
            **{f"{o}_raw": _whole(row[o]) for o in weights},
            **{o: _points(row[o], weights[o]) for o in weights},
            **{item: _whole(row[item]) for item in scored.items},
        }
        for place, row in enumerate(scored.table.to_dict("records"))
    ]
    tables: dict[str, Sequence[Cells]] = {
        "scores": exposures,
        **csv_tables(results.rows),
        "sensitivity": as_json(results.sensitivity),
        "smallest_effects": as_json(results.smallest_effects),
        "descriptives": as_json(results.descriptives),
        "symptoms": as_json(results.symptoms),
        "recovery": [_recovery(row) for row in results.recovery_course],
        "flow": _flow(results.flow),
        "carry_over": as_json(results.counterbalancing.carry_over)
        if results.counterbalancing
        else (),
        "stimulus_time": as_json(results.stimulus_time),
        "movement": as_json(results.movement),
        "frame_measures": as_json(results.frame_measures),
        "straight_lined": as_json(results.answering.straight_lined),
        "withdrawals": as_json(results.withdrawals.list),
        "early_endings": as_json(results.withdrawals.early_endings),
        "left_out": as_json(results.participants.left_out),
        "in_some_tests": as_json(results.participants.in_some_tests),
        "exclusions": as_json(results.exclusions),
        "deviations": [
            cells(row) | {"participants": " ".join(row.participants)} for row in results.deviations
        ],
        "excluded_questionnaires": as_json(results.quality.excluded_questionnaires),
        **section_tables(sections),
        **drawn,
    }
    return {f"{name}.csv": to_csv(rows) for name, rows in tables.items() if rows}


def model_columns(results: Results, scored: Exposures) -> dict[str, list[Any]]:
    """Return the level of each exposure in the factors of the models, as ``reproduce.R`` reads it.

    Columns are called ``anova: NAME`` and ``mixed: NAME``; there are none of an ANOVA over time,
    whose scores are not those of exposures.
    """
    plan, table = results.plan, scored.table
    made = {name for found in ANOVA.of(results.rows) if found.fit for name in found.fit.factors}
    over_time = any(factor.column == "timepoint" for factor in plan.anova)
    found: dict[str, list[Any]] = {}
    for factor in () if over_time else plan.anova:
        if factor.name in made:
            levels = column_of(scored, table, factor.column).map(
                lambda value, names=factor.levels: names.get(str(value), str(value)),
                na_action="ignore",
            )
            found[f"anova: {factor.name}"] = _or_none(levels)
    for name in (*plan.mixed_model, *plan.covariates):
        found[f"mixed: {name}"] = _or_none(column_of(scored, table, name))
    return found


def _or_none(values: pd.Series) -> list[Any]:
    return [None if pd.isna(value) else value for value in values]


def _whole(value: float | None) -> int | None:
    """Return a whole number; None where there is none."""
    return None if value is None or value != value else int(value)  # noqa: PLR0124 - NaN


def _points(value: float | None, unit: float) -> float | None:
    steps = _whole(value)
    return None if steps is None else float(f"{steps * unit:.12g}")


def to_csv(rows: Sequence[Cells]) -> str:
    """Write rows with the columns of all of them, in the order of appearance; None is blank.

    Texts that a spreadsheet would take for a formula begin with an apostrophe. A list of names is
    a line of CSV in its cell.
    """
    columns = list(dict.fromkeys(key for row in rows for key in row))
    table: list[list[Any]] = [columns, *([row.get(column) for column in columns] for row in rows)]
    return "".join(_line(map(_cell, cells)) for cells in table)


def _cell(cell: Any) -> Any:
    return inert(_line(cell).removesuffix("\n") if isinstance(cell, list) else cell)


def _line(cells: Iterable[Any]) -> str:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\r\n").writerow(cells)  # so that \r in a cell is quoted
    return stream.getvalue().removesuffix("\r\n") + "\n"


def inert(cell: Any) -> Any:
    """Return a cell that no spreadsheet takes for a formula; numbers stay as they are.

    ``reproduce.R`` takes the apostrophe off again: to it, names are data.
    """
    if not isinstance(cell, str) or not _FORMULA.match(cell) or _NUMBER.fullmatch(cell):
        return cell
    return f"'{cell}"


def _recovery(row: RecoveryRow) -> Cells:
    described = {"exposed": row.exposed, "recovered": row.recovered}
    return cells(row, tuple(described)) | {
        f"{stat}_{when}": getattr(found, stat)
        for when, found in described.items()
        for stat in ("mean", "sd", "median")
    }


def _flow(stages: Iterable[FlowStage]) -> list[Cells]:
    return [
        {"stage": stage.stage, "n": stage.n, **gone}
        for stage in stages
        for gone in [{"left": loss.n, "reason": loss.reason} for loss in stage.left] or [{}]
    ]
