"""Tasks of participants during an exposure: one file for each task, and one line in `kinds`."""

from vrcomfort.tasks.base import (
    Ball,
    Demand,
    Pointed,
    Result,
    Surroundings,
    Task,
    TaskFrame,
    TaskSettings,
    angle_deg,
)
from vrcomfort.tasks.declared import declared_settings
from vrcomfort.tasks.kinds import AnyTask, OwnTask
from vrcomfort.tasks.own_code import (
    TaskCode,
    installed_task,
    own_task_file,
    read_task_code,
    run_installed_task,
)

Moment = TaskFrame
"""The name of `TaskFrame` in version 0.1, for task files of labs."""

__all__ = [
    "AnyTask",
    "Ball",
    "Demand",
    "Moment",
    "OwnTask",
    "Pointed",
    "Result",
    "Surroundings",
    "Task",
    "TaskCode",
    "TaskFrame",
    "TaskSettings",
    "angle_deg",
    "declared_settings",
    "installed_task",
    "own_task_file",
    "read_task_code",
    "run_installed_task",
]
