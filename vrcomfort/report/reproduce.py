"""The R script beside a report, which makes its primary tests again from the CSV tables."""

from __future__ import annotations

from vrcomfort.report.analyses import r_sections
from vrcomfort.resources import data_folder

NAME = "reproduce.R"
_PLACE = "# ANALYSES\n"
"""Line of the script at which the sections of analyses stand."""


def r_script() -> str:
    """Return the script; it is the same for every study and reads what it needs from tables/."""
    text = (data_folder("analysis") / "report" / NAME).read_text(encoding="utf-8")
    return text.replace(_PLACE, "".join(r_sections()).lstrip("\n"))
