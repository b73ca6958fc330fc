"""The experimenter's keyboard: keys and their meanings, and lines typed meanwhile."""

from __future__ import annotations

import sys

BACK = "b"
DECLINE = "-"
STOP = "q"
YES = "y"
NO = "n"

HELP = f"{DECLINE} = rather not say, {BACK} = back, {STOP} = withdraw"
SURE = f"Stop the study for this participant? {YES} = yes, {NO} = no, continue"


def waiting_line() -> str | None:
    """Return a line that has been typed, or None at once if there is none.

    On Windows single keys count as lines, because the console has no ready lines to ask for.
    """
    if sys.platform == "win32":
        import msvcrt  # noqa: PLC0415 - exists on Windows only

        return msvcrt.getwch() if msvcrt.kbhit() else None
    import select  # noqa: PLC0415 - works on files on other systems only

    try:
        ready, _, _ = select.select([sys.stdin], [], [], 0)
    except (OSError, ValueError):  # no standard input, or one that cannot be waited for
        return None
    return (sys.stdin.readline() or None) if ready else None


def input_over() -> bool:
    """Return whether no line can come any more: a file or pipe that has been read to its end."""
    if sys.platform == "win32":
        return False
    import select  # noqa: PLC0415 - works on files on other systems only

    try:
        ready, _, _ = select.select([sys.stdin], [], [], 0)
        return bool(ready) and not sys.stdin.buffer.peek(1)  # type: ignore[union-attr]
    except (OSError, ValueError):
        return False
