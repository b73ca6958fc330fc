"""Run the benchmarks and write one JSON file and one Markdown table for each."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import moderngl

from bench import accuracy, effects, python_time, requires
from bench.table import Result, write
from vrcomfort.render.gl import create_context

BENCHMARKS: dict[str, Callable[[moderngl.Context, argparse.Namespace], Result]] = {
    "effects": lambda ctx, options: effects.measure(ctx, rounds=options.rounds),
    "requires": lambda ctx, options: requires.measure(ctx, rounds=options.rounds),
    "python_time": lambda ctx, options: python_time.measure(ctx, frames=options.frames),
    "openxr": lambda ctx, options: _openxr(ctx, options),
    "accuracy": lambda ctx, options: accuracy.measure(ctx, samples=options.samples),
}


def _openxr(ctx: moderngl.Context, options: argparse.Namespace) -> Result:
    from bench import openxr

    return openxr.measure(ctx, frames=options.frames)


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder to write to")
    parser.add_argument("--only", choices=sorted(BENCHMARKS), help="run one of them")
    parser.add_argument("--samples", type=int, default=2048, help="of each reference")
    parser.add_argument("--rounds", type=int, default=12, help="timed stereo frames of each kind")
    parser.add_argument("--frames", type=int, default=300, help="frames for Python's own time")
    arguments = parser.parse_args()
    ctx = create_context()
    for name in [arguments.only] if arguments.only else BENCHMARKS:
        write(arguments.out, name, BENCHMARKS[name](ctx, arguments))


if __name__ == "__main__":
    main()
