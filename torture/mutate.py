"""Makes a file worse: some bytes of it, or one of the values that it holds."""

from __future__ import annotations

import copy
import csv
import io
import json
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

Rng = np.random.Generator

VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, 99, 10**6, 10**18, 10**400, 0.5, 1e39, 1e300, float("nan"), float("inf"),
    float("-inf"), "", "x", "../../../etc/passwd", "\0", [], {}, [1.0], [[]], [None], {"x": 1},
    [float("nan")] * 3, "x" * 10_000,
)  # fmt: skip
CELLS = (
    "", " ", "x", "-1", "0", "99", "1e300", "-1e300", "inf", "nan", "1_0", "٣", "9" * 30, "0x10",
    '"', "a,b", "\0", "=1+1", "\u2028", "\r", "true", "P01",
)  # fmt: skip
TOML_VALUES = (
    "nan", "inf", "-1", "0", "1e300", "99999999999999999999", "true", '""', '"x"', "[]", "{}",
    "[[]]", "1979-05-27", '"\\u0000"', "[1, [2, [3]]]", '["x", "x"]', "{ x = 1 }", "= 1",
)  # fmt: skip


def pick(rng: Rng, values: Any) -> Any:
    """Return one of the values (as it is, where NumPy would make an array of it)."""
    return values[int(rng.integers(len(values)))]


def in_bytes(content: bytes, rng: Rng) -> bytes:
    """Change some bytes: another value, gone, twice, cut off, zeros."""
    at = int(rng.integers(len(content) + 1))
    length = int(2 ** rng.uniform(0, 8))
    piece = content[at : at + length]
    changed = (
        content[:at],
        content[:at] + content[at + length :],
        content[:at] + piece + piece + content[at + length :],
        content[:at] + rng.bytes(length) + content[at + length :],
        content[:at] + bytes(length) + content[at + length :],
        content + bytes(length),
        content[:at] + b"\xff\xfe\xed\xa0\x80" + content[at:],
        content[at:] + content[:at],
        b"",
    )
    return changed[int(rng.integers(len(changed)))]


def in_json(content: bytes, rng: Rng, *, top: bool = False) -> bytes:
    """Put something else into one place, or take it away.

    Parameters
    ----------
    top
        A place of the first level only.
    """
    root = json.loads(content)
    changed = json_places(root) if not top else [(key,) for key in root]
    place = pick(rng, list(changed))
    holder: Any = root
    for key in place[:-1]:
        holder = holder[key]
    if rng.random() < 0.2:
        del holder[place[-1]]
    else:
        holder[place[-1]] = copy.deepcopy(pick(rng, VALUES))
    return json.dumps(root).encode()


def json_places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield where every value is."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in items:
        yield (*path, key)
        if isinstance(item, dict | list):
            yield from json_places(item, (*path, key))


def in_toml(content: bytes, rng: Rng) -> bytes:
    """Change the value of a line, or have the line twice, elsewhere or not at all."""
    lines = content.decode().splitlines()
    named = [n for n, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    at = int(pick(rng, named))
    change = int(rng.integers(6))
    if change < 3 and "=" in lines[at]:
        lines[at] = f"{lines[at].partition('=')[0]}= {pick(rng, TOML_VALUES)}"
    elif change == 3:
        lines.insert(at, lines[at])
    elif change == 4:
        lines.insert(int(pick(rng, named)), lines.pop(at))
    else:
        lines[at] = re.sub(r"[\w.]+", lambda found: found[0][::-1], lines[at], count=1)
    return "\n".join(lines).encode(errors="surrogatepass") + b"\n"


def in_csv(content: bytes, rng: Rng) -> bytes:
    """Change a cell (of the header too), a row or a column."""
    rows = list(csv.reader(io.StringIO(content.decode(), newline="")))
    at = int(rng.integers(len(rows))) if rng.random() < 0.9 else 0
    row = rows[at]
    cell = int(rng.integers(len(row)))
    change = int(rng.integers(8))
    if change < 4:
        row[cell] = pick(rng, CELLS)
    elif change == 4:
        del row[cell]
    elif change == 5:
        rows.insert(at, row)
    elif change == 6:
        for each in rows:
            del each[cell : cell + 1]
    else:
        rows[at] = pick(rng, rows)
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode(errors="surrogatepass")


def in_archive(content: bytes, rng: Rng) -> bytes:
    """Change the bytes of a part of a ZIP archive, or leave it out."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    name = pick(rng, [*parts, *[name for name in parts if "sheet" in name.lower()] * 3])
    if rng.random() < 0.1:
        del parts[name]
    else:
        parts[name] = in_bytes(parts[name], rng)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for each, part in parts.items():
            archive.writestr(each, part)
    return file.getvalue()


_NO_STRUCTURE = (
    ValueError, IndexError, csv.Error, zipfile.BadZipFile, zlib.error, EOFError,
    RuntimeError,  # of archives with a password, and of versions and compressions to come
)  # fmt: skip

BY_SUFFIX: Mapping[str, Callable[[bytes, Rng], bytes]] = {
    ".json": in_json,
    ".gltf": in_json,
    ".toml": in_toml,
    ".csv": in_csv,
    ".xlsx": in_archive,
}


def worse(content: bytes, suffix: str, rng: Rng) -> bytes:
    """Change a file once or twice, two thirds of the time by what it holds."""
    for _ in range(int(rng.integers(1, 3))):
        by_structure = BY_SUFFIX.get(suffix, in_bytes)
        change = by_structure if rng.random() < 2 / 3 else in_bytes
        try:
            content = change(content, rng)
        except _NO_STRUCTURE:  # the change before has left none
            content = in_bytes(content, rng)
    return content
