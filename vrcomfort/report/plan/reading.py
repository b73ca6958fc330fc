"""Plans from files: one's own, and those that are shipped."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import Instrument
from vrcomfort.report.plan.model import Plan
from vrcomfort.report.plan.rules import problems
from vrcomfort.resources import data_folder
from vrcomfort.settings import first_problem, parse_settings, read_text

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
    plan = parse_settings(Plan, text, file)
    if faults := list(problems(plan, instruments)):
        raise first_problem(faults, text, file)
    plan._text, plan._file = text, file
    return plan


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
