"""The oracle for both blurs (R1): the scene drawn again for every sample of lens and shutter.

Pixels are sampled where every method samples them, at the four places of multisampling, and not
jittered: blurs are compared, not antialiasing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Pose, focal_length_px
from vrcomfort.gpu import gl
from vrcomfort.optics.lens_sampling import lens_and_shutter
from vrcomfort.protocol.conditions import EFFECTS, Condition, DepthOfField
from vrcomfort.render.camera import EyeCamera, Lens, PreviousCamera, extrapolated_eye_pose
from vrcomfort.render.effects.depth_of_field import lens_radius
from vrcomfort.render.graph import plan_effect
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Scene


@dataclass
class Accumulator:
    """Sums of radiance over two independent halves of the samples, which take turns.

    Parameters
    ----------
    size_px
        (width, height).
    sums
        (2, h, w, 3) float64, linear, bottom row first.
    samples
        How many were added, of both halves.
    """

    size_px: tuple[int, int]
    sums: Array = field(default_factory=lambda: np.zeros(0))
    samples: int = 0

    def __post_init__(self) -> None:
        width, height = self.size_px
        if not self.samples:
            self.sums = np.zeros((2, height, width, 3))

    def add(self, image: NDArray[np.floating]) -> None:
        """Add the next sample's (h, w, 3) image."""
        # In turns: both halves are complete low-discrepancy sets, and their difference is an error
        # estimate without a second run.
        self.sums[self.samples % 2] += image
        self.samples += 1

    @property
    def halves(self) -> tuple[Array, Array]:
        """Return the mean of each half; of a single sample, twice the same."""
        first = self.sums[0] / max(1, (self.samples + 1) // 2)
        second = self.sums[1] / (self.samples // 2) if self.samples > 1 else first
        return first, second

    @property
    def image(self) -> Array:
        """Return the mean of both halves."""
        first, second = self.halves
        return (first + second) / 2


class Reference:
    """Accumulates lens and shutter samples of one eye by brute force.

    The lens has the circle of confusion of the condition's depth of field; with the laws in
    dioptres (``dioptre``, ``eye``, ``thin_lens``) each sample is the exact shear of a thin lens
    without r_max; with ``linear`` it is exact at vertices only. The shutter is centred on the frame
    and poses are extrapolated at constant velocity, less the motion that the previous pose has
    cancelled. Peripheral blur, speed blur, distances along rays and streaks that fade with turning
    are left out.

    Parameters
    ----------
    condition
        Its depth of field and motion blur are sampled, each where it has one.
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
        seed: int = 0,
    ) -> None:
        self._condition = condition
        self._size_px = size_px
        blurred = plan_effect("depth_of_field", scene, condition).needed
        self._lens_effect = condition.depth_of_field if blurred else None
        moving = plan_effect("motion_blur", scene, condition).needed
        self._shutter_effect = condition.motion_blur if moving else None
        self._seed = seed
        self._ctx, self._scene = ctx, scene

    def render(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera | None,
        *,
        focus_m: float,
        samples: int = 64,
        start: Accumulator | None = None,
        on_sample: Callable[[Accumulator], None] | None = None,
    ) -> Accumulator:
        """Draw the eye's view once for each sample.

        Parameters
        ----------
        samples
            How many there are at the end.
        start
            Goes on from here: the result has the same bits as if it had been drawn at once.
        on_sample
            Called after each, to show progress or to keep what there is.
        """
        before = previous or PreviousCamera(camera.world_from_eye, time_s)
        found = start or Accumulator(self._size_px)
        points = lens_and_shutter(
            samples,
            lens=self._lens_effect is not None,
            shutter=self._shutter_effect is not None,
            seed=self._seed,
        )
        for x, y, shutter in points[found.samples :]:
            found.add(self._draw(camera, time_s, before, focus_m, (x, y), shutter))
            if on_sample is not None:
                on_sample(found)
        return found

    def identity(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera | None,
        *,
        focus_m: float,
    ) -> dict[str, Any]:
        """Return all that a picture depends on, apart from scene, shaders and device."""
        before = previous or PreviousCamera(camera.world_from_eye, time_s)
        shutter = self._shutter_effect
        return {
            "size_px": self._size_px,
            "seed": self._seed,
            "fov": camera.fov.tangents,
            "near_m": camera.near_m,
            "poses": [
                [*pose.position, *pose.orientation]
                for pose in (camera.world_from_eye, camera.head, before.world_from_eye)
            ],
            "times_s": (time_s, before.time_s),
            "law": self._lens_effect and self._lens_effect.law,
            "lens": str(self._lens(camera, focus_m, (1.0, 1.0))),
            "shutter_fraction": shutter and shutter.shutter_fraction,
        }

    @cached_property
    def _pass(self) -> ScenePass:
        """Return the pass that draws samples, made when it is first used."""
        law = lens_radius.lens_law(self._lens_effect)
        return ScenePass(self._ctx, self._scene, self._size_px, velocity=False, lens_law=law)

    @property
    def note(self) -> str:
        """Return the reference's limits, and the effects of the condition that it leaves out."""
        lens, shutter = self._lens_effect, self._shutter_effect
        left_out = {
            "peripheral blur": lens and lens.peripheral,
            "the distance along each ray": lens and lens.distance_along == "ray",
            "fading with turning": shutter and shutter.fade_with_turning,
            "background blur": self._condition.background_blur,
            **{
                name.replace("_", " "): plan_effect(name, self._scene, self._condition).needed
                for name in EFFECTS
                if name not in ("depth_of_field", "motion_blur")
            },
        }
        parts = ["no lens" if lens is None else _lens_note(lens)]
        parts += [f"{name} is left out" for name, there in left_out.items() if there]
        return "; ".join(parts)

    def _draw(
        self,
        camera: EyeCamera,
        time_s: float,
        previous: PreviousCamera,
        focus_m: float,
        lens_point: tuple[float, float],
        shutter: float,
    ) -> NDArray[np.float32]:
        fraction = self._shutter_effect.shutter_fraction if self._shutter_effect else 0.0
        frames = shutter * fraction  # centred on the frame: from −½ to ½ of the opening
        moved = _moved(camera, previous.world_from_eye, frames)
        lens = self._lens(camera, focus_m, lens_point)
        self._pass.render(replace(moved, lens=lens), time_s + frames * (time_s - previous.time_s))
        return read_rgb(gl.of_eye(self._pass.colour, 0))

    def _lens(
        self, camera: EyeCamera, focus_m: float, position: tuple[float, float]
    ) -> Lens | None:
        effect = self._lens_effect
        if effect is None:
            return None
        focal_x, focal_y = focal_length_px(camera.fov, self._size_px)
        x, y = position
        # Pixels need not be square: the disc is round for the eye.
        round_in_angle = float(x), float(y) * focal_y / focal_x
        infinity_m = self._condition.focus.infinity_m
        return lens_radius.lens(effect, round_in_angle, focal_x, self._size_px, focus_m, infinity_m)


def _lens_note(lens: DepthOfField) -> str:
    if lens.law == "linear":
        return "law linear: the lens is exact at vertices only"
    at_vertices = lens.law == "thin_lens" and lens.distance_offset_m > 0
    exact = "exact at vertices only (distance offset)" if at_vertices else "exact"
    return f"law {lens.law}: the lens is {exact}; r_max does not limit it"


def _moved(camera: EyeCamera, previous_world_from_eye: Pose, frames: float) -> EyeCamera:
    """Return the camera some frames later; the head and head-locked nodes go with it."""
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
