"""What frames cost: the time of each pass, and how many times that of copying the images."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias

import moderngl
import numpy as np

from vrcomfort.headset.base import Frame
from vrcomfort.render.depth_of_field import DepthOfFieldPass
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.gl import color_texture
from vrcomfort.render.gpu_timer import Stopwatch
from vrcomfort.render.lens_views import LensViews
from vrcomfort.render.motion_blur import MotionBlurPass
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.render.tone_map import ToneMapPass
from vrcomfort.tradeoff.cases import Case, Scope, frames
from vrcomfort.tradeoff.methods import Method, methods, pick
from vrcomfort.tradeoff.shots import context
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import REFRESH_HZ, time_s

PASSES: dict[type[Any], str] = {
    ScenePass: "scene",
    LensViews: "lens_views",
    DepthOfFieldPass: "depth_of_field",
    MotionBlurPass: "motion_blur",
    ToneMapPass: "tone_map",
    FullscreenPass: "other",
}
"""What is timed: the outermost of these at any moment."""

COPIES = 32
"""Copies of a stereo frame that are timed together: one is too short."""

SLOW_S = 1.0
"""A frame that takes longer is timed once, pass by pass."""

Timed: TypeAlias = dict[str, tuple[float, int]]
"""Seconds and calls of each pass in one frame."""


Pair: TypeAlias = tuple[Frame | None, Frame]
"""The frame before (None where nothing moves: it would be the same one) and the one to time."""


class CopyFloor:
    """Copies stereo frames of linear light: what any pass that reads and writes them costs.

    Each copy is copied again: a renderer that works tile by tile would not draw one image many
    times over as it draws the passes of a frame, where each waits for the one before.
    """

    def __init__(self, ctx: moderngl.Context, size_px: tuple[int, int]) -> None:
        there, back = (color_texture(ctx, size_px) for _ in range(2))
        self._copies = tuple(
            FullscreenPass(
                ctx, "copy.frag", size_px=size_px, inputs={"source": source}, target=target
            )
            for source, target in ((there, back), (back, there))
        )

    def render(self) -> None:
        """Copy `COPIES` stereo frames."""
        for _ in range(COPIES):
            for copy in self._copies:
                copy.render()


class MethodTime(NamedTuple):
    """What a method costs in a case, per stereo frame: medians over rounds and their 5–95 %."""

    method: str
    frame_ms: float
    effect_ms: float
    passes_ms: dict[str, float]
    effect_to_copy: float
    effect_to_copy_interval: tuple[float, float]
    frame_to_plain: float
    rounds: int


class CaseTime(NamedTuple):
    """What the methods of a case cost, and how well that is known."""

    case: Case
    copy_ms: float
    copy_again: tuple[float, float]
    """A/A: 5 % and 95 % of the ratio of two copies of the same round."""
    plain_ms: float
    plain_again: tuple[float, float]
    """A/A: of two plain frames of the same round."""
    methods: list[MethodTime]


def time_case(case: Case, scope: Scope, advance: Callable[[], None]) -> CaseTime:
    """Time all methods of a case in turn, round by round, on the same frame."""
    ctx = context()
    clock, copy = Stopwatch(ctx), CopyFloor(ctx, scope.size_px)
    todo = pick(methods(case.effect, quick=scope.quick), scope.methods)
    renderers = {method.name: _renderer(case, scope, method) for method in todo}
    plain = renderers[next(method.name for method in todo if method.family == "none")]
    pair = frames(case, scope) if case.motion != "still" else (None, frames(case, scope)[1])
    rounds: dict[str, list[tuple[float, Timed]]] = defaultdict(list)
    floors: list[tuple[float, float]] = []
    plains: list[tuple[float, float]] = []
    for turn in range(scope.rounds + 1):  # the first warms up
        floor = clock.seconds(copy.render), clock.seconds(copy.render)
        twice = _frame_s(clock, plain, pair), _frame_s(clock, plain, pair)
        if turn:
            floors.append((floor[0] / COPIES, floor[1] / COPIES))
            plains.append(twice)
        for method in todo:
            known = rounds[method.name]
            if known and known[0][0] > SLOW_S:
                continue
            found = _times(clock, renderers[method.name], pair)
            if turn or found[0] > SLOW_S:
                known.append(found)
        advance()
    copy_s, plain_s = np.array(floors), np.array(plains)
    return CaseTime(
        case,
        float(np.median(copy_s) * 1e3),
        _interval(copy_s[:, 1] / copy_s[:, 0]),
        float(np.median(plain_s) * 1e3),
        _interval(plain_s[:, 1] / plain_s[:, 0]),
        [_summary(name, timed, copy_s, plain_s) for name, timed in rounds.items()],
    )


def _renderer(case: Case, scope: Scope, method: Method) -> StereoRenderer:
    scene, _ = scene_and_hash(case.scene)
    renderer = StereoRenderer(context(), scope.size_px)
    renderer.begin(scene, method.condition)
    return renderer


def _frame_s(clock: Stopwatch, renderer: StereoRenderer, pair: Pair) -> float:
    _render_before(renderer, pair)
    return clock.seconds(lambda: renderer.render(pair[1], time_s(pair[1])))


def _times(clock: Stopwatch, renderer: StereoRenderer, pair: Pair) -> tuple[float, Timed]:
    """Return the seconds of a frame and of its passes: of two frames, unless they are slow."""
    _render_before(renderer, pair)
    with clocked_passes(clock) as timed:
        renderer.render(pair[1], time_s(pair[1]))
    whole_s = sum(seconds for seconds, _ in timed.values())
    return (whole_s if whole_s > SLOW_S else _frame_s(clock, renderer, pair)), timed


def _render_before(renderer: StereoRenderer, pair: Pair) -> None:
    before, frame = pair
    if before is not None:
        renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)


@contextmanager
def clocked_passes(clock: Stopwatch) -> Iterator[dict[str, tuple[float, int]]]:
    """Clock the passes that are drawn inside; passes within passes count as the outer one's."""
    timed: dict[str, tuple[float, int]] = {}
    kept = [(owner, owner.render) for owner in PASSES]
    depth = [0]

    def clocked(method: Callable[..., Any], name: str) -> Callable[..., Any]:
        def render(*arguments: Any, **options: Any) -> Any:
            if depth[0]:
                return method(*arguments, **options)
            depth[0] += 1
            try:
                seconds = clock.seconds(lambda: method(*arguments, **options))
            finally:
                depth[0] -= 1
            before_s, calls = timed.get(name, (0.0, 0))
            timed[name] = before_s + seconds, calls + 1
            return None

        return render

    for owner, method in kept:
        owner.render = clocked(method, PASSES[owner])
    try:
        yield timed
    finally:
        for owner, method in kept:
            owner.render = method


def effect_s(timed: Timed) -> float:
    """Return the seconds that a frame's effects cost: all that comes after the first drawing.

    Of several drawings of the scene (one for each view of the lens), all but one for each eye.
    """
    seconds, calls = timed["scene"]
    again = seconds * max(0, calls - 2) / calls
    return again + sum(s for name, (s, _) in timed.items() if name not in {"scene", "tone_map"})


def _summary(name: str, timed: list[tuple[float, Timed]], copy_s: Any, plain_s: Any) -> MethodTime:
    frame_s = [seconds for seconds, _ in timed]
    effects_s = np.array([effect_s(passes) for _, passes in timed])
    copies = np.resize(copy_s.mean(axis=1), len(effects_s))
    names = list(dict.fromkeys(name for _, passes in timed for name in passes))
    return MethodTime(
        name,
        float(np.median(frame_s) * 1e3),
        float(np.median(effects_s) * 1e3),
        {each: float(np.median([p[each][0] for _, p in timed]) * 1e3) for each in names},
        float(np.median(effects_s / copies)),
        _interval(effects_s / copies),
        float(np.median(frame_s) / np.median(plain_s)),
        len(timed),
    )


def _interval(ratios: Any) -> tuple[float, float]:
    low, high = np.percentile(ratios, [5, 95])
    return float(low), float(high)
