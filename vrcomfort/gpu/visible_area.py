"""The visibility mask as tiles: passes draw those that the lenses show, and a margin for reads.

A pass says how far from a texel it reads each of its textures (`PassImage.reach_px`). From this
follows by which margin each texture has to be drawn around what is seen, so that nothing is read
that was not drawn: what is seen has the same bits as without a mask. A pass that does not say it
reads anywhere, so that the passes before it draw whole images.
"""

from __future__ import annotations

import itertools
import math
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple, Protocol, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from vrcomfort.geometry import Array, Fov, HiddenArea, HiddenAreas, focal_length_px
from vrcomfort.gpu import gl, passes
from vrcomfort.gpu.passes import Pass, PassImage

TILE_PX = 8
"""Side of the tiles that are drawn or not."""

ANYWHERE = math.inf
"""Reach of a pass that may read all of a texture."""

DRAWN = -math.inf
"""Reach of a pass that reads a texture exactly where it is drawn, such as the sum of its texels."""

Made = TypeVar("Made")

Tiles = NDArray[np.bool_]
"""(rows, columns) of an image, the lowest row first."""


class Rectangle(NamedTuple):
    """Texels of a target from (left, bottom) to before (right, top)."""

    left: int
    bottom: int
    right: int
    top: int


class HasTargets(Protocol):
    """A pass that draws into textures."""

    def clear(self, value: float, depth: float) -> None:
        """Fill them with a value, and depth with another."""


class VisibleArea:
    """Which tiles the passes of a condition draw, by eye.

    Passes that are made inside :meth:`limiting` belong to it.

    Parameters
    ----------
    size_px
        (width, height) of an eye's image.
    hidden
        What the left and the right lens never show.

    Attributes
    ----------
    eye
        Whose tiles passes of one eye draw: 0 left, 1 right.
    state
        Grows whenever other tiles than before are drawn.
    """

    def __init__(self, size_px: tuple[int, int], hidden: HiddenAreas) -> None:
        self.size_px = size_px
        self.eye = self.state = 0
        self._hidden = hidden
        self._fovs: tuple[Fov, ...] = ()
        self._visible: list[Tiles] = [visible_tiles(None, None, size_px)] * len(hidden)
        self._passes: list[Pass] = []
        self._limited: weakref.WeakSet[HasTargets] = weakref.WeakSet()
        self._margins: dict[int, float] = {}

    @contextmanager
    def limiting(self) -> Iterator[None]:
        """Let all passes that are made inside belong to this area."""
        token = _current.set(self)
        try:
            with passes.collected() as found:
                yield
        finally:
            _current.reset(token)
        self._passes += found

    def add(self, limited: HasTargets) -> None:
        """Fill the targets of `limited` with 0 whenever other tiles are drawn than before."""
        self._limited.add(limited)

    def clear(self, value: float = 0.0, depth: float = 0.0) -> None:
        """Fill all targets with a value, and depth with another."""
        for each in self._limited:
            each.clear(value, depth)

    def look(self, fovs: Sequence[Fov]) -> None:
        """Draw from now on what eyes with these frusta see; without any, whole images."""
        if tuple(fovs) == self._fovs:
            return
        self._fovs = tuple(fovs)
        # Reach is in pixels of the image's width: where pixels are narrow, it is more rows.
        focal_px = [focal_length_px(fov, self.size_px) for fov in fovs]
        aspect = max([1.0, *(vertical / across for across, vertical in focal_px)])
        self._margins = margins(self._passes, aspect)
        seen_by: Sequence[Fov | None] = fovs or [None] * len(self._hidden)
        self._visible = [
            visible_tiles(hidden, fov, self.size_px)
            for hidden, fov in zip(self._hidden, seen_by, strict=False)
        ]
        self.state += 1
        self.clear()

    def margin(self, name: int) -> float:
        """Return the tiles beyond those seen in which a texture is drawn; `ANYWHERE`: all."""
        return self._margins.get(name, 0)

    def by_eye(self, image: PassImage, make: Callable[[list[Tiles]], Made]) -> Callable[[], Made]:
        """Return a function that gives what `make` makes of the tiles that are drawn, made once.

        They are the present eye's, or each eye's where the image has them as layers.
        """
        kept: dict[int, tuple[int, Made]] = {}

        def present() -> Made:
            eye = self.eye if image.layers == 1 else _ALL
            if eye not in kept or kept[eye][0] != self.state:
                drawn = self._visible if eye == _ALL else [self._visible[eye]]
                margin = self.margin(image.name)
                kept[eye] = self.state, make([widened(each, margin) for each in drawn])
            return kept[eye][1]

        return present


_ALL = -1
"""Stands for all eyes."""

_current: ContextVar[VisibleArea | None] = ContextVar("visible_area", default=None)


def current() -> VisibleArea | None:
    """Return the area that passes made now belong to; None where whole images are drawn."""
    return _current.get()


def limited_draw(
    area: VisibleArea,
    whole: moderngl.VertexArray,
    image: PassImage,
    *,
    texel_px: tuple[int, int] = (1, 1),
    points: tuple[int, int] | None = None,
    elsewhere: bool = False,
) -> Callable[[], None]:
    """Return a function that draws what the present eye needs of a texture, or all eyes.

    Parameters
    ----------
    whole
        Draws all of it. Its program takes ``corner_of_eye`` (``include/corner.glsl``), or, with
        `points`, one vertex for each texel, which knows it by gl_VertexID.
    texel_px
        (width, height) in pixels of the eye's image.
    points
        (columns, rows) of texels, or of the tiles that are drawn whole.
    elsewhere
        Draw the rest instead.
    """
    ctx = whole.ctx

    def made(drawn_in: list[Tiles]) -> moderngl.VertexArray | None:
        places: NDArray[np.uint32] | NDArray[np.float32]
        if points is not None:
            columns, rows = points
            texels = _texels_in(drawn_in, points, texel_px)
            places = np.concatenate([e * columns * rows + each for e, each in enumerate(texels)])
        else:
            wanted = [~tiles if elsewhere else tiles for tiles in drawn_in]
            rectangles = [list(covering(each, image.size_px, texel_px)) for each in wanted]
            flat = [corners(each, image.size_px) for each in rectangles]
            places = np.concatenate([np.insert(c, 2, eye, axis=1) for eye, c in enumerate(flat)])
        if not len(places):
            return None
        buffer = gl.buffer(ctx, places.tobytes())
        drawn = (
            ctx.vertex_array(whole.program, [(buffer, "3f", "corner_of_eye")])
            if points is None
            else ctx.vertex_array(whole.program, [], index_buffer=buffer)
        )
        drawn.scope = whole.scope
        return drawn

    of_eye = area.by_eye(image, made)

    def draw() -> None:
        if (drawn := of_eye()) is not None:
            drawn.render(moderngl.TRIANGLES if points is None else moderngl.POINTS)

    return draw


def texel_list(
    ctx: moderngl.Context, area: VisibleArea, image: PassImage, texel_px: tuple[int, int]
) -> Callable[[], moderngl.Buffer]:
    """Return a function that lists a texture's texels that are drawn, as :func:`limited_draw` does.

    Each eye's number stands first: ``include/summed_texels.glsl``.

    Parameters
    ----------
    texel_px
        (width, height) in pixels of the eye's image.
    """

    def made(drawn_in: list[Tiles]) -> moderngl.Buffer:
        texels = _texels_in(drawn_in, image.size_px, texel_px)
        counts = np.array([len(each) for each in texels], np.uint32)
        return gl.buffer(ctx, np.concatenate([counts, *texels]).tobytes())

    return area.by_eye(image, made)


def _texels_in(
    drawn_in: list[Tiles], size_px: tuple[int, int], texel_px: tuple[int, int]
) -> list[NDArray[np.uint32]]:
    """Return the numbers, row by row, of a texture's texels that touch each eye's tiles."""
    found = (np.flatnonzero(texels_of(tiles, size_px, texel_px)) for tiles in drawn_in)
    return [each.astype(np.uint32) for each in found]


def margins(declared: Iterable[Pass], pixel_aspect: float = 1.0) -> dict[int, float]:
    """Return by how many tiles around what is seen each texture has to be drawn.

    What nothing reads is drawn where it is seen: 0. Textures that passes read and write in turns,
    each time from farther away, are drawn as a whole: infinity.

    Parameters
    ----------
    pixel_aspect
        How much farther passes reach along columns than along rows, from 1 on.
    """
    listed = list(declared)
    found = {image.name: 0.0 for each in listed for image in (*each.reads, *each.writes)}
    for turn in itertools.count():
        before = dict(found)
        for each in listed:
            # All targets of a pass are drawn in the same tiles.
            own = max((found[image.name] for image in each.writes), default=0.0)
            found.update(dict.fromkeys((image.name for image in each.writes), own))
            for image in each.reads:
                around = tiles_within(pixel_aspect * image.reach_px, each)
                found[image.name] = max(found[image.name], own + around)
        if found == before:
            break
        if turn > len(found):
            # No chain of passes is that long: those in a ring reach farther each time round.
            grown = (name for name, tiles in found.items() if tiles != before[name])
            found.update(dict.fromkeys(grown, math.inf))
    return found


def tiles_within(reach_px: float, reader: Pass) -> float:
    """Return how many tiles away a pass may read that draws texels which touch a tile."""
    if math.isinf(reach_px):
        return reach_px
    # A texel that touches a tile may go on beyond it.
    beyond_px = max(side - math.gcd(side, TILE_PX) for side in reader.texel_px)
    return math.ceil((reach_px + beyond_px) / TILE_PX)


def visible_tiles(hidden: HiddenArea | None, fov: Fov | None, size_px: tuple[int, int]) -> Tiles:
    """Return the tiles of an image of which a lens shows something, or a pixel beside it does."""
    width, height = size_px
    shape = math.ceil(height / TILE_PX), math.ceil(width / TILE_PX)
    if hidden is None or fov is None:
        return np.ones(shape, dtype=np.bool_)
    # Displays read between pixels: one beside what is seen counts as seen.
    pixels = minimum_filter(hidden_pixels(hidden, fov, size_px), size=3, mode="nearest")
    padded = np.ones((shape[0] * TILE_PX, shape[1] * TILE_PX), dtype=np.bool_)
    padded[:height, :width] = pixels
    blocks = padded.reshape(shape[0], TILE_PX, shape[1], TILE_PX)
    return ~np.asarray(blocks.all(axis=(1, 3)))


def hidden_pixels(hidden: HiddenArea, fov: Fov, size_px: tuple[int, int]) -> NDArray[np.bool_]:
    """Return (height, width) which pixels' middles lie in the hidden area, the lowest row first."""
    width, height = size_px
    left, right, up, down = fov.tangents
    scale = np.array([width / (right - left), height / (up - down)])
    points = (hidden.vertices.astype(np.float64) - [left, down]) * scale
    which, row = _rows_of(points[hidden.triangles], height)
    spans = _spans(points[hidden.triangles[which]], row.astype(np.float64) + 0.5)
    first, last = np.clip(np.ceil(np.stack(spans) - 0.5), 0, width).astype(np.intp)
    steps = np.zeros((height, width + 1), dtype=np.int32)
    np.add.at(steps, (row, first), 1)
    np.add.at(steps, (row, last), -1)
    return np.asarray(np.cumsum(steps, axis=1)[:, :width] > 0)


def _rows_of(triangles: Array, height: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return (n,) triangles and (n,) rows of pixels, whose middles go through them."""
    y = triangles[..., 1]
    ends = np.clip(np.ceil(np.stack([y.min(axis=1), y.max(axis=1)]) - 0.5), 0, height)
    first, last = np.nan_to_num(ends).astype(np.intp)  # what is no number is nowhere
    counts = last - first
    which = np.repeat(np.arange(len(triangles)), counts)
    return which, np.arange(len(which)) + np.repeat(last - np.cumsum(counts), counts)


def _spans(triangles: Array, rows: Array) -> tuple[Array, Array]:
    """Return (n,) where (n, 3, 2) triangles begin and end in (n,) rows that go through them."""
    x, y = np.moveaxis(triangles, -1, 0)
    to_x, to_y = (np.roll(each, -1, axis=1) for each in (x, y))
    with np.errstate(divide="ignore", invalid="ignore"):  # along the row
        along = (rows[:, None] - y) / (to_y - y)
        at = np.where((along >= 0) & (along <= 1), x + along * (to_x - x), np.nan)
    starts = np.fmin.reduce(at, axis=1, initial=np.inf)
    return starts, np.maximum(np.fmax.reduce(at, axis=1, initial=-np.inf), starts)


def widened(tiles: Tiles, margin: float) -> Tiles:
    """Return tiles and those that are at most so many tiles away, also diagonally."""
    if margin <= 0:
        return tiles
    if margin >= max(tiles.shape):
        return np.ones_like(tiles)
    return ~np.asarray(minimum_filter(~tiles, size=2 * int(margin) + 1, mode="nearest"))


def texels_of(tiles: Tiles, size_px: tuple[int, int], texel_px: tuple[int, int]) -> Tiles:
    """Return (rows, columns) which texels of a texture touch tiles."""
    found = tiles
    for axis in (0, 1):
        first = np.arange(size_px[1 - axis]) * texel_px[1 - axis]
        last = np.minimum((first + texel_px[1 - axis] - 1) // TILE_PX, tiles.shape[axis] - 1)
        counted = np.cumsum(found, axis=axis, dtype=np.int32)
        before = np.insert(counted, 0, 0, axis=axis)
        found = np.take(counted, last, axis=axis) > np.take(before, first // TILE_PX, axis=axis)
    return np.asarray(found)


def covering(
    tiles: Tiles, size_px: tuple[int, int], texel_px: tuple[int, int]
) -> Iterator[Rectangle]:
    """Yield rectangles of texels that cover tiles, each texel once."""
    whole = all(TILE_PX % each == 0 for each in texel_px)
    squares = tiles if whole else texels_of(tiles, size_px, texel_px)
    across, along = (TILE_PX // each if whole else 1 for each in texel_px)
    padded = np.pad(squares, ((0, 1), (1, 1)))
    bottom, rows = 0, squares.shape[0]
    for row in range(1, rows + 1):
        if row < rows and (padded[row] == padded[bottom]).all():
            continue
        edges = np.flatnonzero(np.diff(padded[bottom].astype(np.int8)))
        for left, right in edges.reshape(-1, 2).tolist():
            yield Rectangle(
                left * across,
                bottom * along,
                min(right * across, size_px[0]),
                min(row * along, size_px[1]),
            )
        bottom = row


def corners(rectangles: Sequence[Rectangle], size_px: tuple[int, int]) -> NDArray[np.float32]:
    """Return (6 n, 2) corners of two triangles for each rectangle, in parts of an image."""
    edges = np.array(rectangles).reshape(-1, 4)
    order = edges[:, [[0, 1], [2, 1], [2, 3], [0, 1], [2, 3], [0, 3]]]
    return (order.reshape(-1, 2) / size_px).astype(np.float32)
