"""Runs many small cases in one process, each told as it begins and ends, under a limit of memory.

    python -m torture.worker torture.inputs FOLDER 3

reads lines of `number seed` and answers each with a line of JSON. A case that falls, hangs or takes
too much memory ends or is ended with its worker, and the next begins in a fresh one.
"""

from __future__ import annotations

import importlib
import json
import os
import resource
import select
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from torture.case import HANG, OTHER, TRACEBACK, Outcome
from torture.session import RUNNING, environment, kill_group, last_line

START_TIMEOUT_S = 120.0


def main() -> None:
    """Take cases until there are no more."""
    module, folder, gigabytes = sys.argv[1:]
    if int(gigabytes):
        limit = int(gigabytes) << 30
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what a case prints is no answer
    cases: Any = importlib.import_module(module)
    print("{}", file=answers, flush=True)  # ready: from here on time is that of cases
    for line in sys.stdin:
        number, seed = map(int, line.split())
        answer = _judge(cases, Path(folder), number, seed)
        print(json.dumps(answer), file=answers, flush=True)


def _judge(cases: Any, folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Run a case: it returns what became of it, or raises what should never be raised.

    A note on what it raises is its name.
    """
    try:
        found: dict[str, Any] = cases.case(folder, number, seed)
    except Exception as error:  # of any kind: it is what this looks for
        where = error.__traceback__
        while where is not None and where.tb_next is not None:
            where = where.tb_next
        place = f"{where.tb_frame.f_code.co_filename}:{where.tb_lineno}" if where else ""
        detail = f"{type(error).__name__}: {str(error)[:200]} ({place})"
        names = getattr(error, "__notes__", [])
        return {"fault": TRACEBACK, "detail": detail} | ({"name": names[0]} if names else {})
    return found


@contextmanager
def named(name: str) -> Iterator[None]:
    """Give what is raised inside the name of its case."""
    try:
        yield
    except Exception as error:
        error.add_note(name)
        raise


class Workers:
    """A worker for each thread that asks; a case that hangs ends its worker.

    Parameters
    ----------
    module
        Has `case(folder, number, seed)`.
    name
        Of a case that does not return its own.
    gigabytes
        Of address space; 0 is no limit.
    case_s
        Time limit of a case.
    renewed
        After so many cases a worker is replaced.
    """

    def __init__(
        self,
        module: str,
        folder: Path,
        *,
        name: Callable[[int], str],
        gigabytes: int,
        case_s: float,
        renewed: int = 10**9,
    ) -> None:
        self._words = [sys.executable, "-m", "torture.worker", module]
        self._folder, self._gigabytes = folder, gigabytes
        self._case_s, self._renewed, self._name = case_s, renewed, name
        self._mine = threading.local()
        self._all: list[subprocess.Popen[bytes]] = []

    def run(self, number: int, seed: int) -> Outcome:
        """Have a case run."""
        worker = self._worker()
        asked = f"{number} {seed}\n".encode()
        with suppress(BrokenPipeError):  # it does not even start: its end is the answer
            worker.stdin.write(asked)
            worker.stdin.flush()
        answer = self._answer(worker, self._case_s)
        self._mine.count += 1
        if answer is None or self._mine.count >= self._renewed:
            self._end(worker)
        answer = answer or self._end_of(worker)
        return Outcome(**{"name": self._name(number), "seed": seed, **answer})

    def _worker(self) -> Any:
        worker = getattr(self._mine, "worker", None)
        if worker is None or worker.poll() is not None:
            folder = self._folder / f"worker{threading.get_ident()}"
            folder.mkdir(parents=True, exist_ok=True)
            self._mine.log = folder / "said.txt"
            with self._mine.log.open("wb") as said:
                worker = subprocess.Popen(
                    [*self._words, str(folder), str(self._gigabytes)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=said,
                    start_new_session=True,
                    env=environment(),
                )
            self._all.append(worker)
            RUNNING.add(worker)
            self._mine.worker, self._mine.count = worker, 0
            self._answer(worker, START_TIMEOUT_S)
        return worker

    def _answer(self, worker: Any, timeout_s: float) -> dict[str, Any] | None:
        ready, _, _ = select.select([worker.stdout], [], [], timeout_s)
        if not ready:
            self._mine.late = True
            return None
        self._mine.late = False
        line = worker.stdout.readline()
        return json.loads(line) if line else None

    def _end_of(self, worker: Any) -> dict[str, Any]:
        if self._mine.late:
            return {"fault": HANG, "detail": f"not over after {self._case_s:g} s"}
        said = self._mine.log.read_text(errors="replace")
        kind = TRACEBACK if "Traceback" in said else OTHER
        return {"fault": kind, "detail": f"ended with {worker.returncode}: {last_line(said)}"}

    def _end(self, worker: Any) -> None:
        if not self._mine.late:  # it may be about to say why
            worker.stdin.close()
            with suppress(subprocess.TimeoutExpired):
                worker.wait(5.0)
        _put_away(worker)

    def close(self) -> None:
        """End all workers."""
        for worker in self._all:
            _put_away(worker)


def _put_away(worker: Any) -> None:
    kill_group(worker)
    for pipe in (worker.stdin, worker.stdout):
        with suppress(BrokenPipeError):
            pipe.close()


@contextmanager
def workers(module: str, folder: Path, **limits: Any) -> Iterator[Workers]:
    """Yield workers, and end them."""
    made = Workers(module, folder, **limits)
    try:
        yield made
    finally:
        made.close()


if __name__ == "__main__":
    main()
