"""Camera paths as protocols and side-cars write them: floor points with times."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from vrcomfort.geometry import FARTHEST_M
from vrcomfort.settings.reading import Settings

_Finite = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M)]


class PathPoint(Settings):
    """Where a camera path is at a time."""

    time_s: Annotated[float, Field(ge=0, le=14_400)]
    """Since the exposure began; the first point is at 0, and they rise."""
    position: tuple[_Finite, _Finite, _Finite]
    """The point under the participant, metres; their eyes are as high above it as they are."""
    yaw_deg: _Finite | None = None
    """Heading, turned to the left from -Z; without it, towards the next point. From one point to
    the next it turns the shorter way, or with `unwrapped` as far as is written."""
    turning_deg_s: Annotated[float, Field(ge=-720, le=720)] | None = None
    """Mean rate of turning from here to the next point, to the left; that has no `yaw_deg` then.
    Where the rate changes at a point, it does so smoothly."""


def _timed(points: tuple[PathPoint, ...]) -> tuple[PathPoint, ...]:
    if points and points[0].time_s != 0:
        raise PydanticCustomError("camera_path", "a path begins at time_s = 0")
    for before, after in pairwise(points):
        if after.time_s <= before.time_s:
            problem = "times must rise: {after} s follows {before} s"
            context = {"after": f"{after.time_s:g}", "before": f"{before.time_s:g}"}
            raise PydanticCustomError("camera_path", problem, context)
        if before.turning_deg_s is not None and after.yaw_deg is not None:
            problem = "the point at {after} s has both a `yaw_deg` and a `turning_deg_s` to it"
            context = {"after": f"{after.time_s:g}"}
            raise PydanticCustomError("camera_path", problem, context)
    if points and points[-1].turning_deg_s is not None:
        raise PydanticCustomError("camera_path", "the last point has nowhere to turn to")
    return points


PathPoints: TypeAlias = Annotated[
    tuple[PathPoint, ...], Field(min_length=2), AfterValidator(_timed)
]
