"""`run` and `simulate`: participants go through a protocol and everything is recorded."""

from __future__ import annotations

from contextlib import ExitStack
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.cli.desktop import desktop_lab
from vrcomfort.cli.live import live_lab
from vrcomfort.cli.terminal import (
    ProtocolArgument,
    Quiet,
    RefreshRate,
    Size,
    StudySeed,
    complain,
    console,
    parse_size,
    progress_bar,
    warn,
)
from vrcomfort.cli.wiring import PlaybackIn, describe_machine, make_renderer, open_trace
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.cli.live import LiveLab
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.render.scene_data import Scene
    from vrcomfort.respondent import Respondent
    from vrcomfort.session import Outcome, Progress

EXIT_RUNTIME_LOST = 3
EXIT_ABORTED = 130

Study = Annotated[Path, typer.Option("--out", help="The study folder; made if it is not there.")]
TraceOption = Annotated[
    Path | None, typer.Option(help="Head trace (CSV); without it, the walk shipped with the scene.")
]
ExposureOption = Annotated[
    float | None, typer.Option(help="Shorten every exposure to this; recorded.", min=0.001)
]


class HeadsetKind(StrEnum):
    """Headsets that a session can run on."""

    PLAYBACK = "playback"
    OPENXR = "openxr"
    DESKTOP = "desktop"


class RespondentKind(StrEnum):
    """Who answers."""

    SIMULATED = "simulated"
    TERMINAL = "terminal"
    PANEL = "panel"


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(run)
    app.command()(simulate)


def run(
    protocol: ProtocolArgument,
    participant: Annotated[str, typer.Option(help="Letters and digits, for example P01.")],
    out: Study,
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
    playback = PlaybackIn(
        parse_size(size or "640x800"),
        study.headset.ipd_m,
        open_trace(trace) if trace else None,
        refresh_hz,
        real_time=respondent is not RespondentKind.SIMULATED,
    )
    live = None
    number = session or next_session(out, participant)
    if resume:
        seed, exposure_s = _as_before(out, participant, number, seed, exposure_s)
    with ExitStack() as owned:
        if headset is HeadsetKind.OPENXR:
            live = owned.enter_context(
                live_lab(
                    study,
                    size_px=parse_size(size) if size else None,
                    refresh_hz=refresh_hz,
                    monado_trace=monado_trace,
                    answers=monado_answers,
                    mirror=mirror,
                )
            )
        elif headset is HeadsetKind.DESKTOP:
            size_px = parse_size(size) if size else None
            live = owned.enter_context(desktop_lab(study, size_px=size_px, one_eye=one_eye))
        lab = _Lab(study, out, playback, seed, exposure_s, live)
        bars = owned.enter_context(_SessionBars(quiet))
        kind = respondent or lab.usual_respondent
        try:
            outcome = lab.run(participant, kind, [number], bars.tell, resume=resume)
        except RuntimeLostError as error:
            complain(str(error))
            raise typer.Exit(EXIT_RUNTIME_LOST) from error
    for warning in outcome.warnings:
        warn(warning)
    console(quiet).print(_sentence(outcome, out))
    if outcome.status == "aborted":
        raise typer.Exit(EXIT_ABORTED)


def simulate(
    protocol: ProtocolArgument,
    participants: Annotated[int, typer.Option("--participants", "-n", min=1, max=10_000)],
    out: Study,
    seed: StudySeed = None,
    trace: TraceOption = None,
    size: Size = "320x400",
    refresh_hz: RefreshRate = None,
    exposure_s: ExposureOption = None,
    quiet: Quiet = False,
) -> None:
    """Take simulated participants through all their sessions, every frame rendered.

    - `vrcomfort simulate smoke --participants 4 --out my_study`
    - `vrcomfort simulate carnegie_2015 -n 8 --exposure-s 4 --refresh-hz 4 --out my_study`
    """
    outcomes = simulate_study(
        load_protocol(protocol),
        participants=participants,
        out=out,
        seed=seed,
        playback_options=(parse_size(size), open_trace(trace) if trace else None, refresh_hz),
        exposure_s=exposure_s,
        quiet=quiet,
    )
    for outcome in outcomes:
        console(quiet).print(_sentence(outcome, out))
    if outcomes[-1].status == "aborted":
        raise typer.Exit(EXIT_ABORTED)


def simulate_study(
    protocol: Protocol,
    *,
    participants: int,
    out: Path,
    seed: int | None,
    playback_options: tuple[tuple[int, int], Any, float | None],
    exposure_s: float | None,
    quiet: bool,
) -> list[Outcome]:
    """Run all sessions of simulated participants P01, P02, …; stops if one is aborted."""
    size_px, trace, refresh_hz = playback_options
    outcomes: list[Outcome] = []
    lab = _Lab(
        protocol,
        out,
        PlaybackIn(size_px, protocol.headset.ipd_m, trace, refresh_hz),
        seed,
        exposure_s,
    )
    digits = max(2, len(str(participants)))
    with progress_bar("participants", participants, quiet=quiet) as advance:
        for number in range(1, participants + 1):
            name = f"P{number:0{digits}d}"
            outcomes.append(lab.run(name, RespondentKind.SIMULATED, None, lambda _: None))
            advance()
            if outcomes[-1].status == "aborted":
                break
    return outcomes


class _Lab:
    """One study's protocol, folder, headset and renderer; scenes are loaded once."""

    def __init__(
        self,
        protocol: Protocol,
        study: Path,
        playback: PlaybackIn,
        seed: int | None,
        exposure_s: float | None,
        live: LiveLab | None = None,
    ) -> None:
        self._protocol = protocol
        self._study = study
        self._playback = playback
        self._seed = seed
        self._exposure_s = exposure_s
        self._live = live
        self._rendering: tuple[StereoRenderer, Machine] | None = None
        if live is not None:
            self._rendering = live.renderer, live.machine
        self._load_scene = lru_cache(maxsize=None)(_load_scene)

    @property
    def usual_respondent(self) -> RespondentKind:
        """Return who answers where nothing else is said."""
        return RespondentKind.TERMINAL if self._live is None else RespondentKind.PANEL

    def run(
        self,
        participant: str,
        kind: RespondentKind,
        sessions: list[int] | None,
        tell: Any,
        *,
        resume: bool = False,
    ) -> Outcome:
        """Run sessions of one participant."""
        from vrcomfort import session
        from vrcomfort.records import open_study

        seed = open_study(self._study, self._protocol, seed=self._seed)
        if self._rendering is None:
            renderer = make_renderer(self._playback.size_px)
            self._rendering = renderer, describe_machine(renderer, self._protocol)
        renderer, machine = self._rendering
        simulated = kind is RespondentKind.SIMULATED
        return session.run(
            self._protocol,
            participant,
            study=self._study,
            load_scene=self._load_scene,
            headset_for=self._live.headset_for if self._live else self._playback,
            renderer=renderer,
            respondent=self._respondent(kind, participant, seed),
            clock=session.VirtualClock() if simulated else session.WallClock(),
            seed=seed,
            sessions=sessions,
            exposure_s=self._exposure_s,
            resume=resume,
            machine=machine,
            progress=tell,
        )

    def _respondent(self, kind: RespondentKind, participant: str, seed: int) -> Respondent:
        from vrcomfort.respondent import SimulatedRespondent, TerminalRespondent

        if kind is RespondentKind.SIMULATED:
            settings = self._protocol.simulation
            return SimulatedRespondent(settings, participant=participant, seed=seed)
        if kind is RespondentKind.PANEL:
            if self._live is None:
                raise InputError(
                    "--respondent panel needs a headset to answer in: --headset openxr "
                    "or --headset desktop"
                )
            return self._live.panel
        return TerminalRespondent(console())


def next_session(study: Path, participant: str) -> int:
    """Return the number of the first session that is not recorded to its end."""
    from vrcomfort.records import recorded_sessions, unfinished_sessions

    done = set(recorded_sessions(study, participant))
    done -= set(unfinished_sessions(study, participant))
    return next(number for number in range(1, len(done) + 2) if number not in done)


def _as_before(
    study: Path, participant: str, session: int, seed: int | None, exposure_s: float | None
) -> tuple[int | None, float | None]:
    """Return the seed and the exposure of an interrupted session; those given if there is none."""
    from vrcomfort.records import read_manifest, session_folder, unfinished_sessions

    if session not in unfinished_sessions(study, participant):
        return seed, exposure_s
    manifest = read_manifest(session_folder(study, participant, session))
    return manifest["seed"], exposure_s or manifest["exposure_s"]


def _load_scene(source: str) -> Scene:
    from vrcomfort.render.gltf import load_scene

    scene = load_scene(source)
    for warning in scene.warnings:
        warn(warning)
    return scene


class _SessionBars(ExitStack):
    """A bar for each exposure and rest; the questionnaires speak for themselves."""

    def __init__(self, quiet: bool) -> None:
        super().__init__()
        self._quiet = quiet
        self._title = ""
        self._done = 0.0

    def tell(self, progress: Progress) -> None:
        """Show how far a step of the session has come."""
        timed = progress.step in {"training", "exposure", "rest"}
        title = f"{progress.step} {progress.trial or ''}".strip() if timed else ""
        if title != self._title:
            self.close()
            self._title, self._done = title, 0.0
            if title:
                bar = progress_bar(title, round(progress.total), quiet=self._quiet)
                self._advance = self.enter_context(bar)
        if title:
            self._advance(progress.done - self._done)
            self._done = progress.done


def _sentence(outcome: Outcome, out: Path) -> str:
    sessions = ", ".join(map(str, outcome.sessions))
    note = f" ({outcome.note})" if outcome.note else ""
    return (
        f"{outcome.participant} ({outcome.sequence}): session {sessions} recorded, "
        f"{outcome.status}{note}; {out / f'sub-{outcome.participant}'}"
    )
