"""A session may be long: showing and recording frames keeps nothing."""

from __future__ import annotations

import gc
import os
import sys
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.support.render import at, box, floor, glowing, scene
from vrcomfort.geometry import axis_angle
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition, DepthOfField, MotionBlur
from vrcomfort.records import Recorder
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.traces.gaze_track import GazeTrack
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace

WARM_UP, COUNTED, EVERY = 500, 1000, 50
BLOCKS, RSS_KIB = 2.0, 2.0
"""Two small objects, or 2 KiB, per frame: less than any frame, image or row takes."""


class Used(NamedTuple):
    blocks: float
    rss_kib: float


def used() -> Used:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return Used(sys.getallocatedblocks(), pages * os.sysconf("SC_PAGE_SIZE") / 1024)


def walk() -> Trace:
    n = 50
    turns = axis_angle(np.array([[0.0, 1.0, 0.0]]), 0.3 * np.sin(np.arange(n) / 8))
    positions = np.stack([0.01 * np.arange(n), np.full(n, 1.6), np.full(n, 3.0)], axis=1)
    times = np.arange(n) * 11_111_111
    directions = np.tile([0.0, 0.0, -1.0], (n, 1))
    gaze = GazeTrack(times, np.arange(n) % 7 != 0, positions, directions)
    return Trace(times, PoseTrack(positions, turns), np.arange(n) == 0, gaze=gaze)


def growth(ctx, folder, keep) -> Used:
    """Show and record frames; return what each of the last `COUNTED` keeps."""
    renderer = StereoRenderer(ctx, (16, 16))
    world = scene([at(0, 0, 0), at(0, 1, 0, mesh=(1,))], [floor(), box()], [glowing((1, 1, 1))])
    effects = Condition(name="both", depth_of_field=DepthOfField(), motion_blur=MotionBlur())
    renderer.begin(world, effects)
    headset = PlaybackHeadset(walk(), image_size_px=(16, 16))
    with Recorder(folder, "P1", 1) as recorder:
        log, seen = FrameLog(recorder), []
        for frame in islice(headset.frames(), WARM_UP + COUNTED):
            rendered = renderer.render(frame, frame.index / 90)
            log.add(frame, rendered, trial=1, session_s=frame.index / 90)
            keep(frame)
            if frame.index >= WARM_UP and frame.index % EVERY == 0:
                recorder.flush()
                seen.append(used())
    renderer.release()
    return Used(*np.apply_along_axis(slope, 0, np.array(seen)))


def slope(values: np.ndarray) -> float:
    """Return the growth per frame (Theil & Sen): a single step of the allocator is none."""
    before, after = np.triu_indices(len(values), 1)
    return float(np.median((values[after] - values[before]) / ((after - before) * EVERY)))


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_frames_leave_nothing_behind(ctx, tmp_path):
    kept = growth(ctx, tmp_path, lambda _: None)
    assert kept.blocks < BLOCKS
    assert kept.rss_kib < RSS_KIB


@pytest.mark.slow
def test_a_frame_that_is_kept_would_be_noticed(ctx, tmp_path):
    frames: list[object] = []
    assert growth(ctx, tmp_path, lambda frame: frames.append(frame.views)).blocks > BLOCKS
