"""What becomes of a session whose participant, controllers, tracking or floor are not there."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, needs_monado, settled
from vrcomfort.errors import RuntimeLostError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, Quad, axis_angle
from vrcomfort.headset.monado import RemoteFeed, RemoteHand, RemoteState

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_layers import Interceptor
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (16, 16)
TURNED = RemoteState(Pose(np.array([0.3, 1.6, -0.2]), axis_angle([0.0, 1.0, 0.0], 1.0)))


def headset(
    ctx: moderngl.Context,
    feed: RemoteFeed,
    *,
    state: Callable[[int], RemoteState] = lambda _: TURNED,
    patience_s: float = 600.0,
    **calls: Any,
) -> OpenXrHeadset:
    layer = Interceptor(**calls)
    settings = OpenXrSettings(
        image_size_px=SIZE_PX, api_layers=(layer.name,), patience_s=patience_s
    )
    return OpenXrHeadset(ctx, settings, before_wait=Participant(feed, state))


def names(session: OpenXrHeadset) -> list[tuple[str, str]]:
    return [(event.name, event.detail) for event in session.take_events()]


def seen(session: OpenXrHeadset, count: int) -> list[Frame]:
    return list(islice((frame for frame in session.frames() if not frame.paused), count))


def silent(follow: Any, instance: Any, event: Any) -> Any:
    """No event comes: the session never gets ready, as with a headset that sleeps."""
    return xr.Result.EVENT_UNAVAILABLE


class Blind:
    """Keeps from the session that it is seen: something else is shown."""

    def __call__(self, follow: Any, instance: Any, event: Any) -> Any:
        result = follow(instance, event)
        kind = ctypes.cast(event, ctypes.POINTER(xr.EventDataSessionStateChanged)).contents
        changed = xr.StructureType.EVENT_DATA_SESSION_STATE_CHANGED
        if (
            result == xr.Result.SUCCESS.value
            and kind.type == changed
            and xr.SessionState(kind.state) in {xr.SessionState.VISIBLE, xr.SessionState.FOCUSED}
        ):
            return xr.Result.EVENT_UNAVAILABLE
        return result


def covered(follow: Any, session: Any, info: Any, state: Any) -> int:
    """Want no picture of any frame."""
    result = follow(session, info, state)
    state.contents.should_render = 0
    return int(result)


@pytest.mark.parametrize(
    "calls", [{"xrPollEvent": silent}, {"xrPollEvent": Blind()}, {"xrWaitFrame": covered}]
)
def test_a_headset_that_nobody_looks_into_for_long_ends_the_session(
    ctx: moderngl.Context, feed: RemoteFeed, calls: dict[str, Any]
) -> None:
    def go(session: OpenXrHeadset) -> None:
        for frame in session.frames():
            assert not frame.seen
            session.submit(frame, None)

    words = r"shown nothing for 0.5 s.*--resume"
    with (
        headset(ctx, feed, patience_s=0.5, **calls) as session,
        pytest.raises(RuntimeLostError, match=words),
    ):
        go(session)


def test_a_rest_is_no_absence(ctx: moderngl.Context, feed: RemoteFeed) -> None:
    with headset(ctx, feed, patience_s=0.2, xrPollEvent=Blind()) as session:
        frames = session.frames()
        session.submit(next(frames), None)
        session.allow_absence(60.0)
        assert all(frame.paused for frame in islice(frames, 12))  # 0.6 s


def test_controllers_that_come_and_go_are_events(ctx: moderngl.Context, feed: RemoteFeed) -> None:
    now = {"active": True}

    def state(_: int) -> RemoteState:
        return replace(TURNED, right=RemoteHand(Pose(), active=now["active"]))

    with headset(ctx, feed, state=state) as session:
        frames = (frame for frame in session.frames() if not frame.paused)
        list(islice(frames, 4))
        names(session)
        for active, event in ((False, "controller_lost"), (True, "controller_found")):
            now["active"] = active
            for _ in islice(frames, 600):
                told = [each for each in names(session) if each[0].startswith("controller_")]
                if (event, "right") in told:
                    assert told == [(event, "right")]
                    break
            else:
                pytest.fail(f"no {event}")


class Lost:
    """Takes the validity off what the runtime knows of head and eyes, while told to."""

    def __init__(self) -> None:
        self.now = False

    def views(self, follow: Any, session: Any, info: Any, state: Any, *more: Any) -> Any:
        result = follow(session, info, state, *more)
        if self.now:
            state.contents.view_state_flags = 0
        return result


def test_tracking_that_is_lost_keeps_the_last_pose_and_is_told(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    lost, at = Lost(), {"x": 0.3}

    def state(_: int) -> RemoteState:
        return RemoteState(Pose(np.array([at["x"], 1.6, 0.0])))

    with headset(ctx, feed, state=state, xrLocateViews=lost.views) as session:
        frames = (frame for frame in session.frames() if not frame.paused)
        before = settled(frames, [0.3, 1.6, 0.0])
        names(session)
        lost.now, at["x"] = True, 0.9
        *_, blind = islice(frames, 20)  # the driver has read the new place meanwhile
        assert blind.head_pose.position == pytest.approx(before.head_pose.position)
        assert names(session) == [("tracking_lost", "")]
        lost.now = False
        found = next(frames)
        assert found.discontinuity
        assert found.head_pose.position[0] == pytest.approx(0.9, abs=1e-6)
        assert names(session) == [("tracking_found", "")]


def only_local(
    _: Any, __: Any, capacity: int, count: Any, spaces: Any, *, offered: tuple[Any, ...]
) -> Any:
    count[0] = len(offered)
    for index in range(min(capacity, len(offered))):
        spaces[index] = offered[index].value
    return xr.Result.SUCCESS


@pytest.mark.parametrize("kind", ["LOCAL", "LOCAL_FLOOR"])
def test_without_a_stage_the_floor_is_found_another_way(
    ctx: moderngl.Context, feed: RemoteFeed, kind: str
) -> None:
    offered = (xr.ReferenceSpaceType.VIEW, xr.ReferenceSpaceType[kind])

    def spaces(*arguments: Any) -> Any:
        return only_local(*arguments, offered=offered)

    with headset(ctx, feed) as session:
        settled(session.frames(), TURNED.head.position)
        stage = seen(session, 4)[-1].head_pose
    with headset(ctx, feed, xrEnumerateReferenceSpaces=spaces) as session:
        local = seen(session, 4)[-1].head_pose
        assert session.details["space"] == kind.lower()
    assert stage.position[1] == pytest.approx(1.6, abs=1e-5)
    assert local.position[1] == pytest.approx(1.6, abs=1e-5)


def test_recentering_moves_nobody_in_the_world_and_no_panel(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    spawn = Pose(np.array([5.0, 2.0, -3.0]), axis_angle([0.0, 1.0, 0.0], -0.7))
    with headset(ctx, feed) as session:
        frames = (frame for frame in session.frames() if not frame.paused)
        settled(frames, TURNED.head.position)
        session.place(spawn=spawn)
        before = next(frames)
        panel = session.show_panel((8, 8), Quad(Pose(np.array([0.0, 1.5, -1.5])), (1.0, 1.0)))
        panel_in_world = before.avatar_pose @ panel.quad.pose
        session.recenter()
        after = next(frames)
        assert after.head_pose.position == pytest.approx([0.0, 1.6, 0.0], abs=1e-5)
        for one, two in (
            (before.avatar_pose @ before.head_pose, after.avatar_pose @ after.head_pose),
            (panel_in_world, after.avatar_pose @ panel.quad.pose),
        ):
            assert one.position == pytest.approx(two.position, abs=1e-5)
            assert abs(one.orientation @ two.orientation) == pytest.approx(1.0, abs=1e-9)
        assert after.discontinuity
