"""What a condition shows: the frozen settings of every effect, in physical units.

Every number that a paper gives is a named setting here; the paper's protocol file sets it.
`None` in place of an effect's settings means that the effect has no pass, no texture and no cost.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from vrcomfort.protocol.settings_file import Name

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Weight = Annotated[float, Field(ge=0.001, le=1)]
ZoneSide = Annotated[int, Field(ge=1, le=1024)]


Kernel = Literal["vrcomfort"]


class Settings(BaseModel):
    """A frozen table of a protocol file; unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


class Focus(Settings):
    """How the focus distance is found and how fast it follows.

    Sources: Carnegie & Rhee 2015 (`nine_ray`), Hillaire et al. 2008 (`autofocus_zone`), Mantiuk et
    al. 2011 (`gaze`).
    """

    method: Literal["nine_ray", "autofocus_zone", "gaze", "fixed"] = "nine_ray"
    fixed_m: Positive = 2.0
    ring_deg: Annotated[float, Field(gt=0, lt=45)] = 2.0
    """Angle of the eight outer rays; the paper says "small regular angular deviations"."""
    mean: Literal["metres", "dioptres"] = "metres"
    """In which unit distances are averaged (nine rays and autofocus zone)."""
    outlier_mad: Positive = 3.0
    """Rays further than this many scaled median absolute deviations from the median are dropped."""
    outlier_floor_fraction: NotNegative = 0.02
    """No ray nearer to the median than this fraction of it is dropped (mean in metres)."""
    outlier_floor_dioptre: NotNegative = 0.02
    """No ray nearer to the median than this is dropped (mean in dioptres)."""
    zone_ratio: Annotated[float, Field(ge=0.01, le=1)] = 0.25
    """Side of the autofocus zone over that of the image: its area is the square of it."""
    zone_size_px: tuple[ZoneSide, ZoneSide] = (64, 64)
    """Width and height at which the zone is drawn, whatever the size of the image."""
    zone_mean_on: Literal["gpu", "cpu"] = "gpu"
    """Where the zone is averaged; the CPU waits for the GPU in every frame."""
    semantic_min: Weight = 0.004
    """W_S,min: least weight of anything, and that of the sky."""
    semantic_max: Weight = 1.0
    """W_S,max: greatest weight of anything; equal to `semantic_min`, all weigh the same."""
    gauss_centre: Weight = 1.0
    """W_G,max: weight of the middle of the zone."""
    gauss_border: Weight = 0.7
    """W_G,min: weight of its border."""
    gaze_radius_deg: Annotated[float, Field(ge=0, le=20)] = 1.5
    """Neighbourhood of the line of sight whose median distance counts: the tracker's error."""
    without_gaze: Literal["stop", "nine_ray"] = "stop"
    """What `gaze` does with a headset that has no eye tracker."""
    law: Literal[
        "linear", "linear_dioptre", "low_pass", "low_pass_backward_euler", "duration", "instant"
    ] = "linear"
    """How focus moves to its target: see `vrcomfort.optics.refocus`."""
    refocus_s: Positive = 0.5
    """Time from `infinity_m` to 1 m: 30 km / 0.5 s (`linear`), 1 D / 0.5 s (`linear_dioptre`)."""
    cutoff_hz: Positive = 5.0
    """Cut-off of `low_pass` and `low_pass_backward_euler`."""
    duration_s: Positive = 0.37
    """Time of every change of focus with `duration`."""
    refixation_dioptre: NotNegative = 0.1
    """With `duration`, a target that moves less is followed; further away, a new change begins."""
    infinity_m: Positive = 30_000.0
    """Distance taken for the sky (the paper's d_max)."""

    @model_validator(mode="after")
    def _weights_rise(self) -> Focus:
        if self.semantic_min > self.semantic_max or self.gauss_border > self.gauss_centre:
            raise ValueError("least weights are greater than greatest ones; swap them")
        return self


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
    """Rings of samples in the widest discs, 8·k on ring k: speed against smoothness."""

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
