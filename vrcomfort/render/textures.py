"""Scene images on the GPU: texture arrays with mipmaps, each on a texture unit of its own."""

from __future__ import annotations

import moderngl

from vrcomfort.errors import InputError
from vrcomfort.gpu import gl
from vrcomfort.gpu.timer import is_software
from vrcomfort.render.materials import ArrayKind, ImageArrays
from vrcomfort.scene.data import Image, Scene

ANISOTROPY = 8.0
"""Samples along the steep axis of a slanted surface, at most, where the hardware does it."""

SHADOW_UNIT = 32
"""What a scene reads lies on units that no other pass binds anything to: it is bound once a frame.
Below are those of passes (OpenGL 4.5 promises 16 to each shader) and moderngl's own, the 32nd at
most."""

FIRST_UNIT = SHADOW_UNIT + 1
UNITS = 96
"""OpenGL 4.5 promises so many in all."""


class TextureStore:
    """Uploads the images of a scene.

    Raises
    ------
    InputError
        If the scene's images have more different sizes than there are texture units.
    """

    def __init__(self, ctx: moderngl.Context, scene: Scene, arrays: ImageArrays) -> None:
        if len(arrays.kinds) > UNITS - FIRST_UNIT:
            raise InputError(
                f"scene {scene.name!r} has images of {len(arrays.kinds)} kinds (sizes, repetition, "
                f"colour spaces); at most {UNITS - FIRST_UNIT} are drawn: give them equal sizes"
            )
        most = anisotropy(ctx)
        uploaded = [
            _upload(ctx, kind, [scene.images[index] for index in images], anisotropy=most)
            for kind, images in zip(arrays.kinds, arrays.layers, strict=True)
        ]

        self.bind = gl.binder(ctx, uploaded, FIRST_UNIT)
        """Puts every array on its unit."""


def unit(array: int) -> int:
    """Return the texture unit of an array."""
    return FIRST_UNIT + array


def anisotropy(ctx: moderngl.Context) -> float:
    """Return the anisotropy that textures get on this driver; 1 is none, as without a GPU."""
    return 1.0 if is_software(ctx) else min(ANISOTROPY, float(ctx.max_anisotropy))


def _upload(
    ctx: moderngl.Context, kind: ArrayKind, images: list[Image], *, anisotropy: float
) -> moderngl.TextureArray:
    pixels = [image.pixels.tobytes() for image in images]
    texture = gl.image_array(ctx, kind.size_px, pixels, srgb=kind.srgb)
    texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    gl.wrap(ctx, texture, kind.wrap)
    texture.anisotropy = anisotropy
    return texture
