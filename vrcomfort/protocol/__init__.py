"""Protocols: what a study shows, asks and when; read from TOML and validated."""

from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.protocol.load import load_protocol, parse_protocol
from vrcomfort.protocol.model import (
    Ask,
    Order,
    Protocol,
    Ratings,
    Sequence,
    Simulation,
    Trial,
    Unfocused,
)

__all__ = [
    "Ask",
    "Condition",
    "DepthOfField",
    "Focus",
    "MotionBlur",
    "Order",
    "Protocol",
    "Ratings",
    "Sequence",
    "Simulation",
    "Trial",
    "Unfocused",
    "load_protocol",
    "parse_protocol",
]
