"""The results as one HTML page."""

from __future__ import annotations

from typing import Any

from vrcomfort.tradeoff import tables
from vrcomfort.tradeoff.sheets import GAIN
from vrcomfort.web_page import inline_svg, page_templates

TEMPLATE = "tradeoff.html.j2"


def render_page(found: dict[str, Any], figures: dict[str, str], sheets: dict[str, str]) -> str:
    """Fill the template.

    Parameters
    ----------
    figures
        SVG text by scene and effect, inlined.
    sheets
        Paths of contact sheets, from the page, by case.
    """
    keys = list(dict.fromkeys((row["scene"], row["effect"]) for row in found["table"]))
    sections = [
        {
            "title": tables.title(*key),
            "name": "_".join(key),
            "rows": [row for row in found["table"] if (row["scene"], row["effect"]) == key],
            "front": next(
                each["front"] for each in found["fronts"] if (each["scene"], each["effect"]) == key
            ),
            "sheets": {n: p for n, p in sheets.items() if n.startswith("_".join((*key, "pose")))},
        }
        for key in keys
    ]
    return (
        page_templates()
        .get_template(TEMPLATE)
        .render(
            r=found,
            sections=sections,
            columns=tables.COLUMNS,
            notes=tables.notes(found),
            verdicts=tables.VERDICT_COLUMNS,
            headline=tables.headline(found),
            both_eyes=[_emphasis(line) for line in tables.both_eyes(found)],
            dials=tables.dials(found),
            figures={name: inline_svg(svg, name) for name, svg in figures.items()},
            gain=GAIN,
        )
    )


def _emphasis(line: str) -> list[str]:
    """Return the parts of a line; every second one stood between asterisks."""
    return line.split("*")
