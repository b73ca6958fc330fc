"""Reads what the best-practices layer has to say.

As it is compiled into the wheel of pyopenxr it says nothing: `BPLogger::LogMessage` counts each
message in a table, and prints it in debug builds only. So a test that waits for a printed
complaint passes whatever is called. This looks into the table.

::

    errorCounts ─► {buckets, bucket count, first ─► node, size, ...}      libstdc++'s unordered_map
                                             node = {next ─► node, text ─► bytes, length, ...,
                                                     count, hash}
"""

from __future__ import annotations

import ctypes
import struct

from tests.support.openxr import layer_folder

LIBRARY = layer_folder() / "libXrApiLayer_best_practices_validation.so"
TABLE = "_ZN8BPLogger11errorCountsB5cxx11E"
EXPORTED = "xrNegotiateLoaderApiLayerInterface"
FIRST, TEXT, LENGTH, COUNT = 16, 8, 16, 40


class BestPractices:
    """The table of the layer in this process, which stays loaded from now on."""

    def __init__(self) -> None:
        self._library = ctypes.CDLL(str(LIBRARY))
        places = _symbols(LIBRARY.read_bytes())
        function = ctypes.cast(getattr(self._library, EXPORTED), ctypes.c_void_p).value or 0
        self._table = function - places[EXPORTED] + places[TABLE]

    def counts(self) -> dict[str, int]:
        """Return message → how often, since the process began."""
        found = {}
        node = _pointer(self._table + FIRST)
        while node:
            text = ctypes.string_at(_pointer(node + TEXT), _pointer(node + LENGTH))
            found[text.decode()] = ctypes.c_int.from_address(node + COUNT).value
            node = _pointer(node)
        return found


def _pointer(address: int) -> int:
    return ctypes.c_uint64.from_address(address).value


def _symbols(elf: bytes) -> dict[str, int]:
    """Return name → offset of the symbols of a 64-bit ELF file (System V ABI, chapter 4)."""
    (table,) = struct.unpack_from("<Q", elf, 40)
    size, number = struct.unpack_from("<HH", elf, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", elf, table + size * i) for i in range(number)]
    symbols = next(each for each in sections if each[1] == 2)
    names = sections[symbols[6]][4]
    found = {}
    for place in range(symbols[4], symbols[4] + symbols[5], 24):
        name, _, _, _, value = struct.unpack_from("<IBBHQ", elf, place)
        end = elf.index(b"\0", names + name)
        found[elf[names + name : end].decode()] = value
    return found
