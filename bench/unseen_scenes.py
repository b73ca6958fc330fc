"""Scenes that nothing was tuned for, each made from a seed: what stands where, and how it is seen.

A scene has near thin things, wires, leaves, lamps, a fence, writing, far blocks, a slanted floor,
panels of very different brightness, something that moves, and sometimes no sky. Its view has a
head pose, a field of view, a focus and a lens of its own. Heads are rolled, so that no outline runs
along rows or columns of pixels: what does, is a tile's.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenes.kit.glb import GlbWriter
from scenes.kit.glyphs import glyph_wall
from scenes.kit.mesh import Mesh, join
from scenes.kit.ornaments import Parts
from scenes.kit.shapes import ball, box, plane, tube
from scenes.kit.texture import rgb_png
from vrcomfort.geometry import Array, Fov, Pose
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus
from vrcomfort.rotations import axis_angle, normalize, yaw_pitch_roll

EYE_M = 1.6
NEAREST_M = 0.3
PERCENTS = (1.75, 3.5, 7.0)
"""Radius of the widest disc, of the image's width."""

SIDE_CAR = """exposure = {exposure}
[sun]
azimuth_deg = {azimuth}
elevation_deg = {elevation}
irradiance = [{sun}, {sun}, {sun}]
shadow_distance_m = 20.0
[sky]
zenith = [0.2, 0.35, 0.7]
horizon = [0.7, 0.8, 0.9]
ground = [0.3, 0.26, 0.2]
cloud_cover = {clouds}
"""


@dataclass(frozen=True)
class UnseenView:
    """How a scene is looked at.

    Parameters
    ----------
    head
        World-from-head; the eye is the left one.
    fov
        Of the whole image.
    focus_m, percent, full_blur_dioptre
        Of a lens in dioptres whose limit nothing in the scene reaches.
    targets
        (n, 3) places of near things, wires and lamps: a window is put around one of them.
    """

    head: Pose
    fov: Fov
    focus_m: float
    percent: float
    full_blur_dioptre: float
    targets: Array

    def condition(self, name: str = "unseen", **settings: object) -> Condition:
        """Return the condition that draws the view, with more settings of depth of field."""
        lens = {
            "law": "dioptre",
            "max_radius_percent": self.percent,
            "full_blur_dioptre": self.full_blur_dioptre,
            **settings,
        }
        return Condition(
            name=name,
            focus=Focus(method="fixed", fixed_m=self.focus_m),
            depth_of_field=DepthOfField.model_validate(lens),
        )


def build(seed: int, out: Path, *, passing: bool = False) -> UnseenView:
    """Write the scene of a seed to `out` (.glb, with its side-car) and return its view.

    With `passing`, things fly and turn through the view; they are where they are drawn at 1 s.
    """
    rng = np.random.default_rng([31, seed])
    writer = GlbWriter()
    things = _Things(rng, writer)
    things.floor()
    things.walls()
    things.far_blocks()
    things.fence()
    things.panels()
    things.writing()
    near = things.near_bars()
    near += things.wires()
    things.leaves()
    near += things.lamps()
    things.moving()
    if passing:
        near += things.passing()
    writer.save(out)
    text = SIDE_CAR.format(
        exposure=round(float(rng.uniform(0.7, 1.5)), 3),
        azimuth=round(float(rng.uniform(0, 360)), 1),
        elevation=round(float(rng.uniform(15, 70)), 1),
        sun=round(float(rng.uniform(0.5, 5)), 2),
        clouds=round(float(rng.uniform(0, 0.8)), 2),
    )
    out.with_suffix(".toml").write_text(text, encoding="utf-8")
    return _view(rng, np.array(near))


def _view(rng: np.random.Generator, targets: Array) -> UnseenView:
    roll = rng.choice([-1, 1]) * rng.uniform(10, 20)
    turn = yaw_pitch_roll(*np.radians([rng.uniform(-8, 8), rng.uniform(-8, 4), roll]))
    focus_m = float(rng.choice([0.6, 1.0, 1.5, 2.5, 5.0]))
    return UnseenView(
        head=Pose((0.0, EYE_M, 0.0), turn),
        fov=Fov.symmetric(vertical_rad=np.radians(rng.uniform(80, 105)), aspect=1832 / 1920),
        focus_m=focus_m,
        percent=float(rng.choice(PERCENTS)),
        full_blur_dioptre=max(1 / (NEAREST_M - 0.05) - 1 / focus_m, 1 / focus_m),
        targets=targets,
    )


class _Things:
    """What is put into a scene, in the order of the calls."""

    def __init__(self, rng: np.random.Generator, writer: GlbWriter) -> None:
        self.rng, self.writer = rng, writer
        self._count = 0

    def floor(self) -> None:
        """Add a slanted floor of checks."""
        slope = self.rng.uniform(-0.15, 0.15, 2)
        u, v = np.array([60, 60 * slope[0], 0]), np.array([0, 60 * slope[1], -60])
        ground = plane(
            np.array([0.0, 0.0, 4.0]) - u / 2, u, v, step_m=1.0, uv_m=self.rng.uniform(0.5, 2)
        )
        self._add([(ground, "checks")], checks=self._texture(_checks(self.rng)))

    def walls(self) -> None:
        """Add a wall behind everything in two scenes of three: else there is sky."""
        if self.rng.random() < 1 / 3:
            return
        far, high = self.rng.uniform(12, 40), self.rng.uniform(2, 12)
        wall = plane([-40, -10, -far], [80, 0, 0], [0, 10 + high, 0], step_m=4, uv_m=2)
        self._add([(wall, "checks")], checks=self._texture(_checks(self.rng)))

    def far_blocks(self) -> None:
        """Add boxes from 6 to 30 m."""
        for _ in range(self.rng.integers(4, 12)):
            place = self._place(6, 30, -0.3, 0.3)
            block = box(self.rng.uniform(0.4, 3, 3)).turned("y", self.rng.uniform(0, 90))
            self._add([(block.at(*place), "plain")], plain=self._plain())

    def fence(self) -> None:
        """Add a fence across the view, at 2 to 5 m."""
        far, gap = self.rng.uniform(2, 5), self.rng.uniform(0.06, 0.25)
        thick = gap * self.rng.uniform(0.1, 0.4)
        turn, high = self.rng.uniform(-30, 30), EYE_M + self.rng.uniform(-0.4, 0.6)
        bars = [box([thick, high, thick]).at(x) for x in np.arange(-2.5, 2.5, gap)]
        rail = box([5, thick, thick / 2]).at(0, high * 0.9)
        self._add(
            [(join([*bars, rail]).turned("y", turn).at(0, 0, -far), "plain")], plain=self._plain()
        )

    def panels(self) -> None:
        """Add pairs of a bright and a black panel side by side."""
        for _ in range(self.rng.integers(1, 4)):
            side = self.rng.uniform(0.1, 0.5)
            bright = self._material(emissive=self.rng.uniform(1, 6) * np.ones(3))
            black = self._material(color=(0.01, 0.01, 0.01))
            place, turn = self._place(1, 10, -0.4, 0.4), self.rng.uniform(-40, 40)
            panel = box([side, side * 1.5, 0.01]).turned("z", self.rng.uniform(-10, 10))
            left, right = (panel.at(x).turned("y", turn).at(*place) for x in (0, side))
            self._add([(left, "bright"), (right, "black")], bright=bright, black=black)

    def writing(self) -> None:
        """Add a board with signs at 0.8 to 4 m."""
        carved = glyph_wall(int(self.rng.integers(1 << 30)), 512)[..., None]
        ink, paper = self.rng.uniform(0, 90, 3), self.rng.uniform(160, 255, 3)
        side = self.rng.uniform(0.2, 0.8)
        board = box([side, side, 0.01], uv_m=side).turned("y", self.rng.uniform(-40, 40))
        place = self._place(0.8, 4, -0.35, 0.2)
        texture = self._texture(np.where(carved > 0.5, ink, paper))
        self._add([(board.at(*place), "signs")], signs=texture)

    def near_bars(self) -> list[Array]:
        """Add thin bars from 0.3 to 0.6 m; return where."""
        places = []
        for _ in range(self.rng.integers(1, 5)):
            place = self._place(NEAREST_M + 0.02, 0.6, -0.25, 0.25)
            thick, long = self.rng.uniform(0.003, 0.03), self.rng.uniform(0.2, 1.2)
            bar = box([thick, long, thick]).at(0, -long / 2).turned("z", self.rng.uniform(-80, 80))
            self._add([(bar.at(*place), "plain")], plain=self._plain())
            places.append(place)
        return places

    def wires(self) -> list[Array]:
        """Add hair-fine wires from 0.4 to 3 m; return where."""
        places = []
        for _ in range(self.rng.integers(2, 7)):
            place, along = self._place(0.45, 3, -0.3, 0.3), self.rng.normal(size=3) * [1, 1, 0.1]
            along *= self.rng.uniform(0.3, 1.5) / np.linalg.norm(along)
            radius = self.rng.uniform(0.0004, 0.003)
            ends = [place - along / 2, place + along / 2]
            self._add([(tube(ends, radius, segments=5), "plain")], plain=self._plain())
            places.append(place)
        return places

    def leaves(self) -> None:
        """Add clouds of small leaves that are seen from both sides."""
        for _ in range(self.rng.integers(1, 4)):
            middle = self._place(0.6, 4, -0.4, 0.4)
            size = self.rng.uniform(0.01, 0.06)
            flat = plane([-size, 0, 0], [2 * size, 0, 0], [0, size, 0], step_m=9, uv_m=1)
            leaves = [
                flat.turned("x", a).turned("y", b).at(*(middle + away))
                for a, b, away in zip(
                    *self.rng.uniform(0, 360, (2, 60)),
                    self.rng.normal(0, 0.12, (60, 3)),
                    strict=True,
                )
                if np.linalg.norm(middle + away - [0, EYE_M, 0]) > NEAREST_M + 0.1
            ]
            green = self._material(color=self.rng.uniform(0.05, 0.5, 3), double_sided=True)
            self._add([(join(leaves), "green")], green=green)

    def lamps(self) -> list[Array]:
        """Add small bright balls from 1 to 15 m; return where."""
        places = []
        for _ in range(self.rng.integers(3, 12)):
            place, far = self._place(1, 15, -0.3, 0.4), 0.0
            far = float(np.linalg.norm(place))
            light = self.rng.uniform(10, 300) * self.rng.uniform(0.5, 1, 3)
            body = ball(self.rng.uniform(0.001, 0.006) * far, segments=12, rings=8)
            self._add([(body.at(*place), "lamp")], lamp=self._material(emissive=light))
            places.append(place)
        return places

    def moving(self) -> None:
        """Add a ball that crosses the view, back and forth once in four seconds."""
        place, reach = self._place(1, 5, -0.2, 0.2), self.rng.uniform(0.3, 1.5)
        ball_ = ball(self.rng.uniform(0.03, 0.15), segments=24, rings=12)
        mesh = self.writer.mesh("moving", [(ball_.tinted((1, 1, 1, 1)), self._plain())])
        node = self.writer.node("moving", mesh, at=place)
        keys = [place + np.array([x, 0.0, 0.0]) for x in (-reach, reach, -reach)]
        self.writer.animate("moves", node, "translation", [0, 2, 4], np.array(keys))

    def passing(self) -> list[Array]:
        """Add things that fly past each other at up to 6 m/s, and turn; return where."""
        places = []
        for _ in range(self.rng.integers(3, 8)):
            place = self._place(0.6, 4, -0.3, 0.3)
            sides = self.rng.uniform(0.02, 0.4, 3)
            body = ball(sides[0] / 2) if self.rng.random() < 0.3 else box(sides, uv_m=0.2)
            checks = self._texture(_checks(self.rng))
            self._count += 1
            name = f"passing_{self._count}"
            mesh = self.writer.mesh(name, [(body.at(0, -sides[1] / 2), checks)])
            node = self.writer.node(name, mesh, at=place)
            speed = self.rng.uniform(0, 6) * normalize(self.rng.normal(size=3) * [1, 1, 0.5])
            ways = [place + speed * (time_s - 1) for time_s in (0, 2)]
            self.writer.animate(f"{name}_flies", node, "translation", [0, 2], np.array(ways))
            times_s = np.linspace(0, 2, 81)
            turns_rad = self.rng.uniform(-4, 4) * np.pi * times_s
            axis = normalize(self.rng.normal(size=3))
            turns = [axis_angle(axis, angle) for angle in turns_rad]
            self.writer.animate(f"{name}_turns", node, "rotation", times_s, turns)
            places.append(place)
        return places

    def _place(self, near: float, far: float, low: float, high: float) -> Array:
        """Draw a place before the eye: even in 1 / distance, `low` to `high` up for each metre."""
        away = 1 / self.rng.uniform(1 / far, 1 / near)
        side, up = self.rng.uniform(-0.6, 0.6), self.rng.uniform(low, high)
        return np.array([side * away, EYE_M + up * away, -away])

    def _plain(self) -> int:
        dark = self.rng.random() < 0.3
        return self._material(color=self.rng.uniform(0.01, 0.05 if dark else 0.9, 3))

    def _texture(self, rgb: Array) -> int:
        return self._material(texture=self.writer.texture("picture", rgb_png(rgb.astype(float))))

    def _material(self, **settings: object) -> int:
        self._count += 1
        return self.writer.material(f"m{self._count}", **settings)  # type: ignore[arg-type]

    def _add(self, parts: Parts, **materials: int) -> None:
        """Add a node; its parts name the materials."""
        self._count += 1
        name = f"thing_{self._count}"
        lit: list[tuple[Mesh, int]] = [(mesh, materials[key]) for mesh, key in parts]
        self.writer.node(name, self.writer.mesh(name, lit))


def _checks(rng: np.random.Generator, size: int = 256) -> Array:
    """Return an image of checks in two random colours, with finer ones in each."""
    v, u = np.indices((size, size)) * 8 // size
    fine = np.indices((size, size)).sum(axis=0) // (size // 64) % 2
    colours = rng.uniform(20, 240, (2, 3))
    light = np.where(((u + v) % 2)[..., None] > 0, colours[0], colours[1])
    return np.asarray(light * (0.85 + 0.15 * fine[..., None]), dtype=np.float64)
