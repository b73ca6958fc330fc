"""What an eye's image is judged by: references, regions, and which pixels count."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.render.image_error import inside_margin, pixels_per_degree, sure
from vrcomfort.tradeoff.cases import (
    Case,
    Scope,
    drawn,
    drawn_px,
    reference_condition,
    window_of,
)
from vrcomfort.tradeoff.regions import Mask, Seen, border, regions
from vrcomfort.tradeoff.shots import Shot, radius_px
from vrcomfort.tradeoff.store import Store, scene_and_hash
from vrcomfort.tradeoff.truth import Truth, base_shots, truths
from vrcomfort.tradeoff.windows import Window


class EyeView(NamedTuple):
    """What an eye's image is judged by: everything of the size that is drawn, bottom row first."""

    truth: Truth
    sure: Mask
    area: tuple[slice, slice]
    """Rows and columns that are judged."""
    radius_px: Array
    regions: dict[str, Mask]
    exposure: float
    pixels_per_degree: float

    def error(self, image: NDArray[np.floating]) -> Array:
        """Return (h, w, 3): the image less R1, exposed; 0 where R1 is not sure."""
        reference = np.mean(self.truth.halves, axis=0)
        return np.where(self.sure, (image - reference) * self.exposure, 0.0)


def view_of(case: Case, scope: Scope, store: Store) -> tuple[EyeView, ...]:
    """Return what a case's images are judged by, for the left eye and, where it counts, the right.

    References are drawn as far as the store has not got them.
    """
    shots = base_shots(case, scope)
    truth = truths(case, scope, shots, store)
    return tuple(_eye_view(case, scope, *each) for each in zip(shots, truth, strict=True))


def _eye_view(case: Case, scope: Scope, shot: Shot, truth: Truth) -> EyeView:
    scene, _ = scene_and_hash(case.scene)
    exposure = scene.environment.exposure
    radius = radius_px(shot, reference_condition(case, scope))
    seen = Seen(shot.depth, radius, shot.sharp * exposure, scope.size_px[0])
    area, edges = judged_area(case, scope), _border(case, scope, radius)
    inside = np.zeros(radius.shape, dtype=bool)
    inside[area] = True
    masks = {name: mask & inside for name, mask in regions(seen).items()}
    ppd = pixels_per_degree(shot.camera.fov, drawn_px(case, scope))
    known = sure(truth.halves, exposure=exposure)
    return EyeView(truth, known, area, radius, {**masks, "image_border": edges}, exposure, ppd)


def judged_area(case: Case, scope: Scope) -> tuple[slice, slice]:
    """Return the rows and columns of what is drawn that are judged: nothing in the margin."""
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


def _right(window: Window) -> int:
    return window.left_px + window.width_px


def _top(window: Window) -> int:
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
