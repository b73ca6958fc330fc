"""Whether memory grows while frames are shown: resident memory of the process, frame by frame."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.effects import CONDITIONS
from bench.table import Result
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.records import Recorder
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.traces.trace import read_trace
from vrcomfort.tradeoff.walk import REFRESH_HZ

SIZE_PX = (16, 16)
SCENE = "temple"
CONDITION = CONDITIONS[-1]

SAMPLES = 100
WARM_UP = 0.2
"""Share of the frames that are left out: caches fill, and the allocator settles."""

ALLOWED_KIB = 512.0
"""Growth over a whole run that counts as none; the scatter of the samples comes on top."""

Values = NDArray[np.float64]


class Growth(NamedTuple):
    """How memory changed over some frames.

    Parameters
    ----------
    rss_kib_per_1000, blocks_per_1000
        Slopes (Theil & Sen: the median of all pairs) of resident memory, and of the blocks that
        Python's allocator has given out.
    rss_kib
        The slope times the frames that count.
    scatter_kib
        Half of the samples lie closer to that line.
    """

    frames: int
    rss_kib_per_1000: float
    blocks_per_1000: float
    rss_kib: float
    scatter_kib: float

    @property
    def none(self) -> bool:
        """Return whether memory has not grown, as far as this tells."""
        return self.rss_kib <= ALLOWED_KIB + 3 * self.scatter_kib


def rss_kib() -> float:
    """Return the resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024


def watch(show: Callable[[], object], frames: int) -> Growth:
    """Show frames, and sample memory a hundred times meanwhile."""
    every = max(frames // SAMPLES, 1)
    seen = []
    for frame in range(frames):
        if frame % every == 0 and frame >= WARM_UP * frames:
            gc.collect()
            seen.append((frame, rss_kib(), sys.getallocatedblocks()))
        show()
    at, rss, blocks = np.array(seen, dtype=np.float64).T
    slope = _slope(at, rss)
    scatter = np.median(np.abs(rss - slope * at - np.median(rss - slope * at)))
    whole = slope * float(at[-1] - at[0])
    return Growth(frames, slope * 1000, _slope(at, blocks) * 1000, whole, float(scatter))


def _slope(at: Values, values: Values) -> float:
    before, after = np.triu_indices(len(at), 1)
    return float(np.median((values[after] - values[before]) / (at[after] - at[before])))


def measure(ctx: moderngl.Context, *, frames: int) -> Result:
    """Play a looped walk with recording."""
    with frame_loop(ctx, playback()) as show:
        return result("Memory, playback", watch(show, frames))


def playback() -> PlaybackHeadset:
    """Return a headset that plays the shipped walk again and again."""
    trace = read_trace(data_folder("scenes") / f"{SCENE}_walk.csv")
    spawn = load_scene(SCENE).spawn
    return PlaybackHeadset(trace, image_size_px=SIZE_PX, refresh_hz=REFRESH_HZ, spawn=spawn)


@contextmanager
def frame_loop(ctx: moderngl.Context, headset: Any) -> Iterator[Callable[[], object]]:
    """Yield functions that draw, show and record a frame, as `session.exposure.FrameLoop` does."""
    renderer = StereoRenderer(ctx, SIZE_PX)
    renderer.begin(load_scene(SCENE), CONDITION)
    with tempfile.TemporaryDirectory() as folder, Recorder(Path(folder), "P1", 1) as recorder:
        log, frames = FrameLog(recorder), headset.frames()

        def show() -> None:
            frame = next(frames)
            rendered = None
            if frame.should_render:
                rendered = renderer.render(frame, frame.predicted_display_time_ns / 1e9)
            headset.submit(frame, rendered.eyes if rendered else None)
            headset.take_events()
            log.add(frame, rendered, trial=1, session_s=frame.index / REFRESH_HZ)

        yield show
    renderer.release()


def result(title: str, growth: Growth) -> Result:
    """Return a table of one row."""
    row = {
        "frames": growth.frames,
        "KiB per 1000 frames": growth.rss_kib_per_1000,
        "KiB in all": growth.rss_kib,
        "allowed KiB": ALLOWED_KIB + 3 * growth.scatter_kib,
        "none": growth.none,
        "Python blocks per 1000 frames": growth.blocks_per_1000,
    }
    notes = [
        f"Temple, both effects, {SIZE_PX[0]}×{SIZE_PX[1]} px per eye, recorded to a disk. The "
        f"first {WARM_UP:.0%} of the frames are left out.",
        f"Resident memory at {SAMPLES} moments: slope by Theil & Sen. Allowed over the whole run: "
        f"{ALLOWED_KIB:g} KiB and three times the samples' median distance from the line.",
    ]
    return Result(title, [row], notes)
