"""Cost and error of each level of the setting `quality`; writes the shipped table.

``python -m bench.quality`` measures and puts the figures into ``analysis/measured/quality.toml``.
With ``--levels fast`` the figures of all other levels stay, and the file says when they were taken.
"""

from __future__ import annotations

import argparse
import datetime
from collections.abc import Iterator, Sequence
from typing import get_args

import moderngl
import numpy as np

from bench.effects import frame_seconds
from vrcomfort.gpu.gl import create_context
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.quality import write_figures
from vrcomfort.protocol.quality_levels import (
    Effects,
    MeasurementSource,
    Quality,
    QualityFigure,
    quality_table,
)
from vrcomfort.resources import data_folder
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.cases import Scope, cases
from vrcomfort.tradeoff.costs import of_effects, traffic_of
from vrcomfort.tradeoff.measure import measure as measure_errors
from vrcomfort.tradeoff.methods import FOCUS, LENS, SHUTTER, BlurMethod
from vrcomfort.tradeoff.results import means
from vrcomfort.tradeoff.store import Store, default_folder
from vrcomfort.tradeoff.walk import pairs

COST_SIZE_PX = (320, 400)
SLOW_ROUNDS = 2
"""Timed frames of levels that draw the scene from many points of the lens."""

PLAIN = Condition(name="plain")


def condition_of(effects: Effects, level: Quality) -> Condition:
    """Return the condition that is measured for a level."""
    return Condition.model_validate(
        {
            "name": f"{effects}-{level}",
            "quality": level,
            "focus": FOCUS,
            "depth_of_field": None if effects == "motion_blur" else LENS,
            "motion_blur": None if effects == "depth_of_field" else SHUTTER,
        }
    )


def measure(
    ctx: moderngl.Context, *, scope: Scope, rounds: int, levels: Sequence[Quality]
) -> Iterator[QualityFigure]:
    """Yield the figures of these levels, of every effect and scene."""
    errors = _errors(scope, levels)
    kinds = [(effects, level) for effects in get_args(Effects) for level in levels]
    for name in scope.scenes:
        scene = load_scene(name)
        conditions = {kind: condition_of(*kind) for kind in kinds}
        slow = [kind for kind, each in conditions.items() if _views(each) > 1]
        quick = [kind for kind in kinds if kind not in slow]
        ratios: dict[tuple[Effects, Quality], float] = {}
        for group, timed in ((quick, rounds), (slow, min(rounds, SLOW_ROUNDS))):
            drawn = [PLAIN, *(conditions[kind] for kind in group)]
            seconds = frame_seconds(ctx, scene, drawn, rounds=timed, size_px=COST_SIZE_PX)
            medians = np.median(seconds[:, 1:] / seconds[:, :1], axis=0)
            ratios |= dict(zip(group, medians.tolist(), strict=True))
        for (effects, level), ratio in ratios.items():
            found = errors[name, effects, level]
            reads = _reads(ctx, scene, conditions[effects, level])
            yield QualityFigure(
                level=level,
                effects=effects,
                scene=name,
                cost_ratio=round(ratio, 2),
                reads_per_pixel=round(reads, 1),
                psnr_db=round(found["psnr_db"], 1),
                flip=round(found["flip"], 4),
            )


def _views(condition: Condition) -> int:
    return condition.depth_of_field.views if condition.depth_of_field else 1


def _reads(ctx: moderngl.Context, scene: Scene, condition: Condition) -> float:
    """Return the effects' texture reads for each pixel of an eye, on the first step of the walk."""
    pair = next(iter(pairs(scene, COST_SIZE_PX, 2)))
    parts = traffic_of(ctx, scene, condition, pair, COST_SIZE_PX, count_reads=True, records=False)
    return (of_effects(parts).reads or 0) / (COST_SIZE_PX[0] * COST_SIZE_PX[1])


def _errors(
    scope: Scope, levels: Sequence[Quality]
) -> dict[tuple[str, str, str], dict[str, float]]:
    """Return the errors, means over views, by scene, effects and level."""
    store = Store(default_folder())
    rows = [
        row
        for case in cases(scope)
        for row in measure_errors(case, scope, store, _methods(case.effect, levels)).rows
    ]
    return {(row["scene"], row["effect"], row["method"]): row for row in means(rows)}


def _methods(effects: Effects, levels: Sequence[Quality]) -> list[BlurMethod]:
    return [BlurMethod(level, effects, "ours", condition_of(effects, level)) for level in levels]


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m bench.quality", description=__doc__)
    parser.add_argument("--samples", type=int, default=1024, help="of each reference")
    parser.add_argument("--rounds", type=int, default=12, help="timed stereo frames of each level")
    known = get_args(Quality)
    parser.add_argument("--levels", nargs="+", choices=known, default=known, help="only these")
    options = parser.parse_args()
    table = quality_table()
    others = [each for each in table.figures if each.level not in options.levels]
    earlier, only = "", ""
    if others and table.measured:
        only = f" --levels {' '.join(options.levels)}"
        earlier = f". Other levels: {table.measured.command}, {table.measured.date}"
        if table.measured.command.endswith(only):  # the same once more
            earlier = "".join(table.measured.how.partition(". Other levels")[1:])
    ctx = create_context()
    scope = Scope(motions=("walk",), samples=options.samples)
    cost, error = ("×".join(map(str, size)) for size in (COST_SIZE_PX, scope.size_px))
    measured = MeasurementSource(
        command=f"python -m bench.quality --samples {options.samples} --rounds {options.rounds}"
        + only,
        device=str(ctx.info["GL_RENDERER"]),
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        how=f"cost (of processor time on a software rasteriser) and texture reads at {cost} per "
        f"eye, error at {error}; lens: law {LENS['law']}, "
        f"r_max {LENS['max_radius_percent']:g} % at {LENS['full_blur_dioptre']:g} D; shutter: "
        f"fully open, mode {SHUTTER['mode']}; references of {options.samples} samples "
        "(a quarter for motion blur alone)" + earlier,
    )
    figures = list(measure(ctx, scope=scope, rounds=options.rounds, levels=options.levels))
    file = data_folder("analysis") / "measured" / "quality.toml"
    write_figures(file, measured, [*figures, *others])
    for figure in figures:
        print(figure)


if __name__ == "__main__":
    main()
