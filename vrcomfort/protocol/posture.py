"""Whether participants sit or stand, and from which height they see the scene."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.frame import EYE_HEIGHT_M
from vrcomfort.settings import Settings


class Posture(Settings):
    """The height of the eyes is measured; without this table nothing is."""

    mode: Literal["seated", "standing"]
    """How participants are meant to be; they are asked to, and it is recorded."""
    eyes: Literal["scene", "own"] = "scene"
    """`scene`: the floor of the scene is moved, so that everybody sees from `eye_height_m`. `own`:
    from their own height over the floor, which is only recorded."""
    eye_height_m: Annotated[float, Field(ge=0.3, le=3)] = EYE_HEIGHT_M
    """Over the floor of the scene, with `eyes = "scene"`."""
    measure_s: Annotated[float, Field(ge=0.2, le=30)] = 1.0
    """For how long it is measured; the median counts."""
    settle_s: Annotated[float, Field(ge=0, le=30)] = 2.0
    """Time before that, in which people sit or stand up straight."""
    after_breaks: bool = True
    """Measured again after breaks, as well as when a session begins."""

    @model_validator(mode="after")
    def _height_does_something(self) -> Self:
        if self.eyes == "own" and "eye_height_m" in self.model_fields_set:
            message = '`eye_height_m` does nothing with eyes = "own"; remove it or change that'
            raise PydanticCustomError("posture_height", message)
        return self
