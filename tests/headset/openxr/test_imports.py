"""Importing the OpenXR part needs no window system's library; what is missing is a sentence."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.places import ROOT
from tests.support.study import smoke_with
from tests.support.waiting import WAIT_S
from vrcomfort.errors import InputError

WITHOUT = """
import sys

class Missing:
    '''Makes imports fail as they do where a library is not there.'''

    def __init__(self, *names):
        self.names = names

    def find_spec(self, name, path=None, target=None):
        if any(name == each or name.startswith(each + ".") for each in self.names):
            raise ModuleNotFoundError("no " + name + " on this system", name=name)

sys.meta_path.insert(0, Missing({names}))
"""
IMPORT_ALL = """
import importlib, pkgutil
import vrcomfort.headset.openxr as package

for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
    print(importlib.import_module(module.name).__name__)
"""
COMMAND = """
from vrcomfort.cli import main
main()
"""


def python(text: str, names: str, *words: str) -> subprocess.CompletedProcess[str]:
    root = ROOT
    return subprocess.run(
        [sys.executable, "-c", WITHOUT.replace("{names}", names) + text, *words],
        env={**os.environ, "PYTHONPATH": f"{root}:{os.environ.get('PYTHONPATH', '')}"},
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )


@pytest.mark.slow
@pytest.mark.smoke
def test_everything_is_imported_without_egl_and_without_windows() -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    done = python(IMPORT_ALL, "'OpenGL.EGL', 'glfw', 'xr.utils'")
    assert done.returncode == 0, done.stderr
    assert "vrcomfort.headset.openxr.graphics_binding" in done.stdout.split()


@pytest.mark.slow
@pytest.mark.parametrize("names", ["'xr'", "'OpenGL.GLX'"])
def test_run_says_what_openxr_lacks(tmp_path: Path, names: str) -> None:
    protocol, out = str(smoke_with(tmp_path, 4.0)), str(tmp_path / "study")
    words = "run", protocol, "--participant", "P01", "--out", out, "--headset", "openxr"
    done = python(COMMAND, names, *words)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: the OpenXR bindings")
    assert "pip install" in line
    assert not (tmp_path / "study" / "sub-P01" / "ses-1").exists()


@pytest.mark.slow
@pytest.mark.parametrize("names", ["'xr'", "'OpenGL.GLX'"])
def test_doctor_says_what_openxr_lacks(names: str) -> None:
    done = python(COMMAND, names, "doctor", "--json")
    assert done.returncode == 0, done.stderr
    assert "the OpenXR bindings" in done.stdout


class Opengl32:
    """What a session needs of Windows' OpenGL library."""

    def __init__(self, device: int | None, context: int | None) -> None:
        self.wglGetCurrentDC = _function(device)
        self.wglGetCurrentContext = _function(context)


def _function(handle: int | None) -> Any:
    class Function:
        """As ctypes has it: a result is cut to 32 bits unless it is said to be a pointer."""

        restype: Any = ctypes.c_int
        argtypes: Any = None

        def __call__(self) -> int | None:
            return handle if self.restype is ctypes.c_void_p else ctypes.c_int(handle or 0).value

    return Function()


def test_windows_gives_the_whole_handles_of_its_current_context(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    xr = pytest.importorskip("xr", reason="pyopenxr is not installed")
    from vrcomfort.headset.openxr.graphics_binding import wgl_binding

    class Structure(ctypes.Structure):
        _fields_ = (("h_dc", ctypes.c_void_p), ("h_glrc", ctypes.c_void_p))

    monkeypatch.setattr(xr, "GraphicsBindingOpenGLWin32KHR", Structure, raising=False)
    binding = wgl_binding(Opengl32(0x7_1234_5678, 0x9_8765_4321))
    assert (binding.structure.h_dc, binding.structure.h_glrc) == (0x7_1234_5678, 0x9_8765_4321)
    assert binding.platform == "wgl"
    with pytest.raises(InputError, match="no OpenGL context is current"):
        wgl_binding(Opengl32(0x7_1234_5678, None))
