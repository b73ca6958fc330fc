"""Where feet can go: pieces of floor, level or sloping, and walks that never leave them.

A walk follows the floor's profile, and its length is the length along that profile. So a walker
of constant speed is slower across the ground on a slope, and while climbing a step not across the
ground at all, as in Carnegie & Rhee (2015): "their horizontal velocity was decreased to compensate,
keeping their total velocity constant". At an edge without a floor behind it a walk slides along.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, normalize

if TYPE_CHECKING:
    from vrcomfort.scene.data import WalkableArea

Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]

STEP_M = 0.25
"""The highest step that feet climb or go down; a stair has 0.15 to 0.2."""

TOUCH_M = 1e-9
"""Floors that lie this close to each other touch."""

# Feet this close to an edge stand at it, and slide along it.
NEAR_EDGE_M = 1e-6

PARALLEL = 1e-12
"""Sine of the angle at which a walk along an edge does not cross it."""

MAX_TURNS = 3
"""How often one walk may turn along another edge: twice in a corner."""


@dataclass(frozen=True)
class _Leg:
    """The result of a straight walk: its end, and the remainder that was not walked."""

    feet: Array
    left_m: float


class Floors:
    """All pieces of floor of a scene. Without any, the floor is level and endless.

    Where pieces overlap, feet are on the highest that they can reach by a step.
    """

    def __init__(self, areas: Iterable[WalkableArea] = ()) -> None:
        self._areas = tuple(areas)
        corners = [np.asarray(area.polygon_xz, dtype=np.float64) for area in self._areas]
        self._owner = np.repeat(np.arange(len(corners)), [len(each) for each in corners])
        self._from = np.concatenate([np.zeros((0, 2)), *corners])
        ends = [np.roll(each, -1, axis=0) for each in corners]
        self._to = np.concatenate([np.zeros((0, 2)), *ends])
        self._edge = self._to - self._from
        self._length2 = np.maximum(np.sum(self._edge**2, axis=1), 1e-30)
        self._heights = np.array([area.height_m for area in self._areas], dtype=np.float64)
        slopes = [area.slope_xz for area in self._areas]
        self._slopes = np.array(slopes, dtype=np.float64).reshape(-1, 2)

    def settle(self, point: Array) -> Array:
        """Return the nearest (3,) point on a floor, or on a step between two floors."""
        if not self._areas:
            return point.copy()
        spot = point[[0, 2]]
        near, owners = self._nearest_on_edges(spot)
        best = self._nearest_on_floors(point, near, owners)
        # Feet that climb a step are on neither of its floors.
        closer = np.linalg.norm(near - spot, axis=1) < np.linalg.norm(best - point)
        for edge_spot in near[closer]:
            on_step = self._on_step(edge_spot, float(point[1]))
            best = min(best, on_step, key=lambda each: float(np.linalg.norm(each - point)))
        return best

    def _nearest_on_floors(self, point: Array, near: Array, owners: Indices) -> Array:
        spot = point[[0, 2]]
        inside = np.flatnonzero(self._holding(spot))
        spots = np.concatenate([near, np.tile(spot, (len(inside), 1))])
        owners = np.concatenate([owners, inside])
        heights = self._heights[owners] + np.sum(self._slopes[owners] * spots, axis=1)
        found = np.stack([spots[:, 0], heights, spots[:, 1]], axis=1)
        nearest: Array = found[np.argmin(np.linalg.norm(found - point, axis=1))]
        return nearest

    def _on_step(self, spot: Array, height_m: float) -> Array:
        """Return the nearest height between the floors that meet at a point of an edge."""
        holding = np.flatnonzero(self._holding(spot))
        heights = self._heights[holding] + self._slopes[holding] @ spot
        reached = heights[np.abs(heights - height_m) <= STEP_M]
        low, high = (reached.min(), reached.max()) if len(reached) else (np.inf, np.inf)
        return np.array([spot[0], np.clip(height_m, low, high), spot[1]])

    def walk(self, feet: Array, direction_xz: Array, length_m: float) -> Array:
        """Return where feet on a floor come to.

        Parameters
        ----------
        feet
            (3,) metres.
        direction_xz
            (2,) unit vector.
        length_m
            Along the floor's profile; edges take the part of it that leads through them.
        """
        leg = self._straight(feet, direction_xz, length_m)
        for _ in range(MAX_TURNS):
            if leg.left_m <= TOUCH_M:
                break
            turned = self._along_an_edge(leg, direction_xz)
            if turned is None:
                break
            leg = turned
        return leg.feet

    def _along_an_edge(self, leg: _Leg, wish: Array) -> _Leg | None:
        """Use the remainder of a walk for sliding along the edge that it points along most."""
        near, _ = self._nearest_on_edges(leg.feet[[0, 2]])
        close = np.linalg.norm(near - leg.feet[[0, 2]], axis=1) < NEAR_EDGE_M
        edges = normalize(self._edge[close])
        shares = edges @ wish
        for index in np.argsort(-np.abs(shares), kind="stable"):
            share = shares[index]
            slid = self._straight(leg.feet, edges[index] * np.sign(share), leg.left_m * abs(share))
            if np.abs(slid.feet - leg.feet).max() > NEAR_EDGE_M:
                return _Leg(slid.feet, slid.left_m / abs(share))
        return None

    def _straight(self, feet: Array, direction: Array, length_m: float) -> _Leg:
        """Walk until the length is used up, or no floor follows."""
        if not self._areas:
            return _Leg(feet + np.array([direction[0], 0.0, direction[1]]) * length_m, 0.0)
        start, height_m, gone_m, left_m = feet[[0, 2]], float(feet[1]), 0.0, length_m
        for begin_m, end_m in pairwise(self._crossings(start, direction, length_m)):
            area = self._next_floor(start, direction, begin_m, end_m, height_m)
            if area is None:
                break
            step_m = self._height(area, start + direction * begin_m) - height_m
            climbed_m = float(np.clip(step_m, -left_m, left_m))
            height_m, left_m = height_m + climbed_m, left_m - abs(climbed_m)
            slope = float(self._slopes[area] @ direction)
            across_m = min(end_m - begin_m, left_m / np.hypot(1.0, slope))
            gone_m = begin_m + across_m
            height_m += slope * across_m
            left_m -= across_m * np.hypot(1.0, slope)
            if across_m < end_m - begin_m:
                left_m = 0.0
                break
        x, z = start + direction * gone_m
        return _Leg(self._kept_in(np.array([x, height_m, z])), left_m)

    def _crossings(self, start: Array, direction: Array, length_m: float) -> list[float]:
        """Return how far along a walk its start, the edges that it crosses, and its end are."""
        across = _cross(direction, self._edge)
        meets = np.abs(across) > PARALLEL * np.sqrt(self._length2)
        safe = np.where(meets, across, 1.0)
        offset = self._from - start
        ahead = _cross(offset, self._edge) / safe
        share = _cross(offset, direction) / safe
        slack = TOUCH_M / np.sqrt(self._length2)
        met = meets & (share >= -slack) & (share <= 1.0 + slack)
        met &= (ahead > TOUCH_M) & (ahead < length_m)
        return [0.0, *sorted(ahead[met].tolist()), length_m]

    def _next_floor(
        self, start: Array, direction: Array, begin_m: float, end_m: float, height_m: float
    ) -> int | None:
        """Return the highest floor of a stretch that a step reaches."""
        holding = np.flatnonzero(self._holding(start + direction * (begin_m + end_m) / 2))
        heights = self._heights[holding] + self._slopes[holding] @ (start + direction * begin_m)
        reached = np.abs(heights - height_m) <= STEP_M + TOUCH_M
        if not reached.any():
            return None
        return int(holding[np.argmax(np.where(reached, heights, -np.inf))])

    def _kept_in(self, feet: Array) -> Array:
        """Return feet that rounding has put a hair beside the floor, on its edge."""
        spot = feet[[0, 2]]
        if self._even_odd(spot).any():
            return feet
        near, _ = self._nearest_on_edges(spot)
        x, z = near[np.argmin(np.linalg.norm(near - spot, axis=1))]
        return np.array([x, feet[1], z])

    def _height(self, area: int, spot: Array) -> float:
        return float(self._heights[area] + self._slopes[area] @ spot)

    def _holding(self, spot: Array) -> Mask:
        """Return which floors lie under a point, or touch it."""
        near, owners = self._nearest_on_edges(spot)
        touched = owners[np.linalg.norm(near - spot, axis=1) <= TOUCH_M]
        holding = self._even_odd(spot)
        holding[touched] = True
        return holding

    def _even_odd(self, spot: Array) -> Mask:
        """Return which polygons a ray from the point leaves an odd number of times."""
        z_from, z_to = self._from[:, 1], self._to[:, 1]
        spans = (z_from > spot[1]) != (z_to > spot[1])
        rise = np.where(spans, self._edge[:, 1], 1.0)
        x = self._from[:, 0] + (spot[1] - z_from) / rise * self._edge[:, 0]
        met = self._owner[spans & (x > spot[0])]
        odd: Mask = np.bincount(met, minlength=len(self._areas)) % 2 == 1
        return odd

    def _nearest_on_edges(self, spot: Array) -> tuple[Array, Indices]:
        """Return the nearest (2,) point of every edge, and the index of its polygon."""
        share = np.sum((spot - self._from) * self._edge, axis=1) / self._length2
        return self._from + np.clip(share, 0.0, 1.0)[:, None] * self._edge, self._owner


def _cross(a: Array, b: Array) -> Array:
    product: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
