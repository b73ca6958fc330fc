"""An X server without a monitor, and a keyboard and mouse for it; for tests of real windows."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.waiting import WAIT_S

XWD_WIDTH, XWD_HEIGHT, XWD_LINE_BYTES, XWD_COLORS = 4, 5, 12, 19
"""Places in the header of the file that Xvfb keeps its pixels in (XWDFile.h)."""


@dataclass(frozen=True)
class XServer:
    """A server that runs.

    Parameters
    ----------
    display
        As in the variable ``DISPLAY``.
    pixels_file
        Where Xvfb keeps what is on the screen.
    """

    display: str
    pixels_file: Path

    @property
    def environment(self) -> dict[str, str]:
        """Return the variables for a program with a window, drawn in software."""
        return {**os.environ, "DISPLAY": self.display, "LIBGL_ALWAYS_SOFTWARE": "1"}

    def do(self, *words: str | int) -> None:
        """Let xdotool press keys or move the mouse: ``do("key", "Return")``."""
        command = [_needed("xdotool"), *map(str, words)]
        subprocess.run(command, env=self.environment, check=True, timeout=WAIT_S)

    def picture(self) -> NDArray[np.uint8]:
        """Return (height, width, 3) RGB of the screen, top row first."""
        data = self.pixels_file.read_bytes()
        header = np.frombuffer(data, ">u4", 25)
        line, start = header[XWD_LINE_BYTES], header[0] + 12 * header[XWD_COLORS]
        shape = header[XWD_HEIGHT], line // 4, 4
        pixels = np.frombuffer(data, np.uint8, line * header[XWD_HEIGHT], start).reshape(shape)
        return pixels[:, : header[XWD_WIDTH], 2::-1]


@contextmanager
def x_server(folder: Path, size_px: tuple[int, int] = (640, 400)) -> Iterator[XServer]:
    """Yield a server of one's own; fails where Xvfb is missing."""
    server = _needed("Xvfb")
    reader, writer = os.pipe()
    screen = "{}x{}x24".format(*size_px)
    command = [server, "-displayfd", str(writer), "-screen", "0", screen, "-fbdir", str(folder)]
    with subprocess.Popen(command, pass_fds=[writer], stderr=subprocess.DEVNULL) as process:
        os.close(writer)
        with os.fdopen(reader) as answer:
            number = answer.readline().strip()
            assert number, "Xvfb did not start"
            display = f":{number}"
        try:
            yield XServer(display, folder / "Xvfb_screen0")
        finally:
            process.terminate()


def _needed(program: str) -> str:
    path = shutil.which(program)
    if path is None:
        pytest.fail(
            f"{program} is missing: tests of windows need the packages xvfb and xdotool "
            "(Debian and Ubuntu: apt-get install xvfb xdotool)"
        )
    return path
