"""Everything that lives as long as the session: made in order, released in reverse."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from typing import Any

import moderngl
import xr

from vrcomfort.errors import InputError
from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.openxr import display, layers
from vrcomfort.headset.openxr.actions import EACH_EYE_EXTENSION, Actions
from vrcomfort.headset.openxr.faults import running, starting
from vrcomfort.headset.openxr.graphics_binding import Binding, current_binding, make_current
from vrcomfort.headset.openxr.hand_tracking import HandTrackers
from vrcomfort.headset.openxr.instance import connect
from vrcomfort.headset.openxr.layers import EyeLayer
from vrcomfort.headset.openxr.lifecycle import Lifecycle
from vrcomfort.headset.openxr.native import watched
from vrcomfort.headset.openxr.settings import OpenXrSettings
from vrcomfort.headset.openxr.spaces import Stage
from vrcomfort.headset.openxr.swapchain import (
    DEPTH_FORMAT,
    DEPTH_FORMAT_NAME,
    FORMATS,
    Canvas,
    StereoSwapchain,
    Swapchain,
    choose_format,
)


class Connection:
    """A session with a runtime.

    Parameters
    ----------
    ctx
        The OpenGL context that draws.
    settings
        What the caller may choose.
    notify
        Called with each event worth recording.

    Raises
    ------
    InputError
        If it cannot be had.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        settings: OpenXrSettings,
        notify: Callable[[HeadsetEvent], None],
    ) -> None:
        self._ctx = ctx
        self._settings = settings
        self._owned = ExitStack()
        try:
            make_current(ctx)
            with starting():
                self._open(current_binding(), notify)
            make_current(ctx)
        except BaseException:
            self.release()
            raise

    def _open(self, binding: Binding, notify: Callable[[HeadsetEvent], None]) -> None:
        self._platform = binding.platform
        self.runtime = connect(self._settings, binding.extensions, notify)
        self._owned.callback(self.runtime.release)
        create = xr.SessionCreateInfo(system_id=self.runtime.system, next=binding.pointer)
        self.session = watched(xr.create_session, self.runtime.instance, create)
        self._owned.callback(watched, xr.destroy_session, self.session)
        make_current(self._ctx)
        self.lifecycle = Lifecycle(
            self.runtime.instance,
            self.session,
            notify,
            lambda: self._settings.refresh_hz or self.display_hz(),
        )
        self.stage = Stage(self.session, self._settings.eye_height_m)
        formats = watched(xr.enumerate_swapchain_formats, self.session)
        self._format = choose_format(formats)
        self.size_px = self.runtime.image_size_px(self._settings.image_size_px)
        self._no_depth = layers.why_no_depth(self.runtime.extensions, formats)
        colour = self._stereo_swapchain(self._format)
        self._layers = colour.layers
        self.eyes = EyeLayer(self._ctx, colour, self._depth_swapchain())
        self._owned.callback(self.eyes.release)
        offered = self.runtime.extensions
        self.hidden_areas = display.hidden_areas(self.session, offered)
        self._visibility_mask = display.mask_facts(self.hidden_areas, offered)
        self.actions = Actions(self.runtime, self.session)
        self._owned.callback(self.actions.release)
        self.hand_trackers: HandTrackers | None = None
        if self.runtime.has_hand_joints:
            self.hand_trackers = HandTrackers(self.runtime.instance, self.session)
            self._owned.callback(self.hand_trackers.release)
        if self._settings.refresh_hz is not None:
            self._request_rate(self._settings.refresh_hz)

    def _request_rate(self, wanted_hz: float) -> None:
        if not self.switches_rate:
            raise InputError(
                "the OpenXR runtime does not let programs set the refresh rate (it lacks "
                f"{display.REFRESH_RATE}); set {wanted_hz:g} Hz in the headset's software, and "
                "leave out --refresh-hz"
            )
        display.request_refresh_rate(self.session, wanted_hz)

    @property
    def switches_rate(self) -> bool:
        """Return whether the runtime tells its refresh rates."""
        return display.REFRESH_RATE in self.runtime.extensions

    def display_hz(self) -> float:
        """Return the display's refresh rate as the runtime tells it; 0 where it does not."""
        return display.current_refresh_hz(self.session) if self.switches_rate else 0.0

    @property
    @running()
    def details(self) -> dict[str, Any]:
        """Return facts on runtime and headset for the manifest."""
        room = self.stage.room_m()
        return {
            "runtime": self.runtime.name,
            "headset": self.runtime.headset_name,
            "binding": self._platform,
            "space": self.stage.kind,
            "room": "not told" if room is None else f"{room[0]:.2f} m × {room[1]:.2f} m",
            "image_format": FORMATS[self._format],
            "eye_images": "two layers" if self._layers > 1 else "side by side",
            "depth_layer": self._no_depth or DEPTH_FORMAT_NAME,
            "depth": "off" if self._no_depth else self._settings.depth,
            "visibility_mask": self._visibility_mask,
            "eye_tracker": "yes" if self.runtime.has_gaze or self.runtime.has_each_eye else "no",
            "each_eye": EACH_EYE_EXTENSION if self.runtime.has_each_eye else "not told",
            "hand_joints": "yes" if self.hand_trackers is not None else "no",
            "display_clock": display.clock_extension(self.runtime) or "not told",
            "extensions": " ".join(sorted(self.runtime.extensions)),
            "left_controller": self.actions.profile(0),
            "right_controller": self.actions.profile(1),
        }

    def panel_canvas(self, size_px: tuple[int, int]) -> Canvas:
        """Make a ring of images that pictures are written to."""
        return Canvas(self._ctx, self._swapchain(self._format, size_px))

    def make_current(self) -> None:
        """Take the context back after a call in which the runtime may have used it."""
        make_current(self._ctx)

    def _depth_swapchain(self) -> StereoSwapchain | None:
        if self._settings.depth == "off":
            self._no_depth = "switched off"
        return None if self._no_depth else self._stereo_swapchain(DEPTH_FORMAT)

    def _stereo_swapchain(self, image_format: int) -> StereoSwapchain:
        return StereoSwapchain(self._ctx, partial(self._swapchain, image_format), self.size_px)

    def _swapchain(self, image_format: int, size_px: tuple[int, int], layers: int = 1) -> Swapchain:
        timeout_s = self._settings.image_timeout_s
        return Swapchain(self.session, size_px, image_format, timeout_s, layers)

    def release(self) -> None:
        """Release everything, newest first; a runtime that is gone keeps nothing."""
        with suppress(xr.exception.ErrorResult):
            self._owned.close()
        make_current(self._ctx)
