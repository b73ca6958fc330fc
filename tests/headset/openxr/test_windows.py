"""What Windows needs of pyopenxr: read from its files, which are those of every system."""

from __future__ import annotations

import ctypes
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.support.places import ROOT
from tests.support.waiting import WAIT_S
from vrcomfort.cli import headset_setup
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol

DEBUG_RUNTIME = re.compile(rb"(?:msvcp|vcruntime)\d+(?:_\d)?d\.dll|ucrtbased\.dll", re.IGNORECASE)

IMPORT_AS_WINDOWS = """
import ctypes, platform, sys
from unittest.mock import MagicMock

class Loader:
    def LoadLibrary(self, path):
        print(path)
        return MagicMock()

handle = ctypes.c_void_p
sys.modules["OpenGL.WGL"] = MagicMock(__all__=[], HDC=handle, HGLRC=handle)
platform.system = lambda: "Windows"
ctypes.CDLL = ctypes.WinDLL = Loader().LoadLibrary
ctypes.cdll = ctypes.windll = Loader()
ctypes.WINFUNCTYPE = ctypes.CFUNCTYPE
import xr
"""
"""Prints the libraries that `import xr` loads on Windows; no code of theirs runs."""


def windows_libraries() -> list[Path]:
    command = [sys.executable, "-c", IMPORT_AS_WINDOWS]
    done = subprocess.run(command, capture_output=True, text=True, timeout=WAIT_S, check=False)
    assert done.returncode == 0, done.stderr
    return [Path(line) for line in done.stdout.splitlines()]


def test_nothing_that_is_loaded_on_windows_needs_a_debug_runtime() -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    libraries = windows_libraries()
    names = {each.name for each in libraries}
    assert {"openxr_loader.dll", "XrApiLayer_python.dll"} <= names
    needs = {each.name: DEBUG_RUNTIME.findall(each.read_bytes()) for each in libraries}
    assert needs == {name: [] for name in names}


def test_the_remedy_names_the_versions_that_are_required() -> None:
    file = ROOT / "pyproject.toml"
    dependencies = tomllib.loads(file.read_text())["project"]["dependencies"]
    (required,) = (each for each in dependencies if each.startswith("pyopenxr"))
    assert required.partition(";")[0] == headset_setup.REQUIREMENT


@pytest.mark.parametrize(
    ("system", "installed", "words"),
    [
        ("win32", "1.1.6501", '1.1.6501 needs a debug C runtime.*pip install "pyopenxr>=.*,<'),
        ("win32", "1.1.6301", "Visual C\\+\\+ Redistributable.*https://aka.ms/vs/.*x64.exe$"),
        ("linux", "1.1.6301", 'reinstall.*pip install --force-reinstall "pyopenxr>=.*"$'),
    ],
)
def test_a_library_that_is_not_loaded_has_a_remedy(
    system: str, installed: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "xr").mkdir()
    message = "Could not find module 'XrApiLayer_python.dll' (or one of its dependencies)."
    (tmp_path / "xr" / "__init__.py").write_text(f"raise FileNotFoundError({message!r})\n")
    record = tmp_path / f"pyopenxr-{installed}.dist-info"
    record.mkdir()
    (record / "METADATA").write_text(f"Name: pyopenxr\nVersion: {installed}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [each for each in sys.modules if each.partition(".")[0] == "xr"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "platform", system)
    connect = headset_setup.openxr_setup(load_protocol("smoke")).__enter__
    for needs in (headset_setup.require_bindings, headset_setup.tracks_eyes, connect):
        with pytest.raises(InputError, match=words) as caught:
            needs()
        assert "XrApiLayer_python.dll" in str(caught.value)
        assert os.linesep not in str(caught.value)


class Plain(ctypes.Structure):
    """Flags as pyopenxr 1.1.53 has them."""

    _fields_ = (("type", ctypes.c_int), ("flags", ctypes.c_uint64))


class Header(ctypes.Structure):
    _fields_ = (("_type", ctypes.c_int),)


class Behind(Header):
    """Flags as pyopenxr 1.1.63 has them: behind a property that makes an enumeration."""

    _fields_ = (("_flags", ctypes.c_uint64),)

    @property
    def flags(self) -> Any:
        raise AssertionError("slow")


@pytest.mark.parametrize("structure", [Plain, Behind])
def test_a_field_is_read_whatever_pyopenxr_calls_it(structure: type[ctypes.Structure]) -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    from vrcomfort.headset.openxr.native import raw_field

    made = structure(7, 5)
    assert raw_field(structure, "flags")(made) == 5
    assert raw_field(structure, "type")(made) == 7
