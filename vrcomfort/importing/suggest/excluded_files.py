"""Finds files to leave out: trial runs, and starts that were broken off and repeated."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import ROWS, OpenDoubt
from vrcomfort.importing.suggest.names_of_files import DATE
from vrcomfort.importing.suggest.vocabulary import LabVocabulary, tokens

_RARE = 5
"""One in so many files, at most, is a start that was repeated."""


def excluded_files(
    tables: Sequence[SourceTable], vocabulary: LabVocabulary
) -> tuple[list[Path], list[OpenDoubt]]:
    """Return the files to leave out, and the questions whether they are."""
    files = list(dict.fromkeys(table.file for table in tables))
    names = [file.name for file in files]
    if len(files) < _RARE or len({*names}) < len(names):
        return [], []
    rows = {file: sum(len(t.rows) for t in tables if t.file == file) for file in files}
    words = vocabulary.trial_runs.get("participant", frozenset())
    tests = [file for file in files if words & {*tokens(file.stem)[:1]}]
    tests = tests if len(tests) * _RARE <= len(files) else []
    started: dict[str, list[Path]] = {}
    for file in files:
        started.setdefault(DATE.sub("", file.stem), []).append(file)
    again = [sorted(each, key=lambda f: rows[f]) for each in started.values() if len(each) > 1]
    broken = [file for each in again for file in each[:-1] if rows[file] * 2 < rows[each[-1]]]
    broken = broken if len(again) * _RARE <= len(files) else []
    doubts = []
    for out, why in ((tests, "runs of a test"), (broken, "broken off, and started again later")):
        if out:
            shown = ", ".join(file.name for file in out)
            question = f"May {shown} be left out, as {why}?"
            doubts.append(OpenDoubt(question, "yes", ROWS))
    return [*tests, *broken], doubts
