"""The scene as one eye sees it: linear HDR colour, reverse-Z depth, velocity if asked for."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl

from vrcomfort.geometry import Fov, Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render import lighting
from vrcomfort.render.background_blur import foreground
from vrcomfort.render.camera import EyeCamera, Lens, LensLaw, PreviousCamera
from vrcomfort.render.eye_blocks import EyeBlocks
from vrcomfort.render.gpu_scene import GpuScene, Viewpoint
from vrcomfort.render.mip_level import MipLevelPass
from vrcomfort.render.resolve import ResolvePass, Samples
from vrcomfort.render.shadow import ShadowMap
from vrcomfort.scene.data import Scene

__all__ = ["EyeCamera", "Lens", "LensLaw", "PreviousCamera", "ScenePass"]


class ScenePass:
    """Draws a scene; both eyes may share it, one after the other.

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
    ) -> None:
        self.size_px = size_px
        self._ctx = ctx
        defines = _defines(velocity=velocity, lens_law=lens_law)
        sharp = None if background is None else foreground(scene, background)
        self.gpu = GpuScene(ctx, scene, defines=defines, foreground=sharp)
        self._shadow = (
            ShadowMap(ctx, self.gpu, radius_m=scene.environment.shadow_distance_m)
            if lighting.has_sun(scene.environment)
            else None
        )
        self._sky = _Sky(ctx, {**lighting.features(scene.environment), **defines})
        self._targets = _Targets(
            ctx, size_px, velocity_dtype=velocity_dtype if velocity else None, samples=samples
        )
        settings = None if background is None else background.background_blur
        self._background_level = 0.0 if settings is None else settings.level
        self._background = (
            self._targets.background_blur(self._background_level) if settings else None
        )
        self._blocks = EyeBlocks(ctx, scene, size_px, lens=lens_law is not None, velocity=velocity)
        self._eyes: tuple[EyeCamera, ...] = ()
        self._placed: tuple[float, float, Pose] | None = None
        self._shadow_triangles = 0
        self.lens_focus: moderngl.Texture | None = None
        """1×1 RGBA32F, x = where lenses focus (m); without it each `Lens` says so itself."""
        self.triangles = 0
        self.still = True
        """Whether nothing in the last image can have moved: every velocity is exactly 0."""

    @property
    def resolve(self) -> ResolvePass:
        """Return what makes one sample of each pixel."""
        return self._targets.resolve

    @property
    def colour(self) -> moderngl.Texture:
        """Return RGBA16F linear radiance; alpha is 1, or as `resolve` says."""
        return self.resolve.colour

    @property
    def depth(self) -> moderngl.Texture:
        """Return D32F reverse-Z depth, ``near_m / distance``; 0 is the sky."""
        return self.resolve.depth

    @property
    def velocity(self) -> moderngl.Texture | None:
        """Return RG16F pixels per frame, or None."""
        return self.resolve.velocity

    @property
    def textures(self) -> int:
        """Return the number of image-sized textures this pass owns."""
        return self._targets.count

    def update(
        self,
        time_s: float,
        head: Pose,
        previous_time_s: float | None = None,
        eyes: Sequence[EyeCamera] = (),
    ) -> None:
        """Move the scene to a time, and choose what `eyes` are going to see of it, all at once.

        `render` does it for its eye alone where it was not done.
        """
        before_s = time_s if previous_time_s is None else previous_time_s
        self._placed = (time_s, before_s, head)
        self._eyes = tuple(eyes)
        self.gpu.update(time_s, head, before_s)
        if self._shadow is not None:
            self._shadow.render(time_s, head)
            self._shadow_triangles = self._shadow.triangles
        if eyes:
            self.gpu.see([_viewpoint(eye) for eye in eyes])

    def render(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera | None = None,
        *,
        resolve: bool = True,
    ) -> None:
        """Draw the scene at a time.

        Parameters
        ----------
        previous
            Where the eye counts as having been; without it all velocities are zero.
        resolve
            False leaves it to the caller to call `resolve`.
        """
        before = previous or PreviousCamera(camera.world_from_eye, time_s)
        self.still = before.world_from_eye == camera.world_from_eye and (
            (before.time_s == time_s or not self.gpu.moves) and not self.gpu.hands_move
        )
        view = self._view(camera)
        if view is None or self._placed != (time_s, before.time_s, camera.head):
            self.update(time_s, camera.head, before.time_s, [camera])
            view = 0
        self._blocks.update(camera, before, self._shadow, self.lens_focus)
        self._draw(view, camera)
        self.triangles += self._shadow_triangles
        self._shadow_triangles = 0  # the next eye reads the same map
        if resolve:
            self.resolve.render(camera)

    def _view(self, camera: EyeCamera) -> int | None:
        """Return which of the eyes of `update` a camera is, whatever its lens."""
        place = _place(camera)
        return next((view for view, eye in enumerate(self._eyes) if _place(eye) == place), None)

    def _draw(self, view: int, camera: EyeCamera) -> None:
        if self._shadow is not None:
            self._shadow.bind()
        self._targets.begin()
        self.triangles = self._draw_opaque(view)
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._ctx.depth_func = ">="
        self._sky.draw()
        self.triangles += self._draw_blended(view)
        if self._background is not None:
            self._ctx.enable_only(moderngl.NOTHING)
            self.resolve.render(camera)
            self._background.render(self._background_level)
            if self._shadow is not None:
                self._shadow.bind()
            self._targets.use()
            self.triangles += self._draw_opaque(view, foreground=True)
            self.triangles += self._draw_blended(view, foreground=True)
        self._ctx.enable_only(moderngl.NOTHING)

    def _draw_opaque(self, view: int, *, foreground: bool = False) -> int:
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._ctx.depth_func = gl.DEPTH_FUNC
        return self.gpu.draw(view, blended=False, foreground=foreground)

    def _draw_blended(self, view: int, *, foreground: bool = False) -> int:
        if not self.gpu.has_blended:
            return 0
        self._targets.blend()
        self._ctx.depth_func = gl.DEPTH_FUNC
        self._ctx.enable(moderngl.BLEND)
        return self.gpu.draw(view, blended=True, foreground=foreground)


def _viewpoint(camera: EyeCamera) -> Viewpoint:
    return Viewpoint(camera.clip_from_relative(), camera.world_from_eye.position)


def _place(camera: EyeCamera) -> tuple[Pose, Fov, float]:
    return camera.world_from_eye, camera.fov, camera.near_m


def _defines(*, velocity: bool, lens_law: LensLaw | None) -> dict[str, int]:
    wanted = {
        "VELOCITY": velocity,
        "LENS": lens_law is not None,
        "LAW_DIOPTRE": lens_law == "dioptre",
    }
    return {name: 1 for name, needed in wanted.items() if needed}


class _Sky:
    """Fills what nothing was drawn on."""

    def __init__(self, ctx: moderngl.Context, defines: shaders.Defines) -> None:
        program = shaders.program(ctx, "scene/sky.frag", "scene/sky.vert", defines)
        self._triangle = ctx.vertex_array(program, [])

    def draw(self) -> None:
        self._triangle.render(vertices=3)


class _Targets:
    """Multisampled targets and the single-sample ones they are resolved into."""

    def __init__(
        self,
        ctx: moderngl.Context,
        size_px: tuple[int, int],
        *,
        velocity_dtype: str | None,
        samples: int,
    ) -> None:
        self._ctx = ctx
        colour, velocity = _colours(ctx, size_px, velocity_dtype, 0)
        depth = gl.depth_texture(ctx, size_px)
        many_colour, many_velocity = _colours(ctx, size_px, velocity_dtype, samples)
        many_depth = gl.depth_texture(ctx, size_px, samples=samples)
        many = [many_colour, *([many_velocity] if many_velocity else [])]
        self._colours = many_colour
        self._many = ctx.framebuffer(many, many_depth)
        self._many_colour_only = ctx.framebuffer([many_colour], many_depth)
        self.resolve = ResolvePass(
            ctx,
            Samples(many_colour, many_depth, many_velocity),
            colour=colour,
            depth=depth,
            velocity=velocity,
        )
        self.count = 2 * (len(many) + 1)

    def use(self) -> None:
        """Draw colour, depth and velocity from now on."""
        self._many.use()

    def background_blur(self, level: float) -> MipLevelPass:
        """Return what blurs the colour of all samples, as it is resolved; depth stays as it is."""
        colour = self.resolve.colour
        return MipLevelPass(
            self._ctx, colour, most_level=level, size_px=colour.size, target=self._colours
        )

    def begin(self) -> None:
        """Clear to black at infinity."""
        self.use()
        self._many.clear(depth=0.0)
        self.resolve.learn_sample_places()

    def blend(self) -> None:
        """Continue with colour only: what blends covers by alpha and writes no depth."""
        self._many_colour_only.use()
        self._many_colour_only.depth_mask = False
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA


def _colours(
    ctx: moderngl.Context, size_px: tuple[int, int], velocity_dtype: str | None, samples: int
) -> tuple[moderngl.Texture, moderngl.Texture | None]:
    colour = gl.color_texture(ctx, size_px, samples=samples)
    if velocity_dtype is None:
        return colour, None
    velocity = gl.color_texture(ctx, size_px, components=2, dtype=velocity_dtype, samples=samples)
    return colour, velocity
