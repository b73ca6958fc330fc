"""Random faults of a real runtime: what was seen of each exposure adds up, and is flagged.

An API layer under Monado brings the faults about: between the runtime and what is tested.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pandas as pd
import pytest

from tests.support.openxr import fresh_monado, needs_monado
from tests.support.study import read_rows
from vrcomfort.errors import RuntimeLostError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.seen_time import LIMITED, SEEN, UNSEEN, SeenState
from vrcomfort.session.rehearsal import Rehearsal

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.headset.openxr.test_session import run, walk
from tests.support.openxr_layers import Interceptor

pytestmark = needs_monado

PERIOD_S = 0.05
"""Of Monado without a display."""
EXPOSURE_S = 2.0
EXPOSURES = 6
PROTOCOL = f"""
name = "faults"
title = "Exposures in a runtime with faults"
participants = 2
exposure_s = {EXPOSURE_S}
scenes = ["temple"]
conditions = [{{ name = "a" }}]
ratings = {{ instrument = "fms", every_s = 1.2, timeout_s = 0.7 }}
[order]
rule = "explicit"
[[order.sequences]]
name = "all"
sessions = [[{", ".join(['{ scene = "temple", condition = "a" }'] * EXPOSURES)}]]
"""
KINDS = ("not drawn", "untracked", "off", "hidden", "menu", "period x 2", "period 0", "rate")
LONGEST = 14
"""Frames of one fault."""
UNKNOWN = 0
"""Flags of poses that are not valid."""


class Faults:
    """Bends a runtime's answers: a fault after the other, with frames without faults between them.

    Attributes
    ----------
    met
        The faults that there were.
    """

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._kinds: Iterator[str] = iter(())
        self._kind, self._left, self._invalid = "", 40, 0.0
        self._events: list[Any] = []
        self._session: Any = None
        self.met: list[str] = []
        self.calls = {
            "xrWaitFrame": self.wait,
            "xrLocateViews": self.locate,
            "xrPollEvent": self.poll,
        }

    def wait(self, follow: Any, session: Any, info: Any, state: Any) -> int:
        result, self._session = int(follow(session, info, state)), session
        self._left -= 1
        if self._left < 0:
            self._change()
        frame = state.contents
        if self._kind == "not drawn" and self._random.random() < 0.5:
            frame.should_render = 0
        if self._kind.startswith("period"):
            frame.predicted_display_period *= 2 if self._kind == "period x 2" else 0
        return result

    def _change(self) -> None:
        before, self._kind = self._kind, "" if self._kind else self._next()
        self._left = int(self._random.integers(3, LONGEST))
        self._invalid = self._random.uniform(0.1, 0.45)
        state = {"hidden": xr.SessionState.SYNCHRONIZED, "menu": xr.SessionState.VISIBLE}
        if self._kind == "off" or before == "off":
            self._events.append(xr.EventDataUserPresenceChangedEXT(is_user_present=before == "off"))
        elif self._kind in state:
            self._enter(state[self._kind])
        elif before in state:
            self._enter(xr.SessionState.FOCUSED)
        elif self._kind == "rate":
            self._events.append(xr.EventDataDisplayRefreshRateChangedFB(20.0, 19.0))

    def _next(self) -> str:
        kind = next(self._kinds, None)
        if kind is None:
            self._kinds = iter([str(each) for each in self._random.permutation(KINDS)])
            kind = next(self._kinds)
        self.met.append(kind)
        return kind

    def _enter(self, state: xr.SessionState) -> None:
        self._events.append(xr.EventDataSessionStateChanged(self._session, state, 0))

    def locate(self, follow: Any, session: Any, info: Any, state: Any, *more: Any) -> int:
        result = int(follow(session, info, state, *more))
        if self._kind == "untracked" and self._random.random() < self._invalid:
            state.contents.view_state_flags = UNKNOWN
        return result

    def poll(self, follow: Any, instance: Any, event: Any) -> int:
        if self._events:
            waiting = self._events.pop(0)
            ctypes.memmove(event, ctypes.byref(waiting), ctypes.sizeof(waiting))
            return int(xr.Result.SUCCESS.value)
        return int(follow(instance, event))


class Lost(Faults):
    """Loses the session in an exposure."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._numbers = count()

    def wait(self, follow: Any, session: Any, info: Any, state: Any) -> int:
        if next(self._numbers) == 60:
            return int(xr.Result.ERROR_SESSION_LOST.value)
        return super().wait(follow, session, info, state)


def expose(ctx: moderngl.Context, folder: Path, faults: Faults) -> None:
    """Run a session of exposures."""
    layer = Interceptor(**faults.calls)
    with fresh_monado(folder) as monado, monado.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), iter([0] * 99))
        run(ctx, rehearsal, folder, text=PROTOCOL, api_layers=(layer.name,))


def assert_told(folder: Path) -> set[SeenState]:
    """Assert that each exposure adds up and is flagged; return the states that there were."""
    session = folder / "study" / "sub-P01" / "ses-1"
    met: set[SeenState] = set()
    trials, timing = (read_rows(session / f"{name}.csv") for name in ("trials", "timing"))
    frames = pd.read_csv(session / "frames.csv")
    assert set(frames["period_ns"]) == {round(PERIOD_S * 1e9)}, "that of the start"
    for trial, row in zip(trials, timing, strict=True):
        seconds = {state: float(trial[state.column]) for state in SeenState}
        elapsed_s = float(trial["end_s"]) - float(trial["start_s"])
        print({state.value: s for state, s in seconds.items() if s}, f"of {elapsed_s:.3f} s")
        assert abs(sum(seconds.values()) - elapsed_s) <= 2 * PERIOD_S, trial
        shown_s = sum(seconds[state] for state in (SeenState.FROZEN, *SEEN))
        over = [state for state in LIMITED if seconds[state] > 0.0101 * shown_s]
        assert row["flagged"] == "1" or not over, trial
        if trial["status"] == "completed":
            waited_s = sum(seconds[state] for state in (*UNSEEN, SeenState.UNFOCUSED))
            assert elapsed_s - waited_s >= EXPOSURE_S - 4 * PERIOD_S, trial
        met |= {state for state, each in seconds.items() if each}
    assert [str(each) for each in verify_study(folder / "study").faults] == []
    return met


@pytest.mark.parametrize("seed", [26, 27])
def test_the_states_of_exposures_add_up_whatever_the_runtime_does(
    ctx: moderngl.Context, tmp_path: Path, seed: int
) -> None:
    faults = Faults(seed)
    expose(ctx, tmp_path, faults)
    assert set(KINDS) <= set(faults.met)
    wanted = {"off", "hidden", "not_drawn", "untracked", "unfocused", "live"}
    assert wanted <= {state.value for state in assert_told(tmp_path)}


def test_an_exposure_in_which_the_session_was_lost_adds_up(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    with pytest.raises(RuntimeLostError):
        expose(ctx, tmp_path, Lost(28))
    assert SeenState.LIVE in assert_told(tmp_path)
