"""Shows the result of an import in a few lines."""

from __future__ import annotations

from collections import Counter, defaultdict

from vrcomfort.importing.rows import Administration, Imported
from vrcomfort.plurals import counted

FIRST = 8


def preview(imported: Imported) -> list[str]:
    """Return the first rows as imported, counts, and missing answers; one line each."""
    return [*_first_rows(imported), "", *_counts(imported), *_missing(imported)]


def _first_rows(imported: Imported) -> list[str]:
    responses = list(imported.responses.items())[:FIRST]
    rows = [
        [*_shown(m), instrument, " ".join(map(_cell, response.answers.values()))]
        for (instrument, m), response in responses
    ]
    rows += [
        [*_shown(r.administration), r.instrument, f"{_cell(r.response)} at {r.onset_s:g} s"]
        for r in imported.ratings[: max(0, FIRST - len(rows))]
    ]
    heading = ["participant", "session", "trial", "condition", "timepoint", "instrument", "answers"]
    return aligned([heading, *rows])


def _shown(m: Administration) -> list[str]:
    return [m.participant, m.session, m.trial or m.period, m.condition, m.timepoint]


def _cell(value: float | None) -> str:
    return "." if value is None else f"{value:g}"


def aligned(rows: list[list[str]]) -> list[str]:
    """Return the lines of a table; columns without a single text are left out."""
    kept = [i for i in range(len(rows[0])) if any(row[i] for row in rows[1:])]
    widths = {i: max(len(row[i]) for row in rows) for i in kept}
    return ["  ".join(row[i].ljust(widths[i]) for i in kept).rstrip() for row in rows]


def _counts(imported: Imported) -> list[str]:
    who: dict[tuple[str, ...], set[str]] = defaultdict(set)
    what: Counter[tuple[str, ...]] = Counter()
    for (instrument, m), response in imported.responses.items():
        key = (instrument, m.condition or "(no condition)", m.timepoint)
        who[key].add(m.participant)
        what[key] += 1
        what["items", *key] = max(what["items", *key], len(response.answers))
    lines = [
        f"{key[0]}: {key[1]}, {key[2]}: {counted(len(found), 'participants')}, "
        f"{counted(what[key], 'questionnaires')}, "
        f"{counted(what['items', *key], 'scores' if key[0] in imported.scores else 'items')}"
        for key, found in who.items()
    ]
    rated = Counter((r.instrument, r.administration.condition) for r in imported.ratings)
    lines += [
        f"{name}: {condition}: {count} ratings during exposure"
        for (name, condition), count in rated.items()
    ]
    if imported.ends:
        left = Counter(end.administration.condition for end in imported.ends if end.left)
        shown = ", ".join(f"{n} {name or '(no condition)'}" for name, n in left.items())
        lines.append(f"{len(imported.ends)} exposures; left: {shown or 'none'}")
    people = counted(len(imported.participants), "participants")
    total = f"{people}, {counted(len(imported.conditions), 'conditions')}"
    names = ", ".join(imported.covariates)
    return [total + (f"; known of participants: {names}" if names else ""), *lines]


def _missing(imported: Imported) -> list[str]:
    absent = Counter(
        (instrument, item)
        for (instrument, _), response in imported.responses.items()
        for item, answer in response.answers.items()
        if answer is None
    )
    lines = [f"missing: {n} answers to {item} ({name})" for (name, item), n in absent.items()]
    for name, items in imported.not_asked.items():
        lines.append(f"not asked: {', '.join(items)} ({name})")
    return lines or ["missing: none"]
