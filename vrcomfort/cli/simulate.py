"""`simulate`: simulated participants go through a protocol and everything is recorded."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.cli import EXIT_INTERRUPTED
from vrcomfort.cli.lab import RespondentKind, StudyLab, sentence
from vrcomfort.cli.terminal import (
    ExposureOption,
    ProtocolArgument,
    Quiet,
    RefreshRate,
    Size,
    StudyFolder,
    StudySeed,
    TraceOption,
    console,
    parse_size,
    progress_bar,
)
from vrcomfort.cli.wiring import PlaybackIn, open_trace
from vrcomfort.protocol import Protocol, load_protocol

if TYPE_CHECKING:
    from vrcomfort.session import Outcome


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
        console(quiet).print(sentence(outcome, out))
    if outcomes[-1].status == "aborted":
        raise typer.Exit(EXIT_INTERRUPTED)


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
    playback = PlaybackIn(size_px, protocol.headset.ipd_m, trace, refresh_hz)
    lab = StudyLab(protocol, out, playback, seed, exposure_s)
    digits = max(2, len(str(participants)))
    with progress_bar("participants", participants, quiet=quiet) as advance:
        for number in range(1, participants + 1):
            name = f"P{number:0{digits}d}"
            with lab.reserve(name, None, RespondentKind.SIMULATED) as place:
                outcomes.append(lab.run(place, RespondentKind.SIMULATED, lambda _: None))
            advance()
            if outcomes[-1].status == "aborted":
                break
    return outcomes
