"""What a plan says of a measure."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import Name, Settings

Limit = Annotated[float, Field(allow_inf_nan=False)]


class Measured(Settings):
    """An outcome that is no score of a questionnaire: what it is, and what readers call it."""

    name: Name
    measure: str
    """``source.quantity``: ratings.peak, tasks.time_s, participants.age, frames.head_path_m, …"""
    label: str = ""
    unit: str = ""
    better: Literal["lower", "higher", ""] = ""
    """Which direction is the good one."""
    instrument: str = ""
    """Of ratings: which instrument, where several were rated."""
    threshold: Limit | None = None
    """Of ratings.time_to: the rating that is to be reached."""
