"""One line of the list of passes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PlannedPass:
    """One pass, whether it is there, and the reason in words."""

    name: str
    needed: bool
    reason: str
