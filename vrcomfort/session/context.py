"""The context of a participant's sessions: settings of a run, events and progress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.sound import Speaker
from vrcomfort.headset.watchdog import Watchdog
from vrcomfort.operator_interface import (
    NoOperator,
    ProgressCallback,
    ProgressKind,
    SessionProgress,
    no_progress,
)
from vrcomfort.protocol import Protocol, Sequence
from vrcomfort.protocol.timeline import WHOLE_SESSION, TrialPlace
from vrcomfort.records import Durability, EventRow, Machine, Recorder
from vrcomfort.records.rows import Row
from vrcomfort.respondent import Respondent
from vrcomfort.session.clock import Clock, VirtualClock
from vrcomfort.session.interfaces import HeadsetFor, LoadScene, NoOutlet, Outlet, Renderer
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.panel_screen import PanelScreen


@dataclass
class Floor:
    """The height of the scene's floor.

    Parameters
    ----------
    offset_m
        How much higher in the scene everybody is than over their own floor.
    """

    offset_m: float = 0.0


@dataclass(frozen=True, kw_only=True)
class SessionSettings:
    """Settings of the sessions of one run: the respondent, the headset, the outputs.

    Parameters
    ----------
    clock
        `VirtualClock` for simulated participants, `WallClock` for people.
    screen
        Of questions in the headset, None where they are asked elsewhere; its events are recorded.
    ipd_measured_m
        The participant's, as the operator measured it; recorded. None: it was not entered.
    sees_sharp
        The eyes with which the participant sees sharp, as they said; recorded.
    preflight
        The checks before the session, or why there were none, for the manifest.
    notices
        Sentences for the operator, told when the sessions begin.
    durability
        When rows are safe from a power cut; "session_end" is for what can be simulated again.
    watchdog
        Closes the records where the headset's runtime hangs; None where nothing can.
    operators
        Carries out commands; without it there is Ctrl-C alone.
    outlet
        Passes on events, frames and ratings to other devices.
    speaker
        Plays the sounds of instructions; without it their texts stand in for them.
    jumps
        Exposures pass without frames, from one event to the next: for simulated participants.
    """

    respondent: Respondent
    headset_for: HeadsetFor
    load_scene: LoadScene
    renderer: Renderer
    clock: Clock = field(default_factory=VirtualClock)
    machine: Machine = field(default_factory=Machine)
    screen: PanelScreen | None = None
    ipd_measured_m: float | None = None
    sees_sharp: str | None = None
    preflight: Mapping[str, str] | None = None
    notices: tuple[str, ...] = ()
    durability: Durability = "each_row"
    watchdog: Watchdog | None = None
    operators: OperatorControl = field(default_factory=lambda: OperatorControl(NoOperator()))
    outlet: Outlet = field(default_factory=NoOutlet)
    speaker: Speaker | None = None
    jumps: bool = False
    progress: ProgressCallback = no_progress


@dataclass(frozen=True, kw_only=True)
class SessionContext(SessionSettings):
    """The settings, and the participant of the sessions.

    Parameters
    ----------
    study
        The study folder.
    sequence
        The participant's order of conditions.
    seed
        Of the study.
    exposure_s
        Maximum length of an exposure: the protocol's longest, or less.
    floor
        Moves as the height of the eyes is measured.
    """

    protocol: Protocol
    study: Path
    participant: str
    sequence: Sequence
    seed: int
    exposure_s: float
    floor: Floor = field(default_factory=Floor)

    @property
    def time_scale(self) -> float:
        """Return the protocol's seconds for each shown second of the longest exposure."""
        return self.protocol.longest_s / self.exposure_s

    @property
    def panel_stands(self) -> bool:
        """Return whether button presses answer a question in the headset."""
        return self.screen is not None and self.screen.quad is not None

    def shown_s(self, scene: str) -> float:
        """Return how long a trial is shown: as its scene or view says, or shortened."""
        return min(self.protocol.length_s(scene), self.exposure_s)


@dataclass(frozen=True)
class EventLog:
    """Writes events and tells progress under the name of one session."""

    context: SessionContext
    session: int
    recorder: Recorder

    def event(
        self,
        name: str,
        start_s: float | None = None,
        *,
        detail: str = "",
        after: tuple[Row, ...] = (),
    ) -> None:
        """Write an event that ends now; without a start it is a moment.

        The disk is waited for once, for the event and the rows that come before it.
        """
        self.report_file_changes()
        row = self._event(name, start_s, detail)
        self.context.outlet.mark(row)
        self.recorder.write(*after, row)

    def note(self, happened: HeadsetEvent) -> None:
        """Write a headset event between two frames; show the operator the urgent ones."""
        self.event_soon(happened.name, detail=happened.detail)
        if happened.name in ("unfocused", "headset_off", "ipd_differs"):
            self.tell("notice", WHOLE_SESSION, 0, 0, happened.detail)

    def event_soon(self, name: str, start_s: float | None = None, *, detail: str = "") -> None:
        """Write an event that ends now, between two frames: nothing waits for the disk."""
        row = self._event(name, start_s, detail)
        self.context.outlet.mark(row)
        self.recorder.write_soon(row)

    def report_file_changes(self) -> None:
        """Write, and report at once, changes of the session's files by other programs."""
        for each in self.recorder.take_external_changes():
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
