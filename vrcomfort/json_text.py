"""Reads JSON of files from elsewhere; faults are plain sentences with line and column."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from json.decoder import JSONDecoder
from pathlib import Path
from typing import Any, TypeAlias

from vrcomfort.errors import InputError
from vrcomfort.escaping import is_utf8

KeyPath: TypeAlias = tuple[str | int, ...]

MOST_MARKS = 2**22
"""Brackets, braces and commas of a JSON text: each value takes one, and some 100 bytes or more."""
MOST_NESTED = 100
"""Lists and objects in each other, of JSON and TOML: what walks through them calls itself."""

_SPACE = re.compile(r"[ \t\r\n]*")
_HALF = re.compile(r"\\u[dD][89a-fA-F]")
"""How half of a character is written; a text that was decoded has no other."""
_SURROGATE = re.compile("[\ud800-\udfff]")
_FAULTS = {
    "Expecting ',' delimiter": "a comma or a closing bracket is missing before this place",
    "Expecting ':' delimiter": "a colon is missing before this place",
    "Expecting property name": "a name in double quotes is needed here",
    "Expecting value": "a value is needed here; a text stands in double quotes",
    "Illegal trailing comma": "this comma is one too many",
    "Extra data": "the JSON is over before this place",
    "Unterminated string": "the text that begins here has no closing quote",
    "Invalid control character": "a text is not closed before the end of its line",
    "Invalid \\": "this backslash means nothing here; a backslash is written as two",
}
"""Beginning of what the parser says → what a reader needs to know."""


def json_of(content: Any, *, indent: int | None = 2) -> str:
    """Return the text of a JSON file, with lone surrogates escaped.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    return escape_surrogates(
        json.dumps(content, indent=indent, ensure_ascii=False, allow_nan=False)
    )


def escape_surrogates(text: str) -> str:
    r"""Return JSON with ``\\ud800`` in place of each lone surrogate, which UTF-8 does not have."""
    return _SURROGATE.sub(lambda found: f"\\\\u{ord(found[0]):04x}", text)


def parse_json(
    text: str,
    file: Path,
    *,
    what: str = "JSON",
    advice: str = "restore it",
    line: int = 1,
    most_marks: int = MOST_MARKS,
) -> Any:
    """Return the value of a JSON text.

    Parameters
    ----------
    what, advice
        The file in words, and what is to be done where it is damaged: "manifest", "restore it".
    line
        The line of the file in which the text begins, from 1.
    most_marks
        How many brackets, braces and commas it may have.

    Raises
    ------
    InputError
        If it is no JSON, is nested deeper than `MOST_NESTED`, has more than `most_marks`, or has a
        number or text that no program can hold.
    """

    def fault(said: str, at: tuple[int, int] | None = None) -> InputError:
        message = f"{said}: this {what} is damaged; {advice}"
        row, column = at or (None, None)
        return InputError(message, file=file, line=row and row + line - 1, column=column)

    require_few_values(text, file, what=what, most_marks=most_marks)
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise fault(_in_words(error), (error.lineno, error.colno)) from None
    except RecursionError:
        raise fault("it is nested too deep") from None
    except ValueError:  # a number of 5000 digits
        raise fault("a number is too long") from None
    if is_nested_deeper(content, MOST_NESTED):
        raise fault("it is nested too deep")
    if _HALF.search(text) and (found := next(_halves(content), None)):
        raise fault(found[1], place_of(text, found[0]))
    return content


def require_few_values(
    text: str, file: Path, *, what: str = "JSON", most_marks: int = MOST_MARKS, marks: str = "[{,"
) -> None:
    """Raise `InputError` if a text has more brackets, braces and commas; see `parse_json`."""
    if sum(map(text.count, marks)) > most_marks:
        message = f"this {what} has more than {most_marks:,} values; is it the right file?"
        raise InputError(message, file=file)


def is_nested_deeper(content: Any, most: int) -> bool:
    """Return whether more than `most` lists and objects stand in each other."""
    level = [content]
    for _ in range(most + 1):
        level = [
            each
            for holder in level
            if isinstance(holder, dict | list)
            for each in (holder.values() if isinstance(holder, dict) else holder)
            if isinstance(each, dict | list)
        ]
        if not level:
            return False
    return True


def _in_words(error: json.JSONDecodeError) -> str:
    if not error.doc.strip():
        return "there is nothing in it"
    if not error.doc[error.pos :].strip():
        return "it ends before it is whole"
    said = (words for start, words in _FAULTS.items() if error.msg.startswith(start))
    return next(said, "this is no JSON from here on")


def _halves(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, str]]:
    """Yield strings that UTF-8 cannot hold: half of a surrogate pair."""
    if isinstance(value, str) and not is_utf8(value):
        yield path, f"{name_of(path)} has half a character"
    elif isinstance(value, dict | list):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            if isinstance(key, str) and not is_utf8(key):
                yield path, "the name of a key has half a character"
            yield from _halves(each, (*path, key))


def name_of(path: KeyPath) -> str:
    """Return the name of a value in a sentence."""
    return f"`{'.'.join(map(str, path))}`" if path else "the whole"


def place_of(text: str, path: KeyPath) -> tuple[int, int]:
    """Return the 1-based line and column of a value of a valid JSON text."""
    try:
        at = _offset(text, path)
    except (IndexError, ValueError):  # a path that the text does not have
        at = 0
    before = text[:at]
    return before.count("\n") + 1, at - before.rfind("\n")


def _offset(text: str, path: KeyPath, at: int = 0) -> int:
    at = _after_space(text, at)
    if not path:
        return at
    at, index = _after_space(text, at + 1), 0
    while True:
        key: str | int = index
        if isinstance(path[0], str):
            key, at = JSONDecoder().raw_decode(text, at)
            at = _after_space(text, at) + 1
        if key == path[0]:
            return _offset(text, path[1:], at)
        _, at = JSONDecoder().raw_decode(text, _after_space(text, at))
        at, index = _after_space(text, _after_space(text, at) + 1), index + 1


def _after_space(text: str, at: int) -> int:
    found = _SPACE.match(text, at)
    return found.end() if found else at
