"""A session that `vrcomfort run --console` runs in a process of its own."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.support.protocols import (
    ASKED_AFTER_EACH,
    ASKED_BEFORE,
    BLUR,
    PLAIN,
    explicit_order,
    protocol_text,
)
from tests.support.waiting import WAIT_S, wait_for

PROTOCOL = protocol_text(
    ASKED_BEFORE,
    ASKED_AFTER_EACH,
    '[[ratings]]\ninstrument = "fms"\nevery_s = 1.2\ntimeout_s = 1.1\n',
    name="aloud",
    exposure_s=4.0,
    scene="temple",
    keys="participants = 4\ntraining_s = 0.5\n",
    conditions=(PLAIN, BLUR.replace("blur", "dof")),
    order=explicit_order("temple", ab=[["plain", "dof"]]),
)

_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/\?token=\S+")


@dataclass
class RunningSession:
    """The command, and what it has printed so far."""

    process: subprocess.Popen[str]
    folder: Path
    lines: list[str] = field(default_factory=list)
    states: list[dict[str, Any]] = field(default_factory=list)
    """What a page was shown, where one has looked on."""
    pictures: list[bytes] = field(default_factory=list)
    reading: threading.Thread = field(init=False)

    def __post_init__(self) -> None:
        self.reading = threading.Thread(target=self._read, daemon=True)
        self.reading.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)

    @property
    def addresses(self) -> list[str]:
        return [found[0] for line in self.lines if (found := _ADDRESS.search(line))]

    @property
    def ses(self) -> Path:
        return self.folder / "study" / "sub-P01" / "ses-1"

    def next_address(self, number: int = 1) -> str:
        """Return the address for the operator who comes as the first, second, …"""
        wait_for(lambda: len(self.addresses) >= number or not self.reading.is_alive())
        assert len(self.addresses) >= number, "".join(self.lines)
        return self.addresses[number - 1]

    def ended(self) -> int:
        """Wait for the end, and for all that it has printed; return the exit code."""
        code = self.process.wait(WAIT_S)
        self.reading.join(WAIT_S)
        return code


@contextmanager
def running_session(
    folder: Path, *options: str, protocol: str = PROTOCOL
) -> Iterator[RunningSession]:
    """Run it; whatever happens, it is over afterwards."""
    file = folder / "aloud.toml"
    file.write_text(protocol, encoding="utf-8")
    words = ["run", str(file), "--participant", "P01", "--out", str(folder / "study")]
    command = "from vrcomfort.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command, *words, "--size", "64x80", "--console", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    found = RunningSession(process, folder)
    try:
        yield found
    finally:
        if process.poll() is None:
            process.kill()
        found.ended()
        if process.stdout is not None:
            process.stdout.close()
