"""Settings of the effect `grey`: what a protocol writes under [conditions.grey]."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from vrcomfort.settings import Settings


class Grey(Settings):
    """Takes colour out of the image; luminance stays."""

    amount: Annotated[float, Field(ge=0, le=1)] = 1.0
    """0 leaves the colours, 1 leaves none."""
