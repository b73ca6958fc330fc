"""What a condition shows: the frozen settings of every effect, in physical units.

Every number that a paper gives is a named setting here; the paper's protocol file sets it.
`None` in place of an effect's settings means that the effect has no pass, no texture and no cost.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.protocol.settings_file import Name

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


Kernel = Literal["vrcomfort"]
CameraMode = Literal[
    "full", "head_cancelled", "rotation_cancelled", "rotation_cancelled_eye", "objects_only"
]


class Settings(BaseModel):
    """A frozen table of a protocol file; unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


class Focus(Settings):
    """How the focus distance is found and how fast it follows (Carnegie & Rhee 2015, p. 36)."""

    method: Literal["nine_ray", "fixed"] = "nine_ray"
    fixed_m: Positive = 2.0
    ring_deg: Annotated[float, Field(gt=0, lt=45)] = 2.0
    """Angle of the eight outer rays; the paper says "small regular angular deviations"."""
    mean: Literal["metres", "dioptres"] = "metres"
    outlier_mad: Positive = 3.0
    """Rays further than this many scaled median absolute deviations from the median are dropped."""
    outlier_floor_fraction: NotNegative = 0.02
    """No ray nearer to the median than this fraction of it is dropped (mean in metres)."""
    outlier_floor_dioptre: NotNegative = 0.02
    """No ray nearer to the median than this is dropped (mean in dioptres)."""
    law: Literal["linear", "linear_dioptre", "instant"] = "linear"
    refocus_s: Positive = 0.5
    """Time from `infinity_m` to 1 m: 30 km / 0.5 s (`linear`), 1 D / 0.5 s (`linear_dioptre`)."""
    infinity_m: Positive = 30_000.0
    """Distance taken for the sky (the paper's d_max)."""


class DepthOfField(Settings):
    """Circle of confusion and the kernel that spreads it; amounts are radii."""

    kernel: Kernel = "vrcomfort"
    """How discs are summed: ours, or the method of a source (docs/sources.md)."""
    law: Literal["linear", "dioptre"] = "linear"
    """`linear`: radius ∝ |d_f − d| (the paper); `dioptre`: radius ∝ |1/d_f − 1/d| (a thin lens)."""
    max_radius_percent: Annotated[float, Field(ge=0, le=10)] = 1.75
    """r_max as a percentage of one eye's image width; 0 gives the pinhole image."""
    full_blur_m: Positive = 10.0
    """Defocus at which the `linear` law reaches r_max (the paper gives no constant). A focus
    farther than this takes its place."""
    full_blur_dioptre: Positive = 2.0
    """Defocus at which the `dioptre` law reaches r_max."""
    rings: Annotated[int, Field(ge=1, le=8)] = 3
    """Rings of samples in the widest discs, 8·k on ring k: speed against smoothness."""


class TurnRamp(Settings):
    """Grows from 0 at one speed of turning to 1 at another, linearly."""

    from_deg_s: NotNegative
    to_deg_s: Positive

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        _check_order("deg_s", self.from_deg_s, self.to_deg_s)
        return self


class MoveRamp(Settings):
    """Grows from 0 at one speed of moving to 1 at another, linearly."""

    from_m_s: NotNegative
    to_m_s: Positive

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        _check_order("m_s", self.from_m_s, self.to_m_s)
        return self


def _check_order(unit: str, start: float, end: float) -> None:
    if end <= start:
        message = "`to_{unit}` must be more than `from_{unit}`"
        raise PydanticCustomError("ramp_order", message, {"unit": unit})


class MotionBlur(Settings):
    """Velocity-buffer motion blur, per eye (Chapman 2020; McGuire et al. 2012)."""

    method: Literal["reconstruction", "per_pixel"] = "reconstruction"
    """`reconstruction`: knows who hides whom (McGuire 2012, Guertin 2013); `per_pixel`: a plain
    gather along each pixel's own velocity (Rosado 2007, which Chapman 2020 cites)."""
    mode: CameraMode = "rotation_cancelled"
    """Which camera motion blurs; `vrcomfort.render.camera_motion` says what each cancels."""
    shutter_fraction: Annotated[float, Field(ge=0, le=1)] = 0.5
    """Part of the frame period during which the shutter is open, centred on the frame's pose. A
    film camera's shutter angle is 360 degrees times this: 0.5 is 180 degrees."""
    max_radius_percent: Annotated[float, Field(gt=0, le=20)] = 5.0
    """Longest half streak, as a percentage of one eye's image width (logged when it clamps)."""
    samples: Annotated[int, Field(ge=2, le=64)] = 8
    """`reconstruction`: samples along 16 px of a streak, longer ones take proportionally more, 16
    and above are one for each pixel; `per_pixel`: samples along every streak."""
    fade_with_turning: TurnRamp | None = None
    """Shortens all streaks while the head turns, to nothing at `to_deg_s` ("globally reduce the
    blur scale when the head is rotating", Chapman 2020, who gives no speeds)."""


class SpeedBlur(Settings):
    """A blur of the whole image that grows with the participant's speed, alike in both eyes.

    As DynamicGaussianBlur of GingerVR (Ang & Quarles 2020), after Budhiraja et al. 2017. GingerVR
    starts at 40 deg/s and gives sigma in pixels (15), of which its 5 x 5 kernel cuts off most;
    here it is an angle. Both ramps may be there: the larger wins; one that is absent does not
    count. It comes after the other effects.
    """

    speed_of: Literal["head", "avatar", "both"] = "both"
    """`head`: of the tracked head in its room; `avatar`: of locomotion alone, as in Budhiraja et
    al.; `both`: of the head in the scene."""
    turning: TurnRamp | None = None
    moving: MoveRamp | None = None
    max_sigma_arcmin: Annotated[float, Field(ge=0, le=120)] = 30.0
    """Standard deviation of the Gaussian at full strength, in the middle of the image."""


class Condition(Settings):
    """One way of rendering that participants are exposed to."""

    name: Name
    label: str = ""
    focus: Focus = Focus()
    depth_of_field: DepthOfField | None = None
    motion_blur: MotionBlur | None = None
    speed_blur: SpeedBlur | None = None
    effect_order: Literal["depth_of_field_first", "motion_blur_first"] = "depth_of_field_first"
