"""Cost of searching the focus, and error of a small zone against a fine one.

Hillaire et al. 2008, Table 1: frame rates without blur and with it, by zone ratio, by where the
zone is averaged, and by resolution. Beside them stand a focus that is never searched for (the rest
is the blur) and the nine rays, and a figure that the paper does not give: how far the focus is, in
dioptres, from that of a zone drawn with `REFERENCE_SIDE_PX` pixels a side.
"""

from __future__ import annotations

import csv
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, Literal

import moderngl
import numpy as np

from vrcomfort.frame import FocusSample, Frame
from vrcomfort.geometry import Array
from vrcomfort.gpu.gl import describe, is_software
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.conditions import Condition, Focus
from vrcomfort.render.focus.rules import RULES
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import pairs, time_s

SIZES_PX = ((800, 600), (1024, 768), (1280, 1024))
"""Those of the paper's table, of each eye here."""
ZONE_RATIOS = (0.25, 0.5)
ZONE_SIDES_PX = (16, 32, 64, 128)
REFERENCE_SIDE_PX = 1024
ROUNDS, QUICK_ROUNDS = 5, 2
PLACES, QUICK_PLACES = 24, 4
"""Places on a walk where focus is looked for."""

Where = Literal["gpu", "cpu"]


@dataclass(frozen=True)
class SearchCost:
    """A row of the paper's table: medians over rounds."""

    scene: str
    width_px: int
    height_px: int
    search: str
    zone_ratio: float | None
    zone_mean_on: Where | None
    cost: float
    """Frame ÷ plain frames before and after it; of plain frames, ÷ their median."""
    cost_p5: float
    cost_p95: float
    frame_ms: float
    frames_per_s: float


@dataclass(frozen=True)
class ZoneError:
    """How far focus is from that of a fine zone: |1/d − 1/d_fine| over places of the walk."""

    scene: str
    zone_ratio: float
    zone_side_px: int
    median_dioptre: float
    p95_dioptre: float
    largest_dioptre: float
    places: int


@dataclass(frozen=True)
class FocusMethod:
    """A way to find the focus; None as `focus` is no blur at all."""

    name: str
    focus: Focus | None


def searches() -> list[FocusMethod]:
    """Return the compared focus methods; the first has no blur, the second no search."""
    zone = _hillaire().focus
    zones = [
        FocusMethod("autofocus_zone", _with(zone, zone_ratio=ratio, zone_mean_on=where))
        for ratio, where in product(ZONE_RATIOS, ("cpu", "gpu"))
    ]
    rules = [
        FocusMethod(name, _with(zone, method=name))
        for name, rule in RULES.items()
        if name not in {"autofocus_zone", "gaze"} and rule.plan(zone).needed
    ]
    fixed = FocusMethod("fixed", Focus(method="fixed", fixed_m=1.5))
    return [FocusMethod("no blur", None), fixed, *zones, *rules]


def search_costs(
    scene: str, size_px: tuple[int, int], rounds: int, advance: Callable[[], None]
) -> list[SearchCost]:
    """Time whole stereo frames with every search, in turn with plain frames.

    A processor's time on a software rasteriser; elsewhere the clock's, until the GPU is done, for a
    CPU that waits costs no time of the GPU.
    """
    (_, frame), *_ = pairs(scene_and_hash(scene)[0], size_px, 1)
    plain, *others = searches()
    draw_plain = _Frames(scene, size_px, plain)
    draw_plain.seconds(frame)
    plains, rows = [], []
    for search in others:
        timed, around = _Frames(scene, size_px, search), []
        timed.seconds(frame)
        seconds = []
        for _ in range(rounds):
            around.append(draw_plain.seconds(frame))
            seconds.append(timed.seconds(frame))
        around.append(draw_plain.seconds(frame))
        timed.release()
        plains += around
        between = (np.array(around)[1:] + np.array(around)[:-1]) / 2
        rows.append(_row(scene, size_px, search, np.array(seconds), between))
        advance()
    draw_plain.release()
    once = np.array(plains)
    return [_row(scene, size_px, plain, once, np.full_like(once, np.median(once))), *rows]


def zone_errors(scene: str, places: int, advance: Callable[[], None]) -> list[ZoneError]:
    """Compare the focus of small zones with that of a fine one, at places on the scene's walk."""
    frames = [frame for _, frame in pairs(scene_and_hash(scene)[0], (32, 32), places)]
    rows = []
    for ratio in ZONE_RATIOS:
        fine = _dioptres(scene, ratio, REFERENCE_SIDE_PX, frames)
        for side in ZONE_SIDES_PX:
            off = np.abs(_dioptres(scene, ratio, side, frames) - fine)
            p95 = np.percentile(off, 95, method="inverted_cdf")
            found = float(np.median(off)), float(p95), float(off.max())
            rows.append(ZoneError(scene, ratio, side, *found, len(frames)))
        advance()
    return rows


class _Frames:
    """Draws a frame with a search, again and again."""

    def __init__(self, scene: str, size_px: tuple[int, int], search: FocusMethod) -> None:
        self._ctx = context()
        self._renderer = StereoRenderer(self._ctx, size_px)
        self._renderer.begin(scene_and_hash(scene)[0], _condition(search))

    def seconds(self, frame: Frame) -> float:
        """Draw it, wait for it, and return how long that took."""
        clock = time.process_time if is_software(self._ctx) else time.perf_counter
        self._ctx.finish()
        start_s = clock()
        self._renderer.render(frame, time_s(frame))
        self._ctx.finish()
        return clock() - start_s

    def release(self) -> None:
        """Release the renderer's objects on the GPU."""
        self._renderer.release()


def _dioptres(scene: str, ratio: float, side_px: int, frames: Sequence[Frame]) -> Array:
    """Return 1 / target at each frame: of the rule alone, for every frame is a cut."""
    zone = _with(_hillaire().focus, zone_ratio=ratio, zone_size_px=(side_px, side_px))
    renderer = StereoRenderer(context(), (32, 32))
    renderer.begin(scene_and_hash(scene)[0], _condition(FocusMethod("autofocus_zone", zone)))
    samples: list[FocusSample] = []
    for index, frame in enumerate(frames):
        cut = replace(frame, index=index, discontinuity=True)
        samples += renderer.render(cut, time_s(frame)).focus_samples
    samples += renderer.drain()
    renderer.release()
    return 1 / np.array([each.focus_raw_m for each in samples])


def _condition(search: FocusMethod) -> Condition:
    if search.focus is None:
        return Condition(name="plain")
    blurred = _hillaire().depth_of_field
    return Condition(name="searched", focus=search.focus, depth_of_field=blurred)


@cache
def _hillaire() -> Condition:
    """Return the shipped condition with the paper's focus and blur."""
    shipped = load_protocol("hillaire_2008").conditions
    return next(each for each in shipped if each.focus.method == "autofocus_zone")


def _with(focus: Focus, **settings: Any) -> Focus:
    return focus.model_copy(update=settings)


def _row(
    scene: str, size_px: tuple[int, int], search: FocusMethod, seconds: Array, plain_s: Array
) -> SearchCost:
    zone = search.focus if search.name == "autofocus_zone" else None
    frame_s = float(np.median(seconds))
    p5, cost, p95 = map(float, np.percentile(seconds / plain_s, [5, 50, 95]))
    ratio, where = (zone.zone_ratio, zone.zone_mean_on) if zone else (None, None)
    return SearchCost(
        scene, *size_px, search.name, ratio, where, cost, p5, p95, frame_s * 1e3, 1 / frame_s
    )


def write(
    out: Path, costs: Sequence[SearchCost], errors: Sequence[ZoneError], ctx: moderngl.Context
) -> Path:
    """Write focus_costs.csv, focus_errors.csv and focus.md into `out`; return the last."""
    out.mkdir(parents=True, exist_ok=True)
    _write_csv(out / "focus_costs.csv", [asdict(row) for row in costs])
    _write_csv(out / "focus_errors.csv", [asdict(row) for row in errors])
    clock = "processor time" if is_software(ctx) else "time until the GPU is done"
    heading = f"Device: {describe(ctx)['renderer']}. Frames of both eyes; {clock}.\n"
    text = "\n".join(["# Searching for the focus", "", heading, *_tables(costs, errors), ""])
    (out / "focus.md").write_text(text, encoding="utf-8")
    return out / "focus.md"


def _write_csv(path: Path, rows: Sequence[dict[str, Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _tables(costs: Sequence[SearchCost], errors: Sequence[ZoneError]) -> list[str]:
    lines = [
        "| scene | each eye, px | search | zone ratio | averaged by "
        "| cost | 5–95 % | ms | frames/s |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for c in costs:
        ratio = "" if c.zone_ratio is None else f"{c.zone_ratio:g}"
        where = "" if c.zone_mean_on is None else c.zone_mean_on.upper()
        lines.append(
            f"| {c.scene} | {c.width_px}×{c.height_px} | {c.search} | {ratio} | {where} "
            f"| {c.cost:.2f} | {c.cost_p5:.2f}–{c.cost_p95:.2f} "
            f"| {c.frame_ms:.1f} | {c.frames_per_s:.1f} |"
        )
    lines += [
        "",
        f"Distance from the focus of a zone of {REFERENCE_SIDE_PX}×{REFERENCE_SIDE_PX} px:",
        "",
        "| scene | zone ratio | zone, px | median, D | 95 %, D | largest, D | places |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {e.scene} | {e.zone_ratio:g} | {e.zone_side_px}×{e.zone_side_px} "
        f"| {e.median_dioptre:.4f} | {e.p95_dioptre:.4f} | {e.largest_dioptre:.4f} | {e.places} |"
        for e in errors
    ]
    return lines
