"""Analysis plans: what is compared, how, and which tests form a family. Read from TOML."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import Instrument
from vrcomfort.resources import data_folder
from vrcomfort.settings import (
    Name,
    Problem,
    Settings,
    did_you_mean,
    first_problem,
    parse_settings,
    read_text,
    repeated,
)

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

    name: Name
    title: str
    citation: str = ""
    note: str = ""
    """A sentence about the choices made, printed with the methods."""
    instrument: str | None = None
    """A shipped instrument by name, or a TOML file relative to the plan; without it, the one that
    the study's exposures have."""
    outcomes: tuple[str, ...] = ()
    """Scales of the instrument; empty: all that the data have, its primary one first."""
    family: tuple[str, ...] = ()
    """Outcomes whose p values are adjusted together (Holm), over all contrasts; empty: all."""
    contrasts: tuple[Contrast, ...] = ()
    """Empty: every pair of conditions, in the order of the protocol."""
    alternative: Literal["two-sided", "greater", "less"] = "two-sided"
    """`greater`: more discomfort under a."""
    zeros: Literal["pratt", "wilcox"] = "pratt"
    shift_interval: Literal["inverted_test", "order_statistics"] = "inverted_test"
    """`inverted_test`: every shift that the printed test does not reject. `order_statistics`: of
    the Walsh averages, as R's ``wilcox.test`` has it; it may contradict p where there are ties."""
    rank_biserial_interval: Literal["normal_shift", "effectsize", "nonzero_differences"] = (
        "normal_shift"
    )
    """`normal_shift`: by inversion over normal differences. The others are Fisher-z intervals, too
    narrow where there is an effect; they differ in the n of the standard error. R's ``effectsize``
    counts the non-zero scores of condition a; the formula is for the non-zero differences."""
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
        own = (file for file in shipped.glob("*.toml") if file.stem == protocol)
        path = next(own, shipped / "default.toml")
    text = read_text(path, "analysis plan")
    plan = parse_settings(Plan, text, path)
    if found := list(_problems(plan)):
        raise first_problem(found, text, path)
    return plan


def instrument_of(plan: Plan, file: Path | None) -> str | None:
    """Return the name of a plan's instrument, or its file as it is to be opened."""
    if plan.instrument is None or file is None or not plan.instrument.endswith(".toml"):
        return plan.instrument
    return str(file.parent / plan.instrument)


def of_the_data(plan: Plan, instrument: Instrument, outcomes: tuple[str, ...]) -> Plan:
    """Return a plan with the instrument and the outcomes that its data have written out."""
    family = plan.family or outcomes
    changes = {"instrument": instrument.name, "outcomes": outcomes, "family": family}
    return plan.model_copy(update=changes)


def check_outcomes(plan: Plan, instrument: Instrument) -> None:
    """Raise `InputError` where a plan names a scale that the instrument does not have."""
    known = list(instrument.outcomes)
    for name in (*plan.outcomes, *plan.family):
        if name not in known:
            what = f"the analysis plan {plan.name} has outcome `{name}`"
            hint = did_you_mean(name, known)
            raise InputError(f"{what}, which is no scale of the {instrument.short}; {hint}")


def _problems(plan: Plan) -> Iterator[Problem]:
    """Yield what the types cannot say."""
    yield from repeated(("outcomes",), plan.outcomes)
    yield from repeated(("family",), plan.family)
    yield from repeated(("mixed_model",), plan.mixed_model)
    yield from repeated(("anova",), [factor.name for factor in plan.anova])
    if plan.outcomes:
        for index, name in enumerate(plan.family):
            if name not in plan.outcomes:
                message = f"`{name}` is adjusted but not among the outcomes; add it there"
                yield Problem(("family", index), message)
    for index, contrast in enumerate(plan.contrasts):
        if contrast.a == contrast.b:
            message = f"condition `{contrast.a}` is compared with itself; name another one"
            yield Problem(("contrasts", index), message)
    for index, factor in enumerate(plan.anova):
        if factor.name in {"participant", "score"}:
            message = f"`{factor.name}` cannot name a factor; choose another word"
            yield Problem(("anova", index, "name"), message)
