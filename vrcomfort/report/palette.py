"""Colours of the page and its figures: one per condition, the same everywhere, by day and night."""

from __future__ import annotations

from typing import NamedTuple


class Colour(NamedTuple):
    """One meaning on white paper and on a dark screen, as ``#rrggbb``."""

    variable: str
    """The CSS custom property that has it on the page."""
    light: str
    dark: str


PAPER = Colour("--paper", "#ffffff", "#17191d")
INK = Colour("--ink", "#1c1c1e", "#e8e6e1")
SOFT = Colour("--soft", "#59595c", "#a9a8a4")
FAINT = Colour("--faint", "#9b9b9e", "#6d6d70")
GRID = Colour("--grid", "#e4e4e6", "#33363c")
BOX = Colour("--box", "#f4f3f0", "#22252b")

CONDITIONS = (
    Colour("--c0", "#0067a5", "#5bb4ec"),
    Colour("--c1", "#c4500a", "#ff8f4a"),
    Colour("--c2", "#00765a", "#3ccb9d"),
    Colour("--c3", "#9c3f7d", "#e79bcb"),
    Colour("--c4", "#7a6200", "#dfc32e"),
    Colour("--c5", "#4a4a4d", "#c2c2c6"),
)
"""After Okabe & Ito (2008), as dark (as light) as 4.5 to 1 on paper (on a dark screen) asks for.
Neighbours differ in lightness or along blue and yellow, which nearly everybody sees."""
MARKERS = "osD^vP"
"""A shape for each colour, so that colour alone never tells conditions apart."""

ALL = (PAPER, INK, SOFT, FAINT, GRID, BOX, *CONDITIONS)


def colour_of(place: int) -> str:
    """Return the colour of the condition at a place in the order of conditions, for paper."""
    return CONDITIONS[place % len(CONDITIONS)].light


def marker_of(place: int) -> str:
    """Return its shape; where colours come again, shapes do not come with the same ones."""
    return MARKERS[(place + place // len(CONDITIONS)) % len(MARKERS)]


def css_variables(*, dark: bool) -> str:
    """Return the declarations of all colours."""
    return " ".join(f"{c.variable}: {c.dark if dark else c.light};" for c in ALL)
