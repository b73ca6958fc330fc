"""The console's state of a session, updated between two frames."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Protocol

from vrcomfort.console.process import ServerProcess
from vrcomfort.operator_interface import (
    ALLOWED,
    Command,
    OperatorStep,
    SessionOrder,
    SessionProgress,
    TrialSoFar,
)

if TYPE_CHECKING:
    from vrcomfort.frame import FocusSample, Frame, RenderResult

# Five states a second are read as moving, and a page on a busy machine keeps up with two pictures.
STATE_EVERY_S = 0.2
PICTURE_EVERY_S = 0.5
# A state is sent whole each time: these bound its size. Older lines are in events.csv.
LINES = 40
REPLIES = 20


class Pictures(Protocol):
    """Takes pictures of eyes' images without waiting for the GPU.

    A protocol, since the console draws nothing and imports no OpenGL.
    """

    def take(self, eyes: tuple[Any, Any]) -> None:
        """Begin to copy both images."""

    def arrived(self) -> Callable[[], bytes] | None:
        """Count a frame; return the maker of a picture that has arrived, or None."""


class OperatorConsole:
    """A desk with a page. All methods return at once.

    Parameters
    ----------
    server
        Shows the page.
    say
        Prints a line in the terminal for each step and action.
    pictures
        Of both eyes; None where they cannot be taken.
    """

    starts_sessions = True

    def __init__(
        self,
        server: ServerProcess,
        *,
        say: Callable[[str], None] = lambda _: None,
        pictures: Pictures | None = None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._server, self._say = server, say
        self._pictures, self._now_s = pictures, now_s
        self._state: dict[str, Any] = {"kind": "state", "pictures": pictures is not None}
        self._ratings: list[tuple[str, float, float | None]] = []
        self._lines: deque[str] = deque(maxlen=LINES)
        self._replies: deque[tuple[str, str]] = deque(maxlen=REPLIES)
        self._focus_m: float | None = None
        self._order: SessionOrder | None = None
        self._paused = self._leaving = False
        self._next_s = self._next_picture_s = 0.0

    def open(self, order: SessionOrder) -> None:
        """Take note of a session that begins; its first step shows it."""
        self._order = order
        self._state |= {
            "participant": order.participant,
            "session": order.session,
            "sequence": order.sequence,
            "timeline": order.timeline,
            "scales": tuple(asdict(each) for each in order.scales),
            "trial": 0,
            "ended": "",
        }
        self._line(f"session {order.session} of {order.participant}, order {order.sequence}")

    def begin(self, step: OperatorStep) -> None:
        """Show a step that begins."""
        here = {"number": step.number, "kind": step.kind, "words": step.words}
        self._state |= {"step": here, "done": 0.0, "total": 0.0, "frame": None}
        headset = self._order.headset() if self._order else {}
        self._state["depth"] = str(headset.get("depth", ""))
        self._state["allowed"] = sorted(ALLOWED[step.kind])
        if step.kind in {"training", "exposure"}:
            self._ratings.clear()
            self._focus_m = None
        self._paused = False
        self._line(f"step {step.number}: {step.words}")
        self._publish()

    def tell(self, progress: SessionProgress) -> None:
        """Show the progress of a step."""
        if progress.step == "notice":
            self._line(progress.text)
        elif progress.step == "end":
            self._state |= {"ended": progress.text, "allowed": []}
            self._line(f"the session has ended: {progress.text}")
        else:
            self._state |= {"done": progress.done, "total": progress.total}
            self._state["trial"] = progress.trial or self._state.get("trial", 0)
            if self._now_s() < self._next_s:
                return
        self._publish()

    def see(self, frame: Frame, rendered: RenderResult | None, trial: TrialSoFar) -> None:
        """Send a shown frame to the page, if there is time and a page is open."""
        if rendered is not None:
            for sample in rendered.focus_samples:
                self._focus_m = _metres(sample)
            self._look(rendered)
        now_s = self._now_s()
        if now_s < self._next_s:
            return
        self._state["frame"] = {
            "head_m": frame.head_pose.position.tolist(),
            "head_turn": frame.head_pose.orientation.tolist(),
            "tracked": frame.head_tracked,
            "focus_m": self._focus_m,
            "max_blur_px": None if rendered is None else rendered.max_blur_px,
            "frames": trial.frames,
            "dropped": trial.dropped,
            "untracked": trial.untracked,
            "frozen_s": round(trial.frozen_so_far_s, 3),
        }
        self._publish()

    def _look(self, rendered: RenderResult) -> None:
        """Take a picture every `PICTURE_EVERY_S`, if a page shows them."""
        pictures = self._pictures
        if pictures is None:
            return
        if (make := pictures.arrived()) is not None:
            self._server.show_picture(make)
        now_s = self._now_s()
        if self._server.pictures and now_s >= self._next_picture_s:
            self._next_picture_s = now_s + PICTURE_EVERY_S
            pictures.take(rendered.eyes)

    def rated(self, instrument: str, elapsed_s: float, response: float | None) -> None:
        """Show a rating; None was missed."""
        self._ratings.append((instrument, round(elapsed_s, 2), response))
        self._publish()

    def next_command(self) -> Command | None:
        """Return the next command, or None at once."""
        return self._server.next_command()

    def reply(self, command: Command, refusal: str) -> None:
        """Show a command on all pages, and its refusal to the operator."""
        self._replies.append((command.id, refusal))
        action, said = command.action.replace("_", " "), f": {command.text}" if command.text else ""
        if action in {"answer", "rate"} and not refusal:
            said = f"{said} {'rather not say' if command.value is None else f'{command.value:g}'}"
        told = f"refused: {refusal}" if refusal else f"{action}{said}"
        if not refusal and action in {"pause", "go on"}:
            self._paused = action == "pause"
        self._line(f"{command.operator}, {told}")
        self._publish()

    def ask_whether_to_withdraw(self, *, asked: bool) -> None:
        """Ask all operators whether the withdrawal is meant, or no longer."""
        self._leaving = asked
        self._publish()

    def ask(self, question: Mapping[str, Any] | None) -> None:
        """Have operators ask a question aloud and enter the answer; None: no longer."""
        self._state["question"] = question
        self._publish()

    def _line(self, text: str) -> None:
        self._lines.append(f"{time.strftime('%H:%M:%S')} {text}")
        self._say(text)

    def _publish(self) -> None:
        if "step" not in self._state:
            return  # nothing has begun
        self._next_s = self._now_s() + STATE_EVERY_S
        state = dict(self._state)
        state |= {"paused": self._paused, "withdrawing": self._leaving}
        if self._order is not None:
            state["remaining_s"] = round(self._order.remaining_s(), 1)
            state["position"] = self._order.position()
        state |= {"ratings": tuple(self._ratings), "lines": tuple(self._lines)}
        state["replies"] = tuple(self._replies)
        self._server.show(state)


def _metres(sample: FocusSample) -> float | None:
    """Return a distance that JSON can hold: 0 beyond all scenes, None where there is none."""
    metres = float(sample.focus_m)
    return round(metres, 3) if metres < 1e6 else None
