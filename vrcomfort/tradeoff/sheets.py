"""Contact sheets: what each method shows, pixel for pixel, and how it differs from R1."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import binary_dilation

from vrcomfort.geometry import Array
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.text_layout import TextCanvas
from vrcomfort.tradeoff.measure import Measured

CROP_PX = 240
"""Larger images are cropped, at 100 %, to where blur changes most."""

GAIN = 8.0
"""Differences of display values are shown this much larger, around middle grey."""

FADED = 0.35
"""How much is left of a picture in the margin that counts in no error."""

COLUMNS = 6
GAP_PX, LABEL_PX, LETTERS_PX = 8, 22, 13
INK, PAPER = (28, 28, 28), (255, 255, 255)


def contact_sheet(found: Measured, exposure: float) -> Image.Image:
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
    """Return the image with a pale margin, and a line around what counts."""
    line = binary_dilation(counted, np.ones((3, 3, 1))) & ~counted
    pale = 1 - FADED * (1 - np.clip(image, 0, 1))
    found: Array = np.where(counted, image, np.where(line, 0.0, pale))
    return found


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
