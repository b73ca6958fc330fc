"""Cost of hashing a frame's images beside drawing it, in processor time on a rasteriser."""

from __future__ import annotations

import time
from itertools import islice

import moderngl
import numpy as np

from bench.table import Result
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition, DepthOfField
from vrcomfort.render.display import HASH_EVERY, ImageHasher
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace

SIZE_PX = 640, 800
BLUR = Condition(name="blur", depth_of_field=DepthOfField())


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Time a stereo frame and the hashing of its images in turn, each to the end of its drawing."""
    scene = load_scene("temple")
    renderer, hasher = StereoRenderer(ctx, SIZE_PX), ImageHasher(ctx)
    renderer.begin(scene, BLUR)
    trace = read_trace(data_folder("scenes") / "temple_walk.csv")
    headset = PlaybackHeadset(trace, image_size_px=SIZE_PX, refresh_hz=90, spawn=scene.spawn)
    times = []
    for frame in islice(headset.frames(), rounds):
        start_s = time.process_time()
        eyes = renderer.render(frame, frame.index / 90).eyes
        ctx.finish()
        drawn_s = time.process_time()
        hasher.take(frame.index, eyes)
        hasher.arrived()
        ctx.finish()
        times.append((drawn_s - start_s, time.process_time() - drawn_s))
    drawn_ms, hashed_ms = np.median(1e3 * np.array(times), axis=0).tolist()
    measured = {
        "stereo frame, depth of field": drawn_ms,
        "hashing both images": hashed_ms,
        f"the same, of every {HASH_EVERY}th frame": hashed_ms / HASH_EVERY,
    }
    rows = [
        {"what": what, "ms": ms, "of the frame %": 100 * ms / drawn_ms}
        for what, ms in measured.items()
    ]
    notes = [
        f"Medians of {rounds}; temple, {SIZE_PX[0]}×{SIZE_PX[1]} pixels per eye; processor time of "
        "all threads, which on a software rasteriser is that of drawing.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Hashing images", rows, notes)
