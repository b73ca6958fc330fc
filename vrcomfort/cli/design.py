"""`design`: who meets what in which order, before anybody puts a headset on, and as it was run."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from vrcomfort.cli.options import Json, ProtocolArgument, StudySeed
from vrcomfort.cli.terminal import answer, console
from vrcomfort.design import Audit, Design, FactorAudit, StudyAudit, audit, build_design
from vrcomfort.protocol import Protocol, Sequence, load_protocol


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(design)


def design(
    protocol: ProtocolArgument,
    participants: Annotated[
        int | None,
        typer.Option("--participants", "-n", min=1, max=10_000, help="Else the protocol's, or 20."),
    ] = None,
    study: Annotated[
        Path | None, typer.Option(help="Audit what was run in this folder, and say what mends it.")
    ] = None,
    seed: StudySeed = None,
    as_json: Json = False,
) -> None:
    """Show who meets what in which order and in which group, and how balanced that is.

    With --study, what was really run, without those whose places are free again, and which orders
    the next participants should get.

    - `vrcomfort design carnegie_2015 --participants 20`
    - `vrcomfort design my_study.toml -n 24 --json`
    - `vrcomfort design my_study.toml --study my_study`
    """
    read = load_protocol(protocol)
    if study is not None:
        _of_study(read, study, seed, as_json)
        return
    scheme = build_design(read, seed=seed or 0)
    sequences = scheme.plan(participants or read.participants or 20)
    counted = audit(scheme, sequences)
    if as_json:
        answer(_design_as_data(sequences, counted))
        return
    _show_order(scheme, sequences)
    _show_audit(counted)
    console().print(f"\n{counted.remainder}\n{_what_of_places(scheme)}")
    if scheme.groups and scheme.groups.bands:
        console().print("Covariates of the people above were drawn with the seed.", style="dim")


def _what_of_places(scheme: Design) -> str:
    if scheme.own_orders and scheme.groups is None:
        return "Whoever withdraws, the next one enrolled gets an order of their own."
    if not scheme.return_places:
        return "The slot of a participant who withdraws or is excluded stays theirs."
    return (
        "The slot of a participant who withdraws or is excluded goes back to the pool: the next "
        "one enrolled takes the sequence that has the fewest people."
    )


def _of_study(protocol: Protocol, study: Path, seed: int | None, as_json: bool) -> None:
    from vrcomfort.design import audit_study
    from vrcomfort.errors import InputError
    from vrcomfort.records import open_study, what_was_met
    from vrcomfort.records.study import DESCRIPTION

    if not (study / DESCRIPTION).is_file():
        raise InputError(f"this is no study folder: it has no {DESCRIPTION}", file=study)
    scheme = build_design(protocol, seed=open_study(study, protocol, seed=seed))
    found = audit_study(scheme, what_was_met(study))
    if as_json:
        answer(_with_text_keys(asdict(found)))
        return
    console().print(f"As it was run: {found.participants} enrolled, {found.counted.participants} "
                    "take a place")  # fmt: skip
    for name, count in found.gone.items():
        console().print(f"  {count} of sequence {name} withdrew or were excluded")
    console().print(_sequences_table(found))
    _show_audit(found.counted)
    for covariate, margin in found.margins.items():
        console().print(_margin_table(covariate, margin))
    console().print(f"\n{found.mending}")
    if found.next_orders:
        console().print(f"Positions then: {_positions_sentence(found.after)}.")


def _positions_sentence(after: Audit) -> str:
    even = after.treatments.even_positions
    followed = after.treatments.even_carry_over
    places = "every condition in every scene equally often at each position"
    carried = "after each other" if followed else "but not after each other"
    return f"{places}, {carried}" if even else "not alike, as the sequences are not balanced"


def _design_as_data(sequences: list[Sequence], counted: Audit) -> dict[str, Any]:
    order = [
        {"participant": f"P{number:02d}", **each.model_dump()}
        for number, each in enumerate(sequences, start=1)
    ]
    return {**_with_text_keys(asdict(counted)), "order": order}


def _with_text_keys(data: dict[Any, Any]) -> dict[str, Any]:
    """JSON has only text as keys: a pair of levels is written "before > after"."""
    return {
        " > ".join(key) if isinstance(key, tuple) else str(key): (
            _with_text_keys(value) if isinstance(value, dict) else value
        )
        for key, value in data.items()
    }


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column)
    return table


def _show_order(scheme: Design, sequences: list[Sequence]) -> None:
    sessions = [f"session {session}" for session in range(1, scheme.sessions + 1)]
    group = ["group"] if scheme.groups else []
    table = _table("Order", "participant", *group, "sequence", *sessions)
    for number, sequence in enumerate(sequences, start=1):
        shown = [
            " → ".join(f"{trial.condition} in {trial.scene}" for trial in session)
            for session in sequence.sessions
        ]
        group = [sequence.group or ""] if scheme.groups else []
        table.add_row(f"P{number:02d}", *group, sequence.name, *shown)
    console().print(table)


def _show_audit(counted: Audit) -> None:
    if counted.groups:
        groups = _table("Groups", "group", "participants")
        for name, count in counted.groups.items():
            groups.add_row(name, str(count))
        console().print(groups)
    for title, factor in (("condition", counted.conditions), ("scene", counted.scenes)):
        console().print(_audit_table(title, factor))
    table = _table("First exposure: condition × scene", "condition", "scene", "participants")
    for (condition, scene), count in counted.crossing.items():
        table.add_row(condition, scene, str(count))
    console().print(table)
    carried = _table("Carry-over within sessions (before → after)", "pair", "times")
    for (before, after), count in sorted(counted.treatments.carry_over.items()):
        carried.add_row(f"{before} → {after}", str(count))
    console().print(carried)


def _audit_table(title: str, factor: FactorAudit) -> Table:
    longest = max((len(places) for places in factor.positions.values()), default=0)
    positions = [str(place) for place in range(1, longest + 1)]
    title_line = f"Balance of {title}s: how often at each position of a session"
    table = _table(title_line, title, "starts the study", *positions)
    for level, places in factor.positions.items():
        table.add_row(level, str(factor.first[level]), *map(str, places))
    return table


def _sequences_table(found: StudyAudit) -> Table:
    table = _table("Sequences", "sequence", "people", "next participants")
    for name, count in found.counted.sequences.items():
        table.add_row(name, str(count), str(found.next_orders.count(name) or ""))
    return table


def _margin_table(covariate: str, margin: dict[str, dict[str, int]]) -> Table:
    groups = next(iter(margin.values()))
    table = _table(f"Groups by {covariate}", covariate, *groups)
    for level, counts in margin.items():
        table.add_row(level, *(str(counts[group]) for group in groups))
    return table
