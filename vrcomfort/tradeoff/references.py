"""The two references of a case: brute force (R1) and the best of post-processes (R2).

R1 draws the scene for every sample of lens and shutter (`brute_force`), and is kept in the
store. R2 (`ideal_scatter`) is computed from the pinhole image.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array, focal_length_px
from vrcomfort.optics.lens_sampling import lens_and_shutter
from vrcomfort.protocol.conditions import Condition
from vrcomfort.tradeoff.brute_force import Accumulator, Reference
from vrcomfort.tradeoff.captures import Capture, capture_views, context, radius_px
from vrcomfort.tradeoff.cases import (
    Case,
    Scope,
    drawn_px,
    eyes_of,
    frames,
    reference_condition,
    samples_of,
)
from vrcomfort.tradeoff.image_error import HIGHLIGHT, rms
from vrcomfort.tradeoff.store import Store, key_of, scene_and_hash
from vrcomfort.tradeoff.walk import time_s

SAVE_EVERY_S = 30.0
SAME_RMS = 1e-4
"""Pinhole images that differ by no more show the same: a tenth of the errors of the best methods,
and more than the rounding of another order of drawing."""

MOST_SCATTER_SAMPLES = 256
"""R2 has no small lights that need more: its image is one of W × H pixels."""


class EyeReference(NamedTuple):
    """References of one eye: (h, w, 3) each, bottom row first."""

    halves: tuple[Array, Array]
    scatter: Array
    samples: int
    """Of R1."""


class DrawnSamples(NamedTuple):
    """Samples of a reference, and those of earlier runs among them."""

    samples: int
    reused: int


def draw_reference(case: Case, scope: Scope, eye: int, store: Store) -> DrawnSamples:
    """Bring an eye's R1 to the samples it is to have, from where it was left; keep it."""
    _, drawn = _accumulated(case, scope, base_captures(case, scope)[eye], store)
    return drawn


def references_of(
    case: Case, scope: Scope, captures: tuple[Capture, ...], store: Store
) -> tuple[EyeReference, ...]:
    """Return the references of the eyes; their captures are the input of a post-process."""
    return tuple(_reference_of(case, scope, capture, store) for capture in captures)


@lru_cache(maxsize=2)
def base_captures(case: Case, scope: Scope) -> tuple[Capture, ...]:
    """Capture the views of a case's references."""
    scene, _ = scene_and_hash(case.scene)
    condition, size_px = reference_condition(case, scope), drawn_px(case, scope)
    return capture_views(scene, condition, frames(case, scope), size_px, eyes=eyes_of(case, scope))


def _reference_of(case: Case, scope: Scope, capture: Capture, store: Store) -> EyeReference:
    sums, _ = _accumulated(case, scope, capture, store)
    scatter = _scattered(capture, reference_condition(case, scope), samples_of(case, scope))
    return EyeReference(sums.halves, scatter, sums.samples)


def _scattered(capture: Capture, condition: Condition, samples: int) -> Array:
    points = lens_and_shutter(
        min(samples, MOST_SCATTER_SAMPLES),
        lens=condition.depth_of_field is not None,
        shutter=condition.motion_blur is not None,
        seed=0,
    )
    return ideal_scatter(pinhole(capture, condition), points)


def pinhole(capture: Capture, condition: Condition) -> Pinhole:
    """Return the input of a post-process: an eye's image, depth, radii and streaks."""
    height, width = capture.depth.shape
    focal_x, focal_y = focal_length_px(capture.camera.fov, (width, height))
    streak = np.zeros((height, width, 2))
    if condition.motion_blur is not None and capture.velocity_px is not None:
        streak = capture.velocity_px.astype(np.float64) * condition.motion_blur.shutter_fraction
    radius = radius_px(capture, condition)
    return Pinhole(capture.sharp, capture.depth, radius, streak, focal_y / focal_x)


def _accumulated(
    case: Case, scope: Scope, capture: Capture, store: Store
) -> tuple[Accumulator, DrawnSamples]:
    scene, _ = scene_and_hash(case.scene)
    condition = reference_condition(case, scope)
    focus_m = condition.focus.fixed_m
    reference = Reference(context(), scene, condition, drawn_px(case, scope))
    view = capture.camera, time_s(frames(case, scope)[1]), capture.previous
    facts = reference.identity(*view, focus_m=focus_m)
    device = str(context().info["GL_RENDERER"])
    key = key_of("reference", case.scene, facts, device)
    wanted = samples_of(case, scope)
    sums = _read(store, key, drawn_px(case, scope), wanted, capture.sharp)
    reused = sums.samples
    if reused < wanted:
        keeper = _Keeper(store, f"{key}-{wanted}", capture.sharp)
        try:
            reference.render(*view, focus_m=focus_m, samples=wanted, start=sums, on_sample=keeper)
        finally:
            keeper.save(sums)
    return sums, DrawnSamples(sums.samples, reused)


def _read(
    store: Store, key: str, size_px: tuple[int, int], wanted: int, sharp: NDArray[np.floating]
) -> Accumulator:
    """Return where to go on: the most samples that are kept, and no more than are wanted.

    Each number of samples has a file of its own, so that the result of a run does not depend on the
    runs before it. A reference of another picture than the present one, for the scene or the code
    that draws it has changed, is none: the pinhole image that is kept beside it tells.
    """
    kept = [found for each in store.keys(key) if (found := store.read(each)) is not None]
    fitting = [each for each in kept if each["samples"] <= wanted and _is_of(each, sharp)]
    if not fitting:
        return Accumulator(size_px)
    most = max(fitting, key=lambda each: int(each["samples"]))
    return Accumulator(size_px, most["sums"], int(most["samples"]))


def _is_of(kept: Mapping[str, NDArray[Any]], sharp: NDArray[np.floating]) -> bool:
    """Return whether a kept reference belongs to this pinhole image."""
    if "sharp" not in kept or kept["sharp"].shape != sharp.shape:
        return False
    return rms(np.minimum(kept["sharp"], HIGHLIGHT), np.minimum(sharp, HIGHLIGHT)) <= SAME_RMS


class _Keeper:
    """Keeps sums every now and then, so that little is lost when the run is stopped."""

    def __init__(self, store: Store, key: str, sharp: NDArray[np.floating]) -> None:
        self._store, self._key = store, key
        self._sharp = sharp.astype(np.float16)
        self._saved_s = time.monotonic()

    def __call__(self, sums: Accumulator) -> None:
        if time.monotonic() - self._saved_s > SAVE_EVERY_S:
            self.save(sums)

    def save(self, sums: Accumulator) -> None:
        samples = np.array(sums.samples)
        self._store.write(self._key, sums=sums.sums, samples=samples, sharp=self._sharp)
        self._saved_s = time.monotonic()


WIDEST_CRACK_PX = 1.0
"""Neighbours whose blurs differ by more than this belong to different surfaces."""


class Pinhole(NamedTuple):
    """Input of a post-process: one image with depth, radius and streak of each pixel.

    Parameters
    ----------
    image
        (h, w, 3) linear radiance, bottom row first.
    depth
        (h, w) reverse-Z depth: the larger one hides the smaller.
    radius_px
        (h, w) signed radius of the circle of confusion, in pixels of image width.
    streak_px
        (h, w, 2) motion while the shutter is open, +x right, +y up.
    pixel_aspect
        Vertical over horizontal pixels per radian.
    """

    image: NDArray[np.floating]
    depth: NDArray[np.floating]
    radius_px: Array
    streak_px: NDArray[np.floating]
    pixel_aspect: float = 1.0


def ideal_scatter(pinhole: Pinhole, samples: ArrayLike, /) -> Array:
    """Return (h, w, 3): the mean over samples of the pinhole image's nearest pixels.

    Every pixel is a square of its surface, at its depth. A sample (x, y of the unit disc, time in
    [−½, ½)) moves it by ``radius · (x, y) + streak · time``; the nearest wins. So each pixel's
    light is spread evenly over its disc and along its streak, except where something nearer
    hides it from that part of the lens at that time. Where a sample looks at what the pinhole image
    did not see, the farthest of the four surfaces next to that place (along row and column) is
    taken to go on behind the nearer ones: a post-process cannot know better.

    Squares grow by what they move relative to their neighbours (up to 1 px), so that slanted
    surfaces do not tear; wider gaps are edges of surfaces.

    Parameters
    ----------
    samples
        (n, 3), as of `optics.lens_sampling.lens_and_shutter`.
    """
    height, width, _ = pinhole.image.shape
    # Reverse-Z: ascending depth is farthest first, so that nearer squares are written last.
    order = np.argsort(pinhole.depth, axis=None, kind="stable")
    colours = pinhole.image.reshape(-1, 3)[order].astype(np.float64)
    rows, columns = np.divmod(order, width)
    connected = _connected(pinhole, 0), _connected(pinhole, 1)
    total = np.zeros((height, width, 3))
    samples = np.asarray(samples, dtype=np.float64)
    for x, y, shutter in samples:
        shift_x = pinhole.radius_px * x + pinhole.streak_px[..., 0] * shutter
        shift_y = pinhole.radius_px * y * pinhole.pixel_aspect + pinhole.streak_px[..., 1] * shutter
        places = [
            _covered(base + shift.reshape(-1)[order], _growth(shift, connected).reshape(-1)[order])
            for base, shift in ((columns, shift_x), (rows, shift_y))
        ]
        total += colours[_continued(_nearest(places[0], places[1], (height, width)))]
    return total / len(samples)


def _connected(pinhole: Pinhole, axis: int) -> NDArray[np.bool_]:
    """Return whether each pixel and the next along an axis belong to one surface."""
    spread = [np.abs(np.diff(pinhole.radius_px, axis=axis))]
    spread += [np.abs(np.diff(pinhole.streak_px[..., i], axis=axis)) for i in (0, 1)]
    connected: NDArray[np.bool_] = np.max(spread, axis=0) <= WIDEST_CRACK_PX
    return connected


def _growth(shift: Array, connected: tuple[NDArray[np.bool_], ...]) -> Array:
    """Return (h, w): how much farther than itself a pixel's square must reach to meet the next."""
    growth = np.zeros_like(shift)
    for axis in (0, 1):
        gap = np.abs(np.diff(shift, axis=axis)) * connected[axis]
        head, tail = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        head[axis], tail[axis] = (1, 0), (0, 1)
        growth = np.maximum(growth, np.maximum(np.pad(gap, head), np.pad(gap, tail)))
    return growth


def _covered(center: Array, growth: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first and last pixel centre that a square covers: one, or two if it has grown."""
    half = (1 + growth) / 2
    first = np.floor(center - half).astype(np.intp) + 1
    last = np.maximum(first, np.floor(center + half).astype(np.intp))
    return first, last


def _nearest(
    columns: tuple[NDArray[np.intp], NDArray[np.intp]],
    rows: tuple[NDArray[np.intp], NDArray[np.intp]],
    shape: tuple[int, int],
) -> NDArray[np.intp]:
    """Return (h, w) indices of the nearest squares, −1 for none; squares come farthest first."""
    height, width = shape
    x = np.stack([columns[0], columns[1], columns[0], columns[1]], axis=-1)
    y = np.stack([rows[0], rows[0], rows[1], rows[1]], axis=-1)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    index = np.broadcast_to(np.arange(len(x))[:, None], x.shape)
    seen = np.full(shape, -1, dtype=np.intp)
    # Of several values for one pixel NumPy keeps the last: the nearest.
    seen[y[inside], x[inside]] = index[inside]
    return seen


def _continued(seen: NDArray[np.intp]) -> NDArray[np.intp]:
    """Fill holes (−1) with the farthest (least) index next to them in four directions."""
    if seen.min() >= 0:
        return seen
    nothing = seen.size
    found = np.full_like(seen, nothing)
    for turned, filled in ((seen, found), (seen.T, found.T)):
        for view, out in ((turned, filled), (turned[:, ::-1], filled[:, ::-1])):
            np.minimum(out, _last_seen(view, nothing), out=out)
    continued = np.where(seen >= 0, seen, found)
    # A row and a column without anything: any surface at all, the farthest.
    return np.where(continued == nothing, 0, continued)


def _last_seen(seen: NDArray[np.intp], nothing: int) -> NDArray[np.intp]:
    """Return for each place the last index at or before it in its row that is seen."""
    column = np.where(seen >= 0, np.arange(seen.shape[1]), -1)
    last = np.maximum.accumulate(column, axis=1)
    rows = np.arange(seen.shape[0])[:, None]
    return np.where(last >= 0, seen[rows, np.maximum(last, 0)], nothing)
