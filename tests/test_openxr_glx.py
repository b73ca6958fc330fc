"""The same headset on a window's GLX context, on an X server without a screen."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from openxr_support import needs_monado

pytestmark = needs_monado

CLIENT = """
import sys
from itertools import islice
from pathlib import Path
import glfw, moderngl, numpy as np
from vrcomfort.geometry import Pose
from vrcomfort.headset.monado import Monado
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.remote_feed import RemoteState

assert glfw.init()
glfw.window_hint(glfw.VISIBLE, False)
glfw.make_context_current(glfw.create_window(64, 64, "test", None, None))
ctx = moderngl.create_context()
noise = np.random.default_rng(0).bytes(16 * 16 * 4)
eye = ctx.texture((16, 16), 4, noise)
got = []
with Monado(log=Path(sys.argv[1])) as monado, monado.feed() as feed:
    feed.send(RemoteState(Pose(np.array([0.0, 1.6, 0.0]))))
    settings = OpenXrSettings(image_size_px=(16, 16))
    keep = lambda eye, image: got.append(image.read(components=4))
    with OpenXrHeadset(ctx, settings, mirror=keep) as headset:
        for frame in islice(headset.frames(), 8):
            headset.submit(frame, (eye, eye))
        assert headset.details["binding"] == "glx"
assert len(got) >= 10 and set(got) == {noise}
"""


@pytest.fixture
def display() -> Iterator[str]:
    server = shutil.which("Xvfb")
    if server is None:
        pytest.skip("no Xvfb here")
    reader, writer = os.pipe()
    command = [server, "-displayfd", str(writer), "-screen", "0", "320x240x24"]
    with subprocess.Popen(command, pass_fds=[writer], stderr=subprocess.DEVNULL) as process:
        os.close(writer)
        with os.fdopen(reader) as answer:
            yield f":{answer.readline().strip()}"
        process.terminate()


def test_a_window_context_is_bound_by_glx(display: str, tmp_path: Path) -> None:
    environment = {**os.environ, "DISPLAY": display}
    command = [sys.executable, "-c", CLIENT, str(tmp_path / "monado.txt")]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr
