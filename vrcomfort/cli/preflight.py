"""`preflight`: a protocol on this machine and headset, before people come."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from vrcomfort.cli.headset_setup import rehearse
from vrcomfort.cli.options import (
    GroupReadable,
    Json,
    ProtocolArgument,
    Quiet,
    RefreshRate,
    StudyFolder,
    TraceOption,
    declared_by,
)
from vrcomfort.cli.preflight_checks import CHECKS, Preflight, Stage, refuse
from vrcomfort.cli.run import OPENXR, HeadsetKind, RunOptions
from vrcomfort.cli.terminal import EXIT_BAD_INPUT, answer, console, progress_bar, warn
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.headset.watchdog import Watchdog
from vrcomfort.protocol import load_protocol

if TYPE_CHECKING:
    from vrcomfort.api.study_setup import HeadsetSetup
    from vrcomfort.cli.doctor import Diagnosis

SECONDS = 120.0
WAKE_S = 20.0
"""Time in which a headset may be put on."""


@dataclass(frozen=True, kw_only=True)
class PreflightOptions:
    """Arguments and options of `preflight`: each field declares one."""

    protocol: ProtocolArgument
    out: StudyFolder
    headset: Annotated[HeadsetKind, typer.Option(help="Headset to use.")] = OPENXR
    trace: TraceOption = None
    monado_trace: Annotated[
        Path | None,
        typer.Option(help="Rehearse with a Monado runtime whose head follows this trace."),
    ] = None
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="Pixels of one eye's image: 640x800, or the headset's."),
    ] = None
    refresh_hz: RefreshRate = None
    seconds: Annotated[
        float, typer.Option(help="Time for the slowest condition, in s.", min=0.1, max=3600)
    ] = SECONDS
    lsl: Annotated[
        bool, typer.Option("--lsl", help="Check LabStreamingLayer, which sessions will use.")
    ] = False
    ttl: Annotated[
        str | None,
        typer.Option(metavar="PORT", help="Check this serial port, which sessions will use."),
    ] = None
    group_readable: GroupReadable = False
    quiet: Quiet = False
    as_json: Json = False

    def as_run(self) -> RunOptions:
        """Return the options of a session on the same headset."""
        return RunOptions(
            participant="preflight",
            protocol=self.protocol,
            out=self.out,
            headset=self.headset,
            trace=self.trace,
            monado_trace=self.monado_trace,
            size=self.size,
            refresh_hz=self.refresh_hz,
            lsl=self.lsl,
            ttl=self.ttl,
        )


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(preflight)


@declared_by(PreflightOptions)
def preflight(ctx: typer.Context, options: PreflightOptions) -> None:
    """Check machine, headset and room before participants arrive.

    Looks at wording, GPU, disk, clock, sound, runtime, headset, rate, room and stop, and shows the
    condition that takes longest to draw for two minutes: put the headset on. No code of the
    protocol's own tasks is run. What was found stands in preflight.json of the study folder; `run`
    asks for it each day. The exit code is 2 if something stands in the way.

    - `vrcomfort preflight carnegie_2015 --out my_study`
    - `vrcomfort preflight my_study.toml --out my_study --refresh-hz 72 --lsl`
    - `vrcomfort preflight smoke --out my_study --headset playback --seconds 5`
    """
    from vrcomfort.records.disk import GROUP
    from vrcomfort.records.preflights import write_preflight
    from vrcomfort.records.study import access_of

    del ctx
    run = options.as_run()
    flight = Preflight(run, load_protocol(options.protocol))
    run.require_meaning()
    measured: dict[str, Any] = {}
    with progress_bar("looking", None, quiet=options.quiet or options.as_json) as advance:
        findings = list(_examine(flight, options.seconds, measured, advance))
    content = _content(flight, options, measured, findings)
    access = GROUP if options.group_readable else access_of(options.out)
    file = write_preflight(options.out, content, access)
    if options.as_json:
        answer(content)
    elif not options.quiet:
        _show(flight, findings)
        console().print(f"{content['outcome']}: {file}")
    if content["outcome"] == "refuse":
        raise typer.Exit(EXIT_BAD_INPUT)


def _examine(
    flight: Preflight, seconds: float, measured: dict[str, Any], advance: Callable[..., object]
) -> Iterator[Diagnosis]:
    """Yield the findings of the checks, up to a missing OpenGL or headset."""
    from vrcomfort.gpu.gl import release

    yield from _checked(flight, "machine", advance)
    if flight.ctx is None:
        return
    release(flight.ctx)
    with ExitStack() as owned:
        watchdog = owned.enter_context(Watchdog(warn)) if flight.worn else None
        try:
            rehearsal = owned.enter_context(rehearse(flight.run.monado_trace, None, watchdog))
            found = list(_checked(flight, "runtime", advance))
            yield from found
            if any(each.outcome == "refuse" for each in found):
                return
            live = owned.enter_context(flight.run.connect(flight.protocol, rehearsal, watchdog))
            measured |= _show_frames(flight, seconds, live, advance)
        except (InputError, RuntimeLostError) as error:
            yield refuse("headset", "no session, or none to its end", str(error))
            return
        yield from _checked(flight, "frames", advance)


def _checked(
    flight: Preflight, stage: Stage, advance: Callable[..., object]
) -> Iterator[Diagnosis]:
    for check in CHECKS:
        if check.stage == stage:
            advance(0, check.name)
            yield from check.find(flight)


def _show_frames(
    flight: Preflight, seconds: float, live: HeadsetSetup | None, advance: Callable[..., object]
) -> dict[str, Any]:
    """Show the dearest condition for a time; return its measurements for the file."""
    from vrcomfort.api.rendering import describe_machine, make_renderer
    from vrcomfort.api.timed_show import costs, show_for
    from vrcomfort.headset.base import CanSleep
    from vrcomfort.records.apparatus import apparatus_of, facts_now
    from vrcomfort.scene.load import load_scene
    from vrcomfort.session import headset_facts

    protocol, playback = flight.protocol, flight.run.playback(flight.protocol)
    if live is None:
        renderer = make_renderer(playback.size_px)
        machine = describe_machine(renderer, protocol)
    else:
        renderer, machine = live.renderer, live.machine
    headset_for = live.headset_for if live else playback
    headset = live.headset if live else playback.at_start(protocol)
    load = lru_cache(maxsize=None)(load_scene)
    advance(0, "which condition takes longest to draw")
    dearest = costs(protocol, renderer, load)
    timing = None
    if not isinstance(headset, CanSleep) or headset.wake(WAKE_S):
        advance(0, f"{dearest[0].words}, for {seconds:g} s")
        shown = show_for(protocol, dearest[0], headset_for, renderer, load, seconds)
        flight.shown, timing = shown, shown.facts(protocol)
    flight.timing_trust, flight.facts = machine.timing_trust, headset_facts(headset)
    run = facts_now(machine, flight.facts)
    return {
        "apparatus": apparatus_of(run),
        "costs_ms": {each.words: round(each.frame_ms, 3) for each in dearest},
        "timing": timing,
    }


def _content(
    flight: Preflight, options: PreflightOptions, measured: dict[str, Any], found: list[Diagnosis]
) -> dict[str, Any]:
    """Return the content of ``preflight.json``."""
    from vrcomfort.records.study import now

    protocol, outcomes = flight.protocol, {each.outcome for each in found}
    return {
        "at": now(),
        "outcome": next(each for each in ("refuse", "notice", "ok") if each in outcomes),
        "protocol": {"name": protocol.name, "sha256": protocol.sha256},
        "headset": str(flight.run.headset),
        "rehearsed": options.monado_trace is not None,
        "apparatus": {},
        "timing": None,
        **measured,
        "findings": [
            {"part": each.part, "outcome": each.outcome, "found": each.found, "remedy": each.remedy}
            for each in found
        ],
    }


_COLOURS = {"ok": "green", "notice": "yellow", "refuse": "bold red"}


def _show(flight: Preflight, findings: list[Diagnosis]) -> None:
    table = Table(title=f"preflight of {flight.protocol.name}", title_justify="left")
    for column in ("", "part", "found", "remedy"):
        table.add_column(column, overflow="fold")
    for each in findings:
        outcome = Text(each.outcome, style=_COLOURS[each.outcome])
        table.add_row(outcome, each.part, each.found, each.remedy)
    console(wrap=True).print(table)
