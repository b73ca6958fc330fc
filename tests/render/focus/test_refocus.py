"""The laws by which focus follows its target: at any frame rate, with dropped frames."""

import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.oracles.refocus import TWINS, FocusState, advance
from vrcomfort.optics.refocus import LAWS, backward_euler_share, low_pass_share
from vrcomfort.protocol.conditions import Focus, RefocusLawName

EXACT = [name for name in LAWS if name != "low_pass_backward_euler"]
laws = st.sampled_from(list(LAWS))
distances = st.floats(0.05, 30_000.0)
times = st.floats(0.0, 1.0)


def test_every_law_of_a_protocol_is_there_and_has_a_twin():
    assert LAWS.keys() == TWINS.keys() == set(get_args(RefocusLawName))


def test_a_law_takes_settings_that_there_are_and_what_it_does_not_take_changes_nothing():
    other = {"refocus_s": 0.7, "cutoff_hz": 3.0, "duration_s": 0.9, "refixation_dioptre": 0.4}
    other["infinity_m"] = 900.0
    assert set().union(*(law.settings for law in LAWS.values())) == other.keys()
    for name, law in LAWS.items():
        state = FocusState(2.0, 2.0)
        for key, value in other.items():
            usual, changed = Focus(law=name), Focus(law=name, **{key: value})
            # 0.3 dioptres away, and so soon that even 60 km/s is on its way
            steps = [advance(state, 1 / 0.8, 5e-6, each) for each in (usual, changed)]
            assert (steps[0] != steps[1]) == (key in law.settings), (name, key)


def refocus(start_m, target_m, dt_s, settings):
    return advance(FocusState(start_m), target_m, dt_s, settings).focus_m


def moved(start_m, target_m, steps_s, settings):
    """The state after some steps towards one target, from rest."""
    state = FocusState(start_m, start_m, 0.0)
    for step_s in steps_s:
        state = advance(state, target_m, step_s, settings)
    return state


@given(distances, distances, st.lists(times, min_size=1, max_size=6), st.sampled_from(EXACT))
def test_many_steps_are_one_step_of_their_summed_time(start, target, steps, law):
    settings = Focus(law=law)
    in_steps = moved(start, target, steps, settings)
    at_once = moved(start, target, [sum(steps)], settings)
    assert 1 / in_steps.focus_m == pytest.approx(1 / at_once.focus_m, rel=1e-6, abs=1e-9)


@given(distances, distances, st.lists(times, min_size=1, max_size=6), laws)
def test_refocusing_never_passes_its_target_nor_turns_away(start, target, steps, law):
    settings = Focus(law=law)
    tolerance = 1e-12 * max(start, target)
    state = FocusState(start, start, 0.0)
    for step in steps:
        before, state = state, advance(state, target, step, settings)
        low, high = sorted([before.focus_m, target])
        assert low - tolerance <= state.focus_m <= high + tolerance


@given(distances, distances, laws)
def test_focus_arrives_and_stays(start, target, law):
    settings = Focus(law=law)
    assert moved(target, target, [0.01], settings).focus_m == pytest.approx(target, rel=1e-12)
    # A filter has 1e-10 of the way left after 23 time constants, the discrete one after 4 steps.
    steps = [1e3] * 5 if law == "low_pass_backward_euler" else [1e3]
    arrived = moved(start, target, steps, settings)
    assert arrived.focus_m == pytest.approx(target, rel=1e-9)


@given(distances, distances, laws, st.sampled_from([0.0, 1e-9, 1e6]))
def test_no_time_and_all_time_are_numbers(start, target, law, dt_s):
    state = advance(FocusState(start), target, dt_s, Focus(law=law))
    assert math.isfinite(state.focus_m)
    assert state.left_s >= 0


@pytest.mark.slow
@given(distances, distances, st.sampled_from([law for law in LAWS if law != "instant"]))
def test_no_time_means_no_change(start, target, law):
    assume(abs(1 / start - 1 / target) > 0.1)  # closer targets are one for `duration`
    assert moved(start, target, [0.0], Focus(law=law)).focus_m == pytest.approx(start, rel=1e-12)


def after(law, time_s):
    """Focus some time after the target jumped from 4 m to 0.5 m (0.25 to 2 dioptres), by hand."""
    if law == "linear":
        return max(4.0 - 60_000 * time_s, 0.5)
    if law == "linear_dioptre":
        return 1 / min(0.25 + 2 * time_s, 2.0)
    if law == "duration":
        return 1 / min(0.25 + 1.75 * time_s / 0.37, 2.0)
    if law == "low_pass":
        return 0.5 + 3.5 * math.exp(-time_s * 2 * math.pi * 5)
    return 0.5


@pytest.mark.parametrize("law", EXACT)
@pytest.mark.parametrize(("rate_hz", "dropped"), [(30, 0.0), (72, 0.3), (120, 0.3)])
def test_no_frame_rate_and_no_dropped_frame_changes_the_course(law, rate_hz, dropped):
    random = np.random.default_rng(rate_hz)
    shown = np.flatnonzero(random.random(rate_hz) >= dropped)
    shown = shown[shown > 0]
    settings = Focus(law=law)
    state, last = FocusState(4.0, 4.0, 0.0), 0
    for frame in shown:
        state = advance(state, 0.5, (frame - last) / rate_hz, settings)
        last = frame
        assert state.focus_m == pytest.approx(after(law, frame / rate_hz), rel=1e-9)
    assert state.focus_m == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("rate_hz", [30, 120])
def test_the_discrete_filter_depends_on_the_rate_and_gets_there(rate_hz):
    settings = Focus(law="low_pass_backward_euler")
    steps = [1 / rate_hz] * (rate_hz // 5)
    focus_m = moved(4.0, 0.5, steps, settings).focus_m
    exact_m = after("low_pass", len(steps) / rate_hz)
    assert focus_m > exact_m * (1 + 1e-4)  # behind the filter that it stands for
    assert moved(4.0, 0.5, steps * 5, settings).focus_m == pytest.approx(0.5, rel=1e-3)


def test_the_low_pass_has_its_cutoff_where_it_says():
    """A sine of 5 Hz comes out 3 dB down and 45° late, whatever the steps."""
    rate_hz, share = 4000, low_pass_share(1 / 4000, 5.0)
    time_s = np.arange(4 * rate_hz) / rate_hz
    wave, level = np.sin(2 * np.pi * 5 * time_s), 0.0
    out = np.empty_like(wave)
    for index, value in enumerate(wave):
        level = level + (value - level) * share
        out[index] = level
    settled = slice(2 * rate_hz, None)
    gain = 2 * np.mean(out[settled] * np.exp(-2j * np.pi * 5 * time_s[settled]))
    assert abs(gain) == pytest.approx(1 / math.sqrt(2), rel=2e-3)
    assert np.degrees(np.angle(gain)) + 90 == pytest.approx(-45.0, abs=0.5)


def test_the_papers_filter_has_its_cutoff_lower():
    """Backward Euler at the paper's 70 Hz: 3 dB down at 4.2 Hz (|H| of the recursion)."""
    share = backward_euler_share(1 / 70, 5.0)
    gain = share / abs(1 - (1 - share) * np.exp(-2j * np.pi * 4.2 / 70))
    assert gain == pytest.approx(1 / math.sqrt(2), abs=0.01)
    assert share == pytest.approx(1 / (1 + 70 / (2 * math.pi * 5)))


def test_the_papers_law_takes_half_a_second_from_the_sky():
    settings = Focus()
    assert refocus(30_000.0, 1.0, 0.25, settings) == pytest.approx(15_000.0)
    assert refocus(30_000.0, 1.0, 0.5, settings) == 1.0
    # 10 m to 1 m at 60 km/s is done in 0.15 ms.
    assert refocus(10.0, 1.0, 0.149e-3, settings) > 1.0
    assert refocus(10.0, 1.0, 0.151e-3, settings) == 1.0


def test_the_dioptre_law_takes_half_a_second_from_the_sky_to_one_metre():
    settings = Focus(law="linear_dioptre")
    assert refocus(30_000.0, 0.1, 0.5, settings) == pytest.approx(1.0, rel=1e-4)
    assert refocus(1.0, 0.1, 0.5, settings) == pytest.approx(0.5)


DURATION = Focus(law="duration", duration_s=0.4, refixation_dioptre=0.1)


@pytest.mark.slow
@given(distances, distances)
def test_every_change_takes_its_time(start, target):
    assume(abs(1 / start - 1 / target) > 0.11)
    half = moved(start, target, [0.2], DURATION)
    assert 1 / half.focus_m == pytest.approx((1 / start + 1 / target) / 2)
    assert half.left_s == pytest.approx(0.2)
    assert moved(start, target, [0.2, 0.2], DURATION).focus_m == pytest.approx(target)


def test_a_new_target_on_the_way_begins_a_new_change_from_there():
    state = advance(FocusState(1.0, 1.0), 0.5, 0.2, DURATION)  # 1 D to 2 D: half way
    assert 1 / state.focus_m == pytest.approx(1.5)
    state = advance(state, 0.25, 0.1, DURATION)  # now to 4 D: a quarter of 2.5 D
    assert 1 / state.focus_m == pytest.approx(1.5 + 2.5 / 4)
    assert state == (state.focus_m, 0.25, pytest.approx(0.3))


def test_a_target_that_trembles_on_the_way_does_not_hold_the_change_up():
    state = FocusState(1.0, 1.0)
    for step in range(40):
        state = advance(state, 1 / (2.0 + 0.04 * (-1) ** step), 0.01, DURATION)
    assert state.left_s == pytest.approx(0.0, abs=1e-12)
    assert 1 / state.focus_m == pytest.approx(1.96)


def test_a_target_that_drifts_is_followed_and_in_time_looked_at_anew():
    """Away at 0.2 D/s: focus stays on it for half a second, then a new change begins."""
    state = FocusState(1.0, 1.0)
    for step in range(1, 50):
        target = 1 / (1 + 0.002 * step)
        state = advance(state, target, 0.01, DURATION)
        assert state.focus_m == target
    for step in range(50, 52):
        state = advance(state, 1 / (1 + 0.002 * step), 0.01, DURATION)
    assert state.left_s > 0.3
    assert 1 / state.focus_m == pytest.approx(1.1, abs=0.005)
