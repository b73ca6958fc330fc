"""Finds the facts in names of files and sheets: what differs between them; and files to leave out.

These are trial runs, and starts that were broken off and repeated.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path

from vrcomfort.importing.source import SourceTable
from vrcomfort.importing.suggest.draft import ROWS, OpenDoubt
from vrcomfort.importing.suggest.vocabulary import LabVocabulary, tokens

_PART = re.compile(r"([_\-\s./]+)")
DATE = re.compile(
    r"(?<!\d)((19|20)\d\d[-_.]?[01]\d[-_.]?[0-3]\d|[0-3]\d[-_.][01]\d[-_.](19|20)\d\d)"
    r"([-_. T]{1,3}[0-2]\d[-_.:h]?[0-5]\d([-_.:m]?[0-5]\d([.]\d+)?)?)?(?!\d)"
)
"""A date, perhaps with a time behind it: ``20241104-1004``, ``2024-11-04_10h04``."""
_ANY = "\N{REPLACEMENT CHARACTER}"
"""Stands in for a date, which says nothing of a questionnaire, where names differ otherwise."""


@dataclass(frozen=True)
class NameParts:
    """How names are made.

    Parameters
    ----------
    template
        With ``{condition}`` and the like where they differ, or a regular expression.
    texts
        Fact → the different texts that stand for it; ``""`` where names lack a word.
    expression
        Whether it is a regular expression.
    """

    template: str
    texts: dict[str, list[str]]
    expression: bool = False


def parts_of_names(
    names: Sequence[str],
    wanted: Sequence[str],
    vocabulary: LabVocabulary,
    people: Sequence[str] = (),
) -> NameParts | None:
    """Return the parts that differ between names, as facts; None where none differs.

    Timepoints are known by their words, sessions by theirs; of the rest, what differs most is
    the participant, where that is wanted.

    Parameters
    ----------
    people
        The one participant of each name, where columns say it: names may say it again.
    """
    dated = [DATE.sub(_ANY, name) for name in names]
    if len(set(dated)) > 1 and all(map(DATE.search, names)):
        found = parts_of_names(dated, wanted, vocabulary, people)
        sign = ".*?" if found is not None and found.expression else "{*}"
        return found and replace(found, template=found.template.replace(_ANY, sign))
    split = [_PART.split(name) for name in names]
    if len(set(names)) < 2 or not wanted:
        return None
    if len({tuple(parts[1::2]) for parts in split}) > 1:  # made in different ways
        found = _optional(names, wanted, vocabulary) or _whole(names, wanted, vocabulary)
        return None if people and len({*people}) == len({*names}) else found
    columns = list(zip(*split, strict=True))
    differing = [i for i in range(0, len(columns), 2) if len(set(columns[i])) > 1]
    differing = [i for i in differing if not _tells_apart(columns[i], people)]
    left = list(wanted)
    roles: dict[int, str] = {}
    for i in differing:
        if "timepoint" in left and all(vocabulary.timepoint(text) for text in columns[i]):
            roles[i] = "timepoint"
            left.remove("timepoint")
    for i in differing:
        # S01 is a person's code, too, unless other parts differ more.
        most = max(_variety(columns[k]) for k in differing)
        words = _SESSION if _variety(columns[i]) == most else _SHORT_SESSION
        session = all(words.fullmatch(text) for text in columns[i])
        if i not in roles and session and "session" in left and len(differing) > 1:
            roles[i] = "session"
            left.remove("session")
    rest = [i for i in differing if i not in roles]
    for fact in ("participant", "condition"):
        if fact in left and rest:
            # Conditions are words rather than numbers; people differ most.
            key = _variety if fact == "participant" else _wordiness
            chosen = max(rest, key=lambda i, key=key: key(columns[i]))  # type: ignore[misc]
            roles |= {i: fact for i in rest if columns[i] == columns[chosen]}
            rest = [i for i in rest if i not in roles]
    told = {tuple(columns[i][k] for i in roles) for k in range(len(names))}
    worded = [i for i in rest if not all(map(str.isdecimal, columns[i]))]
    alone = "condition" in wanted and "participant" not in wanted
    if alone and worded and len(told) < len({*names}):
        return _whole(names, ["condition"], vocabulary)  # 360_stereo, 360_mono, cgi_stereo
    return _made(columns, roles)


def _tells_apart(texts: Sequence[str], people: Sequence[str]) -> bool:
    """Return whether each text goes with one person, and each person with one text."""
    pairs = len({*zip(texts, people, strict=True)}) if people else 0
    return pairs == len({*texts}) == len({*people})


_SESSION = re.compile(r"(?i)(ses(sion)?|day|visit)\d+")
_SHORT_SESSION = re.compile(r"(?i)(ses(sion)?|s|day|visit)\d+")


def _variety(texts: Sequence[str]) -> int:
    return len({*texts})


def _wordiness(texts: Sequence[str]) -> bool:
    return not any(letter.isdecimal() for text in texts for letter in text)


def _optional(
    names: Sequence[str], wanted: Sequence[str], vocabulary: LabVocabulary
) -> NameParts | None:
    """Return how names are made of which some have a word that others lack: ``P01_SSQ[_PRE]``.

    Words that all names share are anchors; before the first one stands the participant, and after
    the last one words for the timepoint and for the condition.
    """
    split = [_PART.split(name)[::2] for name in names]
    anchors = [word for word in split[0] if all(words.count(word) == 1 for words in split)]
    if not anchors or {"participant", "condition", "timepoint"} - {*wanted}:
        return None
    first = [words.index(anchors[0]) for words in split]
    ends = [words[words.index(anchors[-1]) + 1 :] for words in split]
    middle = {tuple(w[w.index(anchors[0]) : w.index(anchors[-1]) + 1]) for w in split}
    if {*first} != {1} or len(middle) > 1 or max(map(len, ends)) > 2:
        return None
    rest = list(dict.fromkeys(word for words in ends for word in words))
    when = [word for word in rest if vocabulary.timepoint(word)]
    what = [word for word in rest if word not in when]
    texts: dict[str, list[str]] = {"participant": list(dict.fromkeys(w[0] for w in split))}
    slots = [("timepoint", when), ("condition", what)]
    if any(len(words) == 2 and words[0] in what for words in ends):
        slots.reverse()
    sign = r"[_\-\s.]+"
    pattern = rf"(?P<participant>[^_\-\s.]+){sign}" + sign.join(map(re.escape, min(middle)))
    for fact, words in slots:
        if words:
            pattern += rf"(?:{sign}(?P<{fact}>{'|'.join(map(re.escape, words))}))?"
            blank = [""] if any(not {*words} & {*each} for each in ends) else []
            texts[fact] = [*blank, *words]
    if not all(re.fullmatch(pattern, name) for name in names):
        return None
    return NameParts(pattern, texts, expression=True)


def _whole(
    names: Sequence[str], wanted: Sequence[str], vocabulary: LabVocabulary
) -> NameParts | None:
    """Take what differs between names, from its first word to its last, for one fact."""
    split = [_PART.split(name) for name in names]
    start = _same(split)
    left = min(map(len, split)) - start - 1  # at least a word has to differ
    end = min(_same([parts[::-1] for parts in split]), max(left, 0))
    before, after = split[0][:start], split[0][len(split[0]) - end :]
    texts = ["".join(parts[start : len(parts) - end]) for parts in split]
    if not all(texts):
        before, after, texts = [], [], list(names)
    when = {vocabulary.timepoint(text) for text in texts}
    fact = "condition" if "condition" in wanted else wanted[0]
    if "timepoint" in wanted and None not in when and len(when) == len({*texts}):
        fact = "timepoint"
    template = f"{''.join(before)}{{{fact}}}{''.join(after)}"
    return NameParts(template, {fact: list(dict.fromkeys(texts))})


def _same(split: Sequence[Sequence[str]]) -> int:
    """Return how many parts at the start are the same in all names."""
    return sum(1 for _ in takewhile(lambda p: len({*p}) == 1, zip(*split, strict=False)))


def _made(columns: Sequence[Sequence[str]], roles: dict[int, str]) -> NameParts | None:
    if not roles:
        return None
    parts = [
        f"{{{roles[i]}}}" if i in roles else column[0] if len(set(column)) == 1 else "{*}"
        for i, column in enumerate(columns)
    ]
    texts = {fact: list(dict.fromkeys(columns[i])) for i, fact in roles.items()}
    return NameParts("".join(parts), texts)


def names_with_folders(files: Sequence[Path]) -> list[str]:
    """Return the names of files without their endings, with the folders where these differ."""
    names = [file.name.removesuffix(file.suffix) for file in files]
    parents = [file.parent.parts for file in files]
    if len({*parents}) < 2:
        return names
    shared = _same(parents)
    return ["/".join((*folders[shared:], n)) for folders, n in zip(parents, names, strict=True)]


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
