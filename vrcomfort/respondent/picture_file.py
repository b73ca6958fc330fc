"""Pictures for the panel, from PNG and JPEG files."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image

from vrcomfort.errors import InputError
from vrcomfort.respondent.panel_picture import Picture

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
        with warnings.catch_warnings(action="ignore"):  # of large ones, which are refused
            opened = Image.open(file, formats=_FORMATS)
        with opened:
            return look(opened)
    except Image.DecompressionBombError as error:
        message = "this picture is far larger than the panel; make it smaller"
        raise InputError(message, file=file) from error
    except (OSError, SyntaxError, ValueError) as error:
        message = "this is no picture that can be shown, or it is damaged; save it as PNG or JPEG"
        raise InputError(message, file=file) from error


def _require_room(file: Path, size_px: tuple[int, int], room_px: tuple[int, int]) -> None:
    if size_px[0] > room_px[0] or size_px[1] > room_px[1]:
        width, height = room_px
        message = f"this picture has {size_px[0]} x {size_px[1]} pixels, and the panel has room for"
        raise InputError(f"{message} {width} x {height} here; make it smaller", file=file)
