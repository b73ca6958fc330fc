"""What each level of the setting `quality` costs and gets wrong; writes the shipped table.

``python -m bench.quality`` measures and puts the figures into ``analysis/measured/quality.toml``.
"""

from __future__ import annotations

import argparse
import datetime
import math
from collections.abc import Iterator
from typing import get_args

import moderngl
import numpy as np

from bench.accuracy import FOCUS_M, LENS, SHUTTER, VIEWS, Pixels64, Shot, errors, shoot
from bench.accuracy import SIZE_PX as ERROR_SIZE_PX
from bench.effects import frame_seconds
from bench.walk import REFRESH_HZ, SCENES, pairs
from vrcomfort.protocol.conditions import Condition, Focus
from vrcomfort.protocol.quality import Effects, Figure, Measured, Quality, write_figures
from vrcomfort.render.gl import create_context
from vrcomfort.render.gltf import load_scene
from vrcomfort.render.reference import Reference
from vrcomfort.render.scene_data import Scene
from vrcomfort.resources import data_folder

COST_SIZE_PX = (320, 400)
PLAIN = Condition(name="plain")


def condition_of(effects: Effects, level: Quality) -> Condition:
    """Return the condition that is measured for a level."""
    lens = LENS.model_dump(exclude_unset=True)
    shutter = SHUTTER.model_dump(exclude_unset=True)
    return Condition.model_validate(
        {
            "name": f"{effects}-{level}",
            "quality": level,
            "focus": Focus(method="fixed", fixed_m=FOCUS_M),
            "depth_of_field": None if effects == "motion_blur" else lens,
            "motion_blur": None if effects == "depth_of_field" else shutter,
        }
    )


def measure(ctx: moderngl.Context, *, samples: int, rounds: int) -> Iterator[Figure]:
    """Yield the figures of every level, effect and scene."""
    cases = [(effects, level) for effects in get_args(Effects) for level in get_args(Quality)]
    for name in SCENES:
        scene = load_scene(name)
        conditions = [condition_of(*case) for case in cases]
        seconds = frame_seconds(
            ctx, scene, [PLAIN, *conditions], rounds=rounds, size_px=COST_SIZE_PX
        )
        ratios = np.median(seconds[:, 1:] / seconds[:, :1], axis=0)
        truths = {effects: _truth(ctx, scene, effects, samples) for effects in get_args(Effects)}
        for (effects, level), condition, ratio in zip(cases, conditions, ratios, strict=True):
            psnr_db, flip = _error(ctx, scene, condition, truths[effects])
            yield Figure(
                level=level,
                effects=effects,
                scene=name,
                cost_ratio=round(float(ratio), 2),
                psnr_db=round(psnr_db, 1),
                flip=round(flip, 4),
            )


def _truth(
    ctx: moderngl.Context, scene: Scene, effects: Effects, samples: int
) -> list[tuple[Pixels64, Pixels64]]:
    """Return the halves of the reference for each view."""
    condition = condition_of(effects, "balanced")
    reference = Reference(ctx, scene, condition, ERROR_SIZE_PX, samples=samples)
    halves = []
    for before, frame in pairs(scene, ERROR_SIZE_PX, VIEWS):
        images = shoot(ctx, scene, condition, before, frame).images
        truth = reference.render(
            images.camera, frame.index / REFRESH_HZ, images.previous, focus_m=FOCUS_M
        )
        halves.append(truth.halves)
    return halves


def _error(
    ctx: moderngl.Context,
    scene: Scene,
    condition: Condition,
    truths: list[tuple[Pixels64, Pixels64]],
) -> tuple[float, float]:
    """Return PSNR in dB and mean FLIP over the views."""
    shots: list[Shot] = [
        shoot(ctx, scene, condition, *pair) for pair in pairs(scene, ERROR_SIZE_PX, VIEWS)
    ]
    found = [
        errors(scene, shot, shot.blurred, halves)
        for shot, halves in zip(shots, truths, strict=True)
    ]
    mean_square = float(np.mean([each.rms**2 for each in found]))
    return -10 * math.log10(mean_square), float(np.mean([each.flip for each in found]))


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(prog="python -m bench.quality", description=__doc__)
    parser.add_argument("--samples", type=int, default=1024, help="of each reference")
    parser.add_argument("--rounds", type=int, default=12, help="timed stereo frames of each level")
    options = parser.parse_args()
    ctx = create_context()
    cost, error = ("×".join(map(str, size)) for size in (COST_SIZE_PX, ERROR_SIZE_PX))
    measured = Measured(
        command=f"python -m bench.quality --samples {options.samples} --rounds {options.rounds}",
        device=str(ctx.info["GL_RENDERER"]),
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        how=f"cost at {cost} per eye, error at {error}; lens: law {LENS.law}, r_max "
        f"{LENS.max_radius_percent:g} % at {LENS.full_blur_dioptre:g} D; shutter: fully open, "
        f"mode {SHUTTER.mode}; reference of {options.samples} samples",
    )
    figures = list(measure(ctx, samples=options.samples, rounds=options.rounds))
    write_figures(data_folder("analysis") / "measured" / "quality.toml", measured, figures)
    for figure in figures:
        print(figure)


if __name__ == "__main__":
    main()
