"""Cost of the operator's console for the thread that shows frames, without and with 50 pages.

Run with ``python -m bench.console``.
"""

from __future__ import annotations

import argparse
import asyncio
import http.client
import itertools
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import moderngl
import numpy as np
from websockets.asyncio.client import connect

from bench.table import Result, write
from vrcomfort.console import OperatorConsole, ServerProcess
from vrcomfort.frame import Frame
from vrcomfort.gpu.gl import create_context
from vrcomfort.headset.eye_painter import EyePictures
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.operator_interface import NoOperator, SessionProgress
from vrcomfort.protocol import load_protocol
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.scene.load import load_scene
from vrcomfort.session import SessionSettings, open_enrolment, run
from vrcomfort.session.frame_log import TrialTiming
from vrcomfort.session.operator_control import ALLOWED, OperatorControl
from vrcomfort.traces.trace import read_trace

PAGES = 50
SIZE_PX = 64, 80
REFRESH_HZ = 90.0
DESK_FRAMES = 20_000
WARM_UP = 20
"""Frames of each exposure that are not counted: they compile and fill caches."""
PROTOCOL = """\
name = "bench"
title = "One exposure"
participants = 1
exposure_s = {exposure_s}
scenes = ["temple"]
[[conditions]]
name = "plain"
[order]
rule = "explicit"
[[order.sequences]]
name = "a"
sessions = [[{{ scene = "temple", condition = "plain" }}]]
[[questionnaires]]
timepoint = "baseline"
when = "session_start"
[[ratings]]
instrument = "fms"
every_s = 0.5
timeout_s = 0.3
"""


class _Clocked(PlaybackHeadset):
    """Takes the CPU time of the thread from one frame to the next, in µs."""

    def frames(self) -> Iterator[Frame]:
        self.times_us: list[float] = []
        before_s = time.thread_time()
        for frame in super().frames():
            now_s = time.thread_time()
            self.times_us.append(1e6 * (now_s - before_s))
            before_s = now_s
            yield frame


class _Sessions:
    """Runs one-exposure sessions, each in a study of its own."""

    def __init__(self, ctx: moderngl.Context, folder: Path, frames: int) -> None:
        file = folder / "bench.toml"
        exposure_s = (frames + WARM_UP) / REFRESH_HZ
        file.write_text(PROTOCOL.format(exposure_s=exposure_s), encoding="utf-8")
        self._protocol, self._folder = load_protocol(file), folder
        self._renderer = StereoRenderer(ctx, SIZE_PX)
        self._scene = load_scene("temple")
        self._trace = read_trace(data_folder("scenes") / "temple_walk.csv")
        self._count = 0

    def headset(self) -> _Clocked:
        """Return a headset at the start of its trace."""
        return _Clocked(self._trace, image_size_px=SIZE_PX, refresh_hz=REFRESH_HZ)

    def times_us(self, operators: OperatorControl) -> list[float]:
        """Return the CPU time of the thread for each frame of an exposure."""
        self._count += 1
        headset = self.headset()
        study = self._folder / f"study{self._count}"
        with open_enrolment(self._protocol, "P01", study=study, respondent="simulated") as enrolled:
            run(
                enrolled,
                SessionSettings(
                    respondent=SimulatedRespondent(
                        self._protocol.simulation, participant="P01", seed=0
                    ),
                    headset_for=lambda *_: headset,
                    load_scene=lambda _: self._scene,
                    renderer=self._renderer,
                    durability="session_end",
                    operators=operators,
                ),
            )
        return headset.times_us[WARM_UP:]


def measure(ctx: moderngl.Context, *, rounds: int, frames: int) -> Result:
    """Return the loop thread's CPU time per frame without a console twice, and with one."""
    with TemporaryDirectory() as folder, _console(0) as alone, _console(PAGES) as looked_at:
        sessions = _Sessions(ctx, Path(folder), frames)
        nobody = OperatorControl(NoOperator())
        cases = {
            "no console": nobody,
            "no console, again": nobody,
            "console, no page": alone,
            f"console, {PAGES} pages, one with pictures": looked_at,
        }
        for operators in cases.values():
            sessions.times_us(operators)  # warms up
        found: dict[str, list[list[float]]] = {name: [] for name in cases}
        for number in range(rounds):
            for name in sorted(cases, reverse=bool(number % 2)):
                found[name].append(sessions.times_us(cases[name]))
        frame = next(sessions.headset().frames())
    base = {at: _percentiles(found["no console"], at) for at in (50, 99)}
    rows = [_row(name, found[name], base) for name in cases]
    notes = [
        "CPU time of the thread that shows frames (time.thread_time), temple without effects, "
        f"{SIZE_PX[0]}×{SIZE_PX[1]} pixels per eye, {rounds} interleaved exposures of {frames} "
        "frames each.",
        "Ratios are to the first row, round by round: their median, and in brackets the smallest "
        "and the largest round. The second row is the same program again: noise.",
        f"What the desk itself does takes {_desk_us(frame, shows=False):.1f} µs of a frame, and "
        f"{_desk_us(frame, shows=True):.1f} µs of one whose state is shown (five a second).",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Console", rows, notes)


def _percentiles(rounds: list[list[float]], at: float) -> np.ndarray:
    return np.array([np.percentile(each, at) for each in rounds])


def _row(name: str, rounds: list[list[float]], base: dict[int, np.ndarray]) -> dict[str, Any]:
    row: dict[str, Any] = {"what": name}
    for at, word in ((50, "median"), (99, "p99")):
        each = _percentiles(rounds, at)
        ratio = each / base[at]
        row[f"{word} µs"] = float(np.median(each))
        row[f"{word} ratio"] = f"{np.median(ratio):.3f} ({ratio.min():.3f}–{ratio.max():.3f})"
    return row


class _Nowhere:
    """A server that shows nothing."""

    pictures = 0

    def show(self, state: Mapping[str, Any]) -> None:
        """Show nothing."""

    def show_picture(self, make: Callable[[], bytes]) -> None:
        """Show nothing."""

    def next_command(self) -> None:
        """Return nothing."""


def _desk_us(frame: Frame, *, shows: bool) -> float:
    """Return the CPU time of hearing, seeing and telling in one frame."""
    clock = itertools.count(step=1 if shows else 0)
    desk = OperatorConsole(_Nowhere(), ALLOWED, now_s=lambda: float(next(clock)))
    operators, trial = OperatorControl(desk), TrialTiming()
    operators.begin("exposure", "bench")
    for minute in range(15):
        desk.rated("fms", 60.0 * minute, 3)
    progress = SessionProgress("exposure", "P01", 1, trial=1, done=1.0, total=900.0)
    began_s = time.thread_time()
    for _ in range(DESK_FRAMES):
        operators.look()
        desk.see(frame, None, trial)
        desk.tell(progress)
    return 1e6 * (time.thread_time() - began_s) / DESK_FRAMES


@contextmanager
def _console(pages: int) -> Iterator[OperatorControl]:
    """Start a console, and its pages in another process."""
    addresses: list[str] = []
    with ServerProcess(print, addresses.append) as server:
        _wait(lambda: bool(addresses))
        desk = OperatorConsole(server, pictures=EyePictures())
        desk.starts_sessions = False
        connection = http.client.HTTPConnection("127.0.0.1", server.port)
        connection.request("GET", addresses[0].partition(str(server.port))[2])
        cookie = (connection.getresponse().getheader("set-cookie") or "").partition(";")[0]
        connection.close()
        words = [sys.executable, "-m", "bench.console"]
        process = subprocess.Popen([*words, "--pages", str(pages), str(server.port), cookie])
        try:
            _wait(lambda: server.pages == pages and server.pictures == min(pages, 1))
            yield OperatorControl(desk)
        finally:
            process.kill()
            process.wait()


def _wait(wanted: Callable[[], bool]) -> None:
    deadline_s = time.monotonic() + 60
    while not wanted():
        if time.monotonic() > deadline_s:
            raise TimeoutError("the console's pages did not come or go")
        time.sleep(0.05)


async def _look(pages: int, port: int, cookie: str) -> None:
    """Be so many pages, the first of which wants pictures."""

    async def page(number: int) -> None:
        address, origin = f"ws://127.0.0.1:{port}/session", f"http://127.0.0.1:{port}"
        async with connect(address, origin=origin, additional_headers={"Cookie": cookie}) as socket:
            if number == 0:
                await socket.send('{"id": "1", "action": "watch", "step": 0, "value": 1}')
            async for _ in socket:
                pass

    await asyncio.gather(*map(page, range(pages)))


def main() -> None:
    """Measure, or (with ``--pages``) be the pages that look on."""
    parser = argparse.ArgumentParser(prog="python -m bench.console", description=__doc__)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--pages", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.pages:
        pages, port, cookie = options.pages
        asyncio.run(_look(int(pages), int(port), cookie))
        return
    result = measure(create_context(), rounds=options.rounds, frames=options.frames)
    write(options.out, "console", result)


if __name__ == "__main__":
    main()
