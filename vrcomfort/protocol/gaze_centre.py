"""What of a condition is centred on the gaze."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from vrcomfort.settings import Settings

CentredEffect: TypeAlias = Literal["autofocus_zone", "peripheral", "vignette"]


class GazeCentre(Settings):
    """What is centred on the gaze instead of on the head's forward axis.

    While the tracker does not see the eyes, their last direction in the head's frame is held for
    `hold_s`; then the head's forward axis is the centre, until they are seen again.
    """

    of: Annotated[tuple[CentredEffect, ...], Field(min_length=1)]
    """`autofocus_zone`: the zone of `focus`; `peripheral`: the blur of `depth_of_field`;
    `vignette`: its clear field."""
    hold_s: Annotated[float, Field(ge=0, le=60)] = 0.5
    """How long a gaze that is lost counts on: longer than a blink."""
    without_gaze: Literal["stop", "head"] = "stop"
    """What a headset without an eye tracker does: no session, or the centre is the head's axis."""
