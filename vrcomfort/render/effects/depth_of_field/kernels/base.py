"""What depth of field needs of a kernel."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import moderngl


class Aspect(NamedTuple):
    """The uniform that all kernels with round discs have."""

    pixel_aspect: float


class BlurKernel(Protocol):
    """Spreads each point over its disc.

    It is made of a `CocPasses`, whose `colour_and_coc` holds the image (linear HDR) with the signed
    radius of each pixel.
    """

    @property
    def target(self) -> moderngl.Texture:
        """The blurred image, RGBA16F of the same size."""

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points; `pixel_aspect` is vertical over horizontal px per radian."""
