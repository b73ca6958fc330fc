"""Python's own time per frame, recording included: everything that is not inside an OpenGL call.

Beside another revision, or alone. Each side draws in a process of its own (`frame_worker.py`); the
sides take turns every few frames, so that all of them meet the same moments of a busy machine.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from bench.table import Result
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES

ROOT = Path(__file__).resolve().parent.parent
BLOCK = 10
"""Frames that a side draws before it is the next one's turn."""

ROUNDS = 5
CONDITIONS = ("plain", "both effects")


class Side(NamedTuple):
    """Code to be measured: a name for it and where it is checked out."""

    name: str
    checkout: Path


class Worker:
    """A process that draws frames with the code of one checkout; a context manager."""

    def __init__(self, side: Side, files: Path, scene: str, *, effects: bool) -> None:
        trace = str(files / f"{scene}_walk.csv")
        wanted = {"scene": str(files / f"{scene}.glb"), "trace": trace, "effects": effects}
        self._process = subprocess.Popen(
            [sys.executable, str(ROOT / "bench" / "frame_worker.py"), json.dumps(wanted)],
            env={**os.environ, "PYTHONPATH": str(side.checkout)},
            cwd=side.checkout,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.counts: dict[str, int] = self._answer()

    def run(self, frames: int) -> list[dict[str, float]]:
        """Draw the next frames; return their times."""
        assert self._process.stdin is not None  # noqa: S101 - it is a pipe
        print(frames, file=self._process.stdin, flush=True)
        answer: list[dict[str, float]] = self._answer()
        return answer

    def _answer(self) -> Any:
        assert self._process.stdout is not None  # noqa: S101 - it is a pipe
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{' '.join(map(str, self._process.args))} has ended")  # type: ignore[arg-type]
        return json.loads(line)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.communicate()  # the end of its input ends it


def measure(
    *, frames: int, against: str | None, folder: Path, scenes: Sequence[str] = SCENES
) -> Result:
    """Play the walks of shipped scenes, plain and with both effects, with the code of each side.

    Parameters
    ----------
    frames
        Of each round.
    against
        A revision to compare with.
    folder
        Where it is checked out.
    """
    with ExitStack() as owned:
        now = Side("now", ROOT)
        if against is None:
            sides = [now]
        else:
            before = owned.enter_context(checked_out(against, folder / "checkout"))
            sides = [Side(against, before), Side(f"{against} again", before), now]
        files = sides[0].checkout / "scenes"  # the older code need not read newer scenes
        rows = [
            row
            for scene in scenes
            for condition in CONDITIONS
            for row in _rows(sides, files, scene, condition, frames)
        ]
    return Result("Python time per frame, with recording", rows, _notes(frames, against))


@contextmanager
def checked_out(revision: str, folder: Path) -> Iterator[Path]:
    """Check a revision out beside this one, for a while."""

    def git(*words: str) -> None:
        subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True)

    shutil.rmtree(folder, ignore_errors=True)  # of a run that was stopped
    git("worktree", "prune")
    git("worktree", "add", "--force", "--detach", str(folder.resolve()), revision)
    try:
        yield folder.resolve()
    finally:
        git("worktree", "remove", "--force", str(folder.resolve()))


def _rows(
    sides: list[Side], files: Path, scene: str, condition: str, frames: int
) -> Iterator[dict[str, Any]]:
    with ExitStack() as owned:
        workers = [
            owned.enter_context(Worker(side, files, scene, effects=condition != CONDITIONS[0]))
            for side in sides
        ]
        loop_ms, recorder_ms = _milliseconds(workers, frames)
    high = np.percentile(loop_ms, 99, axis=-1)
    ratios = high / high[0]
    for index, (side, worker) in enumerate(zip(sides, workers, strict=True)):
        yield {
            "scene": scene,
            "condition": condition,
            "code": side.name,
            "median ms": float(np.median(loop_ms[index])),
            "p99 ms": float(np.median(high[index])),
            "p99, share of a 90 Hz frame": float(np.median(high[index]) * REFRESH_HZ / 1e3),
            "p99 ratio": float(np.median(ratios[index])),
            "least": float(ratios[index].min()),
            "most": float(ratios[index].max()),
            "median ratio": float(np.median(loop_ms[index]) / np.median(loop_ms[0])),
            "writing rows, mean ms": float(np.mean(recorder_ms[index])),
            **worker.counts,
        }


def _milliseconds(
    workers: list[Worker], frames: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (sides, rounds, frames) milliseconds of the loop and of the recorder's thread."""
    laps: list[list[list[dict[str, float]]]] = [[] for _ in workers]
    for number in range(ROUNDS):
        for each in laps:
            each.append([])
        for block in range(-(-frames // BLOCK)):
            turn = (number + block) % len(workers)
            for side in [*range(turn, len(workers)), *range(turn)]:
                laps[side][-1] += workers[side].run(BLOCK)
    loop, recorder = (
        1e3 * np.array([[[lap[name] for lap in block] for block in side] for side in laps])
        for name in ("loop_s", "recorder_s")
    )
    return loop, recorder


def _notes(frames: int, against: str | None) -> list[str]:
    notes = [
        f"{ROUNDS} rounds of {frames} stereo frames of the shipped walk, 160×200 px: playback, "
        "renderer, and the rows of frames.csv as a session writes them.",
        "CPU time of the thread that runs the loop; what is inside moderngl and inside OpenGL "
        "functions is taken away. A p99 is that of a round, the median of the rounds is shown.",
        "Counted in one frame: calls of Python functions of any kind, moderngl's methods among "
        "them, and draw calls of the scene and in all.",
    ]
    if against is not None:
        notes.append(
            f"The sides take turns every {BLOCK} frames. Ratios are to the p99 of {against} in "
            f"the same round: median, least and most of {ROUNDS}; `{against} again` is the A/A of "
            "the run."
        )
    return notes
