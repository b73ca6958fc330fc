"""Where the things of a scene are, which of them are seen, and their rows on the GPU."""

from __future__ import annotations

from typing import Literal

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.gpu import gl
from vrcomfort.render import culling
from vrcomfort.render.draw_list import COMMAND, DrawList
from vrcomfort.render.lighting import LampReach
from vrcomfort.scene.data import Scene
from vrcomfort.scene.node_poses import NodePoses, relative_rows

Rows = NDArray[np.intp]
Movement = Literal["all", "static", "moving"]

ROW_FORMAT = "4f4 4f4 4f4 4f4 1f4 1f4/i"
ROW_NAMES = ("in_relative_x", "in_relative_y", "in_relative_z", "in_thing", "in_material",
             "in_first_joint")  # fmt: skip
PREVIOUS_FORMAT = "4f4 4f4 4f4/i"
PREVIOUS_NAMES = ("in_previous_x", "in_previous_y", "in_previous_z")
_ROW, _MATRIX = 18, 12
"""Numbers in a row, and those among them that are the rows of a 3 × 4 matrix."""


class RowBuffers:
    """What the GPU reads of drawn things: a row and an indirect command for each.

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

    def write(
        self,
        rows: NDArray[np.float32],
        commands: NDArray[np.void],
        previous: NDArray[np.float32] | None = None,
    ) -> None:
        """Put things in drawing order; row i belongs to command i."""
        commands["base_instance"] = np.arange(len(commands))
        _replace(self.rows, rows)
        _replace(self.commands, commands)
        if self.previous is not None and previous is not None:
            _replace(self.previous, previous)


def _replace(buffer: moderngl.Buffer, data: NDArray[np.generic]) -> None:
    buffer.orphan(data.nbytes)  # what is being drawn from it stays as it is
    buffer.write(data)


class SceneRows:
    """One row (a 3 × 4 matrix and a few numbers) and one indirect command per thing.

    Parameters
    ----------
    velocity
        Whether rows of the frame before are needed.

    Attributes
    ----------
    in_use
        (rows,) bool, the level of detail for where the head is.
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
        """Compute what never changes: boxes and lamps of what does not move."""
        table = self._list
        self._locked = self._poses.locked[table.node]
        self._moving = self._poses.moving[table.node] | self._locked
        self._chosen: dict[Movement, NDArray[np.bool_] | bool] = {
            "all": True,
            "static": ~self._moving,
            "moving": self._moving,
        }
        self._moving_rows = np.flatnonzero(self._moving)
        self.shadow = table.casts_shadow & ~self._locked
        world = self._poses.world_from_node(0.0, Pose())
        self.joints = self.previous_joints = self._poses.place_from_bind(0.0)
        self.centers, self._halves = table.world_boxes(world, np.arange(len(table.node)))
        self._box_skinned(world)
        self._rows = np.zeros((len(table.node), _ROW), dtype=np.float32)
        self._rows[:, _MATRIX] = table.ambient
        self._rows[:, _MATRIX + 1] = self._locked
        self._rows[:, _MATRIX + 2] = self._reach.bits(self.centers, self._halves)
        self._rows[:, _MATRIX + 3] = table.semantic_weight
        self._rows[:, _MATRIX + 4] = table.material
        self._rows[:, _MATRIX + 5] = table.first_joint
        self._node_centers = table.node_centers(self.centers, self._halves, len(self._scene.nodes))
        self._levels_move = bool((self._moving & table.has_levels).any())
        self._world = self._previous_world = world
        self._updated: tuple[float, float, Pose] | None = None
        self.update(0.0, Pose(), 0.0)

    @property
    def moves(self) -> bool:
        """Return whether anything in the scene moves by itself (not with the head)."""
        return self._poses.any_moving

    def update(self, time_s: float, head: Pose, before_s: float) -> None:
        """Move everything to where it is at a time; doing it again for the other eye is free."""
        if self._updated == (time_s, before_s, head):
            return
        self._updated = (time_s, before_s, head)
        self._world = self._poses.world_from_node(time_s, head)
        self._previous_world = (
            self._poses.world_from_node(before_s, head) if before_s != time_s else self._world
        )
        self.joints = self._poses.place_from_bind(time_s)
        self.previous_joints = self._poses.place_from_bind(before_s)
        self._update_moving()
        if self._levels_move:
            nodes = len(self._scene.nodes)
            self._node_centers = self._list.node_centers(self.centers, self._halves, nodes)
        self.in_use = self.level_in_use(head.position)

    def _update_moving(self) -> None:
        rows = self._moving_rows
        if not len(rows):
            return
        centers, halves = self._list.world_boxes(self._world, rows)
        self.centers[rows], self._halves[rows] = centers, halves
        self._box_skinned(self._world)
        self._rows[rows, _MATRIX + 2] = self._reach.bits(self.centers[rows], self._halves[rows])

    def _box_skinned(self, world: Array) -> None:
        boxes = self._list.skin_boxes
        if len(boxes.rows):
            found = boxes.world_boxes(world, self.joints)
            self.centers[boxes.rows], self._halves[boxes.rows] = found

    def level_in_use(self, viewpoint_m: Array) -> NDArray[np.bool_]:
        """Return (rows,) whether a thing is at the level of detail for this viewpoint."""
        return self._list.level_in_use(culling.lengths(self._node_centers - viewpoint_m))

    def seen(self, planes: Array, from_origin: Array) -> NDArray[np.bool_]:
        """Return (..., rows) whether a thing's box is within planes.

        Parameters
        ----------
        from_origin
            (rows, 3), or (views, rows, 3): `centers` less the origins of the planes.
        """
        return culling.visible(planes, from_origin, self._halves)

    def chosen(self, movement: Movement) -> NDArray[np.bool_] | bool:
        """Return (rows,) what moves, what does not, or all."""
        return self._chosen[movement]

    def write(self, buffers: RowBuffers, order: Rows, origin_m: Array) -> None:
        """Write things in drawing order.

        Parameters
        ----------
        order
            Rows; a thing that is drawn in several views is there several times.
        origin_m
            (3,), or (len(order), 3): the viewpoint that each is drawn from.
        """
        if not len(order):
            return
        nodes = self._list.node[order]
        rows = self._rows[order]
        rows[:, :_MATRIX] = relative_rows(self._world, nodes, origin_m).reshape(-1, _MATRIX)
        before = None
        if buffers.previous is not None:
            before = relative_rows(self._previous_world, nodes, origin_m).astype(np.float32)
        buffers.write(rows, self._list.commands[order], before)
