"""From several samples of each pixel to one: colour, depth, velocity, and what is kept beside."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, Together, Uniforms
from vrcomfort.render.camera import EyeCamera


class Radii(Protocol):
    """The circle of confusion of each depth, which is written into the alpha of colour."""

    @property
    def inputs(self) -> dict[str, moderngl.Texture]:
        """Return the textures that ``include/coc_of_depth.glsl`` needs."""

    @property
    def defines(self) -> dict[str, Any]:
        """Return its variant."""

    @property
    def constants(self) -> Uniforms:
        """Return its uniforms that never change."""

    def of_camera(self, camera: EyeCamera) -> Uniforms:
        """Return those of an eye."""


class Samples(NamedTuple):
    """Multisampled textures."""

    colour: moderngl.Texture
    depth: moderngl.Texture
    velocity: moderngl.Texture | None


class ResolvePass:
    """Draws `samples` into `colour`, `depth` and `velocity`: ``scene/resolve.frag``.

    Attributes
    ----------
    colour
        RGBA16F linear radiance; alpha is 1, or with :meth:`write_radii` a signed radius in pixels
        of image width.
    depth
        D32F reverse-Z depth, ``near_m / distance``; 0 is the sky.
    velocity
        Pixels per frame, or None.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        samples: Samples,
        *,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        velocity: moderngl.Texture | None,
    ) -> None:
        self._ctx, self._samples = ctx, samples
        self.colour, self.depth, self.velocity = colour, depth, velocity
        self._radii: Radii | None = None
        self._places = Together()
        self._pass = self._make()

    def write_radii(self, radii: Radii) -> None:
        """Write circles of confusion into the alpha of colour from now on."""
        self._radii = radii
        self._pass = self._make()

    def render(self, camera: EyeCamera) -> None:
        """Fill the single-sample textures with what an eye drew."""
        radii = Together() if self._radii is None else self._radii.of_camera(camera)
        self._pass.render(Together(self._places, radii))

    def learn_sample_places(self) -> None:
        """Ask the driver where samples lie; it tells of the framebuffer in use only."""
        if self.velocity is not None and not self._places.parts:
            places = gl.sample_places(self._ctx, self._samples.colour.samples)
            self._places = Together(_SamplePlaces(places if len(places) > 1 else places[0]))

    def _make(self) -> FullscreenPass:
        many, radii = self._samples, self._radii
        inputs = {"colors": many.colour, "depths": many.depth}
        targets = [self.colour]
        defines: dict[str, Any] = {"SAMPLES": many.colour.samples}
        if many.velocity is not None and self.velocity is not None:
            inputs["velocities"] = many.velocity
            targets.append(self.velocity)
            defines["VELOCITY"] = 1
        if radii is not None:
            inputs |= radii.inputs
            defines |= {"COC": 1, **radii.defines}
        return FullscreenPass(
            self._ctx,
            "scene/resolve.frag",
            size_px=self.colour.size,
            inputs=inputs,
            constants=None if radii is None else radii.constants,
            defines=defines,
            target=targets,
            depth=self.depth,
        )


class _SamplePlaces(NamedTuple):
    sample_place: Any
