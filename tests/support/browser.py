"""A browser without a screen: what a page has become in it, and what the browser says of it."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.support.places import ROOT
from tests.support.waiting import SESSION_S, WAIT_S

OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage")
"""Of a browser in a container, which may have little shared memory: its pages would crash."""
SCRIPT = ROOT / "scripts" / "browser.sh"


@dataclass(frozen=True)
class Opened:
    """A page after its events: the document as HTML, and the browser's console."""

    dom: str
    console: tuple[str, ...]

    @property
    def refused(self) -> tuple[str, ...]:
        """What the page's content security policy has kept from being loaded or run."""
        return tuple(line for line in self.console if "Content Security Policy" in line)


def find_browser() -> str | None:
    """Return the path of a browser; None where there is none (`make test` installs one)."""
    found = subprocess.run(
        [SCRIPT, "--find"], capture_output=True, text=True, check=False, timeout=SESSION_S
    )
    return found.stdout.strip() if found.returncode == 0 else None


def open_page(browser: str, page: Path) -> Opened:
    """Open a file; return what it is once it has loaded, and two seconds of its time later."""
    with TemporaryDirectory() as profile:
        run = subprocess.run(
            [browser, *OPTIONS, f"--user-data-dir={profile}",
             "--enable-logging=stderr", "--virtual-time-budget=2000", "--dump-dom", page.as_uri()],
            capture_output=True, text=True, check=True, timeout=WAIT_S,
        )  # fmt: skip
    return Opened(run.stdout, tuple(line for line in run.stderr.splitlines() if "CONSOLE" in line))
