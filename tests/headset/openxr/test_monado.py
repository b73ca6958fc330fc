"""A whole OpenXR session against Monado: what is fed in comes out, and faults say what they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, Script, fresh_monado, needs_monado, settled
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.geometry import Fov, Pose, Quad, View, axis_angle, yaw_pitch_roll
from vrcomfort.headset.inputs import Inputs
from vrcomfort.headset.monado import RemoteFeed, RemoteHand, RemoteState

pytest.importorskip("xr", reason="pyopenxr is not installed")

from tests.support.openxr_images import ReleasedImages
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (32, 24)
SMALL = OpenXrSettings(image_size_px=SIZE_PX)
STANDING = RemoteState(Pose([0.0, 1.6, 0.0]))


@pytest.fixture
def play(feed: RemoteFeed) -> Callable[[Script], Participant]:
    return lambda script: Participant(feed, script)


def still(_: int) -> RemoteState:
    return STANDING


def walk(frame: int) -> RemoteState:
    turn = yaw_pitch_roll(0.05 * frame, 0.02 * np.sin(frame), 0.01 * np.cos(frame))
    return RemoteState(Pose([0.01 * frame, 1.6 + 0.02 * np.sin(frame), -0.05 * frame], turn))


def test_recorded_poses_are_the_fed_poses_in_order(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    participant = play(walk)
    with OpenXrHeadset(ctx, SMALL, before_wait=participant) as headset:
        frames = []
        for frame in islice(headset.frames(), 40):
            headset.submit(frame, None)
            frames.append(frame)
    fed = np.array([state.head.position for state in participant.sent])
    seen = np.array([frame.head_pose.position for frame in frames])
    nearest = [int(np.argmin(np.abs(fed - position).max(axis=1))) for position in seen]
    assert np.abs(fed[nearest] - seen).max() <= 1e-6
    assert nearest == sorted(nearest)
    turned = np.array([frame.head_pose.orientation for frame in frames])
    wanted = np.array([participant.sent[index].head.orientation for index in nearest])
    assert np.abs(turned - wanted).max() <= 1e-6


def test_eyes_have_the_fed_offsets_and_frusta(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    fovs = Fov(-0.9, 0.7, 0.6, -0.8), Fov(-0.7, 0.9, 0.6, -0.8)
    offsets = Pose([-0.033, 0.0, 0.0]), Pose([0.033, 0.0, 0.0])
    eyes = View(offsets[0], fovs[0]), View(offsets[1], fovs[1])
    head = Pose([1.0, 1.5, -2.0], axis_angle([0.0, 1.0, 0.0], 0.5))
    with OpenXrHeadset(ctx, SMALL, before_wait=play(lambda _: RemoteState(head, eyes))) as headset:
        frame = settled(headset.frames(), head.position)
    for view, fov, offset in zip(frame.views, fovs, offsets, strict=True):
        wanted = head @ offset
        assert np.allclose(view.pose.position, wanted.position, atol=1e-6)
        assert np.allclose(view.fov.tangents, fov.tangents, atol=1e-6)


def test_frames_count_up_and_time_moves_on(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    with OpenXrHeadset(ctx, SMALL, before_wait=play(still)) as headset:
        first = list(islice(headset.frames(), 5))
        second = list(islice(headset.frames(), 5))
    frames = first + second
    assert [frame.index for frame in frames] == list(range(10))
    assert np.all(np.diff([frame.predicted_display_time_ns for frame in frames]) > 0)
    assert [frame.discontinuity for frame in second] == [True, False, False, False, False]


def test_session_walks_through_its_states_to_the_exit(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    with OpenXrHeadset(ctx, SMALL, before_wait=play(still)) as headset:
        for frame in headset.frames():
            headset.submit(frame, None)
            if frame.session_state == "focused":
                headset.request_exit()
        states = [each.detail for each in headset.take_events() if each.name == "session_state"]
    assert states[:5] == ["idle", "ready", "synchronized", "visible", "focused"]
    assert states[-2:] == ["idle", "exiting"]


def test_nobody_sees_the_frames_before_the_session_is_visible(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    with OpenXrHeadset(ctx, SMALL, before_wait=play(still)) as headset:
        paused = []
        for frame in islice(headset.frames(), 600):
            paused.append(frame.paused)
            if not frame.paused:
                break
    assert paused[0] is True
    assert paused[-1] is False


def test_images_reach_the_runtime_byte_for_byte(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    noise = [np.random.default_rng(seed).bytes(SIZE_PX[0] * SIZE_PX[1] * 4) for seed in (1, 2)]
    eyes = ctx.texture(SIZE_PX, 4, noise[0]), ctx.texture(SIZE_PX, 4, noise[1])
    released = ReleasedImages(ctx)
    settings = replace(SMALL, api_layers=(released.layer.name,))
    with OpenXrHeadset(ctx, settings, before_wait=play(still)) as headset:
        for frame in islice((each for each in headset.frames() if each.should_render), 5):
            headset.submit(frame, eyes)
    assert released.colour == noise * 5


def test_an_image_of_another_size_is_refused(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    wrong = ctx.texture((8, 8), 4)
    with OpenXrHeadset(ctx, SMALL, before_wait=play(still)) as headset:
        frame = next(frame for frame in headset.frames() if frame.should_render)
        with pytest.raises(ValueError, match="8"):
            headset.submit(frame, (wrong, wrong))


def test_buttons_and_aim_arrive_once(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    aim = Pose([0.1, 1.3, -0.2], axis_angle([1.0, 0.0, 0.0], 0.3))
    down: dict[str, bool] = {}
    inputs: list[Inputs] = []

    def script(_: int) -> RemoteState:
        return replace(STANDING, right=RemoteHand(aim, **down, thumbstick=(0.5, -1.0)))

    with OpenXrHeadset(ctx, SMALL, before_wait=play(script)) as headset:

        def wait(seen: Callable[[Inputs], bool]) -> None:
            """Let frames pass until something has come through the runtime, and three more."""
            since = 0
            for frame in islice(headset.frames(), 100):
                inputs.append(headset.inputs())
                headset.submit(frame, None)
                headset.tick(1)
                since = since + 1 if since or seen(inputs[-1]) else 0
                if since > 3:
                    return
            pytest.fail("it did not come")

        wait(lambda now: now.right.aim is not None and now.right.thumbstick[0] > 0)
        down["trigger"] = True
        wait(lambda now: now.right.held)
        down.clear()
        wait(lambda now: not now.right.held)
        for button, came in (("b", "back"), ("a", "stop")):
            down[button] = True
            wait(lambda now, name=came: getattr(now, name))
            down.clear()
        profile = headset.details["right_controller"]
    assert profile.endswith("valve/index_controller")
    assert [each.right.select for each in inputs].count(True) == 1
    assert [each.right.back for each in inputs].count(True) == 1
    assert [each.stop for each in inputs].count(True) == 1
    assert not any(each.left.select for each in inputs)
    assert inputs[-1].right.thumbstick == pytest.approx((0.5, -1.0))
    assert inputs[-1].right.aim is not None
    assert np.allclose(inputs[-1].right.aim.position, aim.position, atol=1e-6)


def test_a_controller_that_is_off_has_no_aim(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    off = RemoteState(Pose([0.0, 1.6, 0.0]), right=RemoteHand(Pose(), active=False))
    with OpenXrHeadset(ctx, SMALL, before_wait=play(lambda _: off)) as headset:
        list(islice(headset.frames(), 6))
        assert headset.inputs().right.aim is None


def test_recentering_moves_the_origin_under_the_head(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    turned = RemoteState(Pose([1.0, 1.6, 2.0], axis_angle([0.0, 1.0, 0.0], 1.0)))
    with OpenXrHeadset(ctx, SMALL, before_wait=play(lambda _: turned)) as headset:
        settled(headset.frames(), turned.head.position)
        headset.recenter()
        after = next(headset.frames())
    assert np.allclose(after.head_pose.position, [0.0, 1.6, 0.0], atol=1e-5)
    assert np.allclose(after.head_pose.forward, [0.0, 0.0, -1.0], atol=1e-5)
    assert after.discontinuity


def test_the_participant_starts_where_the_scene_says(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    spawn = Pose([5.0, 2.0, -3.0], axis_angle([0.0, 1.0, 0.0], -0.7))
    turned = RemoteState(Pose([1.0, 1.6, 2.0], axis_angle([0.0, 1.0, 0.0], 1.0)))
    with OpenXrHeadset(ctx, SMALL, before_wait=play(lambda _: turned)) as headset:
        settled(headset.frames(), turned.head.position)
        headset.place(spawn=spawn)
        frame = next(headset.frames())
    world_from_head = frame.avatar_pose @ frame.head_pose
    assert np.allclose(world_from_head.position, [5.0, 3.6, -3.0], atol=1e-5)
    assert np.allclose(world_from_head.forward, spawn.forward, atol=1e-5)


def test_the_record_knows_runtime_space_and_format(
    ctx: moderngl.Context, play: Callable[[Script], Participant]
) -> None:
    with OpenXrHeadset(ctx, before_wait=play(still)) as headset:
        details = headset.details
        assert "Monado" in headset.name
        assert headset.image_size_px == (320, 240)
        assert headset.refresh_hz == pytest.approx(20.0, abs=0.5)
        assert all(area is not None for area in headset.hidden_areas)
    assert details["space"] == "stage"
    assert details["image_format"] == "SRGB8_ALPHA8"
    assert details["binding"] == "egl"


def test_ten_sessions_in_a_row_leave_nothing_behind(
    ctx: moderngl.Context,
    count_objects: Callable[[], dict[str, int]],
    play: Callable[[Script], Participant],
) -> None:
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    handles = []
    before = count_objects()
    for _ in range(10):
        with OpenXrHeadset(ctx, SMALL, before_wait=play(still)) as headset:
            panel = headset.show_panel((32, 16), Quad(Pose([0.0, 1.5, -1.5]), (1.0, 0.5)))
            panel.draw(np.zeros((16, 32, 4), dtype=np.uint8))
            for frame in islice(headset.frames(), 5):
                headset.submit(frame, eyes)
        handles.append(len(list(Path("/proc/self/fd").iterdir())))
    assert count_objects() == before
    assert handles[-1] == handles[1]


def test_a_killed_runtime_is_told_from_other_faults(ctx: moderngl.Context, tmp_path: Path) -> None:
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    seen: list[int] = []
    with fresh_monado(tmp_path) as service, service.feed() as feed:
        headset = OpenXrHeadset(ctx, SMALL, before_wait=Participant(feed, still))

        def run() -> None:
            for frame in headset.frames():
                headset.submit(frame, eyes)
                seen.append(frame.index)
                if frame.index == 8:
                    service.kill()

        with pytest.raises(RuntimeLostError, match="kept"):
            run()
        headset.close()
    assert seen[:9] == list(range(9))


def test_without_a_runtime_the_message_says_what_to_start(
    ctx: moderngl.Context, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with fresh_monado(tmp_path):
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "nobody"))
        with pytest.raises(InputError, match="start your headset's software"):
            OpenXrHeadset(ctx, SMALL)
