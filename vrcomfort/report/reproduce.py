"""The R script beside a report, which makes its primary tests again from the CSV tables."""

from __future__ import annotations

from vrcomfort.resources import data_folder

NAME = "reproduce.R"


def r_script() -> str:
    """Return the script; it is the same for every study and reads what it needs from tables/."""
    return (data_folder("analysis") / "report" / NAME).read_text(encoding="utf-8")
