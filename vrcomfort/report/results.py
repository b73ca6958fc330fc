"""The whole analysis as one record: the content of results.json."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from vrcomfort import __version__
from vrcomfort.json_text import json_of
from vrcomfort.records.names import natural
from vrcomfort.report.analyses import AnalysisData, analysed_people, run_analyses
from vrcomfort.report.analyses.comparisons import COMPARISONS
from vrcomfort.report.analyses.contract import SectionData
from vrcomfort.report.analyses.signed_rank import TESTS
from vrcomfort.report.answering import answering
from vrcomfort.report.asked import unused_timepoints
from vrcomfort.report.contrasts import check_groups, conditions_of, contrasts_of
from vrcomfort.report.decisions import decide_all
from vrcomfort.report.derived_plan import with_outcomes
from vrcomfort.report.descriptives import describe_all, describe_recovery
from vrcomfort.report.deviations import deviations
from vrcomfort.report.exclusions import apply_rules, rules_in_words
from vrcomfort.report.exposures import score_exposures
from vrcomfort.report.factors import check_columns, check_levels
from vrcomfort.report.flow import participant_flow
from vrcomfort.report.measures import Measure, definition_of
from vrcomfort.report.notices import notices
from vrcomfort.report.orders import counterbalancing
from vrcomfort.report.outcomes import Outcome
from vrcomfort.report.plan_files import in_order
from vrcomfort.report.quality import quality
from vrcomfort.report.rows import INLINE, as_json, rounded
from vrcomfort.report.sensitivity import sensitivity, smallest_effects
from vrcomfort.report.stimulus_time import frame_measures, movement, stimulus_time
from vrcomfort.report.study_data import conditions_in
from vrcomfort.report.symptoms import recovery_rows, symptom_rows
from vrcomfort.report.vocabulary import (
    ReportedCondition,
    ReportedInstrument,
    ReportedItem,
    ReportedOutcome,
    Vocabulary,
)
from vrcomfort.report.withdrawals import (
    count_withdrawals,
    everybody,
    find_withdrawals,
    sequences,
    why_not,
)
from vrcomfort.stats.means import RESAMPLES, SEED

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

    import pandas as pd
    from _typeshed import DataclassInstance

    from vrcomfort.questionnaire import Instrument
    from vrcomfort.records.recording import Memory
    from vrcomfort.report.analyses import Rows
    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.answering import AnsweringPatterns
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.decisions import AdjustedFamily
    from vrcomfort.report.descriptives import DescribedRow, RecoveryScores
    from vrcomfort.report.deviations import Deviation
    from vrcomfort.report.exclusions import AppliedRule, ExcludedByRule
    from vrcomfort.report.exposures import Basis, Exposures
    from vrcomfort.report.flow import FlowStage
    from vrcomfort.report.orders import Counterbalancing
    from vrcomfort.report.pairs import Tested
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.quality import Quality
    from vrcomfort.report.sections import Section
    from vrcomfort.report.sensitivity import RepeatedTest, SmallestEffectRow
    from vrcomfort.report.stimulus_time import ConditionMovement, ConditionTime, FrameMeasures
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.symptoms import RecoveryRow, SymptomRow
    from vrcomfort.report.withdrawals import (
        MissingParticipant,
        SequenceCounts,
        WithdrawalCounts,
    )

SOFTWARE = ("numpy", "scipy", "pandas", "pingouin")
SCHEMA = 2
"""Version of the layout of results.json."""
PLAN_FILE = "plan.toml"


@dataclass(frozen=True)
class ReportedStudy:
    """Title and protocol of the study, and the folder or file that was read."""

    title: str
    protocol: str | None
    source: str = ""


@dataclass(frozen=True)
class Bootstrap:
    """How intervals of means are resampled."""

    resamples: int = RESAMPLES
    seed: int = SEED


@dataclass(frozen=True)
class RandomSeed:
    """A seed, and its use."""

    what: str
    seed: int
    resamples: int


@dataclass(frozen=True)
class Participants:
    """Participants in the analysis, and those excluded.

    Parameters
    ----------
    n
        Everybody whom any file names.
    analysed
        Those in at least one test.
    left_out, in_some_tests
        Those in none, and in some but not all; with reasons.
    """

    n: int
    analysed: tuple[str, ...]
    left_out: tuple[MissingParticipant, ...]
    in_some_tests: tuple[MissingParticipant, ...]
    exposures_per_condition: dict[str, int]
    sequences: tuple[SequenceCounts, ...]


@dataclass(frozen=True)
class Results:
    """Everything that a report says, in the order of results.json.

    Parameters
    ----------
    without_primary
        That the planned primary outcome is not in the data; None where it is.
    score_basis
        What the scores of the first outcome are.
    weights
        Outcome → points per step.
    labels
        Label of every condition, and of every other side of a contrast.
    of_tests, of_models
        Rows of the analyses by key: tests and their like; models and analyses of order.
    sections
        What the analyses with a section of their own found, by key.
    files
        Every file of the report.
    """

    without_primary: str | None
    schema: int
    software: dict[str, str]
    study: ReportedStudy
    plan: Plan
    deviations: list[Deviation]
    bootstrap: Bootstrap
    seeds: tuple[RandomSeed, ...]
    outcomes: tuple[ReportedOutcome, ...]
    instruments: tuple[ReportedInstrument, ...]
    score_basis: Basis
    weights: dict[str, float]
    conditions: tuple[ReportedCondition, ...]
    labels: dict[str, str]
    participants: Participants
    exclusion_rules: list[AppliedRule]
    exclusions: list[ExcludedByRule]
    notices: list[str]
    families: list[AdjustedFamily]
    of_tests: Rows = field(metadata=INLINE)
    sensitivity: list[RepeatedTest]
    smallest_effects: list[SmallestEffectRow]
    descriptives: list[DescribedRow]
    recovery: list[RecoveryScores]
    of_models: Rows = field(metadata=INLINE)
    withdrawals: WithdrawalCounts
    quality: Quality
    flow: list[FlowStage]
    symptoms: list[SymptomRow]
    recovery_course: list[RecoveryRow]
    counterbalancing: Counterbalancing | None
    answering: AnsweringPatterns
    stimulus_time: list[ConditionTime]
    movement: list[ConditionMovement]
    frame_measures: list[FrameMeasures]
    sections: Mapping[str, DataclassInstance | None] = field(metadata=INLINE)
    date: str = ""
    files: tuple[str, ...] = ()

    @property
    def rows(self) -> Rows:
        """Return the rows of all analyses by key."""
        return {**self.of_tests, **self.of_models}

    @property
    def tests(self) -> Sequence[SignedRankRow]:
        """Return the signed-rank tests."""
        return TESTS.of(self.of_tests)

    @property
    def comparisons(self) -> Sequence[ComparisonRow]:
        """Return the comparisons by other tests."""
        return COMPARISONS.of(self.of_tests)

    def __getitem__(self, key: str) -> Any:
        """Return the rows of an analysis, or the results of a section, as templates name them."""
        return {**self.rows, **self.sections}[key]

    @property
    def vocabulary(self) -> Vocabulary:
        """Return the names of conditions, outcomes and questions for readers."""
        return Vocabulary.of(
            self.conditions, self.labels, self.outcomes, self.instruments, self.study.protocol
        )

    def for_sections(self, study: StudyData, memory: Memory | None = None) -> SectionData:
        """Return the input of the analyses with a section of their own."""
        tests = [test for test in self.tests if not any(side.timepoint for side in test.sides)]
        return SectionData(
            study=study,
            plan=self.plan,
            conditions=[each.name for each in self.conditions],
            labels=self.labels,
            pairs=list(dict.fromkeys((test.a, test.b) for test in tests)),
            exclusions=self.exclusions,
            memory=memory,
        )

    def with_sections(self, sections: Iterable[Section]) -> Results:
        """Return the results with those of the analyses that have a section of their own."""
        found: dict[str, DataclassInstance | None] = {}
        labels, reading = dict(self.labels), list(self.quality.reading)
        for section in sections:
            found |= section.results
            for name in section.conditions:
                labels.setdefault(name, name)
            reading += section.notes
        quality = replace(self.quality, reading=tuple(reading))
        return replace(self, sections=found, labels=labels, quality=quality)


@cache
def _software() -> dict[str, str]:
    """Look the versions up: once, for that reads the files of many packages."""
    return {"vrcomfort": __version__, **{name: version(name) for name in SOFTWARE}}


def analyse(study: StudyData, plan: Plan) -> tuple[Results, Exposures]:
    """Make every analysis of a plan, but those with a section of their own.

    Returns
    -------
    Results, Exposures
        The results, and the scores they come from.
    """
    plan = with_outcomes(plan, study)
    scored, exclusions = apply_rules(score_exposures(study, plan), study, plan)
    data = _analysis_data(study, scored, plan)
    made = decide_all(data, run_analyses(data))
    tests = TESTS.of(made.rows)
    compared: list[Tested] = [*tests, *COMPARISONS.of(made.rows)]
    names, labels, repeated = _named(data), _labels(data), sensitivity(data, tests)
    people = _participants(data, analysed_people(made.rows), exclusions)
    results = Results(
        without_primary=scored.without_primary or None,
        schema=SCHEMA,
        software=dict(_software()),
        study=ReportedStudy(study.title, study.protocol),
        plan=plan,
        deviations=deviations(data, made.rows, labels),
        bootstrap=Bootstrap(),
        seeds=(RandomSeed("bootstrap-t of means", SEED, RESAMPLES),),
        outcomes=_outcomes(scored),
        instruments=_instruments(scored, study),
        score_basis=scored.basis,
        weights=dict(scored.units),
        conditions=tuple(ReportedCondition(c, study.labels.get(c, c)) for c in names),
        labels=labels,
        participants=people,
        exclusion_rules=rules_in_words(plan, scored, exclusions),
        exclusions=exclusions,
        notices=notices(
            study, scored, plan, tests, COMPARISONS.of(made.rows), repeated, exclusions
        ),
        families=made.families,
        of_tests=made.of("primary", "tests"),
        sensitivity=repeated,
        smallest_effects=smallest_effects(plan, tests),
        descriptives=describe_all(scored, plan, data.conditions, compared),
        recovery=describe_recovery(scored),
        of_models=made.of("models", "order"),
        withdrawals=count_withdrawals(study, data.withdrawals),
        quality=quality(study, scored, plan, unused_timepoints(study, plan)),
        flow=participant_flow(
            study,
            scored,
            plan,
            data.withdrawals,
            people.analysed,
            len(people.analysed) - len(people.in_some_tests),
        ),
        symptoms=symptom_rows(scored, names, tests, study.instruments),
        recovery_course=recovery_rows(scored),
        counterbalancing=counterbalancing(scored.table, names, people.analysed),
        answering=answering(study),
        stimulus_time=stimulus_time(study, names),
        movement=movement(study, names),
        frame_measures=frame_measures(study),
        sections={},
    )
    return rounded(results), scored


def _analysis_data(study: StudyData, scored: Exposures, plan: Plan) -> AnalysisData:
    """Return the input of analyses; the plan is checked against the data."""
    conditions = conditions_of(scored, study.labels)
    asked = conditions_in(study, plan.exposure_timepoint)
    there = list(dict.fromkeys([*conditions, *study.labels, *asked]))
    check_groups(plan, scored)
    every = contrasts_of(plan, conditions, there)
    check_columns(plan, scored)
    check_levels(plan, scored, study.labels)
    found = find_withdrawals(study)
    reference = _reference([each for each in every if each.test == "signed_rank"], conditions)
    return AnalysisData(study, scored, plan, conditions, reference, every, found, complete=False)


def _participants(
    data: AnalysisData, tested: list[Collection[str]], exclusions: Sequence[ExcludedByRule]
) -> Participants:
    """Return analysed and excluded participants; `tested` has the participants of each test."""
    study, scored, left = data.study, data.scored, data.withdrawals
    analysed = _analysed(tested, scored.table)
    in_every_test = set(analysed).intersection(*(people for people in tested if people))
    reasons = why_not(study, scored, left, exclusions, in_every_test=in_every_test)
    return Participants(
        n=len(everybody(study)),
        analysed=tuple(analysed),
        left_out=tuple(row for row in reasons if row.participant not in analysed),
        in_some_tests=tuple(row for row in reasons if row.participant in analysed),
        exposures_per_condition=scored.planned,
        sequences=tuple(sequences(study, analysed, left)),
    )


def _outcomes(scored: Exposures) -> tuple[ReportedOutcome, ...]:
    return tuple(
        ReportedOutcome(
            name=each.name,
            title=each.title,
            instrument=each.instrument,
            unit=scored.units[each.name],
            basis=scored.bases[each.name],
            parts=each.parts,
            unit_label=each.unit_label,
            better=each.better,
            definition=definition_of(each) if isinstance(each, Measure) else "",
            low=scored.possible[each.name].low,
            high=scored.possible[each.name].high,
        )
        for each in scored.outcomes
    )


def _instruments(scored: Exposures, study: StudyData) -> tuple[ReportedInstrument, ...]:
    names = dict.fromkeys(o.instrument for o in scored.outcomes if isinstance(o, Outcome))
    return tuple(
        ReportedInstrument(
            name=each.name,
            short=each.short,
            title=each.title,
            citation=each.citation,
            rule=each.rule,
            asks=each.asks,
            answers=_answers_in_words(each),
            low=each.low,
            high=each.high,
            items=tuple(ReportedItem(item.name, item.text) for item in each.asked),
        )
        for each in map(study.instruments.__getitem__, names)
    )


def _answers_in_words(instrument: Instrument) -> str:
    alike = all(item.answers == instrument.answers for item in instrument.asked)
    return instrument.answers.in_words if alike else "each with its own answers"


def _named(data: AnalysisData) -> list[str]:
    """Return the conditions of the report, with compared ones that no participant finished."""
    sides = [side for each in data.contrasts for side in (each.a, each.b)]
    compared = [side.condition for side in sides if side.condition]
    return list(dict.fromkeys([*data.conditions, *compared]))


def _labels(data: AnalysisData) -> dict[str, str]:
    """Return the label of every condition, and of every other side of a contrast."""
    labels = data.study.labels
    found = {name: labels.get(name, name) for name in _named(data)}
    for side in (side for each in data.contrasts for side in (each.a, each.b)):
        condition = labels.get(side.condition, side.condition)
        parts = [part for part in (side.level, condition, side.timepoint) if part]
        found.setdefault(side.name, ", ".join(parts))
    return found


def _reference(contrasts: list[Compared], conditions: list[str]) -> str:
    """Return the reference condition of models: b of the only contrast, or the first."""
    if len(contrasts) == 1 and contrasts[0].b.condition in conditions:
        return contrasts[0].b.condition
    return next(iter(conditions), "")


def _analysed(tests: list[Collection[str]], table: pd.DataFrame) -> list[str]:
    """Return the participants of all tests; all with a score if there is nothing to test."""
    tested = {name for people in tests for name in people}
    return sorted(tested if tests else table["participant"].unique(), key=natural)


def results_json(results: Results) -> str:
    """Return the text of results.json."""
    plan = results.plan
    said = {**in_order(plan), "sha256": plan.sha256, "file": PLAN_FILE}
    return json_of(as_json(results) | {"plan": rounded(said)}) + "\n"
