"""Cost of the operator's mirror beside the frames it shows; needs a display (or xvfb-run)."""

from __future__ import annotations

import time
from itertools import islice
from pathlib import Path

import moderngl
import numpy as np

from bench.table import Result, write
from vrcomfort.frame import Frame
from vrcomfort.gpu.gl import prepare
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.headset.window import USUAL_HZ, Mirror, Window
from vrcomfort.protocol import Condition, DepthOfField, MotionBlur
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace

SIZE_PX = 320, 400
WINDOW_PX = 480, 600
REFRESH_HZ = 90
BOTH = Condition(name="both", depth_of_field=DepthOfField(), motion_blur=MotionBlur())


def measure(*, rounds: int) -> Result:
    """Time a stereo frame, mirroring it, and leaving it out, each to the end of its drawing."""
    with Window("bench", WINDOW_PX, wait_for_display=False) as window:
        ctx = prepare(window.context())
        now_s = [0.0]
        mirror = Mirror(ctx, window, now_s=lambda: now_s[0])
        drawn, shown, skipped = _time(ctx, mirror, now_s, rounds)
        renderer_name = ctx.info["GL_RENDERER"]
        ctx.release()
    share = USUAL_HZ / REFRESH_HZ * shown + (1 - USUAL_HZ / REFRESH_HZ) * skipped
    rows = [
        {"what": "stereo frame, both effects", "ms": drawn, "of the frame %": 100.0},
        {"what": "frame that is mirrored", "ms": shown, "of the frame %": 100 * shown / drawn},
        {"what": "frame that is left out", "ms": skipped, "of the frame %": 100 * skipped / drawn},
        {"what": "mean at 90 Hz", "ms": share, "of the frame %": 100 * share / drawn},
    ]
    notes = [
        f"Medians of {rounds}; temple, {SIZE_PX[0]}×{SIZE_PX[1]} pixels per eye, mirrored into "
        f"{WINDOW_PX[0]}×{WINDOW_PX[1]} at {USUAL_HZ:g} Hz at most.",
        f"Renderer: {renderer_name}.",
    ]
    return Result("Mirror", rows, notes)


def _time(
    ctx: moderngl.Context, mirror: Mirror, now_s: list[float], rounds: int
) -> tuple[float, float, float]:
    """Return the median milliseconds of drawing, mirroring and leaving out."""
    scene = load_scene("temple")
    renderer = StereoRenderer(ctx, SIZE_PX)
    renderer.begin(scene, BOTH)
    trace = read_trace(data_folder("scenes") / "temple_walk.csv")
    headset = PlaybackHeadset(
        trace, image_size_px=SIZE_PX, refresh_hz=REFRESH_HZ, spawn=scene.spawn
    )
    times: list[tuple[float, float, float]] = []
    for frame in islice(headset.frames(), rounds):
        start_s = time.perf_counter()
        eyes = renderer.render(frame, frame.index / REFRESH_HZ).eyes
        ctx.finish()
        drawn = time.perf_counter() - start_s
        now_s[0] += 1.0
        times.append((drawn, *(_shown_s(ctx, mirror, frame, eyes) for _ in range(2))))
    renderer.release()
    drawn, shown, skipped = np.median(1e3 * np.array(times), axis=0).tolist()
    return drawn, shown, skipped


def _shown_s(
    ctx: moderngl.Context, mirror: Mirror, frame: Frame, eyes: tuple[moderngl.Texture, ...]
) -> float:
    start_s = time.perf_counter()
    mirror.show(frame, (eyes[0], eyes[1]), [])
    ctx.finish()
    return time.perf_counter() - start_s


if __name__ == "__main__":
    write(Path("out/bench"), "mirror", measure(rounds=40))
