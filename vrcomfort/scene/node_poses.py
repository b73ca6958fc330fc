"""Poses of every node, now and a frame ago; only moving nodes are computed again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.scene.data import Scene, parent_from_node

NOT_DRAWN = np.diag([0.0, 0.0, 0.0, 1.0])
"""Shrinks a thing to a point, which covers no pixel."""

KEPT = 2
"""Times whose matrices are kept: this frame's and the one before."""


_NO_JOINTS = np.zeros((0, 4, 4))


class Placed(NamedTuple):
    """Where things are at a time: (nodes, 4, 4), and (joints, 4, 4) of all skins."""

    world_from_node: Array
    place_from_bind: Array


class HandPoses(NamedTuple):
    """world-from-hand of the left and the right hand; None where the headset does not know it."""

    left: Pose | None = None
    right: Pose | None = None


NO_HANDS = HandPoses()


class NodePoses:
    """World-from-node matrices of a scene.

    Attributes
    ----------
    locked
        (n,) True for nodes that go with the head or a hand.
    in_hand
        (n,) True for those that go with a hand.
    hands, hands_before
        Where the hands are now, and count as having been a frame ago.

    `Scene.world_from_node` walks all nodes; this keeps the static ones and walks the moving.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        # Ended by the world itself, the parent -1 of nodes at the root.
        self._static = np.concatenate([scene.world_from_joint(0.0), np.eye(4)[None]])
        head_locked = _locked(scene)
        self._of_hand = [_in_hand(scene, hand) for hand in HandPoses._fields]
        self.in_hand = self._of_hand[0] | self._of_hand[1]
        self._head_locked = head_locked & ~self.in_hand
        self.locked: NDArray[np.bool_] = head_locked | self.in_hand
        self.hands = self.hands_before = NO_HANDS
        self.moving = np.array([node.moving for node in scene.nodes], dtype=bool)
        self._generations = _generations(scene)
        self._walk = [node for nodes, _ in self._generations for node in nodes.tolist()]
        self.any_moving = bool(self._walk)
        self._any_locked = bool(self.locked.any())
        self._placed: dict[float, Placed] = {}

    def place_from_bind(self, time_s: float) -> Array:
        """Return (joints, 4, 4) of all skins (`Skins.place_from_bind`). Do not write into it."""
        return self._at(time_s).place_from_bind

    def _at(self, time_s: float) -> Placed:
        placed = self._placed.get(time_s)
        if placed is None:
            world, skins = self._place(time_s), self._scene.all_skins
            joints = skins.place_from_bind(world) if skins.count else _NO_JOINTS
            placed = Placed(skins.stand(world), joints)
            self._placed = dict([*self._placed.items(), (time_s, placed)][-KEPT:])
        return placed

    @property
    def hands_move(self) -> bool:
        """Return whether a hand counts as having been elsewhere a frame ago."""
        return self.hands != self.hands_before

    def world_from_node(self, time_s: float, head: Pose, hands: HandPoses = NO_HANDS) -> Array:
        """Return (n, 4, 4) world-from-node at `time_s`.

        Head-locked nodes hang on `head`, nodes bound to a hand on that of `hands`; without it they
        are not drawn.

        Do not write into it: it is kept, for the next frame asks again for this one's time.
        """
        world = self._at(time_s).world_from_node
        if not self._any_locked:
            return world
        world = world.copy()
        world[self._head_locked] = head.matrix() @ world[self._head_locked]
        for hand, pose in zip(self._of_hand, hands, strict=True):
            world[hand] = NOT_DRAWN if pose is None else pose.matrix() @ world[hand]
        return world

    def _place(self, time_s: float) -> Array:
        world, scene = self._static.copy(), self._scene
        if self._walk:
            local = parent_from_node(scene.nodes, scene.animations, time_s, self._walk)
            for nodes, parents in self._generations:
                of_these, local = local[: len(nodes)], local[len(nodes) :]
                world[nodes] = world[parents] @ of_these
        return world[:-1]


def _generations(scene: Scene) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Return the moving nodes and their parents: first those with static parents, and so on."""
    found: list[tuple[list[int], list[int]]] = []
    generation: dict[int, int] = {}
    for index, node in enumerate(scene.nodes):
        if node.moving:
            own = generation[index] = generation.get(node.parent, -1) + 1
            if own == len(found):
                found.append(([], []))
            found[own][0].append(index)
            found[own][1].append(node.parent)
    return [(np.array(nodes), np.array(parents)) for nodes, parents in found]


def relative_rows(world_from_node: Array, nodes: NDArray[np.intp], origin_m: Array) -> Array:
    """Return (n, 3, 4) relative-from-node rows, subtracted in float64."""
    rows = world_from_node.take(nodes, axis=0)[:, :3]  # in less time than by indexing
    rows[:, :, 3] -= origin_m
    return np.asarray(rows)


def _locked(scene: Scene) -> NDArray[np.bool_]:
    """Return (n,) True for nodes that are head-locked, or below one that is."""
    locked = np.zeros(len(scene.nodes), dtype=bool)
    for index, node in enumerate(scene.nodes):
        locked[index] = node.head_locked or (node.parent >= 0 and locked[node.parent])
    return locked


def _in_hand(scene: Scene, hand: str) -> NDArray[np.bool_]:
    """Return (n,) True for nodes that are bound to a hand, or below one that is."""
    bound: list[str | None] = []
    for node in scene.nodes:
        bound.append(node.hand or (bound[node.parent] if node.parent >= 0 else None))
    return np.array([each == hand for each in bound], dtype=bool)
