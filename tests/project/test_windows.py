"""The whole program, imported: on Windows (`make test-windows`) with no debug C runtime there."""

from __future__ import annotations

import ctypes
import importlib
import pkgutil
import sys

import pytest

import vrcomfort

pytestmark = [pytest.mark.slow, pytest.mark.windows]

DEBUG_RUNTIMES = ("ucrtbased", "vcruntime140d", "msvcp140d")
"""Of Visual Studio: an ordinary Windows has none."""


def test_every_module_is_imported() -> None:
    found = [each.name for each in pkgutil.walk_packages(vrcomfort.__path__, "vrcomfort.")]
    modules = [name for name in found if not name.endswith("__main__")]
    assert len(modules) > 400
    for name in modules:
        importlib.import_module(name)
    assert "xr" in sys.modules


@pytest.mark.parametrize("name", DEBUG_RUNTIMES)
def test_there_is_no_debug_runtime(name: str) -> None:
    with pytest.raises(OSError, match=name):
        ctypes.CDLL(name)


if sys.platform == "win32":
    import winreg

    from vrcomfort.gpu.adapters import WINDOWS_CLASS, adapters

    def test_graphics_adapters_are_those_of_the_registry() -> None:
        there = adapters()
        assert there
        laptops = "NVIDIA GeForce RTX 3060 Laptop GPU"
        with winreg.CreateKey(winreg.HKEY_LOCAL_MACHINE, rf"{WINDOWS_CLASS}\0077") as added:
            winreg.SetValueEx(added, "DriverDesc", 0, winreg.REG_SZ, laptops)
        try:
            assert adapters() == (*there, laptops)
        finally:
            winreg.DeleteKey(winreg.HKEY_LOCAL_MACHINE, rf"{WINDOWS_CLASS}\0077")
