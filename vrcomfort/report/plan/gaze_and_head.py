"""What a plan says of gaze and head motion."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import Settings

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Zone = Annotated[float, Field(gt=0, le=2)]


class GazeAndHead(Settings):
    """Where people looked and how their heads moved, on a section of the page."""

    zones: Annotated[tuple[Zone, ...], Field(min_length=1)] = (
        0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0,
    )  # fmt: skip
    """Heights of centred zones as shares of the image's."""
    during: tuple[str, ...] = ()
    """Names of events (events.csv) whose time is looked at apart as well, such as shooting."""
    fixations: Literal["i_vt", "i_dt"] = "i_vt"
    """By velocity, or by dispersion."""
    velocity_deg_s: Positive = 30.0
    dispersion_deg: Positive = 1.0
    shortest_fixation_s: Positive = 0.1
    saliency_sigma_deg: Positive = 1.0
    spectrum_window_s: Positive = 4.0
    z_scores: bool = False
    """Whether the primary outcome is also given as z scores within each person."""
