"""What operators see, put together between two frames that wait for nothing."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

import numpy as np
import pytest

from tests.support.console import served
from tests.support.resume import go
from tests.support.study import Picture, Scripted, frame, sample_of
from tests.support.waiting import WAIT_S
from vrcomfort.console import OperatorConsole
from vrcomfort.gpu import gl
from vrcomfort.headset.eye_painter import EyePictures
from vrcomfort.operator_interface import Command, OperatorStep, SessionOrder, SessionProgress
from vrcomfort.session.frame_log import TrialTiming
from vrcomfort.session.operator_control import OperatorControl


@dataclass
class Shown:
    """A server that keeps what it is to show."""

    pictures: int = 0
    states: list[Mapping[str, Any]] = field(default_factory=list)
    taken: list[bytes] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)

    def show(self, state: Mapping[str, Any]) -> None:
        self.states.append(state)

    def show_picture(self, make: Callable[[], bytes]) -> None:
        self.taken.append(make())

    def next_command(self) -> Command | None:
        return self.commands.pop(0) if self.commands else None


class Pictures:
    """Pictures that come with the next frame."""

    def __init__(self) -> None:
        self.began = 0
        self.waiting = False

    def take(self, _eyes: object) -> None:
        self.began += 1
        self.waiting = True

    def arrived(self) -> Callable[[], bytes] | None:
        waiting, self.waiting = self.waiting, False
        return (lambda: b"picture") if waiting else None


def shown_session(tmp_path, server: Any, **more: Any) -> OperatorConsole:
    """Run a session before a desk whose clock moves on by 0.05 s with each look at it."""
    time_s = [0.0]

    def now_s() -> float:
        time_s[0] += 0.05
        return time_s[0]

    said: list[str] = []
    desk = OperatorConsole(server, now_s=now_s, say=said.append, **more)
    desk.starts_sessions = False
    desk.said = said
    go(tmp_path, Scripted(), operators=OperatorControl(desk), progress=desk.tell)
    return desk


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    server, pictures = Shown(pictures=1), Pictures()
    desk = shown_session(tmp_path_factory.mktemp("shown"), server, pictures=pictures)
    return server, desk, pictures


def test_the_state_says_which_depth_the_headset_gets_once_that_is_known():
    server, facts = Shown(), {}
    desk = OperatorConsole(server, say=lambda _: None)
    desk.open(SessionOrder("P01", 1, "ab", (), lambda: 0, lambda: 0.0, headset=lambda: facts))
    desk.begin(OperatorStep(1, "training", "training"))
    facts["depth"] = "blur_aware"
    desk.begin(OperatorStep(2, "exposure", "exposure 1"))
    assert [state["depth"] for state in server.states] == ["", "blur_aware"]


def test_the_state_has_the_reply_to_each_command():
    server = Shown()
    desk = OperatorConsole(server, say=lambda _: None)
    desk.open(SessionOrder("P01", 1, "ab", (), lambda: 0, lambda: 0.0, headset=dict))
    desk.begin(OperatorStep(1, "training", "training"))
    desk.reply(Command("one", "pause", 1, "A", ""), "")
    desk.reply(Command("two", "pause", 1, "A", ""), "it is paused")
    desk.begin(OperatorStep(2, "exposure", "exposure 1"))
    assert server.states[-1]["replies"] == (("one", ""), ("two", "it is paused"))


@pytest.mark.parametrize(("focus_m", "shown_m"), [(2.34567, 2.346), (1e6, None)])
def test_the_focus_is_shown_to_the_millimetre_and_not_where_it_is_beyond_all_scenes(
    focus_m, shown_m
):
    server, sample = Shown(), replace(sample_of(0), focus_m=focus_m)
    desk = OperatorConsole(server, now_s=count(step=10).__next__)
    desk.begin(OperatorStep(1, "exposure", "exposure 1"))
    desk.see(frame(0), Picture((sample,)), TrialTiming())
    assert server.states[-1]["frame"]["focus_m"] == shown_m


def states_of(server: Shown, kind: str) -> list[Mapping[str, Any]]:
    return [state for state in server.states if state.get("step", {}).get("kind") == kind]


def test_the_state_says_who_in_which_order_and_how_much_of_a_step_is_left(session):
    server, *_ = session
    last = states_of(server, "exposure")[-1]
    assert (last["participant"], last["session"], last["sequence"]) == ("P01", 1, "ab")
    assert last["timeline"] == (
        "questionnaire ssq (baseline)",
        "training",
        "exposure 1: plain in room.glb",
        "questionnaire ssq (post)",
        "exposure 2: blur in room.glb",
        "questionnaire ssq (post)",
        "rest of 60 s",
        "questionnaire ssq (recovery)",
    )
    assert last["timeline"][last["position"] - 1] == "exposure 2: blur in room.glb"
    assert last["trial"] == 2
    assert last["step"]["words"] == "exposure 2 of 2, attempt 1: blur in room.glb"
    assert last["total"] == 10.0
    done = [state["done"] for state in states_of(server, "exposure")]
    assert 0 < min(x for x in done if x) < max(done) <= 10.0
    assert "pause" in last["allowed"]
    assert "start" not in last["allowed"]


def test_it_says_where_the_head_is_and_how_the_frames_come(session):
    server, *_ = session
    frame = next(s["frame"] for s in reversed(states_of(server, "exposure")) if s["frame"])
    assert frame["head_m"] == [0.0, 0.0, 0.0]
    assert frame["head_turn"] == [0.0, 0.0, 0.0, 1.0]
    assert (frame["focus_m"], frame["max_blur_px"]) == (2.5, 1.5)
    assert frame["frames"] > 50
    assert (frame["dropped"], frame["untracked"], frame["frozen_s"]) == (0, 0, 0.0)


def test_ratings_come_one_after_the_other_and_begin_again_with_the_next_exposure(session):
    server, *_ = session
    counts = [len(state["ratings"]) for state in states_of(server, "exposure")]
    assert max(counts) == 2
    assert counts.count(0) > 1
    name, elapsed_s, response = states_of(server, "exposure")[-1]["ratings"][0]
    assert (name, response) == ("fms", 4)
    assert 3.0 < elapsed_s < 4.0


def test_the_terminal_has_the_steps_in_plain_lines_and_the_page_how_it_ended(session):
    server, desk, _ = session
    assert desk.said[0] == "session 1 of P01, order ab"
    assert desk.said[1] == "step 1: questionnaire ssq (baseline)"
    assert desk.said[-1] == "the session has ended: completed"
    assert server.states[-1]["ended"] == "completed"
    assert server.states[-1]["allowed"] == []
    assert len(server.states[-1]["lines"]) == len(desk.said)


def test_a_state_does_not_change_any_more_once_it_is_shown(session):
    server, *_ = session
    assert len({len(state["lines"]) for state in server.states if "lines" in state}) > 5


def test_pictures_are_taken_now_and_then_and_only_while_somebody_looks(session, tmp_path):
    server, _, pictures = session
    assert server.taken
    assert set(server.taken) == {b"picture"}
    frames = 210
    assert 5 < pictures.began < frames / 2
    unseen, none = Shown(), Pictures()
    shown_session(tmp_path, unseen, pictures=none)
    assert none.began == 0


def test_what_the_operator_must_know_at_once_is_a_line():
    server = Shown()
    desk = OperatorConsole(server)
    desk.begin(OperatorStep(1, "ready", "waiting"))
    desk.tell(SessionProgress("notice", "P01", 1, text="a menu is in front"))
    assert server.states[-1]["lines"][-1].endswith(" a menu is in front")


def test_a_session_runs_to_its_end_while_its_server_stands_still(tmp_path):
    with served() as console:
        os.kill(console.server.pid, signal.SIGSTOP)
        try:
            ran = threading.Thread(
                target=shown_session, args=(tmp_path, console.server), daemon=True
            )
            ran.start()
            ran.join(WAIT_S)
            assert not ran.is_alive()
        finally:
            os.kill(console.server.pid, signal.SIGCONT)


def test_pictures_of_both_eyes_are_read_back_some_frames_later(ctx):
    eyes = []
    for colour in ((255, 0, 0, 255), (0, 0, 255, 255)):
        eyes.append(gl.color_texture(ctx, (64, 80), dtype="f1"))
        eyes[-1].write(np.full((80, 64, 4), colour, np.uint8).tobytes())
    pictures = EyePictures(width_px=32)
    assert pictures.arrived() is None
    pictures.take((eyes[0], eyes[1]))
    came = [pictures.arrived() for _ in range(gl.LATENCY + 1)]
    assert came[:-1] == [None] * gl.LATENCY
    body = came[-1]()
    assert body[:4] == b"\x40\x00\x28\x00"  # 64 × 40
    picture = np.frombuffer(body[4:], np.uint8).reshape(40, 64, 3)
    np.testing.assert_array_equal(picture[:, :32], np.broadcast_to([255, 0, 0], (40, 32, 3)))
    np.testing.assert_array_equal(picture[:, 32:], np.broadcast_to([0, 0, 255], (40, 32, 3)))
    assert pictures.arrived() is None
    pictures.release()
    del eyes
