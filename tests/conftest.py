"""Shared fixtures: one OpenGL context, checked after each test that uses it; a browser."""

from __future__ import annotations

import atexit
import ctypes
import gc
import os

# Read when numpy, FLIP and Mesa are loaded: threads of several workers would wait for each other.
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "LP_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

# ruff: noqa: E402
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any

import moderngl
import pytest
from hypothesis import HealthCheck, settings

from tests.support import drawn
from tests.support.browser import find_browser
from tests.support.kept_programs import KeptPrograms
from tests.support.openxr import fresh_monado
from vrcomfort.cli import main
from vrcomfort.gpu import gl
from vrcomfort.headset.monado import Monado, RemoteFeed
from vrcomfort.resources import data_folder
from vrcomfort.scene import load
from vrcomfort.scene.gltf.budget import SceneBudget
from vrcomfort.session import exposure

# A busy machine fails no test. The same code meets the same examples: `make explore` draws others.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("same", UNHURRIED, derandomize=True, database=None)
settings.register_profile("explore", UNHURRIED, max_examples=2000)
settings.load_profile("same")

KINDS = ("Texture", "Buffer", "Framebuffer", "Program", "VertexArray", "Query", "Sampler")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="write the golden images instead of comparing"
    )
    parser.addoption("--draw", action="store_true", help="draw the figures of all reports ")
    parser.addoption(
        "--extreme-cases", type=int, default=40, help="cases of each fuzz test of extremes"
    )
    parser.addoption(
        "--exposures", type=int, default=12, help="exposures with random faults of a runtime"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Draw where that is asked for."""
    if config.getoption("--draw"):
        drawn.FORMS.append("svg")


def pytest_collection() -> None:
    """Look for cycles when thousands of tests have been made, and not again and again meanwhile."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Leave alone what has been imported; look for new cycles less often than Python does."""
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)
    gc.enable()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say what was skipped and may not be, and what fuzz tests and oracles have tried."""
    if _may_not_skip() and (skipped := terminalreporter.getreports("skipped")):
        terminalreporter.write_line(f"failed: {len(skipped)} skipped; here nothing may be missing")
    passed = terminalreporter.getreports("passed")
    oracles = [each for each in passed if "stats/test_oracles.py" in each.nodeid]
    if values := sum(dict(each.user_properties).get("values", 1) for each in oracles):
        terminalreporter.write_line(f"oracles: {values} values are those of R and NIST")
    tried = {
        report.nodeid.rpartition("::")[2]: dict(report.user_properties)["cases"]
        for report in passed
        if "cases" in dict(report.user_properties)
    }
    if tried:
        terminalreporter.write_line(f"extremes: {sum(tried.values())} cases, all within bounds")
        for name, cases in tried.items():
            terminalreporter.write_line(f"  {cases:6d} {name}")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Let the run fail where a test was skipped that may not be."""
    atexit.register(gc.unfreeze)  # what is never collected, packages call leaked
    reporter = session.config.pluginmanager.getplugin("terminalreporter")
    if _may_not_skip() and reporter and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def _may_not_skip() -> bool:
    """Return whether nothing may be missing: in CI, scripts/bare.sh, scripts/in_runtime.sh."""
    return "VRCOMFORT_RUNTIME" in os.environ or "CI" in os.environ


@pytest.fixture(scope="session", autouse=True)
def _consents_of_their_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What a test consents to is not kept among the consents of who runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("XDG_CONFIG_HOME", "APPDATA"):
            patch.setenv(name, str(tmp_path_factory.mktemp("consents")))
        yield


@pytest.fixture(scope="session", autouse=True)
def _no_waiting_for_the_disk() -> Iterator[None]:
    """Nothing but a power cut tells what is synced: tests of it look at the calls themselves."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("fsync", "fdatasync"):
            patch.setattr(os, name, lambda _: None, raising=False)
        yield


@pytest.fixture(scope="session", autouse=True)
def _what_was_imported_stays_frozen() -> Iterator[None]:
    """An exposure thaws it, and the next collection would look at all of it again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exposure, "collector_at_rest", nullcontext)
        yield


@pytest.fixture(scope="session", autouse=True)
def _shipped_scenes_are_read_once() -> Iterator[None]:
    """Reading them takes longer than most tests of what is shown in them; nothing changes one."""
    read = cache(load._read)

    def reading(path: Path, budget: SceneBudget | None) -> Any:
        shipped = budget is None and path.parent == data_folder("scenes")
        return (read if shipped else read.__wrapped__)(path, budget)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(load, "_read", reading)
        yield


@pytest.fixture(scope="session", autouse=True)
def _programs_are_kept() -> Iterator[None]:
    """Those of each context, also of one that a command makes: conditions have many in common."""
    make = gl.create_context

    def create_context() -> moderngl.Context:
        ctx = make()
        ctx.kept_programs = KeptPrograms(ctx)
        return ctx

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gl, "create_context", create_context)
        yield


@pytest.fixture(scope="session")
def session_context(_programs_are_kept: None) -> Iterator[moderngl.Context]:
    """Yield the context of the whole run; tests ask for `ctx`."""
    ctx = gl.create_context()
    yield ctx
    ctx.release()


class Alive:
    """The names of all live objects of one kind.

    Some drivers count names up and never use one again: only names that are new since the last
    count are looked at. Others, as Mesa 25, give the lowest free name: all are looked at.
    """

    LONGEST_GAP = 256
    """Free names below a live one, where free names are given again."""

    def __init__(self, ctx: moderngl.Context, kind: str) -> None:
        self._exists = gl.function(ctx, f"glIs{kind}", ctypes.c_uint, result=ctypes.c_ubyte)
        self._new_name = _new_program if kind == "Program" else _new_object
        self._ctx, self._kind = ctx, kind
        self._names: list[int] = []
        self._first_unseen = 1
        self._reuses_names = self._new_name(ctx, kind) == self._new_name(ctx, kind)

    def count(self) -> int:
        """Return how many there are now."""
        if self._reuses_names:
            return self._count_all()
        end = self._new_name(self._ctx, self._kind)
        unseen = range(self._first_unseen, end)
        self._names = [name for name in (*self._names, *unseen) if self._exists(name)]
        self._first_unseen = end + 1
        return len(self._names)

    def _count_all(self) -> int:
        name = last = found = 0
        while (name := name + 1) <= last + self.LONGEST_GAP:
            if self._exists(name):
                last, found = name, found + 1
        return found


def _new_program(ctx: moderngl.Context, _: str) -> int:
    name = gl.function(ctx, "glCreateProgram", result=ctypes.c_uint)()
    gl.function(ctx, "glDeleteProgram", ctypes.c_uint)(name)
    return int(name)


def _new_object(ctx: moderngl.Context, kind: str) -> int:
    plural = "Queries" if kind == "Query" else f"{kind}s"
    name = ctypes.c_uint()
    for verb in ("Gen", "Delete"):
        call = gl.function(ctx, f"gl{verb}{plural}", ctypes.c_int, ctypes.c_void_p)
        call(1, ctypes.byref(name))
    return name.value


@pytest.fixture(scope="session")
def count_objects(session_context: moderngl.Context) -> Callable[[], dict[str, int]]:
    """Return a function that counts the live OpenGL objects of each kind.

    Programs that are kept for other tests do not count.
    """
    alive = {kind: Alive(session_context, kind) for kind in KINDS}
    use_program = gl.function(session_context, "glUseProgram", ctypes.c_uint)
    stages = (f"#version 450\nvoid main() {{{body}}}" for body in ("gl_Position = vec4(0);", ""))
    with session_context:
        idle = session_context.simple_framebuffer((1, 1))
        idle_draw = session_context.vertex_array(session_context.program(*stages), [])
        idle_dispatch = session_context.compute_shader(
            "#version 450\nlayout(local_size_x = 1) in;\nvoid main() {}"
        )

    def count() -> dict[str, int]:
        gc.collect()
        idle.use()  # what was used last outlives its last reference
        idle_dispatch.run()
        idle_draw.render(vertices=3)
        use_program(0)
        gl.collect(session_context)
        found = {kind: names.count() for kind, names in alive.items()}
        return found | {"Program": found["Program"] - session_context.kept_programs.idle}

    return count


@pytest.fixture
def ctx(
    session_context: moderngl.Context, count_objects: Callable[[], dict[str, int]]
) -> Iterator[moderngl.Context]:
    """Yield a real EGL context; afterwards no OpenGL error and no object may be left.

    Objects die with their last reference, so a test need not release what it made;
    what stays is a leak (a reference cycle, a cache, a raw OpenGL name).
    """
    # Walking all that was imported takes longer than most tests: what is alive now is looked
    # at once, and left alone by the collections that follow.
    gc.collect()
    gc.freeze()
    # A test before may have made a context of its own, which is then the current one.
    with session_context:
        before = count_objects()
        yield session_context
        gl.check_errors(session_context)
        assert count_objects() == before, "the test left OpenGL objects behind"


@pytest.fixture(scope="module")
def monado(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Monado]:
    """Yield a runtime that the tests of one file share."""
    with fresh_monado(tmp_path_factory.mktemp("monado")) as service:
        yield service


@pytest.fixture(scope="module")
def feed(monado: Monado) -> Iterator[RemoteFeed]:
    """Yield the connection through which its head and hands move."""
    with monado.feed() as connection:
        yield connection


@pytest.fixture(autouse=True)
def _no_progress_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a command says does not depend on how busy the machine is."""
    monkeypatch.setattr("vrcomfort.cli.terminal.SILENT_S", 3600.0)


@pytest.fixture(scope="module")
def browser() -> str:
    """Return the command of a browser that shows pages."""
    found = find_browser()
    if found is None:
        pytest.skip("there is no browser; scripts/browser.sh installs one")
    return found


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str, str]]:
    """Return what runs the command and gives (exit code, stdout, stderr)."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["vrcomfort", *map(str, arguments)])
        code = 0
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capsys.readouterr()
        return code, out, err

    return call
