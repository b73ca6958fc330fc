"""The same headset on a window's GLX context, on an X server without a screen."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.openxr import needs_monado
from tests.support.waiting import WAIT_S
from tests.support.x_server import x_server

pytestmark = needs_monado

CLIENT = """
import sys
from itertools import islice
from pathlib import Path
import numpy as np
from tests.support.openxr_images import ReleasedImages
from vrcomfort.geometry import Pose
from vrcomfort.headset.monado import Monado
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.monado import RemoteState
from vrcomfort.headset.window import Window

window = Window("test", (64, 64), wait_for_display=False)
ctx = window.context()
noise = np.random.default_rng(0).bytes(16 * 16 * 4)
eye = ctx.texture((16, 16), 4, noise)
released = ReleasedImages(ctx)
with Monado(log=Path(sys.argv[1])) as monado, monado.feed() as feed:
    feed.send(RemoteState(Pose(np.array([0.0, 1.6, 0.0]))))
    settings = OpenXrSettings(image_size_px=(16, 16), api_layers=(released.layer.name,))
    with OpenXrHeadset(ctx, settings) as headset:
        for frame in islice(headset.frames(), 8):
            headset.submit(frame, (eye, eye))
        assert headset.details["binding"] == "glx"
assert len(released.colour) >= 10 and set(released.colour) == {noise}
"""


def test_a_window_context_is_bound_by_glx(tmp_path: Path) -> None:
    command = [sys.executable, "-c", CLIENT, str(tmp_path / "monado.txt")]
    with x_server(tmp_path) as server:
        done = subprocess.run(
            command,
            env=server.environment,
            capture_output=True,
            text=True,
            timeout=WAIT_S,
            check=False,
        )
    assert done.returncode == 0, done.stderr
