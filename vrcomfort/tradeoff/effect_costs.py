"""Costs of the effects that have no ground truth to err from: all but the two blurs of a lens.

Each is drawn with the settings that its registration is measured with, at each level of `quality`
where levels know it, on a step of the scene's walk.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import get_args

import moderngl

from vrcomfort.errors import InputError
from vrcomfort.gpu.gl import describe, is_software
from vrcomfort.protocol.conditions import EFFECTS as REGISTERED
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.quality_levels import Quality, dialled
from vrcomfort.render.graph import EFFECTS, plan_effect
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.costs import time_alone, traffic_of_method
from vrcomfort.tradeoff.methods import EFFECTS as JUDGED
from vrcomfort.tradeoff.methods import FOCUS, BlurMethod
from vrcomfort.tradeoff.store import scene_and_hash

NAMES = tuple(name for name in REGISTERED if name not in JUDGED)
"""Of the effects that are measured here."""


@dataclass(frozen=True)
class EffectCost:
    """Cost of an effect in a scene: time beside plain frames, and traffic of one eye."""

    scene: str
    effect: str
    quality: str
    """Level of the dial, blank for an effect without one."""
    width_px: int
    height_px: int
    cost: float
    """1 + effect ÷ plain frame."""
    cost_p5: float
    cost_p95: float
    effect_ms: float
    passes: int
    draws: int
    bytes_per_pixel: float
    reads_per_pixel: float


def effect_costs(
    scope: Scope, names: Sequence[str], advance: Callable[[], None]
) -> list[EffectCost]:
    """Measure effects in the scenes of a scope.

    Raises
    ------
    InputError
        If an effect draws nothing with the settings that it is measured with.
    """
    return [
        _row(scene, condition, name, scope, advance)
        for scene in scope.scenes
        for name in names
        for condition in _conditions(name)
    ]


def steps(names: Sequence[str]) -> int:
    """Return how many rows there are in a scene."""
    return sum(len(_conditions(name)) for name in names)


def _conditions(name: str) -> list[Condition]:
    settings = {"name": name, "focus": FOCUS, name: dict(EFFECTS[name].measured)}
    if name not in dialled():
        return [Condition.model_validate(settings)]
    return [Condition.model_validate({**settings, "quality": each}) for each in get_args(Quality)]


def _row(
    scene: str, condition: Condition, name: str, scope: Scope, advance: Callable[[], None]
) -> EffectCost:
    planned = plan_effect(name, scene_and_hash(scene)[0], condition)
    if not planned.needed:
        message = f"{name} is not measured: {planned.reason}; register it with `measured` settings"
        raise InputError(message)
    method = BlurMethod(name, "both", "none", condition)
    case = Case(scene, 0, "walk", "both")
    time, traffic = time_alone(method, case, scope), traffic_of_method(method, case, scope)
    advance()
    return EffectCost(
        scene,
        name,
        condition.quality or "",
        *scope.size_px,
        time.cost,
        *time.cost_interval,
        time.effect_ms,
        **traffic,
    )


def write(out: Path, costs: Sequence[EffectCost], ctx: moderngl.Context) -> Path:
    """Write effects.csv and effects.md into `out`; return the last."""
    out.mkdir(parents=True, exist_ok=True)
    rows = [asdict(each) for each in costs]
    with (out / "effects.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    clock = "processor time" if is_software(ctx) else "time stamps of the GPU"
    lines = [
        "# What effects cost",
        "",
        f"Device: {describe(ctx)['renderer']}; {clock}. Cost: 1 + effect ÷ plain frame of both "
        "eyes. Passes, draws, bytes and texture reads are those of one eye.",
        "",
        "| scene | effect | quality | each eye, px | cost | 5–95 % | ms | passes | draws "
        "| bytes/px | reads/px |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
        *map(_line, costs),
        "",
    ]
    (out / "effects.md").write_text("\n".join(lines), encoding="utf-8")
    return out / "effects.md"


def _line(c: EffectCost) -> str:
    return (
        f"| {c.scene} | {c.effect} | {c.quality} | {c.width_px}×{c.height_px} | {c.cost:.2f} "
        f"| {c.cost_p5:.2f}–{c.cost_p95:.2f} | {c.effect_ms:.1f} | {c.passes} | {c.draws} "
        f"| {c.bytes_per_pixel:.1f} | {c.reads_per_pixel:.1f} |"
    )
