"""How far each pixel of one eye is out of focus: colour and signed radius side by side."""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple, TypeAlias

import moderngl
import numpy as np

from vrcomfort.geometry import Array, Fov, Pose, focal_length_px, rotate
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, MaxReductionPass, UniformGroup, Uniforms
from vrcomfort.optics import blur_kernels
from vrcomfort.optics.circle_of_confusion import CLOSEST_FOCUS
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.effects.depth_of_field.lens_radius import (
    max_radius_of,
    px_per_dioptre,
    radius_of_arcmin,
)
from vrcomfort.render.scene_pass import Radii, ResolvePass
from vrcomfort.rotations import rotated

TILE_PX = 8
"""Side of the tiles whose range of radii is known; with 4 px, dilation cost as much as it saved."""


Axis: TypeAlias = tuple[float, float, float]


class EyeUniforms(NamedTuple):
    """Uniforms of ``include/coc_of_depth.glsl`` for the eye that drew the image."""

    tangents: tuple[float, float, float, float]
    head_forward_in_view: tuple[float, float, float]
    near_m: float
    offset_m: float
    eye_in_view: tuple[float, float, float]


class ForwardUniforms(NamedTuple):
    """The fields of `EyeUniforms` without the last: distances along the head's forward axis.

    Two tuples, since a uniform that a variant does not use is an error.
    """

    tangents: tuple[float, float, float, float]
    head_forward_in_view: tuple[float, float, float]
    near_m: float
    offset_m: float


class _Scale(NamedTuple):
    """Pixels per metre or dioptre; they follow from the eye's field of view."""

    px_per_defocus: float


class _Limit(NamedTuple):
    max_radius_px: float


class _Infinity(NamedTuple):
    infinity_m: float


class _ThinLens(NamedTuple):
    focal_length_m: float
    distance_offset_m: float


class _PeripheralUnit(NamedTuple):
    peripheral_px: float
    peripheral_axis_in_view: tuple[float, float, float]


class _PeripheralShape(NamedTuple):
    peripheral_exponent: float


def eye_uniforms(fov: Fov, near_m: float, head_from_eye: Pose) -> EyeUniforms:
    """Return the uniforms that turn an eye's depth into distance from the head centre."""
    *position, x, y, z, w = head_from_eye.numbers
    forward = rotated(-x, -y, -z, w, 0.0, 0.0, -1.0)
    eye_in_view = rotated(-x, -y, -z, w, *position)
    return EyeUniforms(fov.tangents, forward, near_m, -position[2], eye_in_view)


def axis_in_view(axis: Array | None, head_from_eye: Pose) -> Axis | None:
    """Return a direction of the head's frame in that of an eye."""
    if axis is None:
        return None
    x, y, z = rotate(head_from_eye.inverse().orientation, axis).tolist()
    return x, y, z


class _Kept(NamedTuple):
    """Uniforms of an eye, and of which."""

    place: Pose
    axis: Array | None
    frustum: tuple[Fov, float]
    uniforms: Uniforms


class DepthToCoc:
    """Signed radius of any depth in one eye's image, for ``include/coc_of_depth.glsl``.

    Parameters
    ----------
    depth, focus, settings, infinity_m
        Those of :class:`CocPasses`.
    """

    def __init__(
        self,
        *,
        depth: moderngl.Texture,
        focus: moderngl.Texture,
        settings: DepthOfField,
        infinity_m: float,
    ) -> None:
        self._settings, self._size_px = settings, depth.size
        self.depth = depth
        self.inputs = {"focus": focus}
        self._infinity = _Infinity(infinity_m)
        self.constants: Uniforms = UniformGroup(
            *_lens_constants(settings), *_peripheral_constants(settings)
        )
        self._kept: _Kept | None = None
        self._along_ray = settings.distance_along == "ray"
        self.defines: dict[str, Any] = {
            **_law_defines(settings),
            **_peripheral_defines(settings),
            **({"ALONG_RAY": 1} if self._along_ray else {}),
        }

    def make_pass(
        self,
        ctx: moderngl.Context,
        fragment: str,
        *,
        inputs: dict[str, moderngl.Texture] | None = None,
        defines: dict[str, Any] | None = None,
        constants: Uniforms | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return a pass that reads `depth` and includes ``coc_of_depth.glsl``.

        It is drawn with :meth:`of_eye`.
        """
        return FullscreenPass(
            ctx,
            fragment,
            inputs={"depth": self.depth, **self.inputs, **(inputs or {})},
            constants=UniformGroup(self.constants, *([constants] if constants else [])),
            defines={**self.defines, **(defines or {})},
            **options,
        )

    def adjust(self, settings: DepthOfField) -> None:
        """Take other settings of the same law and peripheral exponent."""
        self._settings, self._kept = settings, None

    def adjust_infinity(self, infinity_m: float) -> None:
        """Take another distance of the sky."""
        self._infinity, self._kept = _Infinity(infinity_m), None

    def of_eye(
        self, eye: EyeUniforms, focal_px: float, peripheral_axis: Axis | None = None
    ) -> Uniforms:
        """Return the uniforms of an eye; `focal_px` is the focal length of its image.

        `peripheral_axis`: centre of peripheral blur, in view; None: the head's axis.
        """
        limit, scale = _limit_and_scale(self._settings, focal_px, self._size_px)
        used = eye if self._along_ray else ForwardUniforms(*eye[:-1])
        axis = peripheral_axis or eye.head_forward_in_view
        more = (self._infinity, scale, limit)
        return UniformGroup(used, *more, *_peripheral_unit(self._settings, focal_px, axis))

    def of_camera(self, camera: EyeCamera) -> Uniforms:
        """Return the uniforms of a camera."""
        return self.of_place(
            camera.fov, camera.near_m, camera.head_from_eye, camera.peripheral_axis
        )

    def of_place(
        self, fov: Fov, near_m: float, head_from_eye: Pose, peripheral_axis: Array | None
    ) -> Uniforms:
        """Return the uniforms of an eye; kept for who asks next for the same one in a frame."""
        kept = self._kept
        if (
            kept is None
            or kept.place is not head_from_eye
            or kept.axis is not peripheral_axis
            or (kept.frustum != (fov, near_m))
        ):
            focal_px = focal_length_px(fov, self._size_px)[0]
            eye = eye_uniforms(fov, near_m, head_from_eye)
            uniforms = self.of_eye(eye, focal_px, axis_in_view(peripheral_axis, head_from_eye))
            kept = self._kept = _Kept(head_from_eye, peripheral_axis, (fov, near_m), uniforms)
        return kept.uniforms


class CocPasses:
    """Gives every pixel of `colour` its signed circle-of-confusion radius.

    Parameters
    ----------
    colour, depth
        Linear HDR RGBA16F and reverse-Z D32F of `size_px`.
    focus
        Texture whose first x is the focus distance in metres, the same one for both eyes.
    infinity_m
        Distance taken for the sky.
    resolve
        Resolve that makes `colour`, where it can write radii beside it.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        focus: moderngl.Texture,
        settings: DepthOfField,
        size_px: tuple[int, int],
        infinity_m: float,
        resolve: ResolvePass | None = None,
    ) -> None:
        self.size_px = size_px
        self._resolve = resolve
        self._ctx, self._colour, self._settings = ctx, colour, settings
        self.max_radius_px = max_radius_of(settings, size_px)
        """No eye's image can have a larger radius."""
        self.max_radius_now_px = self.max_radius_px
        """Largest radius that the last eye could have: `max_diameter_arcmin` may make it less."""
        self._least_max_radius_px = self.max_radius_px
        self.depth_to_coc = DepthToCoc(
            depth=depth, focus=focus, settings=settings, infinity_m=infinity_m
        )
        self.now: Uniforms = UniformGroup()
        """Uniforms of the last eye (:meth:`DepthToCoc.of_eye`); empty before the first."""
        self._eye: tuple[Fov, float, Pose] | None = None
        self._is_rendered = False
        self.tile_px = TILE_PX
        """Side of :attr:`tile_min_max`."""
        self.level_defines = {
            "EXACT_PX": blur_kernels.exact_px(settings.samples),
            "LEVELS": blur_kernels.gather_mips(self.max_radius_px, settings.samples),
            "WIDER": blur_kernels.WIDER,
            "FADED": blur_kernels.CROSS_FADE_FROM,
        }
        """Defines of ``include/levels.glsl``."""
        self._tile_min_max = CocTileMinMax(
            ctx,
            self.depth_to_coc,
            size_px=size_px,
            tile_px=self.tile_px,
            defines=self.level_defines,
        )
        self._tiles_are_read = False
        self.tells_clamps = True
        """False draws nothing for :meth:`clamps` alone: for measurements of a kernel's cost."""
        self.widest = None if settings.peripheral else self._tile_min_max.widest
        """1×1, px: no radius of the last eye is wider. None with peripheral blur: tiles only sample
        it."""
        self._colour_and_coc: moderngl.Texture | None = None
        self._beside: FullscreenPass | None = None

    @property
    def eye(self) -> ForwardUniforms | None:
        """Return the last eye; None before the first."""
        return self._eye and ForwardUniforms(*eye_uniforms(*self._eye)[:-1])

    @property
    def tile_min_max(self) -> moderngl.Texture:
        """Tiles of :class:`CocTileMinMax` of the last eye; asking once keeps them drawn."""
        self._tiles_are_read = True
        return self._tile_min_max.target

    @property
    def colour_and_coc(self) -> moderngl.Texture:
        """RGBA16F: finite colour, signed radius in pixels of image width. Drawn if asked for."""
        if self._colour_and_coc is None:
            self._colour_and_coc = self._with_radii()
        return self._colour_and_coc

    def _with_radii(self) -> moderngl.Texture:
        if self._resolve is not None:
            found = self.depth_to_coc
            radii = Radii(found.inputs, found.defines, found.constants, found.of_camera)
            self._resolve.write_radii(radii)
            return self._colour
        inputs = {"colour": self._colour}
        self._beside = self.depth_to_coc.make_pass(
            self._ctx,
            "depth_of_field/colour_and_coc.frag",
            size_px=self.size_px,
            inputs=inputs,
            reach_px={"colour": 0.0, "depth": 0.0},
        )
        if self._is_rendered:
            self._beside.render(self.now)
        return self._beside.target

    def render(
        self,
        *,
        fov: Fov,
        near_m: float,
        head_from_eye: Pose,
        peripheral_axis: Array | None = None,
    ) -> None:
        """Find the radii of an eye's image from its frustum, near plane and place in the head.

        `peripheral_axis`: (3,) that of an `EyeCamera`.
        """
        focal_px = focal_length_px(fov, self.size_px)[0]
        self.max_radius_now_px = max_radius_of(self._settings, self.size_px, focal_px)
        self._least_max_radius_px = min(self._least_max_radius_px, self.max_radius_now_px)
        self.now = self.depth_to_coc.of_place(fov, near_m, head_from_eye, peripheral_axis)
        self._eye, self._is_rendered = (fov, near_m, head_from_eye), True
        if self._beside is not None:
            self._beside.render(self.now)
        if self.tells_clamps or self._tiles_are_read:
            self._tile_min_max.render(self.now)

    def adjust(self, settings: DepthOfField) -> None:
        """Find radii by other settings from now on; see :meth:`DepthToCoc.adjust`."""
        self._settings = settings
        self.depth_to_coc.adjust(settings)

    def adjust_infinity(self, infinity_m: float) -> None:
        """Take another distance of the sky from now on."""
        self.depth_to_coc.adjust_infinity(infinity_m)

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
            ctx,
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
        self._of_eye = MaxReductionPass(
            ctx, self.target, components="z", texel_px=(tile_px, tile_px)
        )
        self.widest = self._of_eye.target
        """1×1: the largest radius of the last eye before its limit."""
        self._largest = MaxReductionPass(ctx, self.widest, components="x")

    def render(self, eye: Uniforms) -> None:
        """Add an eye's image; `eye` is from :meth:`DepthToCoc.of_eye`."""
        self._tiles.render(eye)
        self._of_eye.reset()  # the widest disc is one eye's; only the record goes on
        self._of_eye.render()
        self._largest.render()

    def read(self) -> float:
        """Return the largest radius of all frames; waits for the GPU."""
        return self._largest.read()

    def reset(self) -> None:
        """Start again from 0."""
        self._largest.reset()


def _limit_and_scale(
    settings: DepthOfField, focal_px: float, size_px: tuple[int, int]
) -> tuple[_Limit, _Scale]:
    limit = _Limit(max_radius_of(settings, size_px, focal_px))
    if settings.law == "linear":
        return limit, _Scale(limit.max_radius_px / settings.full_blur_m)
    # A thin lens focused at infinity: the shader knows the focus.
    px = px_per_dioptre(settings, focal_px=focal_px, size_px=size_px, focus_m=np.inf)
    return limit, _Scale(px)


def _law_defines(settings: DepthOfField) -> dict[str, int | float]:
    if settings.law == "linear":
        return {}
    if settings.law != "thin_lens":
        return {"LAW_DIOPTRE": 1}
    return {"LAW_DIOPTRE": 1, "LAW_THIN_LENS": 1, "CLOSEST_FOCUS": CLOSEST_FOCUS}


def _lens_constants(settings: DepthOfField) -> tuple[Uniforms, ...]:
    if settings.law != "thin_lens":
        return ()
    return (_ThinLens(settings.focal_length_m, settings.distance_offset_m),)


def _peripheral_defines(settings: DepthOfField) -> dict[str, int]:
    return {} if settings.peripheral is None else {"PERIPHERAL": 1}


def _peripheral_constants(settings: DepthOfField) -> tuple[Uniforms, ...]:
    shape = settings.peripheral
    return () if shape is None else (_PeripheralShape(shape.exponent),)


def _peripheral_unit(settings: DepthOfField, focal_px: float, axis: Axis) -> tuple[Uniforms, ...]:
    shape = settings.peripheral
    if shape is None:
        return ()
    return (_PeripheralUnit(radius_of_arcmin(shape.unit_diameter_arcmin, focal_px), axis),)
