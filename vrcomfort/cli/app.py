"""The `vrcomfort` command: collects the sub-commands and turns bad input into one sentence."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_group

from vrcomfort import __version__
from vrcomfort.cli import stopping
from vrcomfort.cli.terminal import EXIT_BAD_INPUT, complain
from vrcomfort.errors import InputError

STOPPED = "stopped; what was already written stays"
FAULTS_OF_THE_MACHINE = {
    errno.ENOSPC: "the disk is full; what was already written stays",
    errno.EDQUOT: "your disk quota is used up; what was already written stays",
    errno.EROFS: "the disk is read-only; choose another place",
    errno.EACCES: "no permission; ask for access, or choose another place",
    errno.ENOTDIR: "part of this path is a file, not a folder",
    errno.EEXIST: "a file of this name is in the way; choose another place",
    errno.EISDIR: "this is a folder, a file was expected",
    errno.ENAMETOOLONG: "this name is too long for the disk; choose a shorter one",
    errno.ENOENT: "this file or folder does not exist",
}


class Listed(NamedTuple):
    """A command's help before its module is imported."""

    module: str
    """In `vrcomfort.cli`; its `register` adds the command."""
    help: str
    """First paragraph of the command's docstring."""
    hidden: bool = False


GROUPS = {
    "Study": {
        "new": Listed("new", "Write a commented protocol for a new study."),
        "check": Listed(
            "check",
            "Check protocols before recruitment; the exit code is 2 if one has a fault.",
        ),
        "design": Listed(
            "design", "Show the orders and groups of all participants, and their balance."
        ),
        "power": Listed(
            "design",
            "Estimate the power of a plan's primary test by simulating studies.",
        ),
        "preflight": Listed(
            "preflight", "Check machine, headset and room before participants arrive."
        ),
        "run": Listed("run", "Run one session of one participant."),
        "simulate": Listed(
            "simulate",
            "Run all sessions of simulated participants, with every frame rendered.",
        ),
        "status": Listed(
            "study_folder",
            "Show a study's participants, next steps and disk usage.",
        ),
        "note": Listed(
            "participants", "Add a note on a participant to participants.csv, with its date."
        ),
        "exclude": Listed("participants", "Exclude a participant from all analyses."),
        "undo-exclusion": Listed("participants", "Undo the exclusion of a participant."),
        "undo-withdrawal": Listed("participants", "Undo a mistaken withdrawal of a participant."),
    },
    "Data": {
        "import": Listed(
            "imports",
            "Import another lab's questionnaire answers (head traces: `import-trace`).",
        ),
        "verify": Listed(
            "study_folder",
            "Check the integrity of a study folder: files, rows, ids, times, checksums.",
        ),
        "pack": Listed(
            "study_folder",
            "Write Parquet files beside frames.csv, gaze.csv and long ratings.csv: faster reports.",
        ),
        "export": Listed(
            "study_folder",
            "Export a study as BIDS (motion, gaze, events, answers) or Psych-DS (tables).",
        ),
        "anonymise": Listed(
            "study_folder",
            "Copy a study with new ids and dates, without notes, head motion and gaze.",
        ),
        "erase": Listed(
            "participants",
            "Delete all data of a participant on request. This cannot be undone.",
        ),
    },
    "Scenes and pictures": {
        "render": Listed(
            "render", "Draw one stereo picture with its linear light, depth and settings."
        ),
        "play": Listed("play", "Replay a recorded session, or a head trace in a scene."),
        "import-trace": Listed("imports", "Convert another program's head log to a trace."),
        "passes": Listed(
            "passes",
            "Show the render passes of each condition in each scene, with reasons and cost.",
        ),
        "plan": Listed("passes", "Run `vrcomfort passes`: its name in version 0.1.", hidden=True),
        "tradeoff": Listed(
            "tradeoff", "Measure the cost and the error of each method of blurring."
        ),
    },
    "Analysis": {
        "report": Listed(
            "report",
            "Analyse a study: a page, numbers as JSON and CSV, figures as SVG, PNG and PDF.",
        ),
        "score": Listed(
            "report", "Score questionnaires: a CSV (or JSON) of scores on standard output."
        ),
    },
    "Machine and help": {
        "doctor": Listed(
            "doctor",
            "Check the installation, and name a remedy for each missing part.",
        ),
        "demo": Listed(
            "simulate",
            "Simulate Carnegie & Rhee's study with shortened exposures, render it, and report.",
        ),
        "list": Listed(
            "shipped", "List the shipped scenes, instruments, protocols, effects, tasks or plans."
        ),
        "schema": Listed(
            "new", "Print the JSON Schema of protocols, analysis plans, or scenes' side-cars."
        ),
        "docs": Listed("shipped", "Open the documentation, which needs no network."),
    },
}
"""Title of a group → its commands, in the order of the help."""
COMMANDS = {name: each for group in GROUPS.values() for name, each in group.items()}

OLD_OPTIONS = {
    "play": {"--from": "--from-s", "--to": "--to-s"},
    "simulate": {"--frames": "--draw", "--no-frames": "--no-draw"},
    "tradeoff": {"--scenes": "--scene", "--pose": "--view", "--poses": "--views"},
}
"""Command → names that options had in version 0.2 → their names; the help has the latter alone."""

UsageError: Any = typer.BadParameter.__base__
"""Misspelt commands and options, too; typer exports no name for it."""

STYLE: dict[str, Any] = {"rich_markup_mode": "markdown", "pretty_exceptions_enable": False}


class LazyCommands(TyperGroup):
    """Imports a command's module when the command is called; reports bad values as bad input.

    All modules together take longer to import than most commands run; the help imports none.
    Typer ends the program without a word on a KeyboardInterrupt that it meets; here it is one
    sentence.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands."""
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by its name, or None."""
        if cmd_name in COMMANDS and cmd_name not in self.commands:
            with stopping.at_once():
                module = import_module(f"vrcomfort.cli.{COMMANDS[cmd_name].module}")
            group = typer.Typer(**STYLE)
            group.callback()(_options)  # without it, typer makes no group of a single command
            module.register(group)
            self.commands.update(get_group(group).commands)
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return a command and the rest of its words; a misspelt one is compared with all names."""
        if args[0] not in COMMANDS:
            return self._listed().resolve_command(ctx, args)
        return super().resolve_command(ctx, [args[0], *_renamed(args[0], args[1:])])

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help from the listed commands; no module is imported."""
        self._listed().format_help(ctx, formatter)

    def _listed(self) -> TyperGroup:
        """Return this group with commands that have names and help alone."""
        commands: dict[str, Any] = {
            name: TyperCommand(name, help=each.help, hidden=each.hidden, rich_help_panel=title)
            for title, group in GROUPS.items()
            for name, each in group.items()
        }
        return TyperGroup(
            name=self.name,
            help=self.help,
            params=self.params,
            commands=commands,
            rich_markup_mode=self.rich_markup_mode,
        )

    def invoke(self, ctx: Any) -> Any:  # typer keeps its type of context to itself
        """Run a command; report bad values, and an interrupt, in one sentence."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            complain(STOPPED)
            raise typer.Exit(stopping.exit_code()) from None
        except UsageError as error:
            words = " ".join(error.format_message().split()).rstrip(".")
            words = words.replace(": Value error, ", ": ")  # how pydantic begins a sentence of ours
            command = ctx.command_path if error.ctx is None else error.ctx.command_path
            words = words.replace(". Did you mean", "; did you mean")
            see = " See" if words.endswith("?") else "; see"
            raise InputError(f"{words[0].lower()}{words[1:]}{see} {command} --help") from error


def _renamed(command: str, words: list[str]) -> Iterator[str]:
    """Yield the words of a command with the names that its options have now."""
    new = OLD_OPTIONS.get(command, {})
    for word in words:
        name, equals, value = word.partition("=")
        yield f"{new.get(name, name)}{equals}{value}"


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
