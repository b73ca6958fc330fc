"""Writes the files of a BIDS dataset: tab-separated, "n/a" where nothing is known."""

from __future__ import annotations

import csv
import gzip
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from vrcomfort.json_text import json_of

MISSING = "n/a"


def write_json(file: Path, content: Mapping[str, Any]) -> None:
    """Write a sidecar."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json_of(content) + "\n", encoding="utf-8")


def write_tsv(file: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table with a header; blank and None are "n/a"."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(_tsv([columns, *rows]), encoding="utf-8")


def write_samples(file: Path, rows: Iterable[Sequence[object]]) -> None:
    """Write samples without a header, compressed where the name ends in .gz."""
    file.parent.mkdir(parents=True, exist_ok=True)
    text = _tsv(rows)
    if file.suffix == ".gz":
        file.write_bytes(gzip.compress(text.encode(), mtime=0))  # the same bytes each time
    else:
        file.write_text(text, encoding="utf-8")


def _tsv(rows: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n", quoting=csv.QUOTE_NONE,
                        escapechar="\\")  # fmt: skip
    writer.writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue()


def _cell(value: object) -> str:
    text = "" if value is None else " ".join(str(value).split())
    return text or MISSING
