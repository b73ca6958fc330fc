"""Analysis plans: what is compared, how, and which tests form a family. Read from TOML."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from vrcomfort.errors import InputError
from vrcomfort.protocol.conditions import Settings
from vrcomfort.protocol.locate import locate
from vrcomfort.resources import data_folder

Outcome = Literal["T", "N", "O", "D"]
Column = Literal["condition", "scene", "position", "session"]


class Contrast(Settings):
    """Two conditions; differences are `a` minus `b`."""

    a: str
    b: str


class Factor(Settings):
    """A within-participant factor of the ANOVA."""

    name: str
    column: Column
    levels: dict[str, str] = Field(default_factory=dict)
    """Value of the column → level of the factor; values not listed keep their name."""


class Plan(Settings):
    """One analysis, decided before the data are seen."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]
    title: str
    citation: str = ""
    note: str = ""
    """A sentence about the choices made, printed with the methods."""
    instrument: Literal["ssq"] = "ssq"
    outcomes: Annotated[tuple[Outcome, ...], Field(min_length=1)] = ("T", "N", "O", "D")
    family: tuple[Outcome, ...] = ("T", "N", "O", "D")
    """Outcomes whose p values are adjusted together (Holm), over all contrasts."""
    contrasts: tuple[Contrast, ...] = ()
    """Empty: every pair of conditions, in the order of the protocol."""
    alternative: Literal["two-sided", "greater", "less"] = "two-sided"
    """`greater`: more discomfort under a."""
    zeros: Literal["pratt", "wilcox"] = "pratt"
    rank_biserial_interval: Literal["effectsize", "nonzero_differences"] = "effectsize"
    """The n in the interval's standard error. R's ``effectsize`` counts the non-zero scores of
    condition a; the non-zero differences are the n that the formula is for."""
    confidence: Annotated[float, Field(gt=0.5, lt=1)] = 0.95
    baseline_timepoint: str = "baseline"
    exposure_timepoint: str = "post"
    recovery_timepoint: str = "recovery"
    anova: tuple[Factor, ...] = (
        Factor(name="condition", column="condition"),
        Factor(name="scene", column="scene"),
    )
    """Factors that have one level in the data are left out."""
    mixed_model: tuple[Column, ...] = ("condition", "scene", "position", "session")
    """Fixed effects of the model of all available data, the most wanted first."""


def load_plan(path: Path | None, *, protocol: str | None = None) -> Plan:
    """Read a plan; without a path, the shipped one of the protocol, or the default.

    Raises
    ------
    InputError
        If the file is missing or wrong, with line and column.
    """
    if path is None:
        shipped = data_folder("analysis")
        own = shipped / f"{protocol}.toml"
        path = own if protocol and own.is_file() else shipped / "default.toml"
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read this analysis plan: {error}", file=path) from error
    try:
        return Plan.model_validate(_tuples(tomllib.loads(text)), strict=True)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"this is not valid TOML: {error}", file=path) from error
    except ValidationError as error:
        raise _fault(error, text, path) from error


def _tuples(value: Any) -> Any:
    """Make lists tuples, which strict validation wants."""
    if isinstance(value, dict):
        return {key: _tuples(item) for key, item in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _fault(error: ValidationError, text: str, path: Path) -> InputError:
    detail = error.errors()[0]
    line, column = locate(text).of(detail["loc"])
    name = ".".join(str(part) for part in detail["loc"])
    what = {"extra_forbidden": "unknown key", "missing": "missing key"}.get(detail["type"])
    message = f"{what} `{name}`" if what else f"`{name}`: {detail['msg'].lower()}"
    return InputError(f"{message} in this analysis plan", file=path, line=line, column=column)
