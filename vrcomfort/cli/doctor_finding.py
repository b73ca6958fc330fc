"""What `doctor` says of one thing."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One thing that was looked for.

    Parameters
    ----------
    needed
        Whether every use of vrcomfort needs it.
    details
        More of what was found, for programs.
    """

    part: str
    ok: bool
    found: str
    remedy: str = ""
    needed: bool = True
    details: tuple[str, ...] = ()
