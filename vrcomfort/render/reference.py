"""The oracle for both blurs: the scene drawn again for every sample of lens and shutter."""

from __future__ import annotations

from dataclasses import dataclass, replace

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose, focal_length_px
from vrcomfort.optics.sampling import concentric_disc, low_discrepancy
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render import defocus
from vrcomfort.render.camera import EyeCamera, Lens, PreviousCamera
from vrcomfort.render.camera_motion import extrapolated_eye_pose
from vrcomfort.render.scene_data import Scene
from vrcomfort.render.scene_pass import ScenePass


@dataclass(frozen=True)
class Accumulated:
    """Mean radiance of all samples, and of each of two independent halves of them.

    Each is (h, w, 3) float64, linear, bottom row first. `note` says what the reference cannot do.
    """

    image: Array
    halves: tuple[Array, Array]
    samples: int
    note: str


class Reference:
    """Accumulates lens and shutter samples of one eye by brute force.

    The lens has the circle of confusion of the condition's depth of field; with the laws in
    dioptres (``dioptre``, ``eye``, ``thin_lens``) each sample is the exact shear of a thin lens
    without r_max; with ``linear`` it is exact at vertices only. Peripheral blur is left out. The
    shutter is centred on the frame and poses are extrapolated at constant velocity, less the motion
    that the previous pose has cancelled.

    Parameters
    ----------
    condition
        Its effects are sampled; an effect it does not have is not.
    samples
        Per pixel; half of them make each half.
    seed
        Moves the two low-discrepancy sets, each by its own random shift.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene,
        condition: Condition,
        size_px: tuple[int, int],
        *,
        samples: int = 64,
        seed: int = 0,
    ) -> None:
        self._condition = condition
        self._size_px = size_px
        effect = condition.depth_of_field
        self._pass = ScenePass(
            ctx, scene, size_px, velocity=False, lens_law=defocus.lens_law(effect)
        )
        shifts = np.random.default_rng(seed).random((2, 3))
        self._sets = [low_discrepancy(max(1, samples // 2), shift) for shift in shifts]

    def render(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera | None,
        *,
        focus_m: float,
    ) -> Accumulated:
        """Draw the eye's view once for each sample."""
        before = previous or PreviousCamera(camera.world_from_eye, time_s)
        first, second = (
            np.mean([self._draw(camera, time_s, before, focus_m, s) for s in samples], axis=0)
            for samples in self._sets
        )
        count = sum(map(len, self._sets))
        return Accumulated((first + second) / 2, (first, second), count, self._note())

    def _draw(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera,
        focus_m: float,
        sample: Array,
    ) -> NDArray[np.float32]:
        frames = self._shutter_time(sample[2])
        moved = _moved(camera, previous.world_from_eye, frames)
        lens = self._lens(camera, focus_m, sample[:2])
        self._pass.render(replace(moved, lens=lens), time_s + frames * (time_s - previous.time_s))
        return read_rgb(self._pass.colour)

    def _shutter_time(self, sample: float) -> float:
        """Return when a sample sees the scene, in frames from the frame's own time."""
        effect = self._condition.motion_blur
        return (sample - 0.5) * effect.shutter_fraction if effect else 0.0

    def _lens(self, camera: EyeCamera, focus_m: float, sample: Array) -> Lens | None:
        effect = self._condition.depth_of_field
        if effect is None:
            return None
        focal_x, focal_y = focal_length_px(camera.fov, self._size_px)
        x, y = concentric_disc(sample)
        position = (float(x), float(y) * focal_y / focal_x)  # round in angle, not in pixels
        infinity_m = self._condition.focus.infinity_m
        return defocus.lens(effect, position, focal_x, self._size_px, focus_m, infinity_m)

    def _note(self) -> str:
        effect = self._condition.depth_of_field
        if effect is None:
            return "no lens"
        if effect.law == "linear":
            return "law linear: the lens is exact at vertices only"
        if effect.peripheral is not None:
            return (
                f"law {effect.law}: peripheral blur is left out, and r_max does not limit the lens"
            )
        if effect.law == "thin_lens" and effect.distance_offset_m > 0:
            return "law thin_lens with a distance offset: the lens is exact at vertices only"
        return f"law {effect.law}: the lens is exact; r_max does not limit it"


def _moved(camera: EyeCamera, previous_world_from_eye: Pose, frames: float) -> EyeCamera:
    """Return the camera some frames later; the head goes with it, and so does what is locked."""
    if frames == 0:
        return camera
    world_from_eye = extrapolated_eye_pose(camera.world_from_eye, previous_world_from_eye, frames)
    eye_from_head = camera.world_from_eye.inverse() @ camera.head
    return replace(
        camera, world_from_eye=world_from_eye, world_from_head=world_from_eye @ eye_from_head
    )


def read_rgb(texture: moderngl.Texture) -> NDArray[np.float32]:
    """Return the (h, w, 3) colours of a half-float texture, bottom row first."""
    width, height = texture.size
    pixels = np.frombuffer(texture.read(), dtype=np.float16).reshape(height, width, -1)
    return pixels[..., :3].astype(np.float32)
