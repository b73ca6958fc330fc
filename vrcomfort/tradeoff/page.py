"""The results as one HTML page."""

from __future__ import annotations

from typing import Any

from vrcomfort.tradeoff import tables
from vrcomfort.tradeoff.keys import Key, figure_name, key_of_row, title
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
    groups = list(dict.fromkeys(key_of_row(row) for row in found["table"]))
    sections = [
        {
            "title": title(key),
            "name": figure_name(key),
            "lens": key[1] != "motion_blur",
            "rows": [row for row in found["table"] if key_of_row(row) == key],
            "front": next(each["front"] for each in found["fronts"] if key_of_row(each) == key),
            "sheets": {name: path for name, path in sheets.items() if _is_of(name, key)},
        }
        for key in groups
    ]
    return (
        page_templates()
        .get_template(TEMPLATE)
        .render(
            r=found,
            sections=sections,
            columns=tables.COLUMNS,
            regions=tables.REGION_COLUMNS,
            notes=tables.notes(found),
            verdicts=tables.VERDICT_COLUMNS,
            headline=tables.headline(found),
            both_eyes=[_emphasis(line) for line in tables.both_eyes(found)],
            dials=tables.dials(found),
            figures={name: inline_svg(svg, name) for name, svg in figures.items()},
            gain=GAIN,
        )
    )


def _is_of(name: str, key: Key) -> bool:
    """Return whether the sheet of a case belongs to a group."""
    scene, effect, lens = key
    with_lens = effect == "motion_blur" or f"lens{lens}" in name.split("_")
    return name.startswith(f"{scene}_{effect}_pose") and with_lens


def _emphasis(line: str) -> list[str]:
    """Return the parts of a line; every second one stood between asterisks."""
    return line.split("*")
