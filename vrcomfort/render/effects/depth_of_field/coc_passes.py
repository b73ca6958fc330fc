"""How far each pixel of one eye is out of focus: colour and signed radius side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from operator import is_not
from typing import Any, NamedTuple, TypeAlias

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, Pose, focal_length_px, rotate
from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, max_reduction, of_each
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics import blur_kernels
from vrcomfort.optics.circle_of_confusion import CLOSEST_FOCUS
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.effects.depth_of_field.lens_radius import (
    max_radius_of,
    px_per_dioptre,
    radius_of_arcmin,
)
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.scene_pass import Radii
from vrcomfort.rotations import rotated

TILE_PX = 8
"""Side of the tiles whose range of radii is known; with 4 px, dilation cost as much as it saved."""


COC_BINDING = 4

Inputs = Mapping[str, AnyTexture | Sequence[AnyTexture]]
"""Textures by sampler, as in `FullscreenPass`."""


PixelAspect: TypeAlias = float | tuple[float, ...]
"""Vertical over horizontal px per radian, of one eye or of each."""


def aspects(fovs: Sequence[Fov], size_px: tuple[int, int]) -> PixelAspect:
    """Return it for images with these frusta."""
    focal_px = (focal_length_px(fov, size_px) for fov in fovs)
    found: PixelAspect = of_each([vertical / across for across, vertical in focal_px])
    return found


class EyeInHead(NamedTuple):
    """How an eye stands in the head, as ``include/coc_of_depth.glsl`` has it.

    Parameters
    ----------
    head_forward_in_view
        The head's forward axis.
    offset_m
        How far the eye is in front of the head centre.
    eye_in_view
        The eye from the head centre, m.
    """

    head_forward_in_view: tuple[float, float, float]
    offset_m: float
    eye_in_view: tuple[float, float, float]

    @classmethod
    def of(cls, head_from_eye: Pose) -> EyeInHead:
        """Return it of an eye's place."""
        *position, x, y, z, w = head_from_eye.numbers
        forward = rotated(-x, -y, -z, w, 0.0, 0.0, -1.0)
        return cls(forward, -position[2], rotated(-x, -y, -z, w, *position))


_MEMBERS = (
    "head_forward_in_view",
    "near_m",
    "eye_in_view",
    "offset_m",
    "peripheral_axis_in_view",
    "peripheral_px",
    "tangents",
    "px_per_defocus",
    "max_radius_px",
    "infinity_m",
    "peripheral_exponent",
    "focal_length_m",
    "distance_offset_m",
)
"""Of the block of ``include/coc_of_depth.glsl``: what follows the eye's place, then its frustum."""


class DepthToCoc:
    """Signed radius of any depth in the eyes' images, for ``include/coc_of_depth.glsl``."""

    def __init__(self, inputs: EffectInputs) -> None:
        settings: DepthOfField = inputs.settings
        self._ctx, self._settings, self._infinity_m = inputs.ctx, settings, inputs.infinity_m
        self.depth = inputs.reads["depth"]
        self._size_px = gl.size_px_of(self.depth)
        self.inputs = {"focus": inputs.reads["focus"]}
        self._cameras: tuple[EyeCamera, ...] = ()
        """Whose constants the block has."""
        self._packed: dict[int, tuple[EyeCamera, bytes, float]] = {}
        self._of_frustum: dict[Fov, tuple[float, ...]] = {}
        self.max_radius_px = max_radius_of(settings, self._size_px)
        """Largest radius of the eyes that constants were given for last."""
        self._block = shaders.PackedStruct("coc_of_depth.glsl", "CocOfEye", _MEMBERS)
        self._buffer = gl.dynamic_buffer(self._ctx, EYES * self._block.size_bytes)
        self._rewrite = gl.rewriter(self._ctx, self._buffer)
        self.defines: dict[str, Any] = {
            **_law_defines(settings),
            **({} if settings.peripheral is None else {"PERIPHERAL": 1}),
            **({"ALONG_RAY": 1} if settings.distance_along == "ray" else {}),
        }

    def make_pass(
        self,
        fragment: str,
        *,
        inputs: dict[str, AnyTexture] | None = None,
        defines: dict[str, Any] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return a pass that reads `depth` and includes ``coc_of_depth.glsl``.

        It is drawn after :meth:`see_with`.
        """
        return FullscreenPass(
            self._ctx,
            fragment,
            inputs={"depth": self.depth, **self.inputs, **(inputs or {})},
            defines={**self.defines, **(defines or {})},
            **options,
        )

    def adjust(self, settings: DepthOfField, infinity_m: float) -> None:
        """Take other settings of the same law, and another distance of the sky."""
        self._settings, self._infinity_m = settings, infinity_m
        self._cameras = ()
        self._packed.clear()
        self._of_frustum.clear()

    def see_with(self, *cameras: EyeCamera) -> None:
        """Give shaders the constants of each eye's camera, until others ask for theirs."""
        if len(cameras) != len(self._cameras) or any(map(is_not, cameras, self._cameras)):
            self._cameras = cameras
            found = [self._constants(each) for each in cameras]
            self._rewrite(b"".join(packed for packed, _ in found))
            self.max_radius_px = max(radius_px for _, radius_px in found)
        self._buffer.bind_to_uniform_block(COC_BINDING)

    def _constants(self, eye: EyeCamera) -> tuple[bytes, float]:
        """Return those of a camera, and its largest radius: the resolve asks for them, too."""
        if id(eye) not in self._packed:
            if len(self._packed) >= EYES:
                self._packed.clear()
            numbers = self._numbers(eye)
            self._packed[id(eye)] = eye, self._block.packed(numbers), numbers[_MAX_RADIUS]
        return self._packed[id(eye)][1:]

    def _numbers(self, eye: EyeCamera) -> tuple[float, ...]:
        place, axis = EyeInHead.of(eye.head_from_eye), eye.peripheral_axis
        if axis is not None:
            axis = rotate(eye.head_from_eye.inverse().orientation, axis)
        of_frustum = self._of_frustum.get(eye.fov)
        if of_frustum is None:
            if len(self._of_frustum) >= KEPT_FRUSTA:
                self._of_frustum.clear()
            of_frustum = self._of_frustum[eye.fov] = self._constants_of(eye.fov)
        forward = place.head_forward_in_view
        return (
            *(*forward, eye.near_m),
            *(*place.eye_in_view, place.offset_m),
            *(forward if axis is None else axis),
            *of_frustum,
        )

    def _constants_of(self, fov: Fov) -> tuple[float, ...]:
        settings, peripheral = self._settings, self._settings.peripheral
        focal_px = focal_length_px(fov, self._size_px)[0]
        limit_px, px = _limit_and_scale(settings, focal_px, self._size_px)
        unit_px = peripheral and radius_of_arcmin(peripheral.unit_diameter_arcmin, focal_px)
        return (
            *(unit_px or 0.0, *fov.tangents, px, limit_px, self._infinity_m),
            peripheral.exponent if peripheral else 1.0,
            settings.focal_length_m if settings.law == "thin_lens" else 0.0,
            settings.distance_offset_m,
        )


_MAX_RADIUS = 17
"""Place of the largest radius in the constants of an eye."""

EYES = 2
KEPT_FRUSTA = 8
"""More than a headset has; those of one that changes them in every frame do not pile up."""


class CocPasses:
    """Gives every pixel of an image its signed circle-of-confusion radius."""

    def __init__(self, inputs: EffectInputs) -> None:
        self.ctx, self._colour = inputs.ctx, inputs.colour
        self._resolve = None if inputs.scene is None else inputs.scene.resolve
        self.size_px = size_px = inputs.size_px
        self.eyes = gl.layers_of(inputs.colour)
        """How many are drawn at once."""
        self.settings: DepthOfField = inputs.settings
        self.max_radius_px = max_radius_of(self.settings, size_px)
        """No eye's image can have a larger radius."""
        self.max_radius_now_px = self.max_radius_px
        """Largest radius that the last eyes could have: `max_diameter_arcmin` may make it less."""
        self._least_max_radius_px = self.max_radius_px
        self.depth_to_coc = DepthToCoc(inputs)
        layered = self.settings.kernel == "vrcomfort" and (
            self.settings.samples != blur_kernels.HALF_GATHER_SAMPLES
        )
        known = layered and self._resolve is not None
        self.coverage: dict[str, Any] = {"WITH_COVERAGE": 1} if known else {}
        """Defines of ``include/coverage.glsl``."""
        self._is_rendered = False
        self.tile_px = TILE_PX
        """Side of :attr:`tile_min_max`."""
        samples = self.settings.samples
        levels = blur_kernels.gather_mips(self.max_radius_px, samples)
        self.level_defines: dict[str, Any] = {
            "EXACT_PX": blur_kernels.exact_px(samples),
            "LEVELS": levels,
            "EACH_COARSER_LEVEL(f)": each_level(1, levels),
            "WIDER": blur_kernels.WIDER,
            "FADED": blur_kernels.CROSS_FADE_FROM,
            **self.coverage,
        }
        """Defines of ``include/levels.glsl``."""
        self._tile_min_max = CocTileMinMax(
            self.ctx,
            self.depth_to_coc,
            size_px=size_px,
            tile_px=self.tile_px,
            defines=self.level_defines,
        )
        self._tiles_are_read = False
        self.tells_clamps = True
        """False draws nothing for :meth:`clamps` alone: for measurements of a kernel's cost."""
        self._colour_and_coc: AnyTexture | None = None
        self._beside: FullscreenPass | None = None

    @property
    def disc_px(self) -> float:
        """Return how far the widest disc reaches, summed over texels of the coarsest level."""
        return float(self.max_radius_px + 2 ** int(self.level_defines["LEVELS"]))

    @property
    def reach(self) -> tuple[dict[str, AnyTexture], dict[str, Any]]:
        """Return inputs and defines of ``include/tile_dilate.glsl``."""
        defines = {"TILE": self.tile_px, "MAX_RADIUS_PX": float(self.max_radius_px)}
        if self.widest is None:
            return {}, defines
        return {"widest": self.widest}, {**defines, "WIDEST": 1}

    @property
    def tile_min_max(self) -> AnyTexture:
        """Tiles of :class:`CocTileMinMax` of the last eye; asking once keeps them drawn."""
        self._tiles_are_read = True
        return self._tile_min_max.target

    @property
    def widest(self) -> AnyTexture | None:
        """1×1, px: no radius of the last eye is wider; asking once keeps it drawn.

        None with peripheral blur: tiles only sample it.
        """
        self._tiles_are_read = True
        return None if self.settings.peripheral else self._tile_min_max.widest

    @property
    def colour_and_coc(self) -> AnyTexture:
        """RGBA16F: finite colour, signed radius in pixels of image width. Drawn if asked for."""
        if self._colour_and_coc is None:
            self._colour_and_coc = self._with_radii()
        return self._colour_and_coc

    def _with_radii(self) -> AnyTexture:
        if self._resolve is not None:
            found = self.depth_to_coc
            defines = {**found.defines, **self.coverage}
            self._resolve.write_radii(Radii(found.inputs, defines, found.see_with))
            return self._colour
        inputs = {"colour": self._colour}
        self._beside = self.depth_to_coc.make_pass(
            "depth_of_field/colour_and_coc.frag",
            size_px=self.size_px,
            inputs=inputs,
            reach_px={"colour": 0.0, "depth": 0.0},
        )
        if self._is_rendered:
            self._beside.render()
        return self._beside.target

    def render(self, *cameras: EyeCamera) -> None:
        """Find the radii of the images that eyes have drawn."""
        self.depth_to_coc.see_with(*cameras)
        self.max_radius_now_px = self.depth_to_coc.max_radius_px
        self._least_max_radius_px = min(self._least_max_radius_px, self.max_radius_now_px)
        self._is_rendered = True
        if self._beside is not None:
            self._beside.render()
        if self.tells_clamps or self._tiles_are_read:
            self._tile_min_max.render()

    def make_pass(
        self, name: str, inputs: Inputs, *, texel_px: int = 1, **options: Any
    ) -> FullscreenPass:
        """Return the pass ``depth_of_field/NAME.frag`` of this image.

        Parameters
        ----------
        texel_px
            Side of the square of pixels that a texel of its target stands for.
        options
            Those of :class:`FullscreenPass`.
        """
        width, height = self.size_px
        return FullscreenPass(
            self.ctx,
            f"depth_of_field/{name}.frag",
            size_px=(ceil(width / texel_px), ceil(height / texel_px)),
            inputs=inputs,
            texel_px=(texel_px, texel_px),
            **options,
        )

    def adjust(self, settings: DepthOfField, infinity_m: float) -> None:
        """Find radii by other settings from now on; see :meth:`DepthToCoc.adjust`."""
        self.settings = settings
        self.depth_to_coc.adjust(settings, infinity_m)

    def reset(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        self._tile_min_max.reset()
        self._least_max_radius_px = self.max_radius_px

    def largest_radius_px(self) -> float:
        """Return the largest radius of all frames before its limit; waits for the GPU."""
        return self._tile_min_max.read()

    def clamps(self) -> tuple[str, ...]:
        """Return the limit's effect on the frames so far, in words; waits for the GPU."""
        largest_px = self.largest_radius_px()
        if largest_px <= self._least_max_radius_px:
            return ()
        return (
            f"depth of field: circles of confusion of up to {largest_px:.1f} px (radius) were "
            f"limited to {self._least_max_radius_px:.1f} px",
        )


def each_level(first: int, end: int) -> str:
    """Return the body of a macro that calls another for each level."""
    return " ".join(f"f({level})" for level in range(first, end))


class CocTileMinMax:
    """The range of radii in each tile; remembers the largest of all frames before its limit.

    Parameters
    ----------
    tile_px
        Side of the tiles, even.
    defines
        Those of ``include/levels.glsl``.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        radii: DepthToCoc,
        *,
        size_px: tuple[int, int],
        tile_px: int,
        defines: dict[str, Any],
    ) -> None:
        width, height = size_px
        self._tiles = radii.make_pass(
            "depth_of_field/coc_tile_min_max.frag",
            size_px=(ceil(width / tile_px), ceil(height / tile_px)),
            defines={"TILE": tile_px, **defines},
            dtype="f4",  # 12 bits in alpha (levels.glsl): a half float holds 11
            reach_px={"depth": 2.0},
            texel_px=(tile_px, tile_px),
        )
        self.target = self._tiles.target
        """RGBA32F, pixels of image width: least and greatest signed radius of each tile of the last
        eye; largest radius before the limit; bits of ``coc_tile_min_max.frag``."""
        self._largest = max_reduction(ctx, self.target, value="z", texel_px=(tile_px, tile_px))
        self.widest = self._largest.target
        """1×1: the largest radius of the last eye before its limit."""

    def render(self) -> None:
        """Add the image of the eye that radii are given for."""
        self._tiles.render()
        self._largest.render()

    def read(self) -> float:
        """Return the largest radius of all frames; waits for the GPU."""
        return self._largest.read()

    def reset(self) -> None:
        """Start again from 0."""
        self._largest.reset()


def _limit_and_scale(
    settings: DepthOfField, focal_px: float, size_px: tuple[int, int]
) -> tuple[float, float]:
    """Return the largest radius, and the radius per metre or dioptre of defocus."""
    limit_px = max_radius_of(settings, size_px, focal_px)
    if settings.law == "linear":
        return limit_px, limit_px / settings.full_blur_m
    # A thin lens focused at infinity: the shader knows the focus.
    return limit_px, px_per_dioptre(settings, focal_px=focal_px, size_px=size_px, focus_m=np.inf)


def _law_defines(settings: DepthOfField) -> dict[str, int | float]:
    if settings.law == "linear":
        return {}
    if settings.law != "thin_lens":
        return {"LAW_DIOPTRE": 1}
    return {"LAW_DIOPTRE": 1, "LAW_THIN_LENS": 1, "CLOSEST_FOCUS": CLOSEST_FOCUS}
