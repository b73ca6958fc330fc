"""Ray casting on the CPU: what the GPU's focus rays and depth images are checked against."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from trimesh.ray.ray_triangle import RayMeshIntersector, ray_triangle_id

from vrcomfort.geometry import Array, Pose, normalize
from vrcomfort.scene.data import Image, Material, Node, Primitive, Scene, Wrap


def cast(
    scene: Scene,
    time_s: float,
    origins: ArrayLike,
    directions: ArrayLike,
    *,
    head: Pose | None = None,
) -> Array:
    """Return how far along each ray the first drawn surface is.

    Parameters
    ----------
    time_s
        Scene time: animated nodes are where they are then.
    origins, directions
        (n, 3) world metres and directions (any length).
    head
        world-from-head. It places head-locked nodes (without it they are left out) and
        decides levels of detail (without it the mean origin does).

    Returns
    -------
    (n,) metres along the unit direction, inf where nothing is hit.

    Notes
    -----
    The rules are the renderer's: a single-sided triangle is seen from its front only (also
    where its node mirrors), a double-sided one from both sides. MASK surfaces count
    where base colour alpha (factor × image, bilinear on the full-size image × vertex colour)
    reaches the cut-off; the GPU's mipmaps may disagree by about a texel along such edges.
    BLEND surfaces are transparent to rays: they write no depth.
    """
    starts = np.asarray(origins, np.float64).reshape(-1, 3)
    along = normalize(np.asarray(directions, np.float64).reshape(-1, 3))
    eye = starts.mean(axis=0) if head is None else head.position
    nearest = np.full(len(starts), np.inf)
    world = scene.world_from_node(time_s)
    for index, node in enumerate(scene.nodes):
        world_from_node: Array = world[index]
        if node.head_locked:
            if head is None:
                continue
            world_from_node = head.matrix() @ world_from_node
        for item in mesh_at(node, _distance_m(scene, node.mesh, world_from_node, eye)):
            found = _cast_primitive(scene, item, world_from_node, starts, along)
            nearest = np.minimum(nearest, found)
    return nearest


def mesh_at(node: Node, distance_m: float) -> tuple[int, ...]:
    """Return the primitives to draw when a node is `distance_m` from the head."""
    mesh = node.mesh
    for level in node.lod:
        if distance_m >= level.from_distance_m:
            mesh = level.mesh
    return mesh


def _distance_m(scene: Scene, mesh: tuple[int, ...], world_from_node: Array, eye: Array) -> float:
    """Return the distance that decides the level of detail (see `LodLevel`)."""
    if not mesh:
        return 0.0
    corners = [_box_corners(scene.primitives[item]) for item in mesh]
    world = np.concatenate(corners) @ world_from_node[:3, :3].T + world_from_node[:3, 3]
    centre = (world.min(axis=0) + world.max(axis=0)) / 2
    return float(np.linalg.norm(centre - eye))


def _box_corners(primitive: Primitive) -> Array:
    lower, upper = primitive.bounds
    return np.array(np.meshgrid(*np.stack([lower, upper], axis=1))).reshape(3, 8).T


def _cast_primitive(
    scene: Scene, item: int, world_from_node: Array, origins: Array, directions: Array
) -> Array:
    """Return the (n,) distances to one primitive; rays are taken into its node's frame."""
    nearest = np.full(len(origins), np.inf)
    try:
        node_from_world = np.linalg.inv(world_from_node)
    except np.linalg.LinAlgError:  # scaled to nothing, as animations hide things
        return nearest
    primitive = scene.primitives[item]
    local_origins = origins @ node_from_world[:3, :3].T + node_from_world[:3, 3]
    local_directions = directions @ node_from_world[:3, :3].T
    rays = np.flatnonzero(_meets_box(primitive, local_origins, local_directions))
    if not len(rays):
        return nearest
    triangles, hit_rays, places = _every_hit(
        _intersector(primitive), local_origins[rays], local_directions[rays]
    )
    if not len(triangles):
        return nearest
    hit_rays = rays[hit_rays]
    material = scene.materials[primitive.material]
    # In the node's own frame a front is a front, also where the node mirrors.
    seen = _faces_ray(primitive, triangles, local_directions[hit_rays], material)
    if material.alpha_mode == "BLEND":
        seen[:] = False
    elif material.alpha_mode == "MASK":
        seen &= _alpha(scene, primitive, triangles, places) >= material.alpha_cutoff
    world = places @ world_from_node[:3, :3].T + world_from_node[:3, 3]
    along = np.einsum("ij,ij->i", world - origins[hit_rays], directions[hit_rays])
    np.minimum.at(nearest, hit_rays[seen], along[seen])
    return nearest


def _meets_box(primitive: Primitive, origins: Array, directions: Array) -> NDArray[np.bool_]:
    """Return which rays meet the primitive's box (slab test)."""
    lower, upper = primitive.bounds
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (lower - origins) / directions, (upper - origins) / directions
    # 0/0, a ray inside a slab's own plane, limits nothing.
    enter = np.nanmax(np.where(np.isnan(a), -np.inf, np.fmin(a, b)), axis=1)
    leave = np.nanmin(np.where(np.isnan(a), np.inf, np.fmax(a, b)), axis=1)
    return np.asarray(leave >= np.maximum(enter, 0.0) * (1 - 1e-12))


@lru_cache(maxsize=2048)
def _intersector(primitive: Primitive) -> RayMeshIntersector:
    mesh = trimesh.Trimesh(
        primitive.positions.astype(np.float64), primitive.indices, process=False, validate=False
    )
    return RayMeshIntersector(mesh)  # type: ignore[no-untyped-call]


def _every_hit(
    intersector: RayMeshIntersector, origins: Array, directions: Array
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Return triangle, ray and (hits, 3) place of all hits.

    `RayMeshIntersector.intersects_id` would keep one of two triangles in one place, such as the
    front and the back of a leaf, and perhaps the one that faces away.
    """
    mesh = intersector.mesh
    return ray_triangle_id(  # type: ignore[no-untyped-call, no-any-return]
        triangles=mesh.triangles,
        ray_origins=origins,
        ray_directions=directions,
        tree=mesh.triangles_tree,
        triangles_normal=mesh.face_normals,
    )


def _faces_ray(
    primitive: Primitive,
    triangles: NDArray[np.int64],
    directions: Array,
    material: Material,
) -> NDArray[np.bool_]:
    """Return which hits are on a drawn side of their triangle."""
    if material.double_sided:
        return np.ones(len(triangles), np.bool_)
    a, b, c = _corners(primitive, triangles)
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), directions) < 0)


def _corners(primitive: Primitive, triangles: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    corners = primitive.positions.astype(np.float64)[primitive.indices[triangles]]
    return corners[:, 0], corners[:, 1], corners[:, 2]


def _alpha(
    scene: Scene, primitive: Primitive, triangles: NDArray[np.int64], places: Array
) -> Array:
    """Return the base colour's alpha at (n, 3) places on their triangles."""
    material = scene.materials[primitive.material]
    weights = trimesh.triangles.points_to_barycentric(  # type: ignore[no-untyped-call]
        np.stack(_corners(primitive, triangles), axis=1), places
    )
    alpha = np.full(len(triangles), material.base_color[3])
    corners = primitive.indices[triangles]
    if primitive.colors is not None:
        alpha = alpha * np.einsum("ij,ij->i", primitive.colors[corners, 3], weights)
    if material.base_color_image is not None:
        uv_map = material.base_color_uv
        uvs = primitive.uvs if uv_map.uv_set == 0 else primitive.uvs_1
        uv = np.einsum("ijk,ij->ik", uvs[corners], weights)
        uv = np.column_stack([uv, np.ones(len(uv))]) @ uv_map.matrix().T
        alpha = alpha * _texture_alpha(scene.images[material.base_color_image], uv)
    return np.asarray(alpha)


def _texture_alpha(image: Image, uv: Array) -> Array:
    """Return alpha in [0, 1] at (n, 2) texture coordinates, bilinear like the GPU's level 0."""
    height, width = image.pixels.shape[:2]
    at = uv * [width, height] - 0.5
    low = np.floor(at).astype(np.int64)
    u, v = (at - low).T
    alpha = np.zeros(len(uv))
    for dx, dy, weight in (
        (0, 0, (1 - u) * (1 - v)), (1, 0, u * (1 - v)), (0, 1, (1 - u) * v), (1, 1, u * v),
    ):  # fmt: skip
        column = _wrap(low[:, 0] + dx, width, image.wrap[0])
        row = _wrap(low[:, 1] + dy, height, image.wrap[1])
        alpha += weight * image.pixels[row, column, 3] / 255
    return alpha


def _wrap(texel: NDArray[np.int64], size: int, wrap: Wrap) -> NDArray[np.int64]:
    if wrap == "clamp_to_edge":
        return np.asarray(np.clip(texel, 0, size - 1))
    if wrap == "repeat":
        return np.asarray(texel % size)
    within = texel % (2 * size)
    return np.asarray(np.minimum(within, 2 * size - 1 - within))
