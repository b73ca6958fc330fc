"""The errors of every method on one case."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.render.image_error import (
    hdr_flip,
    judged,
    margin_px,
    pixels_per_degree,
    rms,
    ssim,
    sure,
)
from vrcomfort.scene.data import Scene
from vrcomfort.tradeoff.binocular import (
    Correspondence,
    binocular_error,
    correspondence,
    radius_mismatch_px,
)
from vrcomfort.tradeoff.cases import Case, Scope, frames
from vrcomfort.tradeoff.methods import Method, base_condition, methods, pick
from vrcomfort.tradeoff.shots import context, radius_px, shoot
from vrcomfort.tradeoff.store import Store, key_of, method_code, scene_and_hash
from vrcomfort.tradeoff.truth import Truth, base_shots, truths

SCATTER = "ideal scatter (R2)"


class Measured(NamedTuple):
    """What is known of a case."""

    case: Case
    rows: list[dict[str, Any]]
    """One for each method, and one for R2."""
    pictures: dict[str, NDArray[np.float32]]
    """Left eye: (h, w, 3) linear light, top row first, of the reference and of each method."""
    reused: int
    """How many rows were there from an earlier run."""


class _View(NamedTuple):
    """What errors are measured against: both eyes."""

    scene: Scene
    truth: tuple[Truth, Truth]
    pixels_per_degree: float
    pairs: Correspondence
    coc_mismatch_px: float
    sure: tuple[NDArray[np.bool_], NDArray[np.bool_]]


def measure(
    case: Case, scope: Scope, store: Store, todo: Sequence[Method] | None = None
) -> Measured:
    """Draw and judge methods (those of the scope); what is in the store is taken from there."""
    if todo is None:
        todo = pick(methods(case.effect, quick=scope.quick), scope.methods)
    keys = {method.name: _key(case, scope, method) for method in todo}
    kept = {name: store.read(key) for name, key in keys.items()}
    reference_key = _key(case, scope, None)
    base = store.read(reference_key)
    reused = sum(each is not None for each in kept.values())
    if base is None or reused < len(todo):
        view = _view(case, scope, store)
        base = _reference_facts(view)
        store.write(reference_key, **base)
        for method in todo:
            if kept[method.name] is None:
                kept[method.name] = found = _method_facts(case, scope, method, view)
                store.write(keys[method.name], **found)
    everything = {SCATTER: base, **{name: each for name, each in kept.items() if each}}
    rows = [{**asdict(case), **json.loads(str(each["row"]))} for each in everything.values()]
    pictures = {name: each["picture"] for name, each in everything.items()}
    return Measured(case, rows, {"reference": base["reference"], **pictures}, reused)


def _key(case: Case, scope: Scope, method: Method | None) -> str:
    facts = asdict(case), scope.size_px, scope.samples, scope.poses, method_code()
    condition = method.condition.model_dump(mode="json") if method else None
    _, scene_hash = scene_and_hash(case.scene)
    device = str(context().info["GL_RENDERER"])
    return key_of("method", *facts, condition, method and method.name, scene_hash, device)


def _view(case: Case, scope: Scope, store: Store) -> _View:
    scene, _ = scene_and_hash(case.scene)
    shots = base_shots(case, scope)
    truth = truths(case, scope, shots, store)
    condition = base_condition(case.effect)
    pairs = correspondence(shots[0].eye, shots[1].eye, margin_px=margin_px(scope.size_px))
    radii = [radius_px(shot, condition) for shot in shots]
    exposure = scene.environment.exposure
    return _View(
        scene,
        truth,
        pixels_per_degree(shots[0].camera.fov, scope.size_px),
        pairs,
        radius_mismatch_px(pairs, *radii),
        (sure(truth[0].halves, exposure=exposure), sure(truth[1].halves, exposure=exposure)),
    )


def _method_facts(case: Case, scope: Scope, method: Method, view: _View) -> dict[str, NDArray[Any]]:
    shots = shoot(view.scene, method.condition, frames(case, scope), scope.size_px)
    images = shots[0].blurred, shots[1].blurred
    row = {"method": method.name, "family": method.family, "step": method.step}
    return {
        "row": np.array(json.dumps({**row, **_errors(images, view)})),
        "picture": images[0][::-1],
    }


def _reference_facts(view: _View) -> dict[str, NDArray[Any]]:
    left, right = view.truth
    row = {"method": SCATTER, "family": "none", "step": None}
    errors = _errors((left.scatter, right.scatter), view)
    mean = (left.halves[0] + left.halves[1]) / 2
    return {
        "row": np.array(json.dumps({**row, **errors})),
        "picture": left.scatter[::-1].astype(np.float32),
        "reference": mean[::-1].astype(np.float32),
    }


def _errors(images: tuple[NDArray[Any], NDArray[Any]], view: _View) -> dict[str, Any]:
    """Return the errors of a stereo image, means over both eyes (RMS: quadratic)."""
    eyes = [_eye_errors(images[eye], view, eye) for eye in (0, 1)]
    row = {name: float(np.mean([each[name] for each in eyes])) for name in eyes[0]}
    for name in ("rms", "reference_rms", "filter_rms"):
        row[name] = math.sqrt(float(np.mean([each[name] ** 2 for each in eyes])))
    exposure = view.scene.environment.exposure
    differences = [
        np.where(view.sure[eye], images[eye] - np.mean(view.truth[eye].halves, axis=0), 0)
        * exposure
        for eye in (0, 1)
    ]
    found = binocular_error(view.pairs, differences[0], differences[1])
    return {
        **row,
        "psnr_db": decibels(row["rms"]),
        "filter_psnr_db": decibels(row["filter_rms"]),
        "counts": row["reference_rms"] <= 0.1 * row["rms"],
        "samples": view.truth[0].samples,
        **_known({**found._asdict(), "coc_mismatch_px": view.coc_mismatch_px}),
        "seen_by_both": len(view.pairs.left),
    }


def _eye_errors(image: NDArray[Any], view: _View, eye: int) -> dict[str, float]:
    """Return the errors against R1, and with `filter_` those against R2."""
    truth, exposure = view.truth[eye], view.scene.environment.exposure
    test, first, second, scatter = (
        judged(pixels, view.sure[eye], exposure) for pixels in (image, *truth.halves, truth.scatter)
    )
    reference = (first + second) / 2
    ppd = view.pixels_per_degree
    return {
        "rms": rms(test, reference),
        "flip": hdr_flip(test, reference, pixels_per_degree=ppd),
        "ssim": ssim(test, reference),
        "reference_rms": rms(first, second) / 2,
        "filter_rms": rms(test, scatter),
        "filter_flip": hdr_flip(test, scatter, pixels_per_degree=ppd),
        "filter_ssim": ssim(test, scatter),
    }


def _known(values: dict[str, float]) -> dict[str, float | None]:
    """Return None for what is not a number: JSON has none (nothing is seen by both eyes)."""
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def decibels(error: float) -> float | None:
    """Return PSNR with peak 1; None where there is no error (JSON has no infinity)."""
    return None if error == 0 else -20 * math.log10(error)
