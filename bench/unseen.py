"""How wrong each step of depth of field is on scenes that nothing was tuned for.

``python -m bench --only unseen [--seeds 1 2 3]`` makes a scene for each seed; without ``--seeds``
for seed 1 and two that are drawn anew, and told. It draws a window of the left eye's image of
1832×1920 with every method, and prints its errors against views through the lens: cameras that are
moved over it and look through frusta sheared about the focus. These are ordinary cameras; nothing
of the engine's own lens is in them.

rms, edges      RMS error·10³ of display values, and where near things' discs reach
seams           pixels of wide blur that are off their 5×5 median by more than 2/255
cuts            pixels beside which the image steps by 2/255 more than the reference along most of
                24 pixels of a row or column: heads are rolled, so that few things in a scene do.
                As much as halves of the reference's views differ within 2 pixels is no step
flicker         99.9th percentile of the change of the error, of 255, while the head moves 3.3 mm
rivalry         mean difference·10³ of the errors at matching points of both eyes

The last two need three references; ``--still`` leaves them out.
"""

from __future__ import annotations

import secrets
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter, uniform_filter1d
from scipy.stats import qmc

from bench.table import Result
from bench.unseen_scenes import UnseenView, build
from vrcomfort.frame import Frame
from vrcomfort.geometry import Array, Fov, Pose, View, focal_length_px
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.brute_force import read_rgb
from vrcomfort.tradeoff.captures import Capture, capture_views, context, radius_px
from vrcomfort.tradeoff.cases import HEADSET_PX, ImageWindow, of_part, sub_frustum
from vrcomfort.tradeoff.error_measures import (
    EyeDepth,
    PinholeView,
    binocular_error,
    correspondence,
    flicker,
    off_median,
    regions,
)
from vrcomfort.tradeoff.image_error import LUMINANCE, hdr_flip, pixels_per_degree
from vrcomfort.tradeoff.methods import BlurMethod, methods, no_blur

WINDOW_PX = 448
TIME_S = 1.0
FRAME, PERIOD_NS = 90, 11_111_111
LONG_PX = 24
"""Of a row or column, along which the error of a cut is a step."""
STEP = 2 / 255
BESIDE_PX = 2
"""How far from a step another reference may have it."""
IPD_M, STEP_M = 0.063, 0.0033
"""To the right: the other eye, and a head a frame later (0.3 m/s)."""
MOST = 0.75
"""Of these pixels."""


class Case(NamedTuple):
    """A window of a made scene: what is drawn (wider by as far as discs reach), what is judged."""

    seed: int
    scene: Scene
    view: UnseenView
    window: ImageWindow
    drawn: ImageWindow
    whole_px: tuple[int, int]

    @property
    def part(self) -> float:
        """Return how wide the drawn window is, in widths of the whole image."""
        return self.drawn.width_px / self.whole_px[0]


def case(
    seed: int, folder: Path, *, whole_px: tuple[int, int] = HEADSET_PX, window_px: int = WINDOW_PX
) -> Case:
    """Make a seed's scene in `folder`, and put a window around one of its near things or lamps."""
    view = build(seed, folder / f"unseen_{seed}.glb")
    scene = load_scene(folder / f"unseen_{seed}.glb")
    rng = np.random.default_rng([32, seed])
    ahead = (view.targets - view.head.position) @ view.head.rotation
    tangent = ahead[:, :2] / -ahead[:, 2:]
    left, right, up, down = view.fov.tangents
    place = (tangent - [left, down]) / [right - left, up - down]
    corner = (place * whole_px - window_px / 2) // 32 * 32
    corner = np.clip(corner, 0, np.array(whole_px) - window_px)
    x, y = rng.permutation(corner)[0].astype(int).tolist()
    window = ImageWindow("unseen", x, y, window_px, window_px)
    reach_px = view.percent / 100 * whole_px[0]
    return Case(seed, scene, view, window, window.drawn(whole_px, reach_px), whole_px)


def drawn_with(found: Case, method: BlurMethod) -> Capture:
    """Draw the case's window with a method."""
    lens = method.condition.depth_of_field
    if lens is None:
        condition = found.view.condition().model_copy(update={"depth_of_field": None})
    else:
        steps = {"kernel": lens.kernel, "samples": lens.samples, "views": lens.views}
        condition = found.view.condition(**steps)
    eye = View(found.view.head, sub_frustum(found.view.fov, found.drawn, found.whole_px))
    frame = Frame(
        index=FRAME,
        predicted_display_time_ns=FRAME * PERIOD_NS,
        period_ns=PERIOD_NS,
        head_pose=found.view.head,
        views=(eye, eye),
        avatar_pose=Pose(),
        discontinuity=True,
    )
    condition = of_part(condition, found.part)
    # Without motion blur the frame before is not drawn.
    return capture_views(found.scene, condition, (frame, frame), found.drawn.size_px, eyes=1)[0]


def through_the_lens(found: Case, samples: int, *, seed: int = 0) -> Array:
    """Return the (h, w, 3) mean radiance of the judged window, seen from all over the lens."""
    mean: Array = halves_of_views(found, samples, seed=seed).mean(axis=0)
    return mean


def halves_of_views(found: Case, samples: int, *, seed: int = 0) -> Array:
    """Return (2, h, w, 3) means of the first and of the last half of views through the lens.

    Each half is seen from all over the lens. A camera at a point p of it keeps the plane of focus
    where it is: of its frustum, each tangent loses p / focus. The lens's radius is that of the law
    in dioptres: a defocus of `full_blur_dioptre` makes a disc of `percent` of the image's width.
    """
    view = found.view
    focal_px = focal_length_px(view.fov, found.whole_px)[0]
    radius_m = view.percent / 100 * found.whole_px[0] / focal_px / view.full_blur_dioptre
    fov = sub_frustum(view.fov, found.window, found.whole_px)
    drawing = ScenePass(context(), found.scene, found.window.size_px, velocity=False)
    total = np.zeros((2, found.window.height_px, found.window.width_px, 3))
    for index, (x, y) in enumerate(_disc(samples, seed) * radius_m):
        camera = EyeCamera(
            view.head @ Pose((x, y, 0.0)),
            _sheared(fov, x / view.focus_m, y / view.focus_m),
            world_from_head=view.head,
        )
        drawing.render(camera, TIME_S)
        total[2 * index // samples] += read_rgb(drawing.colour)
    return 2 * total / samples


def _sheared(fov: Fov, x: float, y: float) -> Fov:
    left, right, up, down = fov.tangents
    return Fov(*np.arctan([left - x, right - x, up - y, down - y]).tolist())


def _disc(samples: int, seed: int) -> Array:
    """Return (n, 2) points of the unit disc: scrambled Sobol points, equal areas."""
    turn, area = qmc.Sobol(2, seed=seed).random(samples).T
    radius = np.sqrt(area)
    return np.column_stack([radius * np.cos(2 * np.pi * turn), radius * np.sin(2 * np.pi * turn)])


def cuts(image: Array, true: Array, halves: Array) -> int:
    """Count pixels beside which an (h, w) luminance steps along rows or columns, and `true` less.

    A step is between two pixels, and unlike what the image does beside it: a slope is none. A
    reference is a sum of sharp images, each with its edges: where it has them is left to chance,
    and the (2, h, w) `halves` of its views tell how much.
    """
    found = 0
    for axis in (0, 1):
        steps, allowed, one, other = (_steps(each, axis) for each in (image, true, *halves))
        chance = maximum_filter1d(np.abs(one - other), 2 * BESIDE_PX + 1, axis=axis)
        for sign in (-1, 1):
            higher = sign * steps - np.maximum(sign * allowed, 0.0) - chance > STEP
            along = uniform_filter1d(
                higher.astype(np.float64), LONG_PX, axis=1 - axis, mode="constant"
            )
            found += int((along > MOST).sum())
    return found


def _steps(image: Array, axis: int) -> Array:
    size = [1, 1]
    size[axis] = 5
    slope = np.diff(image, axis=axis)
    found: Array = slope - median_filter(slope, size=size)
    return found


class _Seen(NamedTuple):
    """What an eye sees of a case: its truth, and the errors of images of it."""

    found: Case
    halves: Array
    sharp: Capture
    depth: EyeDepth

    @property
    def exposure(self) -> float:
        return self.found.scene.environment.exposure

    @property
    def true(self) -> Array:
        mean: Array = self.halves.mean(axis=0)
        return mean

    def draw(self, method: BlurMethod) -> Array:
        """Return the (h, w, 3) radiance that a method draws of the judged window."""
        blurred = drawn_with(self.found, method).blurred
        return np.asarray(blurred[self.found.window.within(self.found.drawn)], dtype=np.float64)

    def error(self, linear: Array) -> Array:
        """Return the error of display values."""
        return _shown(linear, self.exposure) - _shown(self.true, self.exposure)


def _seen(found: Case, right_m: float, samples: int) -> _Seen:
    """Look from an eye that is so far to the right."""
    view = replace(found.view, head=found.view.head @ Pose((right_m, 0.0, 0.0)))
    there = found._replace(view=view)
    sharp = drawn_with(there, no_blur("depth_of_field"))
    fov = sub_frustum(view.fov, found.window, found.whole_px)
    depth = sharp.depth[found.window.within(found.drawn)]
    eye = EyeDepth(view.head, fov, depth, sharp.camera.near_m)
    return _Seen(there, halves_of_views(there, samples), sharp, eye)


def errors(
    found: Case, *, samples: int, tried: Sequence[BlurMethod], still: bool = False
) -> list[dict[str, Any]]:
    """Return a row for each method, and one for a reference of half as many views."""
    here = _seen(found, 0.0, samples)
    moved = () if still else (_seen(found, STEP_M, samples), _seen(found, IPD_M, samples))
    judged = found.window.within(found.drawn)
    sharp = here.sharp
    radius = radius_px(sharp, of_part(found.view.condition(), found.part))
    pinhole = PinholeView(sharp.depth, radius, sharp.sharp * here.exposure, found.whole_px[0])
    edges = regions(pinhole)["near_rims"][judged]
    ppd = pixels_per_degree(found.view.fov, found.whole_px)

    true, halves = (_shown(each, here.exposure) @ LUMINANCE for each in (here.true, here.halves))

    def row(name: str, draw: Callable[[_Seen], Array]) -> dict[str, Any]:
        linear = draw(here)
        error = here.error(linear)
        flip = hdr_flip(linear * here.exposure, here.true * here.exposure, pixels_per_degree=ppd)
        measured = {
            "seed": found.seed,
            "method": name,
            "rms": _rms(error),
            "edges": _rms(error[edges]),
            "flip": flip,
            "seams": off_median(_shown(linear, here.exposure), radius[judged]).over_2,
            "cuts": cuts(_shown(linear, here.exposure) @ LUMINANCE, true, halves),
        }
        if moved:
            later, right = moved
            change = flicker(error, later.error(draw(later))) @ LUMINANCE
            measured["flicker"] = float(np.percentile(np.abs(change), 99.9) * 255)
            pairs = correspondence(here.depth, right.depth, margin_px=2)
            both = binocular_error(pairs, error, right.error(draw(right)))
            measured["rivalry"] = both.rivalry * 1e3
        return measured

    half = f"reference of {samples // 2}"
    rows = [row(half, lambda eye: through_the_lens(eye.found, samples // 2, seed=1))]
    return rows + [row(each.name, lambda eye, each=each: eye.draw(each)) for each in tried]


def _shown(linear: Array, exposure: float) -> Array:
    return np.asarray(tone_mapped(linear, exposure=exposure), dtype=np.float64)


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)) * 1e3) if error.size else 0.0


def measure(seeds: Sequence[int], *, samples: int, still: bool = False) -> Result:
    """Measure all steps and the methods of sources and engines on the scene of each seed.

    Parameters
    ----------
    seeds
        1 and two that are drawn now, where there are none.
    samples
        Views of each reference.
    still
        Leave out flicker and rivalry.
    """
    seeds = seeds or [1, *(2 + secrets.randbelow(1_000_000) for _ in range(2))]
    tried = [each for each in methods("depth_of_field") if each.family != "dial"]
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            row
            for seed in seeds
            for row in errors(case(seed, Path(folder)), samples=samples, tried=tried, still=still)
        ]
    notes = [
        f"Seeds {', '.join(map(str, seeds))}; windows of {WINDOW_PX}×{WINDOW_PX} of the left eye's "
        f"{HEADSET_PX[0]}×{HEADSET_PX[1]}; references of {samples} views.",
        "`rms` and `edges`: of display values, ·10³; `edges` where discs of near things reach.",
        f"Renderer: {context().info['GL_RENDERER']}.",
    ]
    return Result("Errors on unseen scenes", rows, notes)
