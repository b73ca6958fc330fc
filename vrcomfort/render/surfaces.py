"""Programs and textures of batches: everything a draw call has to bind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import moderngl

from vrcomfort.gpu import gl, shaders
from vrcomfort.render import textures
from vrcomfort.render.materials import (
    SLOTS,
    BatchKey,
    ImageArrays,
    material_blocks,
    materials_per_block,
)
from vrcomfort.scene.data import Scene

MATERIAL_BINDING = 2

MakeVertexArray = Callable[[moderngl.Program], moderngl.VertexArray]


@dataclass(frozen=True, eq=False)
class Surface:
    """One batch's state."""

    array: moderngl.VertexArray
    block: int | None
    faces: str | None
    """Which way round front faces go; None where both sides are seen."""
    covers: bool
    """Whether alpha says how many samples of a pixel are covered."""


class MaterialBuffer:
    """All materials as ranges of one uniform buffer."""

    def __init__(self, ctx: moderngl.Context, scene: Scene, images: ImageArrays) -> None:
        blocks = material_blocks(scene, images)
        self._stride = gl.uniform_stride(blocks[0].nbytes)
        data = b"".join(block.tobytes().ljust(self._stride, b"\0") for block in blocks)
        self._size = blocks[0].nbytes
        self._buffer = gl.buffer(ctx, data)

    def bind(self, block: int) -> None:
        """Make a block of materials the one that shaders see."""
        offset = block * self._stride
        self._buffer.bind_to_uniform_block(MATERIAL_BINDING, offset=offset, size=self._size)


class SurfaceFactory:
    """Makes the surfaces of a scene; equal variants share a program and a vertex array."""

    def __init__(
        self,
        ctx: moderngl.Context,
        color_array: MakeVertexArray,
        depth_array: MakeVertexArray,
        *,
        scene_features: shaders.Defines,
    ) -> None:
        self._ctx = ctx
        self._color_array, self._depth_array = color_array, depth_array
        self._scene_features = dict(scene_features)
        self._made: dict[tuple[object, ...], moderngl.VertexArray] = {}

    def color(self, key: BatchKey) -> Surface:
        """Return what draws a batch."""
        return self._surface(key, ("scene/scene.frag", "scene/scene.vert"), self._scene_features)

    def depth(self, key: BatchKey) -> Surface:
        """Return what draws a batch's depth alone; `key` is one `of_depth`."""
        fragment = "scene/depth.frag" if key.masked else None
        return self._surface(key, (fragment, "scene/depth.vert"), {})

    def semantic(self, key: BatchKey) -> Surface:
        """Return what draws a batch's depth and semantic weights; `key` is one `of_depth`."""
        return self._surface(key, ("scene/depth.frag", "scene/depth.vert"), {"SEMANTIC": 1})

    def _surface(
        self, key: BatchKey, files: tuple[str | None, str], defines: shaders.Defines
    ) -> Surface:
        fragment, vertex = files
        variant = (files, key.features, key.arrays, *defines)
        if variant not in self._made:
            named = {
                **defines,
                **dict.fromkeys(key.features, 1),
                "MATERIALS": materials_per_block(),
            }
            program = shaders.program(self._ctx, fragment, vertex, named)
            _name_units(program, key)
            make = self._color_array if vertex == "scene/scene.vert" else self._depth_array
            self._made[variant] = make(program)
        faces = None if key.double_sided else "cw" if key.mirrored else "ccw"
        covers = key.masked and fragment == "scene/scene.frag"
        return Surface(self._made[variant], key.block, faces, covers)


def _name_units(program: moderngl.Program, key: BatchKey) -> None:
    """Tell samplers where their arrays are."""
    for slot, array in zip(SLOTS, key.arrays, strict=True):
        if array is not None and slot.sampler in program:
            program[slot.sampler] = textures.unit(array)
    if "shadow_map" in program:
        program["shadow_map"] = textures.SHADOW_UNIT
