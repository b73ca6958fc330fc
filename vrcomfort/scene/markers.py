"""Balls that a session puts into a scene and moves: drawn with it, so that effects act on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.data import Material, Node, Primitive, Rgb, Scene

PREFIX = "marker_"
_RINGS, _SECTORS = 12, 24
_GLOW = 0.35
"""Share of its colour that a ball has in the dark."""


class Shown(NamedTuple):
    """A ball as it is drawn: its number from 1, where it is in the world, radius, linear RGB.

    A radius of 0 is a ball that is not to be seen.
    """

    ball: int
    x_m: float
    y_m: float
    z_m: float
    radius_m: float
    red: float
    green: float
    blue: float

    @property
    def color(self) -> Rgb:
        """Return its linear RGB."""
        return self.red, self.green, self.blue


class Markers:
    """The balls of one scene.

    A ball is a node with an animation of one key frame, which is written anew before a frame is
    drawn. So what it was a frame ago is known to whatever asks for velocities. One that appears is
    first put where it will be and has no size for a frame: it grows there, and leaves no streak
    from where it was.

    Attributes
    ----------
    scene
        The scene with the balls in it; none of them is to be seen at first.
    """

    def __init__(self, scene: Scene, colors: Sequence[Rgb]) -> None:
        count, first = len(colors), len(scene.nodes)
        self._colors = tuple(colors)
        self._places = [np.zeros((1, 3)) for _ in colors]
        self._sizes = [np.zeros((1, 3)) for _ in colors]
        self._coming = [False for _ in colors]
        materials = tuple(_material(k, color) for k, color in enumerate(colors))
        balls = tuple(_ball(len(scene.materials) + k) for k in range(count))
        nodes = tuple(
            Node(
                f"{PREFIX}{k}",
                scale=np.zeros(3),
                mesh=(len(scene.primitives) + k,),
                semantic_weight=1.0,
                moving=True,
                casts_shadow=False,
            )
            for k in range(count)
        )
        channels = [
            channel
            for k in range(count)
            for channel in (
                _channel(first + k, "translation", self._places[k]),
                _channel(first + k, "scale", self._sizes[k]),
            )
        ]
        self.scene = replace(
            scene,
            nodes=(*scene.nodes, *nodes),
            primitives=(*scene.primitives, *balls),
            materials=(*scene.materials, *materials),
            animations=(*scene.animations, Animation("markers", tuple(channels), 0.0)),
        )

    def place(self, balls: Sequence[tuple[Array, float] | None]) -> None:
        """Put each ball at a (3,) place with a radius in metres; None: it is not to be seen."""
        for k, (ball, place, size) in enumerate(zip(balls, self._places, self._sizes, strict=True)):
            hidden, came = size[0, 0] == 0.0, self._coming[k]
            self._coming[k] = False
            if ball is None:
                size[:] = 0.0
            elif hidden and not came and not np.array_equal(place[0], ball[0]):
                place[0], self._coming[k] = ball[0], True
            else:
                place[0], size[:] = ball[0], ball[1]

    def shown(self) -> tuple[Shown, ...]:
        """Return each ball as it is drawn now."""
        return tuple(self._one(k) for k in range(len(self._colors)))

    def _one(self, index: int) -> Shown:
        x_m, y_m, z_m = self._places[index][0].tolist()
        return Shown(
            index + 1, x_m, y_m, z_m, float(self._sizes[index][0, 0]), *self._colors[index]
        )

    def show(self, ball: Shown) -> None:
        """Draw a ball from now on as it was drawn once."""
        self._places[ball.ball - 1][0] = ball.x_m, ball.y_m, ball.z_m
        self._sizes[ball.ball - 1][:] = ball.radius_m


def _channel(node: int, path: str, values: Array) -> Channel:
    return Channel(node, path, np.zeros(1), values, "STEP")  # type: ignore[arg-type]


def _material(number: int, color: Rgb) -> Material:
    red, green, blue = color
    glow = (red * _GLOW, green * _GLOW, blue * _GLOW)
    name = f"{PREFIX}{number}"
    return Material(name, base_color=(red, green, blue, 1.0), roughness=0.6, emissive=glow)


def _ball(material: int) -> Primitive:
    """Return a ball of radius 1."""
    down, around = np.meshgrid(
        np.linspace(0.0, np.pi, _RINGS + 1), np.linspace(0.0, 2 * np.pi, _SECTORS + 1),
        indexing="ij",
    )  # fmt: skip
    points = np.stack(
        [np.sin(down) * np.cos(around), np.cos(down), -np.sin(down) * np.sin(around)], axis=-1
    ).reshape(-1, 3)
    corner = np.arange(_RINGS)[:, None] * (_SECTORS + 1) + np.arange(_SECTORS)
    a, b = corner.ravel(), corner.ravel() + 1
    c, d = a + _SECTORS + 1, b + _SECTORS + 1
    indices = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    positions = points.astype(np.float32)
    return Primitive(
        positions,
        positions,
        np.zeros((len(points), 2), dtype=np.float32),
        None,
        indices.astype(np.uint32),
        material,
    )
