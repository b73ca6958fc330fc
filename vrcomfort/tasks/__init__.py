"""Tasks of participants during an exposure: one file for each task, and one line in `kinds`."""

from vrcomfort.tasks.base import (
    Ball,
    Demand,
    Moment,
    Pointed,
    Result,
    Surroundings,
    Task,
    TaskSettings,
    angle_deg,
)
from vrcomfort.tasks.kinds import AnyTask, OwnTask, own_task_file, run_task_file

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
    "TaskSettings",
    "angle_deg",
    "own_task_file",
    "run_task_file",
]
