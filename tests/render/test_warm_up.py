"""Nothing is compiled late, and nothing of the warming up is left."""

from __future__ import annotations

import numpy as np

from tests.render.test_pipeline import BOTH, SIZE, standing
from tests.support.render import still_life
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.gpu.timer import GpuTimer, make_gpu_timer
from vrcomfort.render import pipeline
from vrcomfort.render.output import read_rgb8, read_texture
from vrcomfort.render.pipeline import StereoRenderer


def images(ctx, frames):
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(still_life(), BOTH)
    samples, pictures = [], []
    for frame in frames:
        rendered = renderer.render(frame, frame.index / 90)
        samples += rendered.focus_samples
        pictures += [read_rgb8(eye) for eye in rendered.eyes]
    return pictures, [*samples, *renderer.drain()]


def test_what_is_drawn_after_warming_up_does_not_know_of_it(ctx, monkeypatch):
    frames = [standing(index, 0.1 * index) for index in range(3)]  # no cut, not even at first
    warm, samples = images(ctx, frames)
    monkeypatch.setattr(pipeline, "looks_around", lambda _: ())
    cold, expected = images(ctx, frames)
    assert all(np.array_equal(one, two) for one, two in zip(warm, cold, strict=True))
    assert [(s.frame_index, s.focus_m) for s in samples] == [
        (s.frame_index, s.focus_m) for s in expected
    ]


def test_everything_is_drawn_before_the_first_frame(ctx):
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(still_life(), BOTH)
    assert renderer.scene_pass.gpu.draws > 0
    assert read_texture(renderer.scene_pass.colour).max() > 0


def test_gpu_times_arrive_late_and_in_order(ctx):
    timer = GpuTimer(ctx)
    found = []
    target = ctx.simple_framebuffer((4, 4))
    for index in range(10):
        with timer.frame(index):
            target.clear()
        found += timer.arrived()
    assert len(found) == 10 - LATENCY
    found += timer.drain()
    assert [time.frame_index for time in found] == list(range(10))
    assert all(time.gpu_ms >= 0 for time in found)
    assert timer.drain() == ()


def test_software_rasterisers_are_not_timed(ctx):
    assert make_gpu_timer(ctx) is None
    renderer = StereoRenderer(ctx, SIZE)
    renderer.begin(still_life(), BOTH)
    assert renderer.render(standing(0), 0.0).gpu_times is None
    assert renderer.drain_times() == ()
