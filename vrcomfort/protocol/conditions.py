"""What a condition shows: the frozen settings of every effect, in physical units.

Every number that a paper gives is a named setting here; the paper's protocol file sets it.
`None` in place of an effect's settings means that the effect has no pass, no texture and no cost.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from vrcomfort.protocol.settings_file import Name

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


Kernel = Literal["vrcomfort"]


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
    views: Annotated[int, Field(ge=1, le=256)] = 1
    """Points of the lens from which each eye's image is drawn: speed against accuracy. From 2 on,
    the views are blurred a little and averaged; r_max does not limit what lies between them."""
    over_blur: Annotated[float, Field(ge=0, le=4)] = 1.0
    """Radius of the blur of each of K views, in parts of the lens over √K; for one view, of 1."""

    @model_validator(mode="after")
    def _views_need_a_lens(self) -> Self:
        if self.views > 1 and self.law == "linear":
            raise ValueError('views > 1 needs law = "dioptre": no lens follows the law "linear"')
        return self


class MotionBlur(Settings):
    """Velocity-buffer motion blur, per eye (Chapman 2020; McGuire et al. 2012)."""

    mode: Literal["full", "head_cancelled", "rotation_cancelled"] = "rotation_cancelled"
    shutter_fraction: Annotated[float, Field(ge=0, le=1)] = 0.5
    """Part of the frame period during which the shutter is open, centred on the frame's pose."""
    max_radius_percent: Annotated[float, Field(gt=0, le=20)] = 5.0
    """Longest half streak, as a percentage of one eye's image width (logged when it clamps)."""
    samples: Annotated[int, Field(ge=2, le=64)] = 8
    """Samples along 16 px of a streak; longer ones take proportionally more."""


class Condition(Settings):
    """One way of rendering that participants are exposed to."""

    name: Name
    label: str = ""
    focus: Focus = Focus()
    depth_of_field: DepthOfField | None = None
    motion_blur: MotionBlur | None = None
    effect_order: Literal["depth_of_field_first", "motion_blur_first"] = "depth_of_field_first"
