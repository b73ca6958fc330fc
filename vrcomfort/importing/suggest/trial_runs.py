"""Finds the rows of trial runs, which labs leave in their exports: previews, tests, admins."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.evidence import texts
from vrcomfort.importing.suggest.heading_roles import inner_names, names_fact
from vrcomfort.importing.suggest.vocabulary import LabVocabulary, tokens
from vrcomfort.questionnaire import plain

_PLACEHOLDER = re.compile(r"0+|9{2,}")


def _placeholder_codes(codes: Sequence[str]) -> set[str]:
    """Return the code ``000`` or ``999`` if it has fewer rows than each of the others."""
    counts = Counter(code for code in codes if code)
    found = {code for code in counts if _PLACEHOLDER.fullmatch(code)}
    others = [count for code, count in counts.items() if code not in found]
    return {code for code in found if others and counts[code] < min(others)}


def rows_of_trial_runs(table: SourceTable, vocabulary: LabVocabulary) -> dict[int, list[str]]:
    """Return column → its texts in rows that are no person's, each row by one column.

    A survey program says so, or the code in place of the person's is a word such as ``test``.
    """
    found: dict[int, list[str]] = {}
    kept = table.rows
    for column, (heading, label) in enumerate(zip(table.headings, table.labels, strict=True)):
        words = vocabulary.trial_runs.get(plain(heading), frozenset())
        words |= vocabulary.trial_runs.get(plain(label), frozenset())
        names = inner_names(heading) if table.nested else (heading,)
        person = any(names_fact(name, "participant", vocabulary) for name in names)
        if person:
            words |= vocabulary.trial_runs.get("participant", frozenset())
        said = {row[column] for row in kept if plain(row[column]) in words}
        if person:
            said |= _placeholder_codes([row[column] for row in kept])
            said |= {row[column] for row in kept if {*tokens(row[column])} & words}  # test123
        rest = tuple(row for row in kept if row[column] not in said)
        if said and len(rest) * 2 > len(table.rows):
            found[column] = [text for text in texts(table, column) if text in said]
            kept = rest
    return found
