"""Survival analyses: time to a rating, and time to withdrawal."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.stats.survival import KaplanMeier, NoHazardRatioError, cox, kaplan_meier, log_rank

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from vrcomfort.report.courses.exposures import RatedExposure


Row = dict[str, Any]
ALL = "all available"


@dataclass(frozen=True)
class TimeToEvent:
    """An exposure until its event, or until it was watched no longer."""

    participant: str
    condition: str
    position: int
    time_s: float
    came: bool


def of_threshold(
    exposures: Iterable[RatedExposure], threshold: float, *, how: str = ALL
) -> list[TimeToEvent]:
    """Return the time to the first rating at a threshold or above.

    Parameters
    ----------
    how
        `all available`: who left below it was watched until then. `completers`: those exposures
        are left out. `worst case`: leaving counts as reaching it.
    """
    found = []
    for e in exposures:
        reached = e.course.time_to(threshold, ended_s=e.ended_s)
        if reached is None or (how == "completers" and e.left and not reached.reached):
            continue
        came = reached.reached or (how == "worst case" and e.left)
        found.append(TimeToEvent(e.participant, e.condition, e.position, reached.time_s, came))
    return found


def of_leaving(exposures: Iterable[RatedExposure]) -> list[TimeToEvent]:
    """Return the time to leaving of every exposure that trials.csv has."""
    return [
        TimeToEvent(e.participant, e.condition, e.position, e.ended_s, e.left)
        for e in exposures
        if e.ending != "not recorded"
    ]


def curve_of(events: list[TimeToEvent], confidence: float, *, robust: bool) -> KaplanMeier:
    """Return the Kaplan–Meier curve of events."""
    people = [e.participant for e in events] if robust else None
    return kaplan_meier(
        [e.time_s for e in events], [e.came for e in events], people=people, confidence=confidence
    )


def repeated(events: Iterable[TimeToEvent]) -> bool:
    """Return whether anybody is there more than once."""
    people = [e.participant for e in events]
    return len(set(people)) < len(people)


def event_results(
    events: list[TimeToEvent],
    conditions: list[str],
    pairs: list[tuple[str, str]],
    times_s: list[float],
    reference: str,
    confidence: float,
) -> Row:
    """Return curves, log-rank tests, and hazard ratios over those of the reference."""
    again = repeated(events)
    shown = [c for c in conditions if any(e.condition == c for e in events)]
    against = sorted(shown, key=lambda name: name != reference)
    return {
        "n": len(events),
        "people": len({e.participant for e in events}),
        "came": sum(e.came for e in events),
        "repeated": again,
        "curves": [
            _curve(events, condition, times_s, confidence, robust=robust)
            for condition in [None, *(shown if len(shown) > 1 else [])]
            for robust in ([False, True] if again else [False])
        ],
        "by_position": _by_position(events),
        "log_rank": _log_ranks(events, shown, pairs),
        "cox": _hazards(events, against, confidence),
    }


def _curve(
    events: list[TimeToEvent],
    condition: str | None,
    times_s: list[float],
    confidence: float,
    *,
    robust: bool,
) -> Row:
    mine = [e for e in events if condition in {None, e.condition}]
    curve = curve_of(mine, confidence, robust=robust)
    median, low, high = curve.median_s()
    return {
        "condition": condition,
        "robust": robust,
        "n": len(mine),
        "came": sum(e.came for e in mine),
        "at": [asdict(row) for row in curve.at(times_s)],
        "last_s": float(curve.times_s[-1]),
        "median_s": median,
        "median_low_s": low,
        "median_high_s": high,
    }


def _by_position(events: list[TimeToEvent]) -> list[Row]:
    """Count by the place of the exposure among those of its participant."""
    return [
        {
            "position": place,
            "n": sum(e.position == place for e in events),
            "came": sum(e.came for e in events if e.position == place),
        }
        for place in sorted({e.position for e in events})
    ]


def _log_ranks(
    events: list[TimeToEvent], shown: list[str], pairs: list[tuple[str, str]]
) -> list[Row]:
    """Return the test of all conditions, of each planned pair, and of positions."""
    whole = [shown] if len(shown) > 2 else []
    asked = [*whole, *([a, b] for a, b in pairs if a in shown and b in shown)]
    if not asked and len(shown) == 2:
        asked = [shown]
    rows = []
    for names in asked:
        mine = [e for e in events if e.condition in names]
        rows += _tests("condition", mine, lambda e: e.condition, names)
    places = [f"{place}" for place in sorted({e.position for e in events})]
    if len(places) > 1:
        rows += _tests("position", events, lambda e: str(e.position), places)
    return rows


def _tests(
    by: str, events: list[TimeToEvent], group: Callable[[TimeToEvent], str], names: list[str]
) -> list[Row]:
    """Test groups as they are and, where people come again, within people."""
    rows = []
    for within in [False, True] if repeated(events) else [False]:
        strata = [e.participant for e in events] if within else None
        row: Row = {"by": by, "groups": names, "within_people": within, "not_tested": None}
        try:
            found = log_rank(
                [e.time_s for e in events],
                [e.came for e in events],
                [group(e) for e in events],
                strata=strata,
            )
        except InputError as error:
            rows.append({**row, "not_tested": error.message})
            continue
        order = [found.groups.index(name) for name in names if name in found.groups]
        rows.append(
            {
                **row,
                "n": [found.n[i] for i in order],
                "observed": [found.observed[i] for i in order],
                "expected": [found.expected[i] for i in order],
                "chi_square": found.chi_square,
                "df": found.df,
                "p": found.p,
            }
        )
    return rows


def _hazards(events: list[TimeToEvent], shown: list[str], confidence: float) -> Row:
    """Return hazard ratios of conditions against the first, with and without the position."""
    levels = shown[1:]
    places = len({e.position for e in events}) > 1
    columns: dict[str, np.ndarray[Any, Any]] = {
        f"condition: {level} − {shown[0]}": np.array([e.condition == level for e in events])
        for level in levels
    }
    if places:
        columns["position"] = np.array([e.position for e in events], dtype=np.float64)
    if not columns:
        alone = "there is one condition in one position, so nothing is compared"
        return {"not_fitted": alone, "term": None}
    for left_out in ([], ["position"]) if places and levels else ([],):
        kept = {name: values for name, values in columns.items() if name not in left_out}
        try:
            model = cox(
                [e.time_s for e in events],
                [e.came for e in events],
                kept,
                people=[e.participant for e in events],
                confidence=confidence,
            )
        except InputError as error:
            term = error.term if isinstance(error, NoHazardRatioError) else None
            reason = {"not_fitted": error.message, "term": term}
            continue
        return {"not_fitted": None, "left_out": left_out, **asdict(model)}
    return reason
