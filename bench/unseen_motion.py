"""How wrong motion blur is on scenes that nothing was tuned for, and what it costs there.

``python -m bench --only unseen_motion [--seeds 1 2 3]`` makes a scene for each seed, through which
things fly and turn, and a head that stands, turns or walks; without ``--seeds`` for seed 1 and two
that are drawn anew, and told. The reference is the mean of images with the shutter open for an
instant each: ordinary cameras on the head's way, with nothing of the engine's motion vectors.

rms, edges      RMS error·10³ of display values, and within 12 px of where velocities jump
reads, bytes    for each pixel: see `vrcomfort.gpu.traffic`
cpu             processor time of the passes, of that of `per_pixel` with 8 samples: median
"""

from __future__ import annotations

import secrets
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from bench.motion_blur import METHODS, blur_pass, processor_s, traffic
from bench.table import Result
from bench.unseen_scenes import build
from vrcomfort.frame import Frame
from vrcomfort.geometry import Array, Fov, Pose, View
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.effects.effect import EyeFrame
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.rotations import axis_angle, normalize, quaternion_multiply
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.brute_force import read_rgb
from vrcomfort.tradeoff.captures import Capture, capture_views, context
from vrcomfort.tradeoff.methods import SHUTTER, base_condition

SIZE_PX = (916, 960)
"""Half of a headset's image each way."""
MARGIN_PX = 48
"""At the image's rim, which is not judged: no method knows what comes in from outside."""
FRAME, PERIOD_NS = 90, 11_111_111
JUMP_PX, BESIDE_PX = 1.0, 12


class Motion(NamedTuple):
    """A head's motion in a frame period: `turn_rad` about an axis of the world, and a step."""

    now: Pose
    axis: Array
    turn_rad: float
    step_m: Array

    def at(self, periods: float) -> Pose:
        """Return world-from-head so many periods after the frame."""
        turn = axis_angle(self.axis, self.turn_rad * periods)
        place = self.now.position + periods * self.step_m
        return Pose(place, quaternion_multiply(turn, self.now.orientation))


class MovingCase(NamedTuple):
    """A made scene, and a head that moves in it."""

    seed: int
    scene: Scene
    fov: Fov
    motion: Motion


def moving_case(seed: int, folder: Path) -> MovingCase:
    """Make a seed's scene in `folder`, and a head's motion: one in four stands still."""
    view = build(seed, folder / f"passing_{seed}.glb", passing=True)
    rng = np.random.default_rng([33, seed])
    moves = rng.random() > 0.25
    turn_deg_s = moves * rng.uniform(0, 180)
    speed_m_s = moves * rng.uniform(0, 2)
    axis = normalize(rng.normal(size=3) * rng.permutation([1, 0.3, 0.1]))
    way = normalize(rng.normal(size=3) * [1, 0.1, 1])
    seconds = PERIOD_NS / 1e9
    step_m = speed_m_s * seconds * way
    motion = Motion(view.head, axis, float(np.radians(turn_deg_s * seconds)), step_m)
    return MovingCase(seed, load_scene(folder / f"passing_{seed}.glb"), view.fov, motion)


def through_the_shutter(case: MovingCase, samples: int, size_px: tuple[int, int]) -> Array:
    """Return the (h, w, 3) mean radiance while the shutter is open for a whole period."""
    drawing = ScenePass(context(), case.scene, size_px, velocity=False)
    total = np.zeros((size_px[1], size_px[0], 3))
    for sample in range(samples):
        periods = (sample + 0.5) / samples - 0.5
        head = case.motion.at(periods)
        camera = EyeCamera(head, case.fov, world_from_head=head)
        drawing.render(camera, (FRAME + periods) * PERIOD_NS / 1e9)
        total += read_rgb(drawing.colour)
    return total / samples


def captured(case: MovingCase, size_px: tuple[int, int]) -> Capture:
    """Draw the frame, sharp, with its depth and velocity."""
    frames = [_frame(case, index) for index in (0, -1)]
    pair = frames[1], frames[0]
    return capture_views(case.scene, base_condition("motion_blur"), pair, size_px, eyes=1)[0]


def _frame(case: MovingCase, periods: int) -> Frame:
    head = case.motion.at(periods)
    eye = View(head, case.fov)
    return Frame(
        index=FRAME + periods,
        predicted_display_time_ns=(FRAME + periods) * PERIOD_NS,
        period_ns=PERIOD_NS,
        head_pose=head,
        views=(eye, eye),
        avatar_pose=Pose(),
    )


def jumps(velocity_px: Array) -> NDArray[np.bool_]:
    """Return (h, w) which pixels are near places where velocities of neighbours jump."""
    size = (3, 3, 1)
    change = maximum_filter(velocity_px, size=size) - minimum_filter(velocity_px, size=size)
    far = np.hypot(*np.moveaxis(change, -1, 0)) > JUMP_PX
    return np.asarray(maximum_filter(far, size=2 * BESIDE_PX + 1))


def errors(
    case: MovingCase, *, samples: int, rounds: int, size_px: tuple[int, int] = SIZE_PX
) -> list[dict[str, Any]]:
    """Return a row for each method, one for no blur, and one for half the reference's images."""
    capture = captured(case, size_px)
    exposure = case.scene.environment.exposure
    inner = (slice(MARGIN_PX, -MARGIN_PX),) * 2
    if capture.velocity_px is None:
        raise RuntimeError("motion blur has no motion vectors")
    edges = jumps(np.asarray(capture.velocity_px, dtype=np.float64))[inner]
    true = _shown(through_the_shutter(case, samples, size_px), exposure)[inner]
    frame = EyeFrame(0, 0, Pose(), capture.camera, capture.previous)
    settings = {name: {**SHUTTER, **METHODS[name]} for name in METHODS}
    passes = {name: blur_pass(context(), capture, settings[name]) for name in METHODS}
    seconds = processor_s({k: lambda p=p: p.render(frame) for k, p in passes.items()}, rounds)

    def row(name: str, linear: Array, **cost: Any) -> dict[str, Any]:
        error = _shown(linear, exposure)[inner] - true
        nothing = {"reads": 0.0, "bytes": 0.0, "cpu": 0.0}
        found = {"rms": _rms(error), "edges": _rms(error[edges])}
        return {"seed": case.seed, "method": name, **found, **nothing, **cost}

    half = through_the_shutter(case, samples // 2, size_px)
    rows = [row(f"reference of {samples // 2}", half), row("no blur", capture.sharp)]
    for name, effect in passes.items():
        reads, moved = traffic(capture, settings[name], frame)
        cpu = float(np.median(seconds[name] / seconds["per_pixel 8"]))
        rows.append(row(name, read_rgb(effect.target), reads=reads, bytes=moved, cpu=cpu))
    return rows


def _shown(linear: Array, exposure: float) -> Array:
    return np.asarray(tone_mapped(linear, exposure=exposure), dtype=np.float64)


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)) * 1e3) if error.size else 0.0


def measure(seeds: Sequence[int], *, samples: int, rounds: int) -> Result:
    """Measure all methods on the scene of each seed; 1 and two drawn now, where there are none."""
    seeds = seeds or [1, *(2 + secrets.randbelow(1_000_000) for _ in range(2))]
    with tempfile.TemporaryDirectory() as folder:
        cases = (moving_case(seed, Path(folder)) for seed in seeds)
        rows = [row for case in cases for row in errors(case, samples=samples, rounds=rounds)]
    notes = [
        f"Seeds {', '.join(map(str, seeds))}; the left eye's {SIZE_PX[0]}×{SIZE_PX[1]} without its "
        f"outer {MARGIN_PX} px; references of {samples} instants; the shutter is fully open.",
        "`rms` and `edges`: of display values, ·10³. `reads`, `bytes`: a pixel. `cpu`: of that of "
        "`per_pixel 8`.",
        f"Renderer: {context().info['GL_RENDERER']}.",
    ]
    return Result("Errors of motion blur on unseen scenes", rows, notes)
