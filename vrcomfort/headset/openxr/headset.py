"""The headset: frames with poses from the runtime, images back to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Any, Self

import moderngl
import xr

from vrcomfort.errors import RuntimeLostError
from vrcomfort.frame import Frame, FrameWaits, HeadsetEvent
from vrcomfort.geometry import HiddenAreas, Pose, Quad
from vrcomfort.headset.inputs import Inputs
from vrcomfort.headset.locomotion import Locomotion
from vrcomfort.headset.openxr import display, faults, layers
from vrcomfort.headset.openxr.connection import Connection
from vrcomfort.headset.openxr.layers import Panels
from vrcomfort.headset.openxr.lifecycle import Presence
from vrcomfort.headset.openxr.native import native, watched
from vrcomfort.headset.openxr.settings import OpenXrSettings
from vrcomfort.headset.openxr.tracking import ParticipantPose
from vrcomfort.headset.timing import Timing, rate_runtime
from vrcomfort.headset.watchdog import RUNTIME_CALLS
from vrcomfort.scene.floors import Floors

if TYPE_CHECKING:
    from vrcomfort.headset.window import Mirror

SECOND_NS = 1_000_000_000
FRAME_WAITS = ("xrWaitFrame", "xrBeginFrame")
IMAGE_WAITS = ("xrAcquireSwapchainImage", "xrWaitSwapchainImage", "xrReleaseSwapchainImage")
"""Functions of the runtime that make a frame wait."""
EXIT_FRAMES = 100
EXIT_S = 10.0
"""Empty frames, and time, at most until the runtime lets a session go."""


class OpenXrHeadset:
    """A headset behind the active OpenXR runtime; a context manager.

    Parameters
    ----------
    ctx
        The OpenGL context that draws.
    settings
        What the caller may choose.
    before_wait
        Called before each wait for a frame: where a simulated runtime's feed moves on.
    window
        Shows the operator what the participant sees; its keys act for the participant.

    Raises
    ------
    InputError
        If no runtime, no headset or no OpenGL can be had; says what to do.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        settings: OpenXrSettings | None = None,
        *,
        before_wait: Callable[[], None] | None = None,
        window: Mirror | None = None,
    ) -> None:
        self._before_wait, self._window = before_wait, window
        settings = settings or OpenXrSettings()
        self._events: list[HeadsetEvent] = []
        self._xr = Connection(ctx, settings, self._events.append)
        self._panels = Panels(self._xr.panel_canvas)
        walks = Locomotion(
            settings.walking_speed_m_s,
            turning_deg_s=settings.turning_deg_s,
            snap_turn_deg=settings.snap_turn_deg,
            teleport_m=settings.teleport_m,
        )
        self._where = ParticipantPose(self._xr, walks, self._events.append, self._panels.relocate)
        self._presence = Presence(self._xr.lifecycle, settings.patience_s, self._events.append)
        self._wait_frame = native("xrWaitFrame")
        self._begin_frame = native("xrBeginFrame", usual=xr.Result.FRAME_DISCARDED)
        self._frame_state = xr.FrameState()
        self._end_frame = layers.FrameEnd(self._xr.session)
        self._open: Frame | None = None
        self._next_index = self._time_ns = self._period_ns = 0
        self._cut = True
        self._inputs: Inputs | None = None
        self._in_scene = False
        self._frame_wait_ms = self._image_wait_ms = 0.0

    @property
    def name(self) -> str:
        """Return the headset's name for the manifest."""
        return f"openxr: {self._xr.runtime.headset_name} ({self._xr.runtime.name})"

    @property
    def details(self) -> dict[str, Any]:
        """Return facts on runtime and headset for the manifest.

        ``ipd_m`` is the distance between the eyes that is shown; there from the first
        frame on in which the head is known. ``frame_period`` says where the period of frames
        comes from; there from the first frame on.
        """
        ipd_m, source = self._where.tracking.ipd_m, self._xr.lifecycle.refresh_period.source
        late = {"ipd_m": ipd_m, "frame_period": source or None}
        told = {name: fact for name, fact in late.items() if fact is not None}
        return {**self._xr.details, "timing": self.timing.reason, **told}

    @property
    def timing(self) -> Timing:
        """Return the trust in the times of frames, and its reason."""
        runtime = self._xr.runtime
        return rate_runtime(runtime.name, runtime.headset_name)

    def wake(self, timeout_s: float) -> bool:
        """Wait until the headset wants frames; return False where it sleeps on."""
        with faults.running():
            return self._xr.lifecycle.wait_until_running(timeout_s)

    @property
    @faults.running()
    def refresh_hz(self) -> float:
        """Return the display's refresh rate: as the runtime says, or as its frames come; or 0."""
        told_hz = self._xr.display_hz()
        return told_hz or (SECOND_NS / self._period_ns if self._period_ns else 0.0)

    @property
    @faults.running()
    def refresh_rates_hz(self) -> list[float]:
        """Return the rates that can be asked for in the settings."""
        return display.refresh_rates_hz(self._xr.session) if self._xr.switches_rate else []

    def display_now_ns(self) -> int | None:
        """Return the present moment as a display time; None where the runtime does not tell."""
        with faults.running():
            return display.display_now_ns(self._xr.runtime)

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image."""
        return self._xr.size_px

    def frames(self) -> Iterator[Frame]:
        """Yield a frame whenever the runtime wants one, until it ends the session.

        While the headset is asleep this waits, and while the period of frames is not known. A
        frame that was not submitted goes back empty.

        Raises
        ------
        RuntimeLostError
            If the runtime goes away, or nobody looks into the headset for too long.
        """
        self._cut = True
        self.allow_absence(0.0)
        while True:
            with faults.running():
                frame = self._next_frame()
            if frame is None:
                return
            if frame.period_ns == 0:  # being measured: goes back empty
                self._cut = True
                continue
            yield frame

    def submit(self, frame: Frame, eyes: layers.Eyes | None) -> None:
        """Show the images (RGBA8, sRGB-encoded) and the panels; with `None` only the panels."""
        with faults.running():
            self._submit(frame, eyes)
        self._in_scene = eyes is not None
        if self._window is not None:
            self._window.show(frame, eyes, self._panels.shown)

    def take_depth(self, eye: int, depth: moderngl.Texture, near_m: float) -> None:
        """Keep the depth of eye 0 (left) or 1 (right) for the frame that is submitted next.

        Does nothing where the runtime takes none.

        Parameters
        ----------
        depth
            D32F, reverse-Z: ``near_m / distance``.
        """
        if self._open is not None and self._open.should_render:
            with faults.running():
                self._xr.eyes.copy_depth(eye, depth, near_m)

    def waits(self) -> FrameWaits:
        """Return the waits of the frame that was submitted last."""
        return FrameWaits(self._frame_wait_ms, self._image_wait_ms)

    @property
    def head_pose(self) -> Pose:
        """Return stage-from-head of the last frame."""
        return self._where.tracking.head

    def allow_absence(self, duration_s: float) -> None:
        """Wait longer than usual, by a duration, for a headset that has been taken off."""
        self._presence.allow(duration_s)

    def inputs(self) -> Inputs:
        """Return the inputs of the participant's hands, eyes and keys in the last frame."""
        if self._inputs is None:
            with faults.running():
                self._inputs = self._xr.actions.read(self._xr.stage, self._time_ns)
            if self._window is not None:
                self._inputs = replace(self._inputs, keys=self._window.keys())
        return self._inputs

    @property
    def arrows_turn(self) -> bool:
        """Return whether the arrow keys of the window turn a dial; else they walk."""
        return self._window is not None and self._window.arrows_turn

    @arrows_turn.setter
    def arrows_turn(self, turn: bool) -> None:
        if self._window is not None:
            self._window.arrows_turn = turn

    def tick(self, hand: int) -> None:
        """Let controller `hand` (0 left, 1 right) tick, to confirm an answer."""
        with faults.running():
            self._xr.actions.tick(hand)

    def show_panel(self, size_px: tuple[int, int], quad: Quad) -> layers.PanelLayer:
        """Put a panel into the room; draw on it, and hide it when it is done."""
        return self._panels.show(size_px, quad)

    def prepare_panel(self, size_px: tuple[int, int]) -> None:
        """Make the images of a panel now, so that `show_panel` need not in a scene."""
        self._panels.prepare(size_px)

    def show_pointer(self, quad: Quad | None) -> None:
        """Put the pointer there, in front of all panels, or take it away."""
        self._panels.point(quad)

    def place(self, *, spawn: Pose, floors: Floors | None = None, on_foot: bool = True) -> None:
        """Put the floor point and heading of the participant on `spawn`, next frame.

        Where nobody is `on_foot`, thumb-sticks neither move nor turn them.
        """
        self._where.send(spawn, floors or Floors(), on_foot=on_foot)

    def recenter(self) -> None:
        """Make the floor point and heading of the head the stage's origin; nothing else moves."""
        self._where.recenter()
        self._cut = True
        self._events.append(HeadsetEvent("recentered", "by the experimenter"))

    def take_events(self) -> list[HeadsetEvent]:
        """Return the events since the last call."""
        stalls = RUNTIME_CALLS.stalls
        while stalls:  # another thread appends
            self._events.append(HeadsetEvent("runtime_stalled", stalls.popleft()))
        events = list(self._events)
        self._events.clear()
        return events

    @property
    def hidden_areas(self) -> HiddenAreas:
        """Return the hidden area of each eye's lens; None where the runtime reports none."""
        return self._xr.hidden_areas

    def close(self) -> None:
        """End the session as the runtime likes it, and release everything."""
        try:
            self._leave()
        except (xr.exception.ResultException, RuntimeLostError):
            pass  # the runtime is gone already
        finally:
            self._panels.release()
            self._xr.release()

    def request_exit(self) -> None:
        """Ask the runtime to end the session: `frames` ends soon after."""
        with faults.running():
            watched(xr.request_exit_session, self._xr.session)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _next_frame(self) -> Frame | None:
        if self._open is not None:
            self._submit(self._open, None)
        self._cut |= not self._xr.lifecycle.running
        if not self._presence.wait():
            return None
        if self._before_wait is not None:
            self._before_wait()
        RUNTIME_CALLS.take_spent_ms(FRAME_WAITS)
        self._wait_frame(self._xr.session, None, self._frame_state)
        self._xr.actions.sync()  # before the frame begins, as best practices would have it
        if self._begin_frame(self._xr.session, None) != 0:  # the frame before was not ended
            self._events.append(HeadsetEvent("frame_discarded", "by the runtime: it was not seen"))
        self._frame_wait_ms = RUNTIME_CALLS.take_spent_ms(FRAME_WAITS)
        RUNTIME_CALLS.take_spent_ms(IMAGE_WAITS)
        if self._in_scene and self._frame_state.should_render:
            self._xr.eyes.acquire()  # before the frame is drawn, so that nothing in it waits
        self._xr.make_current()
        self._inputs = None
        self._open = self._frame(self._frame_state)
        return self._open

    def _frame(self, timing: xr.FrameState) -> Frame:
        time_ns = int(timing.predicted_display_time)
        passed_s, self._time_ns = (time_ns - self._time_ns) / SECOND_NS, time_ns
        period_ns = int(timing.predicted_display_period)
        self._period_ns = self._xr.lifecycle.refresh_period.update(
            period_ns, time_ns if timing.should_render else None
        )
        self._cut |= self._where.update(time_ns)
        inputs = self.inputs()  # kept: between frames a pose would be a guess
        self._cut |= self._where.move(inputs, passed_s, in_scene=self._in_scene)
        self._cut |= self._presence.update(
            inputs,
            time_ns,
            located=self._where.tracking.found,
            rendered=bool(timing.should_render),
            reached=self._xr.actions.reached,
        )
        tracking, trackers = self._where.tracking, self._xr.hand_trackers
        frame = Frame(
            index=self._next_index,
            predicted_display_time_ns=time_ns,
            period_ns=self._period_ns,
            head_pose=tracking.head,
            views=tracking.views,
            avatar_pose=self._where.avatar,
            should_render=bool(timing.should_render),
            discontinuity=self._cut,
            snap_turn=self._where.snap_turned,
            paused=self._presence.away,
            user_present=self._xr.lifecycle.user_present,
            gaze=inputs.gaze,
            hands=(inputs.left.aim, inputs.right.aim),
            joints=trackers.read(self._xr.stage.space, time_ns) if trackers else (None, None),
            head_valid=tracking.valid,
            head_tracked=tracking.tracked,
            session_state=self._xr.lifecycle.state_name,
        )
        self._next_index, self._cut = self._next_index + 1, False
        return frame

    def _submit(self, frame: Frame, eyes: layers.Eyes | None) -> None:
        composed: list[layers.Layer] = []
        space = self._xr.stage.space
        if frame.should_render:
            tracking = self._where.tracking
            if eyes is not None and tracking.found:  # else they would be seen from nowhere
                composed.append(self._xr.eyes.draw(eyes, tracking.xr_views, space))
            composed += [layer for each in self._panels.shown if (layer := each.structure(space))]
        self._open = None
        self._image_wait_ms = RUNTIME_CALLS.take_spent_ms(IMAGE_WAITS)
        self._end_frame(frame.predicted_display_time_ns, composed)
        self._xr.make_current()

    def _leave(self) -> None:
        """Give empty frames until the runtime has ended the session."""
        if self._open is not None:
            self._submit(self._open, None)
        if not self._xr.lifecycle.running:
            return
        watched(xr.request_exit_session, self._xr.session)
        self._presence.leaving = True
        self._presence.until(EXIT_S)
        for frame in islice(iter(self._next_frame, None), EXIT_FRAMES):
            self._submit(frame, None)
