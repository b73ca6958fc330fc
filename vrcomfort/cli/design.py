"""`design` and `power`: the orders of a study and their balance, and how many people it needs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from vrcomfort.api.outputs import output_folder
from vrcomfort.cli.options import Json, ProtocolArgument, Quiet, Seed, StudySeed, output_option
from vrcomfort.cli.terminal import answer, console, progress_bar
from vrcomfort.design import Audit, Design, FactorAudit, StudyAudit, audit, build_design
from vrcomfort.json_text import json_of
from vrcomfort.protocol import Protocol, Sequence, load_protocol

if TYPE_CHECKING:
    from vrcomfort.report.power import PowerRow, Question


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(design)
    app.command()(power)


def design(
    protocol: ProtocolArgument,
    participants: Annotated[
        int | None,
        typer.Option(
            "--participants",
            "-n",
            min=1,
            max=10_000,
            help="Number of participants; by default the protocol's, or 20.",
        ),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option(
            help="Audit the sessions in this folder, and suggest orders that restore balance."
        ),
    ] = None,
    seed: StudySeed = None,
    as_json: Json = False,
) -> None:
    """Show the orders and groups of all participants, and their balance.

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
    from vrcomfort.records import administered_orders, open_study
    from vrcomfort.records.study import DESCRIPTION

    if not (study / DESCRIPTION).is_file():
        raise InputError(f"this is not a study folder: it has no {DESCRIPTION}", file=study)
    scheme = build_design(protocol, seed=open_study(study, protocol, seed=seed))
    found = audit_study(scheme, administered_orders(study))
    if as_json:
        answer(_with_text_keys(asdict(found)))
        return
    console().print(f"As it was run: {found.participants} enrolled, {found.counted.participants} "
                    "take a place")  # fmt: skip
    for name, count in found.gone.items():
        console().print(f"  {count} of sequence {name} withdrew or were excluded")
    console(wrap=True).print(_sequences_table(found))
    _show_audit(found.counted)
    for covariate, margin in found.margins.items():
        console(wrap=True).print(_margin_table(covariate, margin))
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
    console(wrap=True).print(table)


def _show_audit(counted: Audit) -> None:
    if counted.groups:
        groups = _table("Groups", "group", "participants")
        for name, count in counted.groups.items():
            groups.add_row(name, str(count))
        console(wrap=True).print(groups)
    for title, factor in (("condition", counted.conditions), ("scene", counted.scenes)):
        console(wrap=True).print(_audit_table(title, factor))
    table = _table("First exposure: condition × scene", "condition", "scene", "participants")
    for (condition, scene), count in counted.crossing.items():
        table.add_row(condition, scene, str(count))
    console(wrap=True).print(table)
    carried = _table("Carry-over within sessions (before → after)", "pair", "times")
    for (before, after), count in sorted(counted.treatments.carry_over.items()):
        carried.add_row(f"{before} → {after}", str(count))
    console(wrap=True).print(carried)


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


def power(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="Shipped analysis plan, or a file.")],
    effect: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="Mean difference: 0.5sd (standard deviations of the differences), or 10 points.",
        ),
    ] = None,
    participants: Annotated[
        str,
        typer.Option(
            "--participants", "-n", metavar="FIRST:LAST[:STEP]", help="Numbers of participants."
        ),
    ] = "8:60",
    sd: Annotated[
        float | None,
        typer.Option(help="Standard deviation of the differences, for an effect in points."),
    ] = None,
    pilot: Annotated[
        Path | None,
        typer.Option(
            metavar="STUDY",
            help="Resample the differences of this study; without --effect, with its own effect.",
        ),
    ] = None,
    studies: Annotated[
        int, typer.Option(help="Simulated studies of each size.", min=100, max=1_000_000)
    ] = 2000,
    seed: Seed = 0,
    jobs: Annotated[int, typer.Option(help="Number of processes.", min=1)] = 1,
    out: Annotated[
        Path | None, output_option(help="Folder for power.csv, power.svg, power.png, power.json.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Estimate the power of a plan's primary test by simulating studies.

    The test is the report's: that of the plan's first outcome and contrast, at its level. Intervals
    are Wilson's, of 95 %, and say how well the simulation knows the power.

    - `vrcomfort power carnegie_2015 --effect 0.5sd --participants 8:60`
    - `vrcomfort power my_plan.toml --effect 10 --sd 18 --out power`
    - `vrcomfort power my_plan.toml --effect 10 --pilot my_pilot --jobs 2`
    """
    from vrcomfort.report.power import Effect, parse_participants, question_of, simulate_power
    from vrcomfort.workers import workers

    sizes = parse_participants(participants)
    wanted = None if effect is None else Effect.of_text(effect)
    question = question_of(plan, wanted, sd=sd, pilot=pilot)
    folder = None if out is None else output_folder(out)
    bar = progress_bar("simulated", len(sizes) * studies, quiet=quiet or as_json, unit="studies")
    with bar as advance, workers(jobs, None) as work:
        rows = simulate_power(
            question, sizes, studies=studies, seed=seed, work=work, advance=advance
        )
    facts = _facts(question, rows, seed, studies)
    if folder is not None:
        _write(folder, question, rows, facts)
    if as_json:
        answer(facts)
    else:
        _print(question, rows, seed, quiet=quiet)


def _facts(question: Question, rows: list[PowerRow], seed: int, studies: int) -> dict[str, Any]:
    from vrcomfort.report.power import cells

    return {
        "outcome": question.outcome,
        "contrast": question.contrast,
        "test": question.test.name,
        "alternative": question.test.alternative,
        "alpha": round(question.test.alpha, 12),
        "holm_tests": question.holm_tests,
        "differences": question.generator_in_words,
        "effect_sd": question.effect_sd,
        "seed": seed,
        "studies": studies,
        "rows": [cells(row) for row in rows],
    }


def _write(folder: Path, question: Question, rows: list[PowerRow], facts: dict[str, Any]) -> None:
    from vrcomfort.report.power import cells, draw_power
    from vrcomfort.report.tables import to_csv

    drawing = draw_power(question, rows)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "power.csv").write_text(to_csv([cells(row) for row in rows]), encoding="utf-8")
    (folder / "power.json").write_text(json_of(facts) + "\n", encoding="utf-8")
    (folder / "power.svg").write_text(drawing.svg, encoding="utf-8")
    (folder / "power.png").write_bytes(drawing.png())


def _print(question: Question, rows: list[PowerRow], seed: int, *, quiet: bool) -> None:
    from vrcomfort.report.power import TITLES

    test = question.test
    screen = console(quiet)
    what = f"{question.outcome}, {question.contrast}: {TITLES[test.name]}"
    screen.print(f"{what}, {test.alternative}, α = {test.alpha:.3g}")
    screen.print(f"Differences: {question.generator_in_words}. Seed {seed}.")
    adjusted = f"  α/{question.holm_tests} (Holm)" if rows[0].adjusted else ""
    formula = "  by formula" if rows[0].t_test_formula is not None else ""
    screen.print(f"   n  power  [95 % interval]{adjusted}   t test{formula}")
    for row in rows:
        found = f"{row.n:4d}  {row.power.share:.3f}  [{row.power.low:.3f}, {row.power.high:.3f}]  "
        found += f"{row.adjusted.share:12.3f}" if row.adjusted else ""
        found += f"{row.t_test.share:9.3f}"
        found += "" if row.t_test_formula is None else f"{row.t_test_formula:12.3f}"
        screen.print(found)
