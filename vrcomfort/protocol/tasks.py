"""The tasks that a protocol names: found, and, where they are run, the lab's own code."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError

from vrcomfort.errors import InputError
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import NO_TASK, written_orders
from vrcomfort.settings import KeyPath, Problem, did_you_mean, problems_of, repeated
from vrcomfort.tasks import OwnTask, TaskSettings, own_task_file, run_task_file


def find_tasks(protocol: Protocol) -> tuple[dict[str, TaskSettings], list[Problem]]:
    """Return name → settings of each task, and the faults. No task file is run."""
    found: dict[str, TaskSettings] = {}
    faults = list(repeated(("tasks",), [each.name for each in protocol.tasks]))
    for index, task in enumerate(protocol.tasks):
        if task.name == NO_TASK:
            message = f"`{NO_TASK}` says that there is no task; give this one another name"
            faults.append(Problem(("tasks", index, "name"), message))
        found[task.name] = task
        if isinstance(task, OwnTask):
            try:
                own_task_file(_folder(protocol), task.kind)
            except InputError as error:
                faults.append(Problem(("tasks", index, "kind"), str(error)))
    return found, faults + list(_unknown(protocol))


def with_task_code(protocol: Protocol) -> Protocol:
    """Return the protocol with its own tasks ready to start: this runs their Python files.

    Only what is about to hold a session calls it. Until then the settings of an own task are an
    `OwnTask`, whatever keys they have.

    Raises
    ------
    InputError
        If a file cannot be run, or does not take the settings.
    """
    own = [(k, task) for k, task in enumerate(protocol.tasks) if isinstance(task, OwnTask)]
    ready, ran, faults = dict(protocol._tasks), {}, []
    for index, task in own:
        try:
            model, ran[task.kind] = run_task_file(own_task_file(_folder(protocol), task.kind))
            ready[task.name] = model.model_validate(task.model_dump(), strict=True)
        except InputError as error:
            faults.append(Problem(("tasks", index, "kind"), str(error)))
        except ValidationError as error:
            faults += [
                Problem(("tasks", index, *each.path), each.message, each.missing)
                for each in problems_of(model, error)
            ]
    if faults:
        raise protocol.first_fault(faults)
    prepared = protocol.model_copy()
    prepared._tasks, prepared._task_code = ready, ran
    return prepared


def _folder(protocol: Protocol) -> Path:
    return protocol.file.parent if protocol.file else Path()


def _unknown(protocol: Protocol) -> Iterator[Problem]:
    known = [task.name for task in protocol.tasks]
    for path, name in _named(protocol):
        if name not in (None, NO_TASK, *known):
            hint = did_you_mean(str(name), known) if known else "add it to [[tasks]]"
            yield Problem(path, f"there is no task `{name}`; {hint}")


def _named(protocol: Protocol) -> Iterator[tuple[KeyPath, str | None]]:
    yield ("task",), protocol.task
    if not protocol.factors:
        for index, condition in enumerate(protocol.conditions):
            yield ("conditions", index, "task"), condition.task
    for index, factor in enumerate(protocol.factors):
        for number, level in enumerate(factor.levels):
            yield ("factors", index, "levels", number, "task"), level.task
    for index, sequence in enumerate(protocol.order.sequences):
        for session, trials in enumerate(sequence.sessions):
            for number, trial in enumerate(trials):
                path = ("order", "sequences", index, "sessions", session, number, "task")
                yield path, trial.task
    for index, part, order in written_orders(protocol.parts):
        for number, trial in enumerate(order.trials):
            yield ("parts", index, "orders", part, "trials", number, "task"), trial.task
    for index, practice in enumerate(protocol.practice):
        for number, trial in enumerate(practice.trials):
            yield ("practice", index, "trials", number, "task"), trial.task
