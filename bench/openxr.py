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

from bench import memory
from bench.clocked import Clock, Lap, clocked_opengl, replaced, yardstick_s
from bench.effects import CONDITIONS
from bench.table import Result
from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl
from vrcomfort.headset.monado import Monado, RemoteFeed, RemoteHand, RemoteState
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings, native
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.records import Recorder
from vrcomfort.render.condition_passes import EyeImages
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.scene.data import Scene
from vrcomfort.scene.floors import Floors
from vrcomfort.scene.load import load_scene
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import aim_at
from vrcomfort.traces.trace import read_trace
from vrcomfort.tradeoff.walk import REFRESH_HZ

FMS = shipped_instruments()["fms"]

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


def measure_memory(ctx: moderngl.Context, *, frames: int) -> Result:
    """Show frames through Monado and record them; look whether memory grows."""
    settings = OpenXrSettings(image_size_px=memory.SIZE_PX)
    trace = read_trace(data_folder("scenes") / f"{SCENE}_walk.csv")
    with Monado() as monado, monado.feed() as feed:
        rig = Rig(feed, map(trace.head.pose, cycle(range(len(trace)))))
        with (
            OpenXrHeadset(ctx, settings, before_wait=rig) as headset,
            memory.frame_loop(ctx, headset) as show,
        ):
            return memory.result("Memory, Monado", memory.watch(show, frames))


def measure(ctx: moderngl.Context, *, frames: int) -> Result:
    """Run the loop of an exposure with more and more in it, plain and with all effects."""
    clock = Clock()
    with Monado() as monado, monado.feed() as feed, clocked(clock):
        bench = Bench(ctx, clock, feed)
        rows = [
            _row(condition.name, step, bench.laps(condition, step, frames))
            for condition in (CONDITIONS[0], CONDITIONS[-1])
            for step in STEPS
        ]
    best_s = min(map(min, bench.yardsticks_s))
    for row, yardsticks_s in zip(rows, bench.yardsticks_s, strict=True):
        row["machine busy"] = float(np.median(yardsticks_s)) / best_s
    width, height = SIZE_PX
    notes = [
        f"{frames} stereo frames of the shipped {SCENE} walk, {width}×{height} px, through Monado "
        "with its null compositor; each row adds to the one above it. `draw only` is the renderer "
        "on a playback headset.",
        "CPU time of the thread that runs the loop, from one frame's end to the next: what blocks "
        "(xrWaitFrame, images, answers of the runtime) takes none. Taken away: what is inside "
        "moderngl's methods and the copies of images (OpenGL and its software rasteriser), and the "
        "feed of head and hand. `runtime` is what is inside OpenXR's functions, waiting aside; "
        "`python` is the rest. Python's collector of cycles runs as it does in a session.",
        "`machine busy`: how much longer a fixed piece of Python took beside these frames (median) "
        "than at its best in the whole run; 1 is an idle machine.",
        f"Shares are of {1e3 / REFRESH_HZ:.1f} ms, a frame at {REFRESH_HZ} Hz.",
    ]
    return Result("Python time per frame under OpenXR", rows, notes)


@contextmanager
def clocked(clock: Clock) -> Iterator[None]:
    """Count OpenGL and the runtime's functions, of headsets that are made in here."""
    functions = xr.raw_functions
    with ExitStack() as kept:
        kept.enter_context(clocked_opengl(clock, gl))
        raw = native._raw
        calling = replaced(native, "_raw", lambda name: clock.around("runtime", raw(name)))
        kept.enter_context(calling)
        for name in dir(functions):
            if name.startswith("xr") and callable(function := getattr(functions, name)):
                counted: Any = clock.around("runtime", function)
                counted.argtypes = function.argtypes  # `native` makes its own function from them
                kept.enter_context(replaced(functions, name, counted))
        yield


def _row(condition: str, step: str, laps: list[Lap]) -> dict[str, Any]:
    python = 1e3 * np.array([lap.python_s for lap in laps])
    runtime = 1e3 * np.array([lap.runtime_s for lap in laps])
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


class Bench:
    """Runs loops through one runtime."""

    def __init__(self, ctx: moderngl.Context, clock: Clock, feed: RemoteFeed) -> None:
        self._ctx, self._clock, self._feed = ctx, clock, feed
        self.yardsticks_s: list[list[float]] = []
        """Of each loop, of each frame."""
        self._scene: Scene = load_scene(SCENE)
        self._trace = read_trace(data_folder("scenes") / f"{SCENE}_walk.csv")

    def laps(self, condition: Condition, step: str, frames: int) -> list[Lap]:
        """Return the laps of `frames` frames of one kind of loop."""
        level = STEPS.index(step)
        with ExitStack() as owned:
            headset = self._headset(owned) if level else self._playback()
            renderer = StereoRenderer(self._ctx, SIZE_PX, on_eye=_depth_taker(headset))
            owned.callback(renderer.release)
            renderer.begin(self._scene, condition)
            log = respondent = None
            if level >= STEPS.index("+ recording"):
                folder = Path(owned.enter_context(tempfile.TemporaryDirectory()))
                log = FrameLog(owned.enter_context(Recorder(folder, "P1", 1)))
            if level >= STEPS.index("+ panel, pointer moving"):
                self._rig.screen = PanelScreen(headset)
                respondent = PanelRespondent(self._rig.screen)
                respondent.prompt(FMS, 0.0, 1e9)
            return self._loop(headset, renderer, log, respondent, frames)

    def _playback(self) -> PlaybackHeadset:
        return PlaybackHeadset(self._trace, image_size_px=SIZE_PX, spawn=self._scene.spawn)

    def _headset(self, owned: ExitStack) -> OpenXrHeadset:
        self._rig = Rig(self._feed, map(self._trace.head.pose, cycle(range(len(self._trace)))))
        headset = OpenXrHeadset(
            self._ctx,
            OpenXrSettings(image_size_px=SIZE_PX),
            before_wait=self._clock.around("rig", self._rig),
        )
        owned.enter_context(headset)
        headset.place(spawn=self._scene.spawn, floors=Floors(self._scene.walkable))
        return headset

    def _loop(
        self,
        headset: Any,
        renderer: StereoRenderer,
        log: FrameLog | None,
        respondent: PanelRespondent | None,
        frames: int,
    ) -> list[Lap]:
        """Draw, show and record each frame as `session.exposure.FrameLoop` does."""
        laps = []
        self.yardsticks_s.append([])
        for frame in islice(headset.frames(), WARM_UP + frames):
            rendered = None
            if frame.should_render:
                rendered = renderer.render(frame, frame.predicted_display_time_ns / 1e9)
            headset.submit(frame, rendered.eyes if rendered else None)
            headset.take_events()
            if log is not None:
                log.add(frame, rendered, trial=1, session_s=frame.index / REFRESH_HZ)
            if respondent is not None:
                respondent.update(frame.index / REFRESH_HZ)
            laps.append(self._clock.lap())
            self._ctx.finish()
            self.yardsticks_s[-1].append(yardstick_s())
            self._clock.lap()
        return laps[WARM_UP:]


def _depth_taker(headset: Any) -> Callable[[int, EyeImages], None] | None:
    take = getattr(headset, "take_depth", None)
    return take and (lambda eye, images: take(eye, images.depth, images.camera.near_m))
