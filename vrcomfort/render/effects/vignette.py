"""Restricts each eye's field of view, the more the faster the participant turns or moves."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, Pose, turn_to
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, copier, of_each
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics.motion import clear_deg, moved_towards, widest_angle_deg
from vrcomfort.protocol.conditions import Condition, Vignette
from vrcomfort.render.camera import speed_share
from vrcomfort.render.effects.effect import EffectInputs, EffectPass, EyeFrame, RegisteredEffect
from vrcomfort.scene.data import Scene

BLOCKS = (32, 32)
"""Parts of the image whose means are averaged."""


def decide(settings: Vignette, condition: Condition, _: Scene) -> tuple[bool, str]:
    """Say whether there is a restrictor; 180 degrees that nothing narrows restrict nothing."""
    ramps = settings.turning is not None or settings.moving is not None
    if not ramps and settings.open_deg == 180:
        return False, "neither turning nor moving narrows the field"
    reason = f"clear field of {settings.open_deg:g} degrees"
    if ramps:
        reason += f", {settings.restricted_deg:g} at full speed"
    if "vignette" in condition.centred_on_gaze:
        reason += ", centred on the gaze"
    return True, reason


class VignettePass(EffectPass):
    """Covers the image outside the clear field.

    The field is a cone round the head's forward axis or the gaze, the same angle for both eyes, and
    as narrow for both: its strength is a frame's, not an eye's. So is its colour: the mean of the
    eye that is drawn first.
    """

    settings: Vignette

    def __init__(self, inputs: EffectInputs) -> None:
        super().__init__(inputs)
        ctx, colour = inputs.ctx, inputs.colour
        self._means: tuple[FullscreenPass, ...] = ()
        images: dict[str, AnyTexture] = {"image": colour}
        if self.settings.colour == "scene":
            blocks = _mean(ctx, gl.of_eye(colour, 0), BLOCKS)
            self._means = blocks, _mean(ctx, blocks.target, (1, 1))
            images["mean"] = self._means[-1].target
        self._pass = FullscreenPass(
            ctx,
            "vignette/vignette.frag",
            size_px=inputs.size_px,
            inputs=images,
            defines={"MEAN_COLOUR": 1} if self._means else {},
            reach_px={"image": 0.0},
        )
        self.target = self._pass.target
        self._copy = copier(ctx, colour, self.target)
        self._strength, self._time_ns, self._mean_time_ns = 0.0, -1, -1

    @property
    def clear_deg(self) -> float:
        """Return the diameter of the clear field in the frame that was drawn last."""
        settings = self.settings
        return clear_deg(settings.open_deg, settings.restricted_deg, self._strength)

    def render(self, *eyes: EyeFrame) -> None:
        """Restrict the present image; where all of it is in the clear field, the copy is exact."""
        self._move(eyes[0])
        seen = [(eye.camera.fov, _centred(eye)) for eye in eyes]
        if max(widest_angle_deg(*each) for each in seen) <= self.clear_deg / 2:
            self._copy()
            return
        if self._mean_time_ns != eyes[0].display_time_ns:
            self._mean_time_ns = eyes[0].display_time_ns
            self._average()
        self._draw(seen)

    def warm_up(self) -> None:
        """Draw everything once, which frames at rest may leave out."""
        self._average()
        seen = Fov.symmetric(vertical_rad=1.0, aspect=1.0), Pose()
        self._draw([seen] * gl.layers_of(self.target))

    def reset(self) -> None:
        """Open the field."""
        self._strength, self._time_ns, self._mean_time_ns = 0.0, -1, -1

    def _move(self, eye: EyeFrame) -> None:
        """Widen or narrow the field once in a frame; a cut opens it."""
        if eye.step is None:
            self._strength, self._time_ns = 0.0, eye.display_time_ns
        if eye.step is None or eye.display_time_ns == self._time_ns:
            return
        self._time_ns = eye.display_time_ns
        self._strength = moved_towards(
            self._strength,
            speed_share(self.settings, eye.step),
            elapsed_s=eye.step.seconds,
            attack_s=self.settings.attack_s,
            release_s=self.settings.release_s,
        )

    def _average(self) -> None:
        for mean in self._means:
            mean.render()

    def _draw(self, seen: Sequence[tuple[Fov, Pose]]) -> None:
        rotations = [centre_from_eye.matrix()[:3, :3].T for _, centre_from_eye in seen]
        self._pass.render(
            tangents_of_eye=of_each([fov.tangents for fov, _ in seen]),
            centre_from_each_eye=np.array(rotations, np.float32).tobytes(),
            clear_rad=float(np.radians(self.clear_deg / 2)),
            feather_rad=float(np.radians(self.settings.feather_deg)),
        )


def _centred(eye: EyeFrame) -> Pose:
    """Return head-from-eye, with the head turned so that the field's axis is its −Z."""
    axis = eye.camera.vignette_axis
    if axis is None:
        return eye.head_from_eye
    return Pose(orientation=turn_to(axis)).inverse() @ eye.head_from_eye


def _mean(ctx: moderngl.Context, image: AnyTexture, size_px: tuple[int, int]) -> FullscreenPass:
    return FullscreenPass(
        ctx,
        "vignette/block_mean.frag",
        size_px=size_px,
        inputs={"image": image},
        constants={"target_px": size_px},
        dtype="f4",
    )


EFFECT = RegisteredEffect("vignette", decide, VignettePass, measured={"open_deg": 60.0})
