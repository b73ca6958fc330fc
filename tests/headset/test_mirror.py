"""The operator's window: what the participant sees, no more often than allowed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.waiting import wait_for
from tests.support.x_server import XServer, x_server

CLIENT = """
import sys
from dataclasses import dataclass
import numpy as np
from vrcomfort.geometry import Fov, Pose, Quad, View
from vrcomfort.frame import Frame
from vrcomfort.headset.window import Mirror
from vrcomfort.headset.window import Window
from vrcomfort.gpu.gl import check_errors, prepare


@dataclass(frozen=True, eq=False)
class Shown:
    quad: Quad
    picture: np.ndarray


now_s = 0.0
view = View(Pose(), Fov.symmetric(vertical_rad=np.pi / 2, aspect=1.0))
with Window("mirror", (64, 64), wait_for_display=False, drag_turns=True) as window:
    ctx = prepare(window.context())
    mirror = Mirror(ctx, window, max_hz=15, now_s=lambda: now_s)
    eyes = [ctx.texture((64, 64), 4, bytes(color * 64 * 64)) for color in ((0, 0, 255, 255),) * 2]
    quad = Quad(Pose(np.array([0.0, 0.0, -1.0])), (1.0, 1.0))
    panel = Shown(quad, np.full((8, 8, 4), (255, 0, 0, 255), np.uint8))
    for index in range(90):
        frame = Frame(index, index, 1, Pose(), (view, view), Pose())
        mirror.show(frame, eyes, [panel] if index >= 45 else [])
        mirror.keys()
        now_s += 1 / 90
    check_errors(ctx)
    print(mirror.shown, flush=True)
    sys.stdin.readline()
    pressed = mirror.keys()
    print(pressed.stop, pressed.turn_rad > 0.05, flush=True)
"""


def seen(server: XServer) -> tuple[np.ndarray, np.ndarray] | None:
    """Return where eye and panel stand on the screen, once the server has drawn both."""
    screen = server.picture()
    blue = np.argwhere((screen == [0, 0, 255]).all(axis=2))
    red = np.argwhere((screen == [255, 0, 0]).all(axis=2))
    drawn = len(blue) and len(red) and np.array_equal(screen, server.picture())
    return (blue, red) if drawn else None


@pytest.mark.slow
def test_the_mirror_shows_eye_and_panel_at_a_bounded_rate_and_hears_keys(tmp_path: Path) -> None:
    with (
        x_server(tmp_path) as server,
        subprocess.Popen(
            [sys.executable, "-c", CLIENT],
            env=server.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        ) as client,
    ):  # fmt: skip
        assert client.stdout is not None
        assert 12 <= int(client.stdout.readline()) <= 15  # of 90 frames in a second
        blue, red = wait_for(lambda: seen(server))
        corner = blue.min(axis=0)
        server.do("mousemove", int(corner[1]) + 50, int(corner[0]) + 32)
        server.do("mousedown", 1, "mousemove_relative", "--", "-40", "0", "mouseup", 1)
        server.do("key", "Escape")
        told, _ = client.communicate("\n")
    assert np.ptp(blue, axis=0).tolist() == [63, 63]
    assert len(red) == 32 * 32
    assert (red.min(axis=0) - corner).tolist() == [16, 16]
    assert told == "True True\n"
