"""The scene as one eye sees it: linear HDR colour, reverse-Z depth, velocity if asked for."""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.render import lighting
from vrcomfort.render.camera import EyeCamera, Lens, LensLaw, PreviousCamera
from vrcomfort.render.camera_motion import camera_motion
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.shadow import ShadowMap
from vrcomfort.scene.data import Scene

__all__ = ["EyeCamera", "Lens", "LensLaw", "PreviousCamera", "ScenePass"]

VIEW_BINDING = 0
PINHOLE = Lens((0.0, 0.0), focus_m=1.0, infinity_m=1.0, px_per_defocus=0.0, radius_limit_px=0.0)


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
    ) -> None:
        self.size_px = size_px
        self._ctx = ctx
        defines = _defines(velocity=velocity, lens_law=lens_law)
        self.gpu = GpuScene(ctx, scene, defines=defines)
        self._light = lighting.Light(ctx, scene)
        self._shadow = (
            ShadowMap(ctx, self.gpu, radius_m=scene.environment.shadow_distance_m)
            if lighting.has_sun(scene.environment)
            else None
        )
        self._sky = _Sky(ctx, {**lighting.features(scene.environment), **defines})
        self._targets = _Targets(
            ctx, size_px, velocity_dtype=velocity_dtype if velocity else None, samples=samples
        )
        self._view = _ViewBlock(ctx, size_px)
        self.lens_focus: moderngl.Texture | None = None
        """1×1 RGBA32F, x = where lenses focus (m); without it each `Lens` says so itself."""
        self.triangles = 0
        self.still = True
        """Whether nothing in the last image can have moved: every velocity is exactly 0."""

    @property
    def colour(self) -> moderngl.Texture:
        """Return RGBA16F linear radiance, alpha 1."""
        return self._targets.colour

    @property
    def depth(self) -> moderngl.Texture:
        """Return D32F reverse-Z depth, ``near_m / distance``; 0 is the sky."""
        return self._targets.depth

    @property
    def velocity(self) -> moderngl.Texture | None:
        """Return RG16F pixels per frame, or None."""
        return self._targets.velocity

    @property
    def textures(self) -> int:
        """Return the number of image-sized textures this pass owns."""
        return self._targets.count

    def update(self, time_s: float, head: Pose, previous_time_s: float | None = None) -> None:
        """Move the scene to a time; `render` does it where it was not done."""
        self.gpu.update(time_s, head, previous_time_s)

    def render(
        self, camera: EyeCamera, time_s: float, previous: PreviousCamera | None = None
    ) -> None:
        """Draw the scene at a time.

        Parameters
        ----------
        previous
            Where the eye counts as having been; without it all velocities are zero.
        """
        before = previous or PreviousCamera(camera.world_from_eye, time_s)
        self.still = before.world_from_eye == camera.world_from_eye and (
            (before.time_s == time_s or not self.gpu.moves) and not self.gpu.hands_move
        )
        self.gpu.update(time_s, camera.head, before.time_s)
        eye_m = camera.world_from_eye.position
        if self._shadow is not None:
            self._shadow.render(time_s, camera.head)
            self._light.update(eye_m, self._shadow.shadow_from_world, self._shadow.bias)
        else:
            self._light.update(eye_m, None, None)
        self._view.update(camera, before, self.lens_focus)
        self._draw(camera)
        self.triangles += 0 if self._shadow is None else self._shadow.triangles

    def _draw(self, camera: EyeCamera) -> None:
        ctx = self._ctx
        self._targets.begin()
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        eye_m = camera.world_from_eye.position
        clip_from_relative = camera.clip_from_relative()
        self.triangles = self.gpu.draw(clip_from_relative, eye_m, blended=False)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = ">="
        self._sky.draw()
        if self.gpu.has_blended:
            self._targets.blend()
            ctx.depth_func = gl.DEPTH_FUNC
            ctx.enable(moderngl.BLEND)
            self.triangles += self.gpu.draw(clip_from_relative, eye_m, blended=True)
        self._targets.resolve()


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
        self.colour, self.velocity = _colours(ctx, size_px, velocity_dtype, 0)
        self.depth = gl.depth_texture(ctx, size_px)
        colours = [self.colour, *([self.velocity] if self.velocity else [])]
        self._resolved = ctx.framebuffer(colours, self.depth)
        many_colour, many_velocity = _colours(ctx, size_px, velocity_dtype, samples)
        many_depth = gl.depth_texture(ctx, size_px, samples=samples)
        many = [many_colour, *([many_velocity] if many_velocity else [])]
        self._many = ctx.framebuffer(many, many_depth)
        self._many_colour_only = ctx.framebuffer([many_colour], many_depth)
        self._sources = (many_colour, many_depth, *([many_velocity] if many_velocity else []))
        defines = {"SAMPLES": samples, **({"VELOCITY": 1} if velocity_dtype else {})}
        self._resolve = shaders.fullscreen(ctx, "scene/resolve.frag", defines)
        self.count = 2 * len(self._sources)

    def begin(self) -> None:
        """Clear to black at infinity."""
        self._many.use()
        self._many.clear(depth=0.0)

    def blend(self) -> None:
        """Continue with colour only: what blends covers by alpha and writes no depth."""
        self._many_colour_only.use()
        self._many_colour_only.depth_mask = False
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA

    def resolve(self) -> None:
        """Fill the single-sample textures."""
        self._resolved.use()
        self._ctx.enable_only(moderngl.DEPTH_TEST)
        self._ctx.depth_func = "1"
        for unit, texture in enumerate(self._sources):
            texture.use(unit)
        self._resolve.render(vertices=3)
        self._ctx.enable_only(moderngl.NOTHING)


def _colours(
    ctx: moderngl.Context, size_px: tuple[int, int], velocity_dtype: str | None, samples: int
) -> tuple[moderngl.Texture, moderngl.Texture | None]:
    colour = gl.color_texture(ctx, size_px, samples=samples)
    if velocity_dtype is None:
        return colour, None
    velocity = gl.color_texture(ctx, size_px, components=2, dtype=velocity_dtype, samples=samples)
    return colour, velocity


class _ViewBlock:
    """The uniform block of ``shaders/include/view.glsl``."""

    def __init__(self, ctx: moderngl.Context, size_px: tuple[int, int]) -> None:
        self._block = np.zeros((), shaders.block_dtype("view.glsl", "View"))
        self._block["image_size_px"][:2] = size_px
        self._ndc_per_px = 2 / np.array(size_px)
        self._buffer = gl.dynamic_buffer(ctx, self._block.nbytes)
        self._focus_offset = self._block.dtype.fields["lens_focus"][1]

    def update(
        self, camera: EyeCamera, previous: PreviousCamera, lens_focus: moderngl.Texture | None
    ) -> None:
        """Write and bind the block."""
        block = self._block
        motion = camera_motion(camera.world_from_eye, previous.world_from_eye)
        block["clip_from_view"] = camera.clip_from_view().T
        # The transpose of view-from-relative: GLSL stores columns.
        block["view_from_relative"][:3, :3] = motion.view_from_world.T
        block["previous_view_from_relative"][:3, :3] = motion.previous_view_from_world.T
        block["eye_delta_m"][:3] = motion.eye_delta_m
        self._write_lens(camera)
        self._buffer.write(block.tobytes())
        if lens_focus is not None and camera.lens is not None:
            # From texture to block on the GPU: the focus of this frame is not known here.
            lens_focus.read_into(self._buffer, write_offset=self._focus_offset)
        self._buffer.bind_to_uniform_block(VIEW_BINDING)

    def _write_lens(self, camera: EyeCamera) -> None:
        lens = camera.lens or PINHOLE
        head = camera.head
        forward = head.forward
        ahead_m = forward @ (camera.world_from_eye.position - head.position)
        offset = np.array(lens.position) * self._ndc_per_px
        self._block["lens"] = (*offset, 0.0, lens.infinity_m)
        self._block["lens_focus"][0] = lens.focus_m
        self._block["lens_limit"][:2] = lens.px_per_defocus, lens.radius_limit_px
        self._block["head_forward"] = (*forward, ahead_m + lens.distance_offset_m)
