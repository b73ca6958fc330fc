"""Rules of plans beyond types: known names, and keys that go together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from vrcomfort.questionnaire import Instrument
from vrcomfort.report.measures import fault_of
from vrcomfort.report.outcomes import Outcome, fault_of_outcome, known_outcomes
from vrcomfort.report.plan.model import INDEPENDENT, PAIRED, Contrast, Exclusion, Plan
from vrcomfort.settings import Problem, did_you_mean, repeated

_TAKEN = {"participant", "score"}


def problems(plan: Plan, instruments: Iterable[Instrument] | None = None) -> Iterator[Problem]:
    """Yield every fault of a plan; its scores are those of the instruments, or of shipped ones."""
    known = known_outcomes(instruments)
    yield from repeated(("outcomes",), plan.outcomes)
    yield from repeated(("mixed_model",), plan.mixed_model)
    yield from repeated(("covariates",), plan.covariates)
    yield from repeated(("figures",), plan.figures)
    yield from _named_twice(plan)
    yield from _outcomes(plan, known)
    yield from _measures(plan, known)
    yield from _families(plan, known)
    for index, contrast in enumerate(plan.contrasts):
        yield from (Problem(("contrasts", index), said) for said in _of_contrast(contrast, plan))
    for index, factor in enumerate(plan.anova):
        if factor.name in _TAKEN:
            message = f"`{factor.name}` cannot name a factor; choose another word"
            yield Problem(("anova", index, "name"), message)
    for index, rule in enumerate(plan.exclusions):
        yield from (
            Problem(("exclusions", index), said) for said in _of_exclusion(rule, plan, known)
        )


def _named_twice(plan: Plan) -> Iterator[Problem]:
    yield from repeated(("anova",), [factor.name for factor in plan.anova])
    yield from repeated(("families",), [family.name for family in plan.families])
    yield from repeated(("exclusions",), [rule.name for rule in plan.exclusions])


def _outcomes(plan: Plan, known: Mapping[str, Outcome]) -> Iterator[Problem]:
    for index, name in enumerate(plan.outcomes):
        if problem := fault_of_outcome(name, known, _named(plan)):
            yield Problem(("outcomes", index), problem)


def _named(plan: Plan) -> list[str]:
    return [each.name for each in plan.measures]


def _measures(plan: Plan, known: Mapping[str, Outcome]) -> Iterator[Problem]:
    yield from repeated(("measures",), _named(plan))
    for index, each in enumerate(plan.measures):
        if each.name in known:
            message = f"`{each.name}` is a score of an instrument; give the measure another name"
            yield Problem(("measures", index, "name"), message)
        if problem := fault_of(each.measure):
            yield Problem(("measures", index, "measure"), problem)
        timed = each.measure == "ratings.time_to"
        if timed and each.threshold is None:
            yield Problem(("measures", index), "`ratings.time_to` needs a threshold; give one")
        if not timed and each.threshold is not None:
            message = "only `ratings.time_to` has a threshold; leave it away"
            yield Problem(("measures", index, "threshold"), message)
        if each.instrument and not each.measure.startswith("ratings."):
            message = "only measures of ratings have an instrument; leave it away"
            yield Problem(("measures", index, "instrument"), message)


def _families(plan: Plan, known: Mapping[str, Outcome]) -> Iterator[Problem]:
    place: dict[tuple[str, str], str] = {}
    for index, family in enumerate(plan.families):
        for number, name in enumerate(family.outcomes):
            path = ("families", index, "outcomes", number)
            if not plan.outcomes and (problem := fault_of_outcome(name, known, _named(plan))):
                yield Problem(path, problem)
            elif plan.outcomes and name not in plan.outcomes:
                hint = did_you_mean(name, plan.outcomes)
                yield Problem(path, f"`{name}` is not among the outcomes; {hint}")
            for analysis in family.analyses:
                before = place.setdefault((name, analysis), family.name)
                if before != family.name:
                    message = f"the {analysis} of `{name}` are in family `{before}` already"
                    yield Problem(path, f"{message}; adjust them once")


def _of_groups(contrast: Contrast) -> Iterator[str]:
    """Yield the faults of a contrast between groups."""
    if contrast.a_timepoint or contrast.b_timepoint:
        yield "groups are compared after exposure; leave the timepoints away"
    if not contrast.a or not contrast.b or contrast.a == contrast.b:
        yield f"name two different values of `{contrast.between}` as a and b"
    if contrast.test in PAIRED:
        yield f"`{contrast.test}` needs pairs; between groups there are {', '.join(INDEPENDENT)}"


def _of_contrast(contrast: Contrast, plan: Plan) -> Iterator[str]:
    if contrast.between:
        yield from _of_groups(contrast)
        return
    if contrast.condition:
        yield "`condition` is of contrasts between groups; name it as a or b"
    if contrast.test in INDEPENDENT:
        yield f"`{contrast.test}` needs groups; give `between`, or one of {', '.join(PAIRED)}"
    sides = [
        (condition, timepoint or plan.exposure_timepoint)
        for condition, timepoint in (
            (contrast.a, contrast.a_timepoint),
            (contrast.b, contrast.b_timepoint),
        )
    ]
    if sides[0] == sides[1]:
        what = f"condition `{contrast.a}`" if contrast.a else f"timepoint `{sides[0][1]}`"
        yield f"{what} is compared with itself; name another one"
    elif bool(contrast.a) != bool(contrast.b) and sides[0][1] == sides[1][1]:
        absent = "a" if not contrast.a else "b"
        yield f"`{absent}` is missing; name a condition, or another timepoint"


def _of_exclusion(rule: Exclusion, plan: Plan, known: Mapping[str, Outcome]) -> Iterator[str]:
    given = [
        name
        for name, value in (
            ("participants", rule.participants),
            ("score", rule.score),
            ("trial", rule.trial),
            ("column", rule.column),
        )
        if value
    ]
    if len(given) != 1:
        what = f"has {' and '.join(given)}" if given else "names nothing to go by"
        yield f"rule `{rule.name}` {what}; give one of participants, score, trial or column"
        return
    limits = rule.above is not None or rule.below is not None
    if given == ["participants"]:
        if limits or rule.equals or rule.removes == "exposure":
            yield f"rule `{rule.name}` names people; it excludes them as they are"
        return
    if not limits and not rule.equals:
        yield f"rule `{rule.name}` has no limit; give above, below or equals"
    if rule.score and (problem := fault_of_outcome(rule.score, known, _named(plan))):
        yield problem
    if rule.removes == "exposure" and (
        rule.column or (rule.score and rule.timepoint not in {"", plan.exposure_timepoint})
    ):
        yield f"rule `{rule.name}` goes by what belongs to no exposure; let it remove participants"
    if rule.equals and rule.column == "":
        yield f"rule `{rule.name}` goes by a number; give above or below instead of equals"
