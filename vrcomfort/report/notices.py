"""Notices to read before any number, on the terminal and at the top of the page."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from vrcomfort.csv_table import whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.importing.rows import alike
from vrcomfort.plurals import counted
from vrcomfort.records.apparatus import KEYS, differences
from vrcomfort.records.names import natural
from vrcomfort.report.decision_notices import decision_notices
from vrcomfort.report.orders import in_words
from vrcomfort.report.plausibility import plausibility_warnings, some_of
from vrcomfort.report.rated_exposures import rated_exposures
from vrcomfort.report.ratings.survival import times_to_withdrawal
from vrcomfort.report.sensitivity import WORST_RANK
from vrcomfort.report.study_data import short_forms
from vrcomfort.report.withdrawals import early_endings, everybody, find_withdrawals
from vrcomfort.report.words import p_equals
from vrcomfort.stats.survival import log_rank

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.exclusions import ExcludedByRule
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.orders import OneOrder
    from vrcomfort.report.pairs import Side
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.sensitivity import RepeatedTest
    from vrcomfort.report.study_data import StudyData

DROPPED_APART_PERCENT = 1.0
"""Percentage points of dropped frames between two conditions, or scenes, that are told."""
TOLERATED_LOSS = 0.1
"""Share of the people of a comparison who may be missing from its test without a notice."""
# A single withdrawal is always under one condition.
FEWEST_LEFT = 2
ONE_SIDED = 0.75
"""Share of those who left, from which on a condition is named under which they did."""


def notices(
    study: StudyData,
    scored: Exposures,
    plan: Plan,
    tests: Sequence[SignedRankRow],
    comparisons: Sequence[ComparisonRow],
    repeated: Sequence[RepeatedTest],
    exclusions: Sequence[ExcludedByRule],
) -> list[str]:
    """Return the sentences, without their full stops, those that change the answer first.

    `repeated` are the tests of other analysis sets.
    """
    return [
        *_planned_number(study, plan),
        *_short_forms(study),
        *plausibility_warnings(study, plan.of_choices),
        *decision_notices(scored, plan, [*tests, *comparisons], study.labels),
        *_left_under_one(study, tests, repeated),
        *_never_met(study, tests),
        *_losses(study, tests, exclusions),
        *_ended_early(study),
        *_screened(study),
        *_shortened(study),
        *_unbalanced(study),
        *differences(each.model_dump(include=KEYS) for each in study.manifests),
        *_repeated(scored),
        *_suspect_names(study),
        *_confounded(study, tests),
        *_dropped_with(study),
    ]


def _shortened(study: StudyData) -> list[str]:
    """Say that exposures were shown for less than the protocol's time: so are times in them."""
    shown = [each.exposure_override_s for each in study.manifests]
    lengths = sorted({each for each in shown if each is not None})
    if not lengths:
        return []
    sessions = sum(each in lengths for each in shown)
    of_sessions = counted(sessions, "sessions")
    told = " and ".join(f"{each:g} s" for each in lengths)
    return [
        f"Exposures of {of_sessions} were shortened to {told} at most (--exposure-s): the times of "
        "ratings, endings and movements are those of the shortened exposures"
    ]


def _unbalanced(study: StudyData) -> list[str]:
    """Say that the orders need not balance, where the protocol allows it."""
    orders = [each.settings.order for each in study.manifests]
    if not any(each is not None and each.unbalanced for each in orders):
        return []
    return [
        "The protocol lets orders be unbalanced: a condition may stand in some positions more "
        "often than another, and differences may partly be those of order (see Order of the "
        "conditions)"
    ]


def _planned_number(study: StudyData, plan: Plan) -> list[str]:
    """Say that fewer people than planned are there."""
    there = len(everybody(study))
    if plan.participants is None or there >= plan.participants:
        return []
    return [f"{there} of {plan.participants} planned participants are in the data"]


def _short_forms(study: StudyData) -> list[str]:
    """Say which questionnaires are short forms, and which of their scores there are."""
    found = []
    for instrument in short_forms(study):
        titles = {each.name: each.title for each in instrument.scales}
        lost = ", ".join(name.replace("_", " ") for name in instrument.not_asked)
        said = f"the {instrument.short} is a short form, without {lost}"
        if instrument.shortened:
            made = ", ".join(
                f"{each.title} goes from {float(each.low):g} to {float(each.high):g}"
                for each in instrument.scales
                if each.name in instrument.shortened
            )
            said += (
                f": {made}; scores of the items that were asked compare conditions of this study, "
                "and nothing with scores or norms of the whole questionnaire"
            )
        said += "".join(
            f"; {titles[name]} cannot be scored: {why}" for name, why in instrument.unscored.items()
        )
        found.append(said)
    return found


def _dropped_with(study: StudyData) -> list[str]:
    """Say where frames were dropped under some conditions, or in some scenes, more than others.

    Complex images take longer: what a condition does to comfort is then not its blur alone.
    """
    found = []
    for column in ("condition", "scene"):
        shares = _dropped_percent(study, column)
        ranked = sorted(shares, key=lambda each: shares[each])
        if not ranked or shares[ranked[-1]] - shares[ranked[0]] < DROPPED_APART_PERCENT:
            continue
        least, most = (
            f"{shares[each]:.1f} % in {study.labels.get(each, each)}"
            for each in (ranked[0], ranked[-1])
        )
        found.append(
            f"dropped frames go with the {column} ({most}, {least}): a difference between "
            f"{column}s may be one of late frames"
        )
    return found


def _dropped_percent(study: StudyData, column: str) -> dict[str, float]:
    """Return value of a column of the trials → share of its frames that were dropped."""
    shown: Counter[str] = Counter()
    dropped: Counter[str] = Counter()
    for trial in study.trials:
        if value := trial.get(column):
            shown[value] += whole_or_none(trial.get("frames")) or 0
            dropped[value] += whole_or_none(trial.get("dropped")) or 0
    return {value: 100 * dropped[value] / count for value, count in shown.items() if count}


def _losses(
    study: StudyData, tests: Sequence[SignedRankRow], exclusions: Sequence[ExcludedByRule]
) -> list[str]:
    """Report contrasts of which the test lacks more than a tenth of the exposed participants."""
    found = []
    excluded = {p["participant"] for p in study.participants if p["status"] == "excluded"}
    excluded |= {row.participant for row in exclusions if row.is_person}
    primary = {(test.a, test.b): test for test in reversed(tests)}
    for test in reversed(primary.values()):
        people = _of_both(study, [_met(study, side) for side in test.sides]) - excluded
        lost = sorted(people.difference(test.participants), key=natural)
        if len(lost) > TOLERATED_LOSS * len(people):
            needed = test.exposures_per_condition
            label = study.labels
            several = ", ".join(f"{n} of {label.get(c, c)}" for c, n in needed.items() if n > 1)
            of_each = f" ({several})" if several else ""
            pair = " and ".join(label.get(name, name) for name in (test.a, test.b))
            found.append(
                f"{len(lost)} of {len(people)} participants are not in the tests of {pair}, for "
                f"which a score of every planned exposure{of_each} is needed: {some_of(lost)}"
            )
    return found


def _never_met(study: StudyData, tests: Sequence[SignedRankRow]) -> list[str]:
    """Name the participants with one condition of a comparison only, where most had both."""
    found = []
    for test in {(test.a, test.b): test for test in reversed(tests)}.values():
        if any(side.timepoint for side in test.sides):
            continue
        met = [_met(study, side) for side in test.sides]
        both = set.intersection(*met)
        for one, other, condition in ((met[0], met[1], test.b), (met[1], met[0], test.a)):
            lacking = sorted((one & _of_both(study, met)) - other, key=natural)
            if lacking and len(lacking) <= TOLERATED_LOSS * len(both):
                found.append((condition, tuple(lacking)))
    return [
        f"{some_of(people)} never met {study.labels.get(condition, condition)}, and "
        f"{'is' if len(people) == 1 else 'are'} in no test of it"
        for condition, people in dict.fromkeys(found)
    ]


def _left_under_one(
    study: StudyData, tests: Sequence[SignedRankRow], repeated: Sequence[RepeatedTest]
) -> list[str]:
    """Report dropout concentrated in one condition: its completers are a selected sample."""
    left = find_withdrawals(study)
    conditions = {trial["condition"] for trial in study.trials} - {""}
    under = Counter(each.condition for each in left if each.condition)
    if len(left) < FEWEST_LEFT or len(conditions) < 2 or not under:
        return []
    condition, count = under.most_common(1)[0]
    if count < ONE_SIDED * len(left):
        return []
    share = f"{count} of {len(left)}"
    if count == len(left):
        share = "both" if count == 2 else f"all {count}"
    label = study.labels.get(condition, condition)
    ranked = any(test.ranked_worst for test in tests)
    of_whom = "they are ranked as worst" if ranked else "the comparison is of those who stayed"
    said = f"{share} participants who left did so under {label}: {of_whom}"
    times = _leaving_in_words(study)
    worst = next((each for each in repeated if each.analysis == WORST_RANK), None)
    stayed = next((test.p for test in tests if test.p is not None), None)
    if worst is not None and stayed is not None and not ranked:
        times.append(
            f"with those who left ranked as worst {p_equals(worst.p)}, of those who stayed "
            f"{p_equals(stayed)}"
        )
    return ["; ".join([said, *times])]


def _leaving_in_words(study: StudyData) -> list[str]:
    """Return the log-rank test of the time to leaving by condition, if it can be made."""
    events = [e for e in times_to_withdrawal(rated_exposures(study, "")) if e.condition]
    again = len({e.participant for e in events}) < len(events)
    try:
        found = log_rank(
            [e.time_s for e in events], [e.came for e in events], [e.condition for e in events],
            strata=[e.participant for e in events] if again else None,
        )  # fmt: skip
    except InputError:
        return []
    within = " within people" if again else ""
    return [f"time to leaving: log-rank{within} {p_equals(found.p)}"]


def _of_both(study: StudyData, sides: list[set[str]]) -> set[str]:
    """Return participants exposed to a side of a contrast, less groups that never met the other."""
    group = {row["participant"]: row.get("group", "") for row in study.participants}
    groups = [{group.get(who, "") for who in side} for side in sides]
    both = set.intersection(*groups)
    return {who for side in sides for who in side if group.get(who, "") in both}


_BY = {
    "rating": "a rating",
    "score": "a score",
    "participant": "the participant",
    "task": "a task that was done",
    "screening": "the experimenter, who screened somebody out",
    "gaze": "the validation of the gaze",
    "practice": "practice that did not go well enough",
    "adjustment": "an adjustment that was confirmed",
}


def _screened(study: StudyData) -> list[str]:
    """Report the numbers beyond a screening rule, and the decisions."""
    rules = sorted({row["rule"] for row in study.screening})
    found = []
    for rule in rules:
        rows = [row for row in study.screening if row["rule"] == rule]
        stopped = {row["participant"] for row in rows if row["decision"] == "stop"}
        on = len({row["participant"] for row in rows} - stopped)
        told = counted(len(stopped) + on, "participants")
        found.append(
            f"screening: {rule} in {told}; the experimenter stopped {len(stopped)} and "
            f"went on with {on}"
        )
    return found


def _ended_early(study: StudyData) -> list[str]:
    """Say how many exposures and sessions ended before their time, while the study went on."""
    parts = [
        f"{counted(each.n, f'{each.ends}s')} by {_BY[each.by]}"
        for each in early_endings(study)
        if each.ends != "study" and each.by in _BY
    ]
    return [f"ended before their time: {', '.join(parts)}"] if parts else []


def _met(study: StudyData, side: Side) -> set[str]:
    """Return participants exposed to a side of a contrast, or asked at its timepoint."""
    condition, timepoint = side.condition, side.timepoint
    if not timepoint:
        met = {s.participant for s in study.sheets if s.condition == condition}
        return met | {t["participant"] for t in study.trials if t["condition"] == condition}
    asked = (s for s in study.sheets if s.timepoint == timepoint)
    return {s.participant for s in asked if not condition or s.condition in {condition, ""}}


def _repeated(scored: Exposures) -> list[str]:
    """Report participants with more exposures of a condition than planned."""
    counts = Counter(zip(scored.table["participant"], scored.table["condition"], strict=True))
    people = {who for (who, what), n in counts.items() if n > scored.planned.get(what, n)}
    if not people:
        return []
    listed = sorted(people, key=natural)
    have = "has" if len(listed) == 1 else "have"
    return [
        f"{some_of(listed)} {have} more exposures of a condition than are planned; the mean of all "
        f"of them is taken; or is {'it' if len(listed) == 1 else 'each'} the id of two people?"
    ]


def _suspect_names(study: StudyData) -> list[str]:
    """Say which names may be one person's: they differ in case, spaces or zeros alone."""
    groups = alike(everybody(study))
    pairs = [" and ".join(f"`{name}`" for name in group) for group in groups]
    if not pairs:
        return []
    return [
        f"{'; '.join(pairs)} may be one participant each, whose name was typed differently; they "
        "are counted as different people"
    ]


def _confounded(study: StudyData, tests: Sequence[SignedRankRow]) -> list[str]:
    """Say which conditions were met in one order, of the first score of each pair."""
    orders: dict[tuple[str, str], OneOrder] = {}
    for test in tests:
        order = test.confounded
        if order:
            orders.setdefault((test.a, test.b), order)
    return [in_words(each, lambda name: study.labels.get(name, name)) for each in orders.values()]
