"""Whether what is adjusted can be: it exists, can change while shown, and does something."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import BaseModel, ValidationError

from vrcomfort.protocol.adjustments import LIVE, Adjustment, adjusted, value_of
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import NO_TASK
from vrcomfort.protocol.parts import written_orders
from vrcomfort.protocol.without_effect import NEEDS, idle
from vrcomfort.settings import KeyPath, Problem, did_you_mean, in_words, repeated
from vrcomfort.settings.hints import fields_at


def adjustment_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield what is wrong with [[adjustments]] and [[sliders]]."""
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
    if each.setting in LIVE:
        return
    hint = did_you_mean(each.setting, LIVE)
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
    if each.setting not in LIVE:
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
    if tables[0] == "focus" and condition.depth_of_field is None:
        return "it has no depth_of_field"
    if tables[0] == "depth_of_field" and effect.views > 1:
        return "views > 1 are drawn from the points of one lens"
    if tables[0] == "depth_of_field" and effect.kernel == "mip_slices" and effect.slices_m:
        return "slices_m decide its blur"
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
