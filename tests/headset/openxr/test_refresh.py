"""How often the display shows a frame: what a runtime does not tell, and what it cannot set."""

from __future__ import annotations

from itertools import islice
from statistics import median_low
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, needs_monado
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.headset.monado import RemoteFeed, RemoteState
from vrcomfort.headset.timing import MEASURED

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_layers import Interceptor, answer
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings, instance

pytestmark = needs_monado

STANDING = RemoteState(Pose([0.0, 1.6, 0.0]))
EXTENSION = xr.FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME


class NoPeriod:
    """A runtime that predicts when a frame is displayed, and not for how long."""

    def __init__(self) -> None:
        self.shown_ns: list[int] = []

    def __call__(self, follow: Any, session: Any, info: Any, state: Any) -> int:
        result = follow(session, info, state)
        frame = state.contents
        frame.predicted_display_period = 0
        if frame.should_render:
            self.shown_ns.append(int(frame.predicted_display_time))
        return int(result)


def headset(
    ctx: moderngl.Context, feed: RemoteFeed, *, refresh_hz: float | None = None, **calls: Any
) -> OpenXrHeadset:
    settings = OpenXrSettings(
        image_size_px=(16, 16), refresh_hz=refresh_hz, api_layers=(Interceptor(**calls).name,)
    )
    return OpenXrHeadset(ctx, settings, before_wait=Participant(feed, lambda _: STANDING))


@pytest.fixture
def no_rates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a runtime of which the extension for refresh rates is not had."""
    others = tuple(name for name in instance.WANTED_EXTENSIONS if name != EXTENSION)
    monkeypatch.setattr(instance, "WANTED_EXTENSIONS", others)


def test_a_period_that_is_not_predicted_is_that_of_the_display(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    with headset(ctx, feed, xrWaitFrame=NoPeriod()) as session:
        periods = {frame.period_ns for frame in islice(session.frames(), 8)}
        display_hz, source = session.refresh_hz, session.details["frame_period"]
    assert periods == {round(1e9 / display_hz)}
    assert source.startswith("the display's refresh rate")


@pytest.mark.usefixtures("no_rates")
def test_a_period_that_nothing_tells_is_measured_before_the_first_frame(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    wait = NoPeriod()
    with headset(ctx, feed, xrWaitFrame=wait) as session:
        assert "frame_period" not in session.details
        frames = list(islice(session.frames(), 4))
        source, rate_hz = session.details["frame_period"], session.refresh_hz
    measured_ns = median_low(np.diff(wait.shown_ns[: MEASURED + 1]).tolist())
    assert {frame.period_ns for frame in frames} == {measured_ns}
    assert frames[0].discontinuity
    assert source.startswith("measured: ")
    assert rate_hz == pytest.approx(1e9 / measured_ns)


@pytest.mark.usefixtures("no_rates")
def test_a_period_that_is_predicted_is_recorded_as_such(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    with headset(ctx, feed) as session:
        next(session.frames())
        assert session.details["frame_period"] == "predicted by the runtime"


class Doubling:
    """A runtime that predicts twice the period, and later none, while frames come as before."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, follow: Any, session: Any, info: Any, state: Any) -> int:
        result, self.count = follow(session, info, state), self.count + 1
        if self.count > 20:
            state.contents.predicted_display_period *= 2 if self.count < 100 else 0
        return int(result)


def test_the_period_is_that_of_the_start_and_another_one_is_told(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    with headset(ctx, feed, xrWaitFrame=Doubling()) as session:
        periods = {frame.period_ns for frame in islice(session.frames(), 120)}
        told = [each for each in session.take_events() if each.name.startswith("refresh_rate")]
    assert periods == {50_000_000}
    (changed,) = told
    assert changed.name == "refresh_rate_changed"
    assert changed.detail == "the runtime predicts a period of 100.00 ms; 50.00 ms at the start"


@pytest.mark.usefixtures("no_rates")
def test_a_rate_is_refused_where_programs_cannot_set_one(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    words = rf"does not let programs set .*{EXTENSION}.*72 Hz in the headset's software"
    with pytest.raises(InputError, match=words):
        headset(ctx, feed, refresh_hz=72.0)


@pytest.mark.parametrize(
    ("calls", "words"),
    [
        ({}, r"does not switch to 91 Hz; it offers 20 Hz: .*--refresh-hz"),
        (
            {"xrRequestDisplayRefreshRateFB": xr.Result.ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB},
            "does not switch to 20 Hz; it offers 20 Hz",
        ),
    ],
)
def test_a_rate_that_the_headset_lacks_is_refused_with_those_that_it_has(
    ctx: moderngl.Context, feed: RemoteFeed, calls: dict[str, Any], words: str
) -> None:
    wanted_hz = 20.0 if calls else 91.0
    refusing = {name: answer(result) for name, result in calls.items()}
    with pytest.raises(InputError, match=words):
        headset(ctx, feed, refresh_hz=wanted_hz, **refusing)


def test_a_rate_that_the_headset_has_is_set(ctx: moderngl.Context, feed: RemoteFeed) -> None:
    with headset(ctx, feed, refresh_hz=20.0) as session:
        assert session.refresh_rates_hz == [20.0]
        assert session.refresh_hz == 20.0
