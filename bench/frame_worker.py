"""One side of `bench.python_time`: draws and records frames with the code of one checkout.

Runs as a script, in a process of its own, with that checkout first on the path; it also reads
checkouts from before modules moved. Each line of standard input is a number of frames; the answer
is a line of JSON with what each of them took.

    PYTHONPATH=CHECKOUT python bench/frame_worker.py '{"scene": "temple", "effects": true}'
"""

from __future__ import annotations

import cProfile
import gc
import json
import pstats
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path
from typing import Any

import moderngl
from clocked import Clock, clocked_opengl

SIZE_PX = (160, 200)
"""Small, so that a software rasteriser takes little. Yet discs are wide enough for all passes:
where none has a radius of 2 px, nothing is drawn behind near things."""

REFRESH_HZ = 90
WARM_UP = 20
"""Frames before the first that counts."""

DRAWS = ("VertexArray.render", "VertexArray.render_indirect", "glMultiDrawElementsIndirect")


def found(name: str, *modules: str) -> Any:
    """Return a name from the first of these modules that has it: modules have moved."""
    for module in modules:
        try:
            return getattr(import_module(f"vrcomfort.{module}"), name)
        except ImportError:
            continue
    raise ImportError(f"no {name} in {', '.join(modules)}")


def opengl() -> Any:
    """Return the module that makes contexts."""
    for name in ("vrcomfort.gpu.gl", "vrcomfort.render.gl"):
        try:
            return import_module(name)
        except ImportError:
            continue
    raise ImportError("no vrcomfort on the path")


class Loop:
    """The frames of an exposure, as `session.exposure.FrameLoop` draws and records them."""

    def __init__(self, ctx: moderngl.Context, wanted: dict[str, Any], folder: Path) -> None:
        scene = found("load_scene", "scene.load", "render.gltf")(wanted["scene"])
        self.ctx = ctx
        self.renderer = found("StereoRenderer", "render.pipeline")(self.ctx, SIZE_PX)
        self.renderer.begin(scene, _condition(effects=wanted["effects"]))
        self.headset = found("PlaybackHeadset", "headset.playback")(
            found("read_trace", "traces.trace", "headset.trace")(Path(wanted["trace"])),
            image_size_px=SIZE_PX,
            refresh_hz=REFRESH_HZ,
            spawn=scene.spawn,
        )
        recorder = found("Recorder", "records.recorder")(folder, "P1", 1)
        self.log = found("FrameLog", "session.frame_log")(recorder)
        self._frames: Iterator[Any] = iter(self.headset.frames())
        self.draws = 0

    def show(self) -> None:
        """Draw the next frame and record it."""
        frame = next(self._frames)
        rendered = self.renderer.render(frame, frame.predicted_display_time_ns / 1e9)
        self.headset.submit(frame, rendered.eyes)
        self.headset.take_events()
        self.log.add(frame, rendered, trial=1, session_s=frame.index / REFRESH_HZ)
        self.draws = rendered.draws


def _condition(*, effects: bool) -> Any:
    condition, depth_of_field, motion_blur = (
        found(name, "protocol.conditions") for name in ("Condition", "DepthOfField", "MotionBlur")
    )
    if not effects:
        return condition(name="plain")
    return condition(name="both", depth_of_field=depth_of_field(), motion_blur=motion_blur())


def recorder_clock() -> Any:
    """Return the clock of the thread that writes rows."""
    (writer,) = (each for each in threading.enumerate() if each.name == "recorder")
    clock = time.pthread_getcpuclockid(writer.ident)
    return lambda: time.clock_gettime(clock)


def timed(loop: Loop, clock: Clock, frames: int, recorder_s: Any) -> list[dict[str, float]]:
    """Return the times of the next frames."""
    laps = []
    for _ in range(frames):
        before_s = recorder_s()
        clock.lap()
        loop.show()
        lap = clock.lap()
        loop.ctx.finish()
        recorded_s = recorder_s() - before_s
        laps.append({"loop_s": lap.python_s, "opengl_s": lap.opengl_s, "recorder_s": recorded_s})
    return laps


def counted(loop: Loop, clock: Clock) -> dict[str, int]:
    """Count the calls of one frame: Python functions of any kind, and draws.

    The calls of OpenGL are not among them: a method of moderngl makes several, which no wrapper
    around it sees.
    """
    profile = cProfile.Profile()
    clock.counts.clear()
    loop.show()
    counts = clock.counts.copy()
    profile.runcall(loop.show)
    calls = pstats.Stats(profile).stats.items()  # type: ignore[attr-defined]
    rig = ("clocked.py", "thread_time")
    return {
        "calls": sum(
            count
            for (file, _, name), (_, count, *_) in calls
            if not file.endswith(rig) and not name.endswith(f"{rig[1]}>")
        ),
        "scene draws": loop.draws,
        "draws": sum(count for name, count in counts.items() if name in DRAWS),
    }


def main() -> None:
    """Serve."""
    wanted = json.loads(sys.argv[1])
    gl: Any = opengl()
    clock = Clock()
    uninterrupted = found("uninterrupted", "stop_signals")
    with tempfile.TemporaryDirectory() as folder, clocked_opengl(clock, gl), ExitStack() as owned:
        loop = Loop(gl.create_context(), wanted, Path(folder))
        recorder_s = recorder_clock()
        for _ in range(WARM_UP):
            loop.show()
        gc.collect()
        gc.freeze()  # as a session does while it shows frames
        owned.enter_context(uninterrupted())  # the same
        print(json.dumps(counted(loop, clock)), flush=True)
        for line in sys.stdin:
            print(json.dumps(timed(loop, clock, int(line), recorder_s)), flush=True)


if __name__ == "__main__":
    main()
