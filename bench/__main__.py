"""Run the benchmarks and write one JSON file and one Markdown table for each."""

from __future__ import annotations

import argparse
from pathlib import Path

from bench import accuracy, effects
from bench.table import write
from vrcomfort.render.gl import create_context


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder to write to")
    parser.add_argument("--only", choices=["effects", "accuracy"], help="run one of the two")
    parser.add_argument("--samples", type=int, default=1024, help="of each reference")
    parser.add_argument("--rounds", type=int, default=12, help="timed stereo frames of each kind")
    arguments = parser.parse_args()
    ctx = create_context()
    if arguments.only != "accuracy":
        write(arguments.out, "effects", effects.measure(ctx, rounds=arguments.rounds))
    if arguments.only != "effects":
        write(arguments.out, "accuracy", accuracy.measure(ctx, samples=arguments.samples))


if __name__ == "__main__":
    main()
