"""A window with keyboard and mouse (GLFW), and the mirror of a headset in it."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Protocol, Self, TypeAlias

import glfw
import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Quad
from vrcomfort.gpu.gl import MINIMUM_VERSION, VERSION_NAME
from vrcomfort.headset.eye_painter import EyePainter, WindowPanel, fitted
from vrcomfort.headset.inputs import KeyInput

RAD_PER_COUNT = 0.0022
"""Turn of a captured mouse: 0.126° for each of its counts."""

WALKS = {
    glfw.KEY_W: (0, 1),
    glfw.KEY_S: (0, -1),
    glfw.KEY_A: (-1, 0),
    glfw.KEY_D: (1, 0),
}
"""By place on the keyboard, whatever is printed there."""

ARROWS = {
    glfw.KEY_UP: (0, 1),
    glfw.KEY_DOWN: (0, -1),
    glfw.KEY_LEFT: (-1, 0),
    glfw.KEY_RIGHT: (1, 0),
}
"""(right, up or forward)."""

PRESSES = {
    glfw.KEY_ENTER: "enter",
    glfw.KEY_KP_ENTER: "enter",
    glfw.KEY_SPACE: "enter",
    glfw.KEY_BACKSPACE: "back",
    glfw.KEY_ESCAPE: "stop",
}
DIGITS = {first + digit: str(digit) for first in (glfw.KEY_0, glfw.KEY_KP_0) for digit in range(10)}


class Window:
    """A window with an OpenGL context of its own, current in this thread; a context manager.

    Parameters
    ----------
    title
        What its frame says.
    size_px
        (width, height) of the area inside.
    wait_for_display
        Swapping waits for the display, as a participant's window should and a mirror must not.
    drag_turns
        The mouse turns while the left button is held, also where the cursor is not captured.

    Raises
    ------
    InputError
        If there is no display, or no OpenGL of `gpu.gl.MINIMUM_VERSION` on it.
    """

    def __init__(
        self,
        title: str,
        size_px: tuple[int, int],
        *,
        wait_for_display: bool = True,
        drag_turns: bool = False,
    ) -> None:
        self._drag_turns = drag_turns
        self._faults: list[str] = []
        glfw.set_error_callback(self._note_fault)
        if not glfw.init():
            raise InputError(f"no window can be opened ({self._said}); {_remedy()}")
        self._handle = _open(title, size_px)
        if not self._handle:
            glfw.terminate()
            raise InputError(
                f"no window with OpenGL {VERSION_NAME} can be opened ({self._said}); "
                "update the graphics driver"
            )
        glfw.make_context_current(self._handle)
        glfw.swap_interval(int(wait_for_display))
        if wait_for_display:
            glfw.focus_window(self._handle)  # or a mouse is not captured where nothing manages
        glfw.set_key_callback(self._handle, self._on_key)
        glfw.set_mouse_button_callback(self._handle, self._on_button)
        glfw.set_cursor_pos_callback(self._handle, self._on_cursor)
        glfw.set_cursor_enter_callback(self._handle, self._on_enter)
        self._pressed = KeyInput()
        self._cursor: tuple[float, float] | None = None
        self.clicked = False

    def context(self) -> moderngl.Context:
        """Return the window's context; the caller releases it before the window."""
        return moderngl.create_context(require=MINIMUM_VERSION, **_loader())

    @property
    def size_px(self) -> tuple[int, int]:
        """Return (width, height) of the area inside, in pixels of the display."""
        width, height = glfw.get_framebuffer_size(self._handle)
        return int(width), int(height)

    @property
    def refresh_hz(self) -> float | None:
        """Return the rate of the main monitor, where it tells one."""
        monitor = glfw.get_primary_monitor()
        mode = glfw.get_video_mode(monitor) if monitor else None
        return float(mode.refresh_rate) if mode and mode.refresh_rate else None

    @property
    def closing(self) -> bool:
        """Return whether the window has been closed by its user."""
        return bool(glfw.window_should_close(self._handle))

    @property
    def hidden(self) -> bool:
        """Return whether the window is minimised."""
        return bool(glfw.get_window_attrib(self._handle, glfw.ICONIFIED))

    @property
    def focused(self) -> bool:
        """Return whether keys come here."""
        return bool(glfw.get_window_attrib(self._handle, glfw.FOCUSED))

    @property
    def held(self) -> bool:
        """Return whether the left mouse button is held."""
        return bool(glfw.get_mouse_button(self._handle, glfw.MOUSE_BUTTON_LEFT))

    @property
    def looks_aside(self) -> bool:
        """Return whether the right mouse button is held."""
        return bool(glfw.get_mouse_button(self._handle, glfw.MOUSE_BUTTON_RIGHT))

    @property
    def cursor(self) -> tuple[float, float]:
        """Return where the cursor is, as fractions (right, down) of the area inside."""
        x, y = glfw.get_cursor_pos(self._handle)
        width, height = glfw.get_window_size(self._handle)
        return x / max(width, 1), y / max(height, 1)

    @property
    def _captured(self) -> bool:
        return bool(glfw.get_input_mode(self._handle, glfw.CURSOR) == glfw.CURSOR_DISABLED)

    @property
    def _dragging(self) -> bool:
        return self._drag_turns and self.held

    def capture(self, captured: bool) -> None:
        """Hide the cursor and let the mouse turn the head, or give the cursor back."""
        if captured != self._captured:
            mode = glfw.CURSOR_DISABLED if captured else glfw.CURSOR_NORMAL
            glfw.set_input_mode(self._handle, glfw.CURSOR, mode)
            self._cursor = glfw.get_cursor_pos(self._handle)  # a jump is no movement

    def poll(self, *, arrows_walk: bool) -> KeyInput:
        """Return the input of keys and mouse since the last call; `clicked` likewise.

        Parameters
        ----------
        arrows_walk
            The arrow keys walk, as W, A, S and D do; else they move the choice on a panel.
        """
        self.clicked = False
        glfw.poll_events()
        taken, self._pressed = self._pressed, KeyInput()
        if not arrows_walk:
            return replace(taken, walk=self._held(WALKS))
        return replace(taken, arrow=(0, 0), walk=self._held(WALKS | ARROWS))

    def _held(self, keys: dict[int, tuple[int, int]]) -> tuple[int, int]:
        """Return (right, forward) of the keys that are held."""
        held = [way for key, way in keys.items() if glfw.get_key(self._handle, key)]
        right, up = (sum(axis) for axis in zip((0, 0), *held, strict=True))
        return right, up

    def show(self) -> None:
        """Swap the buffers."""
        glfw.swap_buffers(self._handle)

    def close(self) -> None:
        """Close the window and release its context."""
        glfw.destroy_window(self._handle)
        glfw.terminate()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @property
    def _said(self) -> str:
        return "; ".join(self._faults) or "GLFW gives no reason"

    def _note_fault(self, code: int, text: str | bytes) -> None:
        words = text.decode(errors="replace") if isinstance(text, bytes) else text
        self._faults.append(f"{words} ({code:#x})")

    def _on_key(self, _: Any, key: int, scancode: int, action: int, modifiers: int) -> None:
        del modifiers
        if action == glfw.RELEASE:
            return
        now = self._pressed
        if key in ARROWS:
            right, up = ARROWS[key]
            self._pressed = replace(now, arrow=(now.arrow[0] + right, now.arrow[1] - up))
        elif key in DIGITS:
            self._pressed = replace(now, digits=now.digits + DIGITS[key])
        elif key in PRESSES and action == glfw.PRESS:
            changes: dict[str, Any] = {PRESSES[key]: True}
            self._pressed = replace(now, **changes)
        elif action == glfw.PRESS:
            written = (glfw.get_key_name(key, scancode) or "").lower()
            self._pressed = replace(now, letters=now.letters + written)

    def _on_button(self, _: Any, button: int, action: int, modifiers: int) -> None:
        del modifiers
        self.clicked |= button == glfw.MOUSE_BUTTON_LEFT and action == glfw.PRESS

    def _on_enter(self, _: Any, entered: int) -> None:
        del entered
        self._cursor = None  # it comes from elsewhere: no movement

    def _on_cursor(self, _: Any, x: float, y: float) -> None:
        before, self._cursor = self._cursor, (x, y)
        if before is None or not (self._captured or self._dragging):
            return
        now = self._pressed
        self._pressed = replace(
            now,
            turn_rad=now.turn_rad - (x - before[0]) * RAD_PER_COUNT,
            look_up_rad=now.look_up_rad - (y - before[1]) * RAD_PER_COUNT,
        )


def _open(title: str, size_px: tuple[int, int]) -> Any:
    hint: Callable[[int, int], None] = glfw.window_hint
    hint(glfw.CONTEXT_VERSION_MAJOR, MINIMUM_VERSION // 100)
    hint(glfw.CONTEXT_VERSION_MINOR, MINIMUM_VERSION // 10 % 10)
    hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    return glfw.create_window(*size_px, title, None, None)


def _loader() -> dict[str, Any]:
    """Return how moderngl finds the functions of the current context."""
    if sys.platform == "win32":
        return {"libgl": "opengl32.dll"}
    if glfw.get_platform() == glfw.PLATFORM_WAYLAND:
        return {"backend": "egl"}
    return {"libgl": "libGL.so.1", "libx11": "libX11.so.6"}


def _remedy() -> str:
    return "a window needs a graphical session: log in to one, set DISPLAY, or start Xvfb"


# Enough for bystanders; a copy at the display's rate would take time from frames.
USUAL_HZ = 15.0

Eyes: TypeAlias = tuple[moderngl.Texture, moderngl.Texture]


class ShownPanel(Protocol):
    """A panel as a headset holds it."""

    @property
    def quad(self) -> Quad:
        """Return where it stands in the stage."""

    @property
    def picture(self) -> NDArray[np.uint8] | None:
        """Return the panel's present picture."""


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
        """Return the input of the window's keyboard and mouse since the last call."""
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
