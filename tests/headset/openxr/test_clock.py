"""Display times of a runtime can be put on the system's clock, and are recorded so."""

from __future__ import annotations

import time
from itertools import islice

import moderngl
import pytest

from tests.support.openxr import Participant, needs_monado
from vrcomfort.geometry import Pose
from vrcomfort.headset.base import HasDisplayClock
from vrcomfort.headset.monado import RemoteFeed, RemoteState

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado


def test_frames_are_to_be_seen_soon_after_they_are_asked_for(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    participant = Participant(feed, lambda _: RemoteState(Pose([0.0, 1.6, 0.0])))
    settings = OpenXrSettings(image_size_px=(32, 24))
    ahead_ms = []
    with OpenXrHeadset(ctx, settings, before_wait=participant) as headset:
        assert isinstance(headset, HasDisplayClock)
        assert headset.details["display_clock"] == "XR_KHR_convert_timespec_time"
        for frame in islice(headset.frames(), 30):
            now_ns = headset.display_now_ns()
            assert now_ns is not None
            ahead_ms.append((frame.predicted_display_time_ns - now_ns) / 1e6)
            headset.submit(frame, None)
        least_ns, most_ns = [], []
        for _ in range(20):
            before_ns = time.monotonic_ns()
            told_ns = headset.display_now_ns()
            assert told_ns is not None
            least_ns.append(told_ns - time.monotonic_ns())
            most_ns.append(told_ns - before_ns)
    typical_ms = sorted(ahead_ms)[15]
    print(f"\nframes are asked for {typical_ms:.1f} ms before they are to be seen")
    assert 0 < typical_ms < 200
    assert max(least_ns) - min(most_ns) < 1_000_000  # one offset explains all, however late read
