"""Settings of the analysis of gaze and head motion."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import Settings

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Zone = Annotated[float, Field(gt=0, le=2)]


class GazeAndHead(Settings):
    """Where people looked and how their heads moved, on a section of the page."""

    situations: Literal["condition", "scene", "task"] = "condition"
    """What is compared: a curve, a map and a spectrum of each. An exposure without a task has the
    task `none`."""
    labels: dict[str, str] = Field(default_factory=dict)
    """Scene or task → its name in figures and tables; without it, its own."""
    zones: Annotated[tuple[Zone, ...], Field(min_length=1)] = (
        0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0,
    )  # fmt: skip
    """Heights of centred zones as shares of the image's."""
    during: tuple[str, ...] = ()
    """Names of events (events.csv), or kinds of rows of tasks.csv, such as `shot`, whose time is
    looked at apart as well."""
    during_s: Positive = 0.5
    """How long an event without a duration of its own lasts."""
    fixations: Literal["i_vt", "i_dt"] = "i_vt"
    """By velocity, or by dispersion."""
    velocity_deg_s: Positive = 30.0
    dispersion_deg: Positive = 1.0
    shortest_fixation_s: Positive = 0.1
    saliency_sigma_deg: Positive = 1.0
    viewpoint_within_m: Positive = 0.25
    """How far the head may be from a scene's viewpoint, of whose fixations a map is made."""
    spectrum_window_s: Positive = 4.0
