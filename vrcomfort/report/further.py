"""Correlations, equivalence, preferences, agreement, and tests of several groups of a plan."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.choices import choices_of
from vrcomfort.report.comparisons import NO_VARIANCE, too_few
from vrcomfort.report.families import decide
from vrcomfort.report.models import guarded, is_between, level_of, points
from vrcomfort.report.ordering import natural
from vrcomfort.report.pairs import (
    Side,
    groups_of,
    pair_up,
    side_sums,
    sides_of,
    with_every_score,
)
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.correlation import correlation, intraclass, repeated_measures_correlation
from vrcomfort.stats.proportions import preference
from vrcomfort.stats.rank_anova import kruskal_wallis
from vrcomfort.stats.t_tests import equivalence_of_groups, equivalence_of_pairs

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.families import Verdict
    from vrcomfort.report.plan import Agreed, Correlated, Equivalent, Plan, Preferred
    from vrcomfort.report.study_data import StudyData

Row = dict[str, Any]


def further(scored: Exposures, plan: Plan, study: StudyData) -> dict[str, list[Row]]:
    """Return what a plan asks for beside comparisons and models, by its key in results.json."""
    names = {each.name for each in scored.outcomes}
    return {
        "correlations": [
            _correlation(scored, plan, asked)
            for asked in plan.correlations
            if {asked.x, asked.y} <= names
        ],
        "equivalence": [
            _equivalence(scored, plan, asked)
            for asked in plan.equivalence
            if asked.outcome in names
        ],
        "preferences": [_preference(study, plan, i) for i in range(len(plan.preferences))],
        "agreement": [
            _agreement(scored, plan, asked) for asked in plan.agreement if asked.outcome in names
        ],
        "kruskal_wallis": [
            _kruskal_wallis(scored, plan, place, each.name)
            for place, factor in enumerate(plan.anova)
            if is_between(factor) and _several(scored, plan, place)
            for each in scored.outcomes
        ],
    }


def _correlation(scored: Exposures, plan: Plan, asked: Correlated) -> Row:
    table = scored.table
    rows = table[table["condition"] == asked.condition] if asked.condition else table
    if asked.method == "repeated_measures":
        whole = rows.dropna(subset=[asked.x, asked.y])
        x, y = (
            whole[name].to_numpy(dtype=float) * scored.units[name] for name in (asked.x, asked.y)
        )
        found = repeated_measures_correlation(
            x, y, whole["participant"].to_numpy(), confidence=plan.confidence
        )
        people, smallest = sorted(whole["participant"].unique(), key=natural), 0.0
    else:
        side, complete = Side(asked.condition), plan.needs_every_score
        of_x, of_y = (
            side_sums(scored, name, [side], complete=complete)[0] for name in (asked.x, asked.y)
        )
        rows = rows[rows["participant"].isin(set(of_x).intersection(of_y))]
        means = rows.groupby("participant")[[asked.x, asked.y]].mean().dropna()
        x, y = (
            means[name].to_numpy(dtype=float) * scored.units[name] for name in (asked.x, asked.y)
        )
        found = correlation(x, y, method=asked.method, confidence=plan.confidence)
        people = sorted(means.index, key=natural)
        one_way = correlation(np.sort(x), np.sort(y), method=asked.method)
        smallest = 0.0 if asked.method == "pearson" or one_way.p is None else one_way.p
    problem = None
    if found.estimate is None:
        problem = (
            f"{found.n} pairs of values, or one of both does not vary: too little to correlate"
        )
    return {
        "x": asked.x, "y": asked.y, "condition": asked.condition, "not_tested": problem,
        "participants": people, "values": [x.tolist(), y.tolist()], **asdict(found),
        "verdict": _verdict(plan, found.p, smallest, higher=(found.estimate or 0.0) > 0),
    }  # fmt: skip


def _verdict(plan: Plan, p: float | None, smallest_p: float, *, higher: bool) -> Verdict | None:
    """Return what a test decides that is in no family."""
    if p is None:
        return None
    row: Row = {"p": p, "smallest_p": smallest_p, "higher": higher}
    decide(row, 1 - plan.confidence, [p], 0)
    found: Verdict = row["verdict"]
    return found


def _in_points(table: pd.DataFrame, scored: Exposures, name: str) -> NDArray[np.float64]:
    found: NDArray[np.float64] = table[name].to_numpy(dtype=np.float64) * scored.units[name]
    return found


def _equivalence(scored: Exposures, plan: Plan, asked: Equivalent) -> Row:
    complete = plan.needs_every_score
    result: Row = {**asked.model_dump(), "bounds": [asked.low, asked.high], "not_tested": None}
    bounds, level = (asked.low, asked.high), 1 - plan.confidence
    if asked.between:
        sides = sides_of(asked.between, asked.a, asked.b, asked.condition)
        groups = groups_of(scored, asked.outcome, *sides, complete=complete)
        problem = too_few(groups)
        people = (groups.people_a, groups.people_b)
        n = int(groups.a.size + groups.b.size)
        found = None if problem else equivalence_of_groups(
            groups.a * groups.unit, groups.b * groups.unit, bounds, level=level
        )  # fmt: skip
    else:
        pairs = pair_up(scored, asked.outcome, Side(asked.a), Side(asked.b), complete=complete)
        people = (pairs.participants, pairs.participants)
        problem, n = too_few(pairs), len(pairs.participants)
        found = None if problem else equivalence_of_pairs(
            pairs.differences * pairs.unit, bounds, level=level
        )  # fmt: skip
    result |= {"n": n, "people_a": list(people[0]), "people_b": list(people[1])}
    if found is None:
        return result | {"not_tested": problem or NO_VARIANCE}
    return result | asdict(found) | {"equivalent": found.p <= level}


def _preference(study: StudyData, plan: Plan, index: int) -> Row:
    asked: Preferred = plan.preferences[index]
    said = _chosen(study, plan, index) if asked.item else _in_column(study, plan, index)
    counts = Counter(value for _, value in said if value)
    known = {asked.a, asked.b, *asked.none}
    if unknown := sorted(counts.keys() - known):
        message = (
            f"`{unknown[0]}` in {_where(asked)} is neither a, b nor none; name it, or correct it"
        )
        raise plan.fault(message, "preferences", index)
    none = sum(counts[value] for value in asked.none)
    found = preference(counts[asked.a], counts[asked.b], none, confidence=plan.confidence)
    preferring = counts[asked.a] + counts[asked.b]
    smallest = preference(preferring, 0, none).p
    return {
        "name": asked.name, "label": asked.label or asked.name, "of_a": asked.a, "of_b": asked.b,
        "n": sum(counts.values()), "missing": sum(not value for _, value in said),
        "participants": sorted((who for who, value in said if value), key=natural),
        "confidence": plan.confidence,
        "not_tested": None if preferring else "nobody has a preference",
        **asdict(found), "verdict": _verdict(plan, found.p, smallest, higher=found.a > found.b),
    }  # fmt: skip


def _where(asked: Preferred) -> str:
    if asked.item:
        return f"answers to {asked.item}"
    return f"column `{asked.column}` of participants.csv"


def _in_column(study: StudyData, plan: Plan, index: int) -> list[tuple[str, str]]:
    """Return participant and value of a column, blank where it is missing."""
    asked: Preferred = plan.preferences[index]
    columns = {name for person in study.participants for name in person}
    if asked.column not in columns:
        hint = did_you_mean(asked.column, columns)
        message = f"`{asked.column}` is no column of participants.csv; {hint}"
        raise plan.fault(message, "preferences", index, "column")
    return [
        (person["participant"], person.get(asked.column, "").strip())
        for person in study.participants
        if person["status"] != "excluded"
    ]


def _chosen(study: StudyData, plan: Plan, index: int) -> list[tuple[str, str]]:
    """Return participant and the condition that they chose most often, or none."""
    asked: Preferred = plan.preferences[index]
    try:
        found = choices_of(study, asked.item)
    except InputError as error:
        raise plan.fault(str(error), "preferences", index, "item") from error
    left_out = {p["participant"] for p in study.participants if p["status"] == "excluded"}
    none = asked.none[0] if asked.none else "none"
    return [
        (who, _most_often(chosen, none)) for who, chosen in found.items() if who not in left_out
    ]


def _most_often(chosen: Sequence[str | None], none: str) -> str:
    """Return what was chosen more often than all else; blank where nothing was said."""
    counts = Counter(none if each is None else each for each in chosen)
    ranked = counts.most_common(2)
    if not ranked:
        return ""
    tied = len(ranked) == 2 and ranked[0][1] == ranked[1][1]
    return none if tied else ranked[0][0]


def _agreement(scored: Exposures, plan: Plan, asked: Agreed) -> Row:
    result: Row = {"over": asked.over, "condition": asked.condition}
    return result | guarded(asked.outcome, lambda: _intraclass(scored, plan, asked))


def _intraclass(scored: Exposures, plan: Plan, asked: Agreed) -> Row:
    rows = points(scored.table, scored, asked.outcome)
    rows = rows[rows["condition"] == asked.condition] if asked.condition else rows
    if plan.needs_every_score:
        rows = with_every_score(rows, [asked.over])
    wide = rows.pivot_table(index="participant", columns=asked.over, values="score").dropna()
    if wide.shape[0] < 2 or wide.shape[1] < 2:
        raise InputError(
            f"{wide.shape[0]} people with a score in each of {wide.shape[1]} occasions: too few"
        )
    forms = intraclass(wide.to_numpy(dtype=float), confidence=plan.confidence)
    return {
        "n": wide.shape[0],
        "participants": sorted(wide.index, key=natural),
        "occasions": wide.shape[1],
        "forms": [asdict(f) for f in forms],
    }


def _several(scored: Exposures, plan: Plan, place: int) -> bool:
    return len(level_of(scored, scored.table, plan.anova[place]).dropna().unique()) > 2


def _kruskal_wallis(scored: Exposures, plan: Plan, place: int, outcome: str) -> Row:
    factor = plan.anova[place]
    return {"factor": factor.name} | guarded(
        outcome, lambda: _of_levels(scored, plan, place, outcome)
    )


def _of_levels(scored: Exposures, plan: Plan, place: int, outcome: str) -> Row:
    """Test the groups of a factor on each person's integer sums, brought to one number."""
    factor = plan.anova[place]
    rows = points(scored.table, scored, outcome)
    rows = rows.assign(level=level_of(scored, rows, factor)).dropna(subset=["level"])
    if plan.needs_every_score:
        rows = with_every_score(rows, ["level"])
    group = dict(zip(rows["participant"], rows["level"], strict=True))
    names = sorted({str(level) for level in rows["level"].unique()}, key=natural)
    people, sums, _ = side_sums(scored, outcome, [Side()], complete=False)
    of = dict(zip(people, sums[:, 0], strict=True))
    groups = [np.array([v for who, v in of.items() if group.get(who) == name]) for name in names]
    found = asdict(kruskal_wallis(groups, p_value=plan.p_value))
    return {"levels": names, "participants": sorted(group, key=natural), **found}
