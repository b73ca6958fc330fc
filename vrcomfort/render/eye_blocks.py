"""What all draws of one eye share: the uniform blocks of ``view.glsl`` and ``light.glsl``."""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.gpu import gl, shaders
from vrcomfort.render.camera import EyeCamera, Lens, PreviousCamera
from vrcomfort.render.camera_motion import camera_motion, previous_clip_from_clip
from vrcomfort.render.lighting import Light
from vrcomfort.render.shadow import ShadowMap
from vrcomfort.scene.data import Scene

VIEW_BINDING, LIGHT_BINDING = 0, 1

PINHOLE = Lens((0.0, 0.0), focus_m=1.0, infinity_m=1.0, px_per_defocus=0.0, radius_limit_px=0.0)
"""The centre view's lens, after views through other points."""


class EyeBlocks:
    """Both blocks in one buffer, which one call fills.

    Parameters
    ----------
    lens
        Whether cameras have a `Lens`.
    velocity
        Whether the image of velocities is resolved from clip positions.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        size_px: tuple[int, int],
        *,
        lens: bool,
        velocity: bool,
    ) -> None:
        view, light = (
            shaders.block_dtype("view.glsl", "View"),
            shaders.block_dtype("light.glsl", "Light"),
        )
        self._sizes = view.itemsize, light.itemsize
        self._light_offset = gl.uniform_stride(view.itemsize)
        self._bytes = np.zeros(self._light_offset + light.itemsize, dtype=np.uint8)
        self._view = self._bytes[: view.itemsize].view(view).reshape(())
        self._light = Light(scene, self._bytes[self._light_offset :].view(light).reshape(()))
        self._view["image_size_px"][:2] = size_px
        self._clip_from_view = self._view["clip_from_view"]
        self._view_from_relative = self._view["view_from_relative"][:3, :3]
        self._previous_view_from_relative = self._view["previous_view_from_relative"][:3, :3]
        self._eye_delta_m = self._view["eye_delta_m"][:3]
        self._ndc_per_px = 2 / np.array(size_px)
        self._lens, self._velocity = lens, velocity
        self._focus_offset = shaders.offset(view, "lens_focus")
        self._buffer = gl.dynamic_buffer(ctx, self._bytes.nbytes)

    def update(
        self,
        camera: EyeCamera,
        previous: PreviousCamera,
        shadow: ShadowMap | None,
        lens_focus: moderngl.Texture | None,
    ) -> None:
        """Write and bind the blocks for an eye.

        Parameters
        ----------
        lens_focus
            1×1, x = where lenses focus (m); None where each lens says so itself.
        """
        motion = camera_motion(camera.world_from_eye, previous.world_from_eye)
        # Transposed: GLSL stores columns.
        self._clip_from_view[...] = camera.clip_from_view().T
        self._view_from_relative[...] = motion.view_from_world.T
        self._previous_view_from_relative[...] = motion.previous_view_from_world.T
        self._eye_delta_m[...] = motion.eye_delta_m
        if self._velocity:
            self._view["previous_clip_from_clip"] = previous_clip_from_clip(
                camera.clip_from_view(), camera.world_from_eye, previous.world_from_eye
            ).T
        if self._lens:
            self._write_lens(camera, camera.lens or PINHOLE)
        self._light.look_from(camera.world_from_eye.position, shadow)
        self._buffer.orphan()  # what the other eye is being drawn with stays as it is
        self._buffer.write(self._bytes)
        if lens_focus is not None and camera.lens is not None:
            # From texture to block on the GPU: the focus of this frame is not known here.
            lens_focus.read_into(self._buffer, write_offset=self._focus_offset)
        self._bind()

    def _bind(self) -> None:
        view, light = self._sizes
        self._buffer.bind_to_uniform_block(VIEW_BINDING, offset=0, size=view)
        self._buffer.bind_to_uniform_block(LIGHT_BINDING, offset=self._light_offset, size=light)

    def _write_lens(self, camera: EyeCamera, lens: Lens) -> None:
        head = camera.head
        forward = head.forward
        ahead_m = forward @ (camera.world_from_eye.position - head.position)
        offset = np.array(lens.position) * self._ndc_per_px
        self._view["lens"] = (*offset, 0.0, lens.infinity_m)
        self._view["lens_focus"][0] = lens.focus_m
        self._view["lens_limit"][:2] = lens.px_per_defocus, lens.radius_limit_px
        self._view["head_forward"] = (*forward, ahead_m + lens.distance_offset_m)
