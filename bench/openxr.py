"""Python's own time per frame of an OpenXR session: everything but OpenGL and waiting."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import xr

from bench.clocked import Clock, Lap, clocked_opengl, replaced
from bench.effects import CONDITIONS
from bench.table import Result
from vrcomfort.geometry import Pose
from vrcomfort.headset.base import Headset
from vrcomfort.headset.floors import Floors
from vrcomfort.headset.monado import Monado
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings, depth, native
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.headset.remote_feed import RemoteFeed, RemoteHand, RemoteState
from vrcomfort.headset.trace import Trace, read_trace
from vrcomfort.questionnaire import FMS
from vrcomfort.records import Recorder
from vrcomfort.render.gltf import load_scene
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.scene_data import Scene
from vrcomfort.resources import data_folder
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import aim_at
from vrcomfort.tradeoff.walk import REFRESH_HZ

SIZE_PX = (64, 80)
"""Small, so that a software rasteriser takes little: Python's time does not depend on it."""

SCENE = "temple"
WARM_UP = 20
"""Frames before the first that counts: the session begins, and programs are compiled."""

STEPS = ("draw only", "headset loop", "+ recording", "+ panel, pointer moving")


@dataclass
class Rig:
    """Feeds the runtime before each frame: a head that walks, a hand that sweeps over the panel."""

    feed: RemoteFeed
    heads: Iterator[Pose]
    screen: PanelScreen | None = None
    frame: int = field(default=0, init=False)

    def __call__(self) -> None:
        """Send the next state."""
        self.frame += 1
        self.feed.send(RemoteState(next(self.heads), right=self._hand()))

    def _hand(self) -> RemoteHand:
        quad = None if self.screen is None else self.screen.quad
        if quad is None:
            return RemoteHand(Pose(np.array([0.2, 1.2, -0.3])))
        turn = self.frame / 20
        point = 0.5 + 0.4 * math.sin(turn), 0.5 + 0.4 * math.cos(1.7 * turn)
        return RemoteHand(aim_at(quad, point))


def measure(ctx: moderngl.Context, *, frames: int) -> Result:
    """Run the loop of an exposure with more and more in it, plain and with all effects."""
    scene = load_scene(SCENE)
    trace = read_trace(data_folder("scenes") / f"{SCENE}_walk.csv")
    clock = Clock()
    with Monado() as monado, monado.feed() as feed, clocked(clock):
        rows = [
            _row(
                condition.name, step, _laps(ctx, clock, scene, trace, feed, condition, step, frames)
            )
            for condition in (CONDITIONS[0], CONDITIONS[-1])
            for step in STEPS
        ]
    notes = [
        f"{frames} stereo frames of the shipped {SCENE} walk, {SIZE_PX[0]}×{SIZE_PX[1]} px, through "
        "Monado with its null compositor; each row adds to the one above it. `draw only` is the "
        "renderer on a playback headset.",
        "CPU time of the thread that runs the loop, from one frame's end to the next: what blocks "
        "(xrWaitFrame, images, answers of the runtime) takes none. Taken away: what is inside "
        "moderngl's methods and the copy of depth (OpenGL and its software rasteriser), and the "
        "feed of head and hand. `runtime` is what is inside OpenXR's functions, waiting aside; "
        "`python` is the rest. Python's collector of cycles runs as it does in a session.",
        f"Shares are of {1e3 / REFRESH_HZ:.1f} ms, a frame at {REFRESH_HZ} Hz.",
    ]
    return Result("Python time per frame under OpenXR", rows, notes)


@contextmanager
def clocked(clock: Clock) -> Iterator[None]:
    """Count OpenGL and the runtime's functions, of headsets that are made in here."""
    copier: Callable[..., Any] = depth._copier
    functions = xr.raw_functions
    with ExitStack() as kept:
        kept.enter_context(clocked_opengl(clock))
        copying = replaced(depth, "_copier", lambda ctx: clock.around("opengl", copier(ctx)))
        kept.enter_context(copying)
        raw = native._raw
        calling = replaced(native, "_raw", lambda name: clock.around("runtime", raw(name)))
        kept.enter_context(calling)
        for name in dir(functions):
            if name.startswith("xr") and callable(function := getattr(functions, name)):
                kept.enter_context(replaced(functions, name, clock.around("runtime", function)))
        yield


def _row(condition: str, step: str, laps: list[Lap]) -> dict[str, Any]:
    python, runtime = (
        1e3 * np.array(values) for values in zip(*((l.python_s, l.runtime_s) for l in laps))
    )
    (median, high), budget = np.percentile(python + runtime, [50, 99]), 1e3 / REFRESH_HZ
    return {
        "condition": condition,
        "loop": step,
        "median ms": float(median),
        "p99 ms": float(high),
        "median %": float(100 * median / budget),
        "p99 %": float(100 * high / budget),
        "python median ms": float(np.median(python)),
        "runtime median ms": float(np.median(runtime)),
    }


def _laps(
    ctx: moderngl.Context, clock: Clock, scene: Scene, trace: Trace, feed: RemoteFeed,
    condition: Any, step: str, frames: int,
) -> list[Lap]:  # fmt: skip
    """Return the laps of `frames` frames of one kind of loop."""
    level = STEPS.index(step)
    with ExitStack() as owned:
        headset: Any
        if level == 0:
            headset = PlaybackHeadset(trace, image_size_px=SIZE_PX, spawn=scene.spawn)
            on_eye = None
        else:
            rig = Rig(feed, map(trace.head.pose, cycle(range(len(trace)))))
            settings = OpenXrSettings(image_size_px=SIZE_PX)
            before_wait = clock.around("rig", rig)
            headset = owned.enter_context(OpenXrHeadset(ctx, settings, before_wait=before_wait))
            headset.place(spawn=scene.spawn, floors=Floors(scene.walkable))
            on_eye = lambda eye, images: headset.take_depth(eye, images.depth, images.camera.near_m)
        renderer = StereoRenderer(ctx, SIZE_PX, on_eye=on_eye)
        renderer.begin(scene, condition)
        owned.callback(renderer.release)
        log = respondent = None
        if level >= 2:
            folder = Path(owned.enter_context(tempfile.TemporaryDirectory()))
            log = FrameLog(owned.enter_context(Recorder(folder, "P1", 1)))
        if level >= 3:
            rig.screen = PanelScreen(headset)
            respondent = PanelRespondent(rig.screen)
            respondent.prompt(FMS, 0.0, 1e9)
        laps = _loop(ctx, clock, headset, renderer, log, respondent, frames)
    return laps


def _loop(
    ctx: moderngl.Context, clock: Clock, headset: Headset, renderer: StereoRenderer,
    log: FrameLog | None, respondent: PanelRespondent | None, frames: int,
) -> list[Lap]:  # fmt: skip
    """Do what `session.exposure.FrameLoop` does with each frame."""
    laps = []
    for frame in islice(headset.frames(), WARM_UP + frames):
        rendered = None
        if frame.should_render:
            rendered = renderer.render(frame, frame.predicted_display_time_ns / 1e9)
        headset.submit(frame, rendered.eyes if rendered else None)
        headset.take_events()
        if log is not None:
            log.add(frame, rendered, trial=1, session_s=frame.index / REFRESH_HZ)
        if respondent is not None:
            respondent.endure(frame.index / REFRESH_HZ)
        laps.append(clock.lap())
        ctx.finish()
        clock.lap()
    return laps[WARM_UP:]
