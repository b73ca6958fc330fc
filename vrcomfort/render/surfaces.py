"""Programs, textures and constants of each batch: everything a draw call has to bind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.gpu import gl, shaders
from vrcomfort.render.draw_list import BatchKey
from vrcomfort.render.textures import TextureStore
from vrcomfort.scene.data import Material, Scene

MATERIAL_BINDING = 2
_UNIFORM_ALIGNMENT = 256
"""Offsets of uniform buffer ranges are multiples of this on every driver."""

Features = tuple[str, ...]
MakeVertexArray = Callable[[moderngl.Program], moderngl.VertexArray]

_IMAGES = (
    ("base_color_image", "BASE_COLOR_IMAGE", True),
    ("normal_image", "NORMAL_IMAGE", False),
    ("metallic_roughness_image", "METALLIC_ROUGHNESS_IMAGE", False),
    ("emissive_image", "EMISSIVE_IMAGE", True),
)
"""(field of Material, define, is sRGB), in the order of their texture units."""


@dataclass(frozen=True, eq=False)
class Surface:
    """One batch's state; `depth` is None for surfaces that write no depth."""

    color: moderngl.VertexArray
    depth: moderngl.VertexArray | None
    material: int
    textures: tuple[tuple[int, moderngl.Texture], ...]
    mirrored: bool
    double_sided: bool
    masked: bool
    blended: bool


class MaterialBuffer:
    """All materials as ranges of one uniform buffer."""

    def __init__(self, ctx: moderngl.Context, materials: tuple[Material, ...]) -> None:
        layout = shaders.block_dtype("surface.glsl", "Material")
        self._size = layout.itemsize
        self._stride = -(-self._size // _UNIFORM_ALIGNMENT) * _UNIFORM_ALIGNMENT
        data = b"".join(
            _material_block(material, layout).tobytes().ljust(self._stride, b"\0")
            for material in materials
        )
        self._buffer = gl.buffer(ctx, data or bytes(self._stride))

    def bind(self, material: int) -> None:
        """Make a material the one that shaders see."""
        offset = material * self._stride
        self._buffer.bind_to_uniform_block(MATERIAL_BINDING, offset=offset, size=self._size)


def _material_block(material: Material, layout: np.dtype[np.void]) -> NDArray[np.void]:
    block = np.zeros((), layout)
    block["base_color"] = material.base_color
    block["emissive"] = (*material.emissive, material.normal_scale)
    block["reflection"] = (material.metallic, material.roughness, material.alpha_cutoff, 0)
    return block


class SurfaceFactory:
    """Makes the surfaces of a scene; equal variants share a program and a vertex array."""

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        vertex_array: MakeVertexArray,
        *,
        scene_features: shaders.Defines,
    ) -> None:
        self._ctx = ctx
        self._scene = scene
        self._vertex_array = vertex_array
        self._scene_features = dict(scene_features)
        self._textures = TextureStore(ctx, scene.images)
        self._color: dict[Features, moderngl.VertexArray] = {}
        self._depth: dict[Features, moderngl.VertexArray] = {}

    def make(self, key: BatchKey) -> Surface:
        """Return the surface of a batch."""
        material = self._scene.materials[key.material]
        features = _features(material, vertex_colors=key.vertex_colors)
        textures = tuple(
            (unit, self._textures.get(image, srgb=srgb))
            for unit, (field, _, srgb) in enumerate(_IMAGES)
            for image in [getattr(material, field)]
            if image is not None
        )
        return Surface(
            color=self._color_array(features),
            depth=None if material.alpha_mode == "BLEND" else self._depth_array(features),
            material=key.material,
            textures=textures,
            mirrored=key.mirrored,
            double_sided=material.double_sided,
            masked=material.alpha_mode == "MASK",
            blended=material.alpha_mode == "BLEND",
        )

    def _color_array(self, features: Features) -> moderngl.VertexArray:
        if "AMBIENT_IN_ALPHA" in features and not self._scene.environment.ambient_in_vertex_alpha:
            features = tuple(name for name in features if name != "AMBIENT_IN_ALPHA")
        if features not in self._color:
            defines = {**self._scene_features, **dict.fromkeys(features, 1)}
            program = shaders.program(self._ctx, "scene/scene.frag", "scene/scene.vert", defines)
            self._color[features] = self._vertex_array(program)
        return self._color[features]

    def semantic(self, key: BatchKey) -> moderngl.VertexArray | None:
        """Return what draws a batch's depth and semantic weights, None where it writes no depth."""
        material = self._scene.materials[key.material]
        if material.alpha_mode == "BLEND":
            return None
        return self._depth_array((*_features(material, vertex_colors=False), "SEMANTIC"))

    def _depth_array(self, features: Features) -> moderngl.VertexArray:
        relevant = ("ALPHA_MASK", "BASE_COLOR_IMAGE") if "ALPHA_MASK" in features else ()
        features = tuple(name for name in features if name in (*relevant, "SEMANTIC"))
        if features not in self._depth:
            fragment = "scene/depth.frag" if features else None
            defines = dict.fromkeys(features, 1)
            program = shaders.program(self._ctx, fragment, "scene/depth.vert", defines)
            self._depth[features] = self._vertex_array(program)
        return self._depth[features]

    @property
    def depth_programs(self) -> list[moderngl.Program]:
        """Return the programs that draw depth only."""
        return [array.program for array in self._depth.values()]


def _features(material: Material, *, vertex_colors: bool) -> Features:
    alpha = {"OPAQUE": "AMBIENT_IN_ALPHA", "MASK": "ALPHA_MASK", "BLEND": "ALPHA_BLEND"}
    names = [define for field, define, _ in _IMAGES if getattr(material, field) is not None]
    names.append(alpha[material.alpha_mode])
    if material.double_sided:
        names.append("DOUBLE_SIDED")
    if vertex_colors:
        names.append("VERTEX_COLORS")
    return tuple(names)
