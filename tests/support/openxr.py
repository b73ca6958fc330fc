"""A Monado runtime for tests that need one, and a participant who follows a script."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from vrcomfort.frame import Frame
from vrcomfort.headset.monado import Monado, RemoteFeed, RemoteState, active_environment

Script = Callable[[int], RemoteState]
VALIDATION = "XR_APILAYER_LUNARG_core_validation"
BEST_PRACTICES = "XR_APILAYER_KHRONOS_best_practices_validation"

needs_monado = [
    pytest.mark.monado,
    pytest.mark.skipif(
        shutil.which("monado-service") is None and "VRCOMFORT_RUNTIME" not in os.environ,
        reason="no Monado here; scripts/in_runtime.sh brings one",
    ),
]


@dataclass
class Participant:
    """Sends the next state of a script whenever the headset is about to wait for a frame."""

    feed: RemoteFeed
    script: Script
    sent: list[RemoteState] = field(default_factory=list)

    def __call__(self) -> None:
        self.sent.append(self.script(len(self.sent)))
        self.feed.send(self.sent[-1])


def settled(frames: Iterator[Frame], head_m: ArrayLike) -> Frame:
    """Let frames pass until the head is where it is fed: a driver reads when it has time."""
    for frame in islice(frames, 600):
        if not frame.paused and np.allclose(frame.head_pose.position, head_m, atol=1e-5):
            return frame
    pytest.fail("the head is not where it is fed")


@contextmanager
def fresh_monado(folder: Path, *, sways: bool = False) -> Iterator[Monado]:
    """Yield a runtime of one's own, to be killed."""
    with Monado(log=folder / "monado.txt", sways=sways) as monado:
        yield monado


def layer_folder() -> Path:
    """Return where pyopenxr keeps the API layers that it ships."""
    from xr.api_layer.layer_path import py_layer_library_path

    return Path(py_layer_library_path()).parent


def validation_environment(report: Path) -> dict[str, str]:
    """Return where the loader finds the validation layers that pyopenxr ships.

    Manifests of some versions name a library without its folder, where the loader would not look.
    They are written anew beside `report`, to which the layers write.
    """
    folder = report.with_suffix(".layers")
    folder.mkdir()
    for manifest in layer_folder().glob("*_validation.json"):
        layer = json.loads(manifest.read_text())
        library = Path(layer["api_layer"]["library_path"]).name
        layer["api_layer"]["library_path"] = str(layer_folder() / library)
        (folder / manifest.name).write_text(json.dumps(layer))
    return {
        "XR_API_LAYER_PATH": str(folder),
        "XR_CORE_VALIDATION_EXPORT_TYPE": "text",
        "XR_CORE_VALIDATION_FILE_NAME": str(report),
    }


@contextmanager
def validation(report: Path) -> Iterator[tuple[str, ...]]:
    """Yield the validation layers that pyopenxr ships; they write to `report`."""
    with active_environment(validation_environment(report)):
        yield VALIDATION, BEST_PRACTICES


def services_of(pid: int) -> list[int]:
    """Return the Monado services that a process has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = stat.read_text().rpartition(") ")
        except OSError:
            continue
        if "monado" in name and int(rest.split()[1]) == pid:
            found.append(int(stat.parent.name))
    return found
