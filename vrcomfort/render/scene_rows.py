"""Where the things of a scene are, which of them are seen, and their rows on the GPU."""

from __future__ import annotations

from typing import Literal

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.gpu import gl
from vrcomfort.render import culling, lighting
from vrcomfort.render.draw_list import COMMAND, DrawList
from vrcomfort.scene.data import Scene
from vrcomfort.scene.node_poses import HandPoses, NodePoses, relative_rows

Rows = NDArray[np.intp]
Movement = Literal["all", "static", "moving"]


class SceneRows:
    """One row (a 3 × 4 matrix and a few numbers) and one indirect command per thing.

    Parameters
    ----------
    velocity
        Whether rows of the frame before are needed.

    Attributes
    ----------
    buffer, previous_buffer, commands
        What vertex arrays and indirect draws read.
    in_use
        (rows,) bool, the level of detail for where the head is.
    """

    def __init__(
        self, ctx: moderngl.Context, scene: Scene, table: DrawList, *, velocity: bool
    ) -> None:
        self._scene = scene
        self._list = table
        self._poses = NodePoses(scene)
        rows = max(len(table.node), 1)
        self.buffer = gl.dynamic_buffer(ctx, rows * 64)
        self.previous_buffer = gl.dynamic_buffer(ctx, rows * 48) if velocity else None
        self.commands = gl.dynamic_buffer(ctx, rows * COMMAND.itemsize)
        self._prepare()

    def _prepare(self) -> None:
        """Compute what never changes: boxes and lamps of what does not move."""
        table = self._list
        self._locked = self._poses.locked[table.node]
        self._moving = self._poses.moving[table.node] | self._locked
        self._moving_rows = np.flatnonzero(self._moving)
        self.shadow = table.casts_shadow & ~self._locked
        self._thing = np.zeros((len(table.node), 4), dtype=np.float32)
        self._thing[:, 0] = table.ambient
        self._thing[:, 1] = self._locked
        self._thing[:, 3] = table.semantic_weight
        world = self._poses.world_from_node(0.0, Pose())
        self.centers, self._halves = table.world_boxes(world, np.arange(len(table.node)))
        self._thing[:, 2] = lighting.lamp_bits(self._scene, self.centers, self._halves)
        self._world = self._previous_world = world
        self._updated: tuple[float, float, Pose] | None = None
        self.update(0.0, Pose(), 0.0)

    @property
    def moves(self) -> bool:
        """Return whether anything in the scene moves by itself (not with the head)."""
        return bool(self._poses.moving.any())

    @property
    def hands_move(self) -> bool:
        """Return whether a hand counts as having been elsewhere a frame ago."""
        return self._poses.hands_move

    def place_hands(self, hands: HandPoses, before: HandPoses, *, with_head: bool) -> None:
        """Say where the hands are; the next `update` puts there what is bound to them.

        Parameters
        ----------
        before
            Where they count as having been a frame ago: if `with_head`, as the present eye would
            have seen them then, else in the world.
        """
        self._thing[self._poses.in_hand[self._list.node], 1] = with_head
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
        self._update_moving()
        nodes = len(self._scene.nodes)
        self._node_centers = self._list.node_centers(self.centers, self._halves, nodes)
        self.in_use = self.level_in_use(head.position)

    def _update_moving(self) -> None:
        rows = self._moving_rows
        if not len(rows):
            return
        self.centers[rows], self._halves[rows] = self._list.world_boxes(self._world, rows)
        bits = lighting.lamp_bits(self._scene, self.centers[rows], self._halves[rows])
        self._thing[rows, 2] = bits

    def level_in_use(self, viewpoint_m: Array) -> NDArray[np.bool_]:
        """Return (rows,) whether a thing is at the level of detail for this viewpoint."""
        return self._list.level_in_use(culling.lengths(self._node_centers - viewpoint_m))

    def seen(self, planes: Array, origin_m: Array) -> NDArray[np.bool_]:
        """Return (..., rows) whether a thing's box is within the planes around `origin_m`."""
        return culling.visible(planes, self.centers - origin_m, self._halves)

    def chosen(self, movement: Movement) -> NDArray[np.bool_]:
        """Return (rows,) what moves, what does not, or all."""
        if movement == "all":
            return np.ones_like(self._moving)
        return self._moving if movement == "moving" else ~self._moving

    def upload(self, order: Rows, origin_m: Array, *, previous: bool) -> None:
        """Write rows and commands in drawing order; row i belongs to command i."""
        if not len(order):
            return
        nodes = self._list.node[order]
        rows = np.empty((len(order), 4, 4), dtype=np.float32)
        rows[:, :3] = relative_rows(self._world, nodes, origin_m)
        rows[:, 3] = self._thing[order]
        self.buffer.orphan(rows.nbytes)
        self.buffer.write(rows)
        if previous and self.previous_buffer is not None:
            before = relative_rows(self._previous_world, nodes, origin_m).astype(np.float32)
            self.previous_buffer.orphan(before.nbytes)
            self.previous_buffer.write(before)
        commands = self._list.commands[order]
        commands["base_instance"] = np.arange(len(order))
        self.commands.orphan(commands.nbytes)
        self.commands.write(commands)
