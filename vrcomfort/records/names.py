"""Names of participants and studies: which can be names of folders, and their order."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

from vrcomfort.csv_table import whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.file_names import is_reserved, same_file

_NUMBER = re.compile(r"(\d+)")


def check_participant(name: str) -> None:
    """Raise `InputError` if a participant's name cannot be part of a file name."""
    if not re.fullmatch(r"[A-Za-z0-9]{1,64}", name):
        raise InputError(f"participant `{name}`: use 1 to 64 letters and digits only")
    if is_reserved(name):
        message = f"participant `{name}`: Windows keeps this name for a device"
        raise InputError(f"{message}; choose another, such as {name}01")


def check_study(name: str) -> None:
    """Raise `InputError` if a study's folder could not be copied to Windows."""
    if is_reserved(name):
        raise InputError(f"study `{name}`: Windows keeps this name for a device; choose another")
    if name.endswith((".", " ")):
        message = f"study `{name}`: Windows takes no name that ends in a point or a space"
        raise InputError(f"{message}; choose another")


def check_case(name: str, others: Iterable[str]) -> None:
    """Raise `InputError` if a name differs from another in capital letters alone.

    Their folders would be one on Windows and macOS.
    """
    for other in others:
        if other != name and same_file(other, name):
            message = f"participant `{name}` differs only in case from the enrolled `{other}`"
            raise InputError(f"{message}; write {other}, or choose another name")


@lru_cache(maxsize=65536)
def natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """Return a sorting key in which runs of digits count as numbers: P2 before P10."""
    parts = _NUMBER.split(text)
    numbers = ((part, whole_or_none(part)) for part in parts if part)
    keys = ((1, 0, part) if number is None else (0, number, "") for part, number in numbers)
    return (*keys, (-1, 0, text))  # P9 and P09 have an order too, the same each time
