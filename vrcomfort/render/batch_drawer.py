"""Draws batches, and changes only that OpenGL state that differs from one to the next."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl

from vrcomfort.render.draw_list import Batch
from vrcomfort.render.materials import ImageArrays
from vrcomfort.render.surfaces import MaterialBuffer, Surface
from vrcomfort.render.textures import TextureStore
from vrcomfort.scene.data import Scene

_ALPHA_TO_COVERAGE = 0x809E
_NOT_KNOWN = "not known"


class BatchDrawer:
    """Holds the materials and images of a scene: `begin`, then `draw` as often as need be.

    Between the two, and between draws, nothing else may be drawn.
    """

    def __init__(self, ctx: moderngl.Context, scene: Scene, images: ImageArrays) -> None:
        self._ctx = ctx
        self._materials = MaterialBuffer(ctx, scene, images)
        self._textures = TextureStore(ctx, scene, images)
        self._faces: str | None = _NOT_KNOWN
        self._block: int | None = None

    def begin(self) -> None:
        """Bind all images, and count on nothing that others have left."""
        self._textures.bind()
        self._faces, self._block = _NOT_KNOWN, None

    def draw(
        self,
        batches: Sequence[Batch],
        surfaces: Sequence[Surface],
        commands: moderngl.Buffer,
        *,
        cull: bool = True,
    ) -> None:
        """Draw.

        Parameters
        ----------
        surfaces
            What the keys of batches number.
        cull
            Whether back faces of one-sided surfaces are left out.
        """
        covers = False
        for batch in batches:
            surface = surfaces[batch.key]
            if surface.block is not None and surface.block != self._block:
                self._block = surface.block
                self._materials.bind(surface.block)
            self._cull(surface.faces if cull else None)
            if surface.covers != covers:
                covers = surface.covers
                toggle = self._ctx.enable_direct if covers else self._ctx.disable_direct
                toggle(_ALPHA_TO_COVERAGE)
            surface.array.render_indirect(commands, count=batch.length, first=batch.first)
        if covers:
            self._ctx.disable_direct(_ALPHA_TO_COVERAGE)

    def _cull(self, faces: str | None) -> None:
        if faces == self._faces:
            return
        self._faces = faces
        if faces is None:
            self._ctx.disable(moderngl.CULL_FACE)
            return
        self._ctx.front_face = faces
        self._ctx.enable(moderngl.CULL_FACE)
