"""Checks of conditions: settings without effect, and adjustments."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from vrcomfort.optics.refocus import LAWS
from vrcomfort.protocol.adjustments import ADJUSTABLE, Adjustment, adjusted, value_of
from vrcomfort.protocol.conditions import FOLLOWING, Condition, ConditionSettings
from vrcomfort.protocol.marks import needs_of
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import NO_TASK, written_orders
from vrcomfort.protocol.quality_levels import dialled
from vrcomfort.settings import (
    KeyPath,
    Problem,
    Settings,
    did_you_mean,
    in_words,
    read_toml,
    repeated,
)
from vrcomfort.settings.reading import fields_at
from vrcomfort.settings.schema import tables_of

Needs = Mapping[str, Collection[Any]]
"""Other settings of the same table, and the values of theirs of which one is needed."""

_LAWS_THAT_TAKE = {
    key: tuple(name for name, law in LAWS.items() if key in law.settings)
    for key in sorted(set().union(*(law.settings for law in LAWS.values())))
    if key != "infinity_m"  # which is also where the sky is
}


def condition_tables() -> Iterator[tuple[str, type[BaseModel]]]:
    """Yield the name and the class of each table of a condition."""
    for name, field in ConditionSettings.model_fields.items():
        yield from ((name, table) for table in tables_of(field.annotation))


NEEDS: dict[str, dict[str, Needs]] = {
    name: {**needs_of(table)} for name, table in condition_tables()
}
"""Conditions under which each setting has an effect, by table; others always have one."""
NEEDS["focus"] |= {key: {**FOLLOWING.needs, "law": laws} for key, laws in _LAWS_THAT_TAKE.items()}


_ADD = {
    "autofocus_zone": 'write method = "autofocus_zone" under focus, beside depth_of_field,',
    "peripheral": "write a table depth_of_field.peripheral",
    "vignette": "write a table vignette",
}
"""Settings that a condition needs before an effect can be centred on the gaze."""


def without_effect(protocol: Protocol) -> Iterator[Problem]:
    """Yield a problem for each setting in the protocol's text that does nothing there.

    Only what is written counts: defaults, and what a level of `quality` fills in, may be idle. What
    a level of a factor writes must do something in one of the conditions that it is part of.
    """
    data = read_toml(protocol.toml, None)
    for path, table, conditions in written_tables(protocol, data):
        if table.get("quality") and not any(map(_has_dials, conditions)):
            message = f"`quality` does nothing without {' or '.join(dialled())}; remove it"
            yield Problem((*path, "quality"), message)
        for index, name in enumerate(table.get("gaze_centre", {}).get("of", ())):
            if not any(name in each.centred_on_gaze for each in conditions):
                message = f"`gaze_centre` centres `{name}`, which is not there; {_ADD[name]}"
                yield Problem((*path, "gaze_centre", "of", index), f"{message} or leave it out")
        for effect, needs in NEEDS.items():
            for key in needs.keys() & table.get(effect, {}).keys():
                reasons = [idle(getattr(each, effect), needs[key]) for each in conditions]
                if reasons and all(reasons):
                    message = f"`{key}` does nothing with {reasons[0]}; remove it or change that"
                    yield Problem((*path, effect, key), message)


def written_tables(
    protocol: Protocol, data: Mapping[str, Any]
) -> Iterator[tuple[KeyPath, Mapping[str, Any], list[Condition]]]:
    """Yield each table of condition settings: its path, its keys and its conditions."""
    for index, table in enumerate(data.get("conditions", ())):
        yield ("conditions", index), table, [protocol.conditions[index]]
    for index, factor in enumerate(data.get("factors", ())):
        for number, table in enumerate(factor["levels"]):
            level = (factor["name"], table["name"])
            having = [each for each in protocol.conditions if level in each.levels.items()]
            yield ("factors", index, "levels", number), table, having


def _has_dials(condition: Condition) -> bool:
    return any(getattr(condition, name) is not None for name in dialled())


def idle(settings: Settings, needs: Needs) -> str | None:
    """Return the choice beside which a setting with these needs does nothing."""
    for choice, values in needs.items():
        value = getattr(settings, choice)
        # Nine rays stand in for a gaze that no headset tracks.
        stand_in = getattr(settings, "without_gaze", None) if value == "gaze" else None
        if value not in values and stand_in not in values:
            return f'{choice} = "{value}"' if isinstance(value, str) else f"{choice} = {value}"
    return None


def adjustment_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield faults of [[adjustments]] and [[sliders]]."""
    yield from repeated(("adjustments",), [each.name for each in protocol.adjustments])
    known = {each.name: each for each in protocol.conditions}
    taken: dict[str, str] = {}
    yield from _of_sliders(protocol, known, taken)
    for index, each in enumerate(protocol.adjustments):
        path: KeyPath = ("adjustments", index)
        found = [*_of_setting(each, path), *_of_conditions(each, path, known)]
        found = found or [*_of_range(each, path, protocol), *_twice(protocol, each, path, taken)]
        yield from found
    if protocol.exposure_ends == "adjustment" and not protocol.adjustments:
        message = "nothing is adjusted in any exposure; add [[adjustments]], or remove this"
        yield Problem(("exposure_ends",), message)


def _of_sliders(
    protocol: Protocol, known: dict[str, Condition], taken: dict[str, str]
) -> Iterator[Problem]:
    adjustments = [each.name for each in protocol.adjustments]
    yield from repeated(("sliders",), [each.name for each in protocol.sliders])
    for index, each in enumerate(protocol.sliders):
        path: KeyPath = ("sliders", index)
        if each.name in adjustments:
            yield Problem(
                (*path, "name"), f"an adjustment is called `{each.name}`, too; rename one"
            )
        for number, name in enumerate(each.conditions):
            if name not in known:
                message = f"there is no condition `{name}`; {did_you_mean(name, known)}"
                yield Problem((*path, "conditions", number), message)
        for name in each.conditions or known:
            if name in taken:
                yield Problem(path, _both(name, taken[name]))
                return
            taken[name] = each.name


def _both(condition: str, taken: str) -> str:
    message = f"`{condition}` has `{taken}` on the dial already; name the `conditions` of each"
    return f"{message}, one dial for an exposure"


def _of_setting(each: Adjustment, path: KeyPath) -> Iterator[Problem]:
    if each.setting in ADJUSTABLE:
        return
    hint = did_you_mean(each.setting, ADJUSTABLE)
    if _is_number(each.setting):
        said = "decides what is built before an exposure, and cannot change during one"
        yield Problem((*path, "setting"), f"`{each.setting}` {said}; {hint}")
    else:
        yield Problem((*path, "setting"), f"no condition has a number `{each.setting}`; {hint}")


def _is_number(setting: str) -> bool:
    """Return whether a condition could have a number there."""
    model: type[BaseModel] = Condition
    *tables, name = setting.split(".")
    try:
        known = fields_at(model, tables)
    except KeyError:
        return False
    return name in known


def _of_conditions(
    each: Adjustment, path: KeyPath, known: dict[str, Condition]
) -> Iterator[Problem]:
    if each.setting not in ADJUSTABLE:
        return
    for number, name in enumerate(each.conditions):
        place = (*path, "conditions", number)
        if name not in known:
            hint = did_you_mean(name, known)
            yield Problem(place, f"there is no condition `{name}`; {hint}")
        elif reason := why_not(known[name], each.setting):
            yield Problem(place, f"`{each.setting}` does nothing in `{name}`: {reason}")
    reasons = [(name, why_not(known[name], each.setting)) for name in known]
    if not each.conditions and all(reason for _, reason in reasons):
        told = "; ".join(f"`{name}`: {reason}" for name, reason in reasons[:3])
        message = f"`{each.setting}` does nothing in any condition ({told})"
        yield Problem((*path, "setting"), f"{message}; add what it needs to one")


def why_not(condition: Condition, setting: str) -> str | None:
    """Return why nothing can be adjusted there in a condition; None where it can."""
    *tables, name = setting.split(".")
    inner: object = condition
    for table in tables:
        inner = getattr(inner, table)
        if inner is None:
            return f"it has no {table}"
    effect = getattr(condition, tables[0])
    if needs := NEEDS.get(tables[0], {}).get(name):
        reason = idle(effect, needs)
        if reason:
            return f"it has {reason}"
    if tables[0] == "focus":
        return _why_not_focus(condition, name)
    if tables[0] == "depth_of_field" and effect.views > 1:
        return "views > 1 are drawn from the points of one lens"
    if tables[0] == "depth_of_field" and effect.kernel == "mip_slices" and effect.slices_m:
        return "slices_m decide its blur"
    return None


def _why_not_focus(condition: Condition, name: str) -> str | None:
    if condition.depth_of_field is None:
        return "it has no depth_of_field"
    method = condition.focus.method
    if name == "infinity_m" and method not in {"nine_ray", "gaze"}:
        return f'its focus has the method "{method}"'
    return None


def _of_range(each: Adjustment, path: KeyPath, protocol: Protocol) -> Iterator[Problem]:
    low, high = each.range
    if low >= high:
        yield Problem((*path, "range"), "the second value must be more than the first")
        return
    if each.scale == "log" and low <= 0:
        message = 'scale = "log" needs a range above 0; raise its lowest value'
        yield Problem((*path, "range"), message)
        return
    for condition in adjusted_conditions(protocol, each):
        for value in each.range:
            changed = adjusted(condition, each.setting, value)
            try:
                Condition.model_validate(changed.model_dump())
            except ValidationError as error:
                said = in_words(error.errors()[0])
                message = f"`{condition.name}` cannot have {each.setting} = {value:g}: {said}"
                yield Problem((*path, "range"), message)
                return
        own = value_of(condition, each.setting)
        if each.start == "setting" and (own is None or not low <= own <= high):
            says = "does not say it" if own is None else f"has {own:g}, which the range does not"
            message = f'start = "setting", and `{condition.name}` {says}; change one of them'
            yield Problem((*path, "start"), message)
            return


def _twice(
    protocol: Protocol, each: Adjustment, path: KeyPath, taken: dict[str, str]
) -> Iterator[Problem]:
    """Yield a problem where the same button would mean two things in an exposure."""
    for condition in adjusted_conditions(protocol, each):
        if condition.name in taken:
            yield Problem(path, _both(condition.name, taken[condition.name]))
            return
        taken[condition.name] = each.name
        if task := _task_beside(protocol, condition):
            message = f"exposures to `{condition.name}` have the task `{task}`, and both take the "
            yield Problem(path, f'{message}same button; give them `task = "{NO_TASK}"`')
            return


def _task_beside(protocol: Protocol, condition: Condition) -> str | None:
    trials = (
        trial
        for sequence in protocol.order.sequences
        for session in sequence.sessions
        for trial in session
        if trial.condition == condition.name
    )
    of_parts = (
        trial
        for _, _, order in written_orders(protocol.parts)
        for trial in order.trials
        if trial.condition == condition.name
    )
    each_task = [trial.task for trial in (*trials, *of_parts)]
    named = [task for task in each_task if task not in (None, NO_TASK)]
    usual = condition.task or protocol.task
    return next(iter(named), None) or (None if usual == NO_TASK else usual)


def adjusted_conditions(protocol: Protocol, each: Adjustment) -> list[Condition]:
    """Return the conditions in which something is adjusted."""
    if each.conditions:
        return [known for known in protocol.conditions if known.name in each.conditions]
    return [known for known in protocol.conditions if why_not(known, each.setting) is None]
