"""Runs the sessions of an enrolment and records them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, field

from vrcomfort.errors import InputError
from vrcomfort.operator_interface import SessionProgress
from vrcomfort.records import (
    Interrupted,
    Manifest,
    Recorder,
    access_of,
    completed_sessions,
    enrol,
    facts_of_run,
    set_status,
)
from vrcomfort.records.checksums import write_checksums
from vrcomfort.records.consents import note_consent
from vrcomfort.records.study import now
from vrcomfort.records.wall_clock import set_back_before
from vrcomfort.session.context import EventLog, SessionContext, SessionSettings
from vrcomfort.session.enrolment import OpenEnrolment
from vrcomfort.session.flow import SessionFlow, SessionStatus
from vrcomfort.session.manifest_writer import ManifestWriter, limits
from vrcomfort.stop_signals import listening, uninterrupted

RUNTIME_HUNG = "runtime_hung"


@dataclass(frozen=True)
class RunOutcome:
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
        What the experimenter should look at: rows that a crash cut, trials with too many dropped
        frames, a clock that was set back.
    lost
        Rows that another program has taken out of the files, one sentence each.
    """

    participant: str
    sequence: str
    status: str
    sessions: tuple[int, ...]
    note: str = ""
    warnings: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()


@dataclass(frozen=True)
class ParticipantSessions:
    """The sessions of one participant, one after the other.

    Parameters
    ----------
    interrupted
        Session → how far it came, for those that go on.
    """

    context: SessionContext
    interrupted: Mapping[int, Interrupted]
    notices: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    def run(self, numbers: Iterable[int]) -> RunOutcome:
        """Run sessions until one is not completed.

        A signal stops one at once, and then all is written that belongs to it.
        """
        with uninterrupted():
            return self._run(numbers)

    def _run(self, numbers: Iterable[int]) -> RunOutcome:
        ran: list[int] = []
        for number in numbers:
            ran.append(number)
            status, note = self._session(number)
            if status not in {"completed", "ended"}:
                break
        study, participant = self.context.study, self.context.participant
        if status == "withdrawn":
            set_status(study, participant, "withdrawn", f"session {ran[-1]}: {note}")
            return self._outcome(status, ran, note)
        if status == "aborted":
            why = "" if note == STOPPED else f": {note}"
            set_status(study, participant, "enrolled", f"session {ran[-1]} aborted{why}")
            return self._outcome(status, ran, note)
        complete = completed_sessions(study, participant)
        all_done = len(complete) == len(self.context.sequence.sessions)
        status_now = "completed" if all_done else "enrolled"
        set_status(
            study, participant, status_now, f"session {ran[-1]} ended: {note}" if note else ""
        )
        return self._outcome(status_now, ran, note)

    def _outcome(self, status: str, ran: list[int], note: str = "") -> RunOutcome:
        name, warnings = self.context.sequence.name, tuple(self.notices)
        who, lost = self.context.participant, tuple(self.lost)
        return RunOutcome(who, name, status, tuple(ran), note, warnings, lost)

    def _session(self, number: int) -> tuple[SessionStatus, str]:
        context = self.context
        context.progress(SessionProgress("session", context.participant, number))
        before = self.interrupted.get(number)
        study, participant, resumed = context.study, context.participant, before is not None
        access, durability = access_of(study), context.durability
        manifest = self._manifest(number, before)
        with Recorder(
            study, participant, number, resumed=resumed, access=access, durability=durability
        ) as recorder:
            writer = ManifestWriter(manifest, recorder, context.respondent)
            events = EventLog(context, number, recorder)
            if context.screen is not None:
                context.screen.notice = events.note
                context.screen.each_frame = context.operators.look
            flow = SessionFlow(context, events=events, manifest=writer, interrupted=before)
            manifest.write(recorder.folder, access)
            try:
                with self._guarded(number, flow, writer, recorder):
                    status, note = _kept(flow, writer, events)
            finally:
                self.lost.extend(each.sentence for each in recorder.external_changes if each.lost)
                self._look_at(number, manifest, before)
        self._write_checksums(number, recorder)
        context.progress(SessionProgress("end", context.participant, number, text=status))
        return status, note

    def _guarded(
        self, number: int, flow: SessionFlow, writer: ManifestWriter, recorder: Recorder
    ) -> AbstractContextManager[None]:
        """Have the records closed if the headset's runtime hangs."""
        if self.context.watchdog is None:
            return nullcontext()
        return self.context.watchdog.guard(lambda: self._give_up(number, flow, writer, recorder))

    def _give_up(
        self, number: int, flow: SessionFlow, writer: ManifestWriter, recorder: Recorder
    ) -> None:
        """Close the records from another thread: the session's own hangs, and never comes back."""
        try:
            flow.give_up(RUNTIME_HUNG)
        finally:
            try:
                recorder.close()
            finally:
                writer.close("aborted")
                self._write_checksums(number, recorder)
                note = f"session {number} aborted: the headset's runtime hung"
                set_status(self.context.study, self.context.participant, "enrolled", note)

    def _write_checksums(self, number: int, recorder: Recorder) -> None:
        """Write the checksums; a session without them is whole, so nothing fails with them."""
        try:
            write_checksums(recorder.folder, recorder.access)
        except (InputError, OSError) as error:
            self.notices.append(f"session {number} has no checksums: {error}")

    def _manifest(self, number: int, before: Interrupted | None) -> Manifest:
        context = self.context
        then = before.manifest if before else {}
        return Manifest(
            participant=context.participant,
            session=number,
            sequence=context.sequence.name,
            protocol=context.protocol,
            machine=context.machine,
            headset={},
            respondent=context.respondent.name,
            seed=context.seed,
            exposure_s=context.exposure_s,
            started_at=now(),
            clamps=limits(context.protocol),
            earlier_runs=[*then.get("earlier_runs", []), *([facts_of_run(then)] if then else [])],
            clock_set_back=set_back_before(context.study, context.participant),
            timing_flags=list(then.get("timing_flags", [])),
            exposure_ended=then.get("exposure_ended"),
            missed_questions=list(then.get("missed_questions", [])),
            withdrawals_undone=list(then.get("withdrawals_undone", [])),
            ipd_measured_m=context.ipd_measured_m or then.get("ipd_measured_m"),
            preflight=dict(context.preflight) if context.preflight else None,
            sees_sharp=context.sees_sharp or then.get("sees_sharp"),
            memory=then.get("memory"),
            eye_heights=list(then.get("eye_heights", [])),
        )

    def _look_at(self, number: int, manifest: Manifest, before: Interrupted | None) -> None:
        """Collect warnings, and write timing flags into the participant's note."""
        flags = manifest.timing_flags[len(before.manifest["timing_flags"]) if before else 0 :]
        cut = before.warnings if before else ()
        self.notices.extend([*cut, *flags, *manifest.clock_set_back, *manifest.missed_questions])
        if flags:
            note = "; ".join(f"session {number}, {flag}" for flag in flags)
            with suppress(InputError):  # it stands in the manifest and in the events, too
                set_status(self.context.study, self.context.participant, "enrolled", note)


STOPPED = "stopped by the operator"


def _kept(flow: SessionFlow, writer: ManifestWriter, events: EventLog) -> tuple[SessionStatus, str]:
    """Run a session and write its end into the manifest, in any case."""
    status: SessionStatus = "aborted"
    note = ""
    try:
        with listening():
            status, note = flow.run()
        events.recorder.sync()  # first: a session that is completed has all of its rows
    except KeyboardInterrupt as stop:
        early = writer.ended_early
        status, note = ("aborted", str(stop) or STOPPED) if early is None else (early, "")
    except BaseException:
        with suppress(InputError):  # the first error is the one to tell
            writer.close(writer.ended_early or "aborted")
        raise
    try:
        events.recorder.sync()
    finally:
        events.report_file_changes()
        writer.close(status)
    return status, note


def run(enrolment: OpenEnrolment, settings: SessionSettings) -> RunOutcome:
    """Run the sessions that an enrolment has chosen.

    Parameters
    ----------
    enrolment
        Of `open_enrolment`, which is still open.

    Returns
    -------
    RunOutcome
        Ctrl-C ends in status "aborted", with everything written and all files closed.

    Raises
    ------
    InputError
        If the disk refuses, or the headset's runtime goes away; what is there stays.
    """
    row = enrol(
        enrolment.study, enrolment.design, enrolment.participant, dict(enrolment.covariates)
    )
    if enrolment.consent is not None:
        note_consent(enrolment.study, enrolment.consent)
    context = SessionContext(
        **vars(settings),
        protocol=enrolment.protocol,
        study=enrolment.study,
        participant=enrolment.participant,
        sequence=enrolment.design.sequence(row.sequence),
        seed=enrolment.design.seed,
        exposure_s=enrolment.exposure_s,
    )
    enrolment.interrupted.check_memory(settings.respondent)  # before anything is written
    interrupted = enrolment.interrupted.repair_session(context.sequence)
    for text in settings.notices:
        number = enrolment.numbers[0]
        settings.progress(SessionProgress("notice", enrolment.participant, number, text=text))
    return ParticipantSessions(context, interrupted).run(enrolment.numbers)
