"""Writes what became of mutants: JSON, and a table with the survivors."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mutants.sample import Mutant

STATUSES = ("killed", "timed out", "survived", "unclear", "not tried")


def write(out: Path, mutants: Sequence[Mutant], facts: Mapping[str, Any]) -> str:
    """Write ``mutants.json`` and ``mutants.md``; return the table."""
    out.mkdir(parents=True, exist_ok=True)
    listed = {**facts, "mutants": [mutant.facts() for mutant in mutants]}
    (out / "mutants.json").write_text(json.dumps(listed, indent=1) + "\n", "utf-8")
    page = f"{table(mutants, facts)}\n{survivors(mutants)}"
    (out / "mutants.md").write_text(page, "utf-8")
    return page


def table(mutants: Sequence[Mutant], facts: Mapping[str, Any]) -> str:
    """Return a row for each subpackage, and one for all."""
    counts = Counter((mutant.module.subpackage, mutant.status) for mutant in mutants)
    names = sorted({mutant.module.subpackage for mutant in mutants})
    heads = ("subpackage", "mutants", *STATUSES)
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for name in [*names, "all"]:
        row = [sum(counts[each, status] for each in (names if name == "all" else [name]))
               for status in STATUSES]  # fmt: skip
        lines.append(f"| {' | '.join(map(str, (name, sum(row), *row)))} |")
    said = [
        f"\n`{facts['command']}`: {facts['tests']} tests (`{facts['marks']}`).",
        "Unclear: the test that failed fails without the mutant, too.",
    ]
    if facts["left_out"]:
        said.append(f"Left out, for they do not pass alone: {len(facts['left_out'])} tests.")
    return "\n".join([*lines, *said, ""])


def survivors(mutants: Sequence[Mutant]) -> str:
    """Return each mutant that no test notices, with its lines."""
    lines = []
    for mutant in mutants:
        if mutant.status in {"survived", "unclear"}:
            not_run = f", {mutant.not_run} covering ones not" if mutant.not_run else ""
            about = f"{mutant.status}, {mutant.site.operator}; {mutant.run} tests run{not_run}"
            lines += [f"{mutant.place} ({about})", *(f"    {line}" for line in mutant.diff()), ""]
    return "\n".join(lines)
