"""Draws the panel's pages with Pillow, and reads pictures for them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vrcomfort.errors import InputError
from vrcomfort.files import open_file
from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.respondent.base import InstructionContent
from vrcomfort.respondent.panel_layout import (
    ANSWER_TOP_PX,
    FOOT_TOP_PX,
    HINT_PX,
    MARGIN_PX,
    SIZE_PX,
    SMALL_PX,
    Act,
    Cell,
    instruction_cells,
    stop_cells,
)
from vrcomfort.text_layout import Font, TextCanvas, font_for, usual_font

BACKGROUND = 28, 32, 38, 255
CELL, POINTED, CHOSEN = (54, 62, 72, 255), (38, 120, 190, 255), (30, 98, 62, 255)
STOP = 112, 44, 44, 255
TEXT, QUIET = (240, 240, 240, 255), (176, 184, 194, 255)

LOOKED = 255, 210, 80, 255
FRAME_PX, BAR_PX = 6, 14
"""Of a cell that a look has prepared, and of how far a look has come."""

LARGE_PX, MIDDLE_PX = 60, 38
QUESTION_TOP_PX, QUESTION_PX = 190, (LARGE_PX, 52, 44, MIDDLE_PX, SMALL_PX)
"""Where a question begins, and the sizes that it may have: a long one is smaller."""

INSTRUCTION_TOP_PX, INSTRUCTION_BOTTOM_PX, LEADING_PX = MARGIN_PX, FOOT_TOP_PX - 60, 12
"""Vertical limits of an instruction: above the line of hints."""
INSTRUCTION_PX = (46, MIDDLE_PX, SMALL_PX)

Picture = NDArray[np.uint8]

STEPS = 8
"""Steps in which the progress of a look is drawn."""


@dataclass(frozen=True)
class DwellProgress:
    """The panel's marks of a look.

    Parameters
    ----------
    cell
        The one that is looked at.
    step
        How far the look has come, of `STEPS`.
    prepared
        The cell whose next look chooses it.
    """

    cell: Cell | None = None
    step: int = 0
    prepared: Cell | None = None


@dataclass(frozen=True)
class Page:
    """The content of a panel.

    Parameters
    ----------
    title
        The small line at the top.
    question
        The large lines below it, empty on the list of all answers.
    cells
        What can be chosen.
    ends
        Names of both ends of a slider.
    done
        Fraction of the questionnaire that is answered.
    chosen
        The answer given before, if this question is open again.
    hint
        How to answer, in small letters.
    content
        What is told, in place of a question.
    """

    title: str
    question: str
    cells: Sequence[Cell]
    ends: tuple[str, str] | None = None
    done: float | None = None
    chosen: int | None = None
    hint: str = ""
    content: InstructionContent | None = None

    @property
    def font(self) -> Font:
        """Return the font that has all its characters."""
        told = self.content.text if self.content else ""
        cells = (cell.text for cell in self.cells)
        return font_for(self.title, self.question, self.hint, *(self.ends or ()), told, *cells)


def instruction_page(content: InstructionContent, words: Words = ENGLISH, *, ready: bool) -> Page:
    """Return the page of an instruction; with a button to go on, if `ready`."""
    nothing = not content.text and content.picture is None
    shown = replace(content, text=words.listen_sound) if nothing else content
    return Page("", "", instruction_cells(words, ready=ready), content=shown)


def stop_page(words: Words = ENGLISH) -> Page:
    """Return the page that asks to confirm a stop."""
    return Page("", words.sure, stop_cells(words))


class Painter:
    """Draws pages; keeps the last one, because text takes long.

    A pointed cell is a small picture on a copy of the page.
    """

    def __init__(self) -> None:
        self._page: Page | None = None
        self._font = usual_font()
        self._pixels: Picture = np.empty((*SIZE_PX[::-1], 4), dtype=np.uint8)
        self._cells: dict[Cell, Picture] = {}

    def draw(self, page: Page, pointed: Cell | None, looks: DwellProgress | None = None) -> Picture:
        """Return the page as (height, width, 4) pixels, with a pointed cell in its colour.

        Parameters
        ----------
        looks
            How far a look has come, as a bar at the foot of its cell; the cell that the next look
            chooses has a frame.
        """
        if page is not self._page:
            self._page, self._font = page, page.font
            self._pixels = np.asarray(_draw_page(page, self._font))
            self._cells.clear()
        picture = self._pixels.copy()
        if pointed is not None:
            left, top, right, bottom = _around(pointed)
            picture[top:bottom, left:right] = self._pointed_cell(pointed)
        if looks is not None:
            _draw_looks(picture, looks)
        return picture

    def _pointed_cell(self, cell: Cell) -> Picture:
        kept = self._cells.get(cell)
        if kept is None:
            left, top, right, bottom = _around(cell)
            image = Image.fromarray(self._pixels[top:bottom, left:right])
            _draw_cell(TextCanvas(image, self._font), cell, POINTED, corner=(left, top))
            kept = self._cells[cell] = np.asarray(image)
        return kept


def _around(cell: Cell) -> tuple[int, int, int, int]:
    """Return the pixels that a cell covers, from left and top, up to right and bottom."""
    left, top, right, bottom = cell.box
    return left, top, right + 1, bottom + 1


def _draw_looks(picture: Picture, looks: DwellProgress) -> None:
    if looks.prepared is not None:
        left, top, right, bottom = _around(looks.prepared)
        for rows, columns in (
            (slice(top, bottom), slice(left, left + FRAME_PX)),
            (slice(top, bottom), slice(right - FRAME_PX, right)),
            (slice(top, top + FRAME_PX), slice(left, right)),
            (slice(bottom - FRAME_PX, bottom), slice(left, right)),
        ):
            picture[rows, columns] = LOOKED
    if looks.cell is not None and looks.step:
        left, _, right, bottom = _around(looks.cell)
        done = left + (right - left) * looks.step // STEPS
        picture[bottom - BAR_PX : bottom, left:done] = LOOKED


def _draw_page(page: Page, font: Font) -> Image.Image:
    image = Image.new("RGBA", SIZE_PX, BACKGROUND)
    canvas = TextCanvas(image, font)
    _draw_head(canvas, page)
    for cell in page.cells:
        _draw_cell(canvas, cell, _colour(cell, page))
    if page.ends is not None:
        _draw_ends(canvas, page)
    if page.content is not None:
        _draw_instruction(image, canvas, page.content)
    canvas.write((SIZE_PX[0] / 2, HINT_PX), page.hint, SMALL_PX, fill=QUIET, anchor="mm")
    return image


def _draw_head(canvas: TextCanvas, page: Page) -> None:
    width = SIZE_PX[0] - 2 * MARGIN_PX
    title = canvas.wrapped(page.title, SMALL_PX, width)
    canvas.write((MARGIN_PX, 36), title, SMALL_PX, fill=QUIET, leading_px=10)
    _draw_question(canvas, page.question, width)
    if page.done is not None:
        canvas.rectangle((MARGIN_PX, 132, MARGIN_PX + width, 144), fill=CELL)
        canvas.rectangle((MARGIN_PX, 132, MARGIN_PX + width * page.done, 144), fill=POINTED)


def _draw_question(canvas: TextCanvas, question: str, width: float) -> None:
    """Draw the question as large as it has room for above its answers."""
    for size in QUESTION_PX:
        text = canvas.wrapped(question, size, width)
        bottom = QUESTION_TOP_PX + canvas.height_px(text, size, leading_px=LEADING_PX)
        if bottom <= ANSWER_TOP_PX - 8 or size == QUESTION_PX[-1]:
            break
    canvas.write((MARGIN_PX, QUESTION_TOP_PX), text, size, fill=TEXT, leading_px=LEADING_PX)


def _draw_instruction(image: Image.Image, canvas: TextCanvas, content: InstructionContent) -> None:
    """Draw words from the top, and a picture in the middle of the room below them."""
    top = INSTRUCTION_TOP_PX
    if content.text:
        size, height = _instruction_size(canvas, content)
        text = _paragraphs(canvas, content.text, size)
        canvas.write((MARGIN_PX, top), text, size, fill=TEXT, leading_px=LEADING_PX)
        top += height + MARGIN_PX
    if content.picture is not None:
        drawn = Image.fromarray(content.picture)
        left = (SIZE_PX[0] - drawn.width) // 2
        above = top + max(INSTRUCTION_BOTTOM_PX - top - drawn.height, 0) // 2
        image.alpha_composite(drawn, (left, above))


def _instruction_size(canvas: TextCanvas, content: InstructionContent) -> tuple[int, int]:
    """Return the largest size in which words leave room for their picture, and their height."""
    room = INSTRUCTION_BOTTOM_PX - INSTRUCTION_TOP_PX
    if content.picture is not None:
        room -= content.picture.shape[0] + MARGIN_PX
    for size in INSTRUCTION_PX:
        text = _paragraphs(canvas, content.text, size)
        height = canvas.height_px(text, size, leading_px=LEADING_PX)
        if height <= room:
            break
    return size, round(height)


def _paragraphs(canvas: TextCanvas, text: str, size_px: int) -> str:
    width = SIZE_PX[0] - 2 * MARGIN_PX
    return "\n".join(canvas.wrapped(line, size_px, width) for line in text.strip().split("\n"))


def room_for_picture(text: str) -> tuple[int, int]:
    """Return the (width, height) that a picture may have on the panel below a text, in pixels.

    The height is negative where not even the text has room.
    """
    height = INSTRUCTION_BOTTOM_PX - INSTRUCTION_TOP_PX
    if text:
        page = instruction_page(InstructionContent("", text), ready=True)
        canvas = TextCanvas(Image.new("RGBA", (1, 1)), page.font)
        lines = _paragraphs(canvas, text, SMALL_PX)
        height -= round(canvas.height_px(lines, SMALL_PX, leading_px=LEADING_PX))
        height -= MARGIN_PX if height >= 0 else 0
    return SIZE_PX[0] - 2 * MARGIN_PX, height


def _draw_cell(
    canvas: TextCanvas,
    cell: Cell,
    colour: tuple[int, ...],
    *,
    corner: tuple[int, int] = (0, 0),
) -> None:
    """Draw a cell on a canvas with its upper left pixel at `corner` of the page."""
    left, top, right, bottom = (edge - corner[i % 2] for i, edge in enumerate(cell.box))
    canvas.rounded_rectangle(
        (left, top, right, bottom), radius=min(12, (right - left) // 3), fill=colour
    )
    size, text, room = SMALL_PX, cell.text, right - left - 8
    least = "00" if text.isdecimal() else text  # so that the numbers of a slider are of one size
    if bottom - top > LARGE_PX and canvas.fits(least, MIDDLE_PX, room):
        size = MIDDLE_PX
    elif not text.isdecimal():  # numbers have their neighbours' room
        text = canvas.wrapped(text, size, room, hyphens=True)
    middle = (left + right) / 2, (top + bottom) / 2
    canvas.write(middle, text, size, fill=TEXT, anchor="mm", align="center")


def _draw_ends(canvas: TextCanvas, page: Page) -> None:
    low, high = page.ends or ("", "")
    y = max(cell.box[3] for cell in page.cells if cell.act is Act.ANSWER) + 30
    canvas.write((MARGIN_PX, y), low, SMALL_PX, fill=QUIET, anchor="lm")
    canvas.write((SIZE_PX[0] - MARGIN_PX, y), high, SMALL_PX, fill=QUIET, anchor="rm")


def _colour(cell: Cell, page: Page) -> tuple[int, ...]:
    if cell.act is Act.ANSWER and cell.value == page.chosen:
        return CHOSEN
    return STOP if cell.act in {Act.STOP, Act.WITHDRAW} else CELL


Found = TypeVar("Found")

_FORMATS = ("PNG", "JPEG")


def read_picture(file: Path, room_px: tuple[int, int]) -> Picture:
    """Return a picture as (height, width, 4) pixels.

    Parameters
    ----------
    room_px
        (width, height) that it may have: pictures are shown as they are, never smaller.

    Raises
    ------
    InputError
        If it cannot be read, is neither PNG nor JPEG, or is larger than its room.
    """
    _require_room(file, _opened(file, lambda image: image.size), room_px)
    return _opened(file, lambda image: np.asarray(image.convert("RGBA")))


def _opened(file: Path, look: Callable[[Image.Image], Found]) -> Found:
    try:
        with open_file(file) as stream:
            with warnings.catch_warnings(action="ignore"):  # of large ones, which are refused
                opened = Image.open(stream, formats=_FORMATS)
            with opened:
                return look(opened)
    except Image.DecompressionBombError as error:
        message = "this picture is far larger than the panel; make it smaller"
        raise InputError(message, file=file) from error
    except (OSError, SyntaxError, ValueError) as error:
        message = "this picture cannot be shown or is damaged; save it as PNG or JPEG"
        raise InputError(message, file=file) from error


def _require_room(file: Path, size_px: tuple[int, int], room_px: tuple[int, int]) -> None:
    if size_px[0] > room_px[0] or size_px[1] > room_px[1]:
        width, height = room_px
        message = f"this picture has {size_px[0]} x {size_px[1]} pixels, and the panel has room for"
        raise InputError(f"{message} {width} x {height} here; make it smaller", file=file)
