"""`simulate`: simulated participants go through a protocol and everything is recorded."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.cli.gaze_check import require_recorded_gaze
from vrcomfort.cli.options import (
    ExposureOption,
    GroupReadable,
    LanguageOption,
    ProtocolArgument,
    Quiet,
    RefreshRate,
    Size,
    StudyFolder,
    StudySeed,
    TraceOption,
    parse_size,
)
from vrcomfort.cli.playback import PlaybackSetup, open_trace
from vrcomfort.cli.simulate_resume_check import ResumeCheck
from vrcomfort.cli.study_setup import RespondentKind, StudySetup, outcome_sentence
from vrcomfort.cli.terminal import console, progress_bar, warn
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.session import RunOutcome


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(simulate)


def simulate(
    protocol: ProtocolArgument,
    participants: Annotated[int, typer.Option("--participants", "-n", min=1, max=10_000)],
    out: StudyFolder,
    seed: StudySeed = None,
    trace: TraceOption = None,
    size: Size = "320x400",
    refresh_hz: RefreshRate = None,
    exposure_s: ExposureOption = None,
    frames: Annotated[
        bool, typer.Option("--frames/--no-frames", help="Draw every frame, or let time jump.")
    ] = True,
    language: LanguageOption = None,
    group_readable: GroupReadable = False,
    quiet: Quiet = False,
) -> None:
    """Take simulated participants through all their sessions, every frame rendered.

    With --no-frames nothing is drawn, and time jumps from one event to the next: answers, ratings
    and withdrawals as people give them, in no time.

    Where it was stopped, the same command goes on: what is recorded stays, and an interrupted
    session continues at its next exposure. One with other options is refused.

    - `vrcomfort simulate smoke --participants 4 --out my_study`
    - `vrcomfort simulate carnegie_2015 --participants 200 --no-frames --out answers`
    - `vrcomfort simulate carnegie_2015 -n 8 --exposure-s 4 --refresh-hz 4 --out my_study`
    """
    outcomes = simulate_study(
        load_protocol(protocol).spoken(language),
        participants=participants,
        out=out,
        seed=seed,
        playback_options=(parse_size(size), open_trace(trace) if trace else None, refresh_hz),
        exposure_s=exposure_s,
        group_readable=group_readable,
        frames=frames,
        quiet=quiet,
    )
    for outcome in outcomes:
        console(quiet).print(outcome_sentence(outcome, out))
    if outcomes[-1].status == "aborted":
        warn("the same command goes on where this was stopped")
        raise KeyboardInterrupt  # as the session has heard it, which then closed its files
    if lost := [sentence for outcome in outcomes for sentence in outcome.lost]:
        raise InputError("; ".join(lost))


def simulate_study(
    protocol: Protocol,
    *,
    participants: int,
    out: Path,
    seed: int | None,
    playback_options: tuple[tuple[int, int], Any, float | None],
    exposure_s: float | None,
    group_readable: bool = False,
    frames: bool = True,
    quiet: bool,
) -> list[RunOutcome]:
    """Run all sessions of simulated participants P01, P02, … that are left.

    Stops where one is aborted. An interrupted session is continued.

    Raises
    ------
    InputError
        If none is left, a person was in one, one was begun with other options, or the folder
        holds another study.
    """
    from vrcomfort.design import build_design
    from vrcomfort.records import open_study, told_of_the_other_kind

    size_px, trace, refresh_hz = playback_options
    if not frames and (trace or refresh_hz):
        raise InputError("--no-frames plays no head trace; leave --trace and --refresh-hz out")
    if frames and protocol.simulation.eyes is None:
        require_recorded_gaze(protocol.conditions, trace)
    playback = PlaybackSetup(size_px, protocol.headset.ipd_m, trace, refresh_hz)
    setup = StudySetup(
        protocol, out, playback, seed, exposure_s, durability="session_end", frames=frames
    )
    resume_check = ResumeCheck(protocol, playback if frames else None, exposure_s)
    kept_seed = open_study(out, protocol, seed=seed, group_readable=group_readable)
    design = build_design(protocol, seed=kept_seed)
    outcomes: list[RunOutcome] = []
    ends = {name: resume_check.ends(out, name) for name in _names(out, participants)}
    if told := told_of_the_other_kind(out, simulated=True):
        warn(told)
    if protocol.ratings and protocol.shown_s(exposure_s) < protocol.longest_s:
        warn(
            f"exposures of {protocol.longest_s:g} s are shortened to {exposure_s:g} s, and their "
            "ratings come at shortened times, or are missed between frames; --no-frames without "
            "--exposure-s has them at the protocol's times"
        )
    with progress_bar("simulated", participants, quiet=quiet, unit="participants") as advance:
        for number, (name, ended) in enumerate(ends.items(), start=1):
            if not _is_over(out, name, ended, design.sessions):
                outcomes.append(_simulate_one(setup, out, name, design.imagined(number)))
            advance()
            if outcomes and outcomes[-1].status == "aborted":
                break
    if not outcomes:
        message = f"all sessions of all {participants} participants are recorded"
        raise InputError(f"{message}; choose another --out, or more --participants", file=out)
    return outcomes


def _names(study: Path, participants: int) -> list[str]:
    """Return P01, P02, …, with as many digits as the study has already."""
    from vrcomfort.records import read_participants

    there = [row.participant for row in read_participants(study)]
    digits = len(there[0]) - 1 if there else max(2, len(str(participants)))
    return [f"P{number:0{digits}d}" for number in range(1, participants + 1)]


def _simulate_one(
    setup: StudySetup, study: Path, name: str, covariates: dict[str, str]
) -> RunOutcome:
    from vrcomfort import session
    from vrcomfort.records import unfinished_sessions

    kind, resume = RespondentKind.SIMULATED, bool(unfinished_sessions(study, name))
    with setup.open_enrolment(name, None, kind, resume=resume, covariates=covariates) as enrolment:
        return session.run(enrolment, setup.settings(enrolment, kind))


def _is_over(study: Path, name: str, ended: list[str], sessions: int) -> bool:
    """Return whether a participant has nothing left to simulate, and see that the study says so."""
    from vrcomfort.records import note_end, read_participants

    note_end(study, name, sessions)
    known = {row.participant: row.status for row in read_participants(study)}.get(name)
    over = ended.count("completed") + ended.count("ended") == sessions
    return over or known in {"withdrawn", "excluded"}
