"""Scripts that install packages wait for others that do."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.places import ROOT

LOCKED = "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)"
CALL = f"""
source {ROOT}/scripts/apt.sh
as_root=()
sleep() {{ :; }}
env() {{
    echo called >>calls
    [ "$(wc -l <calls)" -gt "$BUSY" ] && return 0
    echo "$SAID"
    return 100
}}
apt_get install nothing
"""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="these scripts are for Linux")


def apt_get(folder: Path, busy: int, said: str) -> tuple[int, int, str]:
    """Return the exit code, how often apt-get was called, and what was told."""
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", CALL],
        cwd=folder, env={"PATH": "/usr/bin:/bin", "BUSY": str(busy), "SAID": said},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stdout == ""
    return done.returncode, len((folder / "calls").read_text().splitlines()), done.stderr


def test_an_installation_waits_for_another_and_says_so_once(tmp_path: Path) -> None:
    code, calls, told = apt_get(tmp_path, 3, LOCKED)
    assert (code, calls) == (0, 4)
    assert told == "Waiting for another package installation to end ...\n"


def test_an_installation_that_fails_otherwise_is_told_at_once(tmp_path: Path) -> None:
    said = "E: Unable to locate package nothing"
    assert apt_get(tmp_path, 3, said) == (1, 1, f"{said}\n")
