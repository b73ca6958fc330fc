"""`design`: who meets what in which order, before anybody puts a headset on."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.table import Table

from vrcomfort.cli.options import Json, ProtocolArgument, Seed
from vrcomfort.cli.terminal import answer, console
from vrcomfort.design import Audit, Design, FactorAudit, audit, build_design
from vrcomfort.protocol import Sequence, load_protocol


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(design)


def design(
    protocol: ProtocolArgument,
    participants: Annotated[int, typer.Option("--participants", "-n", min=1, max=10_000)] = 20,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Show who meets what in which order, and how balanced that is.

    - `vrcomfort design carnegie_2015 --participants 20`
    - `vrcomfort design my_study.toml -n 24 --json`
    """
    scheme = build_design(load_protocol(protocol), seed=seed)
    sequences = scheme.plan(participants)
    counted = audit(scheme, sequences)
    if as_json:
        answer(_design_as_data(sequences, counted))
        return
    _show_order(scheme, sequences)
    _show_audit(counted)
    console().print(
        f"\n{counted.remainder}\nThe slot of a participant who withdraws or is excluded goes back "
        "to the pool: the next one enrolled takes the sequence that has the fewest people."
    )


def _design_as_data(sequences: list[Sequence], counted: Audit) -> dict[str, Any]:
    data = {
        name: _with_text_keys(value) if isinstance(value, dict) else value
        for name, value in asdict(counted).items()
    }
    order = [
        {"participant": f"P{number:02d}", **each.model_dump()}
        for number, each in enumerate(sequences, start=1)
    ]
    return {**data, "order": order}


def _with_text_keys(data: dict[Any, Any]) -> dict[str, Any]:
    """JSON has only text as keys: a pair of levels is written "before > after"."""
    return {
        " > ".join(key) if isinstance(key, tuple) else str(key): (
            _with_text_keys(value) if isinstance(value, dict) else value
        )
        for key, value in data.items()
    }


def _show_order(scheme: Design, sequences: list[Sequence]) -> None:
    table = Table(title="Order", title_justify="left")
    table.add_column("participant")
    table.add_column("sequence")
    for session in range(1, scheme.sessions + 1):
        table.add_column(f"session {session}")
    for number, sequence in enumerate(sequences, start=1):
        sessions = [
            " → ".join(f"{trial.condition} in {trial.scene}" for trial in session)
            for session in sequence.sessions
        ]
        table.add_row(f"P{number:02d}", sequence.name, *sessions)
    console().print(table)


def _show_audit(counted: Audit) -> None:
    for title, factor in (("condition", counted.conditions), ("scene", counted.scenes)):
        console().print(_audit_table(title, factor))
    table = Table(title="First exposure: condition × scene", title_justify="left")
    for column in ("condition", "scene", "participants"):
        table.add_column(column)
    for (condition, scene), count in counted.crossing.items():
        table.add_row(condition, scene, str(count))
    console().print(table)
    carried = Table(title="Carry-over within sessions (before → after)", title_justify="left")
    carried.add_column("pair")
    carried.add_column("times")
    for (before, after), count in sorted(counted.treatments.carry_over.items()):
        carried.add_row(f"{before} → {after}", str(count))
    console().print(carried)


def _audit_table(title: str, factor: FactorAudit) -> Table:
    longest = max((len(places) for places in factor.positions.values()), default=0)
    table = Table(title=f"Balance of {title}s", title_justify="left")
    table.add_column(title)
    table.add_column("starts the study")
    for place in range(1, longest + 1):
        table.add_column(f"at position {place} of a session")
    for level, places in factor.positions.items():
        table.add_row(level, str(factor.first[level]), *map(str, places))
    return table
