"""The bytes of a glTF 2.0 file: containers, buffers, accessors and images as arrays.

The JSON is checked against the loader's types first; every fault has its place. The content of
buffers is checked where it is read.

Source: Khronos glTF 2.0 specification, §3.6 (accessors), §4 (GLB), §3.8 (images).
"""

from __future__ import annotations

import base64
import binascii
import io
import struct
import sys
import urllib.parse
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PureWindowsPath
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.files import read_bytes
from vrcomfort.json_text import parse_json
from vrcomfort.scene.gltf.budget import Account, SceneBudget
from vrcomfort.scene.gltf.parts import Root

_LISTS = ("accessors", "buffers", "bufferViews", "images", "materials", "meshes", "nodes",
          "samplers", "scenes", "skins", "textures")  # fmt: skip
_LAMPS = "KHR_lights_punctual"
_INNER = {"primitives", "children", "nodes", "channels", "samplers", "joints"}
_AT_ONCE = 4096


def check_structure(root: dict[str, Any], path: Path) -> None:
    """Check a file's JSON against the loader's types.

    Raises
    ------
    InputError
        Says what is wrong, and of which node, material, … by number and name.
    """
    context = _counts(root)
    for part, start in _slices(root):
        try:
            Root.model_validate(part, context=context)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = _in_the_whole(first["loc"], start)
            message = f"{place(root, where)} {_in_words(first)}; export the file again"
            raise InputError(message, file=path) from None


def count_items(root: dict[str, Any]) -> int:
    """Return the number of parts in a file's JSON, valid or not."""
    lists = [items for items in root.values() if isinstance(items, list)]
    lamps = _extension(root).get("lights")
    inner = [
        each[key]
        for items in lists
        for each in items
        if isinstance(each, dict)
        for key in _INNER & each.keys()
        if isinstance(each[key], list)
    ]
    return sum(map(len, [*lists, *inner, lamps if isinstance(lamps, list) else []]))


def _slices(root: dict[str, Any]) -> Iterator[tuple[dict[str, Any], int]]:
    """Yield the JSON in parts of a few thousand items, and where in its list the part starts.

    What checks an item takes many times its memory.
    """
    yield {key: value for key, value in root.items() if not isinstance(value, list)}, 0
    for key, items in root.items():
        if isinstance(items, list):
            for start in range(0, max(len(items), 1), _AT_ONCE):
                yield {key: items[start : start + _AT_ONCE]}, start


def _in_the_whole(location: tuple[int | str, ...], start: int) -> tuple[int | str, ...]:
    if len(location) > 1 and isinstance(location[1], int):
        return (location[0], location[1] + start, *location[2:])
    return location


def _counts(root: dict[str, Any]) -> dict[str, int]:
    """Return the length of each list that indices refer to; 0 for anything else."""
    found: dict[str, Any] = {key: root.get(key) for key in _LISTS}
    found["lights"] = _extension(root).get("lights")
    return {key: len(items) if isinstance(items, list) else 0 for key, items in found.items()}


def _extension(root: dict[str, Any]) -> dict[str, Any]:
    """Return the file's lamps, or an empty dict."""
    extensions = root.get("extensions")
    lamps = extensions.get(_LAMPS) if isinstance(extensions, dict) else None
    return lamps if isinstance(lamps, dict) else {}


def place(root: dict[str, Any], location: tuple[int | str, ...]) -> str:
    """Return a place in the JSON for messages, with the names of the objects around it."""
    words, value = "", root
    for part in location:
        words += f"[{part}]" if isinstance(part, int) else f".{part}" if words else part
        try:
            value = value[part]  # type: ignore[index]  # any JSON
        except (KeyError, IndexError, TypeError):
            continue
        name = value.get("name") if isinstance(value, dict) else None
        words += f" ({name!r})" if isinstance(name, str) else ""
    return words


def places_of(root: dict[str, Any], extension: str) -> Iterator[str]:
    """Yield the places in the JSON that use an extension, in words."""
    waiting: list[tuple[tuple[int | str, ...], Any]] = [((), root)]
    while waiting:
        location, value = waiting.pop()
        if isinstance(value, dict):
            if location and extension in (value.get("extensions") or {}):
                yield place(root, location)
            inner = list(value.items())
        else:
            inner = list(enumerate(value)) if isinstance(value, list) else []
        waiting += [((*location, key), each) for key, each in reversed(inner)]


def _in_words(detail: ErrorDetails) -> str:
    context = detail.get("ctx", {})
    if detail["type"] == "missing":
        return "is missing"
    if detail["type"] in ("too_short", "too_long"):
        needed = context.get("min_length", context.get("max_length"))
        return f"has {context['actual_length']} numbers, but needs {needed}"
    return detail["msg"].removeprefix("Input ").replace("a valid ", "a ")


COMPONENT = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_NOTHING: list[dict[str, Any]] = []
_GLB_MAGIC = b"glTF"
_JSON_CHUNK = 0x4E4F534A
_BINARY_CHUNK = 0x004E4942


Bytes: TypeAlias = bytes | memoryview


@dataclass(frozen=True)
class GltfFile:
    """A parsed file.

    `root` is its JSON, `binary` the GLB's own buffer if there is one; `account` is what reading it
    may cost, and has.
    """

    path: Path
    root: dict[str, Any]
    binary: Bytes | None
    account: Account
    _fetched: dict[Path, bytes] = field(default_factory=dict, repr=False)

    def item(self, key: str, index: int) -> dict[str, Any]:
        """Return one item of the file's list called `key`."""
        return self.items(key)[index]

    def fault(self, what: str, wrong: str) -> InputError:
        """Return the error of a named part of the file."""
        return InputError(f"{what} {wrong}; export the file again", file=self.path)

    def items(self, key: str) -> list[dict[str, Any]]:
        """Return the file's own list called `key`, not a copy; empty where there is none."""
        items: list[dict[str, Any]] = self.root.get(key, _NOTHING)
        return items

    @cached_property
    def buffers(self) -> list[Bytes]:
        """Return the bytes of every buffer."""
        return [self._buffer(item, index) for index, item in enumerate(self.items("buffers"))]

    def _buffer(self, item: dict[str, Any], index: int) -> Bytes:
        if "uri" in item:
            data: Bytes = self._fetch(item["uri"], f"buffer {index}")
        elif index == 0 and self.binary is not None:
            data = self.binary
        else:
            raise InputError(f"buffer {index} has no data; export the file again", file=self.path)
        if len(data) < item["byteLength"]:
            raise InputError(
                f"buffer {index} holds {len(data)} of its {item['byteLength']} bytes: "
                "the file is cut off; copy or export it again",
                file=self.path,
            )
        return data

    def _fetch(self, uri: str, what: str) -> bytes:
        """Return the bytes behind a data URI or a path relative to the file."""
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except ValueError:
                raise self.fault("a data URI", "is not base64") from None
        target = self._beside(uri, what)
        if target in self._fetched:
            return self._fetched[target]
        try:
            if target.is_file():  # a device may never end
                self.account.spend("file_bytes", target.stat().st_size, what)
                return self._fetched.setdefault(target, read_bytes(target))
        except OSError:
            pass
        raise InputError(
            f"needs the file {uri!r}, which cannot be read; keep it beside the scene",
            file=self.path,
        )

    def _beside(self, uri: str, what: str) -> Path:
        """Return the path that a URI names; a scene reads nothing outside of its own folder."""
        name, folder = urllib.parse.unquote(uri), self.path.parent.resolve()
        away = PureWindowsPath(name)  # which has a drive or a root wherever a POSIX path has one
        if not away.drive and not away.root and ":" not in name and "\0" not in name:
            target = (folder / name).resolve()
            if target.is_relative_to(folder):
                return target
        raise InputError(
            f"{what} is {uri[:200]!r}, which is not in the scene's folder, or links out of it; "
            "put the file itself beside the scene and name it without a path",
            file=self.path,
        )

    def view(self, index: int) -> tuple[memoryview, int | None]:
        """Return the bytes of a buffer view and its stride."""
        item = self.item("bufferViews", index)
        start = item.get("byteOffset", 0)
        data = memoryview(self.buffers[item["buffer"]])[start : start + item["byteLength"]]
        return data, item.get("byteStride")

    def accessor(self, index: int, what: str, kinds: Sequence[str]) -> NDArray[Any]:
        """Return an accessor as (count, width), float64 where it is normalised.

        Parameters
        ----------
        what
            The part of the file that it belongs to, for messages.
        kinds
            The types that it may have, such as ``VEC3``.

        Raises
        ------
        InputError
            If it has another type, reaches beyond its data, or has a number that is not finite.
        """
        item = self.item("accessors", index)
        if item["type"] not in kinds:
            needed = " or ".join(kinds)
            raise self.fault(what, f"needs {needed} in accessor {index}, which has {item['type']}")
        width, dtype = WIDTH[item["type"]], np.dtype(COMPONENT[item["componentType"]])
        self.account.spend("numbers", item["count"] * width, what)
        if "bufferView" in item:
            values = self._elements(item, dtype, item["count"], width).copy()
        else:
            self.account.spend("zeros", item["count"] * width, what)
            values = np.zeros((item["count"], width), dtype)
        if "sparse" in item:
            self._apply_sparse(item["sparse"], values)
        if not np.isfinite(values).all():
            raise self.fault(what, f"has a number in accessor {index} that is not finite")
        return _denormalise(values) if item.get("normalized") else values

    def _elements(
        self, item: dict[str, Any], dtype: np.dtype[Any], count: int, width: int
    ) -> NDArray[Any]:
        data, stride = self.view(item["bufferView"])
        size = dtype.itemsize * width
        offset, stride = item.get("byteOffset", 0), stride or size
        if count < 1 or offset + stride * (count - 1) + size > len(data):
            raise InputError("an accessor reaches beyond its buffer; export again", file=self.path)
        return np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))

    def _apply_sparse(self, sparse: dict[str, Any], values: NDArray[Any]) -> None:
        count = sparse["count"]
        dtype = np.dtype(COMPONENT[sparse["indices"]["componentType"]])
        rows = self._elements(sparse["indices"], dtype, count, 1)[:, 0]
        if rows.max() >= len(values):
            message = "a sparse accessor has rows out of range; export the file again"
            raise InputError(message, file=self.path)
        values[rows] = self._elements(sparse["values"], values.dtype, count, values.shape[1])

    def image(self, index: int) -> NDArray[np.uint8]:
        """Return an image as (height, width, 4) uint8."""
        item = self.item("images", index)
        what = f"image {item.get('name', index)!r}"
        data = (
            self._fetch(item["uri"], what)
            if "uri" in item
            else bytes(self.view(item["bufferView"])[0])
        )
        try:
            with warnings.catch_warnings():
                # Pillow's own limit is lower than the budget, or not there.
                warnings.simplefilter("ignore", PillowImage.DecompressionBombWarning)
                return self._decoded(data, what)
        except InputError:
            raise
        except (
            SyntaxError,
            EOFError,
            OSError,
            PillowImage.DecompressionBombError,
            *STRUCTURE_ERRORS,
        ):
            raise InputError(f"{what} cannot be decoded; use PNG or JPEG", file=self.path) from None

    def _decoded(self, data: bytes, what: str) -> NDArray[np.uint8]:
        with PillowImage.open(io.BytesIO(data), formats=("PNG", "JPEG")) as picture:
            width, height = picture.size
            most = self.account.budget.image_pixels
            if width * height > most:
                raise InputError(
                    f"{what} is {width}x{height}, and {most} pixels are the most; make it smaller",
                    file=self.path,
                )
            self.account.spend("pixels", width * height, what)
            pixels = np.empty((height, width, 4), np.uint8)
            # In strips: Pillow would hold a large picture four times while it is converted.
            for top in range(0, height, _STRIP):
                strip = picture.crop((0, top, width, min(top + _STRIP, height)))
                pixels[top : top + _STRIP] = np.asarray(_in_8_bits(strip).convert("RGBA"))
        return pixels


_STRIP = 256
"""Rows of a picture that are converted at once."""


def _in_8_bits(picture: PillowImage.Image) -> PillowImage.Image:
    """Return 16 bits of grey in 8: converted otherwise they would be clipped."""
    if not picture.mode.startswith("I"):
        return picture
    return PillowImage.fromarray((np.asarray(picture) >> 8).astype(np.uint8))


def read_gltf_file(path: Path, budget: SceneBudget | None = None) -> GltfFile:
    """Read a .glb or .gltf file.

    Raises
    ------
    InputError
        If the file is missing, is not glTF 2.0, is cut off, or costs more than the budget.
    """
    account = Account(path, budget or SceneBudget())
    try:
        account.spend("file_bytes", path.stat().st_size, "the file")
        data = read_bytes(path, most=sys.maxsize)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror}); check the path", file=path) from None
    text, binary = _unpack_glb(data, path) if data[:4] == _GLB_MAGIC else (data, None)
    account.spend("json_bytes", len(text), "the file")
    account.spend("json_marks", sum(map(bytes(text).count, (b"[", b"{", b","))), "the file")
    root = _parsed(bytes(text), path, account.budget.json_marks)
    if not isinstance(root, dict) or not str(_version(root)).startswith("2."):
        raise InputError(_OLD, file=path)
    account.spend("items", count_items(root), "the file")
    check_structure(root, path)
    return GltfFile(path, root, binary, account)


def _parsed(text: bytes, path: Path, most_marks: int) -> Any:
    try:
        words = str(text, "utf-8-sig")
    except ValueError:
        words = ""
    if not words.lstrip().startswith(("{", "[")):
        raise InputError("is not glTF: no GLB header and no JSON text", file=path)
    return parse_json(words, path, what="glTF", advice="export it again", most_marks=most_marks)


_OLD = "is not glTF 2.0; convert it to version 2.0"


def _version(root: dict[str, Any]) -> Any:
    asset = root.get("asset")
    return asset.get("version") if isinstance(asset, dict) else None


def _unpack_glb(data: bytes, path: Path) -> tuple[Bytes, Bytes | None]:
    """Return the JSON and binary chunks of a GLB container."""
    version, length = struct.unpack_from("<II", data, 4) if len(data) >= 20 else (2, None)
    if version != 2:
        raise InputError(_OLD, file=path)
    if length is None or len(data) < length:
        raise InputError(
            f"is cut off: {len(data)} of {length or 'at least 20'} bytes; copy or export it again",
            file=path,
        )
    chunks: dict[int, memoryview] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        chunks.setdefault(kind, memoryview(data)[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON_CHUNK not in chunks:
        raise InputError("has no JSON chunk; export it again", file=path)
    return chunks[_JSON_CHUNK], chunks.get(_BINARY_CHUNK)


def _denormalise(values: NDArray[Any]) -> NDArray[np.float64]:
    """Map integers to [0, 1] or [-1, 1] (specification, §3.11 "normalized")."""
    if values.dtype.kind == "f":
        return values.astype(np.float64)
    return np.maximum(values / np.iinfo(values.dtype).max, -1.0)


#: What reading malformed JSON structure raises before anything sensible can be said.
STRUCTURE_ERRORS = (
    KeyError, IndexError, TypeError, AttributeError, ValueError, struct.error, binascii.Error,
)  # fmt: skip
