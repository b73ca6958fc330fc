"""Options and arguments that several commands have, with their help."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from dataclasses import MISSING, fields
from inspect import Parameter, Signature
from pathlib import Path
from subprocess import list2cmdline
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import typer

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from vrcomfort.protocol import Condition, Protocol

Options = TypeVar("Options")


def declared_by(
    options: type[Options],
) -> Callable[[Callable[[typer.Context, Options], None]], Callable[..., None]]:
    """Give a command the arguments and options that the fields of a dataclass declare.

    The command is called with its context and an instance of the dataclass.
    """
    hints = get_type_hints(options, include_extras=True)
    taken = [Parameter("ctx", Parameter.KEYWORD_ONLY, annotation=typer.Context)]
    for each in fields(options):  # type: ignore[arg-type]
        default = Parameter.empty if each.default is MISSING else each.default
        hint = hints[each.name]
        taken.append(Parameter(each.name, Parameter.KEYWORD_ONLY, default=default, annotation=hint))

    def decorate(command: Callable[[typer.Context, Options], None]) -> Callable[..., None]:
        def typed(ctx: typer.Context, **values: Any) -> None:
            command(ctx, options(**values))

        typed.__name__, typed.__doc__ = command.__name__, command.__doc__
        typed.__annotations__ = {}
        typed.__signature__ = Signature(taken)  # type: ignore[attr-defined]  # what typer reads
        return typed

    return decorate


Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print no progress and no confirmations.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, for programs.")]
Seed = Annotated[int, typer.Option(help="Every random choice derives from it.", min=0)]
StudySeed = Annotated[
    int | None,
    typer.Option(
        help="Every random choice derives from it. A study keeps its first one (else 0).", min=0
    ),
]
Size = Annotated[str, typer.Option(metavar="WxH", help="Pixels of one eye's image.")]
ParticipantsOption = Annotated[
    int,
    typer.Option("--participants", "-n", help="Number of participants.", min=1, max=10_000),
]
DrawOption = Annotated[
    bool,
    typer.Option("--draw/--no-draw", help="Draw frames; without, time jumps from event to event."),
]
ProtocolArgument = Annotated[
    str, typer.Argument(metavar="PROTOCOL", help="Protocol file, or a shipped one such as smoke.")
]
StudyArgument = Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")]


def output_path(text: str | Path) -> Path:
    """Return where results go; an empty text, such as that of an unset variable, is no place.

    Raises
    ------
    typer.BadParameter
        Which the command line tells with the option's name.
    """
    if not str(text).strip():
        raise typer.BadParameter("it is empty; write where the results go, . for this folder")
    return Path(text)


def output_option(*names: str, help: str) -> Any:  # noqa: A002 - as typer calls it
    """Return the option of a command for a path that it writes to (:func:`output_path`)."""
    return typer.Option(*names, parser=output_path, metavar="PATH", help=help)


StudyFolder = Annotated[Path, output_option("--out", help="Study folder; created if missing.")]
MemoryOption = Annotated[
    str,
    typer.Option(metavar="SIZE", help="Memory limit for reading frames, such as 512MB."),
]
GroupReadable = Annotated[
    bool,
    typer.Option("--group-readable", help="Let your group read a new study's files."),
]
WithoutOption = Annotated[
    list[str] | None,
    typer.Option("--without", metavar="SESSION", help="Leave a session out, such as P07/ses-2."),
]
AcceptFlaggedOption = Annotated[
    bool,
    typer.Option(
        "--accept-flagged", help="Continue although verify finds faults; they are recorded."
    ),
]
TrustOption = Annotated[
    str | None,
    typer.Option(
        metavar="HASH", help="Consent to running the protocol's own Python files with this hash."
    ),
]
TraceOption = Annotated[
    Path | None, typer.Option(help="Head trace (CSV); by default the walk shipped with the scene.")
]
ExposureOption = Annotated[
    float | None,
    typer.Option(
        help="Shorten exposures to this length, in s; recorded.",
        min=0.001,
    ),
]
RefreshRate = Annotated[
    float | None, typer.Option(help="Display rate, in Hz; by default the trace's.", min=0.1)
]


def parse_size(text: str) -> tuple[int, int]:
    """Read ``WIDTHxHEIGHT`` in pixels.

    Raises
    ------
    InputError
        If it is not two positive whole numbers, or larger than any headset's eye.
    """
    width, _, height = (side.lstrip("0") for side in text.lower().partition("x"))
    given = text if len(text) <= 40 else f"{text[:40]}…"
    if not (width.isdecimal() and height.isdecimal()):
        raise InputError(f"--size {given!r} is not a size; write WIDTHxHEIGHT, for example 640x800")
    # Digits are counted first: int() refuses thousands of them with a sentence of its own.
    if max(len(width), len(height)) > 4 or max(int(width), int(height)) > 8192:
        raise InputError(
            f"--size {given!r} has a side of more than 8192 pixels; choose a smaller one"
        )
    return int(width), int(height)


def typed_words(ctx: typer.Context) -> str:
    """Return a command line of the same meaning, ready to be typed again."""
    words = ctx.command_path.split()
    for each in ctx.command.params:
        source = ctx.get_parameter_source(each.name or "")
        # Defaults are left out: they mean the same again, and may change with the protocol.
        if source is not None and source.name == "COMMANDLINE":
            value = ctx.params[each.name or ""]
            for one in value if isinstance(value, list | tuple) else [value]:
                if each.param_type_name == "option":
                    words.append(each.opts[0] if one is not False else each.secondary_opts[0])
                if not isinstance(one, bool):
                    words.append(str(one))
    return list2cmdline(words) if sys.platform == "win32" else shlex.join(words)


CovariateOption = Annotated[
    list[str] | None,
    typer.Option(
        "--covariate",
        metavar="NAME=VALUE",
        help="Covariate of a new participant, as in the protocol's [[covariates]]; once for each.",
    ),
]


def parse_covariates(texts: list[str] | None) -> dict[str, str]:
    """Read ``NAME=VALUE`` texts.

    Raises
    ------
    InputError
        If one has no `=`, or a name comes twice.
    """
    known: dict[str, str] = {}
    for text in texts or []:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError(f"--covariate {text!r} says nothing; write NAME=VALUE, as age=34")
        if name in known:
            raise InputError(f"--covariate {name} is given twice; give it once")
        known[name] = value
    return known


LanguageOption = Annotated[
    str | None,
    typer.Option(
        help="Language of the participant, one of the protocol's `languages`; by default that of "
        "their last session, else the protocol's first."
    ),
]
SceneOption = Annotated[
    str, typer.Option(metavar="NAME|FILE.glb", help="A shipped scene, or any glTF 2.0 file.")
]
Out = Annotated[Path, output_option(help="Folder for the results; earlier ones are replaced.")]
ProtocolOption = Annotated[
    str | None, typer.Option(help="Protocol (file or name) that defines the condition.")
]
ConditionOption = Annotated[
    str | None,
    typer.Option(
        help="A condition of the protocol. Without one: depth of field and rotation-cancelled "
        "motion blur with their default settings."
    ),
]


def pick_condition(
    protocol: str | None, condition: str | None
) -> tuple[Protocol | None, Condition]:
    """Return the condition that a pair of options names; without both, the default.

    Raises
    ------
    InputError
        If only one of the two is given, or the protocol has no such condition.
    """
    from vrcomfort.api.views import DEFAULT_CONDITION
    from vrcomfort.protocol import load_protocol

    if protocol is None:
        if condition is not None:
            raise InputError("--condition needs --protocol, the file that defines it")
        return None, DEFAULT_CONDITION
    study = load_protocol(protocol)
    names = [each.name for each in study.conditions]
    if condition is None or condition not in names:
        given = f"no condition {condition!r}" if condition else "--condition is missing"
        raise InputError(f"{given}; protocol {study.name} has: {', '.join(names)}")
    return study, study.condition(condition)
