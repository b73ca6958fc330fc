"""Key-frame animation of nodes, and linear blend skinning of the meshes that joints bend.

A bent vertex is at ``sum_i weight_i · world_from_joint_i · joint_from_bind_i · vertex``: its own
node's place does not matter. It is drawn as if its node stood at the skin's first joint, not
turned; matrices of joints lead there, so that single precision suffices however far away that is.

Source: Khronos glTF 2.0 specification, §3.7.3 (skins), §3.11 and appendix C (interpolation). The
shader's twin of skinning is ``shaders/include/skin.glsl``.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, normalize
from vrcomfort.rotations import slerp_numbers

ChannelPath = Literal["translation", "rotation", "scale"]
Interpolation = Literal["STEP", "LINEAR", "CUBICSPLINE"]


@dataclass(frozen=True, eq=False)
class Channel:
    """Key frames of one property of one node.

    `values` is (k, 3) or (k, 4); for CUBICSPLINE (k, 3, 3 or 4): in-tangent, value, out-tangent.
    """

    node: int
    path: ChannelPath
    times_s: Array
    values: Array
    interpolation: Interpolation

    @cached_property
    def times(self) -> list[float]:
        """Return the times as numbers: looking among few is faster so.

        Values are not kept: tasks write theirs before each frame.
        """
        found: list[float] = self.times_s.tolist()
        return found


@dataclass(frozen=True)
class Animation:
    """Channels that loop together every `duration_s`; all animations of a scene always play."""

    name: str
    channels: tuple[Channel, ...]
    duration_s: float


def sample(channel: Channel, time_s: float) -> list[float]:
    """Return the channel's 3 or 4 numbers at `time_s`, clamped to its first and last key."""
    times = channel.times
    last = max(len(times) - 2, 0)
    key = min(max(bisect_right(times, time_s) - 1, 0), last)
    after = min(key + 1, len(times) - 1)
    span_s = times[after] - times[key]
    t = 0.0 if span_s <= 0 else min(max((time_s - times[key]) / span_s, 0.0), 1.0)
    if channel.interpolation == "CUBICSPLINE":
        value = _hermite(channel.values[key], channel.values[after], t, span_s)
        found: list[float] = (normalize(value) if channel.path == "rotation" else value).tolist()
        return found
    a: list[float] = channel.values[key].tolist()
    b: list[float] = channel.values[after].tolist()
    if channel.interpolation == "STEP":
        return b if t >= 1.0 else a
    if channel.path == "rotation":
        return slerp_numbers(a, b, t)
    return [each + (other - each) * t for each, other in zip(a, b, strict=True)]


def _hermite(a: Array, b: Array, t: float, span_s: float) -> Array:
    """Return the cubic through two (3, n) keys of in-tangent, value and out-tangent."""
    t2, t3 = t * t, t * t * t
    return np.asarray(
        (2 * t3 - 3 * t2 + 1) * a[1]
        + (t3 - 2 * t2 + t) * span_s * a[2]
        + (3 * t2 - 2 * t3) * b[1]
        + (t3 - t2) * span_s * b[0]
    )


def sample_all(
    animations: tuple[Animation, ...], time_s: float
) -> dict[tuple[int, str], list[float]]:
    """Return the value of every animated (node, path) at `time_s`, animations looping."""
    return {
        (channel.node, channel.path): sample(
            channel, time_s % animation.duration_s if animation.duration_s > 0 else 0.0
        )
        for animation in animations
        for channel in animation.channels
    }


@dataclass(frozen=True, eq=False)
class Skin:
    """Nodes that bend meshes.

    Parameters
    ----------
    joints
        (j,) nodes.
    joint_from_bind
        (j, 4, 4) from the mesh as it is in the file to each joint.
    """

    name: str
    joints: tuple[int, ...]
    joint_from_bind: Array


@dataclass(frozen=True, eq=False)
class Bending:
    """Which joints of a skin bend each vertex of a mesh, and how much.

    Parameters
    ----------
    joints
        (n, 4) index into `Skin.joints`.
    weights
        (n, 4) that add up to 1.
    """

    joints: NDArray[np.uint16]
    weights: NDArray[np.float32]


class Skins:
    """All skins of a scene, their joints in one list.

    Parameters
    ----------
    skin_of_node
        (nodes,) index of each node's skin, or None.

    Attributes
    ----------
    first
        (skins,) where in the list the joints of each skin begin.
    """

    def __init__(self, skins: Sequence[Skin], skin_of_node: Sequence[int | None]) -> None:
        counts = [len(skin.joints) for skin in skins]
        self.first = np.cumsum([0, *counts])[:-1]
        self._joints = np.array([joint for skin in skins for joint in skin.joints], dtype=np.intp)
        self._joint_from_bind = np.concatenate(
            [np.zeros((0, 4, 4)), *(skin.joint_from_bind for skin in skins)]
        )
        roots = np.array([skin.joints[0] if skin.joints else 0 for skin in skins], dtype=np.intp)
        self._root = np.repeat(roots, counts)
        used = [(node, roots[skin]) for node, skin in enumerate(skin_of_node) if skin is not None]
        self._bent, self._stands_at = np.array(used, dtype=np.intp).reshape(-1, 2).T

    @property
    def count(self) -> int:
        """Return the number of joints of all skins."""
        return len(self._joints)

    def place_from_bind(self, world_from_node: Array) -> Array:
        """Return (joints, 4, 4) from the mesh as it is in the file to where its skin stands."""
        matrices: Array = world_from_node[self._joints] @ self._joint_from_bind
        matrices[:, :3, 3] -= world_from_node[self._root, :3, 3]
        return matrices

    def stand(self, world_from_node: Array) -> Array:
        """Return (nodes, 4, 4) with every node that has a skin at its first joint, not turned."""
        if not len(self._bent):
            return world_from_node
        standing = world_from_node.copy()
        standing[self._bent] = np.eye(4)
        standing[self._bent, :3, 3] = world_from_node[self._stands_at, :3, 3]
        return standing


def bent(matrices: Array, positions: NDArray[np.float32], bending: Bending) -> Array:
    """Return (n, 3) positions of vertices that joints bend.

    Parameters
    ----------
    matrices
        (j, 4, 4) of the skin's joints, of `Skins.place_from_bind`.
    positions
        (n, 3) as they are in the file.
    """
    blended = np.einsum("nk,nkij->nij", bending.weights, matrices[bending.joints])
    return np.asarray(np.einsum("nij,nj->ni", blended[:, :3, :3], positions) + blended[:, :3, 3])
