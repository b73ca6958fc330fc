"""Runs functions in forked processes: what they import from the package, they import anew."""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
PRELOADED = (
    "duckdb", "hypothesis.strategies", "jinja2", "matplotlib.figure", "moderngl", "numpy",
    "openpyxl", "pandas", "PIL.ImageFont", "pingouin", "pydantic", "pytest", "rich.console",
    "scipy.optimize", "scipy.signal", "scipy.stats", "starlette.applications", "typer", "uvicorn",
)  # fmt: skip
"""What tests import from others, which takes longer than most tests."""


PYTEST = (
    "-q", "-n", "0", "-p", "no:cacheprovider", "--tb=line",
    "-W", "ignore::pytest.PytestAssertRewriteWarning",  # of what is preloaded
)  # fmt: skip


@dataclass(frozen=True)
class Job:
    """A function, and how long it may take."""

    function: Callable[[], Any]
    """What it returns is written as JSON."""
    cpu_s: float
    log: Path
    """What it prints; its result goes beside it."""

    @property
    def wall_s(self) -> float:
        """The longest time on a busy machine."""
        return 60 + 20 * self.cpu_s


@dataclass(frozen=True)
class Ended:
    """How a function ended."""

    result: Any
    """None if the process died."""
    timed_out: bool


def prepare() -> None:
    """Import what children share, but nothing of the package, and limit threads as tests do."""
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(threads, "1")
    for name in PRELOADED:
        import_module(name)


def in_children(jobs: Iterable[tuple[Any, Job]], at_once: int) -> Iterator[tuple[Any, Ended]]:
    """Run jobs, some at once; yield each one's key and end, as they end."""
    waiting = iter(jobs)
    running: dict[int, tuple[Any, Job, float]] = {}
    while True:
        while len(running) < at_once and (following := next(waiting, None)) is not None:
            key, job = following
            running[_fork(job)] = key, job, time.monotonic()
        if not running:
            return
        yield from _ended(running)
        time.sleep(0.02)


def _ended(running: dict[int, tuple[Any, Job, float]]) -> Iterator[tuple[Any, Ended]]:
    for pid, (key, job, began) in list(running.items()):
        late = time.monotonic() - began > job.wall_s
        if late:
            os.killpg(pid, signal.SIGKILL)
        done, status = os.waitpid(pid, 0 if late else os.WNOHANG)
        if not done:
            continue
        del running[pid]
        _end_group(pid)  # programs that a test left behind
        file = _result_file(job)
        result = json.loads(file.read_text("utf-8")) if file.exists() else None
        by = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
        yield key, Ended(result, late or by == signal.SIGXCPU)


def _end_group(pid: int) -> None:
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def _result_file(job: Job) -> Path:
    return job.log.with_suffix(".json")


def _fork(job: Job) -> int:
    job.log.parent.mkdir(parents=True, exist_ok=True)
    _result_file(job).unlink(missing_ok=True)
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return pid
    status = 1
    try:
        os.setsid()
        log = os.open(job.log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        for stream in (1, 2):
            os.dup2(log, stream)
        limit = int(job.cpu_s) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 30))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.chdir(ROOT)
        _result_file(job).write_text(json.dumps(job.function()), "utf-8")
        status = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
