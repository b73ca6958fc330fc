"""`report` and `score`: from answers to numbers and figures. Need neither a GPU nor a headset."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vrcomfort.cli.options import (
    AcceptFlaggedOption,
    Json,
    MemoryOption,
    Quiet,
    WithoutOption,
    output_option,
)
from vrcomfort.cli.terminal import answer, console, progress_bar, warn
from vrcomfort.errors import InputError
from vrcomfort.files import read_text

if TYPE_CHECKING:
    from vrcomfort.report import Form


MOST_ANSWERS = 8
"""As many sentences as a terminal shows; the page has all."""


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(report)
    app.command()(score)


def _list(asked: bool) -> None:
    """Print the shipped plans, one a line."""
    if asked:
        from vrcomfort.report.plan_files import shipped_plans

        plans = shipped_plans()
        width = max(len(each.name) for each in plans)
        for each in plans:
            typer.echo(f"{each.name:{width}}  {each.title}")
        raise typer.Exit


def _forms(text: str) -> list[Form]:
    """Read the forms of figures, with commas between them; none for `none`.

    Raises
    ------
    InputError
        If one of them is no form.
    """
    from vrcomfort.report import FORMS

    asked = [] if text.strip() == "none" else [each.strip() for each in text.split(",")]
    if unknown := [each for each in asked if each not in FORMS]:
        raise InputError(
            f"--figures {text}: no form is called {unknown[0]!r}; write none, or some of "
            f"{', '.join(FORMS)} with commas between them"
        )
    return [form for form in FORMS if form in asked]


def report(
    out: Annotated[Path, output_option(help="Folder for the report.")],
    study: Annotated[
        Path | None,
        typer.Argument(
            metavar="[STUDY]",
            help="A study folder, any folder that holds questionnaires.csv files, or one file: "
            "tidy, or one that `import --suggest` has no doubts about. Without it, the files that "
            "the plan names in [data].",
        ),
    ] = None,
    plan: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|PLAN.toml",
            help="Analysis plan: a shipped one, or a file. Without it, the protocol's own, or one "
            "derived from the data; either way it is written beside the report.",
        ),
    ] = None,
    _list_plans: Annotated[
        bool,
        typer.Option(
            "--list-plans", callback=_list, is_eager=True, help="List the shipped plans and exit."
        ),
    ] = False,
    instrument: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="Report the answers to this instrument alone; all that were asked without it.",
        ),
    ] = None,
    simulated: Annotated[
        bool,
        typer.Option(
            "--simulated", help="Report the simulated participants of a study with both kinds."
        ),
    ] = False,
    figures: Annotated[
        str,
        typer.Option(
            metavar="FORMS|none",
            help="Forms in which figures are written, with commas; none: a page without figures, "
            "in a fraction of the time.",
        ),
    ] = "svg,png,pdf",
    memory: MemoryOption = "512MB",
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="A running Dask scheduler, such as tcp://host:8786, whose workers read the "
            "frames; they need to see the study.",
        ),
    ] = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="Overwrite the report of another study in --out.")
    ] = False,
    without: WithoutOption = None,
    accept_flagged: AcceptFlaggedOption = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Analyse a study: a page, numbers as JSON and CSV, figures as SVG, PNG and PDF.

    The first answers are printed too.

    - `vrcomfort report out/demo/study --out out/demo/report`
    - `vrcomfort report answers/questionnaires.csv --plan my_plan.toml --out report`
    - `vrcomfort report my_study --plan carnegie_2015_as_printed --out report`
    - `vrcomfort report --plan plan_that_names_files.toml --out report`
    """
    from vrcomfort.api.reports import write_report

    forms = _forms(figures)
    with progress_bar("analysing", None, quiet=quiet):
        summary = write_report(
            study,
            out,
            plan=plan,
            instrument=instrument,
            simulated=simulated or None,
            forms=forms,
            memory=memory,
            cluster=cluster,
            without=without or (),
            accept_flagged=accept_flagged,
            replace=replace,
            note=warn,
        )
    if as_json:
        typer.echo(read_text(out / "results.json", "report"))
    else:
        told = console(quiet)
        for line in _first(summary.headlines):
            told.print(line, markup=False, highlight=False)
        told.print(f"Report: {out / 'index.html'}")


def _first(headlines: tuple[str, ...]) -> list[str]:
    """Return the answers that a terminal has room for; they stand in the plan's order."""
    shown, more = headlines[:MOST_ANSWERS], len(headlines) - MOST_ANSWERS
    return [*shown, *([f"… and {more} more on the page."] if more > 0 else [])]


def score(
    answers: Annotated[
        list[str],
        typer.Argument(
            metavar="[INSTRUMENT] FILE.csv", help="Answers: one row per person, or one per answer."
        ),
    ],
    instrument: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="The questionnaire; without it, the one whose items the file has.",
        ),
    ] = None,
    skip_incomplete: Annotated[
        bool,
        typer.Option(
            "--skip-incomplete", help="Leave out questionnaires without all answers; list them."
        ),
    ] = False,
    coded_from: Annotated[
        int | None,
        typer.Option(
            help="Number of the lowest answer in the file: 1 where 1 to 4 stand for 0 to 3."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Score questionnaires: a CSV (or JSON) of scores on standard output.

    Items are found by their names, in any order; other columns are kept. Instruments are shipped
    ones (ssq, vrsq, csq_vr, nasa_tlx, sus, …) or a lab's own file: `vrcomfort docs instruments`.

    - `vrcomfort score answers.csv > scores.csv`
    - `vrcomfort score answers.csv --instrument vrsq > scores.csv`
    - `vrcomfort score answers.csv --instrument my_questionnaire.toml > scores.csv`
    - `vrcomfort score ssq answers.csv --skip-incomplete > scores.csv`
    """
    from vrcomfort.api.answers import scored_rows

    if len(answers) > 2 or (len(answers) == 2 and instrument is not None):
        raise InputError("`score` takes one file of answers; score several one after the other")
    file, name = Path(answers[-1]), answers[0] if len(answers) == 2 else instrument
    if file.is_file() and not os.access(file, os.R_OK):
        raise typer.BadParameter(f"path '{file}' is not readable")
    rows = scored_rows(file, name, skip_incomplete, coded_from, warn)
    if as_json:
        answer(rows)
        return
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    typer.echo(text.getvalue(), nl=False)
