"""Lays text out and draws it: one layout engine and two fonts, the same on every machine.

Pillow takes Raqm where it finds FriBidi's library and its basic layout elsewhere, so its default
draws the same words differently from machine to machine. Basic layout puts one glyph after the
other, from left to right; characters that need more are known here, and never drawn wrong.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Literal

from fontTools.ttLib import TTFont
from PIL import Image, ImageDraw, ImageFont, features

from vrcomfort.errors import InputError

ENGINE = ImageFont.Layout.BASIC
REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
"""Drawn in place of a character that cannot be drawn."""

_RIGHT_TO_LEFT = frozenset(["R", "AL", "AN"])
"""Bidirectional classes of Hebrew, of Arabic, and of Arabic numbers."""
_WHY = {
    "Mn": "combining mark",
    "Mc": "combining mark",
    "Me": "combining mark",
    "Cc": "control character",
    "Cf": "invisible",
    "Zl": "invisible",
    "Zp": "invisible",
}
"""General categories that basic layout draws wrong."""
_NO_MEANING = frozenset(["Co", "Cn", "Cs"])
"""General categories whose glyphs are each font's own: private, not assigned, surrogate."""
_SPACES = re.compile(r"[^\S\u00a0\u2007\u202f]+")
"""Where a line may be broken: at any space but those that forbid it."""


@dataclass(frozen=True, eq=False)
class Font:
    """A font file.

    Parameters
    ----------
    name
        As the manifest has it.
    scale
        Makes its letters about as wide as the other font's in the same size.
    """

    name: str
    scale: float
    file: bytes = field(repr=False)

    @cached_property
    def _tables(self) -> TTFont:
        return TTFont(BytesIO(self.file), lazy=True)

    @cached_property
    def characters(self) -> frozenset[str]:
        """Return the characters that it has glyphs for."""
        return frozenset(map(chr, self._tables.getBestCmap()))

    @property
    def version(self) -> str:
        """Return its version."""
        return f"{round(self._tables['head'].fontRevision, 3):g}"

    def face(self, size_px: int) -> ImageFont.FreeTypeFont:
        """Return the font in a size."""
        return _face(self, round(size_px * self.scale))


@lru_cache(maxsize=96)
def _face(font: Font, size_px: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(BytesIO(font.file), size_px, layout_engine=ENGINE)


@cache
def usual_font() -> Font:
    """Return Pillow's own font, Aileron, which has ASCII and little more."""
    found = ImageFont.load_default(10)
    if not (isinstance(found, ImageFont.FreeTypeFont) and isinstance(found.path, BytesIO)):
        raise InputError("this Pillow was built without FreeType; install it from its wheel")
    return Font("Aileron", 1.0, found.path.getvalue())


@cache
def whole_font() -> Font:
    """Return DejaVu Sans, which comes with Matplotlib, without importing that."""
    spec = find_spec("matplotlib")
    (folder,) = (spec.submodule_search_locations or [""]) if spec else [""]
    file = Path(folder) / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"
    return Font("DejaVu Sans", 0.9, file.read_bytes())  # it is a seventh wider than Aileron


def font_for(*texts: str) -> Font:
    """Return the usual font if it has all characters of some texts, else the whole one."""
    needed = set("".join(map(as_drawn, texts))) - {"\n"}
    return usual_font() if needed <= usual_font().characters else whole_font()


def width_px(text: str, size_px: int) -> float:
    """Return the width of a line in the font that it is drawn in when it stands alone."""
    return font_for(text).face(size_px).getlength(as_drawn(text))


def layout_facts() -> dict[str, str]:
    """Return the versions that text rendering depends on: layout engine, FreeType and fonts."""
    return {
        "engine": f"Pillow {ENGINE.name.lower()}",
        "freetype": features.version("freetype2") or "",
        **{font.name: font.version for font in (usual_font(), whole_font())},
    }


def as_drawn(text: str) -> str:
    """Return a text composed (NFC), with a mark for each character that cannot be drawn."""
    return "".join(REPLACEMENT if _why_not(each) else each for each in composed(text))


def undrawable(text: str) -> list[str]:
    """Return the characters of a text that cannot be drawn, each once, with the reason."""
    return [_named(each) for each in dict.fromkeys(composed(text)) if _why_not(each)]


def composed(text: str) -> str:
    """Return a text in which letters and their marks are one character, where there is one."""
    return unicodedata.normalize("NFC", text.replace("\t", " "))


@lru_cache(maxsize=4096)
def _why_not(character: str) -> str:
    """Return why a character cannot be drawn; nothing where it can."""
    category = unicodedata.category(character)
    if character == "\n":
        return ""
    if category in _WHY:
        return _WHY[category]
    if unicodedata.bidirectional(character) in _RIGHT_TO_LEFT:
        return "right to left"
    known = category not in _NO_MEANING and character in whole_font().characters
    return "" if known else "not in the font"


def _named(character: str) -> str:
    """Return a character as a sentence has it; one that does not stand alone only by its number."""
    why = _why_not(character)
    shown = "" if why in _WHY.values() or not character.isprintable() else f"{character} "
    return f"{shown}U+{ord(character):04X} ({why})"


class TextCanvas(ImageDraw.ImageDraw):
    """Draws in a picture.

    Parameters
    ----------
    text_font
        Of all texts; without it, each has the first font that has its characters.
    """

    def __init__(self, image: Image.Image, text_font: Font | None = None) -> None:
        super().__init__(image)
        self._text_font = text_font

    def _face(self, text: str, size_px: int) -> ImageFont.FreeTypeFont:
        return (self._text_font or font_for(text)).face(size_px)

    def write(
        self,
        place: tuple[float, float],
        text: str,
        size_px: int,
        *,
        fill: tuple[int, ...],
        anchor: str | None = None,
        leading_px: float = 4,
        align: Literal["left", "center"] = "left",
    ) -> None:
        """Write lines at the place of their upper left corner, or of another `anchor`."""
        face, drawn = self._face(text, size_px), as_drawn(text)
        self.text(
            place, drawn, fill=fill, font=face, anchor=anchor, spacing=leading_px, align=align
        )

    def width_px(self, text: str, size_px: int) -> float:
        """Return the width of the widest line."""
        face = self._face(text, size_px)
        return max(self.textlength(line, font=face) for line in as_drawn(text).split("\n"))

    def height_px(self, text: str, size_px: int, *, leading_px: float) -> float:
        """Return the distance from the place where lines are written down to their lower edge."""
        face = self._face(text, size_px)
        box = self.multiline_textbbox((0, 0), as_drawn(text), font=face, spacing=leading_px)
        return box[3]

    def fits(self, text: str, size_px: int, width_px: float) -> bool:
        """Return whether a text in a size is not wider than its room."""
        return self.width_px(text, size_px) <= width_px

    def wrapped(self, text: str, size_px: int, width_px: float, *, hyphens: bool = False) -> str:
        """Return a text in lines that are not wider than its room.

        Parameters
        ----------
        hyphens
            Break words that are wider than their room, anywhere; else these stand out of it.
        """
        return "\n".join(self._lines(text, size_px, width_px, hyphens=hyphens))

    def _lines(self, text: str, size_px: int, width_px: float, *, hyphens: bool) -> Iterator[str]:
        line = ""
        for word in filter(None, _SPACES.split(text)):
            longer = f"{line} {word}" if line else word
            if self.fits(longer, size_px, width_px):
                line = longer
                continue
            if line:
                yield line
            *parts, line = self._broken(word, size_px, width_px) if hyphens else [word]
            yield from parts
        yield line

    def _broken(self, word: str, size_px: int, width_px: float) -> Iterator[str]:
        """Yield the parts of a word that no line can hold, each but the last with a hyphen."""
        while len(word) > 1 and not self.fits(word, size_px, width_px):
            length = len(word) - 1
            while length > 1 and not self.fits(f"{word[:length]}-", size_px, width_px):
                length -= 1
            yield f"{word[:length]}-"
            word = word[length:]
        yield word
