"""`doctor`: what this machine has, what it lacks, and the remedy."""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass

import typer
from rich.table import Table

from vrcomfort import __version__
from vrcomfort.cli.terminal import Json, answer, console
from vrcomfort.errors import InputError
from vrcomfort.resources import data_folder


@dataclass(frozen=True)
class Finding:
    """One thing that was looked for."""

    part: str
    ok: bool
    found: str
    remedy: str = ""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(doctor)


def doctor(as_json: Json = False) -> None:
    """Say what is there and what is missing, each with the remedy.

    The exit code is 1 if something that vrcomfort needs is missing.

    - `vrcomfort doctor`
    - `vrcomfort doctor --json`
    """
    findings = [check() for check in _CHECKS]
    if as_json:
        answer([asdict(finding) for finding in findings])
    else:
        _show(findings)
    if not all(finding.ok for finding in findings):
        raise typer.Exit(1)


def _show(findings: list[Finding]) -> None:
    table = Table(title=f"vrcomfort {__version__}", title_justify="left")
    for column in ("", "part", "found", "remedy"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        mark = "[green]ok[/]" if finding.ok else "[bold red]missing[/]"
        table.add_row(mark, finding.part, finding.found, finding.remedy)
    console().print(table)


def _python() -> Finding:
    ok = sys.version_info >= (3, 11)
    return Finding("Python", ok, platform.python_version(), "" if ok else "install Python 3.11")


def _opengl() -> Finding:
    from vrcomfort.render.gl import create_context, describe

    try:
        context = create_context()
    except InputError as error:
        return Finding("OpenGL", False, "no context", str(error))
    facts = describe(context)
    context.release()
    return Finding("OpenGL", True, f"{facts['version']} on {facts['renderer']}")


def _video() -> Finding:
    import av

    codecs = [name for name in ("libx264", "mpeg4") if name in av.codecs_available]
    remedy = "" if codecs else "reinstall PyAV from its wheel: pip install --force-reinstall av"
    return Finding("video encoder", bool(codecs), ", ".join(codecs) or "none", remedy)


def _data() -> Finding:
    try:
        scenes = sorted(path.stem for path in data_folder("scenes").glob("*.glb"))
    except FileNotFoundError as error:
        return Finding("scenes", False, "none", str(error))
    remedy = "" if scenes else "reinstall vrcomfort"
    return Finding("scenes", bool(scenes), ", ".join(scenes) or "none", remedy)


_CHECKS: tuple[Callable[[], Finding], ...] = (_python, _opengl, _video, _data)
