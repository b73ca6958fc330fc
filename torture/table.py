"""Writes what became of all cases: a table for people, every case for who looks into one."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from torture.case import Result

SHOWN_FAULTS = 20


def write(folder: Path, results: Sequence[Result], *, command: str, gpu: str) -> str:
    """Write ``torture.json`` and ``torture.md`` into `folder`; return the table."""
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, {gpu}"
    day = datetime.now(UTC).date().isoformat()
    markdown = "\n".join(
        [
            *_table([result.row() for result in results]),
            "",
            f"Measured on {day} with `{command}` ({machine}).",
            "",
            *(f"- **{result.name}**: {result.story}" for result in results),
            "",
        ]
    )
    content = {
        "command": command,
        "date": day,
        "machine": machine,
        "tortures": [
            result.row()
            | {"how": result.story}
            | {"of": [asdict(each) | {"happened": each.happened} for each in result.outcomes]}
            for result in results
        ],
    }
    text = json.dumps(content, indent=1, ensure_ascii=False)
    (folder / "torture.json").write_text(text + "\n", encoding="utf-8")
    (folder / "torture.md").write_text(markdown, encoding="utf-8")
    return markdown


def faults(results: Iterable[Result]) -> list[str]:
    """Return the first cases that did not go well, a line each."""
    wrong = [
        f"{result.name}: {each.name} (seed {each.seed}): {each.happened}; {each.detail}"
        for result in results
        for each in result.outcomes
        if each.happened != "ok"
    ]
    more = len(wrong) - SHOWN_FAULTS
    return wrong[:SHOWN_FAULTS] + ([f"... and {more} more, in torture.json"] if more > 0 else [])


def _table(rows: Sequence[dict[str, object]]) -> list[str]:
    names = list(rows[0])
    marks = ["---"] + ["--:"] * (len(names) - 1)
    cells = [[str(row[name]) for name in names] for row in rows]
    return [f"| {' | '.join(line)} |" for line in (names, marks, *cells)]
