"""The whole measurement: references, then errors, then (alone on the machine) times; then files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from vrcomfort.errors import InputError
from vrcomfort.gpu.gl import describe, is_software
from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.cases import Case, Scope, cases, eyes_of
from vrcomfort.tradeoff.costs import CaseTime, rounds_of, time_case, traffic_of_method
from vrcomfort.tradeoff.files import write_all
from vrcomfort.tradeoff.image_error import margin_px, require_flip
from vrcomfort.tradeoff.measure import MeasuredCase, measure
from vrcomfort.tradeoff.methods import BlurMethod, effects_with, methods, pick
from vrcomfort.tradeoff.recommendation import BUDGET_MS
from vrcomfort.tradeoff.references import DrawnSamples, draw_reference
from vrcomfort.tradeoff.results import results
from vrcomfort.tradeoff.store import Store, scene_and_hash
from vrcomfort.tradeoff.tables import doubts
from vrcomfort.workers import Work, workers

StageProgress: TypeAlias = Callable[[str, int], Callable[[], None]]
"""Shows a stage: called with its title and number of steps, gives a function to advance it."""


class Summary(NamedTuple):
    """Result of a run."""

    page: Path | None
    """None where only references were drawn."""
    reused: str
    """Work kept from earlier runs, in words."""
    doubts: list[str]
    """Why the costs are not to be believed; empty where they are."""


def tradeoff(
    scope: Scope,
    *,
    out: Path,
    cache: Path,
    jobs: int = 1,
    cluster: str | None = None,
    only_references: bool = False,
    budget_ms: float = BUDGET_MS,
    progress: StageProgress,
) -> Summary:
    """Measure everything in `scope` and write it into `out`; or only draw and keep references.

    The page says what to choose where a stereo frame may take `budget_ms`.

    Raises
    ------
    InputError
        If a scene or method is unknown, an image is all margin, the cache cannot be written to, no
        cluster answers, or FLIP cannot be computed here.
    """
    if not only_references:
        require_flip()
    store = Store(cache)
    scope = _checked(scope)
    todo = cases(scope)
    with workers(jobs, cluster) as work:
        if cluster is not None:
            _check_shared(work, store)
        drawn = _draw(work, todo, scope, store, progress)
        if only_references:
            return Summary(None, _reused(drawn, []), [])
        measured = _measure(work, todo, scope, store, progress)
    scope = replace(scope, rounds=rounds_of(scope, context()))
    times = _time(todo, scope, progress)
    traffic = _traffic(todo, scope, progress)
    facts = describe(context())
    found = results(
        scope, measured, times, traffic, f"{facts['renderer']}, {facts['version']}", _timer()
    )
    page = write_all(out, found, measured, budget_ms)
    return Summary(page, _reused(drawn, measured), doubts(found["again"]))


class _ReferenceJob(NamedTuple):
    case: Case
    eye: int


def _draw(
    work: Work, todo: list[Case], scope: Scope, store: Store, progress: StageProgress
) -> list[DrawnSamples]:
    jobs = [
        _ReferenceJob(case, eye)
        for case in _with_later(todo, scope)
        for eye in range(eyes_of(case, scope))
    ]
    advance = progress("references", len(jobs))
    found = []
    for drawn in work(partial(_draw_one, scope, store), jobs):
        found.append(drawn)
        advance()
    return found


def _with_later(todo: list[Case], scope: Scope) -> list[Case]:
    """Return the cases with those a frame later, which flicker needs."""
    times = (False, True) if scope.flicker else (False,)
    return [replace(case, later=later) for case in todo for later in times]


def _draw_one(scope: Scope, store: Store, job: _ReferenceJob) -> DrawnSamples:
    return draw_reference(job.case, scope, job.eye, store)


def _measure(
    work: Work, todo: list[Case], scope: Scope, store: Store, progress: StageProgress
) -> list[MeasuredCase]:
    advance = progress("methods", len(todo))
    found = {}
    for one in work(partial(_measure_one, scope, store), todo):
        found[one.case] = one
        advance()
    return [found[case] for case in todo]


def _measure_one(scope: Scope, store: Store, case: Case) -> MeasuredCase:
    return measure(case, scope, store)


def _time(todo: list[Case], scope: Scope, progress: StageProgress) -> list[CaseTime]:
    """Time in this process alone, one case after the other: nothing else disturbs."""
    wholes = _wholes(todo)
    advance = progress("times", sum(len(_methods(case, scope)) for case in wholes))
    return [time_case(case, scope, advance) for case in wholes]


def _traffic(
    todo: list[Case], scope: Scope, progress: StageProgress
) -> dict[tuple[Case, str], dict[str, Any]]:
    """Count the traffic of each method's effects."""
    pairs = [(case, method) for case in _wholes(todo) for method in _methods(case, scope)]
    advance = progress("reads and bytes", len(pairs))
    found = {}
    for case, method in pairs:
        found[case, method.name] = traffic_of_method(method, case, scope)
        advance()
    return found


def _wholes(todo: list[Case]) -> list[Case]:
    """Return the whole images of which cases show parts, each once."""
    return list(dict.fromkeys(replace(case, window=None) for case in todo))


def _methods(case: Case, scope: Scope) -> list[BlurMethod]:
    return pick(methods(case.effect, quick=scope.quick), scope.methods)


def _checked(scope: Scope) -> Scope:
    """Return the scope with only the effects that have one of the methods asked for."""
    margin_px(scope.size_px)
    for name in scope.scenes:
        scene_and_hash(name)
    return replace(scope, effects=effects_with(scope.effects, scope.methods, quick=scope.quick))


def _check_shared(work: Work, store: Store) -> None:
    """Make sure that workers see the cache that this process sees."""
    store.write("shared")
    if not all(work(store.has, ["shared"])):
        raise InputError(
            "is not seen by the cluster's workers; give --cache a folder that all machines share",
            file=store.folder,
        )


def _timer() -> str:
    software = is_software(context())
    return "processor time of this process" if software else "time stamps of the GPU"


def _reused(drawn: list[DrawnSamples], measured: list[MeasuredCase]) -> str:
    samples, reused = sum(d.samples for d in drawn), sum(min(d.reused, d.samples) for d in drawn)
    rows = sum(len(each.rows) - 1 for each in measured)
    kept = sum(each.reused for each in measured)
    return (
        f"{reused} of {samples} reference samples and {kept} of {rows} measurements of methods "
        "were there from an earlier run"
    )
