"""Writes a list of rows as JSON and as a Markdown table."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple


class Result(NamedTuple):
    """Rows with the same keys, and sentences that say how they came about."""

    title: str
    rows: Sequence[dict[str, Any]]
    notes: Sequence[str]


def write(folder: Path, name: str, result: Result) -> None:
    """Write ``name.json`` and ``name.md`` into `folder` and print the table."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(result._asdict(), indent=1, ensure_ascii=False)
    (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    markdown = _markdown(result)
    (folder / f"{name}.md").write_text(markdown, encoding="utf-8")
    print(markdown)


def _markdown(result: Result) -> str:
    names = list(result.rows[0])
    lines = [f"## {result.title}", "", _line(names), _line(["---"] * len(names))]
    lines += [_line([_text(row[name]) for name in names]) for row in result.rows]
    lines += ["", *(f"- {note}" for note in result.notes), ""]
    return "\n".join(lines)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
