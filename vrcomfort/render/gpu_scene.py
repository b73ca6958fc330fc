"""A scene on the GPU: one vertex buffer, one index buffer, one multi-draw per material.

Per frame Python does not loop over things but over materials: which things are seen, at which
level of detail and in which order is decided by array operations on `DrawList`, and the GPU gets
one row (a 3 × 4 matrix and a few numbers) and one indirect command per thing.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, cast

import moderngl
import numpy as np

from vrcomfort.geometry import Array, Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.render import culling, lighting
from vrcomfort.render.draw_list import Batch, DrawList, batches, front_to_back
from vrcomfort.render.scene_rows import Movement, Rows, SceneRows
from vrcomfort.render.surfaces import MaterialBuffer, Surface, SurfaceFactory
from vrcomfort.render.vertex_data import (
    VERTEX_FORMAT,
    VERTEX_NAMES,
    index_bytes,
    vertex_bytes,
)
from vrcomfort.scene.data import Scene
from vrcomfort.scene.node_poses import HandPoses

DepthArrays = list[moderngl.VertexArray | None]

_ROW_NAMES = ("in_relative_x", "in_relative_y", "in_relative_z", "in_thing")
_PREVIOUS_NAMES = ("in_previous_x", "in_previous_y", "in_previous_z")


class GpuScene:
    """Draws a scene into whatever framebuffer is in use.

    Parameters
    ----------
    defines
        What the colour programs are compiled for besides the scene: VELOCITY, LENS, LAW_DIOPTRE.

    Call `update` once per frame, then `draw` or `draw_depth` for each view.
    """

    def __init__(
        self, ctx: moderngl.Context, scene: Scene, *, defines: shaders.Defines | None = None
    ) -> None:
        self.scene = scene
        self._ctx = ctx
        self._list = DrawList.of(scene)
        self._velocity = "VELOCITY" in (defines or {})
        self._rows = SceneRows(ctx, scene, self._list, velocity=self._velocity)
        self._vertices = gl.buffer(ctx, vertex_bytes(scene.primitives))
        self._indices = gl.buffer(ctx, index_bytes(scene.primitives))
        self._materials = MaterialBuffer(ctx, scene.materials)
        features = {**lighting.features(scene.environment), **(defines or {})}
        # Not a method of this object: buffers must go with it, not when cycles are collected.
        arrays = partial(_vertex_array, ctx, self._vertex_content(), self._indices)
        self._factory = SurfaceFactory(ctx, scene, arrays, scene_features=features)
        self._surfaces = [self._factory.make(key) for key in self._list.keys]
        self._depth_arrays = [surface.depth for surface in self._surfaces]
        self._semantic_arrays: DepthArrays | None = None
        blended = np.array([surface.blended for surface in self._surfaces], dtype=bool)
        self._blended_row = blended[self._list.key]
        self._triangles_of_row = self._list.commands["index_count"].astype(np.int64) // 3
        self.draws = 0

    def _vertex_content(self) -> list[tuple[Any, ...]]:
        content: list[tuple[Any, ...]] = [
            (self._vertices, VERTEX_FORMAT, *VERTEX_NAMES),
            (self._rows.buffer, "4f4 4f4 4f4 4f4/i", *_ROW_NAMES),
        ]
        if self._rows.previous_buffer is not None:
            content.append((self._rows.previous_buffer, "4f4 4f4 4f4/i", *_PREVIOUS_NAMES))
        return content

    def update(self, time_s: float, head: Pose, previous_time_s: float | None = None) -> None:
        """Move everything to where it is at a time; doing it again for the other eye is free.

        Parameters
        ----------
        time_s, previous_time_s
            Scene time now and one frame ago (None: nothing has moved).
        head
            world-from-head: decides levels of detail and places head-locked nodes.
        """
        self._rows.update(time_s, head, time_s if previous_time_s is None else previous_time_s)

    def place_hands(self, hands: HandPoses, before: HandPoses, *, with_head: bool) -> None:
        """Say where the hands are, as `SceneRows.place_hands` has it; call it before `update`."""
        self._rows.place_hands(hands, before, with_head=with_head)

    @property
    def hands_move(self) -> bool:
        """Return whether a hand counts as having been elsewhere a frame ago."""
        return self._rows.hands_move

    @property
    def moves(self) -> bool:
        """Return whether anything in the scene moves by itself (not with the head)."""
        return self._rows.moves

    @property
    def has_blended(self) -> bool:
        """Return whether any surface is blended."""
        return bool(self._blended_row.any())

    def draw(self, clip_from_relative: Array, eye_m: Array, *, blended: bool) -> int:
        """Draw what an eye sees, and return the number of triangles.

        Parameters
        ----------
        clip_from_relative
            (4, 4) for culling; the shaders read the bound `View` block.
        eye_m
            (3,) world position of the eye.
        blended
            False: opaque and masked surfaces, front to back. True: blended ones, back to front.
        """
        seen = self._rows.seen(culling.planes(clip_from_relative), eye_m)
        rows = np.flatnonzero(seen & self._rows.in_use & (self._blended_row == blended))
        distance = culling.lengths(self._rows.centers - eye_m)
        order = (
            rows[np.argsort(-distance[rows], kind="stable")]
            if blended
            else front_to_back(rows, self._list.key, distance)
        )
        self._rows.upload(order, eye_m, previous=self._velocity)
        for batch in batches(self._list.key, order):
            self._draw_batch(self._surfaces[batch.key], batch)
        return self._triangles(order)

    def draw_depth(
        self,
        clip_from_relative: Array,
        origin_m: Array,
        *,
        movement: Movement = "all",
        shadow: bool = False,
    ) -> int:
        """Draw depth only, alpha masks honoured, and return the number of triangles.

        Blended surfaces write no depth. `update` must have been called for this frame.

        Parameters
        ----------
        clip_from_relative
            (4, 4) any reverse-Z projection; relative = world axes with `origin_m` as origin.
        origin_m
            (3,) world metres: the viewpoint.
        movement
            Leave out what moves (or what does not).
        shadow
            Draw for a shadow map: what casts one only, back faces too, levels of detail by the
            distance from `origin_m`, no near plane (the target must clamp depth).
        """
        seen = self._rows.seen(culling.planes(clip_from_relative, near=not shadow), origin_m)
        in_use = (
            self._rows.level_in_use(origin_m) & self._rows.shadow if shadow else self._rows.in_use
        )
        rows = np.flatnonzero(seen & in_use & self._rows.chosen(movement) & ~self._blended_row)
        return self._draw_depth_rows(
            rows, clip_from_relative, origin_m, self._depth_arrays, cull=not shadow
        )

    def draw_semantic(self, clip_from_relative: Array, origin_m: Array) -> int:
        """Draw depth as `draw_depth` does and, as colour, the semantic weight of what is seen."""
        if self._semantic_arrays is None:
            self._semantic_arrays = [self._factory.semantic(key) for key in self._list.keys]
        seen = self._rows.seen(culling.planes(clip_from_relative), origin_m)
        rows = np.flatnonzero(seen & self._rows.in_use & ~self._blended_row)
        return self._draw_depth_rows(
            rows, clip_from_relative, origin_m, self._semantic_arrays, cull=True
        )

    def _draw_depth_rows(
        self, rows: Rows, clip: Array, origin_m: Array, arrays: DepthArrays, *, cull: bool
    ) -> int:
        if not len(rows):
            return 0
        order = rows[np.argsort(self._list.key[rows], kind="stable")]
        self._rows.upload(order, origin_m, previous=False)
        self._look_through(clip)
        for batch in batches(self._list.key, order):
            self._draw_depth_batch(batch.key, batch, arrays, cull=cull)
        return self._triangles(order)

    def draw_depth_views(
        self, clips_from_relative: Array, origin_m: Array, begin_view: Callable[[int], None]
    ) -> int:
        """Draw depth as `draw_depth` does, for several views from one point, with one upload.

        Parameters
        ----------
        clips_from_relative
            (views, 4, 4) projections.
        begin_view
            Called with the number of each view before it is drawn, to set its viewport.
        """
        seen = self._rows.seen(culling.planes(clips_from_relative), origin_m)
        view, row = np.nonzero(seen & self._rows.in_use & ~self._blended_row)
        key = self._list.key[row] + view * len(self._surfaces)
        order = np.argsort(key, kind="stable")
        self._rows.upload(row[order], origin_m, previous=False)
        begun = -1
        for batch in batches(key, order):
            number, surface = divmod(batch.key, len(self._surfaces))
            if number != begun:
                begun = number
                begin_view(number)
                self._look_through(clips_from_relative[number])
            self._draw_depth_batch(surface, batch, self._depth_arrays, cull=True)
        return self._triangles(row)

    def _look_through(self, clip_from_relative: Array) -> None:
        matrix = np.ascontiguousarray(clip_from_relative.T, dtype=np.float32)
        for program in self._factory.depth_programs:
            cast(moderngl.Uniform, program["clip_from_relative"]).write(matrix)

    def _triangles(self, rows: Rows) -> int:
        return int(self._triangles_of_row[rows].sum())

    def _draw_batch(self, surface: Surface, batch: Batch) -> None:
        self._materials.bind(surface.material)
        for unit, texture in surface.textures:
            texture.use(unit)
        self._cull(surface, cull=True)
        if surface.masked:
            self._ctx.enable_direct(_ALPHA_TO_COVERAGE)
        surface.color.render_indirect(self._rows.commands, count=batch.length, first=batch.first)
        if surface.masked:
            self._ctx.disable_direct(_ALPHA_TO_COVERAGE)
        self.draws += 1

    def _draw_depth_batch(self, key: int, batch: Batch, arrays: DepthArrays, *, cull: bool) -> None:
        surface, array = self._surfaces[key], arrays[key]
        if array is None:
            return
        if surface.masked:
            self._materials.bind(surface.material)
            for unit, texture in surface.textures[:1]:
                texture.use(unit)
        self._cull(surface, cull=cull)
        array.render_indirect(self._rows.commands, count=batch.length, first=batch.first)
        self.draws += 1

    def _cull(self, surface: Surface, *, cull: bool) -> None:
        if surface.double_sided or not cull:
            self._ctx.disable(moderngl.CULL_FACE)
            return
        self._ctx.front_face = "cw" if surface.mirrored else "ccw"
        self._ctx.enable(moderngl.CULL_FACE)


_ALPHA_TO_COVERAGE = 0x809E


def _vertex_array(
    ctx: moderngl.Context,
    content: list[tuple[Any, ...]],
    indices: moderngl.Buffer,
    program: moderngl.Program,
) -> moderngl.VertexArray:
    # Without a fragment shader moderngl would take the program for one that feeds points back.
    return ctx.vertex_array(program, content, indices, skip_errors=True, mode=moderngl.TRIANGLES)
