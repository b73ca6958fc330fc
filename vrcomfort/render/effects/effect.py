"""Interface of effects: each is one step from an eye's image to the next.

A new effect is a table of settings (`vrcomfort.protocol.conditions.EffectTables`), a pass that is
an `EffectPass`, its shader and the shader's twin, and an `RegisteredEffect` in
`vrcomfort.render.graph`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

import moderngl

from vrcomfort.geometry import Pose
from vrcomfort.protocol.conditions import Condition, EffectName
from vrcomfort.render.camera import EyeCamera, HeadStep, PreviousCamera
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Scene


class EyeFrame(NamedTuple):
    """An eye of this frame, and the previous eye as motion blur counts it.

    `eye_index` is 0 for the left eye, which is drawn first. `step` is how the head got here, None
    where the frame before has nothing to do with this one. `still`: nothing moves in the image.
    """

    eye_index: int
    display_time_ns: int
    head_from_eye: Pose
    camera: EyeCamera
    previous: PreviousCamera | None = None
    step: HeadStep | None = None
    still: bool = False


@dataclass(frozen=True)
class EffectInputs:
    """Textures and settings for building an effect.

    Parameters
    ----------
    colour
        Linear HDR RGBA16F of `size_px`: the result of the effect before.
    depth
        Reverse-Z D32F.
    settings
        The effect's own table of the condition.
    scene
        What has drawn `colour`, where it is the scene's own.
    reads
        Those that the effect asks for: `velocity` is RG16F (px per frame, +x right, +y up), `focus`
        a 1×1 texture with the focus distance of both eyes in metres as x.
    """

    ctx: moderngl.Context
    condition: Condition
    settings: Any
    size_px: tuple[int, int]
    colour: moderngl.Texture
    depth: moderngl.Texture
    scene: ScenePass | None
    reads: Mapping[str, moderngl.Texture]


class EffectPass(Protocol):
    """Draws its inputs, changed, into `target`: linear HDR RGBA16F."""

    target: moderngl.Texture

    @property
    def max_radius_px(self) -> float:
        """Return the largest radius or half streak that it can have."""

    def render(self, eye: EyeFrame) -> None:
        """Draw the present inputs as this eye sees them; the left eye comes first."""

    def warm_up(self) -> None:
        """Draw once the passes that frames without motion skip, so that they are compiled."""

    def clamps(self) -> tuple[str, ...]:
        """Return which limits have shortened a blur so far, in words; waits for the GPU."""

    def reset(self) -> None:
        """Be as if no frame had been drawn."""


@runtime_checkable
class Adjustable(Protocol):
    """An effect, or a focus, that takes other settings while it is there.

    It need take only those of `vrcomfort.protocol.adjustments.ADJUSTABLE`.
    """

    def adjust(self, settings: Any) -> None:
        """Draw by these settings from now on: its own table of the condition."""


@runtime_checkable
class SeesTheSky(Protocol):
    """An effect in which the focus's `infinity_m` counts."""

    def adjust_infinity(self, infinity_m: float) -> None:
        """Take another distance of the sky from now on."""


def reading_colour(make: Callable[..., EffectPass]) -> Callable[[EffectInputs], EffectPass]:
    """Return the builder of an effect that reads only `colour`."""

    def build(inputs: EffectInputs) -> EffectPass:
        return make(
            inputs.ctx, colour=inputs.colour, settings=inputs.settings, size_px=inputs.size_px
        )

    return build


@dataclass(frozen=True)
class RegisteredEffect:
    """How an effect is planned and built.

    Parameters
    ----------
    name
        Of its table of settings in a condition.
    plan
        Say whether it is there in a scene, and why; no OpenGL.
    build
        Make it, where it is there; None where it needs no pass of its own.
    reads
        Images besides colour; focus and velocity are made for nothing else.
    measured
        Settings, besides defaults, with which its cost is measured on a walk: so that it draws.
    """

    name: EffectName
    plan: Callable[[Scene, Condition], PlannedPass]
    build: Callable[[EffectInputs], EffectPass | None]
    reads: frozenset[Literal["depth", "focus", "velocity"]] = frozenset()
    measured: Mapping[str, Any] = field(default_factory=dict)
