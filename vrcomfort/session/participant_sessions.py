"""The sessions of one participant: their files, their manifests, and how they ended."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.protocol import Sequence
from vrcomfort.records import (
    Interrupted,
    Machine,
    Manifest,
    Recorder,
    completed_sessions,
    facts_of_run,
    set_status,
)
from vrcomfort.records.study import now
from vrcomfort.respondent import Respondent
from vrcomfort.session.event_log import Diary
from vrcomfort.session.flow import Lab, SessionFlow, SessionStatus
from vrcomfort.session.manifest_writer import Ledger, limits
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.interfaces import Progress


@dataclass(frozen=True)
class Outcome:
    """How far a participant came.

    Parameters
    ----------
    status
        completed (all sessions are on disk), enrolled (more to come), withdrawn or aborted.
    sessions
        Numbers of the sessions that this run recorded, also in part.
    note
        Why it ended early.
    warnings
        What somebody should look at: rows that a crash cut, trials with too many dropped frames.
    """

    participant: str
    sequence: str
    status: str
    sessions: tuple[int, ...]
    note: str = ""
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Work:
    """The sessions of one participant, one after the other; see `reserve`."""

    study: Path
    lab: Lab
    participant: str
    sequence: Sequence
    respondent: Respondent
    seed: int
    machine: Machine
    interrupted: Mapping[int, Interrupted]
    screen: PanelScreen | None
    notices: list[str] = field(default_factory=list)

    def run(self, numbers: Iterable[int]) -> Outcome:
        """Run sessions until one is not completed."""
        ran: list[int] = []
        for number in numbers:
            ran.append(number)
            status, note = self._session(number)
            if status != "completed":
                break
        if status == "withdrawn":
            set_status(self.study, self.participant, "withdrawn", f"session {ran[-1]}: {note}")
            return self._outcome(status, ran, note)
        if status == "aborted":
            set_status(self.study, self.participant, "enrolled", f"session {ran[-1]} aborted")
            return self._outcome(status, ran, note)
        complete = completed_sessions(self.study, self.participant)
        all_done = len(complete) == len(self.sequence.sessions)
        status_now = "completed" if all_done else "enrolled"
        set_status(self.study, self.participant, status_now)
        return self._outcome(status_now, ran)

    def _outcome(self, status: str, ran: list[int], note: str = "") -> Outcome:
        name, warnings = self.sequence.name, tuple(self.notices)
        return Outcome(self.participant, name, status, tuple(ran), note, warnings)

    def _session(self, number: int) -> tuple[SessionStatus, str]:
        self.lab.progress(Progress("session", self.participant, number))
        before = self.interrupted.get(number)
        with Recorder(self.study, self.participant, number, resumed=before is not None) as recorder:
            manifest = self._manifest(number, before)
            ledger = Ledger(manifest, recorder, self.respondent)
            headset_for = ledger.noting(self.lab.headset_for, self.lab.protocol.headset.ipd_m)
            lab = self.lab
            diary = Diary(self.participant, number, recorder, lab.clock, lab.progress)
            if self.screen is not None:
                self.screen.notice = diary.note
            flow = SessionFlow(
                replace(lab, headset_for=headset_for),
                diary=diary,
                ledger=ledger,
                sequence=self.sequence,
                respondent=self.respondent,
                interrupted=before,
            )
            manifest.write(recorder.folder)
            try:
                status, note = _kept(flow, ledger, recorder)
            finally:
                self._look_at(number, manifest, before)
        self.lab.progress(Progress("end", self.participant, number, text=status))
        return status, note

    def _manifest(self, number: int, before: Interrupted | None) -> Manifest:
        then = before.manifest if before else {}
        return Manifest(
            participant=self.participant,
            session=number,
            sequence=self.sequence.name,
            protocol=self.lab.protocol,
            machine=self.machine,
            headset={},
            respondent=self.respondent.name,
            seed=self.seed,
            exposure_s=self.lab.exposure_s,
            started_at=now(),
            clamps=limits(self.lab.protocol),
            earlier_runs=[*then.get("earlier_runs", []), *([facts_of_run(then)] if then else [])],
            timing_flags=list(then.get("timing_flags", [])),
            memory=then.get("memory"),
        )

    def _look_at(self, number: int, manifest: Manifest, before: Interrupted | None) -> None:
        """Tell what was cut off, and write into the participant's note what was flagged."""
        flags = manifest.timing_flags[len(before.manifest["timing_flags"]) if before else 0 :]
        self.notices.extend([*(before.warnings if before else ()), *flags])
        if flags:
            note = "; ".join(f"session {number}, {flag}" for flag in flags)
            with suppress(InputError):  # it stands in the manifest and in the events, too
                set_status(self.study, self.participant, "enrolled", note)


def _kept(flow: SessionFlow, ledger: Ledger, recorder: Recorder) -> tuple[SessionStatus, str]:
    """Run a session and write into its manifest how it ended, whatever ended it."""
    status: SessionStatus = "aborted"
    note = ""
    try:
        status, note = flow.run()
        recorder.flush()
    except KeyboardInterrupt:
        status, note = "aborted", "stopped by the operator"
    except BaseException:
        with suppress(InputError):  # the first error is the one to tell
            ledger.close("aborted")
        raise
    ledger.close(status)
    return status, note
