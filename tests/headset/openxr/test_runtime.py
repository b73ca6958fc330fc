"""A headset through our own runtime, which follows a script: frame by frame what it says."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr_runtime import ScriptedRuntime, numbers
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, Quad, axis_angle
from vrcomfort.gpu import gl
from vrcomfort.headset.base import Headset

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.openxr.native import pose_from_xr

pytestmark = pytest.mark.windows
SIZE_PX = (16, 16)


@contextmanager
def headset(ctx: moderngl.Context, folder: Path, script: str = "") -> Iterator[OpenXrHeadset]:
    script = f"log {folder / 'log.txt'}\n{script}"
    with (
        ScriptedRuntime(folder, script),
        OpenXrHeadset(ctx, OpenXrSettings(image_size_px=SIZE_PX)) as made,
    ):
        yield made


def shown(ctx: moderngl.Context, made: Headset, count: int) -> list[Frame]:
    """Return frames that were shown, a picture in each that wanted one."""
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    frames = []
    for frame in islice(made.frames(), count):
        made.submit(frame, eyes if frame.should_render else None)
        frames.append(frame)
    return frames


def test_frames_have_the_poses_of_the_script(ctx: moderngl.Context, tmp_path: Path) -> None:
    turns = [axis_angle([0.3, 1.0, 0.2], 0.05 * each) for each in range(30)]
    fed = [Pose(np.array([0.01 * n, 1.6, -0.2 * n]), turn) for n, turn in enumerate(turns)]
    script = "\n".join(f"{n} head {numbers(pose)}" for n, pose in enumerate(fed))
    with headset(ctx, tmp_path, script) as made:
        frames = shown(ctx, made, len(fed))
        assert made.details["binding"] == ("wgl" if sys.platform == "win32" else "egl")
    for pose, frame in zip(fed, frames, strict=True):
        assert np.abs(frame.head_pose.position - pose.position).max() <= 1e-6
        assert abs(float(frame.head_pose.orientation @ pose.orientation)) >= 1 - 1e-6
    left, right = frames[-1].views
    apart = left.pose.position - right.pose.position
    assert np.linalg.norm(apart) == pytest.approx(0.064, abs=1e-6)


def test_states_presence_and_pictures_follow_the_script(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    rules = "10-14 state visible\n20-24 not_drawn 100\n30-34 present 0\n40-44 invalid 100\n"
    with headset(ctx, tmp_path, f"{rules}50-54 untracked 100\n60-64 period 2") as made:
        frames = shown(ctx, made, 70)
        told = [(event.name, event.detail) for event in made.take_events()]
    wanted = {
        "unfocused": [frame.session_state != "focused" for frame in frames],
        "not drawn": [not frame.should_render for frame in frames],
        "off": [frame.user_present is False for frame in frames],
        "invalid": [not frame.head_valid for frame in frames],
        "untracked": [not frame.head_tracked for frame in frames],
    }
    found = {name: [n for n, holds in enumerate(each) if holds] for name, each in wanted.items()}
    assert found["not drawn"] == list(range(20, 25))
    assert found["invalid"] == list(range(40, 45))
    assert found["untracked"] == [*range(40, 45), *range(50, 55)]
    # Events are read before the frame in which the runtime sends them is waited for.
    assert found["unfocused"] == list(range(11, 16))
    assert found["off"] == list(range(31, 36))
    assert len({frame.period_ns for frame in frames}) == 1
    names = [name for name, _ in told]
    assert names.count("headset_off") == names.count("unfocused") == 1
    assert not {"controller_lost", "controller_found"} & {*names}


def test_a_controller_that_goes_and_comes_is_told_and_the_rate_is_the_displays(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    with headset(ctx, tmp_path, "rates 72 90\nperiod_ns 11111111\n10-19 active right 0") as made:
        shown(ctx, made, 30)
        told = [(event.name, event.detail) for event in made.take_events()]
        assert made.refresh_hz == 72.0
        assert made.details["frame_period"].startswith("the display's refresh rate")
    of_controllers = [each for each in told if each[0].startswith("controller_")]
    assert of_controllers[-2:] == [("controller_lost", "right"), ("controller_found", "right")]


def test_a_session_ends_when_it_is_asked_to_also_before_its_first_frame(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    with headset(ctx, tmp_path) as made:
        assert made.wake(10.0)
    settings = OpenXrSettings(image_size_px=SIZE_PX, patience_s=2.0)
    with ScriptedRuntime(tmp_path), OpenXrHeadset(ctx, settings) as made:
        assert len(shown(ctx, made, 3)) == 3
        made.request_exit()
        assert len(shown(ctx, made, 100)) < 100


def test_a_panel_that_is_moved_stands_elsewhere(ctx: moderngl.Context, tmp_path: Path) -> None:
    with headset(ctx, tmp_path) as made:
        panel = made.show_panel((8, 6), Quad(Pose(), (1.0, 0.75)))
        panel.draw(np.zeros((6, 8, 4), np.uint8))
        moved = Pose(np.array([0.5, 1.25, -2.0]), axis_angle([0.0, 1.0, 0.0], 0.5))
        panel.move(Quad(moved, (1.0, 0.75)))
        layer = panel.structure(xr.Space())
        assert layer is not None
        stands = pose_from_xr(layer.pose)
    assert np.allclose(stands.position, moved.position)
    assert np.allclose(stands.orientation, moved.orientation)


def test_what_is_shown_comes_to_the_runtime_with_its_depth(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    depth, eyes = gl.depth_texture(ctx, SIZE_PX), (ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4))
    with headset(ctx, tmp_path) as made:
        for frame in islice(made.frames(), 6):
            for eye in (0, 1) if frame.index % 2 else ():
                made.take_depth(eye, depth, 0.05)
            made.submit(frame, eyes)
        made.tick(1)
    said = (tmp_path / "log.txt").read_text().splitlines()
    assert "haptic /user/hand/right 30000000 ns" in said
    ended = [line.partition(" layers ")[2] for line in said if line.startswith("frame")]
    assert ended[:6] == ["1 eyes 1 depths 0", "1 eyes 1 depths 2"] * 3


@pytest.mark.parametrize(
    ("rule", "error", "words"),
    [
        ("start answer xrGetSystem -35", InputError, "finds no headset; connect it"),
        ("start answer xrCreateSession -38", InputError, "another graphics device"),
        ("20 answer xrWaitFrame -17", RuntimeLostError, r"stopped in the middle.*--resume"),
        ("20 state loss_pending", RuntimeLostError, r"announced the loss.*--resume"),
        ("20 instance_loss", RuntimeLostError, r"going away.*--resume"),
        ("20 answer * -13", RuntimeLostError, r"stopped in the middle.*--resume"),
    ],
)
def test_a_fault_of_the_script_is_a_sentence(
    ctx: moderngl.Context, tmp_path: Path, rule: str, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words), headset(ctx, tmp_path, rule) as made:
        shown(ctx, made, 40)


def test_a_line_that_is_none_refuses_the_runtime(ctx: moderngl.Context, tmp_path: Path) -> None:
    with pytest.raises(InputError), headset(ctx, tmp_path, "5 head 1 2"):
        pass


def test_patience_begins_anew_with_each_frame_that_is_seen(
    ctx: moderngl.Context, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s, passed_s = time.monotonic, [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now_s() + passed_s[0])
    settings = OpenXrSettings(image_size_px=SIZE_PX, patience_s=600.0)
    with (
        ScriptedRuntime(tmp_path, "speed 0\n9-9999 present 0\n"),
        OpenXrHeadset(ctx, settings) as made,
    ):
        frames = made.frames()

        def is_there(count: int) -> list[bool | None]:
            taken = []
            for frame in islice(frames, count):
                made.submit(frame, None)
                taken.append(frame.user_present)
            return taken

        assert is_there(5) == [True] * 5
        passed_s[0] = 500.0
        assert is_there(5) == [True] * 5
        passed_s[0] = 1000.0
        assert is_there(5) == [False] * 5
        passed_s[0] = 1200.0
        with pytest.raises(RuntimeLostError, match="600 s"):
            is_there(1)
