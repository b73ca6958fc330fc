"""The R script beside a report, which makes its primary tests again from the CSV tables."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, cast

from vrcomfort.report.analyses import r_functions, r_sections
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.report.analyses.contract import Section

NAME = "reproduce.R"
_FUNCTIONS = "# FUNCTIONS\n"
"""Line of the script at which the functions of analyses stand."""
_PARTS = re.compile("# ANALYSES ([a-z ]+)\n")
"""A line at which the parts of the analyses in some sections of the page stand."""


def r_script() -> str:
    """Return the script; it is the same for every study, and reads its data from tables/."""
    text = (data_folder("analysis") / "report" / NAME).read_text(encoding="utf-8")
    text = text.replace(_FUNCTIONS, _joined(r_functions()))
    return _PARTS.sub(lambda found: _joined(r_sections(*_sections(found[1]))), text)


def _sections(names: str) -> list[Section]:
    return cast("list[Section]", names.split())


def _joined(parts: Iterable[str]) -> str:
    return "".join(parts).lstrip("\n")
