"""Conditions: the frozen settings of every effect, in physical units.

Every number that a paper gives is a named setting here; the paper's protocol file sets it.
`None` in place of an effect's settings means that the effect has no pass, no texture and no cost.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias, get_args

from pydantic import Field, create_model, field_validator, model_validator
from pydantic_core import PydanticCustomError

from vrcomfort.errors import InputError
from vrcomfort.installed import installed, load, package_of, place_of
from vrcomfort.optics.blur_kernels import HALF_GATHER_SAMPLES, LEAST_TEXELS
from vrcomfort.protocol.marks import LIVE, OnlyWith
from vrcomfort.protocol.quality_levels import Quality, filled, with_level
from vrcomfort.settings import Name, Settings, Word

CentredEffect: TypeAlias = Literal["autofocus_zone", "peripheral", "vignette"]


class GazeCentre(Settings):
    """Effects that are centred on the gaze instead of on the head's forward axis.

    While the tracker does not see the eyes, their last direction in the head's frame is held for
    `hold_s`; then the head's forward axis is the centre, until they are seen again.
    """

    of: Annotated[tuple[CentredEffect, ...], Field(min_length=1)]
    """`autofocus_zone`: the zone of `focus`; `peripheral`: the blur of `depth_of_field`;
    `vignette`: its clear field."""
    hold_s: Annotated[float, Field(ge=0, le=60)] = 0.5
    """How long a gaze that is lost counts on: longer than a blink."""
    without_gaze: Literal["stop", "head"] = "stop"
    """Without an eye tracker: no session, or the head's axis is the centre."""


Distance = Annotated[float, Field(ge=0.001, le=1e9)]
"""Metres: 1 mm, which is nearer than any near plane, to where every eye is at infinity."""
Seconds = Annotated[float, Field(ge=0.001, le=3600)]
Dioptres = Annotated[float, Field(ge=0, le=1000)]
"""Up to those of 1 mm."""
Arcmin = Annotated[float, Field(ge=0, le=10_800)]
"""Up to half a turn."""
ScriptEntry = tuple[Annotated[float, Field(ge=0, le=14_400)], Distance]
FocusScript = tuple[ScriptEntry, ...]
Weight = Annotated[float, Field(ge=0.001, le=1)]
NodePattern = Annotated[str, Field(min_length=1, max_length=256)]
ZoneSide = Annotated[int, Field(ge=1, le=1024)]


Kernel = Literal[
    "vrcomfort",
    "scatter",
    "poisson12",
    "poisson15_near",
    "mip",
    "mip_slices",
    "half_resolution_disc",
    "ring_gather",
    "separable_gaussian",
]
"""Ours; those of Carnegie & Rhee 2015, Hillaire et al. 2008, Mantiuk et al. 2011 and (two) "Four
Tricks for Fast Blurring in Software and Hardware", 2001; and three engines' ways, for comparison:
as KinoBokeh (Takahashi, Unity), as Filament's `dof.mat` and as Bevy's Gaussian."""

FocusRuleName = Literal["nine_ray", "autofocus_zone", "gaze", "fixed", "scripted"]
_RAYS_AHEAD = OnlyWith(method=("nine_ray",))
_ZONE = OnlyWith(method=("autofocus_zone",))
_ZONE_MEAN = OnlyWith(method=("autofocus_zone",), zone_statistic=("mean",))
_GAZE = OnlyWith(method=("gaze",))
_SCRIPT = OnlyWith(method=("scripted",))
_RULES_AT_REST = ("fixed", "scripted")
FOLLOWING = OnlyWith(method=tuple(n for n in get_args(FocusRuleName) if n not in _RULES_AT_REST))
"""Rules whose focus moves by a refocus law."""

RefocusLawName = Literal[
    "linear", "linear_dioptre", "low_pass", "low_pass_backward_euler", "duration", "instant"
]

_FORMER_ORDERS: dict[Any, tuple[str, ...]] = {
    "depth_of_field_first": ("depth_of_field", "motion_blur"),
    "motion_blur_first": ("motion_blur", "depth_of_field"),
}
"""Words of the first version, which protocols of recorded studies have."""

CameraMode = Literal[
    "full", "head_cancelled", "rotation_cancelled", "rotation_cancelled_eye", "objects_only"
]
Carried = Literal["with_head", "in_world"]
VirtualTurning = Literal["by_mode", "kept", "cancelled"]


class Focus(Settings):
    """How the focus distance is found and how fast it follows.

    Sources: Carnegie & Rhee 2015 (`nine_ray`), Hillaire et al. 2008 (`autofocus_zone`), Mantiuk et
    al. 2011 (`gaze`).
    """

    method: FocusRuleName = "nine_ray"
    """`nine_ray`: nine rays ahead, less outliers; `autofocus_zone`: the weighted mean of a zone;
    `gaze`: under the gaze; `fixed`: it never moves; `scripted`: by `script`."""
    fixed_m: Annotated[Distance, OnlyWith(method=("fixed",)), LIVE] = 2.0
    """Focus distance of `fixed`."""
    script: Annotated[FocusScript, _SCRIPT] = ()
    """`scripted`: [time, distance] in seconds and metres, times rising. Between two, focus moves
    linearly in dioptres; before the first and after the last it rests. Time is that of the scene's
    animations: it begins when the scene is entered, with the training where there is one."""
    scripts: Annotated[dict[str, FocusScript], _SCRIPT] = Field(default_factory=dict)
    """`scripted`: scripts of scenes and views that have one of their own, in place of `script`."""
    script_every_s: Annotated[Seconds | None, _SCRIPT] = None
    """`scripted`: period after which the script begins again."""
    ring_deg: Annotated[float, Field(gt=0, lt=45), _RAYS_AHEAD] = 2.0
    """Angle of the eight outer rays; the paper says "small regular angular deviations"."""
    mean: Annotated[
        Literal["metres", "dioptres"],
        OnlyWith(method=("nine_ray", "autofocus_zone"), zone_statistic=("mean",)),
    ] = "metres"
    """In which unit distances are averaged (nine rays, and the mean of the autofocus zone)."""
    outlier_mad: Annotated[float, Field(ge=0.001, le=1e6), _RAYS_AHEAD] = 3.0
    """Rays further than this many scaled median absolute deviations from the median are dropped."""
    outlier_floor_fraction: Annotated[
        float, Field(ge=0, le=1000), OnlyWith(method=("nine_ray",), mean=("metres",))
    ] = 0.02
    """No ray nearer to the median than this fraction of it is dropped (mean in metres)."""
    outlier_floor_dioptre: Annotated[
        Dioptres, OnlyWith(method=("nine_ray",), mean=("dioptres",))
    ] = 0.02
    """No ray nearer to the median than this is dropped (mean in dioptres)."""
    zone_ratio: Annotated[float, Field(ge=0.01, le=1), _ZONE] = 0.25
    """Side of the autofocus zone over that of the image: its area is the square of it."""
    zone_size_px: Annotated[tuple[ZoneSide, ZoneSide], _ZONE] = (64, 64)
    """Width and height at which the zone is drawn, whatever the size of the image."""
    zone_statistic: Annotated[Literal["mean", "minimum", "maximum"], _ZONE] = "mean"
    """Statistic of the zone's distances: their weighted mean, or the nearest or farthest of those
    that weigh more than `semantic_min`; of all where none does."""
    zone_mean_on: Annotated[Literal["gpu", "cpu"], _ZONE] = "gpu"
    """Where the zone is averaged or searched; the CPU waits for the GPU in every frame."""
    semantic_min: Annotated[Weight, _ZONE] = 0.004
    """W_S,min: least weight of anything, and that of the sky."""
    semantic_max: Annotated[Weight, _ZONE] = 1.0
    """W_S,max: greatest weight of anything; equal to `semantic_min`, all weigh the same."""
    gauss_centre: Annotated[Weight, _ZONE_MEAN] = 1.0
    """W_G,max: weight of the middle of the zone."""
    gauss_border: Annotated[Weight, _ZONE_MEAN] = 0.7
    """W_G,min: weight of its border."""
    gaze_radius_deg: Annotated[float, Field(ge=0, le=20), _GAZE] = 1.5
    """Neighbourhood of the line of sight whose median distance counts: the tracker's error."""
    without_gaze: Annotated[Literal["stop", "nine_ray"], _GAZE] = "stop"
    """Focus of `gaze` with a headset that has no eye tracker."""
    law: Annotated[RefocusLawName, FOLLOWING] = "linear"
    """How focus moves to its target: one file of `vrcomfort.optics.refocus` for each."""
    refocus_s: Seconds = 0.5
    """Time from `infinity_m` to 1 m: 30 km / 0.5 s (`linear`), 1 D / 0.5 s (`linear_dioptre`)."""
    cutoff_hz: Annotated[float, Field(ge=0.001, le=10_000)] = 5.0
    """Cut-off of `low_pass` and `low_pass_backward_euler`."""
    duration_s: Seconds = 0.37
    """Time of every change of focus with `duration`."""
    refixation_dioptre: Dioptres = 0.1
    """With `duration`, a target that moves less is followed; further away, a new change begins."""
    infinity_m: Annotated[Distance, LIVE] = 30_000.0
    """Distance taken for the sky (the paper's d_max)."""

    @model_validator(mode="after")
    def _script_is_there(self) -> Focus:
        if self.method == "scripted" and not self.script:
            message = 'method = "scripted" needs a `script`: [[0.0, 2.0], [3.0, 0.5]]'
            raise PydanticCustomError("no_script", message)
        if empty := [scene for scene, script in self.scripts.items() if not script]:
            message = "`scripts.{scene}` has no distances; write some, or remove it"
            raise PydanticCustomError("no_script", message, {"scene": empty[0]})
        for name, script in self.named_scripts.items():
            times = [time_s for time_s, _ in script]
            if any(after <= before for before, after in pairwise(times)):
                message = "the times of `{name}` must rise"
                raise PydanticCustomError("script", message, {"name": name})
            if self.script_every_s is not None and times and times[-1] > self.script_every_s:
                message = "`script_every_s` is before the last time of `{name}`; make it longer"
                raise PydanticCustomError("script_every", message, {"name": name})
        return self

    @model_validator(mode="after")
    def _weights_rise(self) -> Focus:
        if self.semantic_min > self.semantic_max or self.gauss_border > self.gauss_centre:
            raise ValueError("least weights are greater than greatest ones; swap them")
        return self

    @property
    def named_scripts(self) -> dict[str, FocusScript]:
        """Return key → script, of all scenes."""
        return {"script": self.script, **{f"scripts.{k}": v for k, v in self.scripts.items()}}


class Peripheral(Settings):
    """Blur that grows from the centre of the image outwards (Hillaire et al. 2008, Eq. 5 and 6).

    The diameter is ``unit_diameter_arcmin · (1/cos θ − 1)^exponent`` at the angle θ from the head's
    forward axis, on top of that of depth of field.
    """

    exponent: Annotated[float, Field(ge=1, le=8)] = 2.0
    """n of Eq. 5."""
    unit_diameter_arcmin: Annotated[Arcmin, LIVE] = 59.0
    """Diameter at 60°, where 1/cos θ − 1 is 1: the paper's largest one, 11 px of 1280 over 90°."""


_THIN_LENS = OnlyWith(law=("thin_lens",))


class DepthOfField(Settings):
    """Circle of confusion and the kernel that spreads it; amounts are radii."""

    kernel: Kernel = "vrcomfort"
    """How discs are summed: ours, or the method of a source (docs/sources.md)."""
    slices_m: Annotated[
        Annotated[tuple[Distance, ...], Field(min_length=1, max_length=9)] | None,
        OnlyWith(kernel=("mip_slices",)),
    ] = None
    """Depths of the billboards of `mip_slices`: the k-th covers everything behind it with MIP level
    k, whatever the focus ("evenly along the Z-axis", Four Tricks). Without it they stand where the
    circle of confusion asks for their level, on either side of the focus."""
    rotate_taps: Annotated[bool, OnlyWith(kernel=("poisson12",))] = True
    """Whether `poisson12` turns its taps by an angle of each pixel's own, which makes noise of
    ghosts (Hillaire et al. 2008, Fig. 2, shows both)."""
    law: Literal["linear", "dioptre", "thin_lens", "eye"] = "linear"
    """`linear`: radius ∝ |d_f − d| (Carnegie & Rhee); the others ∝ |1/d_f − 1/d|: `dioptre` by the
    defocus that reaches r_max, `thin_lens` by a camera's lens, `eye` by the pupil."""
    distance_along: Literal["head_axis", "ray"] = "head_axis"
    """Which distances the law, and the search for the focus, take: `head_axis`, along the head's
    forward axis, so that a lens is sharp in a plane; `ray`, from the head centre, so that it is
    sharp on a sphere. An eye accommodates to the distance along its line of sight: where people
    look 40° aside, the two differ by 1/cos 40° = 1.3."""
    max_radius_percent: Annotated[float, Field(ge=0, le=10), LIVE] = 1.75
    """r_max as a percentage of one eye's image width; 0 gives the pinhole image."""
    full_blur_m: Annotated[Distance, OnlyWith(law=("linear",)), LIVE] = 10.0
    """Defocus at which the `linear` law reaches r_max (the paper gives no constant). A focus
    farther than this takes its place."""
    full_blur_dioptre: Annotated[
        float, Field(ge=0.001, le=1000), OnlyWith(law=("dioptre",)), LIVE
    ] = 2.0
    """Defocus at which the `dioptre` law reaches r_max."""
    aperture_m: Annotated[float, Field(ge=0, le=1), _THIN_LENS, LIVE] = 0.007
    """Diameter of the opening of `thin_lens`."""
    focal_length_m: Annotated[float, Field(ge=0.001, le=1), _THIN_LENS] = 0.017
    """Focal length of `thin_lens` (ours: that of the eye; no source prints it)."""
    distance_offset_m: Annotated[float, Field(ge=0, le=1e6), _THIN_LENS] = 0.0
    """How far `thin_lens` is behind the head centre: added to the distances of focus and point."""
    pupil_mm: Annotated[float, Field(ge=0, le=20), OnlyWith(law=("eye",)), LIVE] = 4.0
    """Diameter of the pupil of `eye`."""
    max_diameter_arcmin: Annotated[Annotated[float, Field(ge=0.001, le=10_800)] | None, LIVE] = None
    """Largest diameter as an angle in the middle of the image; r_max is the smaller of this and
    `max_radius_percent`, also where `linear` and `dioptre` reach it."""
    peripheral: Peripheral | None = None
    """Peripheral blur on top; both together stay within the largest diameter."""
    samples: Annotated[int, Field(ge=12, le=256), OnlyWith(kernel=("vrcomfort",))] = 36
    """Speed against accuracy of `vrcomfort`: discs of up to this many pixels are summed pixel by
    pixel, wider ones texel by texel on a level of the image on which they have no more: 16 or more.
    With 12, discs are gathered at half resolution, which is cheaper and errs more. The other
    kernels have the fixed numbers of their sources."""
    views: Annotated[int, Field(ge=1, le=256)] = 1
    """Points of the lens from which each eye's image is drawn: speed against accuracy. From 2 on,
    the views are blurred a little and averaged; two err as much as one. The mean has no largest
    radius: blur that would reach `max_radius_percent` in one view is larger. `vrcomfort passes`
    says where that is."""
    over_blur: Annotated[float, Field(ge=0, le=4), OnlyWith(views=range(2, 257))] = 1.0
    """Scales the blur of each of K views, whose radius is 2/√K of the lens at 1, at most half,
    and 0.97 of it with up to eleven (`views` from 2 on). From twelve on, less than 0.75 px per
    dioptre, in an image 90° wide, is left out."""

    @field_validator("samples")
    @classmethod
    def _twelve_or_many(cls, value: int) -> int:
        if HALF_GATHER_SAMPLES < value < LEAST_TEXELS:
            raise PydanticCustomError(
                "samples",
                "must be {half} (gathered at half resolution) or from {least} on",
                {"half": HALF_GATHER_SAMPLES, "least": LEAST_TEXELS},
            )
        return value

    @field_validator("slices_m")
    @classmethod
    def _slices_recede(cls, value: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if any(far <= near for near, far in pairwise(value or ())):
            raise PydanticCustomError("slices", "must rise: the nearest billboard first")
        return value

    @model_validator(mode="after")
    def _views_need_a_lens(self) -> Self:
        if self.views > 1 and self.law not in ("dioptre", "eye"):
            message = 'views > 1 needs law = "dioptre" or "eye", the same lens at any focus'
            raise PydanticCustomError("views_law", message)
        if self.views > 1 and self.peripheral is not None:
            message = "views > 1 cannot be combined with peripheral blur, which no lens makes"
            raise PydanticCustomError("views_peripheral", message)
        if self.views > 1 and self.distance_along == "ray":
            message = (
                'views > 1 cannot be combined with distance_along = "ray": through points of a '
                "lens, a plane is in focus"
            )
            raise PydanticCustomError("views_ray", message)
        return self

    @property
    def pinhole(self) -> bool:
        """Return whether the lens has no opening: everything is in focus."""
        opening = {"eye": self.pupil_mm, "thin_lens": self.aperture_m}
        return opening.get(self.law, 1.0) == 0.0


class TurnRamp(Settings):
    """Grows from 0 at one speed of turning to 1 at another, linearly."""

    from_deg_s: Annotated[float, Field(ge=0, le=100_000), LIVE]
    """0 up to this speed."""
    to_deg_s: Annotated[float, Field(ge=0.001, le=100_000), LIVE]
    """1 from this speed on."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        _check_order("deg_s", self.from_deg_s, self.to_deg_s)
        return self


class MoveRamp(Settings):
    """Grows from 0 at one speed of moving to 1 at another, linearly."""

    from_m_s: Annotated[float, Field(ge=0, le=10_000), LIVE]
    """0 up to this speed."""
    to_m_s: Annotated[float, Field(ge=0.001, le=10_000), LIVE]
    """1 from this speed on."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        _check_order("m_s", self.from_m_s, self.to_m_s)
        return self


def _check_order(unit: str, start: float, end: float) -> None:
    if end <= start:
        message = "`to_{unit}` must be more than `from_{unit}`"
        raise PydanticCustomError("ramp_order", message, {"unit": unit})


class Neck(Settings):
    """Where a head turns: a point in the head's frame, seen from its centre between the eyes."""

    behind_m: Annotated[float, Field(ge=0, le=0.5)] = 0.1
    """How far behind the eyes."""
    below_m: Annotated[float, Field(ge=0, le=0.5)] = 0.0
    """How far below them."""


class MotionBlur(Settings):
    """Velocity-buffer motion blur, per eye (Chapman 2020; McGuire et al. 2012)."""

    method: Literal["reconstruction", "per_pixel"] = "reconstruction"
    """`reconstruction`: respects occlusion (McGuire 2012, Guertin 2013); `per_pixel`: a plain
    gather along each pixel's own velocity (Rosado 2007, which Chapman 2020 cites)."""
    mode: CameraMode = "rotation_cancelled"
    """Camera motion that blurs; `vrcomfort.render.camera` describes the part that each mode
    cancels."""
    virtual_turning: VirtualTurning = "by_mode"
    """Whether turns by locomotion blur, whatever `mode` does with the tracked head. `by_mode`:
    `rotation_cancelled_eye` and `objects_only` cancel them, the other modes keep them. Snap turns
    never blur."""
    neck: Annotated[Neck | None, OnlyWith(mode=("rotation_cancelled",))] = None
    """With `rotation_cancelled`, the point about which the head's rotation is cancelled: the way
    that the eyes go while the head turns on its neck then leaves no streak either. Without it, the
    head centre."""
    hands: Carried = "with_head"
    """Motion of a node that is bound to a hand: in the head's frame, or in the world, where nodes
    that go with the head blur falsely in all modes that cancel the head's motion (Chapman)."""
    shutter_fraction: Annotated[float, Field(ge=0, le=1), LIVE] = 0.5
    """Part of the frame period during which the shutter is open, centred on the frame's pose. A
    film camera's shutter angle is 360 degrees times this: 0.5 is 180 degrees."""
    max_radius_percent: Annotated[float, Field(gt=0, le=20)] = 5.0
    """Longest half streak, as a percentage of one eye's image width (logged when it clamps)."""
    samples: Annotated[int, Field(ge=2, le=64)] = 16
    """Samples along a streak. `per_pixel`: along every one. `reconstruction`: about as many along a
    long one, for twice their square root of reads (docs/motion_blur.md); a short one takes a read
    for every 2 px. Above 16, reads are sharper across the streak; from 9 on, things pass each other
    where their velocities differ by a tenth, up to 8 by a fifth."""
    fade_with_turning: TurnRamp | None = None
    """Shortens all streaks while the head turns, to nothing at `to_deg_s` ("globally reduce the
    blur scale when the head is rotating", Chapman 2020, who gives no speeds)."""


class SpeedRamps(Settings):
    """How much of an effect the participant's speed brings.

    The larger ramp wins; one that is absent does not count.
    """

    speed_of: Literal["head", "avatar", "both"] = "both"
    """`head`: of the tracked head in its room; `avatar`: of locomotion alone, as in Budhiraja et
    al. 2017; `both`: of the head in the scene."""
    turning: TurnRamp | None = None
    """By the speed of turning."""
    moving: MoveRamp | None = None
    """By the speed of moving."""


class SpeedBlur(SpeedRamps):
    """A blur of the whole image that grows with the participant's speed, alike in both eyes.

    As DynamicGaussianBlur of GingerVR (Ang & Quarles 2020), after Budhiraja et al. 2017. GingerVR
    starts at 40 deg/s and gives sigma in pixels (15), of which its 5 x 5 kernel cuts off most;
    here it is an angle.
    """

    max_sigma_arcmin: Annotated[float, Field(ge=0, le=120), LIVE] = 30.0
    """Standard deviation of the Gaussian at full strength, in the middle of the image."""


class RelocationBlur(Settings):
    """A blur of the whole image at a cut (a teleport, the first frame) that sharpens with time.

    After "Four Tricks for Fast Blurring in Software and Hardware", 2001, trick three: the image at
    a MIP level that changes over time. The paper gives no times.
    """

    level: Annotated[float, Field(ge=0, le=9)] = 3.0
    """MIP level at the cut: its texels are 2^level px wide. 3, an eighth of the resolution, is what
    the paper calls "very blurred". The angle of a pixel is the headset's."""
    duration_s: Annotated[Seconds, LIVE] = 0.5
    """Time in which the level falls to 0, at a constant rate."""
    snap_turns: bool = False
    """Whether a snap turn is a relocation, too."""


class BackgroundBlur(Settings):
    """A blur of everything but named nodes, which are drawn over it, sharp: layers by node.

    After "Four Tricks for Fast Blurring in Software and Hardware", 2001, trick three, "Bringing
    Back Some Clarity" and Figure 8: the background is drawn and blurred, and the foreground is
    drawn over the result. It is drawn before all effects, which see it as the scene.
    """

    foreground: Annotated[tuple[NodePattern, ...], Field(min_length=1, max_length=64)]
    """Nodes that stay sharp, with all below them; * and ? stand for letters. The background may
    hide them, as in the scene."""
    level: Annotated[float, Field(ge=0, le=9)] = 3.0
    """MIP level of the background: its texels are 2^level px wide. The angle of a pixel is the
    headset's."""


class Vignette(SpeedRamps):
    """A field-of-view restrictor that closes with the participant's speed, alike in both eyes.

    After Fernandes & Feiner 2016, who darken the border of the view while the user moves. Angles
    are degrees of visual angle across the field, centred on the head's forward axis. Without ramps
    the field is `open_deg` wide all the time.
    """

    open_deg: Annotated[float, Field(gt=0, le=180), LIVE] = 110.0
    """Diameter of the clear field at rest. One that is wider than the headset's cannot be seen."""
    restricted_deg: Annotated[float, Field(ge=0, le=180), LIVE] = 60.0
    """Diameter of the clear field at full speed."""
    feather_deg: Annotated[float, Field(ge=0.01, le=90), LIVE] = 10.0
    """Width of the border, outside the clear field, in which the cover begins."""
    attack_s: Annotated[float, Field(ge=0, le=3600), LIVE] = 0.3
    """Time in which the field closes from `open_deg` to `restricted_deg`, at a constant rate."""
    release_s: Annotated[float, Field(ge=0, le=3600), LIVE] = 1.0
    """Time in which it opens again."""
    colour: Literal["black", "scene"] = "black"
    """Colour of the cover; `scene` is the mean colour of the left eye's image, for both eyes."""

    @model_validator(mode="after")
    def _narrows(self) -> Self:
        if self.restricted_deg > self.open_deg:
            message = "`restricted_deg` must not be more than `open_deg`"
            raise PydanticCustomError("vignette_order", message)
        return self


class EffectTables(Settings):
    """The effects, in the order in which they come where a condition does not say otherwise.

    This is the one list of them: conditions, levels of factors, `effect_order` and the schema have
    what stands here. How each is drawn is in `vrcomfort.render.graph`.
    """

    depth_of_field: DepthOfField | None = None
    """Defocus blur; none without it."""
    motion_blur: MotionBlur | None = None
    """Motion blur; none without it."""
    speed_blur: SpeedBlur | None = None
    """Blur of the whole image with speed; none without it."""
    relocation_blur: RelocationBlur | None = None
    """Blur of the whole image after a cut; none without it."""
    vignette: Vignette | None = None
    """A field of view that closes with speed; none without it."""


EFFECT_GROUP = "vrcomfort.effects"
"""Entry points of installed packages: the name of an effect → the model of its table."""


def _with_installed(shipped: type[EffectTables]) -> type[EffectTables]:
    fields: dict[str, Any] = {}
    for found in installed(EFFECT_GROUP):
        model = load(found)
        if not (isinstance(model, type) and issubclass(model, Settings)):
            raise InputError(f"the entry point {place_of(found)} is not a model of settings")
        if found.name in shipped.model_fields or found.name in fields:
            raise InputError(f"another effect is called `{found.name}` too ({place_of(found)})")
        text = f"Of the package {package_of(found)}; none without it."
        fields[found.name] = (model | None, Field(None, description=text))
    return create_model("EffectTables", __base__=shipped, **fields) if fields else shipped


if not TYPE_CHECKING:
    EffectTables = _with_installed(EffectTables)
EFFECTS: tuple[str, ...] = tuple(EffectTables.model_fields)
if TYPE_CHECKING:
    EffectName: TypeAlias = str
else:
    EffectName = Literal[EFFECTS]


class ConditionName(Settings):
    """A condition's name and label."""

    name: Name
    """As files have it: letters, digits, - and _."""
    label: str = ""
    """In words, for reports."""


class ConditionSettings(EffectTables):
    """All settings of a condition, each of which a level of a factor may set."""

    quality: Quality | None = None
    """Speed against accuracy: gives the effects' settings that are not written here."""
    background_blur: BackgroundBlur | None = None
    """Blur of everything but named nodes; none without it."""
    task: Word | None = None
    """Name of the task in exposures to it; `none` for no task."""
    focus: Focus = Focus()
    """How the focus is found."""
    gaze_centre: GazeCentre | None = None
    """Effects that are centred on the gaze; none without it."""
    effect_order: tuple[EffectName, ...] = EFFECTS
    """Which effect comes first; those that are not named come last, in their usual order."""

    @field_validator("effect_order", mode="before")
    @classmethod
    def _name_former_orders(cls, value: Any) -> Any:
        # Protocols of the first versions, which studies on disk keep, named two orders by a word.
        return _FORMER_ORDERS.get(value, value) if isinstance(value, str) else value

    @field_validator("effect_order")
    @classmethod
    def _name_each_once(cls, value: tuple[EffectName, ...]) -> tuple[EffectName, ...]:
        for name in value:
            if value.count(name) > 1:
                message = "`{name}` is named more than once; name each effect once"
                raise PydanticCustomError("effect_twice", message, {"name": name})
        return (*value, *(name for name in EFFECTS if name not in value))


class Condition(ConditionSettings, ConditionName):
    """One way of rendering that participants are exposed to."""

    levels: dict[str, str] = Field(default_factory=dict)
    """Factor → level, where the condition is a combination of them; [[factors]] fill this in."""

    @model_validator(mode="before")
    @classmethod
    def _take_what_the_level_says(cls, data: Any) -> Any:
        # Before validation: settings that a level fills in are checked as written ones are.
        return filled(data)

    def at_level(self, level: Quality) -> Condition:
        """Return the same condition, sampled as a level of `quality` says."""
        return Condition.model_validate(with_level(self.model_dump(), level))

    def in_scene(self, scene: str) -> Condition:
        """Return the condition as it is in a scene or a view: with the script of its own."""
        script = self.focus.scripts.get(scene)
        if script is None:
            return self
        focus = self.focus.model_copy(update={"script": script, "scripts": {}})
        return self.model_copy(update={"focus": focus})

    @property
    def centred_on_gaze(self) -> tuple[CentredEffect, ...]:
        """Return the condition's gaze-contingent effects."""
        if self.gaze_centre is None:
            return ()
        blur = self.depth_of_field
        there: dict[CentredEffect, bool] = {
            "autofocus_zone": blur is not None and self.focus.method == "autofocus_zone",
            "peripheral": blur is not None and blur.peripheral is not None,
            "vignette": self.vignette is not None,
        }
        return tuple(name for name in self.gaze_centre.of if there[name])

    @property
    def effects(self) -> dict[EffectName, Settings]:
        """Return the settings of the effects that the condition names, in their order."""
        named = {name: getattr(self, name) for name in self.effect_order}
        return {name: settings for name, settings in named.items() if settings is not None}
