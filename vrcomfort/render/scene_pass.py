"""Scene pass, eye by eye: linear HDR colour, reverse-Z depth, velocity if asked for.

Multisampled, then resolved (`ResolvePass`). `EyeBlocks` fills the uniform blocks that all draws of
an eye share.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Fov, Pose
from vrcomfort.gpu import gl, passes, shaders, visible_area
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.passes import AnyTexture, Pass, PassImage
from vrcomfort.gpu.visible_area import VisibleArea, limited_draw
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render import lighting
from vrcomfort.render.background_blur import MipLevelPass, foreground
from vrcomfort.render.camera import (
    CameraMotion,
    EyeCamera,
    Lens,
    LensLaw,
    PreviousCamera,
    camera_motion,
    clips_from_relative,
    previous_clip_from_clip,
    projections,
)
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.lighting import Light
from vrcomfort.render.materials import NEAREST_UNIT
from vrcomfort.render.shadow import ShadowMap
from vrcomfort.scene.data import Scene


class ScenePass:
    """Draws a scene, one eye after the other.

    Parameters
    ----------
    size_px
        (width, height) of the image.
    velocity
        Also make `velocity`: pixels per frame, now minus before, +x right and +y up.
    samples
        Per pixel; colour is their mean, depth and velocity are those of the nearest.
    lens_law
        Compile the shaders for cameras with a `Lens` of this law of defocus.
    velocity_dtype
        ``f2`` half floats, or ``f4`` where rounding must not hide an error.
    background
        The condition whose background is blurred behind its foreground, where it is.
    eyes
        For how many images there is room: 1, which eyes share, or 2, each eye's as a layer.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        size_px: tuple[int, int],
        *,
        velocity: bool,
        samples: int = 4,
        lens_law: LensLaw | None = None,
        velocity_dtype: str = "f2",
        background: Condition | None = None,
        eyes: int = 1,
    ) -> None:
        self.size_px, self._images = size_px, eyes
        self._ctx = ctx
        defines = _defines(velocity=velocity, lens_law=lens_law)
        sharp = None if background is None else foreground(scene, background)
        self.gpu = GpuScene(ctx, scene, defines=defines, foreground=sharp)
        self._shadow = (
            ShadowMap(ctx, self.gpu, radius_m=scene.environment.shadow_distance_m)
            if lighting.has_sun(scene.environment)
            else None
        )
        light = scene.environment
        of_sky = {**lighting.features(light), **defines}
        program = shaders.program(ctx, "scene/sky.frag", "scene/sky.vert", of_sky)
        self._sky = ctx.vertex_array(program, [])
        self._targets = _Targets(
            ctx,
            size_px,
            velocity_dtype=velocity_dtype if velocity else None,
            samples=samples,
            by_brightness=light.exposure if light.resolve == "by_brightness" else None,
            eyes=eyes,
        )
        shadows = () if self._shadow is None else self._shadow.images
        drawn = self._targets.samples
        self._opaque = Pass("scene/scene.frag", (*self.gpu.images, *shadows), drawn)
        self._blended = replace(self._opaque, writes=drawn[:1], blends=True)
        self._behind = Pass("scene/sky.frag", (), drawn)
        settings = None if background is None else background.background_blur
        self._background_level = 0.0 if settings is None else settings.level
        self._background = self._targets.background_blur(self._background_level) if settings else ()
        self._blocks = EyeBlocks(ctx, scene, size_px, lens=lens_law is not None, velocity=velocity)
        self._eyes: tuple[EyeCamera, ...] = ()
        self._previous: tuple[PreviousCamera, ...] = ()
        self._placed: tuple[float, float, Pose] | None = None
        self._view_drawn = 0
        self.lens_focus: moderngl.Texture | None = None
        """1×1 RGBA32F, x = where lenses focus (m); without it each `Lens` says so itself."""
        self.resolve = self._targets.resolve
        """Makes one sample of several."""
        self.colour = self.resolve.colour
        """RGBA16F linear radiance; alpha is 1, or as `resolve` says."""
        self.depth = self.resolve.depth
        """D32F reverse-Z depth, ``near_m / distance``; 0 is the sky."""
        self.velocity = self.resolve.velocity
        """RG16F pixels per frame, or None."""
        self.still = True
        """Whether nothing in the last image can have moved: every velocity is exactly 0."""

    def update(
        self,
        time_s: float,
        head: Pose,
        previous_time_s: float | None = None,
        eyes: Sequence[EyeCamera] = (),
        previous: Sequence[PreviousCamera] = (),
    ) -> None:
        """Move the scene to a time, and cull it and place it for all `eyes` at once.

        `render` does it for its eye alone where it was not done, or not for its `previous`.
        """
        before_s = time_s if previous_time_s is None else previous_time_s
        self._placed = (time_s, before_s, head)
        self._eyes = tuple(eyes)
        self.gpu.update(time_s, head, before_s)
        if self._shadow is not None:
            with passes.part("shadow"):
                self._shadow.render(time_s, head)
        self._previous = tuple(previous)
        if eyes:
            motion = _motion(eyes, previous)
            self.gpu.cull(clips_from_relative(eyes, motion), motion.eye_m)
            self._blocks.write(eyes, motion, self._shadow)

    def render(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera | None = None,
        *,
        resolve: bool = True,
        image: int = 0,
    ) -> None:
        """Draw the scene at a time.

        Parameters
        ----------
        previous
            Where the eye counts as having been; without it all velocities are zero.
        resolve
            False leaves it to the caller to call `resolve`.
        image
            Which one is drawn, of several.
        """
        before = previous or PreviousCamera(camera.world_from_eye, time_s)
        self.still = before.world_from_eye == camera.world_from_eye and (
            (before.time_s == time_s or not self.gpu.moves) and not self.gpu.hands_move
        )
        view = self._view(camera)
        if view is None or self._placed != (time_s, before.time_s, camera.head):
            self.update(time_s, camera.head, before.time_s, [camera], [before])
            view = 0
        self._bind_blocks(view, camera, before)
        self._draw(view, camera, image)
        if resolve:
            self.resolve.render(camera, image)

    def prepare_behind(
        self,
        nearest: AnyTexture,
        colour: AnyTexture,
        depth: AnyTexture,
    ) -> None:
        """Compile what :meth:`draw_behind` draws.

        Parameters
        ----------
        nearest
            R32F: the reverse-Z depth of the nearest thing that is drawn at a pixel.
        colour, depth
            Where it draws, one sample a pixel: RGBA16F and D32F.
        """
        self.gpu.make_behind(self._images)
        self.gpu.add_texture(NEAREST_UNIT, nearest)
        each = [
            (gl.of_eye(colour, image), gl.of_eye(depth, image)) for image in range(self._images)
        ]
        self._single = [_Surfaces(self._ctx, [pair[0]], pair[1]) for pair in each]
        images = tuple(map(passes.PassImage.of, each[0]))
        limit = passes.PassImage.of(nearest, reach_px=0.0)
        self._opaque_behind = replace(
            self._opaque, reads=(*self._opaque.reads, limit), writes=images
        )
        self._blended_behind = replace(
            self._blended, reads=(*self._blended.reads, limit), writes=images[:1]
        )
        self._sky_behind = replace(self._behind, writes=images)

    def draw_behind(self) -> None:
        """Draw the last images again, up to `nearest`, wherever `depth` is less than 1."""
        for image, surfaces in enumerate(self._single):
            if len(self._single) > 1:
                self._blocks.bind(image)
            surfaces.use()
            view = image if len(self._single) > 1 else self._view_drawn
            self._draw_layers(view, behind=surfaces)
        self._ctx.enable_only(moderngl.NOTHING)

    def _bind_blocks(self, view: int, camera: EyeCamera, before: PreviousCamera) -> None:
        """Bind the blocks of an eye; they are there where `update` knew all of it."""
        if camera.lens is None and self._previous and self._previous[view] == before:
            self._blocks.bind(view)
            return
        self._previous = ()
        self._blocks.write([camera], _motion([camera], [before]), self._shadow)
        self._blocks.bind(lens_focus=None if camera.lens is None else self.lens_focus)

    def _view(self, camera: EyeCamera) -> int | None:
        """Return which of the eyes of `update` a camera is, its lens aside."""
        for view, eye in enumerate(self._eyes):
            if eye is camera or _place(eye) == _place(camera):
                return view
        return None

    def _draw(self, view: int, camera: EyeCamera, image: int) -> None:
        self._targets.begin()
        self._draw_layers(view)
        self._view_drawn = view
        if self._background:
            self._ctx.enable_only(moderngl.NOTHING)
            self.resolve.render(camera, image)
            self._background[image].render(self._background_level)
            self._targets.use()
            self._draw_surfaces(view, blended=False, foreground=True)
            self._draw_surfaces(view, blended=True, foreground=True)
        self._ctx.enable_only(moderngl.NOTHING)

    def _draw_layers(self, view: int, *, behind: _Surfaces | None = None) -> None:
        """Draw opaque surfaces, the sky where none is, and blended ones."""
        self._draw_surfaces(view, blended=False, behind=behind)
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._ctx.depth_func = ">="  # the sky lies at infinity: depth 0, as the clear value
        (self._sky_behind if behind else self._behind).run(self._sky.render, vertices=3)
        self._draw_surfaces(view, blended=True, behind=behind)

    def _draw_surfaces(
        self,
        view: int,
        *,
        blended: bool,
        foreground: bool = False,
        behind: _Surfaces | None = None,
    ) -> None:
        if blended:
            if not self.gpu.has_blended:
                return
            (behind or self._targets).blend()
            drawn = self._blended_behind if behind else self._blended
        else:
            drawn = self._opaque_behind if behind else self._opaque
        self._ctx.enable_only(moderngl.DEPTH_TEST | (moderngl.BLEND if blended else 0))
        self._ctx.depth_func = gl.DEPTH_FUNC
        kind = {"blended": blended, "foreground": foreground, "behind": behind is not None}
        drawn.run(self.gpu.draw, view, **kind)


def _motion(eyes: Sequence[EyeCamera], previous: Sequence[PreviousCamera]) -> CameraMotion:
    poses = [each.world_from_eye for each in eyes]
    return camera_motion(poses, [each.world_from_eye for each in previous] or poses)


def _place(camera: EyeCamera) -> tuple[Pose, Fov, float]:
    return camera.world_from_eye, camera.fov, camera.near_m


def _defines(*, velocity: bool, lens_law: LensLaw | None) -> dict[str, int]:
    wanted = {
        "VELOCITY": velocity,
        "LENS": lens_law is not None,
        "LAW_DIOPTRE": lens_law == "dioptre",
    }
    return {name: 1 for name, needed in wanted.items() if needed}


class _Surfaces:
    """Where surfaces are drawn: into all of some images (colour first) with their depth."""

    def __init__(
        self, ctx: moderngl.Context, images: list[moderngl.Texture], depth: moderngl.Texture
    ) -> None:
        self._ctx = ctx
        self._all = gl.framebuffer(ctx, images, depth)
        self.use = self._all.use
        """Draw into all of them from now on."""
        self._colour_only = gl.framebuffer(ctx, images[:1], depth)

    def blend(self) -> None:
        """Continue with colour only: blended surfaces cover by alpha and write no depth."""
        self._colour_only.use()
        self._colour_only.depth_mask = False
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA


class _Targets(_Surfaces):
    """Multisampled targets and the single-sample ones they are resolved into."""

    def __init__(
        self,
        ctx: moderngl.Context,
        size_px: tuple[int, int],
        *,
        velocity_dtype: str | None,
        samples: int,
        by_brightness: float | None,
        eyes: int,
    ) -> None:
        colour, depth = gl.eye_texture(ctx, size_px, eyes), gl.eye_depth(ctx, size_px, eyes)
        many_colour, many_velocity = gl.color_texture(ctx, size_px, samples=samples), None
        velocity = None
        if velocity_dtype is not None:
            kind: dict[str, Any] = {"components": 2, "dtype": velocity_dtype}
            many_velocity = gl.color_texture(ctx, size_px, samples=samples, **kind)
            velocity = gl.eye_texture(ctx, size_px, eyes, **kind)
        many_depth = gl.depth_texture(ctx, size_px, samples=samples)
        many = [many_colour, *([many_velocity] if many_velocity else [])]
        self._colours = many_colour
        super().__init__(ctx, many, many_depth)
        self._cleared = passes.clear([*many, many_depth])
        self.samples = self._cleared.writes
        """Colour first, depth last."""
        area = visible_area.current()
        self._hidden = None if area is None else _HiddenTiles(ctx, area, many_depth)
        self.resolve = ResolvePass(
            ctx,
            Samples(many_colour, many_depth, many_velocity),
            colour=colour,
            depth=depth,
            velocity=velocity,
            by_brightness=by_brightness,
        )

    def background_blur(self, level: float) -> tuple[MipLevelPass, ...]:
        """Return what blurs the colour of all samples of each image; depth stays as it is."""
        size_px, colour = self._colours.size, self.resolve.colour
        return tuple(
            MipLevelPass(
                self._ctx,
                gl.of_eye(colour, image),
                most_level=level,
                size_px=size_px,
                target=self._colours,
            )
            for image in range(gl.layers_of(colour))
        )

    def begin(self) -> None:
        """Clear to black at infinity; what is not seen lies on the near plane."""
        self._cleared.run(self._all.clear, depth=0.0)
        if self._hidden is not None:
            self._hidden.render()
        self.use()
        self.resolve.learn_sample_places()


class _HiddenTiles:
    """Puts the tiles that nobody sees on the near plane: nothing is nearer, and nothing shaded."""

    def __init__(self, ctx: moderngl.Context, area: VisibleArea, depth: moderngl.Texture) -> None:
        self._ctx = ctx
        whole = ctx.vertex_array(shaders.program(ctx, None, "scene/hidden_tiles.vert"), [])
        whole.scope = ctx.scope(ctx.framebuffer([], depth), moderngl.DEPTH_TEST)
        self._declared = Pass("scene/hidden_tiles.vert", (), (PassImage.of(depth),))
        self._draw = limited_draw(area, whole, self._declared.writes[0], elsewhere=True)

    def render(self) -> None:
        """Draw them over a depth that was cleared."""
        self._ctx.depth_func = gl.DEPTH_FUNC
        self._declared.run(self._draw)


VIEW_BINDING, LIGHT_BINDING = 0, 1

PINHOLE = Lens((0.0, 0.0), focus_m=1.0, infinity_m=1.0, px_per_defocus=0.0, max_radius_px=0.0)
"""The centre view's lens, after views through other points."""


class EyeBlocks:
    """The blocks of ``view.glsl`` and ``light.glsl`` of several eyes in one buffer: one upload.

    Parameters
    ----------
    lens
        Whether cameras have a `Lens`.
    velocity
        Whether the image of velocities is resolved from clip positions.
    most
        Eyes at once.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        size_px: tuple[int, int],
        *,
        lens: bool,
        velocity: bool,
        most: int = 2,
    ) -> None:
        view, light = (
            shaders.block_dtype("view.glsl", "View"),
            shaders.block_dtype("light.glsl", "Light"),
        )
        self._sizes = view.itemsize, light.itemsize
        self._light_offset = gl.uniform_stride(view.itemsize)
        self._stride = gl.uniform_stride(self._light_offset + light.itemsize)
        self._bytes = np.zeros((most, self._stride), dtype=np.uint8)
        self._views = self._bytes[:, : view.itemsize].view(view)[:, 0]
        of_light = self._bytes[:, self._light_offset :][:, : light.itemsize]
        self._light = Light(scene, of_light.view(light)[:, 0])
        self._views["image_size_px"][:, :2] = size_px
        self._views["image_size_px"][:, 2] = np.arange(most)
        self._clips, self._previous_clips = (
            self._views[name].swapaxes(1, 2)  # GLSL stores columns
            for name in ("clip_from_view", "previous_clip_from_clip")
        )
        self._now, self._before = (
            self._views[name][:, :3, :3].swapaxes(1, 2)
            for name in ("view_from_relative", "previous_view_from_relative")
        )
        self._eye_delta_m = self._views["eye_delta_m"][:, :3]
        self._ndc_per_px = 2 / np.array(size_px)
        self._lens, self._velocity = lens, velocity
        self._focus_offset = shaders.offset(view, "lens_focus")
        self._buffer = gl.dynamic_buffer(ctx, self._bytes.nbytes)
        self._rewrite = gl.rewriter(ctx, self._buffer)

    def write(
        self,
        cameras: Sequence[EyeCamera],
        motion: CameraMotion,
        shadow: ShadowMap | None,
    ) -> None:
        """Write the blocks of some eyes, and how each counts as having moved."""
        count = len(cameras)
        self._clips[:count] = projections(cameras)[0]
        self._now[:count] = motion.view_from_world
        self._before[:count] = motion.previous_view_from_world
        self._eye_delta_m[:count] = motion.eye_delta_m
        if self._velocity:
            self._previous_clips[:count] = previous_clip_from_clip(cameras, motion)
        if self._lens:
            for view, camera in zip(self._views, cameras, strict=False):
                self._write_lens(view, camera, camera.lens or PINHOLE)
        self._light.look_from(motion.eye_m, None if shadow is None else shadow.uniforms)
        self._rewrite(self._bytes.tobytes())

    def bind(self, view: int = 0, lens_focus: moderngl.Texture | None = None) -> None:
        """Make an eye's blocks those that shaders see.

        Parameters
        ----------
        lens_focus
            1×1, x = where its lens focuses (m); None where the lens says so itself.
        """
        start, (view_size, light_size) = view * self._stride, self._sizes
        if lens_focus is not None:
            # From texture to block on the GPU: the focus of this frame is not known here.
            lens_focus.read_into(self._buffer, write_offset=start + self._focus_offset)
        self._buffer.bind_to_uniform_block(VIEW_BINDING, offset=start, size=view_size)
        start += self._light_offset
        self._buffer.bind_to_uniform_block(LIGHT_BINDING, offset=start, size=light_size)

    def _write_lens(self, view: NDArray[np.void], camera: EyeCamera, lens: Lens) -> None:
        head = camera.head
        forward = head.forward
        ahead_m = forward @ (camera.world_from_eye.position - head.position)
        offset = np.array(lens.position) * self._ndc_per_px
        view["lens"] = (*offset, 0.0, lens.infinity_m)
        view["lens_focus"][0] = lens.focus_m
        view["lens_limit"][:2] = lens.px_per_defocus, lens.max_radius_px
        view["head_forward"] = (*forward, ahead_m + lens.distance_offset_m)


class Radii(NamedTuple):
    """Inputs of ``include/coc_of_depth.glsl``, which gives each depth its circle of confusion.

    Parameters
    ----------
    see_with
        Gives shaders the constants of an eye.
    """

    inputs: dict[str, AnyTexture]
    defines: dict[str, Any]
    see_with: Callable[[EyeCamera], None]


class Samples(NamedTuple):
    """Multisampled textures."""

    colour: moderngl.Texture
    depth: moderngl.Texture
    velocity: moderngl.Texture | None


class ResolvePass:
    """Draws `samples` into `colour`, `depth` and `velocity`: ``scene/resolve.frag``.

    Parameters
    ----------
    by_brightness
        The exposure where samples weigh less the brighter they are; None for their mean.

    Attributes
    ----------
    colour
        RGBA16F linear radiance; alpha is 1, or with :meth:`write_radii` a signed radius in pixels
        of image width. Like the others it holds one image, or each eye's as a layer.
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
        colour: AnyTexture,
        depth: AnyTexture,
        velocity: AnyTexture | None,
        by_brightness: float | None = None,
    ) -> None:
        self._ctx, self._samples = ctx, samples
        self._by_brightness = by_brightness
        self.colour, self.depth, self.velocity = colour, depth, velocity
        self._places: dict[str, Any] = {}
        self.write_radii(None)

    def write_radii(self, radii: Radii | None) -> None:
        """Write circles of confusion into the alpha of colour from now on; None: ones."""
        self._radii = radii
        self._passes = [self._make(image) for image in range(gl.layers_of(self.colour))]

    def render(self, camera: EyeCamera, image: int = 0) -> None:
        """Resolve what an eye has drawn into one of the images."""
        if self._radii is not None:
            self._radii.see_with(camera)
        self._passes[image].render(**self._places)

    def learn_sample_places(self) -> None:
        """Ask the driver where samples lie; it tells of the framebuffer in use only."""
        if self.velocity is not None and not self._places:
            places = gl.sample_places(self._ctx, self._samples.colour.samples)
            self._places = {"sample_place": places if len(places) > 1 else places[0]}

    def _make(self, image: int) -> FullscreenPass:
        many, radii = self._samples, self._radii
        inputs: dict[str, AnyTexture] = {"colors": many.colour, "depths": many.depth}
        targets = [gl.of_eye(self.colour, image)]
        defines: dict[str, Any] = {"SAMPLES": many.colour.samples}
        if self._by_brightness is not None:
            defines["BY_BRIGHTNESS"] = self._by_brightness
        if many.velocity is not None and self.velocity is not None:
            inputs["velocities"] = many.velocity
            targets.append(gl.of_eye(self.velocity, image))
            defines["VELOCITY"] = 1
        if radii is not None:
            inputs |= radii.inputs
            defines |= {"COC": 1, **radii.defines}
        return FullscreenPass(
            self._ctx,
            "scene/resolve.frag",
            size_px=gl.size_px_of(self.colour),
            inputs=inputs,
            defines=defines,
            target=targets,
            depth=gl.of_eye(self.depth, image),
            reach_px={"colors": 0.0, "depths": 0.0, "velocities": 0.0},
        )
