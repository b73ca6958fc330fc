"""What one eye's image sends through memory, effect by effect: `gpu.traffic` around its passes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import lru_cache
from typing import Any

import moderngl
import numpy as np

from vrcomfort.frame import EYE_HEIGHT_M, Frame
from vrcomfort.geometry import Gaze, Pose, View, yaw_pitch_roll
from vrcomfort.gpu import shaders
from vrcomfort.gpu.traffic import Draw, Recorder, Traffic, added_up
from vrcomfort.headset.playback import default_fovs
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.condition_passes import RESOLVE
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.tradeoff.cases import Case, Scope, condition_of, frames
from vrcomfort.tradeoff.methods import Method, no_blur
from vrcomfort.tradeoff.passes import leave_out_records, outermost
from vrcomfort.tradeoff.shots import context
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.timing import NO_EFFECT
from vrcomfort.tradeoff.walk import REFRESH_HZ, time_s

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
) -> dict[str, Traffic]:
    """Draw the left eye of a frame, and return what each kind of pass sent through memory.

    Parameters
    ----------
    pair
        The frame before, None where nothing moves, and the one to look at.
    count_reads
        Compiles shaders that count their texture reads: slower, the same pictures.
    records
        Whether that is counted too which only the record of limits needs.
    """
    renderer = StereoRenderer(ctx, size_px, eyes=1)
    with shaders.counting_reads() if count_reads else nullcontext():
        renderer.build(scene, condition)
    if not records:
        leave_out_records(renderer.parts())
    before, frame = pair
    if before is not None:
        renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)
    recorder = Recorder(ctx)
    with recorder.recording(), _sorted_by_pass(recorder, renderer) as found:
        renderer.render(frame, time_s(frame))
    renderer.release()
    sums = {name: added_up(draws) for name, draws in found.items()}
    if count_reads:
        return sums
    return {name: each._replace(reads=None) for name, each in sums.items()}


def traffic_of_method(method: Method, case: Case, scope: Scope) -> dict[str, Any]:
    """Return what a method's effects send through memory for one eye's whole image.

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
    """Return what is an effect's.

    Radii that are written where samples are resolved move no bytes that are not moved without them.
    """
    return {name: each for name, each in found.items() if name not in {*NO_EFFECT, RESOLVE}}


def of_effects(found: dict[str, Traffic]) -> Traffic:
    """Return what the effects of an eye's image amount to."""
    effects = by_effect(found).values()
    reads = [each.reads for each in effects if each.reads is not None]
    return Traffic(
        sum(each.passes for each in effects),
        sum(each.draws for each in effects),
        sum(each.bytes for each in effects),
        sum(reads) if reads else None,
    )


@contextmanager
def _sorted_by_pass(
    recorder: Recorder, renderer: StereoRenderer
) -> Iterator[dict[str, list[Draw]]]:
    """Sort the draws by the outermost pass that makes them."""
    found: dict[str, list[Draw]] = {}

    def around(name: str, draw: Any) -> None:
        first = len(recorder.draws)
        draw()
        found.setdefault(name, []).extend(recorder.draws[first:])

    with outermost(around, renderer.parts()):
        yield found
