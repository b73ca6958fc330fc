"""The `vrcomfort` command: collects the sub-commands and turns bad input into one sentence."""

from __future__ import annotations

import errno
import os
import sys
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_group

from vrcomfort import __version__
from vrcomfort.cli import stopping
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


COMMANDS = {
    "run": "run",
    "simulate": "simulate",
    "render": "render",
    "play": "play",
    "import-trace": "imports",
    "import": "imports",
    "report": "report",
    "score": "report",
    "pack": "study_folder",
    "design": "design",
    "new": "new",
    "check": "check",
    "schema": "new",
    "passes": "passes",
    "plan": "passes",
    "power": "design",
    "doctor": "doctor",
    "demo": "simulate",
    "tradeoff": "tradeoff",
    "undo-withdrawal": "participants",
    "exclude": "participants",
    "undo-exclusion": "participants",
    "note": "participants",
    "verify": "study_folder",
    "status": "study_folder",
    "anonymise": "study_folder",
    "export": "study_folder",
}
"""Command → module in `vrcomfort.cli` that registers it, in the order of the help."""

STYLE: dict[str, Any] = {"rich_markup_mode": "markdown", "pretty_exceptions_enable": False}


class LazyCommands(TyperGroup):
    """Imports a command's module when the command is asked for; reports bad values as bad input.

    All modules together take longer to import than most commands run. Typer ends the program
    without a word on a KeyboardInterrupt that it meets; here it is one sentence.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands."""
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by its name, or None."""
        if cmd_name in COMMANDS and cmd_name not in self.commands:
            with stopping.at_once():
                module = import_module(f"vrcomfort.cli.{COMMANDS[cmd_name]}")
            group = typer.Typer(**STYLE)
            group.callback()(_options)  # without it, typer makes no group of a single command
            module.register(group)
            self.commands.update(get_group(group).commands)
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return a command and the rest of its words; a misspelt one is compared with all names."""
        if args[0] not in COMMANDS:
            for name in COMMANDS:
                self.get_command(ctx, name)
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:  # typer keeps its type of context to itself
        """Run a command; report bad values, and an interrupt, in one sentence."""
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
    cls=LazyCommands,
    name="vrcomfort",
    help="Comfort experiments for stereo head-mounted displays: run, play back, report.",
    no_args_is_help=True,
    **STYLE,
    context_settings={"help_option_names": ["-h", "--help"]},
)


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
    """Discard unwritable output: Python would try to flush it again, and exit with 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
