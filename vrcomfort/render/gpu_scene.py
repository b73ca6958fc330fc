"""A scene on the GPU: one vertex buffer, one index buffer, one multi-draw per state.

Per frame Python does not loop over instances but over OpenGL states: which instances are seen, at
which level of detail and in which order is decided by array operations on `DrawList`, for both eyes
at once, and the GPU gets one row (a 3 × 4 matrix and a few numbers) and one indirect command per
instance. Textures and materials are bound once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import by_eyes
from vrcomfort.gpu.passes import AnyTexture, PassImage
from vrcomfort.render import culling, lighting
from vrcomfort.render.draw_list import Batch, DrawList, batches, front_to_back
from vrcomfort.render.materials import (
    BatchState,
    BatchStateFactory,
    ImageArrays,
    MaterialBuffer,
    TextureStore,
)
from vrcomfort.render.scene_buffers import (
    BENDING_FORMAT,
    BENDING_NAMES,
    PREVIOUS_FORMAT,
    PREVIOUS_NAMES,
    ROW_FORMAT,
    ROW_NAMES,
    SECOND_UV_FORMAT,
    SECOND_UV_NAMES,
    VERTEX_FORMAT,
    VERTEX_NAMES,
    ClipBlock,
    JointBuffer,
    Movement,
    RowBuffers,
    Rows,
    SceneRows,
    bending_bytes,
    index_bytes,
    second_uv_bytes,
    vertex_bytes,
)
from vrcomfort.scene.data import Scene
from vrcomfort.scene.node_poses import HandPoses


class _Layer(NamedTuple):
    """Batches of one view in drawing order, either opaque or blended."""

    batches: list[Batch]
    triangles: int


# Bits of a layer's number: blended (1), foreground (2).
_LAYERS, _OF_FOREGROUND = 4, 2
"""Opaque, blended; then those of the foreground."""


DEPTH_SHADER, SEMANTIC_SHADER = "scene/depth.vert", "scene/depth.frag"
"""Names of passes that draw surfaces in depth alone, or their numbers and weights too."""


class GpuScene:
    """Draws a scene into the framebuffer in use.

    Parameters
    ----------
    defines
        Defines of the colour programs besides those of the scene: VELOCITY, LENS, LAW_DIOPTRE.
    foreground
        (nodes,) which are drawn apart from the others; none without it.

    Attributes
    ----------
    draws, triangles
        Sent so far: whoever counts those of a frame sets them to 0 before it.

    Call `update` once per frame, then `cull` once for all eyes and `draw` for each; or
    `draw_depth`.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        *,
        defines: shaders.Defines | None = None,
        foreground: NDArray[np.bool_] | None = None,
    ) -> None:
        self.scene = scene
        self._ctx = ctx
        images = ImageArrays.of(scene)
        self._list = table = DrawList.of(scene, images)
        velocity = "VELOCITY" in (defines or {})
        self._rows = SceneRows(scene, table)
        self._color_rows = RowBuffers(ctx, 2 * len(table.node), previous=velocity)
        self._depth_rows = RowBuffers(ctx, len(table.node), previous=False)
        self._drawer = BatchDrawer(ctx, scene, images)
        self._clips = ClipBlock(ctx)
        joints = scene.all_skins.count
        self._joints = JointBuffer(ctx, joints) if joints else None
        factory = self._factory(defines or {})
        self._color_states = [factory.color(key) for key in table.keys]
        self._depth_states = [factory.depth(key) for key in table.depth_keys]
        self._semantic_states: list[BatchState] | None = None
        self._semantic = partial(_semantic_states, factory, table)
        self._behind_states: list[BatchState] = []
        self._make_behind = partial(_behind_states, factory, table)
        self.has_blended = bool(table.blended.any())
        self._foreground = None if foreground is None else foreground[table.node]
        self._triangles_of_row = table.commands["index_count"].astype(np.int64) // 3
        self._layers: list[_Layer] = []
        """Of the first view, of the second, …: `_LAYERS` each."""
        self.draws = self.triangles = 0

    def _factory(self, defines: shaders.Defines) -> BatchStateFactory:
        vertices = gl.buffer(self._ctx, vertex_bytes(self.scene.primitives))
        indices = gl.buffer(self._ctx, index_bytes(self.scene.primitives))
        of_vertices: list[tuple[Any, ...]] = [(vertices, VERTEX_FORMAT, *VERTEX_NAMES)]
        if (uvs := second_uv_bytes(self.scene.primitives)) is not None:
            of_vertices.append((gl.buffer(self._ctx, uvs), SECOND_UV_FORMAT, *SECOND_UV_NAMES))
        if (bending := bending_bytes(self.scene.primitives)) is not None:
            of_vertices.append((gl.buffer(self._ctx, bending), BENDING_FORMAT, *BENDING_NAMES))

        def arrays(buffers: RowBuffers) -> Callable[[moderngl.Program], moderngl.VertexArray]:
            # Not a method of this object: buffers must go with it, not when cycles are collected.
            content = [*of_vertices, (buffers.rows, ROW_FORMAT, *ROW_NAMES)]
            if buffers.previous is not None:
                content.append((buffers.previous, PREVIOUS_FORMAT, *PREVIOUS_NAMES))
            return partial(_vertex_array, self._ctx, content, indices)

        features = {**lighting.features(self.scene.environment), **defines}
        return BatchStateFactory(
            self._ctx, arrays(self._color_rows), arrays(self._depth_rows), scene_features=features
        )

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
        if self._joints is not None:
            self._joints.write(self._rows.joints, self._rows.previous_joints)

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

    def cull(self, clips_from_relative: Array, origins_m: Array) -> None:
        """Cull and order the instances of several views, all at once.

        Opaque and masked surfaces are drawn front to back, blended ones back to front.

        Parameters
        ----------
        clips_from_relative
            (views, 4, 4) projections; relative = world axes with the view's place as origin.
        origins_m
            (views, 3) their places in the world.
        """
        seen = self._rows.seen(culling.planes(clips_from_relative), origins_m)
        order = self._order(np.logical_or.reduce(seen).nonzero()[0])
        view, place = seen[:, order].nonzero()
        row = self._rows.in_use[order[place]]
        layer = view * _LAYERS + self._list.blended[row]
        if self._foreground is not None:
            layer += _OF_FOREGROUND * self._foreground[row]
        # One number for layer and state: equal numbers in a row are one multi-draw.
        run = layer * len(self._color_states) + self._list.key[row]
        self._rows.write(self._color_rows, row, origins_m[view])
        layers = _LAYERS * len(origins_m)
        triangles = np.bincount(layer, self._triangles_of_row[row], minlength=layers)
        self._layers = [_Layer([], int(count)) for count in triangles.tolist()]
        for number, batch in zip(*batches(run, len(self._color_states)), strict=True):
            self._layers[number].batches.append(batch)

    def _order(self, seen: Rows) -> Rows:
        """Order places in `SceneRows.in_use` by their distance from the head: alike in both eyes.

        Blended instances come last, and from back to front; the foreground comes after the rest.
        """
        rows, distance = self._rows.in_use[seen], self._rows.distance_m[seen]
        order = seen[front_to_back(self._list.key[rows], distance)]
        if self._foreground is not None:
            apart = self._foreground[self._rows.in_use[order]]
            order = order[np.argsort(apart, kind="stable")]
        if not self.has_blended:
            return order
        blended = self._list.blended[self._rows.in_use[order]]
        over = order[blended]
        back_to_front = np.argsort(-self._rows.distance_m[over], kind="stable")
        return np.concatenate([order[~blended], over[back_to_front]])

    @property
    def images(self) -> tuple[PassImage, ...]:
        """Return what surfaces may read, to declare passes that draw them."""
        return self._drawer.textures.images

    def add_texture(self, unit: int, texture: AnyTexture) -> None:
        """Let surfaces read a texture at a unit, as `TextureStore.add` has it."""
        self._drawer.textures.add(unit, texture)

    def make_behind(self, eyes: int) -> None:
        """Compile what `draw` needs for what lies behind near things (``BEHIND_NEAR``).

        Parameters
        ----------
        eyes
            For how many there is a limit in the texture.
        """
        self._behind_states = self._make_behind(by_eyes(eyes))

    def draw(
        self, view: int, *, blended: bool, foreground: bool = False, behind: bool = False
    ) -> int:
        """Draw a view of the last `cull`, and return the number of draws, as `Pass.run` wants it.

        Parameters
        ----------
        blended
            False: opaque and masked surfaces. True: blended ones.
        foreground
            Draw the foreground, or all else.
        behind
            Leave out what is near: `make_behind`; its limit is on `NEAREST_UNIT`. Whether this is
            drawn is left to the GPU, so that it does not count.
        """
        layer = self._layers[_LAYERS * view + _OF_FOREGROUND * foreground + blended]
        if self._joints is not None:
            self._joints.bind()
        states = self._behind_states if behind else self._color_states
        self._drawer.draw(layer.batches, states, self._color_rows.commands)
        if not behind:
            self.draws += len(layer.batches)
            self.triangles += layer.triangles
        return len(layer.batches)

    def draw_shadow(
        self, clip_from_relative: Array, origin_m: Array, *, movement: Movement = "all"
    ) -> int:
        """Draw the depth of shadow casters, back faces too, and return the number of draws.

        Alpha masks are honoured; levels of detail are by the distance from `origin_m`. There is no
        near plane: the target must clamp depth. `update` must have been called for this frame.

        Parameters
        ----------
        clip_from_relative
            (4, 4) any reverse-Z projection; relative = world axes with `origin_m` as origin.
        origin_m
            (3,) world metres: the viewpoint.
        movement
            Leave moving (or static) casters out.
        """
        planes = culling.planes(clip_from_relative, near=False)
        rows = self._rows.casting(planes, origin_m, movement)
        view, clips = np.zeros(len(rows), dtype=np.intp), clip_from_relative[None]
        return self._draw_rows((view, rows), clips, origin_m, self._depth_states, cull=False)

    def draw_depth(
        self,
        clips_from_relative: Array,
        origin_m: Array,
        begin_views: Sequence[Callable[[], object]] = (),
    ) -> int:
        """Draw depth only, for several views from one point, and return the number of draws.

        Alpha masks are honoured; blended surfaces write no depth. `update` must have been called
        for this frame.

        Parameters
        ----------
        clips_from_relative
            (views, 4, 4) projections, as those of `draw_shadow`.
        begin_views
            Each is called before its view is drawn, to set the viewport.
        """
        seen = self._seen_from(culling.planes(clips_from_relative), origin_m)
        states = self._depth_states
        return self._draw_rows(seen, clips_from_relative, origin_m, states, begin_views=begin_views)

    def draw_semantic(
        self, clip_from_relative: Array, origin_m: Array, *, numbered: bool = False
    ) -> int:
        """Draw depth as `draw_depth` does for one view and, as colour, semantic weights.

        Parameters
        ----------
        numbered
            Draw the number of the node that is seen instead: from 1, in the order of `Scene.nodes`.
        """
        if self._semantic_states is None:
            self._semantic_states = self._semantic()
        clips, states = clip_from_relative[None], self._semantic_states
        seen = self._seen_from(culling.planes(clips), origin_m)
        return self._draw_rows(seen, clips, origin_m, states, numbered=numbered)

    def _seen_from(self, planes: Array, origin_m: Array) -> tuple[Rows, Rows]:
        """Return, of all rows that write depth within planes around a point, view and row."""
        seen = self._rows.seen(planes, origin_m[None])
        if self.has_blended:
            seen &= ~self._list.blended[self._rows.in_use]
        view, place = seen.nonzero()
        return view, self._rows.in_use[place]

    def _draw_rows(
        self,
        seen: tuple[Rows, Rows],
        clips_from_relative: Array,
        origin_m: Array,
        states: list[BatchState],
        *,
        begin_views: Sequence[Callable[[], object]] = (),
        cull: bool = True,
        numbered: bool = False,
    ) -> int:
        """Draw rows, each in its view, with one upload; return the number of draws."""
        view, row = seen
        if not len(row):
            return 0
        key = self._list.depth_key[row] + view * len(states)
        order = np.argsort(key, kind="stable")
        rows, buffers = self._rows, self._depth_rows
        rows.write(buffers, row[order], origin_m, view[order], numbered=numbered)
        self._clips.write(clips_from_relative)
        if self._joints is not None:
            self._joints.bind()
        numbers, found = batches(key[order], len(states))
        before = [begin_views[number] for number in numbers] if begin_views else ()
        self._drawer.draw(found, states, buffers.commands, cull=cull, before=before)
        self.draws += len(found)
        self.triangles += int(np.add.reduce(self._triangles_of_row[row]))
        return len(found)


def _semantic_states(factory: BatchStateFactory, table: DrawList) -> list[BatchState]:
    return [factory.semantic(key) for key in table.depth_keys]


def _behind_states(
    factory: BatchStateFactory, table: DrawList, defines: shaders.Defines
) -> list[BatchState]:
    return [factory.color(key, {"BEHIND_NEAR": 1, **defines}) for key in table.keys]


def _vertex_array(
    ctx: moderngl.Context,
    content: list[tuple[Any, ...]],
    indices: moderngl.Buffer,
    program: moderngl.Program,
) -> moderngl.VertexArray:
    # Without a fragment shader moderngl would take the program for one that feeds points back.
    return ctx.vertex_array(program, content, indices, skip_errors=True, mode=moderngl.TRIANGLES)


_ALPHA_TO_COVERAGE = 0x809E


class BatchDrawer:
    """Draws batches, and changes only OpenGL state that differs from one to the next.

    No faces are culled before. The caller enables what it needs afterwards.
    """

    def __init__(self, ctx: moderngl.Context, scene: Scene, images: ImageArrays) -> None:
        self._ctx = ctx
        self._materials = MaterialBuffer(ctx, scene, images)
        self.textures = TextureStore(ctx, scene, images)

    def draw(
        self,
        batches: Sequence[Batch],
        states: Sequence[BatchState],
        commands: moderngl.Buffer,
        *,
        cull: bool = True,
        before: Sequence[Callable[[], object]] = (),
    ) -> None:
        """Draw.

        Parameters
        ----------
        states
            Numbered by the keys of batches.
        cull
            Whether back faces of one-sided surfaces are left out.
        before
            What is called before each batch.
        """
        ctx, culled, bound, covers = self._ctx, None, None, False
        self.textures.bind()
        for number, (key, first, length) in enumerate(batches):
            if before:
                before[number]()
            array, block, faces, state_covers = states[key]
            if block is not None and block != bound:
                bound = block
                self._materials.bind[block]()
            if cull and faces != culled:
                culled = faces
                if faces is None:
                    ctx.disable(moderngl.CULL_FACE)
                else:
                    ctx.front_face = faces
                    ctx.enable(moderngl.CULL_FACE)
            if state_covers != covers:
                covers = state_covers
                toggle = ctx.enable_direct if covers else ctx.disable_direct
                toggle(_ALPHA_TO_COVERAGE)
            array.render_indirect(commands, moderngl.TRIANGLES, length, first)
        if covers:
            ctx.disable_direct(_ALPHA_TO_COVERAGE)
