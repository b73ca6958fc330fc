"""What is clocked, and what counts as an effect's cost."""

import time
from dataclasses import replace

import numpy as np
import pytest

from tests.support.waiting import WAIT_S
from vrcomfort.gpu import adapters
from vrcomfort.gpu import timer as gpu_timer
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.timer import Stopwatch
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff import costs
from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.cases import Case, Scope, frames
from vrcomfort.tradeoff.costs import PartClock, a_step, effect_s, rounds_of, time_case, told
from vrcomfort.tradeoff.methods import base_condition
from vrcomfort.tradeoff.store import scene_and_hash


@pytest.mark.slow
def test_parts_of_each_eye_and_of_both_are_clocked_and_no_longer_than_asked():
    case, scope = Case("temple", 0, "still", "depth_of_field"), Scope(size_px=(16, 20), poses=1)
    scene, _ = scene_and_hash(case.scene)
    ctx = context()
    renderer = StereoRenderer(ctx, scope.size_px)
    renderer.build(scene, base_condition(case.effect))
    clock = PartClock(Stopwatch(ctx))
    with watched(clock):
        renderer.render(frames(case, scope)[1], 0.0)
    renderer.render(frames(case, scope)[1], 0.0)
    timed = told(clock.laps)
    calls = {name: calls for name, (_, calls) in timed.items()}
    once = dict.fromkeys(("focus", "shadow", "depth_of_field", "tone_map"), 1)
    assert calls == {**once, "scene": 2, "resolve": 2}
    assert all(timed[name][0] > 0 for name in ("scene", "depth_of_field", "tone_map"))


def test_what_a_plain_frame_has_too_is_no_effect():
    plain = {"scene": (8.0, 2), "tone_map": (1.0, 2)}
    assert effect_s(plain) == 0
    assert effect_s({**plain, "focus": (2.0, 1), "depth_of_field": (3.0, 2)}) == pytest.approx(3)
    assert effect_s({**plain, "lens_views": (20.0, 2)}) == pytest.approx(20)
    assert effect_s({**plain, "resolve": (3.0, 2)}, 2.0) == pytest.approx(1)


def test_time_stamps_work_inside_a_frame_that_is_timed_and_leave_nothing(ctx, monkeypatch):
    """On a software rasteriser they say little, but they are there."""
    monkeypatch.setattr(adapters, "SOFTWARE", ())
    target = ctx.simple_framebuffer((4, 4))
    timer, watch = gpu_timer.GpuTimer(ctx), Stopwatch(ctx)
    assert watch.on_gpu
    with timer.frame(0):
        seconds = watch.seconds(lambda: target.clear(1.0))
    assert 0 <= seconds < WAIT_S
    assert timer.drain()[0].gpu_ms >= 0


def test_on_a_software_rasteriser_the_processors_time_counts(ctx, monkeypatch):
    monkeypatch.setattr(adapters, "SOFTWARE", (str(ctx.info["GL_RENDERER"]).lower(),))
    watch = Stopwatch(ctx)
    assert not watch.on_gpu
    assert watch.seconds(lambda: time.sleep(0.2)) < 0.1

    def work():
        end = time.process_time() + 0.05
        while time.process_time() < end:
            pass

    assert watch.seconds(work) >= 0.05


def test_time_stamps_are_read_when_they_are_asked_for_and_used_again(ctx, monkeypatch):
    monkeypatch.setattr(adapters, "SOFTWARE", ())
    target = ctx.simple_framebuffer((4, 4))
    watch = Stopwatch(ctx)
    laps = []
    for _ in range(5):
        with watch.lap() as lap:
            target.clear(1.0)
        laps.append(lap)
    assert all(0 <= lap() < WAIT_S for lap in reversed(laps))
    pairs = set(watch._free)
    assert len(pairs) == 5
    watch.seconds(target.clear)
    assert set(watch._free) == pairs


def test_a_gpu_is_given_more_frames_than_a_software_rasteriser(ctx, monkeypatch):
    assert rounds_of(Scope(rounds=5), ctx) == 5
    assert (rounds_of(Scope(), ctx), rounds_of(Scope(quick=True), ctx)) == (9, 3)
    monkeypatch.setattr(adapters, "SOFTWARE", ())
    assert rounds_of(Scope(quick=True), ctx) >= 300


def test_percentiles_are_those_that_they_are_called():
    """Of frames whose effect takes 1, 2, … ms."""
    timed = [{"scene": (1.0, 2), "motion_blur": (each * 1e-3, 2)} for each in range(1, 1001)]
    found = costs._summary("ours", timed, np.ones(1000), np.zeros(1000))
    assert found.effect_ms == pytest.approx(500.5)
    assert found.effect_p95_ms == pytest.approx(950)
    assert found.effect_p99_ms == pytest.approx(990)


@pytest.mark.parametrize("on_gpu", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_percentiles_are_told_where_there_are_frames_enough_for_them(monkeypatch, on_gpu):
    if on_gpu:
        monkeypatch.setattr(adapters, "SOFTWARE", ())
    monkeypatch.setattr(costs, "P95_ROUNDS", 2)
    monkeypatch.setattr(costs, "P99_ROUNDS", 3)
    few = Scope(size_px=(16, 20), poses=1, rounds=2, methods=("ours 8 samples",))
    timed_methods = []
    case = Case("temple", 0, "walk", "motion_blur")
    found = time_case(case, few, lambda: timed_methods.append(1))
    (timed,) = [each for each in found.methods if each.method == "ours 8 samples"]
    assert (len(timed_methods), timed.rounds) == (2, 2)
    assert timed.effect_p95_ms >= timed.effect_ms >= 0
    assert timed.effect_p99_ms is None
    parts = {"shadow", "scene", "resolve", "motion_blur", "tone_map"}
    assert set(timed.parts_ms) == parts
    assert timed.cost >= 1
    assert found.plain_ms > 0


@pytest.mark.slow
def test_what_takes_long_is_timed_once(monkeypatch):
    monkeypatch.setattr(costs, "SLOW_S", 0.0)
    scope = Scope(size_px=(16, 20), poses=1, rounds=2, methods=("ours 8 samples",))
    found = time_case(Case("temple", 0, "walk", "motion_blur"), scope, lambda: None)
    assert {each.rounds for each in found.methods} == {1}


def test_a_window_costs_what_the_whole_image_costs():
    scope = Scope(size_px=(16, 20), poses=1, rounds=1, methods=("no blur",), eyes=1)
    windowed = Case("temple", 0, "still", "depth_of_field", window="far_edges")
    found = time_case(windowed, scope, lambda: None)
    assert found.case.window is None
    assert [each.cost for each in found.methods] == [1.0]


@pytest.mark.parametrize("on_gpu", [False, True])
def test_parts_of_every_third_frame_are_timed_and_told_late(ctx, monkeypatch, on_gpu):
    if on_gpu:
        monkeypatch.setattr(adapters, "SOFTWARE", ())
    renderer = StereoRenderer(ctx, (16, 20), time_parts_every=3)
    scene, _ = scene_and_hash("depths")
    renderer.begin(scene, base_condition("motion_blur"))
    step = a_step(scene.spawn, (16, 20))[1]
    told, timed = [], []
    for index in range(9):
        rendered = renderer.render(replace(step, index=index), 0.0)
        timed += [index] if rendered.times_parts else []
        told += rendered.part_times
        assert all(each.frame_index <= index - gpu_timer.LATENCY for each in rendered.part_times)
    told += renderer.drain_part_times()
    renderer.release()
    assert timed == [0, 3, 6]
    parts = ["shadow", "scene", "resolve", "motion_blur", "tone_map"]
    assert [(each.frame_index, each.part) for each in told] == [
        (index, part) for index in timed for part in parts
    ]
    assert all(each.cpu_ms > 0 for each in told)
    assert {each.gpu_ms is None for each in told} == {not on_gpu}


def test_what_a_frame_hands_on_is_no_time_of_it(ctx, monkeypatch):
    monkeypatch.setattr(adapters, "SOFTWARE", ())
    renderer = StereoRenderer(ctx, (16, 20))
    scene, _ = scene_and_hash("depths")
    renderer.begin(scene, base_condition("motion_blur"))
    step = a_step(scene.spawn, (16, 20))[1]
    free = renderer.render(step, 0.0).cpu_ms
    wait_ms = max(200.0, 2 * free)
    held = renderer.render(step, 0.0, lambda *_: time.sleep(wait_ms / 1e3)).cpu_ms
    assert held < free + wait_ms
    assert [each.gpu_ms < 2 * wait_ms for each in renderer.drain_times()] == [True, True]
    renderer.release()
