"""Leaves out the participants and exposures that the rules of a plan name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.csv_table import number_or_none
from vrcomfort.records.names import natural
from vrcomfort.report.study_data import length_s
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Exclusion, Plan
    from vrcomfort.report.study_data import StudyData

Key = tuple[str, str, str]
"""Participant, session and number of an exposure."""
PERSON = "participant"
"""What is excluded where it is somebody with all exposures."""


@dataclass(frozen=True)
class ExcludedByRule:
    """A participant, or an exposure, that a rule of the plan leaves out."""

    rule: str
    participant: str
    what: str
    reason: str

    @property
    def is_person(self) -> bool:
        """Return whether it is the participant with all exposures."""
        return self.what == PERSON


@dataclass(frozen=True)
class AppliedRule:
    """A rule of the plan in words, and how many participants or exposures it leaves out."""

    name: str
    text: str
    reason: str
    excluded: int


def apply_rules(
    scored: Exposures, study: StudyData, plan: Plan
) -> tuple[Exposures, list[ExcludedByRule]]:
    """Return the remaining scores, and one row per exclusion.

    Raises
    ------
    InputError
        If a rule goes by something that the data do not have.
    """
    found: list[ExcludedByRule] = []
    gone: set[Key] = set()
    for index, rule in enumerate(plan.exclusions):
        _check(rule, index, scored, study, plan)
        for key, why in _hits(rule, scored, study, plan):
            whole = rule.removes == "participant"
            what = PERSON if whole else f"session {key[1]}, exposure {key[2]}"
            row = ExcludedByRule(rule.name, key[0], what, why)
            if row not in found:
                found.append(row)
            gone.add((key[0], "", "") if whole else key)
    found.sort(key=lambda row: natural(row.participant))
    return _without(scored, gone), found


def rules_in_words(
    plan: Plan, scored: Exposures, found: Sequence[ExcludedByRule]
) -> list[AppliedRule]:
    """Return each rule, and how many rows of `apply_rules` are due to it."""
    return [
        AppliedRule(
            rule.name,
            _in_words(rule, plan, scored),
            rule.reason,
            excluded=sum(row.rule == rule.name for row in found),
        )
        for rule in plan.exclusions
    ]


def _check(rule: Exclusion, index: int, scored: Exposures, study: StudyData, plan: Plan) -> None:
    if rule.score and rule.score not in scored.units:
        known = did_you_mean(rule.score, scored.units)
        message = f"rule `{rule.name}` goes by score `{rule.score}`, which is no outcome; {known}"
        raise plan.fault(message, "exclusions", index, "score")
    columns = {name for person in study.participants for name in person}
    if rule.column and rule.column not in columns:
        message = f"`{rule.column}` is not a column of participants.csv"
        raise plan.fault(f"{message}; {did_you_mean(rule.column, columns)}", "exclusions", index)


def _hits(
    rule: Exclusion, scored: Exposures, study: StudyData, plan: Plan
) -> Iterator[tuple[Key, str]]:
    """Yield the exposures, or people, that a rule meets."""
    if rule.participants:
        there = {sheet.participant for sheet in study.sheets}
        for who in rule.participants:
            if who in there:
                yield (who, "", ""), rule.reason or "named by the plan"
    elif rule.score:
        yield from _by_score(rule, scored, plan)
    elif rule.trial:
        for trial in study.trials:
            value = _measure(trial, rule.trial)
            if value is not None and _outside(rule, value):
                key = (trial["participant"], trial["session"], trial["trial"])
                yield key, f"{rule.trial} is {value:.6g}"
    else:
        for person in study.participants:
            text = person.get(rule.column, "")
            if text and (text in rule.equals or _outside(rule, number_or_none(text))):
                yield (person["participant"], "", ""), f"{rule.column} is {text}"


def _by_score(rule: Exclusion, scored: Exposures, plan: Plan) -> Iterator[tuple[Key, str]]:
    timepoint = rule.timepoint or plan.exposure_timepoint
    rows = scored.moments[scored.moments["timepoint"] == timepoint].dropna(subset=[rule.score])
    title = scored.titles[rule.score]
    for row in rows.to_dict("records"):
        value = float(row[rule.score]) * scored.units[rule.score]
        if _outside(rule, value):
            key = (str(row["participant"]), str(row["session"]), str(row["number"]))
            yield key, f"{title} at {timepoint} is {value:.6g}"


def _measure(trial: dict[str, str], name: str) -> float | None:
    """Return a measure of a trial; None where it was not recorded."""
    if name == "length_s":
        return length_s(trial)
    if name == "dropped_percent":
        frames, dropped = (
            number_or_none(trial.get("frames", "")),
            number_or_none(trial.get("dropped", "")),
        )
        return 100 * dropped / frames if frames and dropped is not None else None
    return number_or_none(trial.get(name, ""))


def _outside(rule: Exclusion, value: float | None) -> bool:
    if value is None:
        return False
    return (rule.above is not None and value > rule.above) or (
        rule.below is not None and value < rule.below
    )


def _without(scored: Exposures, gone: set[Key]) -> Exposures:
    def left(table: pd.DataFrame) -> pd.DataFrame:
        keys = zip(table["participant"], table["session"], table["number"], strict=True)
        keep = [key not in gone and (key[0], "", "") not in gone for key in keys]
        return table[np.array(keep, dtype=bool)].reset_index(drop=True)

    if not gone:
        return scored
    return replace(
        scored,
        table=left(scored.table),
        recovery=left(scored.recovery),
        moments=left(scored.moments),
    )


def _in_words(rule: Exclusion, plan: Plan, scored: Exposures) -> str:
    what = "participants" if rule.removes == "participant" else "exposures"
    if rule.participants:
        return f"participants {', '.join(rule.participants)}"
    if rule.score:
        by = f"{scored.titles[rule.score]} at {rule.timepoint or plan.exposure_timepoint}"
    else:
        by = rule.trial or rule.column
    limits = [f"above {rule.above:g}"] if rule.above is not None else []
    limits += [f"below {rule.below:g}"] if rule.below is not None else []
    limits += [f"equal to {' or '.join(rule.equals)}"] if rule.equals else []
    return f"{what} with {by} {' or '.join(limits)}"
