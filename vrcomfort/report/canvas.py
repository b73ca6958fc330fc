"""The canvas of figures: SVG with real text, PNG and PDF. The same data give the same bytes."""

from __future__ import annotations

import atexit
import io
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import fill
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from fontTools.ttLib import TTFont
from matplotlib import font_manager, get_data_path
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from vrcomfort.report import palette
from vrcomfort.web_page import escape_hidden

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

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
    """Make the copies known to Matplotlib; return their folder, which goes with the program.

    Matplotlib lays text out itself, but each time a PDF embeds a few letters of DejaVu Sans, its
    tables of glyph substitution and of characters (four of them) are read first: half of the time
    of a PDF. Copies without them are made once in a program, under a name of their own (as the
    licence of the font asks of changed ones), and removed at its end.
    """
    folder = TemporaryDirectory(prefix="vrcomfort-fonts-", ignore_cleanup_errors=True)
    atexit.register(folder.cleanup)
    for name in _FILES:
        file = Path(folder.name) / name
        _write_copy(Path(get_data_path()) / "fonts" / "ttf" / name, file)
        font_manager.fontManager.addfont(file)
    return Path(folder.name)


def _write_copy(source: Path, target: Path) -> None:
    # The time of the copy would go into every PDF.
    with TTFont(source, recalcTimestamp=False) as font:
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


INK, SOFT = palette.INK.light, palette.SOFT.light
FAINT, GRID, PAPER = palette.FAINT.light, palette.GRID.light, palette.PAPER.light
PNG_DPI = 200

_STYLE: dict[Any, Any] = {
    "font.family": [FAMILY, WHOLE],
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": SOFT,
    "axes.facecolor": "none",
    "axes.labelcolor": INK,
    "axes.titlesize": 9.5,
    "figure.facecolor": PAPER,
    "text.color": INK,
    "xtick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.color": SOFT,
    "ytick.labelcolor": INK,
    "lines.solid_capstyle": "round",
    "path.simplify": False,  # a dot is a line without length
    "pdf.fonttype": 42,  # text that can be searched and edited
    "svg.fonttype": "none",
    "text.parse_math": False,  # a name with two dollars is a name, not a formula
}
LONGEST_NAME, LONGEST_WORD, LEGEND = 60, 30, 30
"""Letters that a figure has room for: of a name, of a word in one piece, of a legend's line."""
_FONT = f"'{FAMILY}', '{WHOLE}'"
_FONTS = "'DejaVu Sans', 'Bitstream Vera Sans', Verdana, sans-serif"
"""The font that was measured, and those of its widths on other systems."""
_DECIMALS = re.compile(r"(\.\d\d)\d+")
_PATH = re.compile(r'(?<= d=")[^"]*')
_NEVER: dict[str, dict[str, None]] = {
    "svg": {"Date": None, "Creator": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""Metadata that would differ from day to day and from version to version."""


class Drawing:
    """A drawn figure; PNG and PDF are made on demand."""

    def __init__(self, name: str, width_in: float, height_in: float, tables: Sequence[str]) -> None:
        self._name = name
        self.tables = tuple(tables)
        """Names of the CSV tables with its data."""
        self.figure = Figure(figsize=(width_in, height_in), layout="constrained")
        self.svg = ""
        """With real text, for the page and for files."""

    def finish(self) -> None:
        """Lay the figure out, once for all forms, and write the SVG."""
        engine = self.figure.get_layout_engine()
        if engine is not None and self.figure.axes:
            engine.execute(self.figure)  # to draw without rendering would draw it once more
        self.figure.set_layout_engine("none")
        print_svg = FigureCanvasSVG(self.figure).print_svg
        self.svg = _rounded(_printed(print_svg, _NEVER["svg"]).decode())

    def png(self) -> bytes:
        """Return the figure as pixels, for slides and messages."""
        with style(self._name):
            self.figure.set_dpi(PNG_DPI)
            return _printed(FigureCanvasAgg(self.figure).print_png, _NEVER["png"])

    def pdf(self) -> bytes:
        """Return the figure with its fonts embedded, for print."""
        with style(self._name):
            return _printed(FigureCanvasPdf(self.figure).print_pdf, _NEVER["pdf"])


@contextmanager
def style(name: str) -> Iterator[None]:
    """Draw in the style of the report; the name makes ids that are the same each time."""
    load_fonts()
    with mpl.rc_context({**_STYLE, "svg.hashsalt": name}), warnings.catch_warnings():
        # A box stands for a letter that the font does not have; the page's tables have the letter.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        yield


@contextmanager
def canvas(
    name: str, width_in: float, height_in: float, *tables: str
) -> Iterator[tuple[Figure, Drawing]]:
    """Yield a figure to draw on, and its drawing.

    Parameters
    ----------
    tables
        Names of the CSV tables with the data that are drawn.
    """
    with style(name):
        drawing = Drawing(name, width_in, height_in, tables)
        FigureCanvasAgg(drawing.figure)
        yield drawing.figure, drawing
        drawing.finish()


def _printed(write: Callable[..., Any], metadata: dict[str, None]) -> bytes:
    """Return the bytes of a canvas; `savefig` would draw everything twice."""
    stream = io.BytesIO()
    write(stream, metadata=metadata)
    return stream.getvalue()


def _rounded(svg: str) -> str:
    """Return an SVG with paths to a hundredth of a point, and fonts that other systems have."""
    svg = _PATH.sub(lambda path: _DECIMALS.sub(r"\1", path[0]), svg)
    return svg.replace(_FONT, _FONTS)


def short(name: str) -> str:
    """Return a name as a figure writes it: every character visible, cut where it is long."""
    name = escape_hidden(name)
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"


def lines(name: str, width: int) -> str:
    """Return a name in lines of about `width` letters."""
    name = short(name)
    broken = any(len(word) > LONGEST_WORD for word in name.split())
    return fill(name, width, break_long_words=broken)


def time_unit(longest_s: float) -> tuple[float, str]:
    """Return the seconds of a unit in which a time is easily read, and its name."""
    return (60.0, "min") if longest_s >= 90 else (1.0, "s")


def dots(axes: Axes, x: Floats, y: Floats, colour: str, *, size: float = 4.0, **more: Any) -> None:
    """Draw round dots as one path: an element for each is a large file for a thousand people.

    Not snapped to pixels: the ends of a line this short would meet, and nothing be drawn.
    """
    gap = np.full(x.shape, np.nan)
    across = np.column_stack([x, x + 1e-9, gap]).ravel()
    axes.plot(across, np.column_stack([y, y, gap]).ravel(), "-", color=colour, lw=size,
              snap=False, **more)  # fmt: skip


def threads(axes: Axes, x: Floats, rows: Floats, **more: Any) -> None:
    """Draw a line for each row of a table (people × places) as one path."""
    gap = np.full((len(rows), 1), np.nan)
    across = np.tile(np.append(x, np.nan), len(rows))
    axes.plot(across, np.hstack([rows, gap]).ravel(), "-", **more)


def spread(count: int, half: float) -> Floats:
    """Return places side by side within ± `half`, so that equal values do not hide each other.

    They are those of a golden-ratio sequence: even for any number, the same each time.
    """
    places: Floats = half * (2 * np.mod(0.5 + 0.61803398875 * np.arange(count), 1.0) - 1)
    return places
