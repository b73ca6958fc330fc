"""Words and sentence lengths of Markdown pages: `python scripts/prose.py PAGE...`."""

from __future__ import annotations

import re
import statistics
import sys
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

FENCED = re.compile(r"^( *)(`{3,}).*?^\1\2 *$", re.MULTILINE | re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
IMAGE = re.compile(r"!\[[^\]]*\]\([^)]*\)")
TARGET = re.compile(r"\]\([^)]*\)(\{[^}]*\})?")
CODE = re.compile(r"`[^`]+`")
ITEM = re.compile(r" *(?:[-*]|\d+\.) ")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|et al|vs|cf|Figs?|Eq|(?:pp?|no)(?=\. \d))\.")
LONGEST = 35
"""Words of a sentence, at most."""
END = re.compile(r"(?<=[.?!])[\"”’)*\]]*\s+(?=[\"“‘(*\[]*[A-Z0-9`§])")


@dataclass(frozen=True)
class Prose:
    """The paragraphs, list items and headings of a page, without tables and code."""

    headings: tuple[str, ...]
    sentences: tuple[str, ...]

    @property
    def words(self) -> int:
        """Number of words, those of headings among them."""
        return sum(map(count, (*self.headings, *self.sentences)))

    @property
    def lengths(self) -> list[int]:
        """Words of each sentence."""
        return [count(each) for each in self.sentences]


def count(text: str) -> int:
    """Return the number of words; a code span is one."""
    return sum(any(map(str.isalnum, word)) for word in text.split())


def prose_of(markdown: str) -> Prose:
    """Return what is read from top to bottom."""
    text = FENCED.sub("\n\n", COMMENT.sub("", markdown))
    text = TARGET.sub("]", IMAGE.sub("", text))
    text = CODE.sub("`code`", text)
    headings: list[str] = []
    sentences: list[str] = []
    for kind, lines in groupby(starts(text.splitlines()), key=lambda each: each[0]):
        if kind == "#":
            headings += [line.lstrip("# ") for _, line in lines]
        elif kind != "|":
            block = " ".join(line.strip() for _, line in lines)
            parts = END.split(
                ABBREVIATION.sub(lambda found: found[1].replace(".", "") + ",", block)
            )
            sentences += [part for part in parts if count(part)]
    return Prose(tuple(headings), tuple(sentences))


def starts(lines: list[str]) -> list[tuple[str | int, str]]:
    """Return each line with its block: a number, `#` for headings, `|` for tables."""
    marked: list[tuple[str | int, str]] = []
    block = 0
    for line in lines:
        if line.lstrip().startswith("|"):
            marked.append(("|", line))
        elif line.startswith("#"):
            marked.append(("#", line))
        else:
            item = ITEM.match(line)
            if not line.strip() or item or (marked and marked[-1][0] in ("#", "|")):
                block += 1
            marked.append((block, line[item.end() :] if item else line.lstrip("> ")))
    return marked


def main() -> None:
    """Print the figures of pages, and sentences that are too long."""
    total, lengths = 0, []
    for file in map(Path, sys.argv[1:]):
        prose = prose_of(file.read_text("utf-8"))
        own = prose.lengths or [0]
        total, lengths = total + prose.words, lengths + own
        long = sum(each > LONGEST for each in own)
        for each in prose.sentences:
            if count(each) > LONGEST:
                print("   ", each)
        print(f"{file.name:28} {prose.words:6} {statistics.median(own):5} {max(own):4} {long:4}")
    too_long = sum(each > LONGEST for each in lengths)
    print(f"{total} words, median {statistics.median(lengths)}, {too_long} over {LONGEST}")


if __name__ == "__main__":
    main()
