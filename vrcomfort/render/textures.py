"""Scene images on the GPU, with mipmaps."""

from __future__ import annotations

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.timer import is_software
from vrcomfort.scene.data import Image

ANISOTROPY = 8.0
"""Samples along the steep axis of a slanted surface, at most, where the hardware does it."""


class TextureStore:
    """Uploads each image once per encoding, when it is first asked for."""

    def __init__(self, ctx: moderngl.Context, images: tuple[Image, ...]) -> None:
        self._ctx = ctx
        self._images = images
        self._anisotropy = anisotropy(ctx)
        self._textures: dict[tuple[int, bool], moderngl.Texture] = {}

    def get(self, image: int, *, srgb: bool) -> moderngl.Texture:
        """Return the texture of an image; `srgb` images are decoded to linear when sampled."""
        key = (image, srgb)
        if key not in self._textures:
            self._textures[key] = _upload(
                self._ctx, self._images[image], srgb=srgb, anisotropy=self._anisotropy
            )
        return self._textures[key]

    @property
    def count(self) -> int:
        """Return the number of textures on the GPU."""
        return len(self._textures)


def anisotropy(ctx: moderngl.Context) -> float:
    """Return the anisotropy that textures get on this driver; 1 is none, as without a GPU."""
    return 1.0 if is_software(ctx) else min(ANISOTROPY, float(ctx.max_anisotropy))


def _upload(
    ctx: moderngl.Context, image: Image, *, srgb: bool, anisotropy: float
) -> moderngl.Texture:
    height, width = image.pixels.shape[:2]
    texture = gl.image_texture(ctx, (width, height), image.pixels.tobytes(), srgb=srgb)
    texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    texture.repeat_x, texture.repeat_y = image.repeat
    texture.anisotropy = anisotropy
    return texture
