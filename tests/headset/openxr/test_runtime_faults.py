"""Random faults of a runtime that follows a script: exposures add up, and nothing goes untold.

`--exposures` says how many there are: few in the gate, 100 with `make torture` and on Windows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import repeat
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr_runtime import ScriptedRuntime
from tests.support.study import read_rows
from vrcomfort.errors import RuntimeLostError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.report.rated_exposures import LiveClock, rated_exposures
from vrcomfort.report.study_data import read_study
from vrcomfort.seen_time import FREEZE_S, LIMITED, SEEN, UNSEEN, SeenState
from vrcomfort.session.rehearsal import Rehearsal

pytest.importorskip("xr", reason="pyopenxr is not installed")

from tests.headset.openxr.test_session import run, walk

pytestmark = [pytest.mark.slow, pytest.mark.windows]

RATES_HZ = 50, 40
PERIOD_S = 1 / RATES_HZ[0]
EXPOSURE_S, RATED_EVERY_S, RATED_S = 1.0, 0.45, 0.3
MANY = 50
"""So many exposures meet everything that can happen."""
RATINGS = 2
"""Of an exposure, whatever was not seen of it."""
KINDS = {
    "not drawn": "{frames} not_drawn 50",
    "invalid": "{frames} invalid {percent:.0f}",
    "untracked": "{frames} untracked {percent:.0f}",
    "off": "{frames} present 0",
    "menu": "{frames} state visible",
    "hidden": "{frames} state synchronized",
    "stopped": "{frames} state stopping",
    "period x 2": "{frames} period 2",
    "period 0": "{frames} period 0",
    "half rate": "{frames} late 2",
    "freeze": "{first} late 40\n{after} late 1",
    "rate": "{first} rate 40\n{after} rate 50",
}
LOSSES = (
    "{} answer xrWaitFrame -17",
    "{} answer xrEndFrame -13",
    "{} state loss_pending",
    "{} instance_loss",
    "{} answer xrLocateViews -2",
    "{} answer xrWaitSwapchainImage 1",
)
"""After which a session is over."""


@dataclass
class Faults:
    """A script of faults with frames without faults between them.

    Attributes
    ----------
    met
        The kinds of faults that there were.
    """

    seed: int
    loss: str | None = None
    met: set[str] = field(default_factory=set)

    def script(self, frames: int) -> str:
        """Return the lines of so many frames."""
        random = np.random.default_rng(self.seed)
        lines, first, kinds = [f"rates {RATES_HZ[0]} {RATES_HZ[1]}", f"seed {self.seed}"], 60, []
        while first < frames:
            kinds = kinds or [str(each) for each in random.permutation(list(KINDS))]
            kind = kinds.pop()
            last = first + int(random.integers(3, 40))
            percent = random.uniform(10, 45)
            lines.append(
                KINDS[kind].format(
                    frames=f"{first}-{last}", first=first, after=last + 1, percent=percent
                )
            )
            self.met.add(kind)
            first = last + int(random.integers(3, 40))
        if self.loss is not None:
            lines.append(self.loss.format(int(random.integers(70, 130))))
        return "\n".join(lines)


def protocol(exposures: int) -> str:
    trials = ", ".join(['{ scene = "temple", condition = "a" }'] * exposures)
    return f"""
name = "faults"
title = "Exposures in a runtime with faults"
participants = 2
exposure_s = {EXPOSURE_S}
scenes = ["temple"]
conditions = [{{ name = "a" }}]
questionnaires = [{{ timepoint = "baseline", when = "session_start" }}]
ratings = {{ instrument = "fms", every_s = {RATED_EVERY_S}, timeout_s = {RATED_S} }}
[order]
rule = "explicit"
[[order.sequences]]
name = "all"
sessions = [[{trials}]]
"""


def expose(
    ctx: moderngl.Context, folder: Path, exposures: int, faults: Faults, *, resume: bool
) -> None:
    """Run, or go on with, a session of exposures."""
    script = faults.script(frames=60 + 400 * exposures)
    with ScriptedRuntime(folder, script) as runtime, runtime.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), repeat(0))
        run(ctx, rehearsal, folder, text=protocol(exposures), resume=resume)


def told(folder: Path) -> Iterator[tuple[dict[str, str], dict[str, str]]]:
    """Yield the rows of trials.csv and timing.csv of each attempt."""
    session = folder / "study" / "sub-P01" / "ses-1"
    trials, timing = (read_rows(session / f"{name}.csv") for name in ("trials", "timing"))
    yield from zip(trials, timing, strict=True)


def seconds_of(trial: dict[str, str], *states: SeenState) -> float:
    return sum(float(trial[state.column]) for state in states)


def assert_told(folder: Path) -> set[SeenState]:
    """Assert that each exposure adds up and is flagged; return the states that there were."""
    met: set[SeenState] = set()
    for trial, timing in told(folder):
        elapsed_s = float(trial["end_s"]) - float(trial["start_s"])
        assert abs(seconds_of(trial, *SeenState) - elapsed_s) <= 2 * PERIOD_S, trial
        shown_s = seconds_of(trial, SeenState.FROZEN, *SEEN)
        over = [state for state in LIMITED if seconds_of(trial, state) > 0.0101 * shown_s]
        assert timing["flagged"] == "1" or not over, trial
        if trial["status"] == "completed":
            waited_s = seconds_of(trial, *UNSEEN, SeenState.UNFOCUSED)
            assert elapsed_s - waited_s >= EXPOSURE_S - 4 * PERIOD_S, trial
            dose_s = seconds_of(trial, *SEEN) - seconds_of(trial, SeenState.UNFOCUSED)
            assert dose_s <= EXPOSURE_S + FREEZE_S + 4 * PERIOD_S, (
                trial
            )  # a busy machine's last frame
        met |= {state for state in SeenState if seconds_of(trial, state)}
    return met


def assert_doses_are_seen_time(folder: Path) -> None:
    """Assert that a report's exposures last as long as they were seen, and ratings lie in them."""
    data = read_study(folder / "study")
    seen_s = {
        trial["trial"]: seconds_of(trial, *SEEN)
        for trial, _ in told(folder)
        if trial["status"] == "completed"
    }
    exposures = rated_exposures(data, "fms", clock=LiveClock(data))
    assert {each.trial for each in exposures} == set(seen_s)
    for each in exposures:
        assert each.ended_s == pytest.approx(seen_s[each.trial], abs=2 * PERIOD_S)
        assert not each.unplaced
        assert all(0 <= time_s <= each.ended_s + PERIOD_S for time_s in each.course.times_s)


@pytest.fixture
def exposures(request: pytest.FixtureRequest) -> int:
    return int(request.config.getoption("--exposures"))


def test_exposures_add_up_whatever_the_runtime_does_and_however_often_it_is_lost(
    ctx: moderngl.Context, tmp_path: Path, exposures: int
) -> None:
    losses = LOSSES if exposures >= MANY else LOSSES[:2]
    for number, loss in enumerate(losses):
        with pytest.raises(RuntimeLostError, match="--resume"):
            expose(ctx, tmp_path, exposures, Faults(26 + number, loss), resume=number > 0)
    faults = Faults(99)
    expose(ctx, tmp_path, exposures, faults, resume=True)
    assert faults.met == set(KINDS)
    assert len(assert_told(tmp_path)) >= (len(SeenState) if exposures >= MANY else 6)

    trials = [trial for trial, _ in told(tmp_path)]
    done = [trial for trial in trials if trial["status"] == "completed"]
    assert [int(each["trial"]) for each in done] == list(range(1, exposures + 1))
    session = tmp_path / "study" / "sub-P01" / "ses-1"
    frames = read_rows(session / "frames.csv")
    shown = Counter(row["trial"] for row in frames if row["paused"] != "1")
    recorded: Counter[str] = Counter()
    for trial in trials:
        recorded[trial["trial"]] += int(trial["frames"])
    assert recorded == shown
    assert_doses_are_seen_time(tmp_path)
    assert [str(each) for each in verify_study(tmp_path / "study").faults] == []
