"""What a panel and whoever answers on it know of each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from vrcomfort.respondent.panel_picture import Picture


@dataclass(frozen=True)
class Pointing:
    """What the participant does to the panel in one frame.

    Parameters
    ----------
    point
        Where they point, as fractions (right, down) of the panel; None beside it.
    select, back, stop
        True in the one frame in which the button goes down.
    held
        True as long as the button of `select` is down.
    dwelling
        True where they point with their eyes or their head and have no button.
    unable
        True where nothing is seen that could point.
    down_deg
        How far below the horizon they look; None where that is not known.
    looked
        Where they look, as `point`, whatever they point with: to answer what a look has asked.
    hand
        Which controller points (0 left, 1 right).
    arrow, digits, letters, enter
        Presses of arrow keys (right, down), number keys, other keys and Enter in this frame.
    """

    point: tuple[float, float] | None = None
    select: bool = False
    back: bool = False
    stop: bool = False
    held: bool = False
    dwelling: bool = False
    unable: bool = False
    down_deg: float | None = None
    looked: tuple[float, float] | None = None
    hand: int = 1
    arrow: tuple[int, int] = (0, 0)
    digits: str = ""
    letters: str = ""
    enter: bool = False


class Screen(Protocol):
    """A panel in a headset (or a window)."""

    def show(self, picture: Picture | None) -> None:
        """Show a picture from the next frame on, or nothing."""

    def point_at(self, point: tuple[float, float] | None) -> None:
        """Put the pointer at fractions (right, down) of the picture, or take it away."""

    def pointing(self) -> Pointing:
        """Return what the participant does in the current frame."""

    def next_frame(self) -> None:
        """Let a frame pass: for questions outside of exposures."""

    def allow_absence(self, duration_s: float) -> None:
        """Take note that nobody need look for so long."""

    def tick(self, hand: int) -> None:
        """Confirm an answer to the hand that gave it."""
