"""One table of everything: rows by case and method, means by scene, and what follows from them."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from vrcomfort import __version__
from vrcomfort.tradeoff.cases import Scope
from vrcomfort.tradeoff.measure import SCATTER, Measured, decibels
from vrcomfort.tradeoff.methods import FOCUS, LENS, SHUTTER
from vrcomfort.tradeoff.pareto import Point, falls, front, log_slope, undecided, verdict
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.timing import CaseTime

Row = dict[str, Any]
MEANS = (
    "flip",
    "ssim",
    "filter_flip",
    "filter_ssim",
    "rivalry",
    "shower_door",
    "coc_mismatch_px",
)
QUADRATIC = ("rms", "reference_rms", "filter_rms")
COSTS = ("frame_ms", "effect_ms", "effect_to_copy", "frame_to_plain")
PERCENTILES = ("effect_p95_ms", "effect_p99_ms")
SAME_COST = 1.1
"""What draws the same picture is on the front together up to this ratio of cost, or noise's."""


def results(
    scope: Scope, measured: Sequence[Measured], times: Sequence[CaseTime], device: str, timer: str
) -> dict[str, Any]:
    """Return everything that was found, as JSON can say it."""
    rows = _rows(measured, times)
    table = means(rows)
    copies = [_copy(each) for each in times]
    return {
        "vrcomfort": __version__,
        "device": device,
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "timer": timer,
        "scope": asdict(scope),
        "settings": {"focus_m": FOCUS.fixed_m, "lens": LENS, "shutter": SHUTTER},
        "exposures": {name: scene_and_hash(name)[0].environment.exposure for name in scope.scenes},
        "copy": copies,
        "rows": rows,
        "table": table,
        **compared(table, _noise(copies)),
    }


def compared(table: Sequence[Row], again: tuple[float, float] = (1.0, 1.0)) -> dict[str, Any]:
    """Return what the means of :func:`means` say: fronts, verdicts and dials.

    Parameters
    ----------
    again
        Ratios of cost, around 1, that say nothing: the A/A interval of the run's copies.
    """
    groups = _groups(table)
    noise = max(SAME_COST, again[1])
    return {
        "again": again,
        "fronts": [_front(key, group, noise) for key, group in groups.items()],
        "verdicts": [row for key, group in groups.items() for row in _verdicts(key, group, again)],
        "dials": [row for key, group in groups.items() for row in _dials(key, group)],
    }


def _noise(copies: Sequence[Row]) -> tuple[float, float]:
    """Return the widest A/A interval of copies, which 1 belongs to."""
    lows, highs = zip(*(each["copy_again"] for each in copies), strict=True) if copies else ((), ())
    return min(1.0, *lows), max(1.0, *highs)


def _rows(measured: Sequence[Measured], times: Sequence[CaseTime]) -> list[Row]:
    """Return one row for each case and method, errors and costs side by side."""
    costs = {(each.case, one.method): one._asdict() for each in times for one in each.methods}
    blank = dict.fromkeys((*COSTS, *PERCENTILES, "passes_ms", "effect_to_copy_interval", "rounds"))
    rows = []
    for each in measured:
        for row in each.rows:
            cost = costs.get((each.case, row["method"]), {})
            rows.append({**row, **blank, **{k: v for k, v in cost.items() if k != "method"}})
    return rows


def _copy(found: CaseTime) -> Row:
    return {
        **asdict(found.case),
        "copy_ms": found.copy_ms,
        "copy_again": found.copy_again,
        "plain_ms": found.plain_ms,
        "plain_again": found.plain_again,
    }


def means(rows: Sequence[Row]) -> list[Row]:
    """Return one row for each scene, effect and method: means over poses and motions."""
    groups: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["scene"], row["effect"], row["method"]), []).append(row)
    return [_mean_row(group) for group in groups.values()]


def _mean_row(group: list[Row]) -> Row:
    first = group[0]
    row = {name: first[name] for name in ("scene", "effect", "method", "family", "step")}
    row["views"] = len(group)
    row |= {name: _mean([each.get(name) for each in group]) for name in (*MEANS, *COSTS)}
    row |= {name: _quadratic([each[name] for each in group]) for name in QUADRATIC}
    row["psnr_db"] = decibels(row["rms"])
    row["filter_psnr_db"] = decibels(row["filter_rms"])
    row["split_half"] = row["reference_rms"] / row["rms"] if row["rms"] else math.inf
    row["counts"] = row["split_half"] <= 0.1
    row["samples"] = min(each["samples"] for each in group)
    return row


def _mean(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _quadratic(values: list[float]) -> float:
    return math.sqrt(float(np.mean(np.square(values))))


def _groups(table: Sequence[Row]) -> dict[tuple[str, str], list[Row]]:
    """Return the rows of each scene and effect, without R2."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in table:
        if row["method"] != SCATTER:
            groups.setdefault((row["scene"], row["effect"]), []).append(row)
    return groups


def _points(rows: Sequence[Row], error: str = "rms") -> list[Point]:
    return [Point(r["method"], r["effect_to_copy"], r[error]) for r in rows if r["effect_to_copy"]]


def _front(key: tuple[str, str], group: Sequence[Row], noise: float) -> Row:
    """Return who is on the front, with those that draw the same as somebody on it."""
    on_front = {point.name for point in front(_points(group))}
    first = [row for row in group if row["method"] in on_front]
    found = [row for row in group if row in first or any(_same(row, one, noise) for one in first)]
    found.sort(key=lambda row: row["effect_to_copy"])
    return {"scene": key[0], "effect": key[1], "front": [row["method"] for row in found]}


def _same(row: Row, other: Row, noise: float) -> bool:
    """Return whether two methods do the same: equal errors, at a cost that differs by noise."""
    if not row["effect_to_copy"]:
        return False
    equal = all(math.isclose(row[name], other[name], rel_tol=1e-9) for name in ("rms", "flip"))
    return equal and row["effect_to_copy"] <= noise * other["effect_to_copy"]


def _verdicts(key: tuple[str, str], group: Sequence[Row], again: tuple[float, float]) -> list[Row]:
    """Return for each source's method which of ours comes nearest to beating it, in both errors."""
    named = {row["method"]: row for row in group}
    ours = [row for row in group if row["family"] in {"ours", "dial"}]
    theirs = [row for row in group if row["family"] == "source"]
    found = []
    for row in theirs:
        for error in ("rms", "flip"):
            one = next(iter(_points([row], error)), None)
            judged = verdict(one, _points(ours, error)) if one else None
            if one and judged:
                facts = {"scene": key[0], "effect": key[1], "error": error, **judged._asdict()}
                facts["counts"] = row["counts"] and named[judged.ours]["counts"]
                facts["undecided"] = undecided(one, _points(ours, error), again)
                found.append({**facts, "beaten": judged.beaten})
    return found


def by_dial(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the methods of each dial in the order of its steps: a name ends in its dial's."""
    dials: dict[str, list[Row]] = {}
    for row in sorted((row for row in rows if row["step"]), key=lambda row: row["step"]):
        word = row["method"].split()[-1]
        dials.setdefault(word if word.endswith("s") else f"{word}s", []).append(row)
    return dials


def _dials(key: tuple[str, str], group: Sequence[Row]) -> list[Row]:
    """Return how the error falls along each dial."""
    return [
        {"scene": key[0], "effect": key[1], "dial": name, **_fall(rows)}
        for name, rows in by_dial(group).items()
        if len(rows) > 1
    ]


def _fall(rows: list[Row]) -> Row:
    sure = [row for row in rows if row["counts"]]
    return {
        "steps": [row["step"] for row in rows],
        "rms": [row["rms"] for row in rows],
        "slope": log_slope([r["step"] for r in rows], [r["rms"] for r in rows]),
        "steps_that_count": [row["step"] for row in sure],
        "slope_that_counts": log_slope([r["step"] for r in sure], [r["rms"] for r in sure]),
        "falls": falls([row["rms"] for row in rows]),
    }
