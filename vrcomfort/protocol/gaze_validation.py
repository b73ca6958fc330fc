"""Validation of an eye tracker, and the eyes of simulated participants."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.settings import Settings

Angle = Annotated[float, Field(ge=-60, le=60)]
Metres = Annotated[float, Field(ge=0.2, le=1000)]
Point = tuple[Angle, Angle, Metres]


class GazeValidation(Settings):
    """Points that participants look at before the exposures: how far off the eye tracker is.

    The calibration is the headset's own; this measures what it is worth, as Mantiuk et al. (2011)
    did, who ended sessions with an error above 1.5 degrees.
    """

    points: Annotated[tuple[Point, ...], Field(min_length=1, max_length=50)] = (
        (0.0, 0.0, 1.0),
        (-10.0, 0.0, 1.0),
        (10.0, 0.0, 1.0),
        (0.0, 8.0, 1.0),
        (0.0, -8.0, 1.0),
        (-7.0, 6.0, 3.0),
        (7.0, 6.0, 3.0),
        (-7.0, -6.0, 3.0),
        (7.0, -6.0, 3.0),
    )
    """[degrees to the right, degrees up, metres] from where the head looks as each appears."""
    each_s: Annotated[float, Field(ge=0.3, le=60)] = 1.5
    """How long each is shown."""
    settle_s: Annotated[float, Field(ge=0, le=30)] = 0.7
    """After it appeared: time in which the eyes are on their way, and nothing counts."""
    diameter_deg: Annotated[float, Field(ge=0.1, le=5)] = 0.5
    """Angle at which a point is seen."""
    limit_deg: Annotated[float, Field(gt=0, le=45)] = 1.5
    """Largest mean error over the points that is good enough."""
    attempts: Annotated[int, Field(ge=1, le=10)] = 2
    """So often in all, while the error is above the limit."""
    above: Literal["end_session", "end_study", "note"] = "end_session"
    """What an error above the limit in the last attempt does."""
    after_breaks: bool = True
    """Again after each break between exposures: the headset may have been off."""

    @model_validator(mode="after")
    def _settles(self) -> Self:
        if self.settle_s >= self.each_s:
            message = "nothing of a point would count: make `settle_s` shorter than `each_s`"
            raise PydanticCustomError("gaze_settle", message)
        return self


class SimulatedEyes(Settings):
    """Eyes of simulated participants, where a headset or trace has none.

    Fixations of log-normal length at places spread about the head's forward direction, saccades on
    the main sequence (Bahill et al. 1975), blinks, and the error of a tracker: an offset for each
    person, another for each of their eyes, and noise.
    """

    fixation_s: Annotated[float, Field(ge=0.05, le=60)] = 0.3
    """Median length of a fixation."""
    spread_deg: tuple[
        Annotated[float, Field(ge=0, le=45)], Annotated[float, Field(ge=0, le=45)]
    ] = (10.0, 7.0)
    """Standard deviation of where they look, to the side and up."""
    blink_every_s: Annotated[float, Field(ge=0.5, le=3600)] = 4.0
    """Mean time between two blinks."""
    blink_s: Annotated[float, Field(ge=0.01, le=1)] = 0.15
    """How long a blink lasts, in which the tracker sees nothing."""
    error_deg: Annotated[float, Field(ge=0, le=30)] = 0.5
    """Standard deviation, over people and along each axis, of the tracker's offset."""
    eye_error_deg: Annotated[float, Field(ge=0, le=30)] = 0.3
    """The same of what each eye's own line of sight is off besides."""
    noise_deg: Annotated[float, Field(ge=0, le=10)] = 0.1
    """Standard deviation of a sample around it, along each axis."""
    pupil_mm: Annotated[float, Field(ge=1, le=10)] = 4.0
    """Diameter of the pupils that the tracker tells."""
