"""What a condition shows: the frozen settings of every effect, in physical units.

Every number that a paper gives is a named setting here; the paper's protocol file sets it.
`None` in place of an effect's settings means that the effect has no pass, no texture and no cost.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from vrcomfort.protocol.settings_file import Name

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


Kernel = Literal["vrcomfort", "scatter", "poisson12", "poisson15_near", "mip", "mip_slices"]
"""Ours, and those of Carnegie & Rhee 2015, Hillaire et al. 2008, Mantiuk et al. 2011, and (the last
two) "Four Tricks for Fast Blurring in Software and Hardware", 2001."""


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


class Peripheral(Settings):
    """Blur that grows from the centre of the image outwards (Hillaire et al. 2008, Eq. 5 and 6).

    The diameter is ``unit_diameter_arcmin · (1/cos θ − 1)^exponent`` at the angle θ from the head's
    forward axis, on top of that of depth of field.
    """

    exponent: Annotated[float, Field(ge=1, le=8)] = 2.0
    """n of Eq. 5."""
    unit_diameter_arcmin: NotNegative = 59.0
    """Diameter at 60°, where 1/cos θ − 1 is 1: the paper's largest one, 11 px of 1280 over 90°."""


class DepthOfField(Settings):
    """Circle of confusion and the kernel that spreads it; amounts are radii."""

    kernel: Kernel = "vrcomfort"
    """How discs are summed: ours, or the method of a source (docs/sources.md)."""
    law: Literal["linear", "dioptre", "thin_lens", "eye"] = "linear"
    """`linear`: radius ∝ |d_f − d| (Carnegie & Rhee); the others ∝ |1/d_f − 1/d|: `dioptre` by the
    defocus that reaches r_max, `thin_lens` by a camera's lens, `eye` by the pupil."""
    max_radius_percent: Annotated[float, Field(ge=0, le=10)] = 1.75
    """r_max as a percentage of one eye's image width; 0 gives the pinhole image."""
    full_blur_m: Positive = 10.0
    """Defocus at which the `linear` law reaches r_max (the paper gives no constant). A focus
    farther than this takes its place."""
    full_blur_dioptre: Positive = 2.0
    """Defocus at which the `dioptre` law reaches r_max."""
    aperture_m: NotNegative = 0.007
    """Diameter of the opening of `thin_lens`."""
    focal_length_m: Positive = 0.017
    """Focal length of `thin_lens` (ours: that of the eye; no source prints it)."""
    distance_offset_m: NotNegative = 0.0
    """How far `thin_lens` is behind the head centre: added to the distances of focus and point."""
    pupil_mm: Annotated[float, Field(ge=0, le=20)] = 4.0
    """Diameter of the pupil of `eye`."""
    max_diameter_arcmin: Positive | None = None
    """Largest diameter as an angle in the middle of the image, besides `max_radius_percent`."""
    peripheral: Peripheral | None = None
    """Peripheral blur on top; both together stay within the largest diameter."""
    rings: Annotated[int, Field(ge=1, le=8)] = 3
    """Rings of samples in the widest discs of `vrcomfort`, 8·k on ring k: speed against smoothness.
    The other kernels have the fixed numbers of their sources."""

    @property
    def pinhole(self) -> bool:
        """Return whether the lens has no opening: everything is in focus."""
        opening = {"eye": self.pupil_mm, "thin_lens": self.aperture_m}
        return opening.get(self.law, 1.0) == 0.0


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
