"""Survival analyses: time to a rating, and time to withdrawal."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.analyses.contract import MethodsParagraph
from vrcomfort.report.rated_exposures import ALL, COMPLETERS, UNKNOWN, WORST
from vrcomfort.report.rows import INLINE, Cells, as_json
from vrcomfort.stats.survival import (
    Cox,
    KaplanMeier,
    NoHazardRatioError,
    SurvivalAt,
    cox,
    kaplan_meier,
    log_rank,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from vrcomfort.report.rated_exposures import RatedExposure


@dataclass(frozen=True)
class TimeToEvent:
    """The time of an exposure to its event, or to its end (censored).

    Parameters
    ----------
    position
        Its place among the participant's exposures, from 1.
    came
        Whether the event came; otherwise the time is censored.
    """

    participant: str
    condition: str
    position: int
    time_s: float
    came: bool


@dataclass(frozen=True)
class SurvivalCurve:
    """The Kaplan–Meier estimates of one condition, or of all together (None)."""

    condition: str | None
    robust: bool
    """Whether errors allow for people with several exposures."""
    n: int
    came: int
    at: list[SurvivalAt]
    last_s: float
    median_s: float | None
    median_low_s: float | None
    median_high_s: float | None


@dataclass(frozen=True)
class PositionCount:
    """Exposures and events at one place among the exposures of people."""

    position: int
    n: int
    came: int


@dataclass(frozen=True)
class LogRankStatistics:
    """A log-rank test, with counts by group."""

    n: list[int]
    observed: list[int]
    expected: list[float]
    chi_square: float
    df: int
    p: float
    p_exact: float | None
    p_asymptotic: float


@dataclass(frozen=True)
class LogRankRow:
    """The log-rank test of some groups, or the reason for its absence."""

    by: str
    groups: list[str]
    within_people: bool
    not_tested: str | None
    found: LogRankStatistics | None = field(metadata=INLINE)


@dataclass(frozen=True)
class HazardRatios:
    """Hazard ratios of conditions against the reference, and of the position."""

    not_fitted: None
    left_out: list[str]
    model: Cox = field(metadata=INLINE)


@dataclass(frozen=True)
class NoHazardRatios:
    """The reason for the absence of hazard ratios, and the term it is about."""

    not_fitted: str
    term: str | None


@dataclass(frozen=True)
class SurvivalAnalysis:
    """Curves, log-rank tests and hazard ratios of one kind of event."""

    n: int
    people: int
    came: int
    repeated: bool
    """Whether people have several exposures."""
    curves: list[SurvivalCurve]
    by_position: list[PositionCount]
    log_rank: list[LogRankRow]
    cox: HazardRatios | NoHazardRatios

    @property
    def deciding(self) -> list[LogRankRow]:
        """Return the tests that decide: within people, where these come again."""
        return [row for row in self.log_rank if row.within_people == self.repeated]


def times_to_threshold(
    exposures: Iterable[RatedExposure], threshold: float, in_a_row: int = 1, *, how: str = ALL
) -> list[TimeToEvent]:
    """Return the time to the first ratings at a threshold or above.

    Parameters
    ----------
    in_a_row
        Successive ratings that have to be so high; see `RatingCourse.time_to`.
    how
        `all available`: withdrawals below it are censored. `completers`: they are left out.
        `worst case`: they count as reaching it.
    """
    found = []
    for e in exposures:
        reached = e.course.time_to(threshold, in_a_row=in_a_row, ended_s=e.ended_s)
        if reached is None or (how == COMPLETERS and e.left and not reached.reached):
            continue
        came = reached.reached or (how == WORST and e.left)
        found.append(TimeToEvent(e.participant, e.condition, e.position, reached.time_s, came))
    return found


def times_to_withdrawal(exposures: Iterable[RatedExposure]) -> list[TimeToEvent]:
    """Return the time to withdrawal, or to the stop rule, of the exposures of trials.csv.

    There is none where an import does not say how long each exposure was that nobody left: as left
    at once, it would count as none at risk.
    """
    known = [e for e in exposures if e.ending != UNKNOWN]
    if not all(e.ended_s for e in known if not e.left):
        return []
    return [TimeToEvent(e.participant, e.condition, e.position, e.ended_s, e.left) for e in known]


def curve_of(events: list[TimeToEvent], confidence: float, *, robust: bool) -> KaplanMeier:
    """Return the Kaplan–Meier curve of events."""
    people = [e.participant for e in events] if robust else None
    return kaplan_meier(
        [e.time_s for e in events], [e.came for e in events], people=people, confidence=confidence
    )


def repeated(events: Iterable[TimeToEvent]) -> bool:
    """Return whether a participant has several exposures."""
    people = [e.participant for e in events]
    return len(set(people)) < len(people)


def survival_analysis(
    events: list[TimeToEvent],
    conditions: list[str],
    pairs: list[tuple[str, str]],
    times_s: list[float],
    reference: str,
    confidence: float,
) -> SurvivalAnalysis:
    """Return curves, log-rank tests, and hazard ratios over those of the reference."""
    again = repeated(events)
    shown = [c for c in conditions if any(e.condition == c for e in events)]
    against = sorted(shown, key=lambda name: name != reference)
    return SurvivalAnalysis(
        n=len(events),
        people=len({e.participant for e in events}),
        came=sum(e.came for e in events),
        repeated=again,
        curves=[
            _curve(events, condition, times_s, confidence, robust=robust)
            for condition in [None, *(shown if len(shown) > 1 else [])]
            for robust in ([False, True] if again else [False])
        ],
        by_position=_by_position(events),
        log_rank=_log_ranks(events, shown, pairs),
        cox=_hazards(events, against, confidence),
    )


def _curve(
    events: list[TimeToEvent],
    condition: str | None,
    times_s: list[float],
    confidence: float,
    *,
    robust: bool,
) -> SurvivalCurve:
    mine = [e for e in events if condition in {None, e.condition}]
    curve = curve_of(mine, confidence, robust=robust)
    came = sum(e.came for e in mine)
    last_s = float(curve.times_s[-1])
    return SurvivalCurve(
        condition, robust, len(mine), came, curve.at(times_s), last_s, *curve.median_s()
    )


def _by_position(events: list[TimeToEvent]) -> list[PositionCount]:
    """Count by the place of the exposure among those of its participant."""
    return [
        PositionCount(
            position=place,
            n=sum(e.position == place for e in events),
            came=sum(e.came for e in events if e.position == place),
        )
        for place in sorted({e.position for e in events})
    ]


def _log_ranks(
    events: list[TimeToEvent], shown: list[str], pairs: list[tuple[str, str]]
) -> list[LogRankRow]:
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
) -> list[LogRankRow]:
    """Test groups as they are and, where people come again, within people."""
    rows = []
    for within in [False, True] if repeated(events) else [False]:
        strata = [e.participant for e in events] if within else None
        try:
            found = log_rank(
                [e.time_s for e in events],
                [e.came for e in events],
                [group(e) for e in events],
                strata=strata,
            )
        except InputError as error:
            rows.append(LogRankRow(by, names, within, error.message, None))
            continue
        # The test sorts its groups by name; rows have them in the order of the report.
        order = [found.groups.index(name) for name in names if name in found.groups]
        statistics = LogRankStatistics(
            n=[found.n[i] for i in order],
            observed=[found.observed[i] for i in order],
            expected=[found.expected[i] for i in order],
            chi_square=found.chi_square,
            df=found.df,
            p=found.p,
            p_exact=found.p_exact,
            p_asymptotic=found.p_asymptotic,
        )
        rows.append(LogRankRow(by, names, within, None, statistics))
    return rows


def _hazards(
    events: list[TimeToEvent], shown: list[str], confidence: float
) -> HazardRatios | NoHazardRatios:
    """Return hazard ratios of conditions against the first, with the position if it can be."""
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
        return NoHazardRatios(alone, None)
    # Where each condition has its own positions, both together have no estimate.
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
            reason = NoHazardRatios(error.message, term)
            continue
        return HazardRatios(None, left_out, model)
    return reason


def survival_tables(name: str, found: SurvivalAnalysis) -> dict[str, list[Cells]]:
    """Return name → lines of the CSV tables of one kind of event."""
    hazards = found.cox
    effects = hazards.model.effects if isinstance(hazards, HazardRatios) else {}
    tables: dict[str, list[Cells]] = {
        f"{name}_curves": [
            {"condition": curve.condition, "robust": curve.robust, "n": curve.n, **as_json(at)}
            for curve in found.curves
            for at in curve.at
        ],
        f"{name}_log_rank": [
            {
                key: " ".join(map(str, value)) if isinstance(value, list) else value
                for key, value in as_json(test).items()
            }
            for test in found.log_rank
        ],
        f"{name}_hazards": [{"term": term, **as_json(e)} for term, e in effects.items()],
        f"{name}_by_position": as_json(found.by_position),
    }
    return {title: lines for title, lines in tables.items() if lines}


def survival_paragraph(*, again: bool) -> MethodsParagraph:
    """Return the paragraph on survival analyses; `again`: people have several exposures."""
    text = (
        "Times to events are Kaplan–Meier (1958) estimates with Greenwood’s standard error and "
        "log–log intervals (Borgan & Liestøl, 1990). Conditions were compared with log-rank tests "
        "(Mantel, 1966), which are exact for two groups where all permutations can be listed. "
        "Hazard ratios of condition and order (Cox, 1972; ties after Efron, 1977) are descriptive: "
        "with few participants their test rejects too often, so none is given."
    )
    cited = ["kaplan_1958", "borgan_1990", "mantel_1966", "cox_1972", "efron_1977"]
    if again:
        text += (
            " As participants have several exposures, log-rank tests are stratified by "
            "participant, and standard errors of curves are robust to that (Lin & Wei, 1989)."
        )
        cited.append("lin_1989")
    return MethodsParagraph("Time to events", text, tuple(cited))
