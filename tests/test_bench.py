"""`make bench` starts: its cases are settings that protocols may have."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def test_the_benchmarks_and_their_cases_are_made():
    shown = subprocess.run(
        [sys.executable, "-W", "error", "-m", "bench", "--help"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert shown.returncode == 0, shown.stderr
    assert "requires" in shown.stdout
