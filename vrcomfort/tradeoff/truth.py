"""The two references of a case: brute force (R1) and the best of post-processes (R2), kept."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.ideal_scatter import ideal_scatter
from vrcomfort.optics.lens_sampling import lens_and_shutter
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.image_error import HIGHLIGHT, rms
from vrcomfort.render.reference import Accumulator, Reference
from vrcomfort.tradeoff.cases import (
    Case,
    Scope,
    drawn_px,
    eyes_of,
    frames,
    reference_condition,
    samples_of,
)
from vrcomfort.tradeoff.shots import Shot, context, pinhole, shoot
from vrcomfort.tradeoff.store import Store, key_of, scene_and_hash
from vrcomfort.tradeoff.walk import time_s

SAVE_EVERY_S = 30.0
SAME_RMS = 1e-4
"""Pinhole images that differ by no more show the same: a tenth of the errors of the best methods,
and more than the rounding of another order of drawing."""

MOST_SCATTER_SAMPLES = 256
"""R2 has no small lights that need more: its image is one of W × H pixels."""


class Truth(NamedTuple):
    """References of one eye: (h, w, 3) each, bottom row first."""

    halves: tuple[Array, Array]
    scatter: Array
    samples: int
    """Of R1."""


class Drawn(NamedTuple):
    """What drawing a reference took."""

    samples: int
    reused: int


def draw_reference(case: Case, scope: Scope, eye: int, store: Store) -> Drawn:
    """Bring an eye's R1 to the samples it is to have, from where it was left; keep it."""
    _, drawn = _accumulated(case, scope, base_shots(case, scope)[eye], store)
    return drawn


def truths(case: Case, scope: Scope, shots: tuple[Shot, ...], store: Store) -> tuple[Truth, ...]:
    """Return the references of the eyes, whose shots show what a post-process would know."""
    return tuple(_truth(case, scope, shot, store) for shot in shots)


@lru_cache(maxsize=2)
def base_shots(case: Case, scope: Scope) -> tuple[Shot, ...]:
    """Draw what the references are references of."""
    scene, _ = scene_and_hash(case.scene)
    condition, size_px = reference_condition(case, scope), drawn_px(case, scope)
    return shoot(scene, condition, frames(case, scope), size_px, eyes=eyes_of(case, scope))


def _truth(case: Case, scope: Scope, shot: Shot, store: Store) -> Truth:
    sums, _ = _accumulated(case, scope, shot, store)
    scatter = _scattered(shot, reference_condition(case, scope), samples_of(case, scope))
    return Truth(sums.halves, scatter, sums.samples)


def _scattered(shot: Shot, condition: Condition, samples: int) -> Array:
    points = lens_and_shutter(
        min(samples, MOST_SCATTER_SAMPLES),
        lens=condition.depth_of_field is not None,
        shutter=condition.motion_blur is not None,
        seed=0,
    )
    return ideal_scatter(pinhole(shot, condition), points)


def _accumulated(case: Case, scope: Scope, shot: Shot, store: Store) -> tuple[Accumulator, Drawn]:
    scene, _ = scene_and_hash(case.scene)
    condition = reference_condition(case, scope)
    focus_m = condition.focus.fixed_m
    reference = Reference(context(), scene, condition, drawn_px(case, scope))
    view = shot.camera, time_s(frames(case, scope)[1]), shot.previous
    facts = reference.identity(*view, focus_m=focus_m)
    device = str(context().info["GL_RENDERER"])
    key = key_of("reference", case.scene, facts, device)
    wanted = samples_of(case, scope)
    sums = _read(store, key, drawn_px(case, scope), wanted, shot.sharp)
    reused = sums.samples
    if reused < wanted:
        keeper = _Keeper(store, f"{key}-{wanted}", shot.sharp)
        try:
            reference.render(*view, focus_m=focus_m, samples=wanted, start=sums, on_sample=keeper)
        finally:
            keeper.save(sums)
    return sums, Drawn(sums.samples, reused)


def _read(
    store: Store, key: str, size_px: tuple[int, int], wanted: int, sharp: NDArray[np.floating]
) -> Accumulator:
    """Return where to go on: the most samples that are kept, and no more than are wanted.

    Each number of samples has a file of its own, so that what a run finds does not depend on the
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
    """Return whether a reference was drawn of what this pinhole image shows."""
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
