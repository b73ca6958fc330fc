"""Cumulative logit models of single items, and what pages and sentences say of them."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from vrcomfort.errors import InputError
from vrcomfort.report.exposures import column_of
from vrcomfort.report.models import guarded
from vrcomfort.report.words import interval, number, p_equals
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.ordinal import ordinal_model

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.vocabulary import Vocabulary

Row = dict[str, Any]
MOST_ANSWERS = 21
"""More different ones are no ordered answers any more, and take a threshold each."""


def ordinal_models(scored: Exposures, plan: Plan, reference: str) -> list[Row]:
    """Return a model for each ``[[ordinal]]`` of the plan, conditions compared with `reference`.

    Raises
    ------
    InputError
        If the plan names what is neither an outcome nor an item of one, with its place.
    """
    return [_model(scored, plan, place, reference) for place in range(len(plan.ordinal))]


def _model(scored: Exposures, plan: Plan, place: int, reference: str) -> Row:
    asked = plan.ordinal[place]
    known = [*scored.items, *(each.name for each in scored.outcomes)]
    if asked.outcome not in (*known, *scored.absent):
        message = (
            f"`{asked.outcome}` is neither an outcome of the plan nor an item of their "
            f"questionnaires; {did_you_mean(asked.outcome, known)}"
        )
        raise plan.fault(message, "ordinal", place, "outcome")
    instrument, item = scored.items.get(asked.outcome, ("", ""))
    found = guarded(asked.outcome, lambda: _fitted(scored, plan, place, reference))
    return {"instrument": instrument, "item": item, "factors": list(asked.factors), **found}


def _fitted(scored: Exposures, plan: Plan, place: int, reference: str) -> Row:
    asked = plan.ordinal[place]
    if asked.outcome in scored.absent:
        raise InputError("the data do not have it")
    unit = 1.0 if asked.outcome in scored.items else scored.units[asked.outcome]
    rows = scored.table.dropna(subset=[asked.outcome])
    rows = rows.assign(answer=rows[asked.outcome].astype(float) * unit)
    if rows["answer"].nunique() > MOST_ANSWERS:
        raise InputError(
            f"it takes {rows['answer'].nunique()} different values; ordinal models are of at most "
            f"{MOST_ANSWERS}"
        )
    rows = rows.assign(**{name: _levels(scored, rows, name) for name in asked.factors})
    model = ordinal_model(
        rows,
        value="answer",
        participant="participant",
        factors=asked.factors,
        references={"condition": reference},
        confidence=plan.confidence,
    )
    people = sorted(rows.dropna(subset=list(asked.factors))["participant"].unique())
    return {**asdict(model), "confidence": plan.confidence, "participants": people}


def _levels(scored: Exposures, rows: pd.DataFrame, name: str) -> pd.Series:
    return column_of(scored, rows, name).map(str, na_action="ignore")


def ordinal_title(row: Row, words: Vocabulary) -> str:
    """Return what an ordinal model is of."""
    if row["item"]:
        return words.item(row["instrument"], row["item"])
    return words.outcome(row["outcome"])


def ordinal_lines(row: Row, words: Vocabulary) -> list[tuple[str, str]]:
    """Return claim and evidence of each odds ratio of a model."""
    title = ordinal_title(row, words)
    if row["not_tested"]:
        return [(f"{title}: no ordinal model ({row['not_tested']}).", "")]
    percent = f"{100 * row['confidence']:g}\u00a0% CI"
    n = f"{row['n_values']} answers of {row['n_participants']} people"
    found = []
    for term, odds in row["terms"].items():
        shown = odds["p"] <= 1 - row["confidence"]
        said = ("higher" if odds["estimate"] > 0 else "lower") if shown else "no difference shown"
        ends = interval({"low": odds["odds_low"], "high": odds["odds_high"]}, null=1.0)
        claim = (
            f"{title}, {words.term(term)}: {said}; odds ratio of a higher answer\u00a0=\u00a0"
            f"{number(odds['odds_ratio'])}, {percent} {ends}, {n}."
        )
        model = "Cumulative logit model"
        model += " with a random intercept" if row["participant_sd"] is not None else ""
        evidence = f"{model}: z\u00a0=\u00a0{number(odds['z'])}, {p_equals(odds['p'])}."
        found.append((claim, evidence))
    return found
