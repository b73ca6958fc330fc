"""`run` and `simulate`: participants go through a protocol and everything is recorded."""

from __future__ import annotations

from contextlib import ExitStack
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.cli.terminal import (
    ProtocolArgument,
    Quiet,
    RefreshRate,
    Size,
    StudySeed,
    console,
    parse_size,
    progress_bar,
    warn,
)
from vrcomfort.cli.wiring import PlaybackIn, describe_machine, make_renderer, open_trace
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.render.scene_data import Scene
    from vrcomfort.respondent import Respondent
    from vrcomfort.session import Outcome, Progress

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


class RespondentKind(StrEnum):
    """Who answers."""

    SIMULATED = "simulated"
    TERMINAL = "terminal"


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
    respondent: Annotated[
        RespondentKind, typer.Option(help="Who answers.")
    ] = RespondentKind.TERMINAL,
    session: Annotated[
        int | None, typer.Option(help="Session number; without it, the next one.", min=1)
    ] = None,
    seed: StudySeed = None,
    size: Size = "640x800",
    refresh_hz: RefreshRate = None,
    exposure_s: ExposureOption = None,
    quiet: Quiet = False,
) -> None:
    """Take one participant through one session.

    Answers are on disk as soon as they are given. Ctrl-C stops: everything is kept.

    - `vrcomfort run smoke --participant P01 --out my_study`
    - `vrcomfort run carnegie_2015 --participant P01 --out my_study --respondent simulated`
    """
    del headset  # one kind so far
    study = load_protocol(protocol)
    playback = PlaybackIn(
        parse_size(size),
        study.headset.ipd_m,
        open_trace(trace) if trace else None,
        refresh_hz,
        real_time=respondent is RespondentKind.TERMINAL,
    )
    lab = _Lab(study, out, playback, seed, exposure_s)
    numbers = [session] if session else lab.next_session(participant)
    with _SessionBars(quiet) as bars:
        outcome = lab.run(participant, respondent, numbers, bars.tell)
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
    ) -> None:
        self._protocol = protocol
        self._study = study
        self._playback = playback
        self._seed = seed
        self._exposure_s = exposure_s
        self._rendering: tuple[StereoRenderer, Machine] | None = None
        self._load_scene = lru_cache(maxsize=None)(_load_scene)

    def next_session(self, participant: str) -> list[int]:
        """Return the number of the first session that is not recorded.

        Raises
        ------
        InputError
            If all are, whole or aborted.
        """
        from vrcomfort.design import build_design
        from vrcomfort.records import recorded_sessions

        done = recorded_sessions(self._study, participant)
        total = build_design(self._protocol).sessions
        left = [number for number in range(1, total + 1) if number not in done]
        if not left:
            message = f"all {total} sessions of {participant} are recorded, whole or in part"
            raise InputError(f"{message}; enrol another participant", file=self._study)
        return left[:1]

    def run(
        self, participant: str, kind: RespondentKind, sessions: list[int] | None, tell: Any
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
            headset_for=self._playback,
            renderer=renderer,
            respondent=self._respondent(kind, participant, seed),
            clock=session.VirtualClock() if simulated else session.WallClock(),
            seed=seed,
            sessions=sessions,
            exposure_s=self._exposure_s,
            machine=machine,
            progress=tell,
        )

    def _respondent(self, kind: RespondentKind, participant: str, seed: int) -> Respondent:
        from vrcomfort.respondent import SimulatedRespondent, TerminalRespondent

        if kind is RespondentKind.SIMULATED:
            settings = self._protocol.simulation
            return SimulatedRespondent(settings, participant=participant, seed=seed)
        return TerminalRespondent(console())


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
