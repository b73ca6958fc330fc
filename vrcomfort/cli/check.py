"""`check`: faults, length and visible blur of a protocol, before participants are recruited."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from vrcomfort.cli.options import Json, Quiet, parse_size
from vrcomfort.cli.terminal import (
    EXIT_BAD_INPUT,
    answer,
    complain,
    console,
    progress_bar,
    warn,
)
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, load_protocol
from vrcomfort.protocol.load import missing_wording
from vrcomfort.protocol.questions import asked_at_least
from vrcomfort.settings import read_toml
from vrcomfort.tasks import OwnTask

if TYPE_CHECKING:
    from vrcomfort.cli.check_stimuli import Stimuli
    from vrcomfort.render.stimulus_check import Amount
    from vrcomfort.session.dry_run import SessionLength


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(check)


@dataclass
class _Checked:
    """Findings on one protocol."""

    faults: list[InputError] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    lengths: list[SessionLength] = field(default_factory=list)
    stimuli: Stimuli | None = None


def check(
    protocols: Annotated[
        list[str], typer.Argument(metavar="PROTOCOL...", help="Protocol files, or shipped ones.")
    ],
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="Pixels of one eye's image; by default the protocol's."),
    ] = None,
    refresh_hz: Annotated[
        float | None,
        typer.Option(help="Display rate, in Hz; by default the protocol's.", min=1, max=1000),
    ] = None,
    moments: Annotated[
        int,
        typer.Option(help="Number of moments of each scene's walk to measure.", min=2, max=1000),
    ] = 24,
    draw: Annotated[
        bool, typer.Option("--draw/--no-draw", help="Measure blur and streaks, which takes frames.")
    ] = True,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Check protocols before recruitment; the exit code is 2 if one has a fault.

    Reads and checks the file, whether the number of participants balances the orders, takes a
    simulated participant through all sessions without drawing, and measures how large blur and
    streaks are. What cannot be seen, or told apart, is a fault unless [visibility] means it.

    - `vrcomfort check my_study.toml`
    - `vrcomfort check carnegie_2015 mantiuk_2011 --size 2064x2208 --refresh-hz 72`
    """
    found: dict[str, _Checked] = {}
    for name in protocols:
        with progress_bar(f"checking {name}", None, quiet=quiet or as_json) as advance:
            found[name] = _check(name, size, refresh_hz, moments, draw, advance)
        if not as_json and not (quiet and not found[name].faults):
            _show(name, found[name])
    if as_json:
        answer({name: _as_data(each) for name, each in found.items()})
    if any(each.faults for each in found.values()):
        raise typer.Exit(EXIT_BAD_INPUT)


def _check(
    name: str, size: str | None, refresh_hz: float | None, moments: int, draw: bool, advance: Any
) -> _Checked:
    from vrcomfort.cli.check_stimuli import open_vignettes
    from vrcomfort.session.start_pose import shortened_turns

    try:
        protocol = load_protocol(name)
    except InputError as error:
        return _Checked(faults=[error.alone, *error.others])
    found = _Checked(notes=list(_notes(protocol)))
    try:
        found.faults += _of_design(protocol)
        found.faults += _undrawable(protocol)
        found.faults += missing_wording(protocol)
        found.notes += dict.fromkeys(shortened_turns(protocol))  # views may share a path
        if not_to_be_had := [*_of_places(protocol), *_of_instructions(protocol)]:
            found.faults += not_to_be_had
            return found  # neither rehearsed nor drawn: nobody can stand there, or be told
        advance(0, f"rehearsing {name} without pictures")
        found.lengths = _rehearsed(protocol)
        found.notes += _without_rest(protocol, found.lengths)
        size_px = parse_size(size) if size else protocol.headset.image_size_px
        rate_hz = refresh_hz or protocol.headset.refresh_hz
        found.notes += open_vignettes(protocol, size_px, rate_hz)
        if draw:
            _look(protocol, found, size_px, rate_hz, moments, advance)
    except InputError as error:
        found.faults += [error.alone, *error.others]
    return found


def _of_places(protocol: Protocol) -> list[InputError]:
    from vrcomfort.scene.load import load_scene
    from vrcomfort.session.start_pose import place_faults

    return list(place_faults(protocol, load_scene))


def _of_instructions(protocol: Protocol) -> list[InputError]:
    from vrcomfort.session.instructor import instruction_faults

    return list(instruction_faults(protocol))


def _undrawable(protocol: Protocol) -> list[InputError]:
    """Return the texts that the panel cannot draw, in any language, each once."""
    from vrcomfort.session.panel_wording import undrawable_wording

    languages = protocol.languages or (None,)
    found = [each for one in languages for each in undrawable_wording(protocol.spoken(one))]
    return list({str(each): each for each in found}.values())


def _of_design(protocol: Protocol) -> Iterator[InputError]:
    from vrcomfort.design import build_design
    from vrcomfort.design.audit import cannot_balance

    if protocol.participants is not None:
        message = cannot_balance(build_design(protocol), protocol.participants)
        if message and not protocol.order.unbalanced:
            allow = "or allow it: `unbalanced = true` under [order]"
            yield protocol.fault(("participants",), f"{message}; {allow}")


def _notes(protocol: Protocol) -> Iterator[str]:
    asked = {ask.instrument for ask in protocol.questionnaires if ask.compares is None}
    for each in (protocol.instrument(name) for name in sorted(asked)):
        if len(each.asked) > 1 and not read_toml(each.text, None).get("scales"):
            yield f"the {each.short} has no [[scales]]: its items are reported one by one"
    counted = asked_at_least(protocol.ratings, protocol.longest_s)
    for rated, (due, least) in zip(protocol.ratings, counted, strict=True):
        if least < due:
            yield (
                f"the rating `{rated.instrument}` is due {due} times in an exposure of "
                f"{protocol.longest_s:g} s, and may be asked {least} of them only: it waits while "
                "another question is open; shorten `timeout_s`, or lengthen `every_s`"
            )
    for task in protocol.tasks:
        if isinstance(task, OwnTask):
            yield (
                f"the code of the task `{task.name}` ({task.kind}) is not run here; its settings "
                "are checked by `simulate` and `run`"
            )
    if protocol.participants is None:
        yield "`participants` is not said, so nobody knows whether the orders will balance"


_MEANT, _MEANT_S = 2, 300.0
"""So many exposures without a rest, or all that take so long together, `break_s = 0.0` allows."""


def _without_rest(protocol: Protocol, lengths: list[SessionLength]) -> Iterator[str]:
    """Yield a note where exposures follow each other without a rest, and no setting decides so.

    A `break_s = 0.0` that is written down is a decision for two exposures, or for a few minutes.
    """
    longest = max(lengths, key=lambda each: (each.in_a_row, each.in_a_row_s))
    written = "break_s" in protocol.model_fields_set
    meant = longest.in_a_row <= _MEANT or longest.in_a_row_s <= _MEANT_S
    if longest.in_a_row < 2 or protocol.breaks is not None or (written and meant):
        return
    decide = "give `break_s` a length, or write [breaks]"
    decide += ", or `break_s = 0.0` where none is meant" if meant else ""
    yield (
        f"{longest.in_a_row} exposures of a session, {longest.in_a_row_s / 60:.1f} min together, "
        f"follow each other without a rest, and symptoms carry over; {decide}"
    )


def _rehearsed(protocol: Protocol) -> list[SessionLength]:
    from vrcomfort.session.dry_run import dry_run

    with TemporaryDirectory(prefix="vrcomfort_check_") as folder:
        return dry_run(protocol, Path(folder))


def _look(
    protocol: Protocol,
    found: _Checked,
    size_px: tuple[int, int],
    refresh_hz: float,
    moments: int,
    advance: Any,
) -> None:
    from vrcomfort.cli.check_stimuli import measure_stimuli
    from vrcomfort.gpu.gl import create_context

    try:
        ctx = create_context()
    except InputError as error:
        found.notes.append(f"blur and streaks were not measured: {error.message}")
        return
    found.stimuli = measure_stimuli(ctx, protocol, size_px, refresh_hz, moments, advance)
    found.notes += found.stimuli.notes
    names = [condition.name for condition in protocol.conditions]
    written = "factors" if protocol.factors else "conditions"
    for each in found.stimuli.faults:
        found.faults.append(
            protocol.fault((written, names.index(each.conditions[-1])), each.message)
        )


def _as_data(found: _Checked) -> dict[str, Any]:
    lengths = [{**asdict(each), "total_s": each.total_s} for each in found.lengths]
    rows = [asdict(each) for each in found.stimuli.rows] if found.stimuli else None
    return {
        "faults": [str(each) for each in found.faults],
        "notes": found.notes,
        "sessions": lengths,
        "stimuli": rows,
    }


def _show(name: str, found: _Checked) -> None:
    printed = console(wrap=True)
    if found.lengths:
        printed.print(_length_table(name, found.lengths))
    if found.stimuli is not None:
        printed.print(_stimulus_table(name, found.stimuli))
    for note in found.notes:
        warn(f"{name}: {note}")
    for fault in found.faults:
        complain(str(fault))
    if not found.faults:
        notes = len(found.notes)
        counted = f"no fault; {notes} {'note' if notes == 1 else 'notes'} to look at"
        printed.print(f"{name}: {counted if notes else 'nothing is wrong'}")


def _length_table(name: str, lengths: list[SessionLength]) -> Table:
    table = Table(title=f"{name}: length of sessions in minutes", title_justify="left")
    for column in ("group", "session", "exposure", "training", "rest", "questions", "total"):
        table.add_column(column, justify="left" if column == "group" else "right")
    for each in lengths:
        parts = (each.exposure_s, each.training_s, each.rest_s, each.questions_s, each.total_s)
        table.add_row(each.group, str(each.session), *(f"{part / 60:.1f}" for part in parts))
    return table


def _stimulus_table(name: str, stimuli: Stimuli) -> Table:
    title = f"{name}: circles of confusion (diameter) and streaks, px (arcmin); share ≥ 1 px"
    table = Table(title=title, title_justify="left")
    table.add_column("condition", overflow="fold")
    table.add_column("scene", overflow="fold")
    for column in ("circle median", "p90", "share", "streak median", "p90", "share"):
        table.add_column(column, justify="right")
    for row in stimuli.rows:
        cells = [*_cells(row.circles), *_cells(row.streaks)]
        table.add_row(row.condition, row.scene, *cells)
    return table


def _cells(amount: Amount | None) -> list[str]:
    if amount is None:
        return ["-", "-", "-"]
    return [
        f"{amount.median_px:.1f} ({amount.median_arcmin:.1f}′)",
        f"{amount.p90_px:.1f} ({amount.p90_arcmin:.1f}′)",
        f"{amount.shown_percent:.0f} %",
    ]
