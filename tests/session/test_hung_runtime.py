"""What is on disk when a session's own thread hangs in the headset's runtime, and never returns."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.session import go, manifest, rows, status
from tests.support.study import AheadHeadset, Scripted
from tests.support.waiting import WAIT_S
from vrcomfort.frame import Frame


class Guard:
    """A watchdog that gives up when it is told to."""

    def __init__(self) -> None:
        self.close: Callable[[], None] | None = None

    @contextmanager
    def guard(self, close: Callable[[], None]) -> Iterator[None]:
        self.close = close
        yield
        self.close = None


def test_the_records_of_a_hung_session_are_closed_from_another_thread(tmp_path: Path) -> None:
    watchdog, hangs, never = Guard(), threading.Event(), threading.Event()

    class Hangs(AheadHeadset):
        """Hangs while a rating is open, after 46 frames of training and exposure."""

        def frames(self) -> Iterator[Frame]:
            for count, frame in enumerate(super().frames()):
                if count == 46:
                    hangs.set()
                    never.wait()
                yield frame

    def session() -> None:
        go(tmp_path, Scripted(rates=None), headset=Hangs, watchdog=watchdog)

    threading.Thread(target=session, daemon=True).start()
    assert hangs.wait(WAIT_S)
    assert manifest(tmp_path)["status"] == "running"
    assert watchdog.close is not None
    watchdog.close()

    assert manifest(tmp_path)["status"] == "aborted"
    (trial,) = rows(tmp_path, "trials.csv")
    assert (trial["status"], trial["abort_code"]) == ("aborted", "runtime_hung")
    shown = [row for row in rows(tmp_path, "frames.csv") if row["trial"] == "1"]
    assert len(shown) == int(trial["frames"]) > 0
    assert rows(tmp_path, "events.csv")[-1]["name"] == "runtime_hung"
    asked, rated = rows(tmp_path, "questionnaires.csv"), rows(tmp_path, "ratings.csv")
    assert {row["timepoint"] for row in asked} == {"baseline"}
    assert [row["missed"] for row in rated] == ["1"]
    assert status(tmp_path) == ("enrolled", "session 1 aborted: the headset's runtime hung")
