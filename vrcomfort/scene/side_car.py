"""The TOML file beside a scene: light, air, spawn point, walkable area, roles of nodes.

Angles are degrees here and only here; colours are linear RGB.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from vrcomfort.files import read_text
from vrcomfort.geometry import FARTHEST_M, Pose, axis_angle
from vrcomfort.scene.camera_path import CameraPath
from vrcomfort.scene.data import (
    Environment,
    Hand,
    LodLevel,
    Node,
    PointLight,
    Resolve,
    Rgb,
    Scene,
    WalkableArea,
)
from vrcomfort.settings import (
    Problem,
    Settings,
    Word,
    did_you_mean,
    first_problem,
    parse_settings,
    toml_value,
)
from vrcomfort.settings.camera_path import PathPoints

Finite = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
Share = Annotated[float, Field(ge=0, le=1)]
NotNegative = Annotated[float, Field(ge=0, le=1e9)]
Positive = Annotated[float, Field(ge=1e-6, le=1e9)]
Color = tuple[NotNegative, NotNegative, NotNegative]
Point = tuple[Finite, Finite, Finite]


class Sun(Settings):
    """Where the sun stands: azimuth 0 is −Z ("north"), 90 is +X ("east")."""

    azimuth_deg: Finite = 40.0
    """Towards it: 0 is -Z, 90 is +X."""
    elevation_deg: Annotated[float, Field(ge=-90, le=90)] = 50.0
    """Above the horizon."""
    irradiance: Color = Environment.sun_irradiance
    """Linear RGB on a surface that faces it; zeros for none."""
    shadow_distance_m: Positive = Environment.shadow_distance_m
    """How far from the eye shadows are wanted."""


class Sky(Settings):
    """Radiance of the sky and of the ground's reflection."""

    zenith: Color = Environment.sky_zenith
    """Linear RGB radiance overhead."""
    horizon: Color = Environment.sky_horizon
    """At the horizon."""
    ground: Color = Environment.ground
    """Of the ground, which lights from below."""
    cloud_cover: Share = 0.0
    """Share of the sky that clouds cover."""
    in_vertex_alpha: bool = False
    """See `Environment.ambient_in_vertex_alpha`."""


class Fog(Settings):
    """Air light and extinction."""

    color: Color = Environment.fog_color
    """Linear RGB of the air's light."""
    density_per_m: NotNegative = 0.0
    """Extinction; 0 is clear air."""


class Lamp(Settings):
    """A point light."""

    position: Point
    """In the world, metres."""
    intensity: Color
    """Linear RGB irradiance at 1 m."""
    range_m: Positive
    """From there on it gives no light."""


class Spawn(Settings):
    """The floor point where a participant starts; yaw 0 looks along −Z, positive turns left."""

    position: Point
    """Point on the floor, metres."""
    yaw_deg: Finite = 0.0
    """Turned to the left from -Z."""


class SceneryPath(Settings):
    """A way along which a participant is carried."""

    points: PathPoints
    """Floor points with times."""
    unwrapped: bool = False
    """Whether `yaw_deg` turns as far as is written, from 0 to 360 once round to the left; without
    it, headings turn the shorter way."""
    loop: bool = False
    """Whether it begins again when it is over: the last point is where the first is, and headings
    differ by whole turns."""


class Ramp(Settings):
    """A slope: the foot is at the floor's `height_m`, the top at `top_m`; x and z of both."""

    foot_xz: tuple[Finite, Finite]
    """x and z of its foot, metres."""
    top_xz: tuple[Finite, Finite]
    """x and z of its top, metres."""
    top_m: Finite
    """Height of its top."""

    @model_validator(mode="after")
    def _has_a_length(self) -> Ramp:
        if self.foot_xz == self.top_xz:
            raise ValueError("foot and top are at the same place; a ramp leads from one to another")
        return self


class Walkable(Settings):
    """A piece of floor: level, or where `ramp` gives two heights, rising from one to the other.

    A ramp over a flight of stairs spares people the jolt of every step.
    """

    height_m: Finite = 0.0
    """Of a level floor."""
    polygon_xz: Annotated[tuple[tuple[Finite, Finite], ...], Field(min_length=3)]
    """Corners, x and z in metres."""
    ramp: Ramp | None = None
    """Where it rises; level without it."""

    def floor(self) -> WalkableArea:
        """Return the floor as scenes hold it."""
        polygon = np.array(self.polygon_xz)
        if self.ramp is None:
            return WalkableArea(polygon, self.height_m)
        foot, way = np.array(self.ramp.foot_xz), np.subtract(self.ramp.top_xz, self.ramp.foot_xz)
        slope = (self.ramp.top_m - self.height_m) / (way @ way) * way
        return WalkableArea(polygon, self.height_m - float(slope @ foot), tuple(slope.tolist()))


class Lod(Settings):
    """From this distance on draw the mesh of `node` (a node outside the scene; "" for none).

    ``*`` in `node` stands for the name of the node that is replaced.
    """

    from_distance_m: Positive
    """Drawn from there on."""
    node: str
    """Mesh outside the scene graph; * stands for the node's name."""


class NodeSettings(Settings):
    """Properties of nodes beyond glTF's; an omitted one is unchanged."""

    semantic_weight: Annotated[float, Field(gt=0, le=1)] | None = None
    """W_S of the autofocus zone: 1 for what people are to look at, 0.004 for the rest."""
    head_locked: bool | None = None
    """The node goes with the head."""
    hand: Hand | None = None
    """The node, and what is below it, goes with this hand: its place in the file is the one it has
    from the controller's aim pose, which points along -Z. It is drawn where the hand is tracked."""
    ambient: Share | None = None
    """Share of the light of sky and ground that reaches it."""
    casts_shadow: bool | None = None
    """Whether it throws shadows."""
    lod: tuple[Lod, ...] = ()
    """Coarser stand-ins, nearest first."""

    @model_validator(mode="after")
    def _goes_with_one(self) -> NodeSettings:
        if self.head_locked and self.hand:
            raise ValueError("`head_locked` and `hand` exclude each other; keep one")
        return self


class SideCar(Settings):
    """The whole file. Keys of `nodes` are node names or patterns with * and ?."""

    title: str = ""
    """In words, for lists."""
    exposure: Positive = 1.0
    """Factor on radiance before the tone curve."""
    resolve: Resolve = "mean"
    """How samples of a pixel become its colour: their mean, or weighted by 1 / (1 + brightest
    channel), which smooths edges of bright lamps and takes light from small ones."""
    sun: Sun = Sun()
    """The sun."""
    sky: Sky = Sky()
    """Light of sky and ground."""
    fog: Fog = Fog()
    """Air between the eye and things."""
    lamps: tuple[Lamp, ...] = ()
    """Point lights."""
    spawn: Spawn | None = None
    """Where participants begin."""
    viewpoints: dict[Word, Spawn] = Field(default_factory=dict)
    """Other places to begin at, which views of protocols name."""
    paths: dict[Word, SceneryPath] = Field(default_factory=dict)
    """Ways along which participants are carried, which views of protocols name."""
    walkable: tuple[Walkable, ...] = ()
    """Pieces of floor."""
    nodes: dict[str, NodeSettings] = Field(default_factory=dict)
    """Name of nodes, or pattern with * and ? → what the glTF file cannot say."""


def apply_side_car(scene: Scene, stand_ins: dict[str, tuple[int, ...]], path: Path) -> Scene:
    """Return the scene with everything that its side-car says.

    Parameters
    ----------
    stand_ins
        Primitives of the nodes outside the scene graph, by node name, for levels of detail.

    Raises
    ------
    InputError
        If the side-car has an error or names a node that the scene does not have.
    """
    side_car = read_side_car(path)
    _check_patterns(side_car, scene, stand_ins, path)
    return replace(
        scene,
        environment=_environment(side_car, scene.environment),
        spawn=_spawn(side_car.spawn) if side_car.spawn else scene.spawn,
        walkable=tuple(area.floor() for area in side_car.walkable) or scene.walkable,
        nodes=_nodes(scene.nodes, side_car.nodes, stand_ins),
        viewpoints=_viewpoints(side_car),
        paths=_paths(side_car),
    )


def places_of(scene: Scene, path: Path) -> Scene:
    """Return a scene, such as an empty one, with the places that a side-car names."""
    side_car = read_side_car(path)
    return replace(scene, viewpoints=_viewpoints(side_car), paths=_paths(side_car))


def read_side_car(path: Path) -> SideCar:
    """Read and validate a side-car file."""
    return parse_settings(SideCar, read_text(path, "side-car"), path)


def _check_patterns(
    side_car: SideCar, scene: Scene, stand_ins: dict[str, tuple[int, ...]], path: Path
) -> None:
    found = list(_pattern_problems(side_car, scene, stand_ins))
    if found:
        raise first_problem(found, read_text(path, "side-car"), path)


def _pattern_problems(
    side_car: SideCar, scene: Scene, stand_ins: dict[str, tuple[int, ...]]
) -> Iterator[Problem]:
    """Yield patterns that name nothing, and levels of detail that are not there."""
    for pattern, settings in side_car.nodes.items():
        names = [node.name for node in scene.nodes if fnmatchcase(node.name, pattern)]
        wanted = {_stand_in(level, name) for level in settings.lod for name in names} - {""}
        missing = sorted(wanted - stand_ins.keys())
        if missing:
            message = (
                f"lod of {pattern!r} names {missing[0]!r}, which is no mesh outside the scene "
                f"graph; {did_you_mean(missing[0], stand_ins)}"
            )
            yield Problem(("nodes", pattern, "lod"), message)
        elif not names:
            hint = did_you_mean(pattern, (node.name for node in scene.nodes if node.name))
            message = f"no node of the scene is called {pattern!r}; {hint}"
            yield Problem(("nodes", pattern), message)


def _stand_in(level: Lod, name: str) -> str:
    return level.node.replace("*", name)


def _environment(side_car: SideCar, of_file: Environment) -> Environment:
    """Return the side-car's environment; the file's lamps stay, its sun unless there is a [sun]."""
    azimuth, elevation = np.radians([side_car.sun.azimuth_deg, side_car.sun.elevation_deg])
    lamps = tuple(
        PointLight(lamp.position, lamp.intensity, lamp.range_m) for lamp in side_car.lamps
    )
    changed = Environment(
        sun_direction=np.array(
            [
                np.sin(azimuth) * np.cos(elevation),
                np.sin(elevation),
                -np.cos(azimuth) * np.cos(elevation),
            ]
        ),
        sun_irradiance=_rgb(side_car.sun.irradiance),
        sky_zenith=_rgb(side_car.sky.zenith),
        sky_horizon=_rgb(side_car.sky.horizon),
        ground=_rgb(side_car.sky.ground),
        exposure=side_car.exposure,
        resolve=side_car.resolve,
        fog_color=_rgb(side_car.fog.color),
        fog_density_per_m=side_car.fog.density_per_m,
        cloud_cover=side_car.sky.cloud_cover,
        shadow_distance_m=side_car.sun.shadow_distance_m,
        ambient_in_vertex_alpha=side_car.sky.in_vertex_alpha,
        point_lights=of_file.point_lights + lamps,
        directional_lights=of_file.directional_lights,
    )
    if "sun" in side_car.model_fields_set:
        return changed
    return replace(
        changed, sun_direction=of_file.sun_direction, sun_irradiance=of_file.sun_irradiance
    )


def _rgb(color: Color) -> Rgb:
    return color[0], color[1], color[2]


def _spawn(spawn: Spawn) -> Pose:
    return Pose(np.array(spawn.position), axis_angle([0.0, 1.0, 0.0], np.radians(spawn.yaw_deg)))


def _viewpoints(side_car: SideCar) -> dict[str, Pose]:
    return {name: _spawn(place) for name, place in side_car.viewpoints.items()}


def _paths(side_car: SideCar) -> dict[str, CameraPath]:
    return {
        name: CameraPath(path.points, unwrapped=path.unwrapped, loop=path.loop)
        for name, path in side_car.paths.items()
    }


def _nodes(
    nodes: tuple[Node, ...],
    settings: dict[str, NodeSettings],
    stand_ins: dict[str, tuple[int, ...]],
) -> tuple[Node, ...]:
    changed: list[Node] = []
    for node in nodes:
        new = node
        for pattern, entry in settings.items():
            if fnmatchcase(node.name, pattern):
                new = _changed(new, entry, stand_ins)
        above = changed[node.parent] if node.parent >= 0 else new
        locked = new.head_locked or above.head_locked
        changed.append(replace(new, head_locked=locked, hand=new.hand or above.hand))
    return tuple(changed)


def _changed(node: Node, entry: NodeSettings, stand_ins: dict[str, tuple[int, ...]]) -> Node:
    given = entry.model_dump(
        include={"semantic_weight", "head_locked", "hand", "ambient", "casts_shadow"},
        exclude_none=True,
    )
    lod = tuple(
        LodLevel(
            level.from_distance_m, stand_ins[_stand_in(level, node.name)] if level.node else ()
        )
        for level in sorted(entry.lod, key=lambda level: level.from_distance_m)
    )
    return replace(node, **given, lod=lod or node.lod)


_DRAFT = """\
# Side-car of {name}: what glTF cannot say. Every key: `vrcomfort schema side-car` and
# `vrcomfort docs scenes`.
title = {title}
exposure = {exposure:g}     # factor on radiance before the tone curve

# [sun]                # takes the place of the sun in the file
# azimuth_deg = {sun.azimuth_deg:g}   # towards it: 0 is -Z, 90 is +X
# elevation_deg = {sun.elevation_deg:g}

# Where participants begin, on the floor; yaw 0 looks along -Z, 90 along -X.
[spawn]
position = [{x:.3f}, {y:.3f}, {z:.3f}]
yaw_deg = {yaw_deg:.1f}

# Where they can walk: corners of a polygon in x and z.
{walkable}"""


def draft_side_car(scene: Scene, name: str) -> str:
    """Return a commented side-car with the start and the floors that a scene has without one.

    Parameters
    ----------
    name
        Of the scene's file.
    """
    forward = scene.spawn.rotation @ np.array([0.0, 0.0, -1.0])
    yaw_deg = float(np.degrees(np.arctan2(-forward[0], -forward[2]))) + 0.0
    x, y, z = (float(each) for each in scene.spawn.position)
    floors = "\n".join(
        f"[[walkable]]\nheight_m = {area.height_m:.3f}\npolygon_xz = "
        f"[{', '.join(f'[{px:.3f}, {pz:.3f}]' for px, pz in area.polygon_xz)}]\n"
        for area in scene.walkable
    )
    return _DRAFT.format(
        name=name, title=toml_value(scene.name), exposure=SideCar().exposure, sun=Sun(),
        x=x, y=y, z=z, yaw_deg=yaw_deg, walkable=floors,
    )  # fmt: skip
