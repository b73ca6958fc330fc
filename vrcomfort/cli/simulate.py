"""`simulate`: simulated participants go through a protocol and everything is recorded."""

from __future__ import annotations

from functools import partial
from typing import Annotated

import typer

from vrcomfort.api.playback import open_trace
from vrcomfort.api.simulation import finish, simulate_sessions
from vrcomfort.api.study_setup import outcome_sentence
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
from vrcomfort.cli.terminal import console, progress_bar, warn
from vrcomfort.protocol import load_protocol


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
    outcomes = simulate_sessions(
        load_protocol(protocol).spoken(language),
        participants=participants,
        out=out,
        seed=seed,
        size_px=parse_size(size),
        trace=open_trace(trace, note=warn) if trace else None,
        refresh_hz=refresh_hz,
        exposure_s=exposure_s,
        group_readable=group_readable,
        frames=frames,
        note=warn,
        progress=partial(progress_bar, quiet=quiet),
    )
    for outcome in outcomes:
        console(quiet).print(outcome_sentence(outcome, out))
    if outcomes[-1].status == "aborted":
        warn("the same command goes on where this was stopped")
    finish(outcomes)
