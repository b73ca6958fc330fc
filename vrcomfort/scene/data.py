"""A scene: plain frozen data between the glTF loader, the renderer and the ray caster.

World frame: right-handed, +Y up, metres. Colours are linear unless a name says sRGB.
Indices into the scene's lists are plain integers; `None` or -1 means "there is none".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose
from vrcomfort.rotations import rotation_rows
from vrcomfort.scene.animation import Animation, Bending, Skin, Skins, bent, sample_all
from vrcomfort.scene.camera_path import CameraPath

Float32: TypeAlias = NDArray[np.float32]
AlphaMode = Literal["OPAQUE", "MASK", "BLEND"]
Hand = Literal["left", "right"]
Wrap = Literal["repeat", "mirrored_repeat", "clamp_to_edge"]
Rgb: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Image:
    """A texture: pixels and how it continues outside of [0, 1].

    Parameters
    ----------
    pixels
        (height, width, 4) uint8; row 0 is at v = 0 (glTF: the upper edge of the picture).
        Base colour and emission are sRGB-encoded; normals and metal-roughness are linear.
    wrap
        How it goes on outside, in u and in v.
    """

    pixels: NDArray[np.uint8]
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")


@dataclass(frozen=True)
class UvMap:
    """Where on an image a vertex is: which of its texture coordinates, scaled, turned and moved.

    Source: Khronos KHR_texture_transform. The sense of the rotation is that of its example.
    """

    uv_set: Literal[0, 1] = 0
    offset: tuple[float, float] = (0.0, 0.0)
    rotation_rad: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)

    def matrix(self) -> Array:
        """Return (2, 3): image coordinates = matrix @ (u, v, 1)."""
        c, s = np.cos(self.rotation_rad), np.sin(self.rotation_rad)
        turn = np.array([[c, s], [-s, c]])
        return np.column_stack([turn * self.scale, self.offset])


@dataclass(frozen=True)
class Material:
    """A metallic-roughness surface of glTF 2.0; factors multiply their image.

    `metallic_roughness_image` holds roughness in green and metallic in blue. An `unlit` surface
    shows its base colour as radiance, whatever the light (KHR_materials_unlit).
    """

    name: str = ""
    base_color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    base_color_image: int | None = None
    base_color_uv: UvMap = UvMap()
    normal_image: int | None = None
    normal_uv: UvMap = UvMap()
    normal_scale: float = 1.0
    metallic: float = 0.0
    roughness: float = 0.9
    metallic_roughness_image: int | None = None
    metallic_roughness_uv: UvMap = UvMap()
    emissive: Rgb = (0.0, 0.0, 0.0)
    emissive_image: int | None = None
    emissive_uv: UvMap = UvMap()
    alpha_mode: AlphaMode = "OPAQUE"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False


@dataclass(frozen=True, eq=False)
class Primitive:
    """Triangles of one material, in their node's frame.

    Parameters
    ----------
    positions, normals
        (n, 3) float32 metres and unit vectors.
    uvs
        (n, 2) float32, zeros where the file has none.
    colors
        (n, 4) float32 linear vertex colours that multiply the base colour, or None.
    indices
        (m, 3) uint32, counter-clockwise seen from the front.
    material
        Index into `Scene.materials`.
    uvs_1
        (n, 2) float32 second texture coordinates, or None.
    bending
        Which joints of the node's skin bend each vertex; None where they bend none.
    """

    positions: Float32
    normals: Float32
    uvs: Float32
    colors: Float32 | None
    indices: NDArray[np.uint32]
    material: int
    uvs_1: Float32 | None = None
    bending: Bending | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the (3,) lower and upper corner of the box around all positions."""
        positions = self.positions.astype(np.float64)
        return positions.min(axis=0), positions.max(axis=0)


@dataclass(frozen=True)
class LodLevel:
    """A coarser stand-in: drawn instead of `Node.mesh` from `from_distance_m` on.

    The distance is measured from the head centre to the centre of the world-space box around
    `Node.mesh`, so both eyes (and the ray caster) always take the same level.
    An empty `mesh` is drawn as nothing.
    """

    from_distance_m: float
    mesh: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Node:
    """A node of the scene graph, with its primitives.

    Parameters
    ----------
    parent
        Index of the parent node, always smaller than the node's own; -1 for the world.
    translation, rotation, scale
        parent-from-node: (3,) metres, (4,) quaternion (x, y, z, w), (3,).
    matrix
        (4, 4) parent-from-node in place of the three above (it may shear), or None.
    mesh
        Indices into `Scene.primitives`.
    semantic_weight
        How much an observer is presumed to look at this node, W_S of Hillaire et al. 2008: 0.004
        for everything but what people are to look at, which has 1.
    head_locked
        The node's root frame is the head, not the world.
    hand
        The node's root frame is this hand's aim pose, not the world; it is drawn where the
        headset knows the hand. None for all other nodes.
    lod
        Coarser levels, by rising distance.
    moving
        An animation moves this node or one of its ancestors.
    ambient
        Share of the sky's and ground's light that reaches the node (0 in a closed room).
    casts_shadow
        False for things finer than a texel of the shadow map: they would darken themselves.
    skin
        Index into `Scene.skins` of what bends the mesh, or None. Such a node stands where its
        skin's first joint is, not turned, whatever it says itself (scene/animation.py).
    """

    name: str
    parent: int = -1
    translation: Array = field(default_factory=lambda: np.zeros(3))
    rotation: Array = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))
    scale: Array = field(default_factory=lambda: np.ones(3))
    matrix: Array | None = None
    mesh: tuple[int, ...] = ()
    semantic_weight: float = 0.004
    head_locked: bool = False
    hand: Hand | None = None
    lod: tuple[LodLevel, ...] = ()
    moving: bool = False
    ambient: float = 1.0
    casts_shadow: bool = True
    skin: int | None = None


@dataclass(frozen=True)
class PointLight:
    """A lamp: irradiance `intensity / distance²`, smoothly windowed to zero at `range_m`."""

    position: Rgb
    intensity: Rgb
    range_m: float


@dataclass(frozen=True)
class SpotLight(PointLight):
    """A lamp that shines into a cone, full within the inner angle, nothing beyond the outer one.

    Parameters
    ----------
    direction
        Unit vector along which it shines.
    inner_cone_rad, outer_cone_rad
        Between the direction and the rim of the cone; the outer one is the greater.
    """

    direction: Rgb
    inner_cone_rad: float
    outer_cone_rad: float


@dataclass(frozen=True)
class DirectionalLight:
    """Light from infinitely far away, without shadows.

    Parameters
    ----------
    direction
        Unit vector along which it shines.
    irradiance
        On a surface that faces it.
    """

    direction: Rgb
    irradiance: Rgb


MOST_LAMPS = 16
"""Point, spot and directional lights of a scene besides its sun, all together."""


Resolve: TypeAlias = Literal["mean", "by_brightness"]


@dataclass(frozen=True, eq=False)
class Environment:
    """Light from outside, air and exposure.

    Parameters
    ----------
    sun_direction
        (3,) unit vector from the world to the sun.
    sun_irradiance
        Linear RGB on a surface that faces the sun; zeros for no sun (and no shadow map).
    sky_zenith, sky_horizon, ground
        Linear RGB radiance of the sky and of the ground below, also the ambient light.
    exposure
        Factor on radiance before the tone curve.
    resolve
        How the samples of a pixel become its colour.
    fog_color, fog_density_per_m
        Air light and extinction: ``colour = mix(fog, surface, exp(-density · distance))``.
    cloud_cover
        Share of the sky that clouds cover, 0 to 1; clouds are part of the sky, at infinity.
    shadow_distance_m
        How far from the eye the sun's shadows are wanted.
    ambient_in_vertex_alpha
        Alpha of the vertex colours of OPAQUE materials (which glTF ignores) holds the share of
        sky and ground light that reaches the vertex; it multiplies ambient light only.
    """

    sun_direction: Array = field(default_factory=lambda: np.array([0.36, 0.8, 0.48]))
    sun_irradiance: Rgb = (3.0, 2.85, 2.6)
    sky_zenith: Rgb = (0.22, 0.42, 0.9)
    sky_horizon: Rgb = (0.75, 0.85, 1.0)
    ground: Rgb = (0.22, 0.2, 0.17)
    exposure: float = 1.0
    resolve: Resolve = "mean"
    fog_color: Rgb = (0.75, 0.85, 1.0)
    fog_density_per_m: float = 0.0
    cloud_cover: float = 0.0
    shadow_distance_m: float = 40.0
    ambient_in_vertex_alpha: bool = False
    point_lights: tuple[PointLight, ...] = ()
    """Spot lights among them."""
    directional_lights: tuple[DirectionalLight, ...] = ()
    """Besides the sun."""


@dataclass(frozen=True, eq=False)
class WalkableArea:
    """A plane piece of floor.

    Parameters
    ----------
    polygon_xz
        (n, 2) x and z of the corners of a simple polygon.
    height_m
        Height of its plane at x = z = 0: of a level floor, everywhere.
    slope_xz
        Rise of the plane per metre along x and along z.
    """

    polygon_xz: Array
    height_m: float
    slope_xz: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that can be drawn or walked on."""

    name: str
    nodes: tuple[Node, ...]
    primitives: tuple[Primitive, ...]
    materials: tuple[Material, ...]
    images: tuple[Image, ...] = ()
    animations: tuple[Animation, ...] = ()
    environment: Environment = field(default_factory=Environment)
    spawn: Pose = field(default_factory=Pose)
    """world-from-stage at the start: a floor point and a turn about +Y."""
    walkable: tuple[WalkableArea, ...] = ()
    warnings: tuple[str, ...] = ()
    skins: tuple[Skin, ...] = ()
    viewpoints: Mapping[str, Pose] = field(default_factory=dict)
    """Other places to start from, as `spawn`, by name."""
    paths: Mapping[str, CameraPath] = field(default_factory=dict)
    """Ways along which a participant can be carried, by name."""
    on_foot: bool = True
    """False where controls do not move the participant, who is carried or stands."""

    @cached_property
    def all_skins(self) -> Skins:
        """Return the joints of all skins in one list."""
        return Skins(self.skins, [node.skin for node in self.nodes])

    @property
    def has_hands(self) -> bool:
        """Return whether a node is bound to a hand."""
        return any(node.hand is not None for node in self.nodes)

    def world_from_node(self, time_s: float) -> Array:
        """Return (n, 4, 4) world-from-node of all nodes.

        It is head-from-node where head-locked, hand-from-node where bound to a hand.
        """
        return self.all_skins.stand(self.world_from_joint(time_s))

    def positions(self, node: int, primitive: int, time_s: float) -> Array:
        """Return (n, 3) positions of a node's primitive, bent where it has a skin."""
        surface, skin = self.primitives[primitive], self.nodes[node].skin
        if skin is None or surface.bending is None:
            return surface.positions.astype(np.float64)
        matrices = self.all_skins.place_from_bind(self.world_from_joint(time_s))
        mine = matrices[self.all_skins.first[skin] :]
        return bent(mine, surface.positions, surface.bending)

    def world_from_joint(self, time_s: float) -> Array:
        """Return (n, 4, 4) as `world_from_node`, but nodes with a skin are where the file has them.

        Joints, and nodes below those with a skin, go by that.
        """
        world = parent_from_node(self.nodes, self.animations, time_s)
        for index, node in enumerate(self.nodes):
            if node.parent >= 0:
                world[index] = world[node.parent] @ world[index]
        return world


def parent_from_node(
    nodes: Sequence[Node],
    animations: tuple[Animation, ...],
    time_s: float,
    indices: Iterable[int] | None = None,
) -> Array:
    """Return (n, 4, 4) parent-from-node at `time_s`, animations looping.

    Of the nodes at `indices`, or of all.
    """
    moved = sample_all(animations, time_s)
    wanted = range(len(nodes)) if indices is None else indices
    local = [_local(nodes[index], index, moved) for index in wanted]
    return np.array(local, dtype=np.float64).reshape(-1, 4, 4)  # a scene may be all sky


def _local(node: Node, index: int, moved: dict[tuple[int, str], list[float]]) -> list[list[float]]:
    if node.matrix is not None:
        rows: list[list[float]] = node.matrix.tolist()
        return rows
    return trs_rows(
        moved.get((index, "translation")) or node.translation.tolist(),
        moved.get((index, "rotation")) or node.rotation.tolist(),
        moved.get((index, "scale")) or node.scale.tolist(),
    )


def trs_rows(
    translation: Sequence[float], rotation: Sequence[float], scale: Sequence[float]
) -> list[list[float]]:
    """Return the 4 rows of parent-from-node of a translation, a quaternion and a scale: hot."""
    (a, b, c), (d, e, f), (g, h, i) = rotation_rows(*rotation)
    (x, y, z), (sx, sy, sz) = translation, scale
    return [
        [a * sx, b * sy, c * sz, x],
        [d * sx, e * sy, f * sz, y],
        [g * sx, h * sy, i * sz, z],
        [0.0, 0.0, 0.0, 1.0],
    ]
