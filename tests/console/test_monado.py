"""A session in a Monado runtime, run from the console alone: recentred, and both eyes seen."""

from __future__ import annotations

import pandas as pd
import pytest

pytest.importorskip("xr", reason="pyopenxr is not installed")
from tests.support.console import Doing, come_in, page_of, steer
from tests.support.console_session import RunningSession, running_session
from tests.support.openxr import needs_monado
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.resources import data_folder

pytestmark = [*needs_monado, pytest.mark.slow, pytest.mark.timeout(540)]

TRACE = data_folder("scenes") / "temple_walk.csv"
PLAN = [
    Doing("waiting for the start", "start"),
    Doing("attempt 1: plain", "pause", after_s=0.5),
    Doing("attempt 1: plain", "note", "the cable is caught", paused=True),
    Doing("attempt 1: plain", "recentre", paused=True),
    Doing("attempt 1: plain", "redo", paused=True),
    Doing("attempt 2: plain", "pause", after_s=1.0),
    Doing("attempt 2: plain", "go_on", paused=True),
]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> RunningSession:
    """Return a session that one page has steered."""
    folder = tmp_path_factory.mktemp("console")
    options = ("--headset", "openxr", "--monado-trace", str(TRACE), "--respondent", "console")
    with running_session(folder, *options) as found:
        origin, cookie = come_in(found.next_address())
        with page_of(origin, cookie) as page:
            page.say("watch", 0, value=1)
            found.states = steer(page, PLAN)
        found.pictures = page.pictures
        assert found.ended() == 0, "".join(found.lines)
        return found


def table(session: RunningSession, name: str) -> pd.DataFrame:
    return pd.read_csv(session.ses / name, keep_default_na=False)


def test_the_session_was_run_from_the_console_alone(session: RunningSession) -> None:
    trials = table(session, "trials.csv")
    columns = ["trial", "attempt", "status", "abort_code"]
    assert trials[columns].to_numpy().tolist() == [
        [1, 1, "aborted", "redone"],
        [1, 2, "completed", ""],
        [2, 1, "completed", ""],
    ]
    assert set(table(session, "questionnaires.csv")["response"]) == {1}
    ratings = table(session, "ratings.csv")
    assert (ratings["response"] == "1").sum() >= 1
    assert [str(each) for each in verify_study(session.folder / "study").faults] == []


def test_pause_redo_note_and_recentring_are_on_record(session: RunningSession) -> None:
    events = table(session, "events.csv")
    done = [name for name in events["name"] if name.startswith("operator_")]
    assert [name for name in done if name not in {"operator_answer", "operator_rate"}] == [
        "operator_start", "operator_confirm", "operator_pause", "operator_note",
        "operator_recentre", "operator_redo", "operator_pause", "operator_go_on",
        "operator_confirm", "operator_confirm",
    ]  # fmt: skip
    note = events[events["name"] == "operator_note"]["detail"].item()
    assert note.endswith(": the cable is caught")
    assert "recentered" in set(events["name"])
    assert (events[events["name"] == "pause"]["duration_s"] > 0).all()
    shown = table(session, "frames.csv")
    assert set(shown["trial"]) == {0, 1, 2}


def test_the_page_saw_the_head_and_both_eyes(session: RunningSession) -> None:
    frames = [state["frame"] for state in session.states if state.get("frame")]
    assert len({tuple(frame["head_m"]) for frame in frames}) > 5
    assert session.pictures
    assert all(picture.startswith(b"\xff\xd8") for picture in session.pictures)
