"""Rules that tell the experimenter of somebody who perhaps should not be exposed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.protocol.order import Covariate
from vrcomfort.questionnaire import Instrument
from vrcomfort.settings import KeyPath, Problem, Settings, did_you_mean

Bound = Annotated[float, Field(ge=-1e6, le=1e6)]


class Screening(Settings):
    """A number that is told before the first exposure, and decided upon by the experimenter."""

    instrument: str | None = None
    """Asked at the session's start: its score."""
    scale: str | None = None
    """Of the instrument; without it, the one that is reported first."""
    covariate: str | None = None
    """Instead of an instrument: what was entered when they were enrolled; a number."""
    above: Bound | None = None
    """Told where the number is more."""
    below: Bound | None = None
    """Told where it is less."""
    ends: Literal["session", "study"] = "study"
    """What ends where the experimenter stops; after `session` they may come back for the next."""

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.instrument is None) == (self.covariate is None):
            message = "needs an `instrument` or a `covariate`, one of the two"
            raise PydanticCustomError("screening_what", message)
        if self.above is None and self.below is None:
            message = "needs `above` or `below`: from where on it is told"
            raise PydanticCustomError("screening_bounds", message)
        if self.above is not None and self.below is not None and self.below > self.above:
            message = "every number is above the one or below the other; swap `above` and `below`"
            raise PydanticCustomError("screening_bounds", message)
        return self

    def broken(self, number: float) -> str | None:
        """Return the bound that a number is beyond, in words; None where it is within."""
        if self.above is not None and number > self.above:
            return f"above {self.above:g}"
        if self.below is not None and number < self.below:
            return f"below {self.below:g}"
        return None


def screening_problems(
    rules: tuple[Screening, ...],
    at_start: set[str],
    instruments: Mapping[str, Instrument],
    covariates: tuple[Covariate, ...],
) -> Iterator[Problem]:
    """Yield what keeps rules from being looked at.

    Parameters
    ----------
    at_start
        Instruments that are asked at the session's start.
    """
    for index, rule in enumerate(rules):
        path: KeyPath = ("screening", index)
        if rule.instrument is not None:
            yield from _of_instrument(rule, rule.instrument, path, at_start, instruments)
        else:
            yield from _of_covariate(str(rule.covariate), path, covariates)


def _of_instrument(
    rule: Screening,
    name: str,
    path: KeyPath,
    at_start: set[str],
    instruments: Mapping[str, Instrument],
) -> Iterator[Problem]:
    if name not in at_start:
        message = f"`{name}` is not asked at session_start; ask it in [[questionnaires]]"
        yield Problem((*path, "instrument"), message)
        return
    scales = [scale.name for scale in instruments[name].scales]
    if rule.scale is not None and rule.scale not in scales:
        message = f"the {instruments[name].short} has no scale `{rule.scale}`"
        yield Problem((*path, "scale"), f"{message}; {did_you_mean(rule.scale, scales)}")


def _of_covariate(name: str, path: KeyPath, covariates: tuple[Covariate, ...]) -> Iterator[Problem]:
    known = {each.name: each for each in covariates}
    if name not in known:
        hint = did_you_mean(name, known) if known else "declare it in [[covariates]]"
        yield Problem((*path, "covariate"), f"there is no covariate `{name}`; {hint}")
    elif known[name].levels:
        message = f"`{name}` is one of {', '.join(known[name].levels)}, and no number"
        yield Problem((*path, "covariate"), f"{message}; screen by one that is")
