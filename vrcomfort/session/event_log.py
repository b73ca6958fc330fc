"""Events of one session and its progress, as they happen."""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.frame import HeadsetEvent
from vrcomfort.operator_interface import ProgressKind, SessionProgress
from vrcomfort.protocol.timeline import WHOLE_SESSION, TrialPlace
from vrcomfort.records import EventRow, Recorder
from vrcomfort.session.context import SessionContext


@dataclass(frozen=True)
class EventLog:
    """Writes events and tells progress under the name of one session."""

    context: SessionContext
    session: int
    recorder: Recorder

    def event(self, name: str, start_s: float | None = None, *, detail: str = "") -> None:
        """Write an event that ends now; without a start it is a moment."""
        self.look_at_files()
        row = self._event(name, start_s, detail)
        self.context.relay.mark(row)
        self.recorder.write(row)

    def note(self, happened: HeadsetEvent) -> None:
        """Write a headset event between two frames; show the operator the urgent ones."""
        self.event_soon(happened.name, detail=happened.detail)
        if happened.name == "unfocused":
            self.tell("notice", WHOLE_SESSION, 0, 0, happened.detail)

    def event_soon(self, name: str, start_s: float | None = None, *, detail: str = "") -> None:
        """Write an event that ends now, between two frames: nothing waits for the disk."""
        row = self._event(name, start_s, detail)
        self.context.relay.mark(row)
        self.recorder.write_soon(row)

    def look_at_files(self) -> None:
        """Write, and tell at once, what other programs have done to the session's files."""
        for each in self.recorder.take_meddling():
            name = "rows_lost" if each.lost else "file_put_back"
            self.event_soon(name, detail=each.sentence)
            self.tell("notice", TrialPlace(), 0, 0, each.sentence)

    def now_s(self) -> float:
        """Return the session clock."""
        return self.context.clock.now_s()

    def _event(self, name: str, start_s: float | None, detail: str) -> EventRow:
        now_s = self.context.clock.now_s()
        onset_s = now_s if start_s is None else start_s
        return EventRow(onset_s, round(now_s - onset_s, 9), name, detail)

    def tell(
        self, step: ProgressKind, place: TrialPlace, done: float, total: float, text: str = ""
    ) -> None:
        """Tell how far a step has come."""
        self.context.operators.come(done, total)  # a notice has no total
        trial, condition = place.trial or 0, place.condition or ""
        self.context.progress(
            SessionProgress(
                step,
                self.context.participant,
                self.session,
                trial=trial,
                scene=place.scene,
                condition=condition,
                done=done,
                total=total,
                text=text,
            )
        )
