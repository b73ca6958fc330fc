"""An OpenXR runtime of our own, which follows a script: tests/openxr_runtime, built when needed.

No headset, no service: a library that the OpenXR loader takes for a runtime. script.c says what
can be written in a script.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Self

import pytest

from tests.support.places import ROOT
from vrcomfort.geometry import Pose
from vrcomfort.headset.monado import RemoteHand, RemoteState, active_environment

SOURCES = ROOT / "tests/openxr_runtime"
NAME = "openxr_runtime.dll" if sys.platform == "win32" else "libopenxr_runtime.so"
BUILT_VARIABLE = "VRCOMFORT_TEST_RUNTIME"
"""Names the library where it was built elsewhere: there is no compiler in the Windows test bed."""
HEADER = Path("/usr/include/openxr/openxr.h")
FLAGS = [
    "-std=gnu11",
    "-O1",
    "-shared",
    "-fPIC",
    "-fvisibility=hidden",
    "-Wall",
    "-Wextra",
    "-Werror",
]
PROFILE = "valve/index_controller"


def cache_folder() -> Path:
    """Return where what is made once is kept."""
    return Path(os.environ.get("VRCOMFORT_CACHE", Path.home() / ".cache" / "vrcomfort"))


@cache
def library() -> Path:
    """Return the runtime's library, built once for its sources; skip where it cannot be."""
    if built := os.environ.get(BUILT_VARIABLE):
        return Path(built)
    compiler = shutil.which("cc")
    if compiler is None or not HEADER.exists():
        pytest.skip("no C compiler with OpenXR's headers; scripts/setup.sh --tests installs both")
    sources = sorted(SOURCES.glob("*.[ch]"))
    made_of = b"".join([*(each.read_bytes() for each in sources), HEADER.read_bytes()])
    folder = cache_folder() / f"openxr_runtime-{sha256(made_of).hexdigest()[:12]}"
    folder.mkdir(parents=True, exist_ok=True)
    folder.with_name(f"{folder.name}.lock").touch()  # scripts/debian.sh removes what is unused
    if not (folder / NAME).exists():
        partial = folder / f"{NAME}.{os.getpid()}"
        files = [str(each) for each in sources if each.suffix == ".c"]
        subprocess.run([compiler, *FLAGS, "-o", str(partial), *files, "-lm", "-ldl"], check=True)
        partial.replace(folder / NAME)
    return folder / NAME


@dataclass
class ScriptedRuntime:
    """The active OpenXR runtime of this process and its children; a context manager.

    It is used as `Monado` is: what follows a trace and answers sends its states to `feed`.

    Parameters
    ----------
    folder
        For the script and the runtime's manifest.
    script
        Lines of a script.
    """

    folder: Path
    script: str = ""

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        self._library = library()
        manifest = {
            "file_format_version": "1.0.0",
            "runtime": {"library_path": str(self._library), "name": "vrcomfort test runtime"},
        }
        (self.folder / "runtime.json").write_text(json.dumps(manifest))
        (self.folder / "script.txt").write_text(self.script, encoding="utf-8")

    @property
    def environment(self) -> dict[str, str]:
        """Return the variables that lead an OpenXR application to this runtime."""
        return {
            "XR_RUNTIME_JSON": str(self.folder / "runtime.json"),
            "VRCOMFORT_TEST_SCRIPT": str(self.folder / "script.txt"),
        }

    def say(self, *lines: str) -> None:
        """Add lines to the script that is being followed in this process."""
        loaded = ctypes.CDLL(str(self._library))
        for line in lines:
            assert loaded.runtime_say(line.encode()), f"not understood: {line}"

    def stop(self) -> None:
        """End what the runtime has besides this process: nothing."""

    kill = stop

    def feed(self) -> ScriptFeed:
        """Return what moves head and controllers in this process."""
        return ScriptFeed(self)

    def __enter__(self) -> Self:
        self._outer = active_environment(self.environment)
        self._outer.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self._outer.__exit__(None, None, None)


@dataclass
class ScriptFeed:
    """Writes states of head and controllers into the script, as `RemoteFeed` sends them."""

    runtime: ScriptedRuntime

    def send(self, state: RemoteState) -> None:
        """Hold `state` from the frame on that is waited for next."""
        self.runtime.say(f"now head {numbers(state.head)}")
        for name, hand in (("left", state.left), ("right", state.right)):
            self.runtime.say(*(f"now {rule}" for rule in rules(name, hand)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        """Leave everything as it is."""


def numbers(pose: Pose) -> str:
    """Return a pose as a script has it."""
    return " ".join(f"{float(each)!r}" for each in (*pose.position, *pose.orientation))


def rules(name: str, hand: RemoteHand) -> list[str]:
    """Return what a script says of a controller of `PROFILE`."""
    user = f"press /user/hand/{name}/input"
    x, y = hand.thumbstick
    return [
        f"hand {name} {numbers(hand.pose)}",
        f"active {name} {hand.active:d}",
        f"{user}/trigger {hand.trigger:d}",
        f"{user}/a {hand.a:d}",
        f"{user}/b {hand.b:d}",
        f"{user}/thumbstick {x!r} {y!r}",
    ]
