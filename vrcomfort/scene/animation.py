"""Key-frame animation: where each node is in its parent at a time.

Source: Khronos glTF 2.0 specification, §3.11 and appendix C (interpolation).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vrcomfort.geometry import Array, normalize, slerp

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


@dataclass(frozen=True)
class Animation:
    """Channels that loop together every `duration_s`; all animations of a scene always play."""

    name: str
    channels: tuple[Channel, ...]
    duration_s: float


def sample(channel: Channel, time_s: float) -> Array:
    """Return the channel's (3,) or (4,) value at `time_s`, clamped to its first and last key."""
    times = channel.times_s
    last = max(len(times) - 2, 0)
    key = min(max(int(times.searchsorted(time_s, side="right")) - 1, 0), last)
    after = min(key + 1, len(times) - 1)
    span_s = float(times[after] - times[key])
    t = 0.0 if span_s <= 0 else min(max((time_s - float(times[key])) / span_s, 0.0), 1.0)
    if channel.interpolation == "CUBICSPLINE":
        value = _hermite(channel.values[key], channel.values[after], t, span_s)
        return normalize(value) if channel.path == "rotation" else value
    a, b = channel.values[key], channel.values[after]
    if channel.interpolation == "STEP":
        return np.asarray(b if t >= 1.0 else a)
    return slerp(a, b, t) if channel.path == "rotation" else np.asarray(a + (b - a) * t)


def _hermite(a: Array, b: Array, t: float, span_s: float) -> Array:
    """Return the cubic through two (3, n) keys of in-tangent, value and out-tangent."""
    t2, t3 = t * t, t * t * t
    return np.asarray(
        (2 * t3 - 3 * t2 + 1) * a[1]
        + (t3 - 2 * t2 + t) * span_s * a[2]
        + (3 * t2 - 2 * t3) * b[1]
        + (t3 - t2) * span_s * b[0]
    )


def sample_all(animations: tuple[Animation, ...], time_s: float) -> dict[tuple[int, str], Array]:
    """Return the value of every animated (node, path) at `time_s`, animations looping."""
    return {
        (channel.node, channel.path): sample(
            channel, time_s % animation.duration_s if animation.duration_s > 0 else 0.0
        )
        for animation in animations
        for channel in animation.channels
    }
