"""Graphics adapters of this machine, and which of them draws: laptops often have two."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.files import read_text

VENDORS = {"0x10de": "NVIDIA", "0x1002": "AMD", "0x8086": "Intel"}
"""PCI vendor → maker."""
NAMES = {
    "NVIDIA": ("nvidia", "geforce", "quadro", "nouveau"),
    "AMD": ("amd", "radeon"),
    "Intel": ("intel",),
}
"""Maker → words of its renderers' and adapters' names, in small letters."""
SOFTWARE = (
    "llvmpipe",
    "softpipe",
    "swiftshader",
    "swrast",
    "software",
    "basic render",
    "gdi generic",
)
"""Rasterisers without a GPU, in small letters. Their timer queries tell when commands were taken,
not drawn, and anisotropic filtering costs them more than all other shading (3 × measured)."""
_DISPLAY_CLASS = "0x03"
_PCI = Path("/sys/bus/pci/devices")
WINDOWS_CLASS = r"SYSTEM\CurrentControlSet\Control\Class\{4d36e968-e325-11ce-bfc1-08002be10318}"
"""The registry's display adapters, in HKEY_LOCAL_MACHINE."""


def draws_in_software(renderer: str) -> bool:
    """Return whether an OpenGL renderer draws on the processor, and not on a GPU."""
    return any(word in renderer.casefold() for word in SOFTWARE)


def maker_of(name: str) -> str:
    """Return the maker of a renderer or adapter; empty where its name does not tell."""
    words = name.casefold()
    return next((maker for maker, own in NAMES.items() if any(w in words for w in own)), "")


def adapters(pci: Path = _PCI) -> tuple[str, ...]:
    """Return the names of the machine's graphics adapters; none where the system does not tell."""
    found = _windows_adapters() if sys.platform == "win32" else _pci_adapters(pci)
    return tuple(dict.fromkeys(found))


def _pci_adapters(pci: Path) -> Iterator[str]:
    for device in sorted(pci.glob("*")):
        try:
            kind, vendor, number = (
                read_text(device / name, "device").strip() for name in ("class", "vendor", "device")
            )
        except InputError:
            continue
        if kind.startswith(_DISPLAY_CLASS) and vendor in VENDORS:
            yield f"{VENDORS[vendor]} ({vendor[2:]}:{number[2:]})"


def _windows_adapters() -> list[str]:
    found: list[str] = []
    if sys.platform == "win32":
        import winreg  # noqa: PLC0415 - of Windows alone

        with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, WINDOWS_CLASS) as displays:
            for index in range(winreg.QueryInfoKey(displays)[0]):
                try:
                    with winreg.OpenKey(displays, winreg.EnumKey(displays, index)) as adapter:
                        found.append(str(winreg.QueryValueEx(adapter, "DriverDesc")[0]))
                except OSError:  # no adapter: the properties of the class
                    continue
    return found


def faster_adapters(renderer: str, there: tuple[str, ...]) -> list[str]:
    """Return the adapters that draw faster than the one in use, as far as makers tell.

    A renderer in software is slower than all of them, and Intel's are slower than those beside
    them. Of an AMD renderer nobody can tell whether it is the one in the processor.
    """
    if draws_in_software(renderer):
        return list(there)
    return [
        name
        for name in there
        if (maker_of(renderer), maker_of(name))
        in {("Intel", "NVIDIA"), ("Intel", "AMD"), ("AMD", "NVIDIA")}
    ]


def how_to_choose(name: str) -> str:
    """Return how a program is made to draw on another adapter."""
    if sys.platform == "win32":
        return (
            f"to draw on the {name}: Settings, System, Display, Graphics, add the Python that runs "
            "vrcomfort, Options, High performance; then connect the headset to that GPU"
        )
    if maker_of(name) == "NVIDIA":
        return (
            f"to draw on the {name}, install its driver and set __NV_PRIME_RENDER_OFFLOAD=1 "
            "__GLX_VENDOR_LIBRARY_NAME=nvidia"
        )
    return f"to draw on the {name}, install its driver and set DRI_PRIME=1"
