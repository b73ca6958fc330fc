"""Names that every operating system takes for a file or folder."""

from __future__ import annotations

import re
from collections.abc import Iterable

from vrcomfort.errors import InputError
from vrcomfort.file_names import is_reserved, same_file


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
            message = f"participant `{name}` differs from `{other}`, who is enrolled, only in case"
            raise InputError(f"{message}; write {other}, or choose another name")
