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
from vrcomfort.tasks.kinds import AnyTask, OwnTask, own_task_file, run_task_file

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
    "TaskFrame",
    "TaskSettings",
    "angle_deg",
    "own_task_file",
    "run_task_file",
]
