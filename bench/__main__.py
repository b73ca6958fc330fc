"""Run the benchmarks and write one JSON file and one Markdown table for each."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import moderngl

from bench import (
    effects,
    fitted,
    gaze_hits,
    image_hash,
    many_answers,
    mask,
    memory,
    python_time,
    ratings,
    recordings,
    requires,
    resolve,
    simulated,
    smaller,
    unseen,
    unseen_motion,
)
from bench.table import Result, write
from vrcomfort.gpu.gl import create_context
from vrcomfort.headset.monado import SERVICE
from vrcomfort.tradeoff.walk import SCENES

NEED_RUNTIME = ("openxr", "memory_openxr")
"""Left out of a run of all where there is no Monado; `scripts/in_runtime.sh` brings one."""


def _openxr() -> Any:
    return import_module("bench.openxr")


BENCHMARKS: dict[str, Callable[[moderngl.Context, argparse.Namespace], Result]] = {
    "fitted": lambda _, options: fitted.measure(scene=options.scene),
    "effects": lambda ctx, options: effects.measure(ctx, rounds=options.rounds),
    "requires": lambda ctx, options: requires.measure(ctx, rounds=options.rounds),
    "python_time": lambda _, options: python_time.measure(
        frames=options.frames,
        against=options.against,
        folder=options.out,
        scenes=[options.scene] if options.scene else SCENES,
    ),
    "openxr": lambda ctx, options: _openxr().measure(ctx, frames=options.frames),
    "memory": lambda ctx, options: memory.measure(ctx, frames=options.memory_frames),
    "memory_openxr": lambda ctx, options: _openxr().measure_memory(
        ctx, frames=options.memory_frames // 50
    ),
    "answers": lambda _, options: many_answers.measure(options.people),
    "ratings": lambda _, options: ratings.measure(options.rating_rows),
    "recordings": lambda _, options: recordings.measure(options.frame_rows),
    "gaze_hits": lambda ctx, options: gaze_hits.measure(ctx, rounds=options.rounds),
    "image_hash": lambda ctx, options: image_hash.measure(ctx, rounds=options.rounds),
    "simulated": lambda _, options: simulated.measure(options.simulated),
    "mask": lambda ctx, options: mask.measure(ctx, rounds=options.rounds),
    "unseen": lambda _, options: unseen.measure(
        options.seeds, samples=options.views, still=options.still
    ),
    "resolve": lambda ctx, _: resolve.measure(ctx),
    "unseen_motion": lambda _, options: unseen_motion.measure(
        options.seeds, samples=options.views, rounds=options.rounds
    ),
    "smaller": lambda ctx, options: smaller.measure(ctx, rounds=options.rounds),
}


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder to write to")
    parser.add_argument("--only", choices=sorted(BENCHMARKS), help="run one of them")
    parser.add_argument("--rounds", type=int, default=12, help="timed stereo frames of each kind")
    parser.add_argument("--frames", type=int, default=300, help="frames for Python's own time")
    parser.add_argument("--against", help="a revision to compare python_time with, as 05fae2d")
    parser.add_argument("--scene", choices=SCENES, help="python_time in one scene alone")
    parser.add_argument("--memory-frames", type=int, default=100_000, help="for memory's growth")
    parser.add_argument("--people", type=int, default=1000, help="whose answers are reported")
    parser.add_argument("--frame-rows", type=int, default=10_000_000, help="summed by exposure")
    parser.add_argument("--rating-rows", type=int, default=10_000_000, help="read and summed up")
    parser.add_argument("--simulated", type=int, default=200, help="people without frames")
    parser.add_argument("--seeds", type=int, nargs="+", default=[], help="of unseen scenes")
    parser.add_argument("--views", type=int, default=512, help="of their references")
    parser.add_argument("--still", action="store_true", help="no flicker, no rivalry in unseen")
    arguments = parser.parse_args()
    ctx = create_context()
    for name in [arguments.only] if arguments.only else _possible():
        write(arguments.out, name, BENCHMARKS[name](ctx, arguments))


def _possible() -> list[str]:
    if shutil.which(SERVICE):
        return list(BENCHMARKS)
    print(f"left out: {', '.join(NEED_RUNTIME)}; run through scripts/in_runtime.sh for them")
    return [name for name in BENCHMARKS if name not in NEED_RUNTIME]


if __name__ == "__main__":
    main()
