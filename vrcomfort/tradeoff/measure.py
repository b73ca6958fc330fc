"""Errors of every method on one case, against the references of its eyes."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.scene.data import Scene
from vrcomfort.tradeoff.captures import Capture, capture_views, context, radius_px
from vrcomfort.tradeoff.cases import (
    Case,
    ImageWindow,
    Scope,
    condition_of,
    drawn,
    drawn_px,
    eyes_of,
    frames,
    reference_condition,
    window_of,
)
from vrcomfort.tradeoff.error_measures import (
    Correspondence,
    Mask,
    PinholeView,
    binocular_error,
    border,
    correspondence,
    flicker,
    off_median,
    radius_mismatch_px,
    region_errors,
    regions,
)
from vrcomfort.tradeoff.image_error import (
    hdr_flip,
    inside_margin,
    judged,
    margin_px,
    pixels_per_degree,
    rms,
    ssim,
    sure,
)
from vrcomfort.tradeoff.methods import BlurMethod, methods, pick
from vrcomfort.tradeoff.references import EyeReference, base_captures, references_of
from vrcomfort.tradeoff.store import Store, key_of, method_code, scene_and_hash

SCATTER = "ideal scatter (R2)"


class MeasuredCase(NamedTuple):
    """Errors and pictures of a case."""

    case: Case
    rows: list[dict[str, Any]]
    """One for each method, and one for R2."""
    pictures: dict[str, NDArray[np.float32]]
    """Left eye: (h, w, 3) linear light, top row first, of the reference and of each method."""
    counted: Mask
    """(h, w, 1) top row first: the judged part of the pictures."""
    reused: int
    """How many rows were there from an earlier run."""


class _View(NamedTuple):
    """References and regions of a case."""

    scene: Scene
    eyes: tuple[EyeView, ...]
    pairs: Correspondence | None
    """None of a single eye."""
    coc_mismatch_px: float
    next_frame: tuple[EyeView, ...]
    """The same a frame of slow walking later; empty where flicker is not asked for."""


def measure(
    case: Case, scope: Scope, store: Store, todo: Sequence[BlurMethod] | None = None
) -> MeasuredCase:
    """Draw and judge methods (those of the scope), or take them from the store."""
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
    shown = {"reference": base["reference"], **pictures}
    return MeasuredCase(case, rows, shown, _counted(case, scope), reused)


def _counted(case: Case, scope: Scope) -> Mask:
    width, height = drawn_px(case, scope)
    counted = np.zeros((height, width, 1), dtype=bool)
    counted[judged_area(case, scope)] = True
    return counted[::-1]  # OpenGL has the bottom row first, pictures the top row


def _key(case: Case, scope: Scope, method: BlurMethod | None) -> str:
    flags = scope.size_px, scope.samples, scope.poses, scope.eyes, scope.flicker
    facts = asdict(case), *flags, method_code()
    condition = method.condition.model_dump(mode="json") if method else None
    _, scene_hash = scene_and_hash(case.scene)
    device = str(context().info["GL_RENDERER"])
    return key_of("method", *facts, condition, method and method.name, scene_hash, device)


def _view(case: Case, scope: Scope, store: Store) -> _View:
    scene, _ = scene_and_hash(case.scene)
    eyes = view_of(case, scope, store)
    later = view_of(replace(case, later=True), scope, store) if scope.flicker else ()
    pairs, mismatch = None, math.nan
    if eyes_of(case, scope) == 2:
        left, right = base_captures(case, scope)
        pairs = correspondence(left.eye, right.eye, margin_px=margin_px(scope.size_px))
        mismatch = radius_mismatch_px(pairs, eyes[0].radius_px, eyes[1].radius_px)
    return _View(scene, eyes, pairs, mismatch, later)


def errors_of(case: Case, scope: Scope, method: BlurMethod, store: Store) -> dict[str, Any]:
    """Return the errors of a method; only references are taken from the store."""
    return _drawn_errors(case, scope, method, _view(case, scope, store))[0]


def _method_facts(
    case: Case, scope: Scope, method: BlurMethod, view: _View
) -> dict[str, NDArray[Any]]:
    errors, picture = _drawn_errors(case, scope, method, view)
    row = {"method": method.name, "family": method.family, "step": method.step}
    return {"row": np.array(json.dumps({**row, **errors})), "picture": picture[::-1]}


def _drawn_errors(
    case: Case, scope: Scope, method: BlurMethod, view: _View
) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """Draw a method, and return its errors and the left eye's image."""
    images = images_of(case, scope, method, view.scene)
    later: tuple[NDArray[np.float32], ...] = ()
    if view.next_frame:
        later = images_of(replace(case, later=True), scope, method, view.scene)
    return _errors(images, view, later), images[0]


def images_of(
    case: Case, scope: Scope, method: BlurMethod, scene: Scene
) -> tuple[NDArray[np.float32], ...]:
    """Draw a method's images for the judged eyes."""
    condition = condition_of(case, scope, method.condition)
    eyes = eyes_of(case, scope)
    captures = capture_views(
        scene, condition, frames(case, scope), drawn_px(case, scope), eyes=eyes
    )
    return tuple(capture.blurred for capture in captures)


def _reference_facts(view: _View) -> dict[str, NDArray[Any]]:
    left = view.eyes[0].references
    row = {"method": SCATTER, "family": "none", "step": None}
    later = tuple(each.references.scatter for each in view.next_frame)
    errors = _errors(tuple(each.references.scatter for each in view.eyes), view, later)
    mean = (left.halves[0] + left.halves[1]) / 2
    return {
        "row": np.array(json.dumps({**row, **errors})),
        "picture": left.scatter[::-1].astype(np.float32),
        "reference": mean[::-1].astype(np.float32),
    }


def _errors(
    images: tuple[NDArray[Any], ...], view: _View, later: tuple[NDArray[Any], ...]
) -> dict[str, Any]:
    """Return the errors of the eyes' images, means over eyes (RMS: quadratic)."""
    eyes = [eye_errors(image, eye) for image, eye in zip(images, view.eyes, strict=True)]
    row = {name: _mean(name, [each[name] for each in eyes]) for name in eyes[0]}
    if later:
        changes = [
            _flicker(*each) for each in zip(images, view.eyes, later, view.next_frame, strict=True)
        ]
        row["flicker"] = _mean("rms", changes)
    return {
        **row,
        "psnr_db": decibels(row["rms"] or 0.0),
        "filter_psnr_db": decibels(row["filter_rms"] or 0.0),
        "counts": (row["reference_rms"] or 0.0) <= 0.1 * (row["rms"] or 0.0),
        "samples": view.eyes[0].references.samples,
        **_binocular(images, view),
    }


def _mean(name: str, values: list[float | None]) -> float | None:
    known = np.array([value for value in values if value is not None])
    if not len(known):
        return None
    if name.endswith(("rms", "seams")):
        return math.sqrt(float(np.mean(known**2)))
    return float(np.sum(known)) if name.endswith("px") else float(np.mean(known))


def _binocular(images: tuple[NDArray[Any], ...], view: _View) -> dict[str, float | None]:
    if view.pairs is None:
        return {"rivalry": None, "shower_door": None, "coc_mismatch_px": None, "seen_by_both": None}
    differences = [eye.error(image) for image, eye in zip(images, view.eyes, strict=True)]
    found = binocular_error(view.pairs, differences[0], differences[1])
    return {
        **_known({**found._asdict(), "coc_mismatch_px": view.coc_mismatch_px}),
        "seen_by_both": len(view.pairs.left),
    }


def _flicker(
    image: NDArray[Any], eye: EyeView, later: NDArray[Any], eye_later: EyeView
) -> float | None:
    changed = flicker(eye.error(image), eye_later.error(later))
    both = (eye.sure & eye_later.sure)[eye.area][..., 0]
    return math.sqrt(float(np.mean(changed[eye.area][both] ** 2))) if both.any() else None


def eye_errors(image: NDArray[Any], view: EyeView) -> dict[str, float | None]:
    """Return the errors of an eye's image: against R1, with `filter_` against R2, and by region.

    ``rms``, ``flip``, ``ssim``; ``REGION_rms`` (None where the view has none of it) and
    ``REGION_px``; ``seams`` (RMS of the high-pass error beside far edges); ``off_median_2_px`` and
    ``off_median_4_px`` and those of R1, of ``wide_px`` pixels.
    """
    references, exposure, area = view.references, view.exposure, view.area
    test, first, second, scatter = (
        judged(pixels, view.sure, exposure, area)
        for pixels in (image, *references.halves, references.scatter)
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
        **region_errors(view.error(image), view.regions, view.sure[..., 0]),
        **_off_median(image, view),
    }


def _off_median(image: NDArray[Any], view: EyeView) -> dict[str, float | None]:
    reference = np.mean(view.references.halves, axis=0)
    shown, ideal = (
        np.clip(tone_mapped(pixels, exposure=view.exposure), 0, 1) for pixels in (image, reference)
    )
    test, best = (off_median(pixels, view.radius_px, view.area) for pixels in (shown, ideal))
    return {
        "wide_px": test.wide_px,
        "off_median_2_px": test.over_2,
        "off_median_4_px": test.over_4,
        "reference_off_median_2_px": best.over_2,
        "reference_off_median_4_px": best.over_4,
    }


def _known(values: dict[str, float]) -> dict[str, float | None]:
    """Return None for NaN: JSON has none (no surface is seen by both eyes)."""
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def decibels(error: float) -> float | None:
    """Return PSNR with peak 1; None where there is no error (JSON has no infinity)."""
    return None if error == 0 else -20 * math.log10(error)


class EyeView(NamedTuple):
    """References, regions and mask of an eye's image, of the drawn size, bottom row first."""

    references: EyeReference
    sure: Mask
    area: tuple[slice, slice]
    """Rows and columns that are judged."""
    radius_px: Array
    regions: dict[str, Mask]
    exposure: float
    pixels_per_degree: float

    def error(self, image: NDArray[np.floating]) -> Array:
        """Return (h, w, 3): the image less R1, exposed; 0 where R1 is not sure."""
        reference = np.mean(self.references.halves, axis=0)
        return np.where(self.sure, (image - reference) * self.exposure, 0.0)


def view_of(case: Case, scope: Scope, store: Store) -> tuple[EyeView, ...]:
    """Return references and regions of a case, for the left eye and, where it counts, the right.

    References are drawn as far as the store has not got them.
    """
    captures = base_captures(case, scope)
    references = references_of(case, scope, captures, store)
    return tuple(_eye_view(case, scope, *each) for each in zip(captures, references, strict=True))


def _eye_view(case: Case, scope: Scope, capture: Capture, references: EyeReference) -> EyeView:
    scene, _ = scene_and_hash(case.scene)
    exposure = scene.environment.exposure
    radius = radius_px(capture, reference_condition(case, scope))
    seen = PinholeView(capture.depth, radius, capture.sharp * exposure, scope.size_px[0])
    area, edges = judged_area(case, scope), _border(case, scope, radius)
    inside = np.zeros(radius.shape, dtype=bool)
    inside[area] = True
    masks = {name: mask & inside for name, mask in regions(seen).items()}
    ppd = pixels_per_degree(capture.camera.fov, drawn_px(case, scope))
    known = sure(references.halves, exposure=exposure)
    return EyeView(references, known, area, radius, {**masks, "image_border": edges}, exposure, ppd)


def judged_area(case: Case, scope: Scope) -> tuple[slice, slice]:
    """Return the judged rows and columns of the drawn image: nothing in the margin."""
    rows, columns = inside_margin(scope.size_px)
    if case.window is None:
        return rows, columns
    part, whole = drawn(case, scope), window_of(case)
    bottom, top = max(whole.bottom_px, rows.start), min(_top(whole), rows.stop)
    left, right = max(whole.left_px, columns.start), min(_right(whole), columns.stop)
    inner = replace(
        whole, left_px=left, bottom_px=bottom, width_px=right - left, height_px=top - bottom
    )
    return inner.within(part)


def _right(window: ImageWindow) -> int:
    return window.left_px + window.width_px


def _top(window: ImageWindow) -> int:
    return window.bottom_px + window.height_px


def _border(case: Case, scope: Scope, radius: Array) -> Mask:
    """Return the pixels into which blur comes from outside the image."""
    part = drawn(case, scope)
    sides = (
        part.left_px == 0,
        _right(part) == scope.size_px[0],
        part.bottom_px == 0,
        _top(part) == scope.size_px[1],
    )
    found = border(radius.shape, sides, math.ceil(float(np.abs(radius).max(initial=0))))
    if case.window is None:
        return found
    inside = np.zeros_like(found)
    inside[window_of(case).within(part)] = True
    return found & inside
