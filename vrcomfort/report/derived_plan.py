"""The plan that a report follows where none is given: written down, so that it can be given."""

from __future__ import annotations

from collections import Counter, defaultdict
from itertools import combinations
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_all, shipped_instruments
from vrcomfort.report.outcomes import Outcome, outcomes_of
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.study_data import conditions_in
from vrcomfort.settings import toml_value

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

BASELINES = ("baseline", "pre", "before", "pretest", "pre_test")
EXPOSURES = ("post", "after", "posttest", "post_test")
RECOVERIES = ("recovery", "followup", "follow_up")
"""Words for the moments of a study, the usual one first."""

_HEAD = """\
# Derived from the data by `vrcomfort report`, which was given no plan. Change it, and pass it back
# with --plan, to decide otherwise. As it was written after the data, it is no pre-registration.
"""


def plan_of(study: StudyData) -> Plan:
    """Return the plan that the data suggest: every score, every factor or pair of conditions.

    Its text, read again, is the same plan.

    Raises
    ------
    InputError
        If nobody answered a questionnaire: then a plan has to say what is analysed.
    """
    if not study.sheets:
        raise InputError(
            "there is no questionnaires.csv in this folder; to analyse its tasks, ratings or "
            "preferences alone, give a plan that names them (--plan)",
            file=study.source,
        )
    text = _HEAD + "".join(f"{line}\n" for line in _lines(study))
    return read_plan(text, None, study.instruments.values())


def with_outcomes(plan: Plan, study: StudyData) -> Plan:
    """Return a plan with the outcomes that the data have, where it names none."""
    if plan.outcomes:
        return plan
    found = _outcomes(study, plan.exposure_timepoint)
    return plan.model_copy(update={"outcomes": tuple(each.name for each in found)})


def _lines(study: StudyData) -> Iterator[str]:
    moments = _moments(study)
    conditions = conditions_in(study, moments["exposure_timepoint"])
    outcomes = _outcomes(study, moments["exposure_timepoint"])
    before = any(sheet.timepoint == moments["baseline_timepoint"] for sheet in study.sheets)
    met = _one_condition_each(study, moments["exposure_timepoint"])
    apart = len(set(met.values())) > 1
    groups = _groups(study, met if apart else {})
    scenes = {s.scene for s in study.sheets} | {t.get("scene", "") for t in study.trials}
    factors = ["condition"] if len(conditions) > 1 else []
    factors += ["scene"] if len(scenes - {""}) > 1 else []
    factors += groups
    crossed = _crossed(study, conditions, factors, apart=apart)
    yield 'name = "derived"'
    yield f"title = {toml_value(_title(conditions, crossed, before=before))}"
    yield f"note = {toml_value('The plan was derived from the data, because none was given.')}"
    if study.planned_participants:
        yield f"participants = {study.planned_participants}"
    yield f"outcomes = {toml_value([each.name for each in outcomes])}"
    if not before:
        yield 'scores = "raw"'
    yield from (f"{key} = {toml_value(name)}" for key, name in moments.items())
    yield f"mixed_model = {toml_value([] if apart else [*factors, 'position', 'session'])}"
    if not factors:
        yield "anova = []"
    yield from _contrasts(study, conditions, moments, crossed, apart=apart)
    yield from _families(outcomes, "anova" if crossed else "tests")
    if crossed:
        yield from _families(outcomes, "tests", of="_of_conditions")
    columns = [(name, "condition") for name in crossed]
    columns += [(each, each) for each in factors if not (crossed and each == "condition")]
    for name, column in columns:
        yield from ("", "[[anova]]", f"name = {toml_value(name)}", f"column = {toml_value(column)}")
        if name in crossed:
            yield f"levels = {toml_value(crossed[name])}"
        if apart and column == "condition":
            yield 'kind = "between"'


def _crossed(
    study: StudyData, conditions: list[str], others: list[str], *, apart: bool
) -> dict[str, dict[str, str]]:
    """Return the protocol's crossed factors: name → condition → level.

    There are none where a combination of levels is missing, or where people met some of them, but
    neither one nor all.
    """
    levels = [study.levels.get(name, {}) for name in conditions]
    names = list(levels[0]) if levels else []
    cells = {tuple(each.items()) for each in levels}
    if len(names) < 2 or any(list(each) != names for each in levels):
        return {}
    full = prod(len({each[name] for each in levels}) for name in names)
    met: dict[str, set[str]] = defaultdict(set)
    for sheet in study.sheets:
        met[sheet.participant] |= {sheet.condition} & set(conditions)
    if not len(cells) == len(conditions) == full:
        return {}
    if not apart and not any(len(each) == full for each in met.values()):
        return {}
    taken = {"participant", "score", *others}
    return {
        f"{name}_level" if name in taken else name: {
            condition: each[name] for condition, each in zip(conditions, levels, strict=True)
        }
        for name in names
    }


def _one_condition_each(study: StudyData, timepoint: str) -> dict[str, str]:
    """Return participant → condition where everybody met one condition alone, else nothing."""
    sheets = [s for s in study.sheets if s.timepoint == timepoint and s.condition]
    met = {sheet.participant: sheet.condition for sheet in sheets}
    return met if all(met[sheet.participant] == sheet.condition for sheet in sheets) else {}


def _outcomes(study: StudyData, timepoint: str) -> tuple[Outcome, ...]:
    """Return the scores at a timepoint that every complete participant has."""
    found: list[Outcome] = []
    asked = [s for s in study.sheets if s.timepoint == timepoint]
    exposed = {s.keys["instrument"] for s in asked if s.condition}  # of a session: no condition
    for name in study.instruments_at(timepoint):
        if exposed and name not in exposed:
            continue
        instrument = study.instruments[name]
        sheets = [s.answers for s in study.sheets if s.keys["instrument"] == name]
        known = score_all(instrument, sheets).known
        needed = [known[scale] for scale in instrument.needed]
        complete = np.logical_and.reduce([np.ones(len(sheets), dtype=bool), *needed])
        found += [
            each
            for each in outcomes_of(instrument)
            if each.scale.name in instrument.needed
            or (complete.any() and known[each.scale.name][complete].all())
        ]
    return tuple(found)


def _title(conditions: list[str], crossed: Collection[str], *, before: bool) -> str:
    if crossed:
        return f"Effects of {' and '.join(crossed)}, and their interaction"
    if len(conditions) == 1:
        return "Before and after exposure" if before else "One condition, described"
    return "Every pair of conditions"


def _moments(study: StudyData) -> dict[str, str]:
    """Return the roles of timepoints, as far as their names tell."""
    there = Counter(sheet.timepoint for sheet in study.sheets)
    known = {name.casefold(): name for name in there}

    def first(words: tuple[str, ...], otherwise: str) -> str:
        return next((known[word] for word in words if word in known), otherwise)

    baseline, recovery = first(BASELINES, BASELINES[0]), first(RECOVERIES, RECOVERIES[0])
    others = [name for name, _ in there.most_common() if name not in {baseline, recovery}]
    exposure = first(EXPOSURES, next(iter(others), EXPOSURES[0]))
    return {
        "baseline_timepoint": baseline,
        "exposure_timepoint": exposure,
        "recovery_timepoint": recovery,
    }


def _contrasts(
    study: StudyData,
    conditions: list[str],
    moments: dict[str, str],
    crossed: dict[str, dict[str, str]],
    *,
    apart: bool,
) -> Iterator[str]:
    """Compare every pair of conditions; of crossed factors, those that differ in one of them."""
    for a, b in combinations(conditions, 2):
        if sum(level[a] != level[b] for level in crossed.values()) > 1:
            continue
        yield from ("", "[[contrasts]]", f"a = {toml_value(a)}", f"b = {toml_value(b)}")
        if apart:
            yield 'between = "condition"'
    baseline, exposure = moments["baseline_timepoint"], moments["exposure_timepoint"]
    if len(conditions) == 1 and any(sheet.timepoint == baseline for sheet in study.sheets):
        yield from ("", "[[contrasts]]", f"a_timepoint = {toml_value(exposure)}")
        yield f"b_timepoint = {toml_value(baseline)}"


def _families(outcomes: tuple[Outcome, ...], analysis: str, of: str = "") -> Iterator[str]:
    """Adjust totals, subscales, and each instrument of the lab's own in separate families.

    Totals and subscales hold the same answers; a lab's own questions ask for something else.
    """
    shipped = shipped_instruments()
    rest = "subscales" if any(each.parts for each in outcomes) else "scores"
    named: dict[str, list[str]] = {"total": [], rest: []}
    for each in outcomes:
        family = rest if each.instrument in shipped else each.instrument
        named.setdefault("total" if each.parts else family, []).append(each.name)
    for name, members in named.items():
        if members:
            yield from ("", "[[families]]", f"name = {toml_value(name + of)}")
            yield f"outcomes = {toml_value(members)}"
            if analysis != "tests":
                yield f"analyses = {toml_value([analysis])}"


def _groups(study: StudyData, met: dict[str, str]) -> list[str]:
    """Return `group` where everybody is in one of a few, and these are not the conditions `met`."""
    groups = study.between("group")
    sizes = Counter(groups.values())
    if met and len({(groups.get(who), each) for who, each in met.items()}) == len(sizes):
        return []
    return ["group"] if len(sizes) > 1 and min(sizes.values()) > 1 else []
