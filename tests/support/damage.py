"""Damages one value of a recorded session at a time."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import CsvTable
from vrcomfort.records.rows import csv_line
from vrcomfort.records.shared_columns import POSE_COLUMNS

LONG = "x" * 200_000
HUGE = 10**40

JSON_VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 1, HUGE, -1.5, 1e300, float("nan"), float("inf"), "", "x", "1", LONG,
    "\0\0", "\ud800", [], [1], [[]], {}, {"x": 1}, "2026-01-01T00:00:00",
)  # fmt: skip
CELLS = (
    "inf", "-inf", "1e300", "-1", "0", "1.5", "99", str(HUGE), "9" * 5000,
    "1_000", "٣", '"', "a,b", " ", "nan", "x", "", LONG, "\0\0\0",
)  # fmt: skip

Damage = tuple[str, Callable[[Path], None]]
"""What is damaged in words, and how, given the session's folder or the study's."""


def of_json(file: str, content: dict[str, Any]) -> Iterator[Damage]:
    """Yield every key with every hostile value, without it, and with one key in it damaged."""
    for path in _paths(content):
        for value in JSON_VALUES:
            yield f"{file} {path} = {str(value)[:20]!r}", _set(file, path, value)
        yield f"{file} without {path}", _unset(file, path)


def _paths(content: dict[str, Any]) -> Iterator[tuple[str, ...]]:
    for key, value in content.items():
        yield (key,)
        if isinstance(value, dict) and key in {"protocol", "headset", "under_way", "memory"}:
            yield from ((key, *rest) for rest in _paths(value))


def _set(file: str, path: tuple[str, ...], value: Any) -> Callable[[Path], None]:
    def damage(folder: Path) -> None:
        content = json.loads((folder / file).read_text())
        _holder(content, path)[path[-1]] = value
        (folder / file).write_text(json.dumps(content))

    return damage


def _unset(file: str, path: tuple[str, ...]) -> Callable[[Path], None]:
    def damage(folder: Path) -> None:
        content = json.loads((folder / file).read_text())
        del _holder(content, path)[path[-1]]
        (folder / file).write_text(json.dumps(content))

    return damage


def _holder(content: dict[str, Any], path: tuple[str, ...]) -> dict[str, Any]:
    for key in path[:-1]:
        content = content[key]
    return content


def of_csv(file: Path) -> Iterator[Damage]:
    """Yield every column with every hostile cell in its last row, and rows that cannot be."""
    table = CsvTable.read(file)
    for column, name in enumerate(table.header):
        for cell in CELLS if name not in POSE_COLUMNS else CELLS[-6:]:
            row = [*table.rows[-1]]
            row[column] = cell
            yield f"{file.name} {name} = {cell[:20]!r}", _lines(file.name, table, row)
    yield f"{file.name}: a row twice", _lines(file.name, table, [*table.rows[-1]], more=True)
    yield f"{file.name}: a short row first", _lines(file.name, table, ["1"], first=True)


def _lines(
    file: str, table: CsvTable, row: list[str], *, more: bool = False, first: bool = False
) -> Callable[[Path], None]:
    kept = [*table.rows] if more else [*table.rows[:-1]]
    rows = [row, *kept] if first else [*kept, row]

    def damage(folder: Path) -> None:
        text = csv_line(table.header) + "".join(map(csv_line, rows))
        (folder / file).write_text(text, encoding="utf-8", newline="")

    return damage


def of_bytes(file: Path, step: int) -> Iterator[Damage]:
    """Yield the file cut at every `step` bytes, with NULs after the cut, and with NULs within."""
    content = file.read_bytes()
    for at in range(0, len(content) + 1, step):
        yield f"{file.name} cut at {at}", _bytes(file.name, content[:at])
        yield f"{file.name} NULs from {at}", _bytes(file.name, content[:at] + bytes(30))
        within = content[:at] + bytes(3) + content[at + 3 :]
        yield f"{file.name} NULs at {at}", _bytes(file.name, within)


def _bytes(file: str, content: bytes) -> Callable[[Path], None]:
    return lambda folder: (folder / file).write_bytes(content) and None
