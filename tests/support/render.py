"""Small scenes for the renderer's tests, built by hand."""

from __future__ import annotations

import numpy as np

from vrcomfort.geometry import Fov, Pose
from vrcomfort.render.camera import EyeCamera, camera_motion, clips_from_relative
from vrcomfort.scene.data import (
    Environment,
    Image,
    Material,
    Node,
    PointLight,
    Primitive,
    Scene,
)

DARK = Environment(
    sun_irradiance=(0, 0, 0), sky_zenith=(0, 0, 0), sky_horizon=(0, 0, 0), ground=(0, 0, 0)
)
"""Nothing shines but what emits."""

RIGHT_ANGLE = Fov(-np.pi / 4, np.pi / 4, np.pi / 4, -np.pi / 4)
"""Tangents of 1: a pixel of a 64 px image is 1/32 of the distance."""


def mesh(positions, indices, material=0, uvs=None, colors=None):
    """Return a primitive with flat normals from its first triangle."""
    positions = np.array(positions, dtype=np.float32)
    indices = np.array(indices, dtype=np.uint32).reshape(-1, 3)
    a, b, c = positions[indices[0]]
    normal = np.cross(b - a, c - a)
    normals = np.tile(normal / np.linalg.norm(normal), (len(positions), 1)).astype(np.float32)
    uvs = np.zeros((len(positions), 2)) if uvs is None else np.array(uvs)
    return Primitive(positions, normals, uvs.astype(np.float32), colors, indices, material)


def wall(size=1.0, material=0):
    """Return a square of side `size` in the plane z = 0 that faces +z."""
    s = size / 2
    corners = [[-s, -s, 0], [s, -s, 0], [s, s, 0], [-s, s, 0]]
    uvs = [[0, 1], [1, 1], [1, 0], [0, 0]]
    return mesh(corners, [0, 1, 2, 0, 2, 3], material, uvs)


def floor(size=20.0, material=0):
    """Return a square in the plane y = 0 that faces up."""
    s = size / 2
    corners = [[-s, 0, s], [s, 0, s], [s, 0, -s], [-s, 0, -s]]
    return mesh(corners, [0, 1, 2, 0, 2, 3], material, [[0, 0], [size, 0], [size, size], [0, size]])


def box(size=1.0, material=0):
    """Return an axis-aligned cube around the origin, each side with its own normals."""
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3] * sign
            center = np.eye(3)[axis] * sign
            sides.append(np.array([center - u - v, center + u - v, center + u + v, center - u + v]))
    positions = (np.concatenate(sides) * size / 2).astype(np.float32)
    normals = np.repeat([side.mean(axis=0) for side in sides], 4, axis=0).astype(np.float32)
    quad = np.array([[0, 1, 2], [0, 2, 3]])
    indices = np.concatenate([quad + 4 * side for side in range(6)]).astype(np.uint32)
    return Primitive(positions, normals, np.zeros((24, 2), np.float32), None, indices, material)


def glowing(color, **settings):
    """Return a material that shows `color` whatever the light."""
    return Material(base_color=(0, 0, 0, 1), emissive=color, roughness=1.0, **settings)


def at(x, y, z, **settings):
    """Return a node at a place that draws primitive 0 unless told otherwise."""
    return Node(**{"name": "n", "mesh": (0,), "translation": np.array([x, y, z]), **settings})


def scene(nodes, primitives, materials, *, environment=DARK, **settings):
    return Scene(
        "test",
        tuple(nodes),
        tuple(primitives),
        tuple(materials),
        environment=environment,
        **settings,
    )


def clips_of(*cameras):
    """Return (n, 4, 4) clip-from-relative of cameras, as scenes are drawn."""
    poses = [camera.world_from_eye for camera in cameras]
    return clips_from_relative(cameras, camera_motion(poses, poses))


def eye(position=(0, 0, 0), orientation=(0, 0, 0, 1), **settings):
    """Return a camera with tangents of 1 that looks along −z."""
    return EyeCamera(Pose(position, orientation), RIGHT_ANGLE, **settings)


def still_life():
    """Return a scene with everything the renderer does: sun, lamp, fog, mask, blend, metal."""
    checks = np.indices((16, 16)).sum(axis=0) % 2
    pixels = np.where(checks[..., None], [230, 220, 200, 255], [70, 60, 50, 255]).astype(np.uint8)
    holes = np.full((16, 16, 4), 255, np.uint8)
    holes[4:12, 4:12, 3] = 0
    bumps = np.full((16, 16, 4), 255, np.uint8)
    bumps[..., :2] = 128
    bumps[:, 8:, 0] = 190
    materials = [
        Material("floor", base_color_image=0, roughness=0.7),
        Material("clay", base_color=(0.7, 0.25, 0.12, 1), roughness=0.5),
        Material("brass", base_color=(0.9, 0.7, 0.3, 1), metallic=1.0, roughness=0.25),
        Material("grid", base_color_image=1, alpha_mode="MASK", double_sided=True),
        Material("glass", base_color=(0.2, 0.5, 0.9, 0.4), alpha_mode="BLEND"),
        Material("plaster", normal_image=2, base_color=(0.8, 0.8, 0.75, 1)),
    ]
    nodes = [
        Node("floor", mesh=(0,)),
        Node("clay", mesh=(1,), translation=np.array([-0.9, 0.5, -3.0])),
        Node("brass", mesh=(2,), translation=np.array([0.5, 0.5, -3.6])),
        Node("grid", mesh=(3,), translation=np.array([0.2, 0.5, -2.2])),
        Node("glass", mesh=(4,), translation=np.array([1.0, 0.6, -2.5])),
        Node("plaster", mesh=(5,), translation=np.array([0.0, 1.5, -6.0])),
    ]
    primitives = [floor(), box(1, 1), box(1, 2), wall(1, 3), wall(1.2, 4), wall(3, 5)]
    environment = Environment(
        cloud_cover=0.4,
        fog_density_per_m=0.01,
        shadow_distance_m=10.0,
        point_lights=(PointLight((-0.2, 1.2, -2.6), (1.0, 0.5, 0.2), 4.0),),
    )
    images = tuple(Image(image) for image in (pixels, holes, bumps))
    return scene(nodes, primitives, materials, environment=environment, images=images)
