"""Protocols: a study's stimuli, order, questions and timing, read from TOML and validated."""

from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.protocol.load import (
    load_protocol,
    parse_protocol,
    task_code_of,
    with_task_code,
)
from vrcomfort.protocol.model import Protocol
from vrcomfort.protocol.order import Allocation, Covariate, Group, Order, Sequence, Trial
from vrcomfort.protocol.questions import Ask, Ratings, Unfocused
from vrcomfort.protocol.simulation import Simulation
from vrcomfort.protocol.viewing import SceneView

__all__ = [
    "Allocation",
    "Ask",
    "Condition",
    "Covariate",
    "DepthOfField",
    "Focus",
    "Group",
    "MotionBlur",
    "Order",
    "Protocol",
    "Ratings",
    "SceneView",
    "Sequence",
    "Simulation",
    "Trial",
    "Unfocused",
    "load_protocol",
    "parse_protocol",
    "task_code_of",
    "with_task_code",
]
