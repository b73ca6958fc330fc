"""Thumb-sticks of real controllers walk, through the runtime; and the operator's window."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pandas as pd
import pytest

from tests.support.openxr import Participant, fresh_monado, needs_monado
from tests.support.study import smoke_with
from tests.support.x_server import x_server
from vrcomfort.frame import Frame
from vrcomfort.geometry import Array, Pose, axis_angle
from vrcomfort.headset.monado import RemoteState
from vrcomfort.resources import data_folder
from vrcomfort.scene.floors import Floors

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (16, 16)
SPEED_M_S = 1.4
STILL = RemoteState(Pose(np.array([0.3, 1.6, -0.2]), axis_angle([0.0, 1.0, 0.0], 1.0)))


@dataclass(frozen=True)
class Piece:
    """A floor, as a scene has it."""

    polygon_xz: Array
    height_m: float = 0.0
    slope_xz: tuple[float, float] = (0.0, 0.0)


CORRIDOR = Piece(np.array([[-1.0, 1.0], [-1.0, -3.0], [1.0, -3.0], [1.0, 1.0]]))


def with_sticks(left: tuple[float, float], right: tuple[float, float]) -> RemoteState:
    left_hand, right_hand = STILL.left, STILL.right
    return replace(
        STILL,
        left=replace(left_hand, thumbstick=left),
        right=replace(right_hand, thumbstick=right),
    )


def feet(frame: Frame) -> Array:
    x, _, z = frame.head_pose.position
    return (frame.avatar_pose @ Pose(np.array([x, 0.0, z]))).position


def walk(
    ctx: moderngl.Context, folder: Path, script: Callable[[int], RemoteState], shown: bool
) -> list[Frame]:
    """Return 60 seen frames of somebody who starts in a corridor and looks along it."""
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    with fresh_monado(folder) as monado, monado.feed() as feed:
        settings = OpenXrSettings(image_size_px=SIZE_PX)
        with OpenXrHeadset(ctx, settings, before_wait=Participant(feed, script)) as headset:
            list(islice(headset.frames(), 3))
            headset.place(spawn=Pose(), floors=Floors([CORRIDOR]))
            frames = []
            for frame in islice((each for each in headset.frames() if not each.paused), 60):
                headset.submit(frame, eyes if shown else None)
                frames.append(frame)
            return frames


def test_the_left_stick_walks_at_one_speed_and_never_through_the_wall(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    frames = walk(ctx, tmp_path, lambda _: with_sticks((0.0, 0.6), (0.0, 0.0)), shown=True)
    path = np.array([feet(frame) for frame in frames])
    assert path[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert path[-1] == pytest.approx([0.0, 0.0, -3.0], abs=1e-5)
    passed_s = np.diff([frame.predicted_display_time_ns for frame in frames]) / 1e9
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert (lengths <= SPEED_M_S * passed_s + 1e-6).all()
    full = (lengths > 1e-4) & (path[1:, 2] > -2.9) & (passed_s < 0.1)
    assert full.sum() > 10
    assert lengths[full] == pytest.approx(SPEED_M_S * passed_s[full], abs=1e-5)


def test_the_right_stick_turns_the_torso_about_the_feet(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    frames = walk(ctx, tmp_path, lambda _: with_sticks((0.0, 0.0), (-1.0, 0.0)), shown=True)
    path = np.array([feet(frame) for frame in frames])
    assert np.abs(path).max() < 1e-5
    looks = [(frame.avatar_pose @ frame.head_pose).forward for frame in frames]
    assert looks[0] == pytest.approx([0.0, 0.0, -1.0], abs=1e-5)
    angle = np.unwrap([np.arctan2(-look[0], -look[2]) for look in looks])
    passed_s = (frames[-1].predicted_display_time_ns - frames[0].predicted_display_time_ns) / 1e9
    assert 0.5 * np.pi / 3 * passed_s < angle[-1] <= np.pi / 3 * passed_s + 1e-6


def test_nobody_walks_while_the_scene_is_not_shown(ctx: moderngl.Context, tmp_path: Path) -> None:
    frames = walk(ctx, tmp_path, lambda _: with_sticks((0.0, 1.0), (1.0, 0.0)), shown=False)
    assert np.abs([feet(frame) for frame in frames]).max() < 1e-5


def test_a_mirror_shows_the_rehearsal_to_the_operator(tmp_path: Path) -> None:
    answers = tmp_path / "answers.txt"
    answers.write_text("0 1 2 3 " * 60)
    command = [
        *("vrcomfort", "run", str(smoke_with(tmp_path, 1.0)), "--participant", "P01"),
        *("--out", str(tmp_path / "study"), "--quiet", "--mirror"),
        *("--headset", "openxr", "--size", "64x80"),
        *("--monado-trace", str(data_folder("scenes") / "temple_walk.csv")),
        *("--monado-answers", str(answers)),
    ]
    colors = []
    with (
        x_server(tmp_path, (640, 640)) as server,
        subprocess.Popen(
            command, env={**os.environ, **server.environment}, stderr=subprocess.PIPE, text=True
        ) as process,
    ):
        while process.poll() is None:
            time.sleep(0.1)
            screen = server.picture()[::8, ::8].reshape(-1, 3)
            colors.append(len(np.unique(screen, axis=0)))
        assert process.stderr is not None
        assert process.returncode == 0, process.stderr.read()
    assert sum(20 < count < 300 for count in colors) > 10  # a panel: few colours
    assert max(colors) > 1000  # the temple: many
    rows = pd.read_csv(tmp_path / "study" / "sub-P01" / "ses-1" / "questionnaires.csv")
    assert rows["response"].tolist()[:16] == [0, 1, 2, 3] * 4
