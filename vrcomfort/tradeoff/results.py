"""Table of results: rows by case and method, means by scene, fronts, slopes and verdicts."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import pairwise, product
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort import __version__
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.costs import CaseTime
from vrcomfort.tradeoff.error_measures import REGIONS
from vrcomfort.tradeoff.measure import SCATTER, MeasuredCase, decibels
from vrcomfort.tradeoff.methods import FOCUS, LENSES, SHUTTER
from vrcomfort.tradeoff.store import scene_and_hash

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
REGION_RMS = tuple(f"{region}_rms" for region in REGIONS)
QUADRATIC = ("rms", "reference_rms", "filter_rms", "seams", "flicker", *REGION_RMS)
COUNTS = (
    "wide_px",
    "off_median_2_px",
    "off_median_4_px",
    "reference_off_median_2_px",
    "reference_off_median_4_px",
    *(f"{region}_px" for region in REGIONS),
)
"""Pixels, added up over views."""
TRAFFIC = ("reads_per_pixel", "bytes_per_pixel", "passes", "draws")
COSTS = ("cost", "frame_ms", "effect_ms", *TRAFFIC)
PRICES = ("cost", "reads_per_pixel", "bytes_per_pixel")
"""Costs at which methods are compared: processor time (or a GPU's), and counts that hold on any
machine."""
JUDGED = ("rms", "flip", "near_rims_rms", "far_edges_rms")
"""Errors that have verdicts."""
PERCENTILES = ("effect_p95_ms", "effect_p99_ms")
SAME_COST = 1.1
"""Methods with the same picture are on the front together up to this ratio of cost, or noise's."""


def results(
    scope: Scope,
    measured: Sequence[MeasuredCase],
    times: Sequence[CaseTime],
    traffic: dict[tuple[Case, str], Row],
    device: str,
    timer: str,
) -> dict[str, Any]:
    """Return everything that was found, as JSON can say it."""
    rows = _rows(measured, times, traffic)
    table = means(rows)
    again = [_again(each) for each in times]
    return {
        "vrcomfort": __version__,
        "device": device,
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "timer": timer,
        "scope": asdict(scope),
        "settings": {
            "focus_m": FOCUS.fixed_m,
            "lenses": {name: LENSES[name] for name in scope.lenses},
            "shutter": SHUTTER,
        },
        "exposures": {name: scene_and_hash(name)[0].environment.exposure for name in scope.scenes},
        "again": again,
        "rows": rows,
        "table": table,
        **compared(table, _noise(again)),
    }


def compared(table: Sequence[Row], again: tuple[float, float] = (1.0, 1.0)) -> dict[str, Any]:
    """Return fronts, verdicts and dials from the rows of :func:`means`.

    Parameters
    ----------
    again
        Ratios of cost, around 1, that say nothing: the A/A interval of the run's plain frames.
    """
    groups = _groups(table)
    noise = max(SAME_COST, again[1])
    return {
        "noise": again,
        "fronts": [_front(key, group, noise) for key, group in groups.items()],
        "verdicts": [row for key, group in groups.items() for row in _verdicts(key, group, again)],
        "dials": [row for key, group in groups.items() for row in _dials(key, group)],
    }


def _noise(times: Sequence[Row]) -> tuple[float, float]:
    """Return the widest A/A interval of plain frames, which 1 belongs to."""
    lows, highs = zip(*(each["plain_again"] for each in times), strict=True) if times else ((), ())
    return min(1.0, *lows), max(1.0, *highs)


def _rows(
    measured: Sequence[MeasuredCase],
    times: Sequence[CaseTime],
    traffic: dict[tuple[Case, str], Row],
) -> list[Row]:
    """Return one row for each case and method: errors, costs and traffic side by side.

    Windows share the costs of the whole image that they are parts of.
    """
    costs = {(each.case, one.method): one._asdict() for each in times for one in each.methods}
    blank = dict.fromkeys((*COSTS, *PERCENTILES, "parts_ms", "cost_interval", "rounds"))
    rows = []
    for each in measured:
        whole = replace(each.case, window=None)
        for row in each.rows:
            key = whole, row["method"]
            cost = {k: v for k, v in costs.get(key, {}).items() if k != "method"}
            rows.append({**row, **blank, **cost, **traffic.get(key, {})})
    return rows


def _again(found: CaseTime) -> Row:
    return {**asdict(found.case), "plain_ms": found.plain_ms, "plain_again": found.plain_again}


def means(rows: Sequence[Row]) -> list[Row]:
    """Return one row for each scene, effect, lens and method: means over poses and motions."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        key = row["scene"], row["effect"], row["lens"], row["method"]
        groups.setdefault(key, []).append(row)
    return [_mean_row(group) for group in groups.values()]


def _mean_row(group: list[Row]) -> Row:
    first = group[0]
    row = {name: first[name] for name in ("scene", "effect", "lens", "method", "family", "step")}
    row["views"] = len(group)
    row |= {name: _mean([each.get(name) for each in group]) for name in (*MEANS, *COSTS)}
    row |= {name: _quadratic([each.get(name) for each in group]) for name in QUADRATIC}
    row |= {name: _sum([each.get(name) for each in group]) for name in COUNTS}
    row["psnr_db"] = decibels(row["rms"])
    row["filter_psnr_db"] = decibels(row["filter_rms"])
    row["split_half"] = row["reference_rms"] / row["rms"] if row["rms"] else math.inf
    row["counts"] = row["split_half"] <= 0.1
    row["samples"] = min(each["samples"] for each in group)
    return row


def _mean(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _quadratic(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return math.sqrt(float(np.mean(np.square(known)))) if known else None


def _sum(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if known else None


def _groups(table: Sequence[Row]) -> dict[Key, list[Row]]:
    """Return the rows of each scene, effect and lens, without R2."""
    groups: dict[Key, list[Row]] = {}
    for row in table:
        if row["method"] != SCATTER:
            groups.setdefault(key_of_row(row), []).append(row)
    return groups


def _points(rows: Sequence[Row], error: str = "rms", price: str = "cost") -> list[Point]:
    """Return the methods with a price and an error; no blur has neither a price nor a rival."""
    return [
        Point(r["method"], r[price], r[error])
        for r in rows
        if r["family"] != "none" and r.get(price) and r.get(error) is not None
    ]


def _front(key: Key, group: Sequence[Row], noise: float) -> Row:
    """Return the methods on the front, with those that draw the same as one on it."""
    on_front = {point.name for point in front(_points(group))}
    first = [row for row in group if row["method"] in on_front]
    found = [row for row in group if row in first or any(_same(row, one, noise) for one in first)]
    found.sort(key=lambda row: row["cost"])
    return {**named(key), "front": [row["method"] for row in found]}


def _same(row: Row, other: Row, noise: float) -> bool:
    """Return whether two methods do the same: equal errors, at a cost that differs by noise."""
    if not row["cost"] or row["family"] == "none":
        return False
    equal = all(math.isclose(row[name], other[name], rel_tol=1e-9) for name in ("rms", "flip"))
    return equal and row["cost"] <= noise * other["cost"]


def _verdicts(key: Key, group: Sequence[Row], again: tuple[float, float]) -> list[Row]:
    """Return for each source's method which of ours comes nearest to beating it.

    In each of :data:`JUDGED` at each of :data:`PRICES`.
    """
    rows = {row["method"]: row for row in group}
    ours = [row for row in group if row["family"] in {"ours", "dial"}]
    theirs = [row for row in group if row["family"] == "source"]
    found = []
    for row, error, price in product(theirs, JUDGED, PRICES):
        one = next(iter(_points([row], error, price)), None)
        judged = verdict(one, _points(ours, error, price)) if one else None
        if one and judged:
            facts = {**named(key), "error": error, "price": price, **judged._asdict()}
            facts["counts"] = row["counts"] and rows[judged.ours]["counts"]
            noise = again if price == "cost" else (1.0, 1.0)
            facts["undecided"] = price == "cost" and undecided(
                one, _points(ours, error, price), noise
            )
            found.append({**facts, "beaten": judged.beaten})
    return found


def by_dial(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the methods of each dial in the order of its steps: a name ends in its dial's."""
    dials: dict[str, list[Row]] = {}
    for row in sorted((row for row in rows if row["step"]), key=lambda row: row["step"]):
        word = row["method"].split()[-1]
        dials.setdefault(word if word.endswith("s") else f"{word}s", []).append(row)
    return dials


def _dials(key: Key, group: Sequence[Row]) -> list[Row]:
    """Return how the error falls along each dial."""
    return [
        {**named(key), "dial": name, **_fall(rows)}
        for name, rows in by_dial(group).items()
        if len(rows) > 1
    ]


def _falls_where_known(name: str, rows: list[Row]) -> bool | None:
    known = [row[name] for row in rows if row[name] is not None]
    return falls(known) if len(known) > 1 else None


def _fall(rows: list[Row]) -> Row:
    sure = [row for row in rows if row["counts"]]
    return {
        "steps": [row["step"] for row in rows],
        "rms": [row["rms"] for row in rows],
        "slope": log_slope([r["step"] for r in rows], [r["rms"] for r in rows]),
        "steps_that_count": [row["step"] for row in sure],
        "slope_that_counts": log_slope([r["step"] for r in sure], [r["rms"] for r in sure]),
        "falls": falls([row["rms"] for row in rows]),
        "flicker_falls": _falls_where_known("flicker", rows),
    }


class Point(NamedTuple):
    """Cost and error of a method (less is better)."""

    name: str
    cost: float
    error: float


class Verdict(NamedTuple):
    """How one of ours stands against the method of a source.

    Parameters
    ----------
    ours
        The one that comes nearest to beating it (or beats it by most).
    factor
        The larger of both ratios, ours / theirs, of cost and of error: below 1, ours is both
        faster and closer; above, it fails by this factor.
    """

    theirs: str
    ours: str
    cost_ratio: float
    error_ratio: float
    factor: float

    @property
    def beaten(self) -> bool:
        """Return whether ours is both faster and closer."""
        return self.factor < 1


def front(points: Sequence[Point]) -> list[Point]:
    """Return the points that no other beats in one way without losing in the other, by cost.

    Of points that are equal in both, all stay.
    """
    found = [p for p in points if not any(_dominates(q, p) for q in points)]
    return sorted(found, key=lambda point: point.cost)


def verdict(theirs: Point, ours: Sequence[Point]) -> Verdict | None:
    """Compare a method with ours; None where there is none of ours."""
    found = [
        Verdict(theirs.name, each.name, *ratios, max(ratios))
        for each in ours
        for ratios in [(_ratio(each.cost, theirs.cost), _ratio(each.error, theirs.error))]
    ]
    return min(found, key=lambda each: each.factor, default=None)


def undecided(theirs: Point, ours: Sequence[Point], again: tuple[float, float]) -> bool:
    """Return whether the noise of costs alone could turn a verdict.

    Parameters
    ----------
    again
        Ratios of cost, around 1, between which the same work lies when it is timed twice.
    """
    closer = [_ratio(each.cost, theirs.cost) for each in ours if each.error < theirs.error]
    return any(ratio <= again[1] for ratio in closer) and not any(
        ratio < again[0] for ratio in closer
    )


def log_slope(steps: ArrayLike, errors: ArrayLike) -> float | None:
    """Return the least-squares slope of log error against log step; None below two points."""
    x, y = np.asarray(steps, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    usable = (x > 0) & (y > 0)
    if len(np.unique(x[usable])) < 2:
        return None
    return float(np.polyfit(np.log(x[usable]), np.log(y[usable]), 1)[0])


def falls(errors: Sequence[float]) -> bool:
    """Return whether each error is less than the one before."""
    return all(b < a for a, b in pairwise(errors))


def _dominates(a: Point, b: Point) -> bool:
    no_worse = a.cost <= b.cost and a.error <= b.error
    return no_worse and (a.cost < b.cost or a.error < b.error)


def _ratio(a: float, b: float) -> float:
    if b == 0:
        return 1.0 if a == 0 else float("inf")
    return a / b


Key: TypeAlias = tuple[str, str, str]
"""Scene, effect and lens."""


def key_of_row(row: dict[str, Any]) -> Key:
    """Return the key of a row."""
    return row["scene"], row["effect"], row["lens"]


def named(key: Key) -> dict[str, Any]:
    """Return the columns that say it."""
    return dict(zip(("scene", "effect", "lens"), key, strict=True))


def figure_name(key: Key) -> str:
    """Return the stem of a figure's files; motion blur alone has no lens."""
    scene, effect, lens = key
    return f"{scene}_{effect}" if effect == "motion_blur" else f"{scene}_{effect}_lens{lens}"


def title(key: Key) -> str:
    """Return a heading."""
    scene, effect, lens = key
    words = f"{scene}, {effect.replace('_', ' ')}"
    if effect == "motion_blur":
        return words
    return f"{words}, {'lens of an eye' if lens == 'eye' else f'lens {lens} %'}"
