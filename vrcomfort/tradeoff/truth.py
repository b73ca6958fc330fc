"""The two references of a case: brute force (R1) and the best of post-processes (R2), kept."""

from __future__ import annotations

import time
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.optics.ideal_scatter import ideal_scatter
from vrcomfort.optics.sampling import lens_and_shutter
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.reference import Accumulator, Reference
from vrcomfort.tradeoff.cases import Case, Scope, frames, samples_of
from vrcomfort.tradeoff.methods import base_condition
from vrcomfort.tradeoff.shots import Shot, context, pinhole, shoot
from vrcomfort.tradeoff.store import Store, key_of, reference_code, scene_and_hash
from vrcomfort.tradeoff.walk import time_s

SAVE_EVERY_S = 5.0
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


def truths(case: Case, scope: Scope, shots: tuple[Shot, Shot], store: Store) -> tuple[Truth, Truth]:
    """Return the references of both eyes, whose shots show what a post-process would know."""
    left, right = (_truth(case, scope, shot, store) for shot in shots)
    return left, right


@lru_cache(maxsize=2)
def base_shots(case: Case, scope: Scope) -> tuple[Shot, Shot]:
    """Draw what the references are references of."""
    scene, _ = scene_and_hash(case.scene)
    return shoot(scene, base_condition(case.effect), frames(case, scope), scope.size_px)


def _truth(case: Case, scope: Scope, shot: Shot, store: Store) -> Truth:
    sums, _ = _accumulated(case, scope, shot, store)
    scatter = _scattered(shot, base_condition(case.effect), samples_of(case, scope))
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
    scene, scene_hash = scene_and_hash(case.scene)
    condition = base_condition(case.effect)
    focus_m = condition.focus.fixed_m
    reference = Reference(context(), scene, condition, scope.size_px)
    view = shot.camera, time_s(frames(case, scope)[1]), shot.previous
    facts = reference.identity(*view, focus_m=focus_m)
    device = str(context().info["GL_RENDERER"])
    key = key_of("reference", scene_hash, facts, reference_code(), device)
    wanted = samples_of(case, scope)
    sums = _read(store, key, scope, wanted)
    reused = sums.samples
    if reused < wanted:
        keeper = _Keeper(store, f"{key}-{wanted}")
        try:
            reference.render(*view, focus_m=focus_m, samples=wanted, start=sums, on_sample=keeper)
        finally:
            keeper.save(sums)
    return sums, Drawn(sums.samples, reused)


def _read(store: Store, key: str, scope: Scope, wanted: int) -> Accumulator:
    """Return where to go on: the most samples that are kept, and no more than are wanted.

    Each number of samples has a file of its own (a file without a number in its name is read too),
    so that what a run finds does not depend on the runs before it.
    """
    kept = [found for each in store.keys(key) if (found := store.read(each)) is not None]
    fitting = [each for each in kept if each["samples"] <= wanted]
    if not fitting:
        return Accumulator(scope.size_px)
    most = max(fitting, key=lambda each: int(each["samples"]))
    return Accumulator(scope.size_px, most["sums"], int(most["samples"]))


class _Keeper:
    """Keeps sums every few seconds, so that little is lost when the run is stopped."""

    def __init__(self, store: Store, key: str) -> None:
        self._store, self._key = store, key
        self._saved_s = time.monotonic()

    def __call__(self, sums: Accumulator) -> None:
        if time.monotonic() - self._saved_s > SAVE_EVERY_S:
            self.save(sums)

    def save(self, sums: Accumulator) -> None:
        self._store.write(self._key, sums=sums.sums, samples=np.array(sums.samples))
        self._saved_s = time.monotonic()
