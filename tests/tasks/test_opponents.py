"""Opponents: they move, hide, shoot back and come again; skill decides who wins."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tasks.test_tasks import around, towards
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.protocol import Simulation
from vrcomfort.respondent.simulated_hands import SimulatedHands
from vrcomfort.settings import parse_settings
from vrcomfort.tasks import TaskFrame
from vrcomfort.tasks.opponents import Opponents

STEP_S = 0.02


def settings(**more):
    return Opponents(name="fight", kind="opponents", **more)


def fought(seed=0, seconds=120.0, aim_sd_deg=1.0, **more):
    """Let a simulated participant fight in frames."""
    task = settings(**more).start(around(seed))
    person = Simulation(aim_sd_deg=aim_sd_deg)
    hands, results = SimulatedHands(person, "", np.random.default_rng(seed)), []
    for time_s in np.arange(0.0, seconds, STEP_S).tolist():
        ray = hands.act(task.demand(), Pose(), time_s)
        results += task.step(TaskFrame(time_s, Pose(), pressed=() if ray is None else (ray,)))
    return [*results, *task.finish(seconds)]


def trial(results):
    return results[-1]


def test_who_aims_better_wins_more_often_and_hits_with_more_of_their_shots():
    good, bad = fought(aim_sd_deg=0.5), fought(aim_sd_deg=2.5)
    assert trial(good).hits > 2 * trial(bad).hits
    share = {
        id(each): np.mean([shot.hit for shot in each if shot.kind == "shot"])
        for each in (good, bad)
    }
    assert share[id(good)] > 2 * share[id(bad)]


def test_performance_does_not_saturate():
    done = [trial(fought(seed, 60.0, opponents=2)) for seed in range(6)]
    assert all(0 < each.hits < each.targets for each in done)
    assert len({each.hits for each in done}) > 2
    assert len({each.deaths for each in done}) > 1


def test_an_opponent_is_defeated_by_as_many_hits_as_it_lives():
    results = fought(aim_sd_deg=0.01, life_hits=3, hit_chance=0.0, sway_deg=0.0)
    shots = [each for each in results if each.kind == "shot"]
    assert {each.hit for each in shots} == {1}
    assert trial(results).hits == len(shots) // 3
    defeated = [each for each in results if each.kind == "target" and each.hit]
    assert len(defeated) == trial(results).hits == trial(results).score
    assert trial(results).deaths == 0


def test_who_does_nothing_is_shot_as_often_as_the_settings_say():
    task = settings(
        hit_chance=1.0, aims_s=1.0, shoots_every_s=0.5, own_life_hits=3, away_s=2.0,
        shown_s=(60.0, 60.0), hidden_s=(1.0, 1.0),
    ).start(around())  # fmt: skip
    for time_s in np.arange(0.0, 20.0, STEP_S).tolist():
        task.step(TaskFrame(time_s, Pose()))
    # It hits after 1, 1.5 and 2 s; 2 s later it is there again.
    assert trial(task.finish(20.0)).deaths == 5


def test_an_opponent_that_shoots_flashes():
    task = settings(aims_s=1.0, shoots_every_s=0.5, hit_chance=0.0).start(around())
    flashes = {}
    for time_s in (0.0, 0.5, 0.99, 1.01, 1.2, 1.51):
        task.step(TaskFrame(time_s, Pose()))
        flashes[time_s] = task.balls()[2]
    assert [time_s for time_s, flash in flashes.items() if flash] == [1.01, 1.51]


def test_nobody_is_seen_after_a_death_and_opponents_hide_and_sway():
    task = settings(
        hit_chance=1.0, own_life_hits=1, away_s=4.0, shown_s=(8.0, 8.0), hidden_s=(1.0, 1.0)
    ).start(around())
    seen = {}
    for time_s in np.arange(0.0, 12.0, STEP_S).tolist():
        task.step(TaskFrame(time_s, Pose()))
        seen[round(time_s, 2)] = next((ball for ball in task.balls()[:2] if ball), None)
    # It has won after a second, and is away for four.
    assert [seen[at] is not None for at in (0.5, 1.5, 4.5, 5.5, 6.5)] == [1, 0, 0, 1, 0]
    place = seen[0.2].position_m
    moved = seen[0.8].position_m - place
    assert np.linalg.norm(moved) > 0.01
    flat = place * (1, 0, 1)  # from a head at the origin
    across = abs(moved @ flat) / np.linalg.norm(moved) / np.linalg.norm(flat)
    assert across < np.sin(np.radians(settings().sway_deg))


def test_a_held_trigger_shoots_at_the_rate_of_the_weapon():
    task = settings(shot_every_s=0.25, hit_chance=0.0).start(around())
    aim = towards([0.0, 5.0, -1.0])
    results = []
    for time_s in np.arange(0.0, 10.0, STEP_S).tolist():
        results += task.step(TaskFrame(time_s, Pose(), held=(aim,)))
    shots = [each for each in results if each.kind == "shot"]
    assert 36 <= len(shots) <= 40
    assert {each.hit for each in shots} == {0}


def test_time_can_jump_from_one_event_to_the_next():
    """What happens does not hang on the frames between: the same targets at the same times."""
    more = {"hit_chance": 0.5, "opponents": 2, "own_life_hits": 4}
    stepped, jumped = (settings(**more).start(around(3)) for _ in range(2))
    slow, fast = [], []
    for time_s in np.arange(0.0, 60.0, 0.01).tolist():
        slow += stepped.step(TaskFrame(time_s, Pose()))
    time_s = 0.0
    while (time_s := jumped.next_s()) < 60.0:
        fast += jumped.step(TaskFrame(time_s, Pose()))
    assert len(slow) == len(fast) > 10
    for a, b in zip(slow, fast, strict=True):
        assert a.time_s == pytest.approx(b.time_s, abs=0.1)
    assert stepped.finish(60.0)[-1].deaths == jumped.finish(60.0)[-1].deaths > 0


def test_a_shorter_time_is_named_first():
    with pytest.raises(InputError, match="names the shorter time first"):
        parse_settings(Opponents, 'name = "a"\nkind = "opponents"\nshown_s = [3.0, 2.0]\n', None)
