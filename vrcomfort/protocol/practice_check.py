"""Whether practice can be done: its scenes, conditions and tasks, and what it is repeated for."""

from __future__ import annotations

from collections.abc import Iterator

from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import NO_TASK, Trial
from vrcomfort.protocol.order_check import unknown_name
from vrcomfort.protocol.practice import Practice
from vrcomfort.settings import KeyPath, Problem, repeated


def practice_problems(protocol: Protocol) -> Iterator[Problem]:
    """Yield what is wrong with [[practice]] tables."""
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
