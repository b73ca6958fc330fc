"""Ways of doing the same, each measured in a program of its own: time and memory are its alone."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from bench.table import Result

_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def in_a_program(module: str, *words: object, one_thread: bool = False) -> dict[str, Any]:
    """Run ``python -m module --once …`` and return what it prints as JSON.

    Parameters
    ----------
    one_thread
        Whether linear algebra may use one thread alone.
    """
    command = [sys.executable, "-m", module, "--once", *map(str, words)]
    env = {**os.environ, **_ONE_THREAD} if one_thread else None
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def main_of_ways(
    module: str,
    description: str | None,
    file: str,
    ways: Sequence[str],
    once: Callable[[str, Path], dict[str, Any]],
    measure: Callable[..., Result],
) -> None:
    """Read the command line of a benchmark of several ways; measure all, or one of a `file`."""
    parser = argparse.ArgumentParser(prog=f"python -m {module}", description=description)
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--once", choices=ways, help="one way alone, as JSON")
    parser.add_argument("--file", type=Path, help=f"its {file}")
    options = parser.parse_args()
    if options.once:
        print(json.dumps(once(options.once, options.file)))
        return
    for row in measure(options.rows, rounds=options.rounds).rows:
        cells = (f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items())
        print(", ".join(cells))
