"""Shows the operator what the participant sees, at a bounded cost."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import Frame
from vrcomfort.geometry import Quad
from vrcomfort.headset.eye_painter import EyePainter, WindowPanel, fitted
from vrcomfort.headset.inputs import KeyInput
from vrcomfort.headset.window import Window

USUAL_HZ = 15.0

Eyes: TypeAlias = tuple[moderngl.Texture, moderngl.Texture]


class ShownPanel(Protocol):
    """A panel as a headset holds it."""

    @property
    def quad(self) -> Quad:
        """Return where it stands in the stage."""

    @property
    def picture(self) -> NDArray[np.uint8] | None:
        """Return what is on it."""


class Mirror:
    """One eye's image and the panels before it, in a window.

    It copies one image of the two, never waits for the display, and leaves out every frame that
    comes too early. Keys and mouse of its window act for the participant, who may have keyboard
    and mouse before them, as in Carnegie & Rhee (2015).

    Parameters
    ----------
    ctx
        The window's context, which also draws the frames.
    window
        Opened with `wait_for_display` off.
    max_hz
        So often at most.
    eye
        0 left, 1 right.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        window: Window,
        *,
        max_hz: float = USUAL_HZ,
        eye: int = 0,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._ctx, self._window, self._eye = ctx, window, eye
        self._painter = EyePainter(ctx)
        self._between_s = 1 / max_hz
        self._now_s = now_s
        self._next_s = 0.0
        self._panels: dict[ShownPanel, WindowPanel] = {}
        self._asked = False
        self.arrows_turn = False
        """Whether the arrow keys turn a dial; else they walk, or move the choice on a panel."""
        self.shown = 0

    def keys(self) -> KeyInput:
        """Return what the window's keyboard and mouse have done since the last call."""
        return self._window.poll(arrows_walk=not (self._asked or self.arrows_turn))

    def show(self, frame: Frame, eyes: Eyes | None, panels: Sequence[ShownPanel]) -> None:
        """Show a frame, unless the last one was shown a moment ago."""
        self._asked = bool(panels)
        now_s = self._now_s()
        if now_s < self._next_s or self._window.hidden:
            return
        self._next_s = now_s + self._between_s
        self._take(panels)
        image = None if eyes is None else eyes[self._eye]
        screen, view = self._ctx.screen, frame.views[self._eye]
        screen.viewport = (0, 0, *self._window.size_px)
        screen.clear()
        left, right, up, down = view.fov.tangents
        box = fitted(self._window.size_px, (right - left) / (up - down))
        self._painter.paint(screen, box, image, view, list(self._panels.values()))
        self._window.show()
        self.shown += 1

    def _take(self, panels: Sequence[ShownPanel]) -> None:
        """Keep a copy of each panel's picture."""
        pictures = {panel: panel.picture for panel in panels}
        shown = {panel: picture for panel, picture in pictures.items() if picture is not None}
        self._panels = {
            panel: self._panels.get(panel) or self._copy_of(panel, picture)
            for panel, picture in shown.items()
        }
        for panel, picture in shown.items():
            self._panels[panel].quad = panel.quad  # a panel may have been moved
            self._panels[panel].draw(picture)

    def _copy_of(self, panel: ShownPanel, picture: NDArray[np.uint8]) -> WindowPanel:
        height, width = picture.shape[:2]
        return WindowPanel(self._ctx, (width, height), panel.quad)
