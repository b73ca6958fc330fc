"""Random faults of a headset: what was seen of an exposure adds up, is flagged and reported."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from tests.support.resume import go
from tests.support.study import AheadHeadset, frame, read_rows, tiny_protocol
from vrcomfort.errors import RuntimeLostError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import Frame, HeadsetEvent
from vrcomfort.headset.timing import RefreshPeriod
from vrcomfort.records import session_folder
from vrcomfort.report.rated_exposures import LiveClock, rated_exposures
from vrcomfort.report.study_data import read_study, trial_s
from vrcomfort.seen_time import LIMITED, SEEN, UNSEEN, SeenState, SeenTime

PERIOD_NS = 100_000_000
PEOPLE = 6
"""With two exposures each."""
FAULTS = (
    "not drawn", "untracked", "off", "hidden", "no frames", "menu", "frozen", "half rate",
    "period x 2", "period 0", "rate changed", "lost",
)  # fmt: skip


@dataclass
class Faulty(AheadHeadset):
    """Has random faults at random times: several of them may hold at once."""

    random: np.random.Generator = field(default_factory=np.random.default_rng)
    lost_at: int | None = None

    def __post_init__(self) -> None:
        kinds = [str(each) for each in self.random.choice(FAULTS[:-1], self.random.integers(1, 4))]
        starts = self.random.integers(5, 95, len(kinds))
        lengths = self.random.integers(1, 50, len(kinds))
        self._faults = list(zip(kinds, starts, starts + lengths, strict=True))
        self._period = RefreshPeriod(lambda: 10.0, self.events.append)

    def frames(self) -> Iterator[Frame]:
        periods, was_off = 0, False
        for index in range(self.frames_left):
            now = {kind for kind, start, end in self._faults if start <= index < end}
            if index == self.lost_at:
                raise RuntimeLostError("the runtime went away")
            step = 2 if "half rate" in now else 1
            step = 15 if "frozen" in now and index % 20 == 0 else step
            cut = "no frames" in now and index % 20 == 5
            periods += 30 if cut else step
            if any(kind == "rate changed" and index == at for kind, at, _ in self._faults):
                self._period.take_rate(10.0, 8.0)
            off = "off" in now
            if off != was_off:
                self.events.append(HeadsetEvent("headset_off" if off else "headset_on"))
            was_off = off
            predicted_ns = 0 if "period 0" in now else PERIOD_NS * (1 + ("period x 2" in now))
            yield replace(
                frame(index, period_ns=self._period.update(predicted_ns)),
                predicted_display_time_ns=periods * PERIOD_NS,
                discontinuity=cut or index == 0,
                should_render="not drawn" not in now or bool(self.random.random() < 0.5),
                head_tracked="untracked" not in now or bool(self.random.random() < 0.7),
                user_present=not off,
                paused="hidden" in now or (off and bool(self.random.random() < 0.9)),
                session_state="visible" if "menu" in now else "focused",
            )


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory):
    """A study of many exposures, some of which were interrupted and shown again."""
    folder, random = tmp_path_factory.mktemp("faults"), np.random.default_rng(26)
    protocol = tiny_protocol(folder)
    for number in range(PEOPLE):
        lost = [int(random.integers(15, 90)) if random.random() < 0.1 else None]

        def headset_for(*_: object, lost=lost) -> Faulty:
            return Faulty(random=random, lost_at=lost.pop() if lost else None)

        person = {"participant": f"P{number:02}", "protocol": protocol, "headset_for": headset_for}
        try:
            go(folder, **person)
        except RuntimeLostError:
            go(folder, **person, resume=True)
    return folder / "S"


def people(study):
    for number in range(PEOPLE):
        folder = session_folder(study, f"P{number:02}", 1)
        yield folder, *(read_rows(folder / f"{name}.csv") for name in ("trials", "timing"))


def test_the_states_add_up_to_each_exposure(study):
    count = 0
    met = set()
    for _, trials, _ in people(study):
        for trial in trials:
            seconds = {state: float(trial[state.column]) for state in SeenState}
            elapsed_s = float(trial["end_s"]) - float(trial["start_s"])
            assert abs(sum(seconds.values()) - elapsed_s) <= 2 * PERIOD_NS / 1e9 + 1e-6, trial
            assert min(seconds.values()) >= 0
            met |= {state for state, each in seconds.items() if each}
            count += 1
            if trial["status"] == "completed":  # it waited while nothing was seen
                waited_s = sum(seconds[state] for state in (*UNSEEN, SeenState.UNFOCUSED))
                assert elapsed_s - waited_s >= 10.0 - 2 * PERIOD_NS / 1e9 - 1e-6
    assert count >= 2 * PEOPLE
    assert met == set(SeenState)


def test_each_exposure_beyond_a_limit_is_flagged_and_no_other(study):
    flagged = 0
    for folder, trials, timing in people(study):
        told = [r["detail"] for r in read_rows(folder / "events.csv") if r["name"] == "timing_flag"]
        for trial, row in zip(trials, timing, strict=True):
            shown_s = sum(float(trial[state.column]) for state in (SeenState.FROZEN, *SEEN))
            over = [s for s in LIMITED if shown_s and float(trial[s.column]) > 0.0101 * shown_s]
            where = f"trial {trial['trial']}, attempt {trial['attempt']}: "
            mine = [detail for detail in told if detail.startswith(where)]
            assert (row["flagged"] == "1") == bool(mine)
            assert not over or mine
            others = 100 * int(trial["dropped"]) > 5 * int(trial["frames"])
            assert bool(mine) == bool(over or others or "the display's rate" in "".join(mine))
            flagged += bool(mine)
    assert 0 < flagged < 2 * PEOPLE


def test_verify_finds_the_same_account_in_the_frames(study):
    assert [str(each) for each in verify_study(study).faults] == []


def test_verify_finds_seconds_that_are_not_those_of_the_frames(study):
    folder, trials, _ = next(each for each in people(study) if float(each[1][0]["not_drawn_s"]))
    file, text = folder / "trials.csv", (folder / "trials.csv").read_text()
    cell = trials[0][SeenState.NOT_DRAWN.column]
    moved = text.replace(f",{cell},", f",{float(cell) + 1!r},", 1)
    assert moved != text
    file.write_text(moved)
    try:
        faults = [str(each) for each in verify_study(study).faults]
    finally:
        file.write_text(text)
    assert any("its states of seen time add up to" in each for each in faults)


def test_the_dose_and_the_times_of_ratings_are_seen_seconds(study):
    data = read_study(study)
    lost = 0
    for trial in data.trials:
        cells = {name: float(trial[name]) for name in (state.column for state in SeenState)}
        assert trial_s(trial) == pytest.approx(SeenTime.of_cells(cells).seconds(*SEEN))
    for each in rated_exposures(data, "fms", clock=LiveClock(data)):
        trial = next(
            row
            for row in data.trials
            if (row["participant"], row["trial"]) == (each.participant, each.trial)
        )
        assert not each.unplaced
        seen_s = trial_s(trial)
        assert each.ended_s == pytest.approx(seen_s, abs=2 * PERIOD_NS / 1e9)
        assert max(each.course.times_s, default=0.0) <= seen_s + 2 * PERIOD_NS / 1e9
        lost += each.not_live_s > 1
    assert lost > PEOPLE / 2
