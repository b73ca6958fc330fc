"""Costs of a frame's passes: time in parts of a plain frame's, and traffic through memory.

On a software rasteriser the time is the processor's: CPU seconds of this process. Traffic (bytes,
reads, draws) is `gpu.traffic`'s, of one eye's image, effect by effect: it travels between machines,
as times do not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import moderngl
import numpy as np

from vrcomfort.frame import EYE_HEIGHT_M, Frame
from vrcomfort.geometry import Array, Gaze, HiddenAreas, Pose, View, yaw_pitch_roll
from vrcomfort.gpu import passes, shaders
from vrcomfort.gpu.gl import is_software
from vrcomfort.gpu.timer import Lap, Stopwatch
from vrcomfort.gpu.traffic import Traffic, TrafficCounter, added_up
from vrcomfort.headset.playback import default_fovs
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.viewing import DepthMode
from vrcomfort.render.condition_passes import RESOLVE
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.cases import Case, Scope, condition_of, eyes_of, frames
from vrcomfort.tradeoff.methods import BlurMethod, methods, no_blur, pick
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import REFRESH_HZ, time_s

NO_EFFECT = ("focus", "shadow", "scene", "tone_map", "headset_depth")
"""Parts that no effect has added, or (the focus search) that blurs of all methods share. So is
`RESOLVE` but for the circles of confusion, which are its cost beyond a plain frame's."""

SLOW_S = 12.0
"""A method whose first frame takes longer is not timed again."""

LONGEST_S = 40.0
"""A method whose timed frames have taken so long together is not timed again."""

GPU_ROUNDS, SOFTWARE_ROUNDS, QUICK_ROUNDS = 300, 9, 3
"""Timed frames of each method; the last, on a software rasteriser, of a quick run."""

P95_ROUNDS, P99_ROUNDS = 20, 100
"""Fewest frames of which a 95th or 99th percentile is told: of fewer it would be the slowest."""

Timed: TypeAlias = dict[str, tuple[float, int]]
"""Seconds and calls of each part in one frame."""

Laps: TypeAlias = dict[str, list[Lap]]
"""Laps of each part in one frame, call by call."""

Pair: TypeAlias = tuple[Frame | None, Frame]
"""The frame before (None where nothing moves: it would be the same one) and the one to time."""


class MethodTime(NamedTuple):
    """Cost of a method in a case: medians over rounds and their 5–95 %.

    `cost` is 1 + effect ÷ plain, each round's effect by the plain frames before and after it.
    Percentiles (nearest ranks) are None where rounds are too few for them.
    """

    method: str
    cost: float
    cost_interval: tuple[float, float]
    frame_ms: float
    effect_ms: float
    effect_p95_ms: float | None
    effect_p99_ms: float | None
    parts_ms: dict[str, float]
    rounds: int


class CaseTime(NamedTuple):
    """Costs of the methods of a case, and their precision."""

    case: Case
    plain_ms: float
    plain_again: tuple[float, float]
    """A/A: 5 % and 95 % of the ratio of a plain frame to the one before it."""
    methods: list[MethodTime]


def rounds_of(scope: Scope, ctx: moderngl.Context) -> int:
    """Return how many frames of each method are timed."""
    if scope.rounds is not None:
        return scope.rounds
    if not is_software(ctx):
        return GPU_ROUNDS
    return QUICK_ROUNDS if scope.quick else SOFTWARE_ROUNDS


def time_case(case: Case, scope: Scope, advance: Callable[[], None]) -> CaseTime:
    """Time all methods of a case, one after the other, each in turn with plain frames.

    Of a case with a window, the whole image is timed. A GPU gets the draws of a method queued as a
    whole, and its time stamps are read afterwards.
    """
    whole, todo = replace(case, window=None), methods(case.effect, quick=scope.quick)
    plain = _Timer(whole, scope, no_blur(case.effect).condition)
    plain.frame()
    plains: list[Array] = []
    found = []
    for method in pick(todo, scope.methods):
        found.append(time_method(method, whole, scope, plain, plains))
        advance()
    seconds = np.concatenate(plains)
    again = np.concatenate([each[1:] / each[:-1] for each in plains])
    return CaseTime(whole, float(np.median(seconds) * 1e3), _interval(again), found)


def time_alone(method: BlurMethod, case: Case, scope: Scope) -> MethodTime:
    """Time one method, in turn with plain frames."""
    plain = _Timer(replace(case, window=None), scope, no_blur(case.effect).condition)
    plain.frame()
    return time_method(method, replace(case, window=None), scope, plain, [])


def time_method(
    method: BlurMethod, case: Case, scope: Scope, plain_frames: _Timer, plains: list[Array]
) -> MethodTime:
    """Time a method; the seconds of the plain frames in between are added to `plains`."""
    timer = _Timer(case, scope, method.condition)
    first = told(timer.frame())
    rounds = 0
    if whole_s(first) <= SLOW_S:
        most = rounds_of(scope, context())
        rounds = min(most, max(1, int(LONGEST_S / max(whole_s(first), 1e-9))))
    # In turns with plain frames: a clock that drifts, or other load, changes both alike.
    queued, between = [], [plain_frames.frame()]
    for _ in range(rounds):
        queued.append(timer.frame())
        between.append(plain_frames.frame())
    if not queued:
        between.append(plain_frames.frame())
    timed = [told(laps) for laps in queued] or [first]
    plain = [told(laps) for laps in between]
    plain_s = np.array([whole_s(each) for each in plain])
    plains.append(plain_s)
    timer.release()
    # Radii are written in the resolve: with depth of field its cost beyond a plain one counts.
    resolved = timed if method.condition.depth_of_field is None else plain
    resolve_s = np.array([each[RESOLVE][0] for each in resolved])
    resolve_s = resolve_s if resolved is timed else _between(resolve_s)
    return _summary(method.name, timed, _between(plain_s), resolve_s)


class _Timer:
    """Draws a case's frame with a condition, again and again."""

    def __init__(self, case: Case, scope: Scope, condition: Condition) -> None:
        self._clock = Stopwatch(context())
        before, frame = frames(case, scope)
        self._pair: Pair = (before if case.motion != "still" else None, frame)
        scene, _ = scene_and_hash(case.scene)
        self._renderer = StereoRenderer(context(), scope.size_px, eyes=eyes_of(case, scope))
        self._renderer.build(scene, condition_of(case, scope, condition))
        self._renderer.leave_out_records()

    def frame(self) -> Laps:
        """Draw a frame, and return the laps of its parts."""
        before, frame = self._pair
        if before is not None:
            self._renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)
        clock = PartClock(self._clock)
        with passes.watched(clock):
            self._renderer.render(frame, time_s(frame))
        return clock.laps

    def release(self) -> None:
        """Release the renderer's objects on the GPU."""
        self._renderer.release()


class PartClock(passes.Watcher):
    """Clocks the parts of a frame; parts within parts count as the outer one's."""

    def __init__(self, clock: Stopwatch) -> None:
        self._clock, self._inside = clock, False
        self.laps: Laps = {}

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Clock the draws inside as a part."""
        if self._inside:
            yield
            return
        self._inside = True
        with self._clock.lap() as lap:
            yield
        self._inside = False
        self.laps.setdefault(name, []).append(lap)


def told(laps: Laps) -> Timed:
    """Return the seconds and calls of each part; waits for the GPU."""
    return {name: (sum(lap() for lap in each), len(each)) for name, each in laps.items()}


def whole_s(timed: Timed) -> float:
    """Return the seconds of all parts of a frame."""
    return sum(seconds for seconds, _ in timed.values())


def effect_s(timed: Timed, plain_resolve_s: float = 0.0) -> float:
    """Return the seconds that a frame's effects cost: all that no plain frame has.

    `plain_resolve_s` is the cost of `RESOLVE` without them. Several views through the lens draw
    the scene within their own part; one drawing of it for each eye is outside.
    """
    return sum(s for name, (s, _) in timed.items() if name not in NO_EFFECT) - plain_resolve_s


def _between(seconds: Array) -> Array:
    """Return the means of each two that follow each other."""
    return (seconds[1:] + seconds[:-1]) / 2


def _summary(
    name: str, timed: Sequence[Timed], plain_s: Array, plain_resolve_s: Array
) -> MethodTime:
    frame_s = np.array([whole_s(each) for each in timed])
    effects_s = np.array([effect_s(*each) for each in zip(timed, plain_resolve_s, strict=True)])
    costs = 1 + effects_s / plain_s
    names = list(dict.fromkeys(part for each in timed for part in each))
    return MethodTime(
        name,
        float(np.median(costs)),
        _interval(costs),
        float(np.median(frame_s) * 1e3),
        float(np.median(effects_s) * 1e3),
        _percentile_ms(effects_s, 95, P95_ROUNDS),
        _percentile_ms(effects_s, 99, P99_ROUNDS),
        {part: float(np.median([each[part][0] for each in timed]) * 1e3) for part in names},
        len(timed),
    )


def _percentile_ms(seconds: Array, percent: float, least: int) -> float | None:
    if len(seconds) < least:
        return None
    return float(np.percentile(seconds, percent, method="inverted_cdf") * 1e3)


def _interval(ratios: Any) -> tuple[float, float]:
    low, high = np.percentile(ratios, [5, 95])
    return float(low), float(high)


WALK_M_PER_S, WALK_RAD_PER_S = 1.4, 0.5
FRAME_NS = round(1e9 / REFRESH_HZ)


def traffic_of(
    ctx: moderngl.Context,
    scene: Scene,
    condition: Condition,
    pair: tuple[Frame | None, Frame],
    size_px: tuple[int, int],
    *,
    count_reads: bool = False,
    records: bool = True,
    headset_depth: DepthMode = "scene",
    hidden: HiddenAreas = (None, None),
) -> dict[str, Traffic]:
    """Draw the left eye of a frame, and return the traffic of each kind of pass.

    Parameters
    ----------
    pair
        The frame before, None where nothing moves, and the one to look at.
    count_reads
        Compiles shaders that count their texture reads: slower, the same pictures.
    records
        Whether that is counted too which only the record of limits needs.
    headset_depth
        The depth that a runtime is to get.
    hidden
        What the lenses never show.
    """
    renderer = StereoRenderer(ctx, size_px, eyes=1, headset_depth=headset_depth, hidden=hidden)
    with shaders.counting_reads() if count_reads else nullcontext():
        renderer.build(scene, condition)
    if not records:
        renderer.leave_out_records()
    before, frame = pair
    if before is not None:
        renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)
    counter = TrafficCounter(ctx)
    with passes.watched(counter):
        renderer.render(frame, time_s(frame))
    renderer.release()
    sums = {name: added_up(drawn) for name, drawn in counter.parts.items()}
    if count_reads:
        return sums
    return {name: each._replace(reads=None) for name, each in sums.items()}


def traffic_of_method(method: BlurMethod, case: Case, scope: Scope) -> dict[str, Any]:
    """Return the traffic of a method's effects for one eye's whole image.

    ``reads_per_pixel`` and ``bytes_per_pixel`` of that image, ``passes`` and ``draws``.
    """
    whole = replace(case, window=None)
    parts = _parts_of(method.condition, whole, scope)
    found = of_effects(parts)
    reads = found.reads or 0
    if method.condition.depth_of_field is not None:
        reads += (parts[RESOLVE].reads or 0) - _reads_of_plain_resolve(whole, scope)
    pixels = scope.size_px[0] * scope.size_px[1]
    return {
        "reads_per_pixel": reads / pixels,
        "bytes_per_pixel": found.bytes / pixels,
        "passes": found.passes,
        "draws": found.draws,
    }


def _parts_of(condition: Condition, case: Case, scope: Scope) -> dict[str, Traffic]:
    scene, _ = scene_and_hash(case.scene)
    before, frame = frames(case, scope)
    return traffic_of(
        context(),
        scene,
        condition_of(case, scope, condition),
        (before if case.motion != "still" else None, frame),
        scope.size_px,
        count_reads=True,
        records=False,
    )


@lru_cache(maxsize=1)
def _reads_of_plain_resolve(case: Case, scope: Scope) -> int:
    return _parts_of(no_blur(case.effect).condition, case, scope)[RESOLVE].reads or 0


def a_step(spawn: Pose, size_px: tuple[int, int]) -> tuple[Frame, Frame]:
    """Return two frames of a head that walks and turns where a scene begins: everything moves."""
    left, right = default_fovs(size_px)
    heads = [
        Pose(np.array([0.0, EYE_HEIGHT_M, -metres]), yaw_pitch_roll(yaw_rad, 0.0, 0.0))
        for metres, yaw_rad in (
            (0.0, 0.0),
            (WALK_M_PER_S / REFRESH_HZ, WALK_RAD_PER_S / REFRESH_HZ),
        )
    ]
    before, after = (
        Frame(
            index=number,
            predicted_display_time_ns=(number + 1) * FRAME_NS,
            period_ns=FRAME_NS,
            head_pose=head,
            views=(View(head, left), View(head, right)),
            avatar_pose=spawn,
            discontinuity=number == 0,
            gaze=Gaze(head),
        )
        for number, head in enumerate(heads)
    )
    return before, after


def by_effect(found: dict[str, Traffic]) -> dict[str, Traffic]:
    """Return the traffic of effects, pass by pass.

    Radii that are written where samples are resolved move no bytes that are not moved without them.
    """
    return {name: each for name, each in found.items() if name not in {*NO_EFFECT, RESOLVE}}


def of_effects(found: dict[str, Traffic]) -> Traffic:
    """Return the traffic of all effects of an eye's image."""
    effects = by_effect(found).values()
    reads = [each.reads for each in effects if each.reads is not None]
    return Traffic(
        sum(each.passes for each in effects),
        sum(each.draws for each in effects),
        sum(each.bytes for each in effects),
        sum(reads) if reads else None,
    )
