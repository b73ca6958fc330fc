"""`run`: one participant through one session of a protocol."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.api.playback import (
    PlaybackSetup,
    open_trace,
    require_eye_tracker,
    require_recorded_gaze,
)
from vrcomfort.api.study_setup import RespondentKind, StudySetup, outcome_sentence, require_wording
from vrcomfort.cli.headset_setup import desktop_setup, openxr_setup, rehearse, tracks_eyes
from vrcomfort.cli.options import (
    CovariateOption,
    ExposureOption,
    GroupReadable,
    LanguageOption,
    ProtocolArgument,
    Quiet,
    RefreshRate,
    StudyFolder,
    StudySeed,
    TraceOption,
    TrustOption,
    declared_by,
    parse_covariates,
    parse_size,
    typed_words,
)
from vrcomfort.cli.session_devices import open_console, open_outlets, open_speaker
from vrcomfort.cli.terminal import (
    ask_for_code,
    ask_to_go_on,
    complain,
    console,
    dialogue,
    progress_bar,
    warn,
)
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.headset.watchdog import EXIT_RUNTIME_LOST, Watchdog
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.api.study_setup import HeadsetSetup
    from vrcomfort.cli.session_devices import ConsoleSetup
    from vrcomfort.operator_interface import SessionProgress
    from vrcomfort.records.consents import Given
    from vrcomfort.respondent import Respondent
    from vrcomfort.session import OpenEnrolment, RunOutcome, SessionSettings
    from vrcomfort.session.rehearsal import Rehearsal


class HeadsetKind(StrEnum):
    """Headsets that a session can run on."""

    PLAYBACK = "playback"
    OPENXR = "openxr"
    DESKTOP = "desktop"


PLAYBACK, OPENXR, DESKTOP = HeadsetKind


class SharpEyes(StrEnum):
    """Eyes that see sharp in the headset."""

    BOTH = "both"
    LEFT = "left"
    RIGHT = "right"
    NEITHER = "neither"


MEANT_FOR: Mapping[str, tuple[HeadsetKind, ...]] = {
    "trace": (PLAYBACK,),
    "refresh_hz": (PLAYBACK, OPENXR),
    "monado_trace": (OPENXR,),
    "monado_answers": (OPENXR,),
    "mirror": (OPENXR,),
    "no_preflight": (OPENXR, DESKTOP),
    "one_eye": (DESKTOP,),
}
"""Field of `RunOptions` → headsets that it has a meaning for; others have one for all."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Arguments and options of `run`: each field declares one."""

    protocol: ProtocolArgument
    participant: Annotated[
        str, typer.Option(help="Participant id: letters and digits, such as P01.")
    ]
    out: StudyFolder
    headset: Annotated[HeadsetKind, typer.Option(help="Headset to use.")] = HeadsetKind.PLAYBACK
    trace: TraceOption = None
    monado_trace: Annotated[
        Path | None,
        typer.Option(help="Rehearse with a Monado runtime whose head follows this trace."),
    ] = None
    monado_answers: Annotated[
        Path | None, typer.Option(help="Answers of its controllers: whole numbers, in order.")
    ] = None
    respondent: Annotated[
        RespondentKind | None,
        typer.Option(
            help="Source of answers; by default the panel in a headset, else the terminal."
        ),
    ] = None
    session: Annotated[
        int | None, typer.Option(help="Session number; by default the next.", min=1)
    ] = None
    seed: StudySeed = None
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="Pixels of one eye's image: 640x800, or the headset's."),
    ] = None
    refresh_hz: RefreshRate = None
    exposure_s: ExposureOption = None
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Continue an interrupted session at its next exposure."),
    ] = False
    mirror: Annotated[
        bool, typer.Option("--mirror", help="OpenXR: mirror the participant's view in a window.")
    ] = False
    one_eye: Annotated[bool, typer.Option("--one-eye", help="Desktop: show the left eye only.")] = (
        False
    )
    with_console: Annotated[
        bool,
        typer.Option(
            "--console", help="Control the session from a page on this machine; prints its address."
        ),
    ] = False
    ipd_mm: Annotated[
        float | None,
        typer.Option(
            help="Participant's interpupillary distance, in mm; recorded.", min=40, max=85
        ),
    ] = None
    sees_sharp: Annotated[
        SharpEyes | None,
        typer.Option(help="Eyes with which the participant reports to see sharp; recorded."),
    ] = None
    other_stimulus: Annotated[
        bool,
        typer.Option(
            "--other-stimulus",
            help="Continue a study whose sessions had another stimulus version; recorded.",
        ),
    ] = False
    no_preflight: Annotated[
        bool,
        typer.Option("--no-preflight", help="Continue without today's preflight; recorded."),
    ] = False
    lsl: Annotated[
        bool,
        typer.Option("--lsl", help="Send markers, ratings, head and gaze to LabStreamingLayer."),
    ] = False
    ttl: Annotated[
        str | None,
        typer.Option(
            metavar="PORT", help="Serial port for a byte at the start and end of exposures."
        ),
    ] = None
    covariate: CovariateOption = None
    consent: Annotated[
        str | None,
        typer.Option(
            metavar="VERSION", help="Version of the form that the participant has signed."
        ),
    ] = None
    consented_on: Annotated[
        str | None, typer.Option(metavar="DAY", help="Date of the consent; by default today.")
    ] = None
    language: LanguageOption = None
    trust: TrustOption = None
    group_readable: GroupReadable = False
    quiet: Quiet = False

    @property
    def answering(self) -> RespondentKind:
        """Return the respondent; by default the panel in a headset, else an experimenter."""
        if self.respondent is not None:
            return self.respondent
        if self.headset is not PLAYBACK:
            return RespondentKind.PANEL
        return RespondentKind.CONSOLE if self.with_console else RespondentKind.TERMINAL

    @property
    def simulated(self) -> bool:
        """Return whether a simulated participant answers."""
        return self.answering is RespondentKind.SIMULATED

    @property
    def size_px(self) -> tuple[int, int] | None:
        """Return (width, height) of one eye's image; None is the headset's own."""
        return parse_size(self.size) if self.size else None

    def require_meaning(self) -> None:
        """Refuse options, and a respondent, that mean nothing for the headset.

        Raises
        ------
        InputError
            Names the first of them, and the headsets that it is for.
        """
        for name, headsets in MEANT_FOR.items():
            if getattr(self, name) not in {None, False}:
                self._require(f"--{name.replace('_', '-')}", headsets)
        if self.respondent is RespondentKind.PANEL:
            self._require("--respondent panel", (OPENXR, DESKTOP))

    def _require(self, option: str, headsets: tuple[HeadsetKind, ...]) -> None:
        if self.headset not in headsets:
            places = " or ".join(f"--headset {each}" for each in headsets)
            raise InputError(
                f"{option} is for {places}; leave it out with --headset {self.headset}"
            )

    def require_console(self) -> None:
        """Refuse answers on a console that is not asked for.

        Raises
        ------
        InputError
            Says what to type.
        """
        if self.answering is RespondentKind.CONSOLE and not self.with_console:
            raise InputError("--respondent console needs --console, where answers are entered")

    def require_gaze(self, protocol: Protocol, playback: PlaybackSetup) -> None:
        """Refuse conditions that need gaze, where there is none."""
        if self.headset is PLAYBACK:
            require_recorded_gaze(protocol.conditions, playback.trace)
        else:
            openxr = self.headset is OPENXR
            require_eye_tracker(protocol.conditions, lambda: openxr and tracks_eyes())

    def require_dial(self, protocol: Protocol) -> None:
        """Refuse adjustments and sliders where the headset has no dial for them."""
        dials = (*protocol.adjustments, *protocol.sliders)
        if dials and self.headset is PLAYBACK and not self.simulated:
            name = dials[0].name
            message = f"participants turn the dial `{name}`, and the playback headset has none"
            remedy = "give --headset openxr or desktop, or --respondent simulated"
            raise InputError(f"{message}; {remedy}")

    def spoken_protocol(self) -> Protocol:
        """Load the protocol in the participant's language."""
        protocol = load_protocol(self.protocol)
        return protocol.spoken(self.language or self._last_language(protocol))

    def _last_language(self, protocol: Protocol) -> str | None:
        """Return the language of the participant's last session, if the protocol still has it."""
        from vrcomfort.records import read_manifest, recorded_sessions, session_folder

        for number in reversed(recorded_sessions(self.out, self.participant)):
            manifest = read_manifest(session_folder(self.out, self.participant, number))
            language = manifest.get("language")
            return language if language in protocol.languages else None
        return None

    def playback(self, protocol: Protocol) -> PlaybackSetup:
        """Return the playback headset, which stands in where there is no live one."""
        return PlaybackSetup(
            self.size_px or (640, 800),
            protocol.headset.ipd_m,
            open_trace(self.trace, note=warn) if self.trace else None,
            self.refresh_hz,
            real_time=not self.simulated,
        )

    @contextmanager
    def connect(
        self, protocol: Protocol, rehearsal: Rehearsal | None, watchdog: Watchdog | None
    ) -> Iterator[HeadsetSetup | None]:
        """Connect to the live headset, or open its window; None of the playback headset."""
        if self.headset is OPENXR:
            with openxr_setup(
                protocol,
                size_px=self.size_px,
                refresh_hz=self.refresh_hz,
                rehearsal=rehearsal,
                mirror=self.mirror,
                watchdog=watchdog,
            ) as setup:
                yield setup
        elif self.headset is DESKTOP:
            with desktop_setup(protocol, size_px=self.size_px, one_eye=self.one_eye) as setup:
                yield setup
        else:
            yield None

    def open_enrolment(self, study: StudySetup) -> AbstractContextManager[OpenEnrolment]:
        """Return the participant's open enrolment in one session: the next, or that asked for."""
        return study.open_enrolment(
            self.participant,
            [self.session or next_session(self.out, self.participant)],
            self.answering,
            resume=self.resume,
            covariates=parse_covariates(self.covariate),
            consent=self._consent(),
        )

    def _consent(self) -> Given | None:
        from vrcomfort.records.consents import Given

        if self.consent is None and self.consented_on is not None:
            raise InputError("--consented-on needs --consent VERSION: what was consented to")
        return None if self.consent is None else Given(self.consent, self.consented_on)

    def open_respondent(
        self, protocol: Protocol, headset: HeadsetSetup | None, console: ConsoleSetup | None
    ) -> Respondent | None:
        """Return the person, by where they answer; None of a simulated participant."""
        from vrcomfort.respondent import TerminalRespondent

        kind = self.answering
        if kind is RespondentKind.SIMULATED:
            return None
        if kind is RespondentKind.TERMINAL:
            return TerminalRespondent(dialogue())
        if console is not None and kind is RespondentKind.CONSOLE:
            return console.respondent(headset.screen if headset else None, protocol.words)
        if headset is None:
            raise InputError("--respondent panel needs a headset to answer in")
        return headset.panel


class SessionBars(ExitStack):
    """A bar for each exposure and rest; the questionnaires speak for themselves."""

    def __init__(self, quiet: bool) -> None:
        super().__init__()
        self._quiet = quiet
        self._title = ""
        self._done = 0.0

    def tell(self, progress: SessionProgress) -> None:
        """Show the progress of a step, and notices to the operator."""
        if progress.step == "notice":
            warn(progress.text)
            return
        timed = progress.step in {"training", "exposure", "rest"}
        title = f"{progress.step} {progress.trial or ''}".strip() if timed else ""
        if title != self._title:
            self.close()
            self._title, self._done = title, 0.0
            if title:
                bar = progress_bar(title, progress.total, quiet=self._quiet, unit="s")
                self._advance = self.enter_context(bar)
        if title:
            self._advance(progress.done - self._done)
            self._done = progress.done


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(run)


@declared_by(RunOptions)
def run(ctx: typer.Context, options: RunOptions) -> None:
    """Run one session of one participant.

    Answers are on disk as soon as they are given. Ctrl-C, SIGTERM and a closed terminal stop:
    everything is kept, and --resume continues. The exit code is 130 after Ctrl-C (143 after
    SIGTERM, 129 after SIGHUP), 3 where the headset's runtime went away.

    - `vrcomfort run smoke --participant P01 --out my_study`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --respondent simulated`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --headset openxr --mirror`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --headset desktop`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --headset openxr --console`
    """
    protocol = options.spoken_protocol()
    options.require_meaning()
    playback = options.playback(protocol)
    study = StudySetup(
        protocol,
        options.out,
        playback,
        options.seed,
        options.exposure_s,
        group_readable=options.group_readable,
        trust=options.trust,
        ask=ask_for_code,
        note=warn,
    )
    options.require_console()
    require_wording(protocol, options.answering, in_headset=options.headset is not PLAYBACK)
    from vrcomfort.frame import STIMULUS_VERSION
    from vrcomfort.records.apparatus import require_stimulus

    with ExitStack() as owned:
        # First in, last out: a runtime may hang while the rest is being closed.
        watchdog = None
        if options.headset is OPENXR:
            watchdog = owned.enter_context(Watchdog(warn, go_on=how_to_go_on(ctx)))
        rehearsal = owned.enter_context(
            rehearse(options.monado_trace, options.monado_answers, watchdog)
        )
        # Refused before the enrolment, which is the first to write.
        options.require_gaze(protocol, playback)
        options.require_dial(protocol)
        if not options.other_stimulus:
            require_stimulus(options.out, STIMULUS_VERSION)
        enrolment = owned.enter_context(options.open_enrolment(study))
        _tell_of_the_other_kind(options.out, simulated=options.simulated)
        headset = owned.enter_context(options.connect(protocol, rehearsal, watchdog))
        from vrcomfort.records.apparatus import differences_in, facts_now
        from vrcomfort.session import headset_facts
        from vrcomfort.session import run as run_sessions

        try:
            settings = _settings(owned, options, protocol, study, enrolment, headset)
            shown_by = headset.headset if headset else playback.at_start(protocol)
            now = facts_now(settings.machine, headset_facts(shown_by))
            told = _differences_before(enrolment, now)
            preflight = _preflight(options, protocol, now)
            settings = replace(settings, preflight=preflight, notices=told)
            outcome = run_sessions(enrolment, settings)
            if outcome.status == "aborted":
                warn(how_to_go_on(ctx))  # now: the runtime may hang as it is left
        except RuntimeLostError as error:
            complain(str(error))
            warn(how_to_go_on(ctx))
            raise typer.Exit(EXIT_RUNTIME_LOST) from error
    for sentence in differences_in(options.out):  # of facts that were not known before
        if sentence not in told:
            warn(sentence)
    _tell(outcome, options.out, options.quiet)
    if outcome.status == "aborted":
        raise KeyboardInterrupt  # as the session has heard it, which then closed its files
    if outcome.lost:
        raise InputError("; ".join(outcome.lost))


def _tell_of_the_other_kind(study: Path, *, simulated: bool) -> None:
    from vrcomfort.records import mixed_kinds_notice

    if told := mixed_kinds_notice(study, simulated=simulated):
        warn(told)


def _preflight(
    options: RunOptions, protocol: Protocol, now: Mapping[str, Any]
) -> dict[str, str] | None:
    """Return the preflight for the manifest; without one that holds, ask whether to go on.

    Raises
    ------
    InputError
        If the operator would rather do it first.
    """
    from vrcomfort.records.preflights import read_preflight, why_again

    if options.headset is PLAYBACK or options.simulated or options.monado_trace is not None:
        return None  # nobody wears anything
    try:
        done = read_preflight(options.out)
        why = why_again(done, protocol_sha256=protocol.sha256, headset=options.headset, run=now)
    except InputError as error:
        done, why = None, str(error)
    if done is not None and not why:
        return {"at": done.at, "outcome": done.outcome}
    if not options.no_preflight:
        words = [
            "preflight",
            options.protocol,
            "--out",
            str(options.out),
            "--headset",
            options.headset,
        ]
        remedy = f"to do it, type: vrcomfort {shlex.join(words)}"
        if not ask_to_go_on(f"{why}; {remedy}"):
            raise InputError(f"{why}; {remedy}, or run again with --no-preflight")
    return {"without": why}


def _differences_before(enrolment: OpenEnrolment, now: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the differences between this session's apparatus and that of earlier ones."""
    from vrcomfort.records.apparatus import differences_in

    who = {"participant": enrolment.participant, "session": enrolment.numbers[0]}
    return tuple(differences_in(enrolment.study, {**who, **now}))


def _settings(
    owned: ExitStack,
    options: RunOptions,
    protocol: Protocol,
    study: StudySetup,
    enrolment: OpenEnrolment,
    headset: HeadsetSetup | None,
) -> SessionSettings:
    """Open the devices beside the session, and return its settings."""
    simulated = options.simulated
    outlet = owned.enter_context(
        open_outlets(
            protocol.name,
            options.participant,
            lsl=options.lsl,
            ttl=options.ttl,
            simulated=simulated,
        )
    )
    speaker = None if simulated else owned.enter_context(open_speaker(protocol))
    console = owned.enter_context(open_console()) if options.with_console else None
    progress = console.progress if console else owned.enter_context(SessionBars(options.quiet)).tell
    person = options.open_respondent(protocol, headset, console)
    operators = console.operators if console else None
    settings = study.settings(enrolment, person, headset, operators)
    return replace(
        settings,
        ipd_measured_m=None if options.ipd_mm is None else options.ipd_mm / 1000,
        sees_sharp=None if options.sees_sharp is None else str(options.sees_sharp),
        outlet=outlet,
        speaker=speaker or settings.speaker,
        progress=progress,
    )


def _tell(outcome: RunOutcome, out: Path, quiet: bool) -> None:
    for warning in outcome.warnings:
        warn(warning)
    console(quiet).print(outcome_sentence(outcome, out))


def how_to_go_on(ctx: typer.Context) -> str:
    """Return the words that take up the session again: the same, with --resume."""
    words = typed_words(ctx)
    return f"to go on, type: {words}" + ("" if ctx.params["resume"] else " --resume")


def next_session(study: Path, participant: str) -> int:
    """Return the number of the first session that is not recorded to its end."""
    from vrcomfort.records import recorded_sessions, unfinished_sessions

    done = set(recorded_sessions(study, participant))
    done -= set(unfinished_sessions(study, participant))
    return next(number for number in range(1, len(done) + 2) if number not in done)
