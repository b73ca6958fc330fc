"""Plans from files: one's own, and those that are shipped, with the keys of all analyses."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import Field, create_model

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.questionnaire import Instrument
from vrcomfort.report.analyses import ANALYSES
from vrcomfort.report.plan import Plan, problems
from vrcomfort.report.plan.model import FigureName
from vrcomfort.report.sections import SECTIONS
from vrcomfort.resources import data_folder
from vrcomfort.settings import Problem, first_problem, parse_settings


def _entries(entry: Any) -> Any:
    """Return the type of a key: any number of entries."""
    return tuple.__class_getitem__((entry, ...))


_FIGURES = (
    *get_args(FigureName),
    *dict.fromkeys(kind for each in SECTIONS for kind in each.figure_kinds),
    *dict.fromkeys(kind for each in ANALYSES for kind in each.figure_kinds),
)
_KEYS = {
    each.key: (_entries(each.asked), Field(default=(), description=each.about or None))
    for each in ANALYSES
    if each.asked
}
_SETTINGS = {
    each.key: (
        each.asked if each.default else each.asked | None,
        Field(default=each.default, description=each.about),
    )
    for each in SECTIONS
}
_figures = Plan.model_fields["figures"]
AnalysisPlan: type[Plan] = create_model(  # type: ignore[call-overload]
    "Plan",
    __base__=Plan,
    __doc__=Plan.__doc__,
    figures=(
        _entries(Literal.__getitem__(_FIGURES)),
        Field(default=(), description=_figures.description),
    ),
    **_SETTINGS,
    **_KEYS,
)
"""The model of a plan with the key of each analysis, and the names of their figures."""
_FORMER_FAMILY = re.compile(r"^family\s*=", re.MULTILINE)


@dataclass(frozen=True)
class ShippedPlan:
    """A plan that comes with the package."""

    name: str
    title: str
    file: Path


def read_plan(
    text: str, file: Path | None, instruments: Iterable[Instrument] | None = None
) -> Plan:
    """Return the plan that is written in a text.

    Parameters
    ----------
    instruments
        Those that the study has, whose scores may be named; the shipped ones without it.

    Raises
    ------
    InputError
        If it is wrong, with line and column.
    """
    if found := _FORMER_FAMILY.search(text):
        raise InputError(
            "`family` is now a list of tables, so that a plan can have several: write "
            '[[families]] with name = "scores" and outcomes = [...] at the end of the plan',
            file=file,
            line=text.count("\n", 0, found.start()) + 1,
        )
    plan = parse_settings(AnalysisPlan, text, file)
    if faults := [*problems(plan, instruments), *_of_analyses(plan)]:
        raise first_problem(faults, text, file)
    plan._text, plan._file = text, file
    return plan


def _of_analyses(plan: Plan) -> Iterator[Problem]:
    """Yield faults of the analyses' keys beyond their types."""
    for each in ANALYSES:
        yield from each.problems(plan, plan.entries(each.key))


def in_order(plan: Plan) -> dict[str, Any]:
    """Return a plan as results.json has it: the analyses' keys stand after those of the tests."""
    said = plan.model_dump(mode="json")
    asked = {key: said.pop(key) for key in _KEYS if key in said}
    found: dict[str, Any] = {}
    for key, value in said.items():
        found |= {key: value, **(asked if key == "confidence" else {})}
    return found


def load_plan(file: Path, instruments: Iterable[Instrument] | None = None) -> Plan:
    """Read a plan from a file; see `read_plan`.

    Raises
    ------
    InputError
        If the file is missing or wrong, with line and column.
    """
    return read_plan(read_text(file, "analysis plan"), file, instruments)


def shipped_files() -> dict[str, Path]:
    """Return name → file of the plans that come with the package, in the order of names."""
    return {file.stem: file for file in sorted(data_folder("analysis").glob("*.toml"))}


def shipped_plans() -> tuple[ShippedPlan, ...]:
    """Return the plans that come with the package, by name."""
    files = shipped_files().items()
    return tuple(ShippedPlan(name, load_plan(file).title, file) for name, file in files)


def find_plan(name: str | Path) -> Path:
    """Return the file of a plan: a path, or the name of a shipped one.

    Raises
    ------
    InputError
        If there is neither, with the nearest name.
    """
    path = Path(name)
    if path.suffix or len(path.parts) > 1 or path.is_file():
        return path
    shipped = shipped_files()
    if str(name) not in shipped:
        near = get_close_matches(str(name), shipped, n=1, cutoff=0.6)
        known = f"did you mean `{near[0]}`?" if near else f"shipped: {', '.join(shipped)}"
        raise InputError(f"there is no analysis plan `{name}`; {known}")
    return shipped[str(name)]
