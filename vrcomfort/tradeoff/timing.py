"""What frames cost: the time of each pass, and how many times that of copying the images."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias

import moderngl
import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.geometry import Array
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.gl import color_texture
from vrcomfort.gpu.timer import Lap, Stopwatch, is_software
from vrcomfort.render.effects.depth_of_field.effect import DepthOfFieldPass
from vrcomfort.render.effects.depth_of_field.lens_views import LensViews
from vrcomfort.render.effects.motion_blur.effect import MotionBlurPass
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

LONGEST_S = 30.0
"""A method whose timed frames have taken so long together is not timed again."""

GPU_ROUNDS, SOFTWARE_ROUNDS, QUICK_ROUNDS = 300, 20, 3
"""Timed frames of each method; the last, on a software rasteriser, of a quick run."""

P95_ROUNDS, P99_ROUNDS = 20, 100
"""Fewest frames of which a 95th or 99th percentile is told: of fewer it would be the slowest."""

Timed: TypeAlias = dict[str, tuple[float, int]]
"""Seconds and calls of each pass in one frame."""

Laps: TypeAlias = dict[str, list[Lap]]
"""What tells the seconds of each pass in one frame, call by call."""


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
                ctx, "common/copy.frag", size_px=size_px, inputs={"source": source}, target=target
            )
            for source, target in ((there, back), (back, there))
        )

    def render(self) -> None:
        """Copy `COPIES` stereo frames."""
        for _ in range(COPIES):
            for copy in self._copies:
                copy.render()


class MethodTime(NamedTuple):
    """What a method costs in a case, per stereo frame: medians over rounds and their 5–95 %.

    Percentiles (nearest ranks) are None where rounds are too few for them.
    """

    method: str
    frame_ms: float
    effect_ms: float
    effect_p95_ms: float | None
    effect_p99_ms: float | None
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


def rounds_of(scope: Scope, ctx: moderngl.Context) -> int:
    """Return how many frames of each method are timed."""
    if scope.rounds is not None:
        return scope.rounds
    if not is_software(ctx):
        return GPU_ROUNDS
    return QUICK_ROUNDS if scope.quick else SOFTWARE_ROUNDS


def time_case(case: Case, scope: Scope, advance: Callable[[], None]) -> CaseTime:
    """Time all methods of a case in turn, round by round, on the same frame.

    What a GPU draws in a round is queued as a whole, and its time stamps are read afterwards.
    """
    ctx = context()
    clock, copy = Stopwatch(ctx), CopyFloor(ctx, scope.size_px)
    todo = pick(methods(case.effect, quick=scope.quick), scope.methods)
    renderers = {method.name: _renderer(case, scope, method) for method in todo}
    plain = renderers[next(method.name for method in todo if method.family == "none")]
    pair = frames(case, scope) if case.motion != "still" else (None, frames(case, scope)[1])
    rounds: dict[str, list[tuple[float, Timed]]] = {method.name: [] for method in todo}
    floors: list[tuple[float, float]] = []
    plains: list[tuple[float, float]] = []
    for turn in range(rounds_of(scope, ctx) + 1):  # the first warms up
        floor = clock.lap(copy.render), clock.lap(copy.render)
        twice = _frame_lap(clock, plain, pair), _frame_lap(clock, plain, pair)
        queued = {
            name: _queue(clock, renderers[name], pair, warm=not turn)
            for name, known in rounds.items()
            if not _enough(known)
        }
        copy_s, plain_s = [lap() / COPIES for lap in floor], [lap() for lap in twice]
        if turn:
            floors.append((copy_s[0], copy_s[1]))
            plains.append((plain_s[0], plain_s[1]))
        for name, found in ((name, tell()) for name, tell in queued.items()):
            if turn or found[0] > SLOW_S:
                rounds[name].append(found)
        advance()
    return _case_time(case, np.array(floors), np.array(plains), rounds)


def _enough(known: list[tuple[float, Timed]]) -> bool:
    frame_s = [seconds for seconds, _ in known]
    return max(frame_s, default=0.0) > SLOW_S or sum(frame_s) > LONGEST_S


def _case_time(
    case: Case, copy_s: Array, plain_s: Array, rounds: dict[str, list[tuple[float, Timed]]]
) -> CaseTime:
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


def _frame_lap(clock: Stopwatch, renderer: StereoRenderer, pair: Pair) -> Lap:
    _render_before(renderer, pair)
    return clock.lap(lambda: renderer.render(pair[1], time_s(pair[1])))


def _queue(
    clock: Stopwatch, renderer: StereoRenderer, pair: Pair, *, warm: bool
) -> Callable[[], tuple[float, Timed]]:
    """Draw two frames, and return what tells the seconds of one and of the other's passes.

    When `warm`-ing up, a slow frame is drawn once, and its passes are the frame.
    """
    _render_before(renderer, pair)
    with clocked_passes(clock) as laps:
        renderer.render(pair[1], time_s(pair[1]))
    timed = told(laps) if warm else None
    if timed and (whole_s := sum(seconds for seconds, _ in timed.values())) > SLOW_S:
        return lambda: (whole_s, timed)
    frame = _frame_lap(clock, renderer, pair)
    return lambda: (frame(), timed or told(laps))


def told(laps: Laps) -> Timed:
    """Return the seconds and calls of each pass; waits for the GPU."""
    return {name: (sum(lap() for lap in each), len(each)) for name, each in laps.items()}


def _render_before(renderer: StereoRenderer, pair: Pair) -> None:
    before, frame = pair
    if before is not None:
        renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)


@contextmanager
def clocked_passes(clock: Stopwatch) -> Iterator[Laps]:
    """Clock the passes that are drawn inside; passes within passes count as the outer one's."""
    laps: Laps = {}
    kept = [(owner, owner.render) for owner in PASSES]
    depth = [0]

    def clocked(method: Callable[..., Any], name: str) -> Callable[..., Any]:
        def render(*arguments: Any, **options: Any) -> Any:
            if depth[0]:
                return method(*arguments, **options)
            depth[0] += 1
            try:
                lap = clock.lap(lambda: method(*arguments, **options))
            finally:
                depth[0] -= 1
            laps.setdefault(name, []).append(lap)
            return None

        return render

    for owner, method in kept:
        owner.render = clocked(method, PASSES[owner])
    try:
        yield laps
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
        _percentile_ms(effects_s, 95, P95_ROUNDS),
        _percentile_ms(effects_s, 99, P99_ROUNDS),
        {each: float(np.median([p[each][0] for _, p in timed]) * 1e3) for each in names},
        float(np.median(effects_s / copies)),
        _interval(effects_s / copies),
        float(np.median(frame_s) / np.median(plain_s)),
        len(timed),
    )


def _percentile_ms(seconds: Array, percent: float, least: int) -> float | None:
    if len(seconds) < least:
        return None
    return float(np.percentile(seconds, percent, method="inverted_cdf") * 1e3)


def _interval(ratios: Any) -> tuple[float, float]:
    low, high = np.percentile(ratios, [5, 95])
    return float(low), float(high)
