"""How much of a trial was seen: live, frozen, hidden, unfocused; and what fell due meanwhile."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.resume import attempts, go, rows
from tests.support.study import AheadHeadset, frame
from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.timing import RefreshPeriod
from vrcomfort.protocol import Ratings
from vrcomfort.questionnaire import find_instrument
from vrcomfort.session.frame_log import SeenTime, missed_refreshes
from vrcomfort.session.interfaces import NoOutlet
from vrcomfort.session.ratings import RatingSchedule, RatingSchedules

PERIOD_NS = 100_000_000


def seen_of(frames) -> SeenTime:
    seen = SeenTime()
    for each in frames:
        seen.add(each)
    seen.end()
    return seen


def at(periods: int, **changes):
    return replace(frame(periods), predicted_display_time_ns=periods * PERIOD_NS, **changes)


def test_a_freeze_is_time_beyond_a_frames_own_period():
    seen = seen_of([at(0), at(1), at(51), at(52)])
    assert (seen.live_s, seen.frozen_s) == pytest.approx((0.4, 4.9))
    assert seen.frozen_percent == pytest.approx(100 * 4.9 / 5.3, abs=0.01)


@given(
    st.lists(
        st.tuples(
            st.integers(1, 60),
            st.booleans(),
            st.booleans(),
            st.booleans(),
            st.sampled_from(["", "visible"]),
        )
    )
)
def test_the_four_kinds_of_time_add_up_to_the_trial(steps):
    frames, periods = [at(0)], 0
    for step, paused, drawn, discontinuity, state in steps:
        periods += step
        frames.append(
            at(
                periods,
                paused=paused,
                should_render=drawn,
                discontinuity=discontinuity,
                session_state=state,
            )
        )
    seen = seen_of(frames)
    whole_s = (periods + 1) * PERIOD_NS / 1e9
    assert seen.live_s + seen.frozen_s + seen.hidden_s + seen.unfocused_s == pytest.approx(whole_s)
    assert min(seen.cells().values()) >= 0


def test_time_while_the_headset_is_off_is_hidden():
    frames = [at(0), at(1, paused=True), at(2, paused=True), at(3, discontinuity=True)]
    seen = seen_of(frames)
    assert (seen.live_s, seen.hidden_s, seen.frozen_s) == pytest.approx((0.2, 0.2, 0.0))


@pytest.mark.parametrize("state", ["focused", "visible"])
def test_time_in_frames_that_the_runtime_wants_no_picture_of_is_hidden(state):
    frames = [at(0), *(at(n, should_render=False, session_state=state) for n in (1, 2, 9)), at(10)]
    seen = seen_of(frames)
    assert (seen.live_s, seen.hidden_s) == pytest.approx((0.2, 0.9))
    assert (seen.frozen_s, seen.unfocused_s) == (0.0, 0.0)


def test_a_runtimes_menu_in_front_is_unfocused_time():
    seen = seen_of([at(0), at(1, session_state="visible"), at(2, session_state="focused")])
    assert (seen.live_s, seen.unfocused_s) == pytest.approx((0.2, 0.1))


@pytest.mark.parametrize(
    ("periods", "missed"), [(1.0, 0), (1.2, 0), (1.3, 1), (2.0, 1), (3.0, 2), (50.0, 49)]
)
def test_refreshes_are_counted_not_late_frames(periods, missed):
    assert missed_refreshes(round(periods * PERIOD_NS), PERIOD_NS) == missed


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
    frames = [row for row in rows(tmp_path, "frames") if row["trial"] == "1"]
    assert sum(int(row["missed_refreshes"]) for row in frames) == 50


def test_a_rating_that_fell_due_in_a_freeze_is_a_row(tmp_path):
    go(tmp_path, headset_for=lambda *_: Freezes())
    whole = tmp_path / "whole"
    whole.mkdir()
    go(whole)
    frozen, asked = (
        [r for r in rows(at, "ratings") if r["trial"] == "1"] for at in (tmp_path, whole)
    )
    assert len(frozen) == len(asked), "each rating that was due has its row"
    missed = [row for row in frozen if row["missed"] == "1"]
    assert missed
    for row in missed:
        assert (row["response"], row["latency_s"]) == ("", "")


def test_a_trial_without_tracking_is_flagged_and_never_silently_completed(tmp_path):
    class Lost(AheadHeadset):
        def frames(self):
            for index in range(self.frames_left):
                yield at(index, head_tracked=index < 20)

    outcome = go(tmp_path, headset_for=lambda *_: Lost())
    assert rows(tmp_path, "timing")[0]["flagged"] == "1"
    assert any("the head was not tracked in 90 of 100 frames" in each for each in outcome.warnings)
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
    assert float(trial["live_s"]) == pytest.approx(10.0)
    assert float(trial["hidden_s"]) == pytest.approx(8.8)
    assert float(trial["frozen_s"]) == pytest.approx(0.2), "until the first of them"
    assert (trial["frames"], trial["dropped"], timing["flagged"]) == ("130", "1", "0")
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


def test_a_slow_program_does_not_lengthen_the_period_at_which_frames_are_due():
    period = RefreshPeriod()
    assert [period.update(ns) for ns in (17, 50, 50, 50)] == [17, 17, 50, 50]
    assert [period.update(ns) for ns in (1050, 850, 700)] == [50, 50, 50]
    period.forget()
    assert period.update(100) == 100, "the display's rate has changed"


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
    assert period.update(8, now_ns + 180) == 8, "a prediction is better"
    assert period.source == "predicted by the runtime"


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
