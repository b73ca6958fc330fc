"""Waiting for what another process or thread does, however slow the machine is."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

WAIT_S = 120.0
"""Guards against waiting for ever, and measures nothing: a busy machine takes long."""

SESSION_S = 600.0
"""The same for whole sessions, reports and scenes in a process of their own."""


def wait_for(wanted: Callable[[], Any], told: Callable[[], object] = lambda: "") -> Any:
    """Return what `wanted` returns as soon as that is something; `told` says why it is not."""
    deadline = time.monotonic() + WAIT_S
    while not (found := wanted()):
        assert time.monotonic() < deadline, f"it did not come: {told()}"
        time.sleep(0.02)
    return found


def read_until_closed(descriptor: int) -> bytes:
    """Return all that comes out of a pipe or a terminal until its other end is closed."""
    content = b""
    while chunk := _chunk(descriptor):
        content += chunk
    return content


def _chunk(descriptor: int) -> bytes:
    try:
        return os.read(descriptor, 4096)
    except OSError:  # so a terminal says that nobody is there any more
        return b""
