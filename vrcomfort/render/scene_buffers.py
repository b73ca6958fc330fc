"""Buffers of a scene on the GPU: vertices, one row for each instance, joints, clip matrices.

Vertices are written once. A row holds the inputs of the vertex shader for an instance in a
view: a 3 × 4 matrix and a few numbers; rows of visible instances are written each frame.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.gpu import gl
from vrcomfort.optics.focus import RAYS
from vrcomfort.render import culling
from vrcomfort.render.draw_list import COMMAND, DrawList
from vrcomfort.render.lighting import LampReach
from vrcomfort.scene.data import Primitive, Scene
from vrcomfort.scene.node_poses import HandPoses, NodePoses, relative_rows

# Half floats for normals and colours: 11 bits are finer than an 8-bit image shows. Not for texture
# coordinates, which grow large where an image repeats. A fourth component keeps attributes aligned
# to 4 bytes.
_VERTEX = np.dtype(
    [
        ("position", np.float32, 3),
        ("normal", np.float16, 4),
        ("uv", np.float32, 2),
        ("color", np.float16, 4),
    ]
)
VERTEX_FORMAT = "3f4 4f2 2f4 4f2"
SECOND_UV_FORMAT = "2f4"
SECOND_UV_NAMES = ("in_uv_1",)
VERTEX_NAMES = ("in_position", "in_normal", "in_uv", "in_color")


def vertex_bytes(primitives: tuple[Primitive, ...]) -> bytes:
    """Return the vertices of all primitives, one after the other."""
    # A scene may be empty, a buffer may not.
    return b"".join(_packed(primitive).tobytes() for primitive in primitives) or bytes(64)


def _packed(primitive: Primitive) -> NDArray[np.void]:
    vertices = np.zeros(len(primitive.positions), _VERTEX)
    vertices["position"] = primitive.positions
    vertices["normal"][:, :3] = primitive.normals
    vertices["uv"] = primitive.uvs
    vertices["color"] = 1 if primitive.colors is None else primitive.colors
    return vertices


def second_uv_bytes(primitives: tuple[Primitive, ...]) -> bytes | None:
    """Return the second texture coordinates of all vertices, or None where no primitive has any."""
    if all(primitive.uvs_1 is None for primitive in primitives):
        return None
    return b"".join(
        np.asarray(np.zeros_like(p.uvs) if p.uvs_1 is None else p.uvs_1, np.float32).tobytes()
        for p in primitives
    )


_BENDING = np.dtype([("joints", np.uint16, 4), ("weights", np.float32, 4)])
BENDING_FORMAT = "4u2 4f4"
BENDING_NAMES = ("in_joints", "in_weights")


def bending_bytes(primitives: tuple[Primitive, ...]) -> bytes | None:
    """Return joints and weights of all vertices, or None where no primitive has any."""
    if all(primitive.bending is None for primitive in primitives):
        return None
    return b"".join(_bending(primitive).tobytes() for primitive in primitives)


def _bending(primitive: Primitive) -> NDArray[np.void]:
    vertices = np.zeros(len(primitive.positions), _BENDING)
    if primitive.bending is not None:
        vertices["joints"] = primitive.bending.joints
        vertices["weights"] = primitive.bending.weights
    return vertices


def index_bytes(primitives: tuple[Primitive, ...]) -> bytes:
    """Return the indices of all primitives, each counting from its own first vertex."""
    return b"".join(np.asarray(p.indices, dtype=np.uint32).tobytes() for p in primitives) or bytes(
        12
    )


Rows = NDArray[np.intp]
Movement = Literal["all", "static", "moving"]

ROW_FORMAT = "4f4 4f4 4f4 4f4 1f4 1f4/i"
ROW_NAMES = ("in_relative_x", "in_relative_y", "in_relative_z", "in_thing", "in_material",
             "in_first_joint")  # fmt: skip
PREVIOUS_FORMAT = "4f4 4f4 4f4/i"
PREVIOUS_NAMES = ("in_previous_x", "in_previous_y", "in_previous_z")
_BASE_INSTANCE = 4
"""Place in a command."""

_ROW, _MATRIX = 18, 12
"""Numbers in a row, and those among them that are the rows of a 3 × 4 matrix."""

# Columns after the matrix: `in_thing` (scene.vert), then `in_material` and `in_first_joint`.
_AMBIENT, _LOCKED, _LAMPS, _WEIGHT, _MATERIAL, _FIRST_JOINT = range(_MATRIX, _ROW)
_VIEW = _AMBIENT  # in depth.vert


class RowBuffers:
    """Instance rows and indirect commands on the GPU.

    Parameters
    ----------
    rows
        As many as are likely to be drawn at once.
    previous
        Whether rows of the frame before are needed.
    """

    def __init__(self, ctx: moderngl.Context, rows: int, *, previous: bool) -> None:
        most = max(rows, 1)
        self.rows = gl.dynamic_buffer(ctx, most * _ROW * 4)
        self.previous = gl.dynamic_buffer(ctx, most * _MATRIX * 4) if previous else None
        self.commands = gl.dynamic_buffer(ctx, most * COMMAND.itemsize)
        self._write_rows = gl.rewriter(ctx, self.rows)
        self._write_commands = gl.rewriter(ctx, self.commands)
        self._write_previous = gl.rewriter(ctx, self.previous) if self.previous else None

    def write(
        self,
        rows: NDArray[np.float32],
        commands: NDArray[np.uint32],
        previous: NDArray[np.float32] | None = None,
    ) -> None:
        """Write instances in drawing order; row i belongs to command i."""
        # Instanced attributes are read from `base_instance` on: each command has its own row.
        commands[:, _BASE_INSTANCE] = np.arange(len(commands))
        self._write_rows(rows.tobytes())
        self._write_commands(commands.tobytes())
        if self._write_previous is not None and previous is not None:
            self._write_previous(previous.tobytes())


class DetailLevels(NamedTuple):
    """Rows, and the distances from and until which each is drawn."""

    rows: Rows
    from_m: Array
    until_m: Array
    any: bool
    """Whether one of them is not for every distance."""

    @classmethod
    def of(cls, table: DrawList, rows: Rows) -> DetailLevels:
        """Return those of some rows of a table."""
        any_levels = bool(table.has_levels[rows].any())
        return cls(rows, table.from_m[rows], table.until_m[rows], any_levels)

    def in_use(self, centers: Array, viewpoint_m: Array) -> NDArray[np.bool_]:
        """Return (rows,) whether each is at the level of detail for this viewpoint.

        `centers` is (3, n) of all rows, of which those with levels count.
        """
        if not self.any:
            return np.ones(len(self.rows), dtype=np.bool_)
        distance_m = culling.lengths(centers.take(self.rows, axis=1) - viewpoint_m[:, None])
        return (distance_m >= self.from_m) & (distance_m < self.until_m)


class SceneRows:
    """One row (a 3 × 4 matrix and a few numbers) and one indirect command per instance.

    Parameters
    ----------
    velocity
        Whether rows of the frame before are needed.

    Attributes
    ----------
    in_use
        Rows at the level of detail for where the head is.
    distance_m
        Of each of them from the head.
    joints, previous_joints
        (joints, 4, 4) place-from-bind of all skins.
    """

    def __init__(self, scene: Scene, table: DrawList) -> None:
        self._scene = scene
        self._list = table
        self._poses = NodePoses(scene)
        self._reach = LampReach(scene.environment)
        self._prepare()

    def _prepare(self) -> None:
        """Compute the boxes and lamps of static instances, once."""
        table = self._list
        self._locked = self._poses.locked[table.node]
        self._moving = self._poses.moving[table.node] | self._locked
        self._moves = PlacedRows(table, self._moving)
        casts = table.casts_shadow & ~self._locked & ~table.blended
        self._casting: dict[Movement, DetailLevels] = {
            "all": DetailLevels.of(table, casts.nonzero()[0]),
            "static": DetailLevels.of(table, (casts & ~self._moving).nonzero()[0]),
            "moving": DetailLevels.of(table, (casts & self._moving).nonzero()[0]),
        }
        self._leveled = DetailLevels.of(table, table.has_levels.nonzero()[0])
        self._is_in_use = np.ones(len(table.node), dtype=bool)
        self._commands = table.commands.view(np.uint32).reshape(-1, 5)
        world = self._poses.world_from_node(0.0, Pose())
        self.joints = self.previous_joints = self._poses.place_from_bind(0.0)
        self._world = self._previous_world = world
        self._boxes = np.ones((7, len(table.node)))
        self._level_centers = np.zeros((3, len(table.node)))
        self._rows = np.zeros((len(table.node), _ROW), dtype=np.float32)
        self._rows[:, _AMBIENT] = table.ambient
        self._rows[:, _LOCKED] = self._locked
        self._rows[:, _WEIGHT] = table.semantic_weight
        self._rows[:, _MATERIAL] = table.material
        self._rows[:, _FIRST_JOINT] = table.first_joint
        self._place(PlacedRows(table, np.ones(len(table.node), dtype=bool)))
        self._updated: tuple[float, float, Pose] | None = None
        self.update(0.0, Pose(), 0.0)

    @property
    def moves(self) -> bool:
        """Return whether anything in the scene moves by itself (not with the head)."""
        return self._poses.any_moving

    @property
    def hands_move(self) -> bool:
        """Return whether a hand counts as having been elsewhere a frame ago."""
        return self._poses.hands_move

    def place_hands(self, hands: HandPoses, before: HandPoses, *, with_head: bool) -> None:
        """Set the poses of the hands; the next `update` moves the nodes bound to them.

        Parameters
        ----------
        before
            Where they count as having been a frame ago: if `with_head`, as the present eye would
            have seen them then, else in the world.
        """
        self._rows[self._poses.in_hand[self._list.node], _LOCKED] = with_head
        if (hands, before) != (self._poses.hands, self._poses.hands_before):
            self._poses.hands, self._poses.hands_before = hands, before
            self._updated = None

    def update(self, time_s: float, head: Pose, before_s: float) -> None:
        """Move everything to where it is at a time; doing it again for the other eye is free."""
        if self._updated == (time_s, before_s, head):
            return
        self._updated = (time_s, before_s, head)
        poses = self._poses
        self._world = poses.world_from_node(time_s, head, poses.hands)
        self._previous_world = (
            poses.world_from_node(before_s, head, poses.hands_before)
            if before_s != time_s or poses.hands_move
            else self._world
        )
        if self._scene.skins:
            self.joints = self._poses.place_from_bind(time_s)
            self.previous_joints = self._poses.place_from_bind(before_s)
        self._place(self._moves)
        self._head_m = head.position
        leveled = self._leveled
        self._is_in_use[leveled.rows] = leveled.in_use(self._level_centers, self._head_m)
        self.in_use = self._is_in_use.nonzero()[0]
        self._in_use_from_head = self._from_head(self.in_use)
        self.distance_m = culling.lengths(self._in_use_from_head[:3])

    def _place(self, placed: PlacedRows) -> None:
        """Compute the boxes and lamps of some rows."""
        rows = placed.rows
        if not len(rows):
            return
        centers, halves = self._bent(rows, *placed.boxes(self._world))
        self._boxes[:3, rows], self._boxes[3:6, rows] = centers.T, halves.T
        self._rows[rows, _LAMPS] = self._reach.bits(centers, halves)
        if len(placed.with_levels):
            self._level_centers[:, placed.with_levels] = placed.level_centers(centers, halves).T

    def _bent(self, rows: Rows, centers: Array, halves: Array) -> tuple[Array, Array]:
        """Return the boxes of (ascending) rows, of skinned ones as their joints bend them."""
        bent = self._list.skin_boxes
        if len(bent.rows):
            among = np.isin(bent.rows, rows)
            at = np.searchsorted(rows, bent.rows[among])
            found = bent.world_boxes(self._world, self.joints)
            centers[at], halves[at] = found[0][among], found[1][among]
        return centers, halves

    def _from_head(self, rows: Rows) -> Array:
        """Return (7, rows) boxes around the head."""
        boxes = self._boxes.take(rows, axis=1)
        boxes[:3] -= self._head_m[:, None]
        return boxes

    def seen(self, planes: Array, origins_m: Array) -> NDArray[np.bool_]:
        """Return (views, rows in use) whether an instance's box is within the planes of each view.

        Parameters
        ----------
        planes
            (views, k, 4) around
        origins_m
            (views, 3) world.
        """
        around_head = culling.from_origins(planes, origins_m - self._head_m)
        return culling.visible(around_head, self._in_use_from_head)

    def casting(self, planes: Array, origin_m: Array, movement: Movement) -> Rows:
        """Return the shadow casters within planes, levels of detail by distance from `origin_m`."""
        casting = self._casting[movement]
        rows = casting.rows[casting.in_use(self._level_centers, origin_m)]
        around_head = culling.from_origins(planes[None], origin_m[None] - self._head_m)
        seen: Rows = rows[culling.visible(around_head[0], self._from_head(rows))]
        return seen

    def write(
        self,
        buffers: RowBuffers,
        order: Rows,
        origin_m: Array,
        view: Rows | None = None,
        *,
        numbered: bool = False,
    ) -> None:
        """Write instances in drawing order.

        Parameters
        ----------
        order
            Rows; an instance that is drawn in several views is there several times.
        origin_m
            (3,), or (len(order), 3): the viewpoint that each is drawn from.
        view
            (len(order),) for depth alone: whose matrix of `ClipBlock` each takes.
        numbered
            With the numbers of nodes, from 1, in the place of semantic weights.
        """
        if not len(order):
            return
        nodes = self._list.node[order]
        rows = self._rows[order]
        rows[:, :_MATRIX] = relative_rows(self._world, nodes, origin_m).reshape(-1, _MATRIX)
        if view is not None:
            rows[:, _VIEW] = view
        if numbered:
            rows[:, _WEIGHT] = nodes + 1
        before = None
        if buffers.previous is not None:
            # From the present eye: the shader adds the eye's own step (`camera.CameraMotion`).
            before = relative_rows(self._previous_world, nodes, origin_m).astype(np.float32)
        buffers.write(rows, self._commands[order], before)


class PlacedRows:
    """Some rows of a scene, and where they are.

    Parameters
    ----------
    chosen
        (rows of `table`,) which ones; all rows of a node, or none.

    Attributes
    ----------
    rows
        They, in the table.
    with_levels
        Those of them that are not for every distance.
    """

    def __init__(self, table: DrawList, chosen: NDArray[np.bool_]) -> None:
        self.rows = np.flatnonzero(chosen)
        self._node = table.node[self.rows]
        self._centers, self._halves = table.centers[self.rows], table.halves[self.rows]
        # Rows of a node stand together; those of its finest level say where it is.
        self._finest = np.flatnonzero(table.base_level[self.rows])
        nodes = self._node[self._finest]
        self._first = np.flatnonzero(np.diff(nodes, prepend=-1))
        located = np.isin(self._node, nodes) & table.has_levels[self.rows]
        self.with_levels = self.rows[located]
        self._group = np.searchsorted(nodes[self._first], self._node[located])

    def boxes(self, world_from_node: Array) -> tuple[Array, Array]:
        """Return (rows, 3) centres and half extents of the world-space boxes."""
        return culling.transformed_boxes(world_from_node[self._node], self._centers, self._halves)

    def level_centers(self, centers: Array, halves: Array) -> Array:
        """Return (rows with levels, 3): where from the distance counts that decides a level."""
        center, half = centers[self._finest], halves[self._finest]
        lower = np.minimum.reduceat(center - half, self._first)
        upper = np.maximum.reduceat(center + half, self._first)
        return np.asarray(((lower + upper) / 2)[self._group])


JOINT_BINDING = 0


class JointBuffer:
    """Six rows for each joint (``include/skin.glsl``): its matrix now, and a frame ago."""

    def __init__(self, ctx: moderngl.Context, joints: int) -> None:
        self._rows = np.zeros((joints, 2, 3, 4), dtype=np.float32)
        self._buffer = gl.dynamic_buffer(ctx, self._rows.nbytes)
        self._rewrite = gl.rewriter(ctx, self._buffer)

    def write(self, place_from_bind: Array, previous: Array) -> None:
        """Take (joints, 4, 4) matrices of `Skins.place_from_bind`."""
        self._rows[:, 0], self._rows[:, 1] = place_from_bind[:, :3], previous[:, :3]
        self._rewrite(self._rows.tobytes())

    def bind(self) -> None:
        """Make the joints those that shaders see."""
        self._buffer.bind_to_storage_buffer(JOINT_BINDING)


CLIP_BINDING = 3


class ClipBlock:
    """The uniform block of ``depth.vert``: matrices of up to nine views, the rays of the focus."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._matrices = np.zeros((RAYS, 4, 4), dtype=np.float32)
        self._buffer = gl.dynamic_buffer(ctx, self._matrices.nbytes)
        self._rewrite = gl.rewriter(ctx, self._buffer)

    def write(self, clips_from_relative: Array) -> None:
        """Make (views, 4, 4) matrices those that shaders see."""
        found = clips_from_relative.swapaxes(-1, -2)  # GLSL stores columns
        self._matrices[: len(found)] = found
        self._rewrite(self._matrices.tobytes())
        self._buffer.bind_to_uniform_block(CLIP_BINDING)
