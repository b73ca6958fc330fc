"""Respondents: simulated participants; terminal and panel for real ones."""

from vrcomfort.respondent.base import (
    Exposure,
    Form,
    Heard,
    InstructionContent,
    Respondent,
    Withdrew,
)
from vrcomfort.respondent.simulated import SimulatedRespondent
from vrcomfort.respondent.terminal import TerminalRespondent

__all__ = [
    "Exposure",
    "Form",
    "Heard",
    "InstructionContent",
    "Respondent",
    "SimulatedRespondent",
    "TerminalRespondent",
    "Withdrew",
]
