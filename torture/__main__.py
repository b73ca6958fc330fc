"""Torture sessions and readers of files; print a table, and exit 1 if anything was lost.

Writes ``torture.json`` and ``torture.md``. The part with an OpenXR runtime needs one:
`scripts/in_runtime.sh python -m torture --only runtime`.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from torture import (
    commands,
    damaged,
    disk_full,
    inputs,
    meanwhile,
    power_cut,
    resumed,
    runtime,
    scenes,
    signals,
    table,
    tampered,
    texts,
)
from torture.case import Result, Rig
from torture.session import kill_all
from vrcomfort.errors import InputError
from vrcomfort.gpu.gl import create_context, describe
from vrcomfort.headset.monado import SERVICE

_NAMESPACE = "VRCOMFORT_TORTURE_NAMESPACE"

TORTURES: dict[str, Callable[[Rig], Result]] = {
    "signals": signals.torture,
    "power_cut": power_cut.torture,
    "disk_full": disk_full.torture,
    "resumed": resumed.torture,
    "meanwhile": meanwhile.torture,
    "tampered": tampered.torture,
    "damaged": damaged.torture,
    "inputs": inputs.torture,
    "commands": commands.torture,
    "texts": texts.torture,
    "scenes": scenes.torture,
    "runtime": runtime.torture,
}


def main() -> None:
    """Read the command line, run, and tell."""
    parser = argparse.ArgumentParser(prog="python -m torture", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/torture"), help="folder to write to")
    parser.add_argument("--short", action="store_true", help="few cases: less than 3 minutes")
    parser.add_argument("--patient", action="store_true", help="all cases, however long it takes")
    parser.add_argument("--seed", type=int, default=0, help="of all cases")
    parser.add_argument("--only", choices=sorted(TORTURES), nargs="+", help="run these")
    arguments = parser.parse_args()
    _prepare()
    shutil.rmtree(arguments.out / "cases", ignore_errors=True)
    cases = (arguments.out / "cases").resolve()
    rig = Rig(cases, arguments.seed, arguments.short, arguments.patient)
    results = []
    for name in arguments.only or _possible():
        results.append(TORTURES[name](rig))
        said = [f"{name}: {results[-1].row()}", *table.faults(results[-1:])]
        print(*said, sep="\n", file=sys.stderr, flush=True)
    tell(arguments.out, results)
    sys.exit(0 if all(result.passed for result in results) else 1)


def _possible() -> list[str]:
    if shutil.which(SERVICE):
        return list(TORTURES)
    print("left out: runtime; run it through scripts/in_runtime.sh", file=sys.stderr)
    return [name for name in TORTURES if name != "runtime"]


def tell(out: Path, results: Sequence[Result]) -> None:
    """Write the table, and print it with what went wrong."""
    words = ["python -m torture", *sys.argv[1:]]
    print(table.write(out, results, command=" ".join(words), gpu=_gpu()))
    for line in table.faults(results):
        print(line)


def _gpu() -> str:
    try:
        return describe(create_context())["renderer"]
    except InputError:
        return "no OpenGL"


def _prepare() -> None:
    _in_own_namespace()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, kill_all)


def _in_own_namespace() -> None:
    """Begin again where root mounts what nobody else sees, and what goes with this program."""
    unshare = shutil.which("unshare")
    if os.geteuid() or unshare is None or _NAMESPACE in os.environ:
        return
    private = [unshare, "--mount", "--propagation", "private"]
    if subprocess.run([*private, "true"], capture_output=True, check=False).returncode == 0:
        again = [*private, sys.executable, "-m", "torture", *sys.argv[1:]]
        os.execve(unshare, again, {**os.environ, _NAMESPACE: "1"})  # noqa: S606 - found on PATH


if __name__ == "__main__":
    main()
