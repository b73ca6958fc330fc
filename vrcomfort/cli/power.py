"""`power`: how many participants a plan needs. Needs neither a GPU nor a headset."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.cli.options import Json, Quiet, Seed, output_option
from vrcomfort.cli.outputs import output_folder
from vrcomfort.cli.terminal import answer, console, progress_bar

if TYPE_CHECKING:
    from vrcomfort.report.power import Question, Row


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(power)


def power(
    plan: Annotated[
        str, typer.Argument(metavar="PLAN", help="A shipped analysis plan, or a file.")
    ],
    effect: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE",
            help="Mean difference: 0.5sd (standard deviations of the differences), or 10 points.",
        ),
    ] = None,
    participants: Annotated[
        str, typer.Option(metavar="FIRST:LAST[:STEP]", help="Numbers of participants.")
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
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
    out: Annotated[
        Path | None, output_option(help="Folder for power.csv, power.svg, power.png, power.json.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate studies of a plan, and say how often its primary test finds the effect.

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
    with progress_bar("simulating", None, quiet=quiet), workers(jobs, None) as work:
        rows = simulate_power(question, sizes, studies=studies, seed=seed, work=work)
    facts = _facts(question, rows, seed, studies)
    if folder is not None:
        _write(folder, question, rows, facts)
    if as_json:
        answer(facts)
    else:
        _print(question, rows, seed, quiet=quiet)


def _facts(question: Question, rows: list[Row], seed: int, studies: int) -> dict[str, Any]:
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


def _write(folder: Path, question: Question, rows: list[Row], facts: dict[str, Any]) -> None:
    from vrcomfort.report.power import cells, draw_power
    from vrcomfort.report.results import to_json
    from vrcomfort.report.tables import to_csv

    drawing = draw_power(question, rows)
    (folder / "power.csv").write_text(to_csv([cells(row) for row in rows]), encoding="utf-8")
    (folder / "power.json").write_text(to_json(facts), encoding="utf-8")
    (folder / "power.svg").write_text(drawing.svg, encoding="utf-8")
    (folder / "power.png").write_bytes(drawing.png())


def _print(question: Question, rows: list[Row], seed: int, *, quiet: bool) -> None:
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
