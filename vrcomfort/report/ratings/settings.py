"""Settings of the analysis of ratings during exposure."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.settings import Settings

Seconds = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Course = Literal["peak", "mean", "last", "area", "slope"]


class RatingAnalysis(Settings):
    """How courses of ratings during exposure are analysed."""

    instrument: str = ""
    """Whose ratings; empty: the one that was rated most."""
    summaries: Annotated[tuple[Course, ...], Field(min_length=1)] = ("peak", "mean")
    """What sums a course up for the mixed model, the first one first."""
    threshold: Annotated[float, Field(allow_inf_nan=False)] | None = None
    """The rating that is the event of the time to it; None: that of the protocol's stop rule, and
    without one the middle of the scale."""
    times_s: tuple[Seconds, ...] = ()
    """When survival is read, ascending; empty: at quarters of the longest exposure."""
    symptom_model: Literal["none", "fast_slow"] = "none"
    """`fast_slow`: the model of Oman (1990) with the constants of Irmak et al. (2022), fitted to
    each person."""
    fast_s: Seconds = 66.2
    slow_s: Seconds = 502.0
    exponent: Annotated[float, Field(gt=0, le=4)] = 0.4
