"""How much of a trial was seen: live, frozen, hidden, unfocused; and what fell due meanwhile."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.resume import attempts, go, rows
from tests.support.study import AheadHeadset, frame
from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.timing import RefreshPeriod
from vrcomfort.protocol import Ratings
from vrcomfort.questionnaire import find_instrument
from vrcomfort.seen_time import UNSEEN, SeenState, SeenTime, ShownFrame, unseen_rows
from vrcomfort.session.frame_log import FrameLog, missed_refreshes
from vrcomfort.session.interfaces import NoOutlet
from vrcomfort.session.ratings import RatingSchedule, RatingSchedules

PERIOD_NS = 100_000_000


def account(frames, elapsed_s: float | None = None) -> dict[str, float]:
    """Return the seconds of the states that there were."""
    shown = [ShownFrame.of(each) for each in frames]
    last, first = shown[-1], shown[0]
    whole_s = (last.time_ns + last.period_ns - first.time_ns) / 1e9
    seen = SeenTime.of(shown, whole_s if elapsed_s is None else elapsed_s)
    return {state.value: s for state in SeenState if (s := seen.seconds(state))}


def at(periods: float, **changes):
    time_ns = round(periods * PERIOD_NS)
    return replace(frame(round(periods)), predicted_display_time_ns=time_ns, **changes)


def test_a_freeze_is_time_beyond_a_frames_own_period():
    assert account([at(0), at(1), at(51), at(52)]) == pytest.approx({"live": 0.4, "frozen": 4.9})


def test_late_frames_that_are_no_freeze_are_half_rate_or_less():
    late = [at(0), at(2), at(4), at(9), at(10)]
    assert account(late) == pytest.approx({"half_rate": 0.9, "live": 0.2})
    assert account([at(0), at(1), at(7), at(8)]) == pytest.approx({"live": 0.3, "half_rate": 0.6})


def test_of_the_states_that_hold_the_first_counts():
    changes = {"session_state": "visible"}
    assert account([at(0, **changes), at(1)]) == {"unfocused": 0.1, "live": 0.1}
    changes["head_tracked"] = False
    assert account([at(0, **changes), at(1)]) == {"untracked": 0.1, "live": 0.1}
    assert account([at(0, **changes), at(2)]) == {"half_rate": 0.2, "live": 0.1}
    assert account([at(0, **changes), at(8)]) == {"untracked": 0.1, "frozen": 0.7, "live": 0.1}
    changes["should_render"] = False
    assert account([at(0, **changes), at(8)]) == {"not_drawn": 0.8, "live": 0.1}
    changes["paused"] = True
    assert account([at(0, **changes), at(8)]) == {"hidden": 0.8, "live": 0.1}
    changes["user_present"] = False
    assert account([at(0, **changes), at(8)]) == {"off": 0.8, "live": 0.1}


def test_rows_in_which_nothing_is_seen_are_those_of_the_states():
    names = ("user_present", "paused", "should_render")
    told = list(product((0.0, 1.0, math.nan), repeat=3))
    columns = dict(zip(names, np.transpose(told), strict=True))
    cells = [[None if math.isnan(cell) else cell for cell in row] for row in told]
    rows = [dict(zip(names, row, strict=True)) for row in cells]
    rest = {"xr_time_ns": 0, "period_ns": 1, "discontinuity": 0, "head_tracked": 1,
            "session_state": ""}  # fmt: skip
    states = [ShownFrame.of_row(rest | row).state for row in rows]
    assert [state in UNSEEN for state in states] == unseen_rows(columns).tolist()


FAULTS = st.fixed_dictionaries(
    {},
    optional={
        "paused": st.booleans(),
        "user_present": st.sampled_from([True, False, None]),
        "should_render": st.booleans(),
        "discontinuity": st.booleans(),
        "head_tracked": st.booleans(),
        "session_state": st.sampled_from(["", "visible", "focused"]),
    },
)


@given(st.lists(st.tuples(st.floats(0.1, 60), FAULTS), max_size=10), st.floats(0, 9))
def test_the_states_add_up_to_the_exposure(steps, untold_s):
    frames, periods = [at(0)], 0.0
    for step, changes in steps:
        periods += step
        frames.append(at(periods, **changes))
    whole_s = (round(periods * PERIOD_NS) + PERIOD_NS) / 1e9
    told = account(frames, whole_s + untold_s)
    assert min(told.values()) > 0
    assert abs(sum(told.values()) - whole_s - untold_s) <= 2 * PERIOD_NS / 1e9 + 1e-9
    assert sum(account(frames).values()) == pytest.approx(whole_s)


@given(st.lists(st.tuples(st.floats(0.9, 60), FAULTS), max_size=10))
def test_what_is_counted_as_dropped_and_the_time_of_late_frames_agree(steps):
    log, frames, periods = FrameLog(Rows()), [at(0)], 0.0
    for step, changes in steps:
        periods += step
        frames.append(at(periods, **changes))
    for index, each in enumerate(frames):
        log.add(replace(each, index=index), None, trial=1, session_s=0.0)
    log.finish()
    late_s = log.timing.seen.seconds(SeenState.FROZEN, SeenState.HALF_RATE)
    assert (log.dropped > 0) == (late_s > 0)


class Rows:
    """Keeps rows."""

    def __init__(self) -> None:
        self.rows = []

    def write(self, *rows) -> None:
        self.rows += rows


def test_time_of_a_pause_is_hidden():
    frames = [at(0), at(1, paused=True), at(2, paused=True), at(3, discontinuity=True)]
    assert account(frames) == pytest.approx({"live": 0.2, "hidden": 0.2})


def test_time_without_frames_before_a_cut_is_hidden():
    frames = [at(0), at(50, discontinuity=True)]
    assert account(frames) == pytest.approx({"live": 0.2, "hidden": 4.9})


def test_time_that_no_frame_tells_of_is_hidden_or_of_the_pause_at_its_end():
    assert account([at(0)], 5.0) == pytest.approx({"live": 0.1, "hidden": 4.9})
    assert account([at(0), at(1, user_present=False)], 5.0) == pytest.approx(
        {"live": 0.1, "off": 4.9}
    )
    assert SeenTime.of([], 5.0).seconds(SeenState.HIDDEN) == 5.0


@pytest.mark.parametrize("state", ["focused", "visible"])
def test_time_in_frames_that_the_runtime_wants_no_picture_of_is_not_drawn(state):
    frames = [at(0), *(at(n, should_render=False, session_state=state) for n in (1, 2, 9)), at(10)]
    assert account(frames) == pytest.approx({"live": 0.2, "not_drawn": 0.9})


@pytest.mark.parametrize(("periods", "missed"), [(1.2, 0), (1.3, 1), (2.0, 1), (50.0, 49)])
def test_refreshes_are_counted_not_late_frames(periods, missed):
    assert missed_refreshes(round(periods * PERIOD_NS), PERIOD_NS) == missed


def assert_adds_up(trial: dict[str, str]) -> None:
    seconds = sum(float(trial[state.column]) for state in SeenState)
    elapsed_s = float(trial["end_s"]) - float(trial["start_s"])
    assert abs(seconds - elapsed_s) <= 2 * PERIOD_NS / 1e9 + 1e-9, trial


class Freezes(AheadHeadset):
    """Stands still for 5 of 10 s, from the 20th frame on."""

    def frames(self):
        for index in range(self.frames_left):
            yield at(index if index < 20 else index + 50)


def test_a_trial_that_froze_says_so_and_keeps_its_live_time(tmp_path):
    outcome = go(tmp_path, headset_for=lambda *_: Freezes())
    trial = rows(tmp_path, "trials")[0]
    assert trial["status"] == "completed"
    assert float(trial["live_s"]) == pytest.approx(5.0, abs=0.2)
    assert float(trial["frozen_s"]) == pytest.approx(5.0, abs=0.2)
    assert (trial["dropped"], trial["missed_refreshes"]) == ("1", "50")
    assert rows(tmp_path, "timing")[0]["flagged"] == "1"
    assert any("stood still for 5.00 s" in warning for warning in outcome.warnings)
    assert_adds_up(trial)
    frames = [row for row in rows(tmp_path, "frames") if row["trial"] == "1"]
    assert sum(int(row["missed_refreshes"]) for row in frames) == 50
    ratings = [row for row in rows(tmp_path, "ratings") if row["trial"] == "1"]
    assert len(ratings) == 2, "each rating that was due, at 3 and at 6 s, has its row"
    missed = [(row["response"], row["latency_s"]) for row in ratings if row["missed"] == "1"]
    assert missed
    assert set(missed) == {("", "")}


def test_a_trial_without_tracking_is_flagged_and_never_silently_completed(tmp_path):
    class Lost(AheadHeadset):
        def frames(self):
            for index in range(self.frames_left):
                yield at(index, head_tracked=index < 20)

    outcome = go(tmp_path, headset_for=lambda *_: Lost())
    assert rows(tmp_path, "timing")[0]["flagged"] == "1"
    assert any("the head was not tracked for 9.00 s, 90 %" in each for each in outcome.warnings)
    tracked = [row["head_tracked"] for row in rows(tmp_path, "frames") if row["trial"] == "1"]
    assert tracked == ["1"] * 10 + ["0"] * 90, "the first ten were training"


def test_a_menu_in_front_pauses_the_exposure(tmp_path):
    class Menu(AheadHeadset):
        """For 30 of its frames the runtime's menu is in front."""

        def frames(self):
            for index in range(self.frames_left):
                state = "visible" if 20 <= index < 50 else "focused"
                yield at(index, session_state=state)

    go(tmp_path, headset_for=lambda *_: Menu())
    trial = rows(tmp_path, "trials")[0]
    assert float(trial["live_s"]) == pytest.approx(10.0, abs=0.2)
    assert float(trial["unfocused_s"]) == pytest.approx(3.0, abs=0.2)
    assert [row[3] for row in attempts(tmp_path)] == ["completed", "completed"]


class Covered(AheadHeadset):
    """For 30 of its frames the runtime wants no picture, and wakes the program every 0.3 s."""

    def frames(self):
        for index in range(self.frames_left):
            covered = 20 <= index < 50
            since = min(max(index - 19, 0), 30)
            yield at(index + 2 * since, should_render=not covered)


def test_frames_that_are_not_seen_are_recorded_and_no_exposure(tmp_path):
    told = []

    class Told(NoOutlet):
        def show(self, frame, seen_ns):
            told.append((frame.should_render, seen_ns))

    go(tmp_path, headset_for=lambda *_: Covered(), outlet=Told())
    trial, timing = rows(tmp_path, "trials")[0], rows(tmp_path, "timing")[0]
    assert float(trial["live_s"]) == pytest.approx(9.7)
    assert float(trial["not_drawn_s"]) == pytest.approx(8.8)
    assert float(trial["half_rate_s"]) == pytest.approx(0.3), "until the first of them"
    assert (trial["frames"], trial["dropped"], timing["flagged"]) == ("128", "1", "1")
    assert_adds_up(trial)
    frames = [row for row in rows(tmp_path, "frames") if row["trial"] == "1"]
    assert [row["should_render"] for row in frames].count("0") == 30
    assert told, "other devices are told of frames"
    assert all(drawn for drawn, _ in told)


def test_the_operator_is_told_at_once_that_the_stop_button_is_out_of_reach(tmp_path):
    told = []
    headset = AheadHeadset(events=[HeadsetEvent("unfocused", "the stop button does not work")])
    go(tmp_path, headset_for=lambda *_: headset, progress=told.append)
    (notice,) = [each for each in told if each.step == "notice"]
    assert "stop button" in notice.text
    assert "unfocused" in {row["name"] for row in rows(tmp_path, "events")}


def periods(*predicted_ns: int, hz: float = 0.0) -> tuple[list[int], list[HeadsetEvent]]:
    told: list[HeadsetEvent] = []
    period = RefreshPeriod(lambda: hz, told.append)
    return [period.update(each) for each in predicted_ns], told


def test_the_period_is_fixed_when_the_runtimes_predictions_are_stable():
    found, told = periods(17, *[50] * 9, *[1050, 850, 700], *[100] * 200)
    assert found == [17, 17, *[50] * 211]
    (event,) = told
    assert event.name == "refresh_rate_changed"


def test_a_runtime_that_halves_its_rate_does_not_hide_it():
    found, told = periods(*[11_111_111] * 90, *[22_222_222] * 90, *[11_111_111] * 90, hz=90.0)
    assert set(found) == {11_111_111}
    assert [each.name for each in told] == ["refresh_rate_changed", "refresh_rate_restored"]
    assert "22.22 ms; 11.11 ms at the start" in told[0].detail


def test_a_runtime_that_stops_predicting_changes_nothing():
    assert periods(*[50] * 9, *[0] * 100) == ([50] * 109, [])


def test_the_runtimes_word_on_its_rate_is_told_and_changes_nothing():
    told: list[HeadsetEvent] = []
    period = RefreshPeriod(lambda: 90.0, told.append)
    assert period.update(11_111_111) == 11_111_111
    period.take_rate(90.0, 72.0)
    period.take_rate(72.0, 90.0)
    assert {period.update(11_111_111) for _ in range(99)} == {11_111_111}
    assert [each.name for each in told] == ["refresh_rate_changed", "refresh_rate_restored"]


def test_a_runtime_that_predicts_no_period_has_that_of_its_display():
    rates = iter([0.0, 80.0])
    period = RefreshPeriod(lambda: next(rates))
    assert [period.update(0, 0), period.update(0, 1)] == [0, 12_500_000]
    assert "refresh rate" in period.source
    assert period.update(0, 2) == 12_500_000, "asked once"


def test_where_nothing_tells_the_period_it_is_measured_once_in_frames_that_are_shown():
    period, now_ns = RefreshPeriod(), 0
    for passed_ns in (11, 500, 10, 9, 10, 11, 10, 9, 700, 10):
        assert period.update(0, now_ns) == 0
        assert period.source == ""
        now_ns += passed_ns
        if passed_ns == 700:  # not shown: the runtime may let it wait
            assert period.update(0, None) == 0
    assert [period.update(0, at_ns) for at_ns in (now_ns, now_ns + 90)] == [10, 10]
    assert period.source.startswith("measured: ")
    assert period.update(8, now_ns + 180) == 10, "it is fixed"


class Silent:
    """Answers no rating."""

    def prompt(self, *_):
        """Nobody is there."""

    def rating(self, _):
        """Say nothing."""


def test_a_rating_that_waited_for_an_open_one_when_a_freeze_began_is_missed_too():
    settings = Ratings(instrument="fms", every_s=1.0, timeout_s=0.9)
    due_s = [float(due) for due in range(1, 10)]
    schedule = RatingSchedules([RatingSchedule(settings, find_instrument("fms"), Silent(), due_s)])
    assert schedule.update(1.3, 1.3) is None  # asked late, so open until 2.2
    assert schedule.update(2.1, 2.1) is None
    missed = schedule.missed_while_frozen(7.05, 7.05, 1.0)
    assert [each.onset_s for _, each in missed] == pytest.approx([2, 3, 4, 5, 6, 7])
    assert schedule.update(7.1, 7.1)[1].onset_s == 1.3


def test_a_state_without_a_limit_is_not_flagged() -> None:
    assert SeenTime().beyond({}) == []
