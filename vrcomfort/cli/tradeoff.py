"""`tradeoff`: cost and error of each method of blurring."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from vrcomfort.api.outputs import output_folder
from vrcomfort.cli.options import Json, Quiet, output_option, parse_size
from vrcomfort.cli.terminal import conclude, console, progress_bar, warn
from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from vrcomfort.tradeoff.methods import Effect

Name = TypeVar("Name", bound=str)
QUICK_SAMPLES = 256
QUICK_SIZE_PX = (640, 800)
"""Large enough to see the blur, and how methods differ in it."""
SMALL_SIZE_PX = (160, 200)
"""Of quick tables of costs alone."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(tradeoff)


def tradeoff(
    out: Annotated[Path, output_option(help="Folder for the results; earlier ones are replaced.")],
    scene: Annotated[
        list[str] | None, typer.Option(help="A shipped scene; once for each. Without it, all.")
    ] = None,
    effects: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,…",
            help="depth_of_field, motion_blur, both; without it, the first two. Or other effects: "
            "what each costs. Or focus, alone: what each search for the focus costs.",
        ),
    ] = None,
    methods: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,…",
            help="Methods to measure, and with them the effects that have one; by default all.",
        ),
    ] = None,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="Measure the left eye's image of one view, with fewer samples."
        ),
    ] = False,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WxH",
            help="Pixels of one eye's image; by default 320x400, or 640x800 with --quick "
            "(160x200 for costs alone).",
        ),
    ] = None,
    lens: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,…",
            help="1.75, 3.5, 7 (percent of the image's width at 2 dioptres) or eye (4 mm pupil).",
        ),
    ] = None,
    windows: Annotated[
        bool, typer.Option("--windows", help="Judge windows of images of 1832x1920, left eye.")
    ] = False,
    eyes: Annotated[
        int | None,
        typer.Option(
            help="Number of eyes to judge; 1: the left. By default 2, or 1 with --quick.",
            min=1,
            max=2,
        ),
    ] = None,
    flicker: Annotated[
        bool,
        typer.Option(
            "--flicker",
            help="Measure how errors change from frame to frame; takes more references.",
        ),
    ] = False,
    references: Annotated[
        bool, typer.Option("--references", help="Only draw the references, into the cache.")
    ] = False,
    views: Annotated[
        int | None, typer.Option(help="Number of views of each scene's walk.", min=1)
    ] = None,
    view: Annotated[
        int | None, typer.Option(help="Number of the only view to measure, from 1.", min=1)
    ] = None,
    samples: Annotated[int | None, typer.Option(help="Samples per reference.", min=2)] = None,
    rounds: Annotated[
        int | None,
        typer.Option(
            help="Timed frames per method; by default 300 on a GPU, 9 without, 3 with --quick.",
            min=1,
        ),
    ] = None,
    budget_ms: Annotated[
        float | None,
        typer.Option(
            help="Milliseconds that a stereo frame may take, for which the page says what to "
            "choose; by default nine tenths of a 90 Hz period.",
            min=0,
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Number of processes; by default one per core.", min=1)
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Address of a running Dask scheduler, such as tcp://host:8786."
        ),
    ] = None,
    cache: Annotated[
        Path | None,
        output_option(help="Cache folder; by default one in the user's cache."),
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Measure the cost and the error of each method of blurring.

    Writes index.html, tradeoff.json, tradeoff.csv, tradeoff.md, figures/ and sheets/. A run that
    was stopped goes on where it was.

    - `vrcomfort tradeoff --quick --out out/tradeoff`
    - `vrcomfort tradeoff --quick --budget-ms 8 --out out/tradeoff`
    - `vrcomfort tradeoff --scene temple --effects depth_of_field --samples 4096 --out temple`
    - `vrcomfort tradeoff --effects depth_of_field --size 1832x1920 --windows --out headset`
    - `vrcomfort tradeoff --effects vignette,speed_blur --out effects`
    - `vrcomfort tradeoff --effects focus --out focus`
    - `vrcomfort tradeoff --cluster tcp://host:8786 --cache /shared/cache --out out/tradeoff`
    """
    # Before anything loads OpenMP: FLIP's threads would wait for each other's cores.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    from vrcomfort.tradeoff.cases import Scope
    from vrcomfort.tradeoff.effect_costs import NAMES
    from vrcomfort.tradeoff.methods import EFFECTS, LENS_NAMES
    from vrcomfort.tradeoff.recommendation import BUDGET_MS
    from vrcomfort.tradeoff.run import tradeoff as run
    from vrcomfort.tradeoff.store import default_folder
    from vrcomfort.tradeoff.walk import SCENES

    quiet = quiet or as_json
    shown = _chosen("--scene", ",".join(scene) if scene else None, SCENES)
    asked = _chosen("--effects", effects, EFFECTS[:2], (*EFFECTS, *NAMES, "focus"))
    judged: tuple[Effect, ...] = tuple(each for each in EFFECTS if each in asked)
    if set(asked) & {"focus", *NAMES}:
        if judged or ("focus" in asked and len(asked) > 1):
            raise InputError(
                f"--effects {effects} asks for tables of different kinds; ask in runs of their "
                f"own for focus, for {', '.join(NAMES)}, and for {', '.join(EFFECTS)}"
            )
        others = (methods, lens, eyes, views, view, samples, budget_ms, jobs, cluster, cache)
        if any((windows, flicker, references, *(each is not None for each in others))):
            message = f"--effects {effects} takes --scene, --size, --rounds and --quick alone"
            raise InputError(message)
        where = output_folder(out), shown
        if "focus" in asked:
            written = _tradeoff_of_focus(*where, size, rounds, quick=quick, quiet=quiet)
        else:
            written = _tradeoff_of_effects(*where, asked, size, rounds, quick=quick, quiet=quiet)
        conclude(f"Costs: {written}", {"table": str(written)}, quiet=quiet, as_json=as_json)
        return
    scope = Scope(
        scenes=shown,
        effects=judged,
        motions=("walk",) if quick else ("walk", "turn"),
        poses=views or (1 if quick else 2),
        pose=None if view is None else view - 1,
        size_px=parse_size(size) if size else QUICK_SIZE_PX if quick else Scope.size_px,
        samples=samples or (QUICK_SAMPLES if quick else Scope.samples),
        quick=quick,
        methods=tuple(name.strip() for name in methods.split(",")) if methods else None,
        rounds=rounds,
        lenses=_chosen("--lens", lens, ("3.5",), LENS_NAMES),
        windows=windows,
        eyes=1 if eyes == 1 or (quick and eyes is None) else 2,
        flicker=flicker,
    )
    with ExitStack() as bars:

        def progress(title: str, steps: int) -> Callable[[], None]:
            bars.close()
            advance: Callable[[], None] = bars.enter_context(
                progress_bar(title, steps, quiet=quiet)
            )
            return advance

        summary = run(
            scope,
            out=output_folder(out),
            cache=cache or default_folder(),
            jobs=jobs or os.cpu_count() or 1,
            cluster=cluster,
            only_references=references,
            budget_ms=BUDGET_MS if budget_ms is None else budget_ms,
            progress=progress,
        )
    for doubt in summary.doubts:
        warn(doubt)
    console(quiet).print(summary.reused)
    page = None if summary.page is None else str(summary.page)
    if page is not None or as_json:
        facts = {"page": page, "doubts": list(summary.doubts)}
        conclude(f"Trade-off: {page}", facts, quiet=quiet, as_json=as_json)


def _tradeoff_of_focus(
    out: Path,
    scenes: tuple[str, ...],
    size: str | None,
    rounds: int | None,
    *,
    quick: bool,
    quiet: bool,
) -> Path:
    """Measure the searches for the focus, and write focus.md and two tables."""
    from vrcomfort.tradeoff import focus_search as focus
    from vrcomfort.tradeoff.captures import context

    sizes = (SMALL_SIZE_PX,) if quick else focus.SIZES_PX
    sizes = (parse_size(size),) if size else sizes
    rounds = rounds or (focus.QUICK_ROUNDS if quick else focus.ROUNDS)
    places = focus.QUICK_PLACES if quick else focus.PLACES
    each = (len(focus.searches()) - 1) * len(sizes) + len(focus.ZONE_RATIOS)
    costs, errors = [], []
    with progress_bar("focus", each * len(scenes), quiet=quiet) as advance:
        for scene in scenes:
            for size_px in sizes:
                costs += focus.search_costs(scene, size_px, rounds, advance)
            errors += focus.zone_errors(scene, places, advance)
    return focus.write(out, costs, errors, context())


def _tradeoff_of_effects(
    out: Path,
    scenes: tuple[str, ...],
    names: tuple[str, ...],
    size: str | None,
    rounds: int | None,
    *,
    quick: bool,
    quiet: bool,
) -> Path:
    """Measure effects that err from no ground truth, and write effects.md and effects.csv."""
    from vrcomfort.tradeoff import effect_costs as measured
    from vrcomfort.tradeoff.captures import context
    from vrcomfort.tradeoff.cases import Scope

    size_px = parse_size(size) if size else SMALL_SIZE_PX if quick else Scope.size_px
    scope = Scope(scenes=scenes, size_px=size_px, quick=quick, rounds=rounds)
    steps = measured.steps(names) * len(scenes)
    with progress_bar("effects", steps, quiet=quiet) as advance:
        costs = measured.effect_costs(scope, names, advance)
    return measured.write(out, costs, context())


def _chosen(
    option: str, text: str | None, default: tuple[Name, ...], known: tuple[Name, ...] | None = None
) -> tuple[Name, ...]:
    """Return the names in a comma-separated list.

    Raises
    ------
    InputError
        If one of them is not known.
    """
    if text is None:
        return default
    by_name: dict[str, Name] = {name: name for name in known or default}
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in by_name:
            raise InputError(f"{option}: there is no {name!r}; there are: {', '.join(by_name)}")
    return tuple(by_name[name] for name in dict.fromkeys(names))
