"""The `vrcomfort` command: collects the sub-commands and turns bad input into one sentence."""

from __future__ import annotations

import errno
import os
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from vrcomfort import __version__
from vrcomfort.cli import (
    anonymise,
    check,
    demo,
    design,
    doctor,
    exclude,
    export,
    import_answers,
    import_trace,
    new,
    pack,
    passes,
    play,
    power,
    render,
    report,
    run,
    schema,
    score,
    simulate,
    status,
    stopping,
    tradeoff,
    undo_withdrawal,
    verify,
)
from vrcomfort.cli.terminal import EXIT_BAD_INPUT, complain
from vrcomfort.errors import InputError

STOPPED = "stopped; what was already written stays"
FAULTS_OF_THE_MACHINE = {
    errno.ENOSPC: "the disk is full; what was already written stays",
    errno.EDQUOT: "your disk quota is used up; what was already written stays",
    errno.EROFS: "the disk is read-only; choose another --out",
    errno.EACCES: "no permission; ask for access, or choose another place",
    errno.ENOTDIR: "part of this path is a file, not a folder",
    errno.EISDIR: "this is a folder, a file was expected",
    errno.ENAMETOOLONG: "this name is too long for the disk; choose a shorter one",
    errno.ENOENT: "this file or folder does not exist",
}


class OneSentence(TyperGroup):
    """Tells a value that no option takes like all other bad input, and that it was stopped.

    Typer ends the program without a word on a KeyboardInterrupt that it meets.
    """

    def invoke(self, ctx: Any) -> Any:  # typer keeps its type of context to itself
        """Run the command whose values `ctx` holds."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            complain(STOPPED)
            raise typer.Exit(stopping.exit_code()) from None
        except typer.BadParameter as error:
            words = " ".join(error.format_message().split()).rstrip(".")
            words = words.replace(": Value error, ", ": ")  # how pydantic begins a sentence of ours
            command = ctx.command_path if error.ctx is None else error.ctx.command_path
            sentence = f"{words[0].lower()}{words[1:]}; see {command} --help"
            raise InputError(sentence) from error


app = typer.Typer(
    cls=OneSentence,
    name="vrcomfort",
    help="Comfort experiments for stereo head-mounted displays: run, play back, report.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

for module in (
    run,
    simulate,
    render,
    play,
    import_trace,
    import_answers,
    report,
    score,
    pack,
    design,
    new,
    check,
    schema,
    passes,
    power,
    doctor,
    demo,
    tradeoff,
    undo_withdrawal,
    exclude,
    verify,
    status,
    anonymise,
    export,
):
    module.register(app)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"vrcomfort {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Comfort experiments for stereo head-mounted displays: run, play back, report."""


def main() -> None:
    """Run the command line; bad input ends with one sentence and exit code 2."""
    try:
        _run()
    except OSError as error:
        if error.errno != errno.EIO or not stopping.terminal_closed():
            raise
        sys.exit(stopping.exit_code())  # nobody to say it to
    finally:
        if stopping.terminal_closed():
            _drop_unwritten()


def _run() -> None:
    try:
        app(prog_name="vrcomfort")
    except InputError as error:
        for each in (error.alone, *error.others):
            complain(str(each))
        sys.exit(EXIT_BAD_INPUT)
    except BrokenPipeError:
        # The reader (`| head`) has gone: nothing to say, and nobody to say it to.
        _drop_unwritten()
        sys.exit(1)
    except KeyboardInterrupt:  # before a command began
        complain(STOPPED)
        sys.exit(stopping.exit_code())
    except OSError as error:
        if error.errno not in FAULTS_OF_THE_MACHINE:
            raise
        place = f"{error.filename}: " if error.filename else ""
        complain(f"{place}{FAULTS_OF_THE_MACHINE[error.errno]}")
        sys.exit(EXIT_BAD_INPUT)


def _drop_unwritten() -> None:
    """Send to nowhere what a stream cannot write; Python would try once more, and exit with 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
