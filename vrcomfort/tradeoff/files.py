"""Writes what was found: numbers, tables, figures, pictures and a page."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from vrcomfort.json_text import parse_json
from vrcomfort.tradeoff.cases import Case
from vrcomfort.tradeoff.figures import pareto_figure
from vrcomfort.tradeoff.keys import figure_name, key_of_row
from vrcomfort.tradeoff.measure import Measured
from vrcomfort.tradeoff.methods import EFFECTS
from vrcomfort.tradeoff.page import render_page
from vrcomfort.tradeoff.results import COUNTS, REGION_RMS, TRAFFIC
from vrcomfort.tradeoff.sheets import contact_sheet
from vrcomfort.tradeoff.tables import markdown
from vrcomfort.tradeoff.walk import MOTIONS, SCENES

CSV_COLUMNS = (
    "scene", "effect", "pose", "motion", "lens", "window", "method", "family", "step",
    "cost", *TRAFFIC, "effect_ms", "effect_p95_ms", "effect_p99_ms", "frame_ms", "rounds",
    "rms", "psnr_db", "flip", "ssim",
    "filter_rms", "filter_psnr_db", "filter_flip", "filter_ssim",
    *REGION_RMS, "seams", "flicker", *COUNTS,
    "rivalry", "shower_door", "coc_mismatch_px", "seen_by_both",
    "reference_rms", "counts", "samples",
)  # fmt: skip


CASE = tuple(field.name for field in fields(Case))


def write_all(out: Path, found: dict[str, Any], measured: Sequence[Measured]) -> Path:
    """Write everything into `out`, in place of an earlier run's files; return the page's path."""
    _remove_earlier(out)
    for folder in ("figures", "sheets"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    text = json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False)
    (out / "tradeoff.json").write_text(text + "\n", encoding="utf-8")
    _write_csv(out / "tradeoff.csv", found["rows"])
    (out / "tradeoff.md").write_text(markdown(found), encoding="utf-8")
    figures = _write_figures(out / "figures", found)
    sheets = _write_sheets(out / "sheets", found, measured)
    page = out / "index.html"
    page.write_text(render_page(found, figures, sheets), encoding="utf-8")
    return page


def _remove_earlier(out: Path) -> None:
    """Remove the figures and sheets that the run wrote whose numbers are in `out`, and no others.

    Its own ``tradeoff.json`` says which they are; a name is made of what is shipped, never of text
    that could lead out of the folder.
    """
    try:
        numbers = out / "tradeoff.json"
        rows = parse_json(numbers.read_text(encoding="utf-8"), numbers)["rows"]
        earlier = [file for row in rows for file in _pictures_of(row)]
    except (OSError, ValueError, KeyError, TypeError):
        return
    for file in earlier:
        (out / file).unlink(missing_ok=True)


def _pictures_of(row: dict[str, Any]) -> list[str]:
    case = Case(**{name: row[name] for name in CASE})
    if case.scene not in SCENES or case.effect not in EFFECTS or case.motion not in MOTIONS:
        return []
    figure = f"figures/{figure_name((case.scene, case.effect, case.lens))}"
    return [f"{figure}.svg", f"{figure}.png", f"sheets/{case.name}.png"]


def _write_csv(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(
            file, fieldnames=CSV_COLUMNS, extrasaction="ignore", lineterminator="\n"
        )
        writer.writeheader()
        writer.writerows(rows)


def _write_figures(folder: Path, found: dict[str, Any]) -> dict[str, str]:
    """Write the Pareto figures as SVG and PNG; return the SVG texts by scene and effect."""
    texts = {}
    for key in dict.fromkeys(key_of_row(row) for row in found["table"]):
        rows = [row for row in found["table"] if key_of_row(row) == key]
        name = figure_name(key)
        texts[name] = pareto_figure(name, rows, folder)
    return texts


def _write_sheets(
    folder: Path, found: dict[str, Any], measured: Sequence[Measured]
) -> dict[str, str]:
    """Write one contact sheet for each case; return their paths from the page, by case."""
    paths = {}
    for each in measured:
        exposure = found["exposures"][each.case.scene]
        contact_sheet(each, exposure).save(folder / f"{each.case.name}.png")
        paths[each.case.name] = f"{folder.name}/{each.case.name}.png"
    return paths
