"""The settings of a patch for a photodiode."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import Settings


class Photodiode(Settings):
    """A patch in a corner of both images, for a photodiode: black, and white in some frames."""

    corner: Literal["upper_left", "upper_right", "lower_left", "lower_right"] = "lower_left"
    """Where it is. Lenses may hide the corners: see what the headset shows there."""
    size_deg: Annotated[float, Field(ge=0.5, le=45)] = 5.0
    """Width and height as angles from the eye."""
    inset_deg: Annotated[float, Field(ge=0, le=60)] = 0.0
    """How far from the edges of the field it begins."""
    white: Literal["onset", "every_other_frame"] = "onset"
    """`onset`: for `onset_s` from the first frame of each exposure on. `every_other_frame`: in the
    first drawn frame of each exposure, the third, the fifth …"""
    onset_s: Annotated[float, Field(ge=0.001, le=60)] = 0.1
    """How long it is white with `onset`."""
