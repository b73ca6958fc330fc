"""Runs the sessions of an enrolment and keeps everything that happened."""

from __future__ import annotations

from vrcomfort.headset.sound import Speaker
from vrcomfort.operator_interface import NoOperator, ProgressCallback, no_progress
from vrcomfort.records import Durability, Machine, enrol
from vrcomfort.records.consents import note_consent
from vrcomfort.respondent import Respondent
from vrcomfort.session.clock import Clock, VirtualClock
from vrcomfort.session.context import SessionContext
from vrcomfort.session.enrolment import Enrolment
from vrcomfort.session.interfaces import (
    HeadsetFor,
    LoadScene,
    NoRelay,
    NoWatchdog,
    Relay,
    Renderer,
    Watchdog,
)
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.participant_sessions import Outcome, ParticipantSessions


def run(
    enrolment: Enrolment,
    *,
    respondent: Respondent,
    headset_for: HeadsetFor,
    load_scene: LoadScene,
    renderer: Renderer,
    clock: Clock | None = None,
    machine: Machine | None = None,
    screen: PanelScreen | None = None,
    ipd_measured_m: float | None = None,
    durability: Durability = "each_row",
    watchdog: Watchdog | None = None,
    operators: OperatorControl | None = None,
    relay: Relay | None = None,
    speaker: Speaker | None = None,
    jumps: bool = False,
    progress: ProgressCallback = no_progress,
) -> Outcome:
    """Run the sessions that an enrolment has chosen.

    Parameters
    ----------
    enrolment
        Of `open_enrolment`, which is still open.
    clock
        `VirtualClock` (the default) for simulated participants, `WallClock` for people.
    screen
        Where questions are asked in the headset: what happens to it meanwhile is recorded.
    ipd_measured_m
        The participant's, if the operator measured it; recorded.
    durability
        When rows are safe from a power cut; "session_end" is for what can be simulated again.
    watchdog
        Closes the records where the headset's runtime hangs.
    operators
        Hears the operators; without it, nobody steers but by Ctrl-C.
    relay
        Passes on what happens to other devices.
    speaker
        Plays the sounds of instructions; without it, their texts stand in for them.
    jumps
        Let time jump from one event to the next: for simulated participants without frames.

    Returns
    -------
    Outcome
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
        protocol=enrolment.protocol,
        study=enrolment.study,
        participant=enrolment.participant,
        sequence=enrolment.design.sequence(row.sequence),
        seed=enrolment.design.seed,
        exposure_s=enrolment.exposure_s,
        respondent=respondent,
        headset_for=headset_for,
        load_scene=load_scene,
        renderer=renderer,
        clock=clock or VirtualClock(),
        machine=machine or Machine(),
        screen=screen,
        ipd_measured_m=ipd_measured_m,
        durability=durability,
        progress=progress,
        watchdog=watchdog or NoWatchdog(),
        operators=operators or OperatorControl(NoOperator()),
        relay=relay or NoRelay(),
        speaker=speaker,
        jumps=jumps,
    )
    enrolment.interrupted.check_memory(respondent)  # before anything is written
    interrupted = enrolment.interrupted.take_up(context.sequence)
    return ParticipantSessions(context, interrupted).run(enrolment.numbers)
