"""Interface of effects: each is one step from the eyes' images to the next.

A new effect is a table of settings (`vrcomfort.protocol.conditions.EffectTables`), an `EffectPass`,
its shader and the shader's twin, and a `RegisteredEffect` beside the pass.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

import moderngl

from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.protocol.conditions import Condition, EffectName, Focus
from vrcomfort.render.camera import EyeCamera, HeadStep, PreviousCamera
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Scene


class EyeFrame(NamedTuple):
    """An eye of this frame, and the previous eye as motion blur counts it: itself without any.

    `eye_index` is 0 for the left eye, which is drawn first. `step` is how the head got here, None
    where the frame before has nothing to do with this one. `still`: nothing moves in the image.
    """

    eye_index: int
    display_time_ns: int
    head_from_eye: Pose
    camera: EyeCamera
    previous: PreviousCamera
    step: HeadStep | None = None
    still: bool = False


@dataclass(frozen=True)
class EffectInputs:
    """Textures and settings for building an effect.

    A `FullscreenPass` of these textures draws as many eyes at once as they have layers; what both
    eyes share, such as focus, has none.

    Parameters
    ----------
    settings
        The effect's own table of the condition.
    colour
        Linear HDR RGBA16F: the result of the effect before.
    reads
        Those that the effect asks for: `depth` is reverse-Z D32F, `velocity` RG16F (px per frame,
        +x right, +y up), `focus` a 1×1 texture with the focus distance of both eyes in metres as x.
    infinity_m
        Distance taken for the sky.
    scene
        What has drawn `colour`, where it is the scene's own: it can write radii beside it, and draw
        what near things hide.
    """

    ctx: moderngl.Context
    settings: Any
    colour: AnyTexture
    reads: Mapping[str, AnyTexture] = field(default_factory=dict)
    infinity_m: float = Focus().infinity_m
    scene: ScenePass | None = None

    @property
    def size_px(self) -> tuple[int, int]:
        """Return (width, height) of an eye's image."""
        return gl.size_px_of(self.colour)


class EffectPass:
    """Draws the colour of its inputs, changed, into `target`.

    What it does not define is that of an effect without a limit, which draws all of itself in each
    frame and remembers none.

    Attributes
    ----------
    target
        Linear HDR RGBA16F.
    settings
        Those of the inputs, or of the last :meth:`adjust`.
    """

    target: AnyTexture

    def __init__(self, inputs: EffectInputs) -> None:
        self.settings = inputs.settings

    @property
    def max_radius_px(self) -> float:
        """Return the largest radius or half streak that it can have; 0 if it has none."""
        return 0.0

    def render(self, *eyes: EyeFrame) -> None:
        """Draw the present inputs as these eyes of a frame see them, each its layer.

        Without layers it is called for each eye, the left one first.
        """
        raise NotImplementedError

    def adjust(self, condition: Condition, settings: Any) -> None:
        """Draw by other settings from now on: its own table of the condition.

        Only those of `vrcomfort.protocol.adjustments.ADJUSTABLE` are others.
        """
        del condition
        self.settings = settings

    def warm_up(self) -> None:
        """Draw once the passes that some frames skip, so that they are compiled."""

    def clamps(self) -> tuple[str, ...]:
        """Return which limits have shortened a blur so far, in words; waits for the GPU."""
        return ()

    def reset(self) -> None:
        """Be as if no frame had been drawn."""


@runtime_checkable
class Adjustable(Protocol):
    """A focus that takes other settings while it is there."""

    def adjust(self, settings: Any) -> None:
        """Find it by these settings from now on: those of the condition."""


@dataclass(frozen=True)
class RegisteredEffect:
    """How an effect is planned and built.

    Parameters
    ----------
    name
        Of its table of settings in a condition.
    decide
        Say of settings, condition and scene whether it is there, and why; no OpenGL.
    build
        Make it, where it is there; None where it needs no pass of its own.
    reads
        Images besides colour; focus and velocity are made for nothing else.
    measured
        Settings, besides defaults, with which its cost is measured on a walk: so that it draws.
    """

    name: EffectName
    decide: Callable[[Any, Condition, Scene], tuple[bool, str]]
    build: Callable[[EffectInputs], EffectPass | None]
    reads: frozenset[Literal["depth", "focus", "velocity"]] = frozenset()
    measured: Mapping[str, Any] = field(default_factory=dict)

    def plan(self, scene: Scene, condition: Condition) -> PlannedPass:
        """Plan it; a condition without its settings has none."""
        settings = getattr(condition, self.name)
        if settings is None:
            return PlannedPass(self.name, False, "the condition has none")
        return PlannedPass(self.name, *self.decide(settings, condition, scene))
