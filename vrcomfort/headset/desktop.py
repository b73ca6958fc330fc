"""A window that stands in for a headset: keys walk, the mouse turns torso and head."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import moderngl
import numpy as np

from vrcomfort.frame import MEAN_IPD_M, Frame, HeadsetEvent
from vrcomfort.geometry import Fov, Pose, Quad, View, yaw_pitch_roll
from vrcomfort.headset.eye_painter import Box, EyePainter, WindowPanel, fitted
from vrcomfort.headset.inputs import POINTER_SIZE_PX, HandInput, Inputs, KeyInput, pointer_picture
from vrcomfort.headset.locomotion import WALKING_SPEED_M_S, Locomotion, move_command
from vrcomfort.headset.window import Window
from vrcomfort.scene.floors import Floors

SECOND_NS = 1_000_000_000
USUAL_HZ = 60.0
"""Where the monitor does not tell its rate."""

STEEPEST_RAD = np.radians(80.0)
FURTHEST_RAD = np.radians(90.0)
"""Limits of the head's tilt, and of its turn on the torso."""

QUESTION_SHARE, RATING_SHARE = 0.9, 0.7
"""Share of the image that a panel may take: alone, and before a scene."""

Layout = Literal["side_by_side", "one_eye"]


@dataclass(frozen=True)
class DesktopSettings:
    """Settings of `DesktopHeadset`.

    Parameters
    ----------
    image_size_px
        (width, height) of one eye's image; a window of another size shows it scaled.
    layout
        Both eyes side by side (left on the left), or the left eye alone.
    field_rad
        Horizontal field of view of an eye.
    ipd_m
        Distance between the eyes.
    eye_height_m
        Of the eyes above the floor.
    walking_speed_m_s
        Total speed.
    """

    image_size_px: tuple[int, int] = (640, 800)
    layout: Layout = "side_by_side"
    field_rad: float = np.pi / 2
    ipd_m: float = MEAN_IPD_M
    eye_height_m: float = 1.6
    walking_speed_m_s: float = WALKING_SPEED_M_S
    teleport_m: float | None = None

    @property
    def window_size_px(self) -> tuple[int, int]:
        """Return the size at which every pixel of the images is shown as it is."""
        width, height = self.image_size_px
        return width * self.columns, height

    @property
    def columns(self) -> Literal[1, 2]:
        """Return how many eyes are shown."""
        return 2 if self.layout == "side_by_side" else 1

    @property
    def fov(self) -> Fov:
        """Return the frustum of each eye: symmetric, with square pixels."""
        width, height = self.image_size_px
        tangent = np.tan(self.field_rad / 2) * height / width
        return Fov.symmetric(vertical_rad=2 * float(np.arctan(tangent)), aspect=width / height)


class DesktopHeadset:
    """Shows a session in a window.

    Parameters
    ----------
    ctx
        The window's OpenGL context.
    """

    def __init__(
        self, ctx: moderngl.Context, window: Window, settings: DesktopSettings | None = None
    ) -> None:
        self._ctx = ctx
        self._window = window
        self._settings = settings or DesktopSettings()
        self._painter = EyePainter(ctx)
        self._pace = _Pace(self.refresh_hz)
        self._locomotion = Locomotion(
            self._settings.walking_speed_m_s, teleport_m=self._settings.teleport_m
        )
        self._panels: list[WindowPanel] = []
        self._pointer: WindowPanel | None = None
        self._points = False
        self._events: list[HeadsetEvent] = []
        self._yaw_rad = self._pitch_rad = 0.0
        self._inputs = Inputs()
        self._next_index = 0
        self._cut = True
        self.arrows_turn = False
        """Whether the arrow keys turn a dial; else they walk, or move the choice on a panel."""
        self._paused = self._in_scene = False
        self._on_foot = True
        self._focused = window.focused

    @property
    def name(self) -> str:
        """Return the headset's name for the manifest."""
        return "desktop"

    @property
    def refresh_hz(self) -> float:
        """Return the monitor's rate."""
        return self._window.refresh_hz or USUAL_HZ

    def display_now_ns(self) -> int:
        """Return the present moment as a display time: they are the system's monotonic clock."""
        return time.monotonic_ns()

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image."""
        return self._settings.image_size_px

    @property
    def details(self) -> dict[str, Any]:
        """Return how the eyes are shown."""
        settings = self._settings
        return {
            "ipd_m": settings.ipd_m,
            "layout": settings.layout,
            "field_deg": f"{np.degrees(settings.field_rad):g}",
            "eye_height_m": f"{settings.eye_height_m:g}",
            "walking_speed_m_s": f"{settings.walking_speed_m_s:g}",
        }

    @property
    def head_pose(self) -> Pose:
        """Return stage-from-head."""
        eyes = np.array([0.0, self._settings.eye_height_m, 0.0])
        return Pose(eyes, yaw_pitch_roll(self._yaw_rad, self._pitch_rad, 0.0))

    def place(self, *, spawn: Pose, floors: Floors | None = None, on_foot: bool = True) -> None:
        """Put the participant on `spawn`, looking straight ahead; they walk on `floors`.

        Where nobody is `on_foot`, keys and mouse turn the head alone.
        """
        self._yaw_rad = self._pitch_rad = 0.0
        self._on_foot = on_foot
        self._locomotion.send(spawn=spawn, floors=floors or Floors(), on_foot=on_foot)
        self._locomotion.arrive(self.head_pose)
        self._cut = True

    def frames(self) -> Iterator[Frame]:
        """Yield a frame each time the monitor wants one, until the window is closed."""
        self._cut = True
        while not self._window.closing:
            yield self._next_frame()

    def submit(self, frame: Frame, eyes: tuple[moderngl.Texture, moderngl.Texture] | None) -> None:
        """Show the images (RGBA8, sRGB-encoded) and the panels; with `None` only the panels."""
        self._in_scene = eyes is not None
        screen = self._ctx.screen
        screen.viewport = (0, 0, *self._window.size_px)
        screen.clear()
        panels = [*self._panels, self._pointer] if self._pointer and self._points else self._panels
        for eye in range(self._settings.columns):
            image = None if eyes is None else eyes[eye]
            self._painter.paint(screen, self._box(eye), image, frame.views[eye], panels)
        self._window.show()

    def take_events(self) -> list[HeadsetEvent]:
        """Return the events since the last call."""
        events = list(self._events)
        self._events.clear()
        return events

    def inputs(self) -> Inputs:
        """Return the inputs of keys and mouse in the present frame; the mouse is the right hand."""
        return self._inputs

    def allow_absence(self, duration_s: float) -> None:
        """Do nothing: a window waits for as long as it is open."""

    def tick(self, hand: int) -> None:
        """Do nothing: a mouse cannot tick."""

    def show_panel(self, size_px: tuple[int, int], quad: Quad) -> WindowPanel:
        """Put a panel where `quad` is, as large as the image allows."""
        share = RATING_SHARE if self._in_scene else QUESTION_SHARE
        away_m = float(np.linalg.norm(quad.pose.position - self.head_pose.position))
        _, right, up, _ = self._settings.fov.tangents
        scale = share * 2 * away_m * min(right / quad.size_m[0], up / quad.size_m[1])
        width, height = quad.size_m
        larger = Quad(quad.pose, (width * scale, height * scale))
        panel = WindowPanel(self._ctx, size_px, larger, self._panels.remove)
        self._panels.append(panel)
        return panel

    def show_pointer(self, quad: Quad | None) -> None:
        """Put the pointer there, in front of all panels, or take it away."""
        self._points = quad is not None
        if quad is None:
            return
        if self._pointer is None:
            self._pointer = WindowPanel(self._ctx, POINTER_SIZE_PX, quad)
            self._pointer.draw(pointer_picture())
        self._pointer.quad = quad

    def _next_frame(self) -> Frame:
        now_ns, passed_s = self._pace.wait()
        window, asked = self._window, bool(self._panels)
        window.capture(self._in_scene and not asked)
        keys = window.poll(arrows_walk=not (asked or self.arrows_turn))
        self._notice_focus()
        self._look(keys, passed_s)
        self._inputs = Inputs(
            right=HandInput(self._cursor_ray(), select=window.clicked, held=window.held), keys=keys
        )
        paused = window.hidden
        self._cut |= self._paused and not paused
        period_ns = round(SECOND_NS / self.refresh_hz)
        head = self.head_pose
        frame = Frame(
            index=self._next_index,
            predicted_display_time_ns=now_ns + period_ns,
            period_ns=period_ns,
            head_pose=head,
            views=self._views(head),
            avatar_pose=self._locomotion.avatar,
            should_render=not paused,
            discontinuity=self._cut,
            paused=paused,
        )
        self._next_index, self._cut, self._paused = self._next_index + 1, False, paused
        return frame

    def _look(self, keys: KeyInput, passed_s: float) -> None:
        """Turn the torso, or with the right mouse button the head alone; and walk."""
        if not self._in_scene:
            return  # nobody walks blindly
        self._pitch_rad = _within(self._pitch_rad + keys.look_up_rad, STEEPEST_RAD)
        command = move_command(Inputs(keys=keys))
        if self._window.looks_aside or not self._on_foot:
            self._yaw_rad = _within(self._yaw_rad + keys.turn_rad, FURTHEST_RAD)
            command = command.without_turn()
        self._locomotion.step(self.head_pose, command, passed_s)
        self._cut |= self._locomotion.teleported

    def _views(self, head: Pose) -> tuple[View, View]:
        half = np.array([self._settings.ipd_m / 2, 0.0, 0.0])
        fov = self._settings.fov
        return View(head @ Pose(-half), fov), View(head @ Pose(half), fov)

    def _cursor_ray(self) -> Pose | None:
        """Return the ray through the cursor, from the eye of the image under it."""
        columns = self._settings.columns
        right, down = self._window.cursor
        eye = min(int(max(right, 0.0) * columns), columns - 1)
        width, height = self._window.size_px
        left, bottom, wide, high = self._box(eye)
        x = 2 * (right * width - left) / wide - 1
        y = 2 * ((1 - down) * height - bottom) / high - 1
        _, right_tangent, up_tangent, _ = self._settings.fov.tangents
        yaw = float(np.arctan(x * right_tangent))
        pitch = float(np.arctan(y * up_tangent * np.cos(yaw)))
        view = self._views(self.head_pose)[eye].pose
        return view @ Pose(orientation=yaw_pitch_roll(-yaw, pitch, 0.0))

    def _box(self, eye: int) -> Box:
        width, height = self.image_size_px
        of = self._settings.columns
        return fitted(self._window.size_px, width / height, column=eye, of=of)

    def _notice_focus(self) -> None:
        focused = self._window.focused
        if focused != self._focused:
            self._events.append(HeadsetEvent("window_focus", "gained" if focused else "lost"))
        self._focused = focused


class _Pace:
    """Lets one frame pass per period of the monitor, also where swapping does not wait for it."""

    def __init__(self, refresh_hz: float) -> None:
        self._period_ns = round(SECOND_NS / refresh_hz)
        self._before_ns: int | None = None

    def wait(self) -> tuple[int, float]:
        """Return the time (ns), and the seconds since the last call."""
        now_ns = time.monotonic_ns()
        before_ns = now_ns if self._before_ns is None else self._before_ns
        early_ns = before_ns + self._period_ns - now_ns
        # A swap that waits for the display comes back a little early now and then.
        if self._before_ns is not None and early_ns > self._period_ns / 4:
            time.sleep(early_ns / SECOND_NS)
            now_ns = time.monotonic_ns()
        self._before_ns = now_ns
        return now_ns, (now_ns - before_ns) / SECOND_NS


def _within(angle_rad: float, limit_rad: float) -> float:
    return float(np.clip(angle_rad, -limit_rad, limit_rad))
