"""The panels of a headset and their pointer: made once, shown and hidden as they are needed."""

from __future__ import annotations

from contextlib import suppress

import xr

from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset import pointer
from vrcomfort.headset.openxr.faults import running
from vrcomfort.headset.openxr.layers import MakeCanvas, PanelLayer


class Panels:
    """Panels that stand in the room, and those that wait to be shown again.

    Parameters
    ----------
    make_canvas
        Makes a canvas of a size in pixels.
    """

    def __init__(self, make_canvas: MakeCanvas) -> None:
        self._make_canvas = make_canvas
        self._standing: list[PanelLayer] = []
        self._hidden: list[PanelLayer] = []
        self._pointer: PanelLayer | None = None
        self._points = False

    @running()
    def show(self, size_px: tuple[int, int], quad: Quad) -> PanelLayer:
        """Put a panel into the room: one that was hidden, or a new one."""
        panel = next((each for each in self._hidden if each.size_px == size_px), None)
        if panel is None:
            panel = self._new(size_px, quad)
        else:
            self._hidden.remove(panel)
            panel.move(quad)
        self._standing.append(panel)
        return panel

    @running()
    def prepare(self, size_px: tuple[int, int]) -> None:
        """Make the images of a panel and of the pointer now, so that none are made in a scene."""
        nowhere = Quad(Pose(), (1.0, 1.0))
        self.point(nowhere)
        self.point(None)
        self._hidden.append(self._new(size_px, nowhere))

    @running()
    def point(self, quad: Quad | None) -> None:
        """Put the pointer there, in front of all panels, or take it away."""
        self._points = quad is not None
        if quad is None:
            return
        if self._pointer is None:
            self._pointer = self._new(pointer.SIZE_PX, quad)
            self._pointer.draw(pointer.pointer_picture())
        self._pointer.move(quad)

    @property
    def shown(self) -> list[PanelLayer]:
        """Return what is seen, from back to front."""
        return [*self._standing, *([self._pointer] if self._pointer and self._points else [])]

    def relocate(self, new_from_old: Pose) -> None:
        """Leave all panels where they are in the world: the stage's origin has moved."""
        for panel in self._standing:
            panel.move(Quad(new_from_old @ panel.quad.pose, panel.quad.size_m))

    def release(self) -> None:
        """Release all images; a runtime that is gone keeps nothing."""
        panels = [*self._standing, *self._hidden]
        panels += [] if self._pointer is None else [self._pointer]
        self._standing.clear()
        self._hidden.clear()
        self._pointer = None
        with suppress(xr.exception.ResultException):
            for panel in panels:
                panel.release()

    def _new(self, size_px: tuple[int, int], quad: Quad) -> PanelLayer:
        return PanelLayer(self._make_canvas, size_px, quad, self._put_aside)

    def _put_aside(self, panel: PanelLayer) -> None:
        self._standing.remove(panel)
        self._hidden.append(panel)
