"""Runs the sessions of an enrolment and keeps everything that happened."""

from __future__ import annotations

from vrcomfort.records import enrol
from vrcomfort.records.consents import note_consent
from vrcomfort.session.context import SessionContext, SessionSettings
from vrcomfort.session.enrolment import OpenEnrolment
from vrcomfort.session.participant_sessions import ParticipantSessions, RunOutcome


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
    interrupted = enrolment.interrupted.take_up(context.sequence)
    return ParticipantSessions(context, interrupted).run(enrolment.numbers)
