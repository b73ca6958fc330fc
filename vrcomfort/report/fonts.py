"""The font of the figures, without what only slows its embedding in PDF files.

Matplotlib lays text out itself, but each time a PDF embeds a few letters of DejaVu Sans, its tables
of glyph substitution and of characters (four of them) are read first: half of the time of a PDF.
Copies without them are made once in a program, under a name of their own (as the licence of the
font asks of changed ones), and removed at its end.
"""

from __future__ import annotations

import atexit
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from fontTools.ttLib import TTFont
from matplotlib import font_manager, get_data_path

FAMILY = "vrcomfort Sans"
WHOLE = "DejaVu Sans"
"""The font it is made of; what figures that others open are to name."""
_FILES = ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")
_UNUSED = ("GSUB", "GPOS", "GDEF", "FFTM")
_UNICODE = (3, 10)
"""Platform and encoding of the one table of characters that is kept."""
_NAMES = (1, 4, 6, 16)
"""Family, full name, PostScript name and typographic family."""


@cache
def load_fonts() -> Path:
    """Make the copies known to Matplotlib; return their folder, which goes with the program."""
    folder = TemporaryDirectory(prefix="vrcomfort-fonts-", ignore_cleanup_errors=True)
    atexit.register(folder.cleanup)
    for name in _FILES:
        file = Path(folder.name) / name
        _write_copy(Path(get_data_path()) / "fonts" / "ttf" / name, file)
        font_manager.fontManager.addfont(file)
    return Path(folder.name)


def _write_copy(source: Path, target: Path) -> None:
    with TTFont(source) as font:
        for table in _UNUSED:
            if table in font:
                del font[table]
        font["cmap"].tables = [
            each for each in font["cmap"].tables if (each.platformID, each.platEncID) == _UNICODE
        ]
        for record in font["name"].names:
            if record.nameID in _NAMES:
                record.string = (
                    record.toUnicode().replace(WHOLE, FAMILY).replace("DejaVuSans", "vrcomfortSans")
                )
        font.save(target, reorderTables=False)
