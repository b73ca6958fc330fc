"""`run`: a participant goes through a protocol and everything is recorded."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.cli.run_desktop import desktop_lab
from vrcomfort.cli.run_headset import HeadsetKind, require_meaning, usual_respondent
from vrcomfort.cli.study_setup import RespondentKind, SessionBars, StudyLab, sentence
from vrcomfort.cli.run_openxr import live_lab, rehearse, tracks_eyes
from vrcomfort.cli.terminal import (
    ExposureOption,
    ProtocolArgument,
    Quiet,
    RefreshRate,
    StudyFolder,
    StudySeed,
    TraceOption,
    complain,
    console,
    parse_size,
    warn,
)
from vrcomfort.cli.playback import (
    PlaybackIn,
    open_trace,
    require_eye_tracker,
    require_recorded_gaze,
)
from vrcomfort.errors import RuntimeLostError
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.cli.run_openxr import LiveLab
    from vrcomfort.session import Outcome
    from vrcomfort.session.rehearsal import Rehearsal

EXIT_RUNTIME_LOST = 3


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(run)


def run(
    protocol: ProtocolArgument,
    participant: Annotated[str, typer.Option(help="Letters and digits, for example P01.")],
    out: StudyFolder,
    headset: Annotated[HeadsetKind, typer.Option(help="What shows it.")] = HeadsetKind.PLAYBACK,
    trace: TraceOption = None,
    monado_trace: Annotated[
        Path | None, typer.Option(help="Rehearse: a Monado runtime whose head follows this trace.")
    ] = None,
    monado_answers: Annotated[
        Path | None, typer.Option(help="What its controllers answer: whole numbers, in order.")
    ] = None,
    respondent: Annotated[
        RespondentKind | None,
        typer.Option(help="Who answers; without it, the panel in a headset, else the terminal."),
    ] = None,
    session: Annotated[
        int | None, typer.Option(help="Session number; without it, the next one.", min=1)
    ] = None,
    seed: StudySeed = None,
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="Pixels of one eye's image: 640x800, or the headset's."),
    ] = None,
    refresh_hz: RefreshRate = None,
    exposure_s: ExposureOption = None,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Continue an interrupted session at its next exposure."),
    ] = False,
    mirror: Annotated[
        bool, typer.Option("--mirror", help="OpenXR: show the operator what the participant sees.")
    ] = False,
    one_eye: Annotated[
        bool, typer.Option("--one-eye", help="Desktop: show the left eye alone, not both.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Take one participant through one session.

    Answers are on disk as soon as they are given. Ctrl-C stops: everything is kept, and --resume
    continues. The exit code is 130 after Ctrl-C, 3 where the headset's runtime went away.

    - `vrcomfort run smoke --participant P01 --out my_study`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --respondent simulated`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --headset openxr --mirror`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --headset desktop`
    """
    study = load_protocol(protocol)
    options = {
        "--trace": trace,
        "--refresh-hz": refresh_hz,
        "--monado-trace": monado_trace,
        "--monado-answers": monado_answers,
        "--mirror": mirror,
        "--one-eye": one_eye,
    }
    require_meaning(headset, respondent, options)
    size_px = parse_size(size) if size else None
    playback = PlaybackIn(
        size_px or (640, 800),
        study.headset.ipd_m,
        open_trace(trace) if trace else None,
        refresh_hz,
        real_time=respondent is not RespondentKind.SIMULATED,
    )
    lab = StudyLab(study, out, playback, seed, exposure_s)
    kind = respondent or usual_respondent(headset)
    with ExitStack() as owned:
        rehearsal = owned.enter_context(rehearse(monado_trace, monado_answers))
        _require_gaze(headset, study, playback)
        numbers = [session or next_session(out, participant)]
        place = owned.enter_context(lab.reserve(participant, numbers, kind, resume=resume))
        live = _connect(owned, headset, study, size_px, options, rehearsal)
        bars = owned.enter_context(SessionBars(quiet))
        try:
            outcome = lab.run(place, kind, bars.tell, live)
        except RuntimeLostError as error:
            complain(str(error))
            raise typer.Exit(EXIT_RUNTIME_LOST) from error
    _tell(outcome, out, quiet)


def _require_gaze(headset: HeadsetKind, protocol: Protocol, playback: PlaybackIn) -> None:
    """Refuse a protocol whose focus needs to know where the eyes look, and cannot."""
    if headset is HeadsetKind.PLAYBACK:
        require_recorded_gaze(protocol.conditions, playback.trace)
    else:
        openxr = headset is HeadsetKind.OPENXR
        require_eye_tracker(protocol.conditions, lambda: openxr and tracks_eyes())


def _connect(
    owned: ExitStack,
    headset: HeadsetKind,
    protocol: Protocol,
    size_px: tuple[int, int] | None,
    options: dict[str, Any],
    rehearsal: Rehearsal | None,
) -> LiveLab | None:
    if headset is HeadsetKind.OPENXR:
        lab = live_lab(
            protocol,
            size_px=size_px,
            refresh_hz=options["--refresh-hz"],
            rehearsal=rehearsal,
            mirror=options["--mirror"],
        )
        return owned.enter_context(lab)
    if headset is HeadsetKind.DESKTOP:
        one_eye = options["--one-eye"]
        return owned.enter_context(desktop_lab(protocol, size_px=size_px, one_eye=one_eye))
    return None


def _tell(outcome: Outcome, out: Path, quiet: bool) -> None:
    for warning in outcome.warnings:
        warn(warning)
    console(quiet).print(sentence(outcome, out))
    if outcome.status == "aborted":
        raise KeyboardInterrupt  # as the session has heard it, which then closed its files


def next_session(study: Path, participant: str) -> int:
    """Return the number of the first session that is not recorded to its end."""
    from vrcomfort.records import recorded_sessions, unfinished_sessions

    done = set(recorded_sessions(study, participant))
    done -= set(unfinished_sessions(study, participant))
    return next(number for number in range(1, len(done) + 2) if number not in done)
