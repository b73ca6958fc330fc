"""What a frame says of the head and of the session, and what moves the tracked space."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from itertools import islice
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, needs_monado
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, Quad, axis_angle
from vrcomfort.headset.monado import RemoteFeed, RemoteState

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_layers import Interceptor
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.openxr.native import pose_to_xr

pytestmark = needs_monado

SIZE_PX = (16, 16)
UP = [0.0, 1.0, 0.0]
TURNED = RemoteState(Pose(np.array([0.3, 1.6, -0.2]), axis_angle(UP, 1.0)))


def headset(ctx: moderngl.Context, feed: RemoteFeed, **calls: Any) -> OpenXrHeadset:
    layer = Interceptor(**calls)
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=(layer.name,))
    return OpenXrHeadset(ctx, settings, before_wait=Participant(feed, lambda _: TURNED))


def events(session: OpenXrHeadset) -> list[tuple[str, str]]:
    return [(event.name, event.detail) for event in session.take_events()]


class Views:
    """Bends what the runtime knows of the eyes, and counts the layers that frames end with."""

    def __init__(self, flags: int | None) -> None:
        self.flags = flags
        self.layers: list[int] = []
        self.calls = {"xrLocateViews": self.locate, "xrEndFrame": self.end}

    def locate(self, follow: Any, session: Any, info: Any, state: Any, *more: Any) -> Any:
        result = follow(session, info, state, *more)
        if self.flags is not None:
            state.contents.view_state_flags = self.flags
        return result

    def end(self, follow: Any, session: Any, info: Any) -> Any:
        self.layers.append(info.contents.layer_count)
        return follow(session, info)


def focused(session: OpenXrHeadset) -> Iterator[Frame]:
    return (frame for frame in session.frames() if frame.session_state == "focused")


def test_nothing_is_shown_before_the_head_has_been_found(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    views = Views(flags=0)
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    with headset(ctx, feed, **views.calls) as session:
        session.place(spawn=Pose(np.array([5.0, 0.0, 0.0])))
        frames = focused(session)
        for frame in islice(frames, 4):
            assert not frame.head_valid
            assert not frame.head_tracked
            assert frame.paused
            session.submit(frame, eyes)
        assert set(views.layers) == {0}
        assert ("tracking_lost", "") in events(session)
        assert "ipd_m" not in session.details

        views.flags = None
        frame = next(frames)
        assert frame.head_valid
        assert frame.head_tracked
        assert frame.discontinuity
        assert not frame.paused
        assert (frame.avatar_pose @ frame.head_pose).position == pytest.approx([5.0, 1.6, 0.0])
        session.submit(frame, eyes)
        assert views.layers[-1] == 1
        assert events(session) == [("head_found", "")]
        left, right = (view.pose.position for view in frame.views)
        shown = session.details["ipd_m"]
        assert shown == pytest.approx(np.linalg.norm(right - left), abs=1e-6)
        assert 0.05 < shown < 0.08


def test_a_pose_that_is_inferred_is_valid_and_not_tracked(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    inferred = xr.ViewStateFlags.ORIENTATION_VALID_BIT | xr.ViewStateFlags.POSITION_VALID_BIT
    with headset(ctx, feed, **Views(int(inferred)).calls) as session:
        frame = next(focused(session))
        assert (frame.head_valid, frame.head_tracked) == (True, False)


def test_a_frame_while_tracking_is_lost_is_not_valid(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    views = Views(flags=None)
    with headset(ctx, feed, **views.calls) as session:
        frames = focused(session)
        before = next(frames)
        views.flags = 0
        lost = next(frames)
        assert (lost.head_valid, lost.head_tracked, lost.paused) == (False, False, False)
        assert lost.head_pose.position == pytest.approx(before.head_pose.position)


class Sent:
    """Events that the runtime seems to send."""

    def __init__(self) -> None:
        self.waiting: list[ctypes.Structure] = []

    def poll(self, follow: Any, instance: Any, event: Any) -> Any:
        result = follow(instance, event)
        if result == xr.Result.EVENT_UNAVAILABLE.value and self.waiting:
            told = self.waiting.pop(0)
            ctypes.memmove(event, ctypes.byref(told), ctypes.sizeof(told))
            return xr.Result.SUCCESS
        return result


def space_change(session: OpenXrHeadset, space: Any, pose: Pose | None) -> ctypes.Structure:
    told: ctypes.Structure = xr.EventDataReferenceSpaceChangePending(
        session=session._xr.session,
        reference_space_type=space,
        change_time=0,
        pose_valid=pose is not None,
        pose_in_previous_space=pose_to_xr(pose or Pose()),
    )
    return told


def test_a_change_of_a_space_that_is_not_in_use_moves_nobody(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    sent = Sent()
    with headset(ctx, feed, xrPollEvent=sent.poll) as session:
        frames = focused(session)
        before = next(frames)
        events(session)
        moved = Pose(np.array([1.0, 0.0, 0.0]))
        sent.waiting.append(space_change(session, xr.ReferenceSpaceType.LOCAL, moved))
        after = next(frames)
        assert after.avatar_pose.position == pytest.approx(before.avatar_pose.position)
        assert not after.discontinuity
        assert events(session) == [
            ("space_changed", "local by the runtime: not in use, nothing moves")
        ]


class Recentered:
    """Measures poses from a new origin of the stage, from a certain moment on."""

    def __init__(self) -> None:
        self.new_from_old: Pose | None = None

    def _bend(self, pose: Any) -> Any:
        old = Pose(
            np.array([pose.position.x, pose.position.y, pose.position.z]),
            np.array([getattr(pose.orientation, axis) for axis in "xyzw"]),
        )
        return pose_to_xr((self.new_from_old or Pose()) @ old)

    def space(self, follow: Any, space: Any, base: Any, time: Any, location: Any) -> Any:
        result = follow(space, base, time, location)
        location.contents.pose = self._bend(location.contents.pose)
        return result

    def views(self, follow: Any, s: Any, info: Any, state: Any, n: Any, m: Any, views: Any) -> Any:
        result = follow(s, info, state, n, m, views)
        for index in range(n):
            views[index].pose = self._bend(views[index].pose)
        return result


@pytest.mark.parametrize("told", [True, False])
def test_recentering_by_the_runtime_moves_nobody_in_the_world(
    ctx: moderngl.Context, feed: RemoteFeed, *, told: bool
) -> None:
    sent, recentered = Sent(), Recentered()
    calls = {
        "xrPollEvent": sent.poll,
        "xrLocateSpace": recentered.space,
        "xrLocateViews": recentered.views,
    }
    with headset(ctx, feed, **calls) as session:
        frames = focused(session)
        session.place(spawn=Pose(np.array([5.0, 2.0, -3.0]), axis_angle(UP, -0.7)))
        next(frames)
        before = next(frames)
        quad = Quad(Pose(np.array([0.0, 1.5, -1.5])), (1.0, 1.0))
        panel = session.show_panel((8, 8), quad)
        panel_before = before.avatar_pose @ panel.quad.pose
        events(session)

        old_from_new = Pose(np.array([0.5, 0.0, 0.8]), axis_angle(UP, 0.6))
        recentered.new_from_old = old_from_new.inverse()
        space = xr.ReferenceSpaceType.STAGE
        sent.waiting.append(space_change(session, space, old_from_new if told else None))
        after = next(frames)
        assert after.discontinuity
        assert events(session) == [("recentered", "stage by the runtime")]
        for one, two in (
            (before.avatar_pose @ before.head_pose, after.avatar_pose @ after.head_pose),
            (panel_before, after.avatar_pose @ panel.quad.pose),
        ):
            assert one.position == pytest.approx(two.position, abs=1e-5)
            assert abs(one.orientation @ two.orientation) == pytest.approx(1.0, abs=1e-6)


def test_a_menu_before_the_session_is_told_with_what_it_takes_away(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    sent = Sent()
    with headset(ctx, feed, xrPollEvent=sent.poll) as session:
        frames = session.frames()
        next(focused(session))
        events(session)
        for state, name in (
            (xr.SessionState.VISIBLE, "unfocused"),
            (xr.SessionState.FOCUSED, "focused"),
        ):
            change = xr.EventDataSessionStateChanged(session._xr.session, state, 0)
            sent.waiting.append(change)
            frame = next(frames)
            assert frame.session_state == state.name.lower()
            said = dict(events(session))
            assert said["session_state"] == state.name.lower()
            assert ("stop button does not work" in said[name]) == (name == "unfocused")


def test_a_new_refresh_rate_is_an_event(ctx: moderngl.Context, feed: RemoteFeed) -> None:
    sent = Sent()
    with headset(ctx, feed, xrPollEvent=sent.poll) as session:
        frames = focused(session)
        next(frames)
        events(session)
        sent.waiting.append(xr.EventDataDisplayRefreshRateChangedFB(90.0, 72.0))
        next(frames)
        detail = "from 90 Hz to 72 Hz; 50.00 ms at the start"
        assert events(session) == [("refresh_rate_changed", detail)]
