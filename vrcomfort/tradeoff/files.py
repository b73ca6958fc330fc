"""Files of a run: numbers, tables, figures, contact sheets and an HTML page."""

from __future__ import annotations

import base64
import csv
import io
import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import binary_dilation

from vrcomfort.files import read_text
from vrcomfort.geometry import Array
from vrcomfort.json_text import parse_json
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.text_layout import TextCanvas
from vrcomfort.tradeoff import tables
from vrcomfort.tradeoff.cases import Case
from vrcomfort.tradeoff.figures import front_figure, pareto_figure
from vrcomfort.tradeoff.measure import MeasuredCase
from vrcomfort.tradeoff.methods import EFFECTS
from vrcomfort.tradeoff.recommendation import BUDGET_MS, Recommendation, recommendations
from vrcomfort.tradeoff.results import (
    COUNTS,
    REGION_RMS,
    TRAFFIC,
    Key,
    figure_name,
    key_of_row,
    title,
)
from vrcomfort.tradeoff.tables import markdown
from vrcomfort.tradeoff.walk import MOTIONS, SCENES
from vrcomfort.web_page import inline_svg, page_templates

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


def write_all(
    out: Path,
    found: dict[str, Any],
    measured: Sequence[MeasuredCase],
    budget_ms: float = BUDGET_MS,
) -> Path:
    """Write everything into `out`, in place of an earlier run's files; return the page's path.

    The page begins with what to choose where a stereo frame may take `budget_ms`.
    """
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
    chosen = [
        {"choice": each, "figure": front_figure(each, out / "figures"),
         "crops": _crops(each, found, measured)}
        for each in recommendations(found, budget_ms)
    ]  # fmt: skip
    page.write_text(render_page(found, figures, sheets, chosen), encoding="utf-8")
    return page


def _remove_earlier(out: Path) -> None:
    """Remove the figures and sheets of the run with its numbers in `out`, and no others.

    Its own ``tradeoff.json`` says which they are; a name is made of what is shipped, never of text
    that could lead out of the folder.
    """
    try:
        numbers = out / "tradeoff.json"
        rows = parse_json(read_text(numbers, "table of the trade-off"), numbers)["rows"]
        earlier = [file for row in rows for file in _pictures_of(row)]
    except (OSError, ValueError, KeyError, TypeError):
        return
    for file in earlier:
        (out / file).unlink(missing_ok=True)


def _pictures_of(row: dict[str, Any]) -> list[str]:
    case = Case(**{name: row[name] for name in CASE})
    if case.scene not in SCENES or case.effect not in EFFECTS or case.motion not in MOTIONS:
        return []
    names = (f"{figure_name((case.scene, case.effect, case.lens))}",
             f"choice_{figure_name(('all', case.effect, case.lens))}")  # fmt: skip
    figures = [f"figures/{name}.{kind}" for name in names for kind in ("svg", "png")]
    return [*figures, f"sheets/{case.name}.png"]


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
    folder: Path, found: dict[str, Any], measured: Sequence[MeasuredCase]
) -> dict[str, str]:
    """Write one contact sheet for each case; return their paths from the page, by case."""
    paths = {}
    for each in measured:
        exposure = found["exposures"][each.case.scene]
        contact_sheet(each, exposure).save(folder / f"{each.case.name}.png")
        paths[each.case.name] = f"{folder.name}/{each.case.name}.png"
    return paths


TEMPLATE = "tradeoff.html.j2"


def render_page(
    found: dict[str, Any],
    figures: dict[str, str],
    sheets: dict[str, str],
    chosen: Sequence[dict[str, Any]] = (),
) -> str:
    """Fill the template.

    Parameters
    ----------
    figures
        SVG text by scene and effect, inlined.
    sheets
        Paths of contact sheets, from the page, by case.
    chosen
        For each :class:`Recommendation` its figure (SVG text) and its crops by scene.
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
            chosen=[
                {
                    **each,
                    "answer": tables.answer(each["choice"], found["scope"]["size_px"]),
                    "figure": inline_svg(each["figure"], f"choice{number}"),
                }
                for number, each in enumerate(chosen)
            ],
            options=tables.OPTION_COLUMNS,
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


CROP_PX = 240
"""Larger images are cropped, at 100 %, to where blur changes most."""

GAIN = 8.0
"""Differences of display values are shown this much larger, around middle grey."""

FADED = 0.35
"""How much is left of a picture in the margin that counts in no error."""

COLUMNS = 6
GAP_PX, LABEL_PX, LETTERS_PX = 8, 22, 13
INK, PAPER = (28, 28, 28), (255, 255, 255)


def contact_sheet(found: MeasuredCase, exposure: float) -> Image.Image:
    """Return a sheet: for each method its picture above its difference from the reference."""
    reference = tone_mapped(found.pictures["reference"], exposure=exposure)
    counted = found.counted
    crop = _crop(reference, tone_mapped(found.pictures["no blur"], exposure=exposure), counted)
    tiles = []
    for name, picture in found.pictures.items():
        shown = tone_mapped(picture, exposure=exposure)
        difference = 0.5 + GAIN * (shown - reference) / 2
        label = "reference (R1)" if name == "reference" else name
        above, below = (_rgb8(_faded(each, counted)[crop]) for each in (shown, difference))
        tiles.append((label, above, below))
    return _sheet(tiles)


def _faded(image: Array, counted: NDArray[np.bool_]) -> Array:
    """Return the image with a pale margin, and a line around the judged part."""
    line = binary_dilation(counted, np.ones((3, 3, 1))) & ~counted
    pale = 1 - FADED * (1 - np.clip(image, 0, 1))
    found: Array = np.where(counted, image, np.where(line, 0.0, pale))
    return found


def _crops(
    choice: Recommendation, found: dict[str, Any], measured: Sequence[MeasuredCase]
) -> dict[str, list[tuple[str, str]]]:
    """Return each scene's crops at 100 % around the chosen level: names and data URIs.

    They are what is next on the front in both directions, no blur and the reference.
    """
    at, front = choice.chosen, choice.front
    near = [("a step cheaper: ", at - 1), ("to choose: ", at), ("a step closer: ", at + 1)]
    near = [(words, i) for words, i in near if 0 <= i < len(front)]
    names = [
        ("no blur", "no blur"),
        *(
            (f"{words}{front[i].label}", front[i].method)
            for words, i in near
            if 0 <= i < len(front)
        ),
        ("brute force", "reference"),
    ]
    crops: dict[str, list[tuple[str, str]]] = {}
    for each in measured:
        case = each.case
        if (case.effect, case.lens) != choice.key[1:] or case.scene in crops:
            continue
        exposure = found["exposures"][case.scene]
        shown = {name: tone_mapped(each.pictures[name], exposure=exposure) for _, name in names}
        where = _crop(shown["reference"], shown["no blur"], each.counted)
        crops[case.scene] = [(label, _data_uri(_rgb8(shown[name][where]))) for label, name in names]
    return crops


def _data_uri(pixels: NDArray[np.uint8]) -> str:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"


def _crop(reference: Array, sharp: Array, counted: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return where a window holds most difference that counts between blurred and sharp."""
    height, width = reference.shape[:2]
    tall, wide = min(height, CROP_PX), min(width, CROP_PX)
    change = np.where(counted, np.abs(reference - sharp), 0.0).sum(axis=-1)
    total = np.pad(change, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    windows = total[tall:, wide:] - total[:-tall, wide:] - total[tall:, :-wide]
    windows += total[:-tall, :-wide]
    top, left = np.unravel_index(int(np.argmax(windows)), windows.shape)
    return slice(int(top), int(top) + tall), slice(int(left), int(left) + wide)


def _sheet(tiles: list[tuple[str, NDArray[np.uint8], NDArray[np.uint8]]]) -> Image.Image:
    height, width, _ = tiles[0][1].shape
    wide = max(width, 160)
    step_x, step_y = wide + GAP_PX, LABEL_PX + 2 * height + 3 * GAP_PX
    columns = min(COLUMNS, len(tiles))
    rows = -(-len(tiles) // columns)
    sheet = Image.new("RGB", (columns * step_x + GAP_PX, rows * step_y + GAP_PX), PAPER)
    canvas = TextCanvas(sheet)
    for index, (label, picture, difference) in enumerate(tiles):
        row, column = divmod(index, columns)
        x, y = GAP_PX + column * step_x, GAP_PX + row * step_y
        canvas.write((x, y + 2), label, LETTERS_PX, fill=INK)
        sheet.paste(Image.fromarray(picture), (x, y + LABEL_PX))
        sheet.paste(Image.fromarray(difference), (x, y + LABEL_PX + height + GAP_PX // 2))
    return sheet


def _rgb8(values: Any) -> NDArray[np.uint8]:
    pixels: NDArray[np.uint8] = np.round(np.clip(values, 0, 1) * 255).astype(np.uint8)
    return pixels
