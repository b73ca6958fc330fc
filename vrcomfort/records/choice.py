"""Which sessions of a study a report or a copy takes: those left out, and faults accepted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vrcomfort.errors import InputError

_SESSION = re.compile(r"(?:sub-)?([A-Za-z0-9]{1,64})/ses-([1-9][0-9]{0,8})")


class SessionName(NamedTuple):
    """A participant's session, written ``P07/ses-2``."""

    participant: str
    number: int

    def __str__(self) -> str:
        """Return it as it is written."""
        return f"{self.participant}/ses-{self.number}"

    def folder(self, study: Path) -> Path:
        """Return its folder."""
        return study / f"sub-{self.participant}" / f"ses-{self.number}"


def session_name(text: str) -> SessionName:
    """Return the session that a text names.

    Raises
    ------
    InputError
        If it names none.
    """
    found = _SESSION.fullmatch(text)
    if found is None:
        message = f"{text[:80]!r} names no session; write participant and session as P07/ses-2"
        raise InputError(message)
    return SessionName(found[1], int(found[2]))


@dataclass(frozen=True)
class Choice:
    """The sessions that are taken.

    Parameters
    ----------
    without
        Left out, whatever is in them.
    accept_flagged
        Take the study though `vrcomfort verify` finds something wrong.
    """

    without: frozenset[SessionName] = frozenset()
    accept_flagged: bool = False

    @classmethod
    def of_texts(cls, without: Iterable[str] | None, *, accept_flagged: bool = False) -> Choice:
        """Return the choice that a command's options make.

        Raises
        ------
        InputError
            If a text names no session.
        """
        return cls(frozenset(map(session_name, without or ())), accept_flagged)

    def require_there(self, study: Path) -> None:
        """Raise `InputError` where a session that is to be left out is not in the study."""
        for each in sorted(self.without):
            if not each.folder(study).is_dir():
                raise InputError(f"--without {each}: the study has no such session", file=study)

    def sentences(self, flagged: Sequence[str]) -> list[str]:
        """Return the sentences for the record; `flagged` are the accepted faults."""
        left = ", ".join(str(each) for each in sorted(self.without))
        said = [f"left out on request: {left}"] if left else []
        return said + [f"accepted as it is: {each}" for each in flagged]


EVERYTHING = Choice()
