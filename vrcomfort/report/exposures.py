"""One row of integer scores per exposure from questionnaires, with exclusions and reasons."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.report.asked import (
    Scorer,
    Unscored,
    check_timepoints,
    kept_by_the_experimenter,
    last_runs,
    left_out,
    timepoints_of,
)
from vrcomfort.report.baselines import Baselines, Values
from vrcomfort.report.facts import SAME_EXPOSURE, Facts, Row, RowKey
from vrcomfort.report.measures import Measure, possible_values
from vrcomfort.report.measuring import Beside, exposure_of, measured, unmeasured
from vrcomfort.report.outcomes import Outcome, items_of, known_outcomes, outcome_of_plan
from vrcomfort.report.planned import planned_exposures
from vrcomfort.report.possible import Possible

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from vrcomfort.questionnaire import Instrument, Sheet
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

Basis = Literal["difference_from_baseline", "raw_post", "measured"]
Found = TypeVar("Found")
COLUMNS = (
    "participant", "session", "number", "position", "timepoint", "condition", "scene", "part",
    "early", "sequence", "group",
)  # fmt: skip


@dataclass(frozen=True)
class Exposures:
    """Scored exposures.

    Parameters
    ----------
    outcomes
        Those of the plan that the data have, in the plan's order.
    absent
        Those that the data do not have → why.
    without_primary
        Sentences on the plan's primary outcome, where it is one of them; blank otherwise.
    units
        Outcome → points per integer step of its column.
    bases
        Outcome → what its scores are.
    possible
        Outcome → the values that it can have at one moment, in points.
    items
        Column of an item that scores are made of → its instrument, and its name.
    table
        One row per exposure with a usable questionnaire: `COLUMNS` (position in the session, or
        among all if sessions have one exposure each; early is 1 if the exposure was not finished),
        integer scores and items.
    recovery
        Same columns for the questionnaires after recovery; the condition is that of the session,
        if it had one.
    moments
        Same columns, without items, of raw scores at every timepoint of the plan. The baseline of
        an exposure has a row of its own, with the condition of the exposure.
    excluded
        Questionnaires left out, and why.
    planned_of
        Outcome → condition → exposures that a participant of the study has; see
        `planned_exposures`.
    people
        Participant → what participants.csv says.
    """

    outcomes: tuple[Outcome | Measure, ...]
    absent: dict[str, str]
    without_primary: str
    units: dict[str, float]
    bases: dict[str, Basis]
    possible: dict[str, Possible]
    items: dict[str, tuple[str, str]]
    table: pd.DataFrame
    recovery: pd.DataFrame
    moments: pd.DataFrame
    excluded: tuple[Unscored, ...]
    planned_of: dict[str, dict[str, int]]
    people: dict[str, dict[str, str]]
    found: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)
    """What was looked up in the tables before, by what it is; see `looked_up`."""

    def looked_up(self, key: tuple[Any, ...], look: Callable[[], Found]) -> Found:
        """Return the result of the first call of `look` for a key: tests need the same rows."""
        if key not in self.found:
            self.found[key] = look()
        there: Found = self.found[key]
        return there

    def possible_scores(self, outcome: str) -> Possible:
        """Return the values that the scores of an outcome can have, changes where they are some."""
        raw = self.possible[outcome]
        return raw.difference if self.bases[outcome] == "difference_from_baseline" else raw

    @property
    def titles(self) -> dict[str, str]:
        """Return outcome → title."""
        return {outcome.name: outcome.title for outcome in self.outcomes}

    @property
    def basis(self) -> Basis:
        """Return the basis of the first outcome with scores."""
        scores = (basis for basis in self.bases.values() if basis != "measured")
        return next(scores, "measured")

    @property
    def planned(self) -> dict[str, int]:
        """Return the planned exposures of the primary outcome."""
        return next(iter(self.planned_of.values()), {})


def column_of(scored: Exposures, table: pd.DataFrame, column: str) -> pd.Series:
    """Return a column of the exposures, or of participants.csv for the participant of each row."""
    if column in COLUMNS:
        return table[column].replace("", pd.NA)
    said = table["participant"].map(lambda who: scored.people.get(who, {}).get(column))
    return said.replace("", pd.NA)


def with_scores(table: pd.DataFrame, outcome: str) -> pd.DataFrame:
    """Return the rows that have a score."""
    return table[table[outcome].notna()]  # `dropna` takes five times as long


def score_exposures(study: StudyData, plan: Plan) -> Exposures:
    """Score every questionnaire on integer raw sums, minus the baseline where there is one.

    Nothing of a participant whom the experimenter has excluded is scored.

    Raises
    ------
    InputError
        If the plan's exposure timepoint is not in the data.
    """
    kept = kept_by_the_experimenter(study)
    others = [sheet for sheet in kept if sheet.keys["instrument"] not in plan.of_choices]
    check_timepoints(others, plan)
    wanted = outcomes_of_plan(study, plan)
    absent = {each.name: why for each in wanted if (why := _why_absent(study, plan, each))}
    outcomes = tuple(each for each in wanted if each.name not in absent)
    if not outcomes and others:
        reasons = "; ".join(f"{name}: {why}" for name, why in absent.items())
        raise plan.fault(f"the data have no outcome of the plan ({reasons})", "outcomes")
    work = _Work(study, plan, Facts.of(study, plan), outcomes)
    scores = [each for each in outcomes if isinstance(each, Outcome)]
    for instrument in dict.fromkeys(each.instrument for each in scores):
        work.add(
            [s for s in kept if s.keys["instrument"] == instrument], study.instruments[instrument]
        )
    for measure in (each for each in outcomes if isinstance(each, Measure)):
        work.measure(measure)
    return work.done(absent, _without_primary(wanted, absent))


def _without_primary(wanted: Iterable[Outcome | Measure], absent: Mapping[str, str]) -> str:
    """State that the planned primary outcome is not in the data, with reason and remedy."""
    primary = next(iter(wanted), None)
    if primary is None or primary.name not in absent:
        return ""
    return (
        f"The planned primary outcome ({primary.title}, {primary.name}) is not in the data: "
        f"{absent[primary.name]}. If it was asked, add its answers and report again; if not, the "
        "question of the plan has no answer here: the outcomes that follow are secondary, and "
        "none of them takes its place."
    )


def _why_absent(study: StudyData, plan: Plan, outcome: Outcome | Measure) -> str:
    """Say why the data do not have an outcome; nothing where they have it."""
    if isinstance(outcome, Measure):
        return ""
    instrument, moment = study.instruments[outcome.instrument], plan.exposure_timepoint
    if outcome.instrument not in study.instruments_at(moment):
        asked = {s.timepoint for s in study.sheets if s.keys["instrument"] == instrument.name}
        if asked:
            at = ", ".join(f"`{name}`" for name in sorted(asked))
            return f"the {instrument.short} was answered at {at}, and not at `{moment}`"
        have = sorted({study.instruments[s.keys["instrument"]].short for s in study.sheets})
        return f"the {instrument.short} was not answered; the data have the {', '.join(have)}"
    why = instrument.unscored.get(outcome.scale.name, "")
    return f"the {instrument.short} was asked as a short form, and {why}" if why else ""


def outcomes_of_plan(study: StudyData, plan: Plan) -> tuple[Outcome | Measure, ...]:
    """Return the outcomes that a plan names.

    Raises
    ------
    InputError
        If one is no score of any instrument, and no measure.
    """
    known = known_outcomes(study.instruments.values())
    found = []
    for index, name in enumerate(plan.outcomes):
        try:
            found.append(outcome_of_plan(name, known, plan.measures))
        except InputError as error:
            raise plan.fault(error.message, "outcomes", index) from None
    return tuple(found)


class _Work:
    """Collects the rows of all instruments."""

    def __init__(
        self,
        study: StudyData,
        plan: Plan,
        facts: Facts,
        outcomes: tuple[Outcome | Measure, ...],
    ) -> None:
        self._study, self._plan, self._facts = study, plan, facts
        self._outcomes = outcomes
        self._items: dict[str, tuple[str, str]] = {}
        self._excluded: list[Unscored] = []
        self._bases: dict[str, Basis] = {}
        self._planned: dict[str, dict[str, int]] = {}
        self._after: dict[RowKey, Row] = {}
        self._moments: dict[RowKey, Row] = {}

    def add(self, kept: list[Sheet], instrument: Instrument) -> None:
        """Score the sheets of one instrument."""
        plan = self._plan
        named = timepoints_of(plan)
        sheets = last_runs([s for s in kept if s.timepoint in named], plan, self._excluded)
        scores = tuple(each for each in self._outcomes if isinstance(each, Outcome))
        scorer = Scorer.of(instrument, scores, plan)
        scored = list(zip(sheets, scorer.values_of(sheets), strict=True))
        for sheet, values in scored:
            if values is None:
                self._excluded.append(left_out(sheet, scorer.refusal(sheet)))
        posts = [s for s in sheets if s.timepoint == plan.exposure_timepoint]
        before = [(s, v) for s, v in scored if s.timepoint == plan.baseline_timepoint]
        baselines = Baselines.of_sheets(
            [(sheet, values) for sheet, values in before if sheet.run or values is not None], posts
        )
        subtract = bool(before) and plan.scores == "difference_from_baseline"
        conditions = any(sheet.condition for sheet in posts)
        for sheet, values in scored:
            if values is not None and sheet.timepoint != plan.baseline_timepoint:
                self._row(sheet, values, baselines, subtract=subtract, conditions=conditions)
        met = [sheet for sheet in posts if sheet.condition or not conditions]
        planned = planned_exposures(self._study, plan, met, instrument.name)
        for outcome in scorer.outcomes:
            self._bases[outcome.name] = "difference_from_baseline" if subtract else "raw_post"
            self._planned[outcome.name] = planned
        names = items_of(instrument)
        self._items |= {c: (instrument.name, i) for c, i in zip(scorer.items, names, strict=True)}

    def _row(
        self,
        sheet: Sheet,
        values: Values,
        baselines: Baselines,
        *,
        subtract: bool,
        conditions: bool,
    ) -> None:
        exposed = sheet.timepoint == self._plan.exposure_timepoint
        if exposed and conditions and not sheet.condition:
            self._excluded.append(left_out(sheet, "no condition is given"))
            return
        row = self._facts.row(sheet)
        before = baselines.of(sheet)
        names = [each.name for each in self._outcomes if each.name in values]
        _put(self._moments, row, {name: values[name] for name in names})
        if exposed and before is not None:
            moment = row | {"timepoint": self._plan.baseline_timepoint}
            _put(self._moments, moment, {name: before[name] for name in names})
        if subtract and before is None:
            self._excluded.append(left_out(sheet, "no complete baseline to subtract"))
        elif exposed or sheet.timepoint == self._plan.recovery_timepoint:
            _put(self._after, row, _minus(values, before if subtract else None))

    def measure(self, measure: Measure) -> None:
        """Add a measure to the rows of its exposures, or as rows of its own."""
        timepoint = self._plan.exposure_timepoint
        met = []
        beside = [Beside(rows, timepoint) for rows in (self._after, self._moments)]
        for value in measured(self._study, self._plan, measure):
            if value.number is None:
                self._excluded.append(unmeasured(value, measure))
                continue
            exposure = exposure_of(value, timepoint)
            row = self._facts.row(exposure) | {"condition": value.condition}
            for rows in beside:
                rows.put(row, measure.name, value.number)
            met += [exposure] if value.condition else []
        self._bases[measure.name] = "measured"
        self._planned[measure.name] = planned_exposures(self._study, self._plan, met, "")

    def done(self, absent: dict[str, str], without_primary: str) -> Exposures:
        """Return the tables."""
        names = [each.name for each in self._outcomes if each.name in self._bases]
        rows, moments = list(self._after.values()), list(self._moments.values())
        steps = {name: _steps([*rows, *moments], name) for name in names}
        columns = [*COLUMNS, *names, *self._items]
        table = _table(_whole(rows, steps), columns)
        posts = table["timepoint"] == self._plan.exposure_timepoint
        return Exposures(
            outcomes=tuple(each for each in self._outcomes if each.name in names),
            absent=absent,
            without_primary=without_primary,
            units={o.name: o.unit / steps[o.name] for o in self._outcomes if o.name in names},
            bases={name: self._bases[name] for name in names},
            possible={
                o.name: possible_values(self._study, o)
                if isinstance(o, Measure)
                else Possible(float(o.scale.low), float(o.scale.high))
                for o in self._outcomes
                if o.name in names
            },
            items=dict(self._items),
            table=table[posts].reset_index(drop=True),
            recovery=table[~posts].reset_index(drop=True),
            moments=_table(_whole(moments, steps), [*COLUMNS, *names]),
            excluded=tuple(self._excluded),
            planned_of={name: self._planned[name] for name in names},
            people=self._facts.people,
        )


def _table(rows: list[Row], columns: list[str]) -> pd.DataFrame:
    """Return rows as a data frame with Python strings.

    Pandas' own strings take several times as long to walk through, and most of what is done with
    words here is to walk through them.
    """
    table = pd.DataFrame(rows, columns=columns)
    words = [name for name in columns if isinstance(table[name].dtype, pd.StringDtype)]
    return table.astype(dict.fromkeys(words, object))


def _put(rows: dict[RowKey, Row], row: Row, values: Values) -> None:
    """Add scores to the row of the same moment; instruments asked together share it."""
    rows.setdefault(tuple(row[name] for name in SAME_EXPOSURE), dict(row)).update(values)


def _minus(after: Values, before: Values | None) -> Values:
    if before is None:
        return after
    pairs = ((name, value, before[name]) for name, value in after.items())
    return {n: None if one is None or two is None else one - two for n, one, two in pairs}


def _steps(rows: Iterable[Row], name: str) -> int:
    """Return the steps to divide a raw sum by, so that all scores are whole: 1 unless prorated."""
    values = {row.get(name) for row in rows}
    return lcm(*(value.denominator for value in values if isinstance(value, Fraction)))


def _whole(rows: list[Row], steps: dict[str, int]) -> list[Row]:
    for row in rows:
        for name, times in steps.items():
            score = row.get(name)
            if score is not None and not isinstance(score, str):
                row[name] = int(score * times)
    return rows
