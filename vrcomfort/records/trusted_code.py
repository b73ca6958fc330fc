"""Consents of this machine's user to run the Python files of protocols: a file for each hash."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.json_text import json_of
from vrcomfort.records.disk import OWNER, make_folders, refused, replace_text
from vrcomfort.records.study import now
from vrcomfort.tasks import TaskCode


def consents_folder() -> Path:
    """Return the folder of this user's consents; removing a file there withdraws one."""
    home = os.environ.get("APPDATA" if sys.platform == "win32" else "XDG_CONFIG_HOME")
    return (Path(home) if home else Path.home() / ".config") / "vrcomfort" / "trusted_code"


def is_trusted(code: TaskCode) -> bool:
    """Return whether this user has consented to these files, as they are."""
    return (consents_folder() / f"{code.sha256}.json").is_file()


def trust(code: TaskCode) -> None:
    """Keep this user's consent to run these files, as they are.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    folder = consents_folder()
    content = {"consented_at": now(), "folder": str(code.folder.resolve()), "files": code.hashes}
    try:
        make_folders(folder, folder, OWNER)
    except OSError as error:
        raise refused(folder, error) from error
    replace_text(folder / f"{code.sha256}.json", json_of(content) + "\n", OWNER)


def require_given_hash(code: TaskCode, given: str) -> None:
    """Check the hash given as consent.

    Raises
    ------
    InputError
        If it is none, or that of other files.
    """
    if not re.fullmatch("[0-9a-f]{64}", given):
        raise InputError(f"--trust {given[:80]!r} is not a hash of 64 digits, 0 to 9 and a to f")
    if not code.files:
        raise InputError("this protocol runs no Python files of its own; leave --trust out")
    if given != code.sha256:
        message = f"--trust {given} is the hash of other files: {', '.join(code.files)} have"
        raise InputError(f"{message} {code.sha256}; read them, they may have changed")
