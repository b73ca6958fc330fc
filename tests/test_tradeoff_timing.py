"""What is clocked, and what counts as an effect's cost."""

import time

import pytest

from vrcomfort.gpu import timer as gpu_timer
from vrcomfort.gpu.timer import Stopwatch
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.tradeoff import timing
from vrcomfort.tradeoff.cases import Case, Scope, frames
from vrcomfort.tradeoff.methods import base_condition
from vrcomfort.tradeoff.shots import context
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.timing import clocked_passes, effect_s, rounds_of, time_case, told


def test_each_pass_is_clocked_once_for_each_eye_and_methods_are_put_back():
    case, scope = Case("temple", 0, "still", "depth_of_field"), Scope(size_px=(16, 20), poses=1)
    scene, _ = scene_and_hash(case.scene)
    ctx = context()
    renderer, method = StereoRenderer(ctx, scope.size_px), ScenePass.render
    renderer.begin(scene, base_condition(case.effect))
    with clocked_passes(Stopwatch(ctx)) as laps:
        renderer.render(frames(case, scope)[1], 0.0)
    timed = told(laps)
    assert {name: calls for name, (_, calls) in timed.items()} == {
        "scene": 2,
        "depth_of_field": 2,
        "tone_map": 2,
    }
    assert all(seconds > 0 for seconds, _ in timed.values())
    assert ScenePass.render is method


def test_the_first_drawing_of_the_scene_is_no_effect():
    assert effect_s({"scene": (8.0, 2), "tone_map": (1.0, 2)}) == 0
    assert effect_s({"scene": (8.0, 2), "depth_of_field": (3.0, 2)}) == pytest.approx(3)
    assert effect_s({"scene": (8.0, 8), "depth_of_field": (3.0, 8)}) == pytest.approx(9)


def test_time_stamps_work_inside_a_frame_that_is_timed_and_leave_nothing(ctx, monkeypatch):
    """On a software rasteriser they say little, but they are there."""
    monkeypatch.setattr(gpu_timer, "SOFTWARE", ())
    target = ctx.simple_framebuffer((4, 4))
    timer, watch = gpu_timer.GpuTimer(ctx), Stopwatch(ctx)
    assert watch.on_gpu
    with timer.frame(0):
        seconds = watch.seconds(lambda: target.clear(1.0))
    assert 0 <= seconds < 10
    assert timer.drain()[0].gpu_ms >= 0


def test_a_software_rasteriser_is_timed_by_the_wall(ctx, monkeypatch):
    monkeypatch.setattr(gpu_timer, "SOFTWARE", (str(ctx.info["GL_RENDERER"]).lower(),))
    watch = Stopwatch(ctx)
    assert not watch.on_gpu
    assert watch.seconds(lambda: time.sleep(0.02)) >= 0.02


def test_time_stamps_are_read_when_they_are_asked_for_and_used_again(ctx, monkeypatch):
    monkeypatch.setattr(gpu_timer, "SOFTWARE", ())
    target = ctx.simple_framebuffer((4, 4))
    watch = Stopwatch(ctx)
    laps = [watch.lap(lambda: target.clear(1.0)) for _ in range(5)]
    assert all(0 <= lap() < 10 for lap in reversed(laps))
    pairs = set(watch._free)
    assert len(pairs) == 5
    watch.seconds(target.clear)
    assert set(watch._free) == pairs
    with pytest.raises(ZeroDivisionError):
        watch.lap(lambda: 1 / 0)


def test_a_gpu_is_given_more_frames_than_a_software_rasteriser(ctx, monkeypatch):
    assert rounds_of(Scope(rounds=5), ctx) == 5
    assert (rounds_of(Scope(), ctx), rounds_of(Scope(quick=True), ctx)) == (20, 3)
    monkeypatch.setattr(gpu_timer, "SOFTWARE", ())
    assert rounds_of(Scope(quick=True), ctx) >= 300


@pytest.mark.parametrize("on_gpu", [False, True])
def test_percentiles_are_told_where_there_are_frames_enough_for_them(monkeypatch, on_gpu):
    if on_gpu:
        monkeypatch.setattr(gpu_timer, "SOFTWARE", ())
    monkeypatch.setattr(timing, "P95_ROUNDS", 2)
    monkeypatch.setattr(timing, "P99_ROUNDS", 3)
    few = Scope(size_px=(16, 20), poses=1, rounds=2, methods=("ours 2 samples",))
    rounds = []
    found = time_case(Case("temple", 0, "walk", "motion_blur"), few, lambda: rounds.append(1))
    (timed,) = [each for each in found.methods if each.method == "ours 2 samples"]
    assert (len(rounds), timed.rounds) == (3, 2)
    assert timed.effect_p95_ms >= timed.effect_ms >= 0
    assert timed.effect_p99_ms is None
    assert set(timed.passes_ms) == {"scene", "motion_blur", "tone_map"}


def test_what_takes_long_is_timed_once(monkeypatch):
    monkeypatch.setattr(timing, "SLOW_S", 0.0)
    scope = Scope(size_px=(16, 20), poses=1, rounds=2, methods=("ours 2 samples",))
    found = time_case(Case("temple", 0, "walk", "motion_blur"), scope, lambda: None)
    assert {each.rounds for each in found.methods} == {1}
