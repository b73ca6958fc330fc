"""`doctor`: the parts that this machine has and lacks, each with its remedy."""

from __future__ import annotations

import platform
import sys
import warnings
from collections.abc import Container, Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import typer
from rich.table import Table
from rich.text import Text

from vrcomfort import __version__
from vrcomfort.cli.headset_setup import require_bindings
from vrcomfort.cli.options import Json, Quiet
from vrcomfort.cli.terminal import answer, console, progress_bar, warn
from vrcomfort.errors import InputError, pip_install
from vrcomfort.headset.watchdog import Watchdog
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.headset.openxr.capabilities import RuntimeFacts, SessionFacts, SystemFacts
    from vrcomfort.headset.timing import TimingTest


@dataclass(frozen=True)
class Diagnosis:
    """One part that was looked for.

    Parameters
    ----------
    needed
        Whether nothing works without it: in `doctor`, no use of vrcomfort; in a preflight, the
        session that is planned.
    details
        Further facts, for programs.
    """

    part: str
    ok: bool
    found: str
    remedy: str = ""
    needed: bool = True
    details: tuple[str, ...] = ()

    @property
    def outcome(self) -> Literal["ok", "notice", "refuse"]:
        """Return whether it is well, worth a look, or in the way."""
        if self.ok:
            return "ok"
        return "refuse" if self.needed else "notice"


class Extra(NamedTuple):
    """An extra of pyproject.toml: a package that a few options need."""

    name: str
    package: str
    use: str


EXTRAS = (
    Extra("video", "av", "play --video"),
    Extra("lsl", "pylsl", "run --lsl"),
    Extra("ttl", "pyserial", "run --ttl"),
    Extra("sound", "miniaudio", "instructions that are heard"),
    Extra("cluster", "distributed", "report --cluster and tradeoff --cluster"),
)


# The part of `doctor` that looks for a headset: bindings, runtime, headset, session, timing.


TIMING_TEST_S = 5.0
WITHOUT_GAZE = 'gaze.csv stays out; focus.method = "gaze" needs one, or without_gaze = "nine_ray"'
EACH_EYE = "XR_FB_eye_tracking_social"
WITHOUT_EACH_EYE = (
    f"columns of each eye in gaze.csv stay blank; a runtime with {EACH_EYE} fills them (no runtime "
    "tells pupils)"
)
PLAYBACK = "playback, rendering and reports work without"


def examine_openxr(ctx: moderngl.Context | None, *, timing: bool) -> Iterator[Diagnosis]:
    """Yield the parts that are there, up to the first missing one.

    Parameters
    ----------
    ctx
        To begin a session with.
    timing
        Also show images, and count frames.
    """
    with Watchdog(warn):
        yield from _stages(ctx, timing=timing)


def _stages(ctx: moderngl.Context | None, *, timing: bool) -> Iterator[Diagnosis]:
    part = "OpenXR bindings"
    try:
        yield _there(part, f"pyopenxr {require_bindings()}, with its loader")
        from vrcomfort.headset.openxr import capabilities as survey

        part = "OpenXR runtime"
        runtime = survey.find_runtime()
        yield from _openxr_runtime(runtime)
        part = "headset"
        yield from _openxr_headset(survey.find_headset())
        if ctx is None:
            return
        part = "OpenXR session"
        yield from _openxr_session(survey.try_session(ctx))
        if timing:
            part = "timing test"
            yield _timed(survey.try_timing(ctx, TIMING_TEST_S))
    except InputError as error:
        yield Diagnosis(part, False, f"none; {PLAYBACK}", str(error), needed=False)


def _openxr_runtime(facts: RuntimeFacts) -> Iterator[Diagnosis]:
    yield _there("OpenXR runtime", facts.name)
    missed = [name for name in facts.wanted if name not in facts.extensions]
    words = f"{len(facts.extensions)} offered; of those that help, missing: {' '.join(missed)}"
    yield Diagnosis("extensions", True, words, needed=False, details=facts.extensions)
    yield _controllers(facts.extensions)


def _controllers(extensions: Container[str]) -> Diagnosis:
    """Return the supported controllers, and the stop button of each."""
    from vrcomfort.headset.openxr.profiles import PROFILES

    taken = [each for each in PROFILES if each.extension is None or each.extension in extensions]
    words = f"{len(taken)} of {len(PROFILES)} kinds taken: {', '.join(each.name for each in taken)}"
    stops = tuple(f"{each.path}: stop is {each.words('stop')}" for each in taken)
    return Diagnosis("controllers", True, words, needed=False, details=stops)


def _openxr_headset(facts: SystemFacts) -> Iterator[Diagnosis]:
    width, height = facts.recommended_size_px
    yield _there("headset", f"{facts.name}, {width}×{height} pixels per eye recommended")
    yield Diagnosis(
        "eye tracker",
        facts.gaze,
        "there" if facts.gaze else "none",
        "" if facts.gaze else WITHOUT_GAZE,
        needed=False,
    )
    if facts.gaze:
        yield Diagnosis(
            "each eye",
            facts.each_eye,
            f"{EACH_EYE}; no pupils" if facts.each_eye else "not told apart",
            "" if facts.each_eye else WITHOUT_EACH_EYE,
            needed=False,
        )


def _openxr_session(facts: SessionFacts) -> Iterator[Diagnosis]:
    details = facts.details
    words = (
        f"{details['binding'].upper()} binding, images {details['image_format']} "
        f"({details['eye_images']}), space {details['space']}, depth layer {details['depth_layer']}"
    )
    yield _there("OpenXR session", words)
    rates = ", ".join(f"{rate:g}" for rate in facts.refresh_rates_hz) or "not told"
    yield _there("refresh rate", f"{facts.refresh_hz:g} Hz; can switch to: {rates}")
    yield _visibility_mask(facts)
    yield _there("timing_trust", f"{facts.timing.trust}: {facts.timing.reason}")


def _visibility_mask(facts: SessionFacts) -> Diagnosis:
    part, mask = "visibility mask", facts.details["visibility_mask"]
    if isinstance(mask, str):
        return _there(part, f"{mask}; all of each image is drawn")
    left, right = facts.hidden_percent
    return _there(part, f"hides {left:.1f} % (left) and {right:.1f} % (right), which is not drawn")


def _timed(test: TimingTest | None) -> Diagnosis:
    if test is None:
        remedy = "put the headset on (or cover its sensor), then run doctor --timing again"
        return Diagnosis("timing test", False, "the headset sleeps", remedy, needed=False)
    words = (
        f"{test.frames} frames in {test.seconds:.1f} s, {test.dropped} dropped; period "
        f"{test.period_ms:.2f} ms, intervals {test.interval_median_ms:.2f} ms (median) and "
        f"{test.interval_p99_ms:.2f} ms (p99); frames came every {test.wait_median_ms:.2f} ms "
        f"(median) and {test.wait_p99_ms:.2f} ms (p99) by this machine's clock"
    )
    remedy = "close other programs; ask for a lower refresh rate" if test.dropped else ""
    return Diagnosis("timing test", not test.dropped, words, remedy, needed=False)


def _there(part: str, found: str) -> Diagnosis:
    return Diagnosis(part, True, found, needed=False)


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
        bool, typer.Option("--timing", help="Show two still images for 5 s, and count frames.")
    ] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Check the installation, and name a remedy for each missing part.

    The exit code is 1 if something is missing that every use of vrcomfort needs. A headset is not:
    playback, rendering and reports work without.

    - `vrcomfort doctor`
    - `vrcomfort doctor --timing`
    - `vrcomfort doctor --json`
    """
    with progress_bar("looking", None, quiet=quiet or as_json):
        findings = list(_examine(timing=timing))
    if as_json:
        answer([asdict(finding) for finding in findings])
    else:
        _show(findings)
    if any(finding.needed and not finding.ok for finding in findings):
        raise typer.Exit(1)


def _examine(*, timing: bool) -> Iterator[Diagnosis]:
    yield _python()
    finding, ctx = find_opengl()
    yield finding
    if ctx is not None:
        yield find_gpu(ctx)
    yield _windows()
    yield _data()
    yield from map(find_extra, EXTRAS)
    yield from examine_openxr(ctx, timing=timing)
    if ctx is not None:
        ctx.release()


def _show(findings: list[Diagnosis]) -> None:
    table = Table(title=f"vrcomfort {__version__}", title_justify="left")
    for column in ("", "part", "found", "remedy"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        mark = Text(*_MARKS[finding.ok, finding.needed])
        table.add_row(mark, finding.part, finding.found, finding.remedy)
    console(wrap=True).print(table)


def _python() -> Diagnosis:
    ok = sys.version_info >= (3, 11)
    return Diagnosis("Python", ok, platform.python_version(), "" if ok else "install Python 3.11")


def find_opengl() -> tuple[Diagnosis, moderngl.Context | None]:
    """Look for OpenGL without a window; return its context, too."""
    from vrcomfort.gpu.gl import VERSION_NAME, create_context, describe

    try:
        context = create_context()
    except InputError as error:
        return Diagnosis("OpenGL", False, "no context", str(error)), None
    facts = describe(context)
    kind = "EGL" if sys.platform.startswith("linux") else "WGL"
    there = f"{facts['version']} on {facts['renderer']}, by {kind}, without a window"
    words = f"{there}; needed: {VERSION_NAME}"
    return Diagnosis("OpenGL", True, words), context


def find_gpu(ctx: moderngl.Context) -> Diagnosis:
    """Look at the GPU that draws, and for a faster one beside it, as laptops have."""
    from vrcomfort.gpu.adapters import adapters, draws_in_software, faster_adapters, how_to_choose
    from vrcomfort.gpu.gl import describe

    renderer, there = describe(ctx)["renderer"], adapters()
    words = f"{renderer} draws"
    if faster := faster_adapters(renderer, there):
        words = f"{words}; also there: {', '.join(faster)}"
        return Diagnosis("GPU", False, words, how_to_choose(faster[0]), needed=False)
    if draws_in_software(renderer):
        remedy = "for a headset: a GPU with its driver; playback and reports work without"
        return Diagnosis("GPU", False, f"{words}, on the processor", remedy, needed=False)
    return Diagnosis("GPU", True, words, needed=False)


def _windows() -> Diagnosis:
    """Look for a screen to put windows on: GLX on X11 or XWayland, WGL on Windows."""
    try:
        import glfw
    except ImportError:
        remedy = f"for sessions in a window: {pip_install('glfw')}"
        return Diagnosis("windows", False, "GLFW is not installed", remedy, needed=False)
    with warnings.catch_warnings(action="ignore", category=glfw.GLFWError):
        there = glfw.init()
    if not there:
        remedy = "for sessions in a window: start them on a desktop, or under Xvfb"
        return Diagnosis("windows", False, "no screen", remedy, needed=False)
    mode = glfw.get_video_mode(glfw.get_primary_monitor()) if glfw.get_monitors() else None
    glfw.terminate()
    kind = "WGL" if sys.platform == "win32" else "GLX"
    screen = f", {mode.size.width}×{mode.size.height} at {mode.refresh_rate} Hz" if mode else ""
    return Diagnosis("windows", True, kind + screen, needed=False)


def _data() -> Diagnosis:
    try:
        scenes = sorted(path.stem for path in data_folder("scenes").glob("*.glb"))
    except FileNotFoundError as error:
        return Diagnosis("scenes", False, "none", str(error))
    remedy = "" if scenes else "reinstall vrcomfort"
    return Diagnosis("scenes", bool(scenes), ", ".join(scenes) or "none", remedy)


def find_extra(extra: Extra) -> Diagnosis:
    """Look for the package of an extra."""
    part = f"extra {extra.name}"
    try:
        found = f"{extra.package} {version(extra.package)}"
    except PackageNotFoundError:
        remedy = f"for {extra.use}: {pip_install(extra.package)}"
        return Diagnosis(part, False, f"no {extra.package}", remedy, needed=False)
    if extra.package == "av":
        try:
            codecs = _codecs()
        except InputError as error:
            return Diagnosis(part, False, found, str(error), needed=False)
        if not codecs:
            remedy = f"reinstall PyAV from its wheel: {pip_install('av', again=True)}"
            return Diagnosis(part, False, f"{found} without an encoder", remedy, needed=False)
        found += f", {', '.join(codecs)}"
    return Diagnosis(part, True, f"{found}: {extra.use}", needed=False)


def _codecs() -> list[str]:
    from vrcomfort.render.output import require_video

    return [name for name in ("libx264", "mpeg4") if name in require_video().codecs_available]
