"""Both eyes' images of a frame, as arrays."""

from __future__ import annotations

import threading
from typing import Literal, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import Frame
from vrcomfort.geometry import Array, Pose, focal_length_px
from vrcomfort.gpu import gl
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.camera import EyeCamera, PreviousCamera
from vrcomfort.render.condition_passes import EyeImages
from vrcomfort.render.effects.depth_of_field import lens_radius
from vrcomfort.render.effects.depth_of_field.coc_passes import EyeInHead
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.tradeoff.brute_force import read_rgb
from vrcomfort.tradeoff.error_measures import EyeDepth
from vrcomfort.tradeoff.walk import REFRESH_HZ, time_s

_thread = threading.local()


class Capture(NamedTuple):
    """One eye's image before and after the effects (bottom row first), and how it came about."""

    camera: EyeCamera
    previous: PreviousCamera
    head_from_eye: Pose
    sharp: NDArray[np.float32]
    blurred: NDArray[np.float32]
    depth: NDArray[np.float32]
    velocity_px: NDArray[np.float32] | None

    @property
    def eye(self) -> EyeDepth:
        """Return the depth view that pairs this eye's pixels with the other's."""
        camera = self.camera
        return EyeDepth(camera.world_from_eye, camera.fov, self.depth, camera.near_m)


def context() -> moderngl.Context:
    """Return this thread's OpenGL context, made when it is first asked for, as the current one."""
    if not hasattr(_thread, "context"):
        _thread.context = gl.create_context()
    found: moderngl.Context = _thread.context
    found.mglo.__enter__()  # the rest of the program may have a context of its own
    return found


def capture_views(
    scene: Scene,
    condition: Condition,
    pair: tuple[Frame, Frame],
    size_px: tuple[int, int],
    *,
    eyes: Literal[1, 2] = 2,
) -> tuple[Capture, ...]:
    """Draw the second frame of a pair with both eyes, or with the left one alone."""
    before, frame = pair
    found: list[Capture] = []

    def keep(index: int, images: EyeImages) -> None:
        head_from_eye = frame.head_pose.inverse() @ frame.views[index].pose
        found.append(_capture_of(images, head_from_eye))

    renderer = StereoRenderer(context(), size_px, eyes=eyes)
    renderer.begin(scene, condition)
    # Motion blur needs the frame before; without it, the pair's second frame is all there is.
    if condition.motion_blur is not None:
        renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)
    renderer.render(frame, time_s(frame), keep)
    renderer.release()
    return tuple(found)


def radius_px(capture: Capture, condition: Condition) -> Array:
    """Return the (h, w) signed circle-of-confusion radii of an eye; zeros without depth of field.

    These are those that the shaders compute, in float64, for laws in dioptres, which all that is
    compared here has.
    """
    settings = condition.depth_of_field
    if settings is None:
        return np.zeros(capture.depth.shape)
    height, width = capture.depth.shape
    row, column = np.mgrid[:height, :width]
    uv = np.stack([(column + 0.5) / width, (row + 0.5) / height], axis=-1)
    focal_px = focal_length_px(capture.camera.fov, (width, height))[0]
    focus_m = condition.focus.fixed_m
    max_radius_px = lens_radius.max_radius_of(settings, (width, height))
    px = lens_radius.px_per_dioptre(
        settings, focal_px=focal_px, size_px=(width, height), focus_m=focus_m
    )
    eye = EyeInHead.of(capture.head_from_eye)
    return coc.signed_radius_px(
        capture.depth,
        law="dioptre",
        focus_m=focus_m,
        near_m=capture.camera.near_m,
        max_radius_px=max_radius_px,
        full_blur=max_radius_px / px,
        slope=coc.head_depth_slope(capture.camera.fov, eye.head_forward_in_view, uv),
        offset_m=eye.offset_m,
        infinity_m=condition.focus.infinity_m,
    )


def _capture_of(images: EyeImages, head_from_eye: Pose) -> Capture:
    width, height = images.depth.size
    velocity = None
    if images.velocity is not None:
        halves = np.frombuffer(images.velocity.read(), np.float16)
        velocity = halves.reshape(height, width, 2).astype(np.float32)
    depth = np.frombuffer(gl.read(images.depth), np.float32).reshape(height, width)
    return Capture(
        images.camera,
        images.previous,
        head_from_eye,
        read_rgb(images.pinhole),
        read_rgb(images.linear),
        depth,
        velocity,
    )
