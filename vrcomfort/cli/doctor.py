"""`doctor`: what this machine has, what it lacks, and the remedy."""

from __future__ import annotations

import platform
import sys
import warnings
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table
from rich.text import Text

from vrcomfort import __version__
from vrcomfort.cli import doctor_openxr
from vrcomfort.cli.doctor_finding import Finding
from vrcomfort.cli.options import Json
from vrcomfort.cli.terminal import answer, console, progress_bar
from vrcomfort.errors import InputError, pip_install
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    import moderngl

_MARKS = {
    (True, True): ("ok", "green"),
    (True, False): ("ok", "green"),
    (False, True): ("missing", "bold red"),
    (False, False): ("–", "yellow"),
}


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(doctor)


def doctor(
    timing: Annotated[
        bool, typer.Option("--timing", help="Show two still images for 5 s and count frames.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Say what is there and what is missing, each with the remedy.

    The exit code is 1 if something is missing that every use of vrcomfort needs. A headset is not:
    playback, rendering and reports work without.

    - `vrcomfort doctor`
    - `vrcomfort doctor --timing`
    - `vrcomfort doctor --json`
    """
    with progress_bar("looking", None, quiet=False):
        findings = list(_examine(timing=timing))
    if as_json:
        answer([asdict(finding) for finding in findings])
    else:
        _show(findings)
    if any(finding.needed and not finding.ok for finding in findings):
        raise typer.Exit(1)


def _examine(*, timing: bool) -> Iterator[Finding]:
    yield _python()
    finding, ctx = _opengl()
    yield finding
    yield _windows()
    yield _video()
    yield _data()
    yield from doctor_openxr.examine(ctx, timing=timing)
    if ctx is not None:
        ctx.release()


def _show(findings: list[Finding]) -> None:
    table = Table(title=f"vrcomfort {__version__}", title_justify="left")
    for column in ("", "part", "found", "remedy"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        mark = Text(*_MARKS[finding.ok, finding.needed])
        table.add_row(mark, finding.part, finding.found, finding.remedy)
    console(wrap=True).print(table)


def _python() -> Finding:
    ok = sys.version_info >= (3, 11)
    return Finding("Python", ok, platform.python_version(), "" if ok else "install Python 3.11")


def _opengl() -> tuple[Finding, moderngl.Context | None]:
    from vrcomfort.gpu.gl import VERSION_NAME, create_context, describe

    try:
        context = create_context()
    except InputError as error:
        return Finding("OpenGL", False, "no context", str(error)), None
    facts = describe(context)
    kind = "EGL" if sys.platform.startswith("linux") else "WGL"
    there = f"{facts['version']} on {facts['renderer']}, by {kind}, without a window"
    words = f"{there}; needed: {VERSION_NAME}"
    return Finding("OpenGL", True, words), context


def _windows() -> Finding:
    """Look for a screen to put windows on: GLX on X11 or XWayland, WGL on Windows."""
    try:
        import glfw
    except ImportError:
        remedy = f"for sessions in a window: {pip_install('glfw')}"
        return Finding("windows", False, "GLFW is not installed", remedy, needed=False)
    with warnings.catch_warnings(action="ignore", category=glfw.GLFWError):
        there = glfw.init()
    if not there:
        remedy = "for sessions in a window: start them on a desktop, or under Xvfb"
        return Finding("windows", False, "no screen", remedy, needed=False)
    mode = glfw.get_video_mode(glfw.get_primary_monitor()) if glfw.get_monitors() else None
    glfw.terminate()
    kind = "WGL" if sys.platform == "win32" else "GLX"
    screen = f", {mode.size.width}×{mode.size.height} at {mode.refresh_rate} Hz" if mode else ""
    return Finding("windows", True, kind + screen, needed=False)


def _video() -> Finding:
    import av

    codecs = [name for name in ("libx264", "mpeg4") if name in av.codecs_available]
    remedy = f"reinstall PyAV from its wheel: {pip_install('av', again=True)}"
    return Finding(
        "video encoder", bool(codecs), ", ".join(codecs) or "none", "" if codecs else remedy
    )


def _data() -> Finding:
    try:
        scenes = sorted(path.stem for path in data_folder("scenes").glob("*.glb"))
    except FileNotFoundError as error:
        return Finding("scenes", False, "none", str(error))
    remedy = "" if scenes else "reinstall vrcomfort"
    return Finding("scenes", bool(scenes), ", ".join(scenes) or "none", remedy)
