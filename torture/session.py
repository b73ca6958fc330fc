"""A session as a victim: started, watched over a pipe, stopped, and compared with what is left."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from torture.case import HANG, OTHER, TRACEBACK, Outcome
from torture.rows import PARTICIPANT, Rows, Told, by_file, missing

STUDY = Path(__file__).with_name("study.toml")
ROOT = Path(__file__).resolve().parent.parent
TRACE = ROOT / "scenes" / "temple_walk.csv"
ANSWER_S = 0.03
LENGTH_S = 12.0
"""About how long a paced session takes from its first row to its last."""

STATES = {
    "questionnaires.csv": "a question",
    "answer": "a question",
    "frames.csv": "an exposure",
    "ratings.csv": "an exposure",
    "rest": "a rest",
}
SLOW_FILES = {"frames.csv", "gaze.csv", "timing.csv"}
SLOW_S, QUICK_S = 1.2, 0.2
"""A row handed to the recorder so long before a power cut must be on the disk: time in which the
machine let the session run."""
STILL_NS = 50_000_000
"""A session that does not say for so long that it runs does not run."""


class Ended(NamedTuple):
    """How a program ended; `code` is None where it had to be killed."""

    code: int | None
    said: str

    def fault(
        self, codes: Iterable[int], *, noted: bool = False, several: bool = False
    ) -> tuple[str, str]:
        """Return the fault of an end that should be one of `codes`, with a sentence if not 0.

        Parameters
        ----------
        noted
            Notes are sentences enough.
        several
            Of a file with several faults, each may have its sentence.
        """
        if self.code is None:
            return HANG, f"still running at its time limit; said: {last_line(self.said)}"
        if "Traceback" in self.said:
            return TRACEBACK, last_line(self.said)
        if self.code not in codes:
            return OTHER, f"exit code {self.code}; said: {last_line(self.said)}"
        sentences = self.said.count("error: ")
        sentences = min(sentences, 1) if several else sentences
        if self.code > 0 and sentences != 1 and not (noted and "note: " in self.said):
            return OTHER, f"exit code {self.code} without one sentence; said: {self.said[-300:]!r}"
        return "", ""


def last_line(text: str) -> str:
    """Return the last line that says anything."""
    return (text.strip().splitlines() or ["nothing"])[-1][:300]


def run_words(study: Path, *more: str) -> list[str]:
    """Return the command that runs the session."""
    return [
        *("run", str(STUDY), "--participant", PARTICIPANT, "--out", str(study)),
        *("--respondent", "simulated", "--size", "32x40", "--refresh-hz", "20"),
        *("--trace", str(TRACE), "--quiet", *more),
    ]


class Victim:
    """A command in a process group of its own, whose rows are told over a pipe.

    Parameters
    ----------
    log
        Where its words go.
    slow
        Frames, rests and answers take their time.
    """

    def __init__(
        self, words: Sequence[str], log: Path, *, slow: bool = True, options: Sequence[str] = ()
    ) -> None:
        self._told: list[Told] = []
        self._gone: Counter[tuple[str, Any]] = Counter()
        self._beats_ns: list[int] = []
        self._log = log
        reading, writing = os.pipe()
        pace = ["--pace", "--answer-s", str(ANSWER_S)] if slow else []
        command = [sys.executable, "-m", "torture.victim", "--tell", str(writing)]
        with log.open("ab") as said:
            self.process = subprocess.Popen(
                [*command, *pace, *options, *words],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
                pass_fds=[writing],
                start_new_session=True,
                env=environment(),
            )
        RUNNING.add(self.process)
        os.close(writing)
        self._listener = threading.Thread(target=self._listen, args=(reading,), daemon=True)
        self._listener.start()

    def _listen(self, reading: int) -> None:
        with os.fdopen(reading, encoding="utf-8") as lines:
            for line in lines:
                if line.endswith("\n"):
                    self._hear(json.loads(line))

    def _hear(self, word: dict[str, Any]) -> None:
        if word["kind"] == "beat":
            self._beats_ns.append(word["ns"])
            return
        told = Told(word["ns"], word["file"], tuple(word["cells"].items()))
        if word["kind"] == "gone":
            self._gone[told.file, told.cells] += 1
        else:
            self._told.append(told)

    def rows(self, file: str | None = None) -> list[Told]:
        """Return what has been told until now, of one file or all."""
        return [each for each in list(self._told) if file in {None, each.file}]

    def state(self) -> str:
        """Return what the session was doing when it told its last row."""
        told = self.rows()
        if not told:
            return "the start"
        last = dict(told[-1].cells).get("name")  # of an event
        return STATES.get(last or told[-1].file, "between")

    def sentences(self) -> int:
        """Return how many sentences it has said; a runtime's own log is none of ours."""
        return sum(line.startswith(("note: ", "error: ")) for line in self.said().splitlines())

    def said(self) -> str:
        """Return what it has written on stderr."""
        return self._log.read_text(encoding="utf-8", errors="replace")

    def wait_for(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until something is so; return whether it was before the end and the time limit."""
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if condition():
                return True
            if self.process.poll() is not None:
                return condition()
            time.sleep(0.005)
        return False

    def send(self, number: int) -> int:
        """Send a signal to the program; return the time, in ns of the monotonic clock."""
        now_ns = time.monotonic_ns()
        if self.process.poll() is None:
            self.process.send_signal(number)
        return now_ns

    def end(self, timeout_s: float) -> Ended:
        """Wait for the end, and make one where there is none; nothing of its group remains."""
        code: int | None
        try:
            code = self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            code = None
        kill_group(self.process)
        self._listener.join(5.0)
        return Ended(code, self.said())

    def must_be_there(self, cut_ns: int | None, *, slow_s: float = QUICK_S) -> Rows:
        """Return the rows that a cut at this time may not take; all where it ended by itself."""
        rows: Rows = Counter()
        if cut_ns is None:
            rows.update((told.file, told.cells) for told in self._told)
            return rows - self._gone
        quick_ns, slow_ns = (
            running_since(self._beats_ns, cut_ns, each) for each in (QUICK_S, slow_s)
        )
        for told in self._told:
            if told.ns < (slow_ns if told.file in SLOW_FILES else quick_ns):
                rows[told.file, told.cells] += 1
        return rows - self._gone


def running_since(beats_ns: Sequence[int], cut_ns: int, running_s: float) -> int:
    """Return since when a session has run for so long until a cut; 0 where it has not.

    Parameters
    ----------
    beats_ns
        When it said that it runs. Where it said nothing for long, the machine kept it waiting.
    """
    later_ns, left_ns = cut_ns, round(running_s * 1e9)
    for beat_ns in sorted((each for each in beats_ns if each < cut_ns), reverse=True):
        left_ns -= min(later_ns - beat_ns, STILL_NS)
        later_ns = beat_ns
        if left_ns <= 0:
            return beat_ns
    return 0


RUNNING: set[subprocess.Popen[Any]] = set()
"""Programs with a process group of their own that must not outlive this one."""


def kill_group(process: subprocess.Popen[Any]) -> None:
    """Kill a program and what it has started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    RUNNING.discard(process)


def kill_all(*_: object) -> None:
    """Kill all programs, and end this one: for a signal."""
    for process in list(RUNNING):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    os._exit(1)


def environment() -> dict[str, str]:
    """Return the environment of victims: this checkout's code, one thread for sums."""
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "1000"}


@dataclass
class Findings:
    """What is held against a case, the worst first."""

    handed: int = 0
    lost: int = 0
    never_asked: int = 0
    fault: str = ""
    details: list[str] = field(default_factory=list)

    def end(self, what: str, ended: Ended, codes: Iterable[int], *, noted: bool = False) -> None:
        """Note how a command ended; see `Ended.fault`."""
        fault, detail = ended.fault(codes, noted=noted)
        if fault:
            self.fault = self.fault or fault
            self.details.append(f"{what}: {detail}")

    def rows(self, when: str, rows: Rows, study: Path) -> None:
        """Note which rows are lost."""
        lost = missing(rows, study)
        self.handed = max(self.handed, rows.total())
        if lost.total() > self.lost:
            self.lost = lost.total()
            self.details.append(f"{when}: lost {by_file(lost)}")

    def outcome(self, *, name: str, seed: int, folder: Path) -> Outcome:
        """Return what became of the case; its files stay only where something is wrong."""
        detail = "; ".join(self.details)
        outcome = Outcome(name, seed, self.handed, self.lost, self.never_asked, self.fault, detail)
        if outcome.happened == "ok":
            shutil.rmtree(folder, ignore_errors=True)
        return outcome
