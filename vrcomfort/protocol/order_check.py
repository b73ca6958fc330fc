"""Checks of orders: rules, sequences, parts, and practice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import pairwise
from math import prod

from vrcomfort.protocol.model import Protocol, factor_names, level_of, part_trials, trials_of
from vrcomfort.protocol.order import NO_TASK, Group, Order, Part, Trial, orders_of
from vrcomfort.protocol.session_steps import Practice
from vrcomfort.settings import KeyPath, Problem, did_you_mean, read_toml, repeated, reserved

# Sequences are made whole: n! of all orders are 720 with 6 treatments, more than studies have
# participants, and a square of 64 has 64 rows of 64 trials.
MOST_TREATMENTS = {
    "latin_square": 64,
    "williams": 26,
    "all_orders": 6,
    "block_random": 1000,
    "random": 1000,
}
OF_RULES = {
    "blocks": ("block_random",),
    "strata": ("block_random",),
    "max_run": ("block_random",),
    "assignment": ("explicit", "latin_square", "williams", "all_orders", "parts"),
    "sessions": tuple(MOST_TREATMENTS),
}
"""Keys of [order] that do nothing with other rules."""
MOST_STRATA = 1000
TAKEN = frozenset(["participant", "sequence", "status", "enrolled_at", "note", "group"])
"""Columns of participants.csv, which no covariate may be called."""


def order_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield faults of the [order] table."""
    written = read_toml(protocol.toml, None).get("order", {}) if protocol.toml else {}
    for key in written.keys() & OF_RULES.keys():
        if protocol.order.rule not in OF_RULES[key]:
            message = f'`{key}` does nothing with rule = "{protocol.order.rule}"'
            yield Problem(("order", key), f"{message}; remove it or change that")
    if protocol.order.rule == "explicit":
        yield from _explicit(protocol)
    elif protocol.order.rule == "parts":
        if protocol.order.sequences:
            message = "`parts` makes its own sequences; remove these or say `explicit`"
            yield Problem(("order", "sequences"), message)
    else:
        yield from _generated(protocol)


def _explicit(protocol: Protocol) -> Iterator[Problem]:
    order = protocol.order
    if not order.sequences:
        yield Problem(("order", "rule"), "`explicit` needs at least one [[order.sequences]] table")
    yield from repeated(("order", "sequences"), [each.name for each in order.sequences])
    conditions = [condition.name for condition in protocol.conditions]
    for index, sequence in enumerate(order.sequences):
        path: KeyPath = ("order", "sequences", index)
        if len(sequence.sessions) != len(order.sequences[0].sessions):
            message = f"sequence `{sequence.name}` has another number of sessions than the first"
            yield Problem((*path, "sessions"), f"{message}; all need the same")
        yield from _group_of_sequence(protocol, path, sequence.group)
        for session_index, session in enumerate(sequence.sessions):
            for trial_index, trial in enumerate(session):
                place = (*path, "sessions", session_index, trial_index)
                yield from unknown_name(place, "condition", trial.condition, conditions)
                yield from unknown_name(place, "scene", trial.scene, protocol.scenes)


def _group_of_sequence(protocol: Protocol, path: KeyPath, group: str | None) -> Iterator[Problem]:
    names = [each.name for each in protocol.groups]
    if group is None and names:
        message = "this sequence has no group; with [[groups]], name its `group`"
        yield Problem(path, message)
    elif group is not None:
        yield from unknown_name(path, "group", group, names)


def _generated(protocol: Protocol) -> Iterator[Problem]:
    order = protocol.order
    if order.sequences:
        message = f"rule `{order.rule}` makes its own sequences; remove these or say `explicit`"
        yield Problem(("order", "sequences"), message)
    for group in protocol.groups or (None,):
        yield from _dealt(protocol, len(trials_of(protocol, group)))
    if order.rule == "block_random":
        yield from _limits(protocol)


def _dealt(protocol: Protocol, treatments: int) -> Iterator[Problem]:
    order = protocol.order
    most = MOST_TREATMENTS[order.rule]
    if treatments > most:
        message = f"`{order.rule}` takes at most {most} condition-scene pairs; there are"
        yield Problem(("order", "rule"), f"{message} {treatments}: choose another rule")
    yield from _sessions(order, treatments * order.blocks)


def _sessions(order: Order, exposures: int) -> Iterator[Problem]:
    """Yield why exposures cannot be dealt over the sessions, and how they could be."""
    sessions = order.sessions
    if not exposures or not exposures % sessions or (order.unbalanced and exposures > sessions):
        return
    fitting = [each for each in range(1, exposures + 1) if not exposures % each]
    below = [each for each in fitting if each < sessions][-1]
    near = [str(each) for each in (below, *fitting[fitting.index(below) + 1 :][:1])]
    remedies = [f"choose {' or '.join(near)}", "show all of them in each session with [[parts]]"]
    if exposures > sessions:
        remedies.append("let sessions differ by one exposure (`unbalanced = true`)")
    message = f"{exposures} condition-scene pairs cannot be dealt evenly over {sessions} sessions"
    yield Problem(("order", "sessions"), f"{message}: {', or '.join(remedies)}")


def _limits(protocol: Protocol) -> Iterator[Problem]:
    """Yield words that limit nothing, and limits that no order can keep."""
    order = protocol.order
    known = ["condition", "scene", "trial", *factor_names(protocol)]
    for word in order.max_run:
        if word not in known:
            hint = did_you_mean(word, known)
            yield Problem(("order", "max_run", word), f"trials have no `{word}`; {hint}")
    strata = [word for word in known if word != "trial"]
    if order.strata is not None and order.strata not in strata:
        hint = did_you_mean(order.strata, strata)
        yield Problem(("order", "strata"), f"trials have no `{order.strata}`; {hint}")
    for group in protocol.groups or (None,):
        trials = trials_of(protocol, group) * order.blocks
        for word, most in {"trial": 1, **order.max_run}.items():
            if word in known:
                counts = Counter(level_of(protocol, trial, word) for trial in trials)
                yield from _impossible_run(word, most, counts, len(trials))
        if order.strata in strata:
            yield from _uneven(protocol, order.strata or "", group)


def _impossible_run(word: str, most: int, counts: Counter[str], trials: int) -> Iterator[Problem]:
    level, count = max(counts.items(), key=lambda each: each[1], default=("", 0))
    if count > most * (trials - count + 1):
        message = f"{count} of {trials} trials have {word} `{level}`: some order has more than"
        hint = f"{most} in a row; allow more in `max_run`, or add others"
        yield Problem(("order", "max_run", word), f"{message} {hint}")


def _uneven(protocol: Protocol, word: str, group: Group | None) -> Iterator[Problem]:
    counts = Counter(level_of(protocol, trial, word) for trial in trials_of(protocol, group))
    if len(set(counts.values())) > 1:
        message = f"a block has {dict(counts)} trials by {word}: no rounds with one of each"
        yield Problem(("order", "strata"), f"{message}; leave `strata` out")


def group_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield faults of groups, covariates and allocation."""
    groups, covariates = protocol.groups, protocol.covariates
    yield from repeated(("groups",), [group.name for group in groups])
    yield from repeated(("covariates",), [each.name for each in covariates])
    conditions = [condition.name for condition in protocol.conditions]
    for index, group in enumerate(groups):
        yield from reserved(("groups", index, "name"), group.name)
        for number, name in enumerate(group.conditions):
            path: KeyPath = ("groups", index, "conditions", number)
            for problem in unknown_name(path, "condition", name, conditions):
                yield Problem(path, problem.message)
        if group.conditions and protocol.order.rule == "explicit":
            message = "explicit sequences say what a group meets"
            yield Problem(("groups", index, "conditions"), f"{message}; remove this")
    if len(groups) == 1:
        yield Problem(("groups",), "one group is no factor; add another, or remove it")
    yield from _nobody_in(protocol)
    yield from _covariates(protocol)
    yield from _allocation(protocol)


def _nobody_in(protocol: Protocol) -> Iterator[Problem]:
    used = {sequence.group for sequence in protocol.order.sequences}
    for index, group in enumerate(protocol.groups):
        if protocol.order.rule == "explicit" and group.name not in used:
            message = f"no sequence is group `{group.name}`'s"
            yield Problem(("groups", index, "name"), f"{message}; add one, or remove the group")


def _covariates(protocol: Protocol) -> Iterator[Problem]:
    for index, each in enumerate(protocol.covariates):
        path: KeyPath = ("covariates", index)
        if each.name in TAKEN:
            message = f"`{each.name}` is a column of participants.csv already"
            yield Problem((*path, "name"), f"{message}; choose another name")
        if each.levels and each.cuts:
            yield Problem((*path, "cuts"), "`cuts` divide numbers; this has `levels`: remove one")
        if len(each.levels) == 1:
            yield Problem((*path, "levels"), "a covariate needs at least two levels; add others")
        yield from repeated((*path, "levels"), each.levels)
        if each.low >= each.high:
            yield Problem((*path, "low"), "`low` must be less than `high`; swap them")
        outside = [cut for cut in each.cuts if not each.low < cut < each.high]
        if outside:
            message = f"the cut {outside[0]:g} is outside of the range"
            hint = f"choose cuts between {each.low:g} and {each.high:g}"
            yield Problem((*path, "cuts"), f"{message}; {hint}")


def _allocation(protocol: Protocol) -> Iterator[Problem]:
    allocation = protocol.allocation
    if allocation is None:
        return
    if not protocol.groups:
        message = "there are no groups to divide people among; add [[groups]] or remove this"
        yield Problem(("allocation",), message)
    covariates = {each.name: each for each in protocol.covariates}
    for index, name in enumerate(allocation.by):
        path: KeyPath = ("allocation", "by", index)
        for problem in unknown_name(path, "covariate", name, covariates):
            yield Problem(path, problem.message)
        found = covariates.get(name)
        if found and len(found.bands) < 2:
            message = f"`{name}` is a number without `cuts`: everyone would be in one stratum"
            yield Problem(path, f"{message}; give it cuts")
    strata = prod(len(covariates[name].bands) for name in allocation.by if name in covariates)
    if allocation.method == "permuted_blocks" and strata > MOST_STRATA:
        message = f"{strata} strata would mostly stay empty; choose minimisation, or fewer strata"
        yield Problem(("allocation", "by"), message)
    yield from repeated(("allocation", "by"), allocation.by)
    if allocation.method == "minimisation" and not allocation.by:
        message = "minimisation needs covariates to balance"
        yield Problem(("allocation", "method"), f"{message}; name them in `by`")
    if allocation.method == "simple" and allocation.by:
        yield Problem(("allocation", "by"), "`by` does nothing with `simple`; remove it")
    yield from _idle(protocol)


def _idle(protocol: Protocol) -> Iterator[Problem]:
    allocation = protocol.allocation
    written = read_toml(protocol.toml, None).get("allocation", {}) if protocol.toml else {}
    for key, method in {"rounds": "permuted_blocks", "p_best": "minimisation"}.items():
        if allocation and key in written and allocation.method != method:
            message = f'`{key}` does nothing with method = "{allocation.method}"'
            yield Problem(("allocation", key), f"{message}; remove it")


def unknown_name(path: KeyPath, kind: str, name: str, known: Iterable[str]) -> Iterator[Problem]:
    """Yield a problem if a study has no condition, scene, … of a name."""
    choices = list(known)
    if name not in choices:
        hint = did_you_mean(name, choices)
        yield Problem((*path, kind), f"this study has no {kind} `{name}`; {hint}")


# Each part's orders are combined with those of all others, and every combination is a sequence.
MOST_COMBINATIONS = 10_000


def part_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield faults of [[parts]]."""
    rule = protocol.order.rule
    if rule != "parts":
        if protocol.parts:
            message = f'[[parts]] do nothing with rule = "{rule}"; say `rule = "parts"`'
            yield Problem(("order", "rule"), message)
        return
    if not protocol.parts:
        message = "`parts` needs [[parts]] with their orders; add them"
        yield Problem(("order", "rule"), message)
        return
    yield from repeated(("parts",), [part.name for part in protocol.parts])
    for index, part in enumerate(protocol.parts):
        yield from _part(protocol, part, ("parts", index))
    if not set(range(1, max(p.session for p in protocol.parts) + 1)) <= {
        part.session for part in protocol.parts
    }:
        message = "a session before this one has no part; count sessions from 1, without gaps"
        yield Problem(("parts", len(protocol.parts) - 1, "session"), message)
    if any(_combinations(protocol, group) > MOST_COMBINATIONS for group in _groups(protocol)):
        message = f"the parts' orders have more than {MOST_COMBINATIONS} combinations"
        yield Problem(("parts",), f"{message}; give them fewer orders")


def _groups(protocol: Protocol) -> tuple[Group | None, ...]:
    return protocol.groups or (None,)


def _combinations(protocol: Protocol, group: Group | None) -> int:
    return prod(_orders(protocol, part, group) for part in protocol.parts)


def _orders(protocol: Protocol, part: Part, group: Group | None) -> int:
    """Return how many orders a group has of a part, or at least a number that is too large."""
    if part.rule == "explicit":
        return max(len(orders_of(part, group.name if group else "")), 1)
    count = min(len(part_trials(protocol, part, group)), MOST_TREATMENTS[part.rule])
    if part.rule == "all_orders":
        return prod(range(1, count + 1))
    return count * (2 if part.rule == "williams" and count % 2 else 1)


def _part(protocol: Protocol, part: Part, path: KeyPath) -> Iterator[Problem]:
    conditions = [condition.name for condition in protocol.conditions]
    if part.rule == "explicit":
        if not part.orders:
            message = "`explicit` needs at least one [[parts.orders]] table"
            yield Problem((*path, "rule"), message, missing=True)
        for key in sorted({"conditions", "scenes"} & part.model_fields_set):
            message = f'`{key}` does nothing with rule = "explicit"; remove it or change that'
            yield Problem((*path, key), message)
    elif part.orders:
        message = f"rule `{part.rule}` makes its own orders; remove these or say `explicit`"
        yield Problem((*path, "orders"), message)
    for name in part.conditions:
        yield from unknown_name((*path, "conditions"), "condition", name, conditions)
    for name in part.scenes:
        yield from unknown_name((*path, "scenes"), "scene", name, protocol.scenes)
    yield from repeated((*path, "orders"), [order.name for order in part.orders])
    for number, order in enumerate(part.orders):
        for place, trial in enumerate(order.trials):
            here = (*path, "orders", number, "trials", place)
            yield from unknown_name(here, "condition", trial.condition, conditions)
            yield from unknown_name(here, "scene", trial.scene, protocol.scenes)
    for group in _groups(protocol):
        yield from _of_group(protocol, part, path, group)
    yield from _whose(protocol, part, path)


def _of_group(
    protocol: Protocol, part: Part, path: KeyPath, group: Group | None
) -> Iterator[Problem]:
    """Yield faults of the orders of a part for one group."""
    written = orders_of(part, group.name if group else "")
    whose = f" of group `{group.name}`" if group else ""
    for before, after in pairwise(written):
        if len(before.trials) != len(after.trials):
            message = f"orders `{before.name}` and `{after.name}` are not of the same length"
            yield Problem((*path, "orders"), f"{message}; all of a part{whose} need the same")
    if group and part.orders and not written:
        message = f"group `{group.name}` has no order of part `{part.name}`"
        yield Problem((*path, "orders"), f"{message}; add one, or leave `group` out of another")
    if part.rule == "explicit":
        return
    most, count = MOST_TREATMENTS[part.rule], len(part_trials(protocol, part, group))
    if count > most:
        message = f"`{part.rule}` takes at most {most} condition-scene pairs; there are {count}"
        yield Problem((*path, "rule"), f"{message}{whose}: choose another rule")
    if group and not count:
        message = f"group `{group.name}` meets no condition of part `{part.name}`"
        yield Problem((*path, "conditions"), f"{message}; name some of its conditions")


def _whose(protocol: Protocol, part: Part, path: KeyPath) -> Iterator[Problem]:
    """Yield faults of the groups of written orders."""
    names = [group.name for group in protocol.groups]
    for number, order in enumerate(part.orders):
        here = (*path, "orders", number)
        if order.group is not None and not names:
            yield Problem((*here, "group"), "there are no [[groups]]; add them, or remove this")
        elif order.group is not None:
            yield from unknown_name((*here, "group"), "group", order.group, names)
        for group in protocol.groups:
            if order.group not in (None, group.name) or not group.conditions:
                continue
            others = [t.condition for t in order.trials if t.condition not in group.conditions]
            if others:
                message = f"group `{group.name}` does not meet condition `{others[0]}`"
                yield Problem((*here, "trials"), f"{message}; name the order's `group`")


def practice_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield faults of [[practice]] tables."""
    yield from repeated(("practice",), [each.name for each in protocol.practice])
    conditions = [condition.name for condition in protocol.conditions]
    for index, each in enumerate(protocol.practice):
        path: KeyPath = ("practice", index)
        if bool(each.trials) == (each.draw is not None):
            message = "`trials` and `draw` exclude each other; keep one" if each.trials else (
                f"`{each.name}` shows nothing; give it `trials`, or `draw` some of the session's"
            )  # fmt: skip
            yield Problem((*path, "draw" if each.trials else "name"), message)
        for number, trial in enumerate(each.trials):
            place = (*path, "trials", number)
            yield from unknown_name(place, "condition", trial.condition, conditions)
            yield from unknown_name(place, "scene", trial.scene, protocol.scenes)
            yield from _too_long(protocol, each, trial, (*path, "exposure_s"))
        yield from _criterion(protocol, each, path)


def _too_long(
    protocol: Protocol, practice: Practice, trial: Trial, path: KeyPath
) -> Iterator[Problem]:
    longest_s = protocol.length_s(trial.scene)
    if protocol.view(trial.scene).carried and (practice.exposure_s or 0.0) > longest_s:
        message = f"the path of `{trial.scene}` is for {longest_s:g} s; practise it no longer"
        yield Problem(path, message)


def _criterion(protocol: Protocol, practice: Practice, path: KeyPath) -> Iterator[Problem]:
    if not practice.has_criterion:
        for key in sorted({"at_most", "otherwise"} & practice.model_fields_set):
            message = f"`{key}` does nothing without `score_at_least` or `hits_at_least`"
            yield Problem((*path, key), f"{message}; remove it or add one")
        return
    key = "score_at_least" if practice.score_at_least is not None else "hits_at_least"
    if not any(_has_task(protocol, trial) for trial in practice.trials) and (
        practice.trials or not protocol.tasks
    ):
        message = f"nothing is done in `{practice.name}` that `{key}` could count"
        yield Problem((*path, key), f"{message}; name a `task`, or remove it")


def _has_task(protocol: Protocol, trial: Trial) -> bool:
    of_condition = (c.task for c in protocol.conditions if c.name == trial.condition)
    name = trial.task or next(of_condition, None) or protocol.task
    return name not in {None, NO_TASK}
