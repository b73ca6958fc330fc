"""Cost of finding the gaze hit in each frame: drawn, and beside drawing."""

from __future__ import annotations

import time
from itertools import islice
from typing import Any

import moderngl
import numpy as np

from bench.table import Result
from vrcomfort.frame import Frame
from vrcomfort.geometry import Gaze, Pose, yaw_pitch_roll
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition
from vrcomfort.render.focus.rays import GazeHits
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.scene.ray_cast import RayCaster
from vrcomfort.traces.trace import read_trace
from vrcomfort.tradeoff.walk import SCENES

SIZE_PX = 640, 800
SPREAD_DEG = 10.0


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Time a plain stereo frame, a look along the gaze, and a ray on the CPU in turn."""
    rows = [_row(ctx, name, rounds) for name in SCENES]
    notes = [
        f"Medians of {rounds} frames of the walk, {SIZE_PX[0]}×{SIZE_PX[1]} pixels per eye; "
        "processor time of the whole process. `look` is a texel drawn along the gaze and read four "
        "frames later, to the end of its drawing; `call` is what the frame's thread spends of it "
        "(on a rasteriser its vertices, too); `ray` is the same by a ray cast on the CPU.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("What the gaze meets", rows, notes)


def _row(ctx: moderngl.Context, name: str, rounds: int) -> dict[str, Any]:
    scene = load_scene(name)
    renderer, caster = StereoRenderer(ctx, SIZE_PX), RayCaster(scene)
    renderer.begin(scene, Condition(name="plain"))
    hits = GazeHits(ctx, renderer.scene_pass.gpu, near_m=0.02, along_ray=False)
    trace = read_trace(data_folder("scenes") / f"{name}_walk.csv")
    headset = PlaybackHeadset(trace, image_size_px=SIZE_PX, refresh_hz=90, spawn=scene.spawn)
    times = []
    random = np.random.default_rng(1)
    for frame in islice(headset.frames(), rounds):
        side, up = np.radians(SPREAD_DEG) * random.standard_normal(2)
        gaze = Gaze(Pose(orientation=yaw_pitch_roll(side, up, 0.0)))
        times.append(_times(ctx, renderer, hits, caster, frame, gaze))
    frame_ms, call_ms, look_ms, ray_ms = np.median(1e3 * np.array(times), axis=0).tolist()
    return {
        "scene": name,
        "frame ms": frame_ms,
        "look ms": look_ms,
        "call ms": call_ms,
        "ray ms": ray_ms,
        "look / frame %": 100 * look_ms / frame_ms,
    }


def _times(
    ctx: moderngl.Context,
    renderer: StereoRenderer,
    hits: GazeHits,
    caster: RayCaster,
    frame: Frame,
    gaze: Gaze,
) -> tuple[float, float, float, float]:
    """Return seconds of a frame, of the call that looks, of all of the look, and of a ray."""
    start_s = time.process_time()
    renderer.render(frame, frame.index / 90)
    ctx.finish()
    drawn_s = time.process_time()
    head = frame.avatar_pose @ frame.head_pose
    thread_s = time.thread_time()
    hits.look(frame.index, gaze, head)
    called_s = time.thread_time() - thread_s
    ctx.finish()
    looked_s = time.process_time()
    caster.cast(head @ gaze.pose, frame.index / 90)
    return drawn_s - start_s, called_s, looked_s - drawn_s, time.process_time() - looked_s
