"""`passes`: the render passes of each condition, their cost, and the GPU memory."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from vrcomfort.cli.options import Json, ProtocolArgument, Quiet, Size, parse_size
from vrcomfort.cli.terminal import answer, console, progress_bar, warn
from vrcomfort.errors import InputError
from vrcomfort.protocol import Condition, Protocol, load_protocol
from vrcomfort.protocol.quality import figure_for, level_of
from vrcomfort.protocol.quality_levels import MeasurementSource, QualityFigure, quality_table

if TYPE_CHECKING:
    from collections.abc import Callable

    from vrcomfort.gpu.traffic import Traffic
    from vrcomfort.protocol.viewing import DepthMode
    from vrcomfort.render.effects.depth_of_field.lens_radius import Unlimited
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.render.planned_pass import PlannedPass
    from vrcomfort.scene.data import Scene

UNKNOWN = "?"
WHOLE = "whole frame"
ONCE = ("shadow", "focus", "gaze_hit")
"""Parts that are drawn once for both eyes."""
COLOUR_BYTES, DEPTH_BYTES = 4, 4
"""Of a pixel that the runtime gets."""
MOST_VIEWS = 4
"""Through the lens, of which a frame is drawn to count what it sends through memory."""


def register(app: typer.Typer) -> None:
    """Add the command, hidden also under its name of version 0.1."""
    app.command()(passes)
    app.command("plan", hidden=True)(plan)


def passes(
    protocol: ProtocolArgument,
    size: Size = "1832x1920",
    draw: Annotated[
        bool,
        typer.Option("--draw/--no-draw", help="Draw a frame of each, to count bytes and draws."),
    ] = True,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Show the render passes of each condition in each scene, with reasons and cost.

    Draws a frame of each, which without a GPU takes some seconds at --size. GPU memory is what is
    allocated here, for both eyes at --size. Cost and error are those shipped for the condition's
    settings, where they have been measured.

    - `vrcomfort passes carnegie_2015`
    - `vrcomfort passes my_study.toml --size 2064x2208 --json`
    """
    study = load_protocol(protocol)
    total = len(study.scenes) * len(study.conditions)
    bar = progress_bar("counted passes", total, quiet=quiet or as_json, unit="conditions in scenes")
    with bar as advance:
        found = study_passes(study, parse_size(size), draw=draw, advance=advance)
    if as_json:
        answer(found.as_data())
    else:
        show(found, study)


def plan(
    protocol: ProtocolArgument,
    size: Size = "1832x1920",
    draw: Annotated[bool, typer.Option("--draw/--no-draw")] = True,
    as_json: Json = False,
) -> None:
    """Run `vrcomfort passes`: its name in version 0.1."""
    warn("`vrcomfort plan` is now called `vrcomfort passes`; a plan is an analysis plan")
    passes(protocol, size, draw, as_json=as_json)


@dataclass(frozen=True)
class PlannedPasses:
    """One condition in one scene.

    Parameters
    ----------
    draws_effects
        Whether anything but the plain image is drawn.
    figure
        Shipped measurement of its settings, or None.
    megabytes
        GPU memory by kind, or None where there is no OpenGL.
    traffic
        What each part of a frame sends through memory, by name: parts of both eyes for one eye;
        None where no frame was drawn.
    """

    scene: str
    condition: str
    quality: str
    passes: list[PlannedPass]
    draws_effects: bool
    figure: QualityFigure | None
    megabytes: dict[str, float] | None
    traffic: dict[str, Traffic] | None


@dataclass(frozen=True)
class StudyPasses:
    """All conditions in all scenes.

    Parameters
    ----------
    no_opengl
        Why memory is not known.
    beyond
        By condition, where views show more blur than the limit on the radius.
    """

    size_px: tuple[int, int]
    rows: list[PlannedPasses]
    no_opengl: str | None
    beyond: dict[str, Unlimited]

    def as_data(self) -> dict[str, Any]:
        """Return passes, costs and the figures' source, for JSON."""
        names = [(row, {"scene": row.scene, "condition": row.condition}) for row in self.rows]
        measured = quality_table().measured
        return {
            "passes": [name | asdict(step) for row, name in names for step in row.passes],
            "costs": [name | self._cost(row) for row, name in names],
            "no_limit": [_beyond_as_data(name, beyond) for name, beyond in self.beyond.items()],
            "traffic": [
                name | {"part": part} | _traffic_as_data(part, found, self.size_px)
                for row, name in names
                for part, found in (row.traffic or {}).items()
            ],
            "measured": measured.model_dump() if measured else None,
        }

    def _cost(self, row: PlannedPasses) -> dict[str, Any]:
        figure = row.figure
        return {
            "quality": row.quality if row.draws_effects else None,
            "cost_ratio": figure.cost_ratio if figure else None if row.draws_effects else 1.0,
            "psnr_db": figure.psnr_db if figure else None,
            "flip": figure.flip if figure else None,
            "size_px": self.size_px,
            "gpu_megabytes": row.megabytes,
        }


def _beyond_as_data(condition: str, beyond: Unlimited) -> dict[str, Any]:
    ranges = [each._asdict() for each in beyond.ranges]
    return {"condition": condition, **beyond._asdict(), "ranges": ranges}


def _traffic_as_data(part: str, found: Traffic, size_px: tuple[int, int]) -> dict[str, Any]:
    """Return passes and draws of an eye, and bytes for each of its pixels and of both eyes.

    What is drawn once for both eyes counts half for each.
    """
    both = found.bytes * (1 if part in ONCE else 2)
    return {
        "passes": found.passes,
        "draws": found.draws,
        "bytes_per_pixel": round(both / 2 / (size_px[0] * size_px[1]), 2),
        "megabytes_both_eyes": round(both / 1e6, 2),
    }


def _whole(traffic: dict[str, Traffic]) -> Traffic:
    """Return one eye's traffic of a frame; parts drawn once for both eyes count half."""
    from vrcomfort.gpu.traffic import Traffic

    found = traffic.items()
    return Traffic(
        sum(each.passes for _, each in found),
        sum(each.draws for _, each in found),
        sum(each.bytes / (2 if part in ONCE else 1) for part, each in found),
        None,
    )


def study_passes(
    study: Protocol,
    size_px: tuple[int, int],
    *,
    draw: bool = True,
    advance: Callable[[], None] = lambda: None,
) -> StudyPasses:
    """Plan every condition of a study in every scene, for eyes of this size.

    Parameters
    ----------
    draw
        Draws a frame of each, to count what its effects send through memory.
    advance
        Called after each condition in a scene.
    """
    from vrcomfort.render.effects.depth_of_field.lens_radius import unlimited
    from vrcomfort.scene.load import load_scene

    renderer, no_opengl = _renderer(size_px)
    rows, depth = [], study.headset.depth
    for name in study.scenes:
        scene = load_scene(study.scene_source(name))
        for condition in study.conditions:
            shown = condition.in_scene(name)
            rows.append(_condition_passes(name, scene, shown, renderer, depth, draw=draw))
            advance()
    beyond = {each.name: found for each in study.conditions if (found := unlimited(each))}
    return StudyPasses(size_px, rows, no_opengl, beyond)


def _renderer(size_px: tuple[int, int]) -> tuple[StereoRenderer | None, str | None]:
    """Return a renderer, or why there is none: a plan needs no GPU, only its memory does."""
    from vrcomfort.gpu.gl import create_context
    from vrcomfort.render.pipeline import StereoRenderer

    try:
        return StereoRenderer(create_context(), size_px), None
    except InputError as error:
        return None, error.message


def _condition_passes(
    name: str,
    scene: Scene,
    condition: Condition,
    renderer: StereoRenderer | None,
    depth: DepthMode,
    *,
    draw: bool,
) -> PlannedPasses:
    from vrcomfort.gpu.memory import megabytes
    from vrcomfort.render.graph import plan_passes

    memory = None
    if renderer is not None:
        renderer.build(scene, condition)
        memory = {kind: round(value, 2) for kind, value in megabytes(renderer.memory()).items()}
        renderer.release()
    traffic = _traffic(scene, condition, renderer, depth) if renderer and draw else None
    passes = plan_passes(scene, condition)
    drawn = _drawn(passes)
    return PlannedPasses(
        scene=name,
        condition=condition.name,
        quality=_quality(condition, drawn),
        passes=passes,
        draws_effects=drawn != _drawn(plan_passes(scene, Condition(name="plain"))),
        figure=figure_for(condition, name, drawn),
        megabytes=memory,
        traffic=traffic,
    )


def _traffic(
    scene: Scene, condition: Condition, renderer: StereoRenderer, depth: DepthMode
) -> dict[str, Traffic] | None:
    """Draw a frame where the scene begins; not of many views, which would take minutes."""
    from vrcomfort.gpu.traffic import copied
    from vrcomfort.tradeoff.costs import a_step, traffic_of

    lens = condition.depth_of_field
    if lens is not None and lens.views > MOST_VIEWS:
        return None
    size_px = renderer.size_px
    step = a_step(scene.spawn, size_px)
    found = traffic_of(renderer.ctx, scene, condition, step, size_px, headset_depth=depth)
    found["headset"] = copied(size_px, COLOUR_BYTES + (DEPTH_BYTES if depth != "off" else 0))
    return found | {WHOLE: _whole(found)}


def _quality(condition: Condition, drawn: list[str]) -> str:
    """Return the quality level of these settings, or that they are of no level."""
    changed = f"{condition.quality}, changed" if condition.quality else "own settings"
    return level_of(condition, drawn) or changed


def _drawn(passes: list[PlannedPass]) -> list[str]:
    return [step.name for step in passes if step.needed]


def show(found: StudyPasses, study: Protocol) -> None:
    """Print one table of passes for each condition, then the costs of all."""
    for condition in study.conditions:
        rows = [row for row in found.rows if row.condition == condition.name]
        console(wrap=True).print(_passes_table(condition, rows))
        if beyond := found.beyond.get(condition.name):
            console(wrap=True).print(f"No limit: {beyond.text}", style="yellow")
    console(wrap=True).print(_cost_table(found))
    if any(row.traffic for row in found.rows):
        console(wrap=True).print(_traffic_table(found))
    for note in _notes(found):
        console(wrap=True).print(note, style="dim")


def _passes_table(condition: Condition, rows: list[PlannedPasses]) -> Table:
    table = _table(f"{condition.name}: {condition.label}" if condition.label else condition.name)
    table.add_column("pass", no_wrap=True)
    for row in rows:
        table.add_column(row.scene, overflow="fold")
    table.add_column("why", overflow="fold")
    for steps in zip(*(row.passes for row in rows), strict=True):
        marks = [Text("drawn", "green") if step.needed else "-" for step in steps]
        reasons = dict.fromkeys(step.reason for step in steps)
        table.add_row(steps[0].name, *marks, "; ".join(reasons))
    return table


def _cost_table(found: StudyPasses) -> Table:
    width, height = found.size_px
    table = _table(f"Cost and error of each quality level; GPU memory at 2 × {width}×{height}")
    for column in ("condition", "scene", "quality"):
        table.add_column(column, overflow="fold")
    for column in ("× plain", "dB", "FLIP", "MB", "of scene"):
        table.add_column(column, justify="right", no_wrap=True)
    for row in found.rows:
        memory = row.megabytes
        loaded = memory and memory["image"] + memory["buffer"]
        table.add_row(
            row.condition,
            row.scene,
            row.quality if row.draws_effects else "-",
            *_expected(row),
            f"{memory['total']:.0f}" if memory else UNKNOWN,
            f"{loaded:.0f}" if loaded else UNKNOWN,
        )
    return table


def _traffic_table(found: StudyPasses) -> Table:
    width, height = found.size_px
    table = _table(f"Passes and draws of an eye; bytes of the frames of both, 2 × {width}×{height}")
    for column in ("condition", "scene"):
        table.add_column(column, overflow="fold")
    table.add_column("part", no_wrap=True)
    for column in ("passes", "draws", "bytes/px", "MB"):
        table.add_column(column, justify="right", no_wrap=True)
    for row in found.rows:
        for part, each in (row.traffic or {}).items():
            data = _traffic_as_data(part, each, found.size_px)
            table.add_row(
                row.condition,
                row.scene,
                part,
                str(each.passes),
                str(each.draws),
                f"{data['bytes_per_pixel']:.1f}",
                f"{data['megabytes_both_eyes']:.0f}",
            )
    return table


def _expected(row: PlannedPasses) -> tuple[str, str, str]:
    if not row.draws_effects:
        return "1", "-", "-"
    if row.figure is None:
        return UNKNOWN, UNKNOWN, UNKNOWN
    psnr_db, flip = row.figure.psnr_db, row.figure.flip
    return (
        f"{row.figure.cost_ratio:.2f}",
        UNKNOWN if psnr_db is None else f"{psnr_db:.1f}",
        UNKNOWN if flip is None else f"{flip:.3f}",
    )


def _notes(found: StudyPasses) -> list[str]:
    measured = quality_table().measured
    memory = found.no_opengl and f"GPU memory is not known: {found.no_opengl}."
    told = [_about_figures(measured)] if measured and any(row.figure for row in found.rows) else []
    if any(row.draws_effects and row.figure is None for row in found.rows):
        told.append(
            f"{UNKNOWN}: not measured. Figures are kept of the levels of `quality` in the shipped "
            "scenes, with depth of field, motion blur of a moving camera, or both."
        )
    if any(row.traffic for row in found.rows):
        told.append(
            "Passes, draws and bytes are those of a frame drawn here where the scene begins, of a "
            "head that walks: each pass reads each of its textures once and writes what it draws; "
            "a mip chain is one pass. They grow with what is on the way. What follows the scene is "
            "drawn once for both eyes where the driver draws layers. "
            "`headset` is the copy of each image to the runtime; vertices are not counted, and a "
            "GPU that compresses, or keeps tiles on chip, moves less."
        )
    return [
        *told,
        memory
        or "GPU memory (MB) is the sum of the textures and buffers just allocated here, those of "
        "the scene included; swapchains belong to the runtime and are not counted.",
    ]


def _about_figures(measured: MeasurementSource) -> str:
    return (
        f"× plain (frames without effects), PSNR and FLIP are those of the quality level: measured "
        f"on {measured.device}, {measured.date} ({measured.how}), not with the laws, modes and "
        "strengths of your conditions, on your device or at your size: take them as a guide. A "
        "focus that is looked for, and locomotion, are not in them."
    )


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left")
