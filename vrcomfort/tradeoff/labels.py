"""Where the labels of a figure go, so that none lies on another, on a marker or on an axis.

Everything is in pixels of the canvas. A place is a box (x0, y0, x1, y1); a line of two ends leads
from a marker to the nearest point of its label's box.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array

DIRECTIONS = 20
GAPS_PX = (4, 10, 16, 24, 34, 46, 60, 76, 94)
"""Between a marker's rim and its label."""

KEPT = 100
"""Places of each label that are looked at: those that are best on their own."""

PAD_PX = 2.0
"""At least so far from all that a label must not touch (twice as far from the next label)."""

LEADER_PX = 9.0
"""From so large a gap on a line shows whose label it is."""

MUST_NOT, BETTER_NOT, WORSE = 1e4, 300.0, 60.0
"""A label on a label, on a marker, outside, or under another's line; a label on a drawn line, or a
line over a marker; a label nearer to another marker than to its own, behind a drawn line, or two
lines that cross. Beside them, the gap in pixels counts."""

TRIES, ROUNDS, UNREST = 600, 8, 60.0
"""So often labels are put elsewhere, as noise on what is bad about their places has it, and moved
one at a time until none moves, or so often."""


class Crowd(NamedTuple):
    """What labels must keep away from.

    Parameters
    ----------
    inside
        The box they must stay in.
    markers
        (m, 3): centre and radius of all markers.
    lines
        (k, 2, 2): ends of straight lines that are drawn; may be none.
    """

    inside: Array
    markers: Array
    lines: Array


class _Places(NamedTuple):
    """The places that one label can take, and what is bad about each on its own."""

    boxes: Array
    lines: Array
    """(n, 2, 2): from the marker to where a line would end."""
    has_line: NDArray[np.bool_]
    bad: Array


def place(sizes_px: Sequence[tuple[float, float]], markers: Array, crowd: Crowd) -> list[Array]:
    """Return the box of each label: the best that is found by moving some, then one at a time.

    Parameters
    ----------
    sizes_px
        (width, height) of the labels' texts.
    markers
        (n, 3): centre and radius of what each label belongs to.
    """
    if not len(markers):
        return []
    places = [_places(size, own, crowd) for size, own in zip(sizes_px, markers, strict=True)]
    search = _Search(places)
    taken = search.best(np.random.default_rng(0))
    return [each.boxes[index] for each, index in zip(places, taken, strict=True)]


def leader(box: Array, marker: Array) -> Array | None:
    """Return the ends (2, 2) of a line from a marker's rim to its label; None of a near one."""
    end = np.clip(marker[:2], box[:2], box[2:])
    way = end - marker[:2]
    length = float(np.hypot(*way))
    if length - marker[2] < LEADER_PX:
        return None
    return np.array([marker[:2] + way * marker[2] / length, end])


def _places(size_px: tuple[float, float], marker: Array, crowd: Crowd) -> _Places:
    angle = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    toward = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    gap = np.repeat(GAPS_PX, DIRECTIONS)[:, None] + marker[2]
    half = np.array(size_px) / 2
    centre = marker[:2] + np.tile(toward, (len(GAPS_PX), 1)) * (half + gap)
    boxes = np.concatenate([centre - half, centre + half], axis=-1)
    ends = np.clip(marker[:2], boxes[:, :2], boxes[:, 2:])
    distance = np.hypot(*(ends - marker[:2]).T) - marker[2]
    has_line = distance >= LEADER_PX
    inside = crowd.inside + PAD_PX * np.array([1, 1, -1, -1])
    outside = np.any((boxes[:, :2] < inside[:2]) | (boxes[:, 2:] > inside[2:]), axis=-1)
    rims = _around(crowd.markers[:, :2], crowd.markers[:, 2:])
    strange = np.hypot(*(crowd.markers[:, :2] - marker[:2]).T) > marker[2]
    elsewhere = crowd.lines[~_hits(_around(marker[None, :2], marker[2:]), crowd.lines)[0]]
    own = np.stack([np.broadcast_to(marker[:2], ends.shape), ends], axis=1)
    must_not = outside + _overlaps(boxes, rims).sum(axis=-1)
    better_not = _hits(boxes, crowd.lines).any(axis=-1)
    better_not = better_not + has_line * _hits(rims[strange], own).sum(axis=0)
    nearest = _gaps(boxes, crowd.markers[strange]).min(axis=-1, initial=np.inf)
    worse = (nearest < distance + PAD_PX) + 1.0 * _cross(own, elsewhere).any(axis=-1)
    bad = MUST_NOT * must_not + BETTER_NOT * better_not + WORSE * worse + distance
    kept = np.argsort(bad, kind="stable")[:KEPT]
    return _Places(boxes[kept], own[kept], has_line[kept], bad[kept])


class _Search:
    """Looks for places that go together: a list with the number of a place for each label."""

    def __init__(self, places: Sequence[_Places]) -> None:
        self._alone = [each.bad for each in places]
        self._together = [[_together(a, b, same=a is b) for b in places] for a in places]

    def best(self, random: np.random.Generator) -> list[int]:
        """Return the best that is found."""
        best = self._settled([int(np.argmin(bad)) for bad in self._alone], random)
        least = self._total(best)
        for _ in range(TRIES):
            found = self._settled(self._disturbed(best, random), random)
            total = self._total(found)
            if total < least:
                best, least = found, total
        return best

    def _disturbed(self, taken: list[int], random: np.random.Generator) -> list[int]:
        """Return the places with a third of the labels, at least one, elsewhere."""
        found = list(taken)
        for index in random.permutation(len(found))[: 1 + len(found) // 3]:
            bad = self._alone[index]
            found[index] = int(np.argmin(bad + random.exponential(UNREST, len(bad))))
        return found

    def _settled(self, taken: list[int], random: np.random.Generator) -> list[int]:
        """Return places that no label can better by moving alone."""
        found = list(taken)
        for _ in range(ROUNDS):
            before = list(found)
            for index in random.permutation(len(found)):
                found[index] = int(np.argmin(self._bad(found, int(index))))
            if found == before:
                break
        return found

    def _total(self, taken: list[int]) -> float:
        return sum(float(self._bad(taken, i)[at]) for i, at in enumerate(taken))

    def _bad(self, taken: list[int], index: int) -> Array:
        """Return what is bad about each place of a label while the others stay."""
        rows = self._together[index]
        found: Array = self._alone[index] + sum(
            row[at] for row, at in zip(rows, taken, strict=True)
        )
        return found


def _together(a: _Places, b: _Places, *, same: bool) -> Array:
    """Return (places of b, places of a): what is bad about two labels' places together."""
    if same:
        return np.zeros((len(b.bad), len(a.bad)))
    apart = PAD_PX * np.array([-1, -1, 1, 1])
    over = _overlaps(b.boxes, a.boxes + apart) + 1.0 * (_hits(b.boxes, a.lines) & a.has_line)
    over = over + (_hits(a.boxes, b.lines) & b.has_line).T
    crossing = _cross(b.lines, a.lines) & a.has_line & b.has_line[:, None]
    found: Array = MUST_NOT * over + WORSE * crossing
    return found


def _around(centres: Array, reach: Array) -> Array:
    """Return (n, 4) boxes around centres."""
    return np.concatenate([centres - reach, centres + reach], axis=-1)


def _gaps(boxes: Array, markers: Array) -> Array:
    """Return (n, m): how far each box is from the rim of each marker."""
    centres = markers[None, :, :2]
    nearest = np.clip(centres, boxes[:, None, :2], boxes[:, None, 2:])
    gaps: Array = np.linalg.norm(nearest - centres, axis=-1) - markers[:, 2]
    return gaps


def _overlaps(a: Array, b: Array) -> NDArray[np.bool_]:
    """Return (n, m): which boxes come nearer to each other than :data:`PAD_PX`."""
    low = np.maximum(a[:, None, :2], b[None, :, :2]) - PAD_PX
    high = np.minimum(a[:, None, 2:], b[None, :, 2:])
    found: NDArray[np.bool_] = np.all(low < high, axis=-1)
    return found


def _hits(boxes: Array, lines: Array) -> NDArray[np.bool_]:
    """Return (n, m): which lines (m, 2, 2) come nearer to which boxes than :data:`PAD_PX`."""
    start, way = lines[None, :, 0], lines[None, :, 1] - lines[None, :, 0]
    way = np.where(way == 0, 1e-9, way)
    enter = (boxes[:, None, :2] - PAD_PX - start) / way
    leave = (boxes[:, None, 2:] + PAD_PX - start) / way
    first = np.minimum(enter, leave).max(axis=-1)
    last = np.maximum(enter, leave).min(axis=-1)
    found: NDArray[np.bool_] = (first <= last) & (last >= 0) & (first <= 1)
    return found


def _cross(a: Array, b: Array) -> NDArray[np.bool_]:
    """Return (n, m): which lines (n, 2, 2) cross which others (m, 2, 2)."""
    a, b = a[:, None], b[None]
    start, end, first, second = a[..., 0, :], a[..., 1, :], b[..., 0, :], b[..., 1, :]
    apart = _side(start, end, first) * _side(start, end, second)
    split = _side(first, second, start) * _side(first, second, end)
    found: NDArray[np.bool_] = (apart < 0) & (split < 0)
    return found


def _side(a: Array, b: Array, c: Array) -> Array:
    """Return a number that is positive where `c` lies to the left of the way from a to b."""
    along, across = b - a, c - a
    found: Array = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
    return np.sign(found)
