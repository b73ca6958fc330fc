"""Views and devices: headset, locomotion, photodiode, and views of scenes."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.settings import Name, Settings, Word
from vrcomfort.settings.camera_path import PathPoints

Ipd = Annotated[float, Field(ge=0.04, le=0.08)]
PixelCount = Annotated[int, Field(ge=16, le=8192)]


DepthMode: TypeAlias = Literal["off", "scene", "blur_aware"]
Percent = Annotated[float, Field(ge=0, le=100)]


class SeenTimeLimits(Settings):
    """Shares of the time in which an exposure did not wait; above them it is flagged."""

    frozen: Percent = 1.0
    """The picture stood still."""
    half_rate: Percent = 1.0
    """New frames came late: at half the display's rate, or less."""
    untracked: Percent = 1.0
    """The head's pose was not measured."""
    unfocused: Percent = 1.0
    """A menu of the headset's was in front."""


class HeadsetSettings(Settings):
    """Settings of the headset; a playback headset is built from them."""

    name: str = ""
    """Which headset the study is for; `vrcomfort check` tells sizes in its pixels."""
    image_size_px: tuple[PixelCount, PixelCount] = (1832, 1920)
    """Width and height of one eye's image in that headset, for `vrcomfort check`. A session records
    those of the headset itself."""
    refresh_hz: Annotated[float, Field(ge=1, le=1000)] = 90.0
    """Of that headset's display, for `vrcomfort check`: streaks are those of one period."""
    depth: DepthMode = "blur_aware"
    """Depth that the headset's runtime gets with each image, where it takes any, to shift images
    with the head. `off`: none, images are only turned; `scene`: of the surface in each pixel, whose
    blurred outlines a shift tears; `blur_aware`: of what is seen, so that a blurred foreground's
    depth reaches as far as its blur (without depth of field the same as `scene`)."""
    ipd_m: Ipd = MEAN_IPD_M
    """Distance between the eyes, where no headset says it."""
    ipd_range_m: tuple[Ipd, Ipd] | None = None
    """Least and greatest distance between pupils that the headset can be fitted to. For a
    participant outside of it (`run --ipd-mm`) the experimenter decides before the exposure."""

    @field_validator("ipd_range_m")
    @classmethod
    def _range_rises(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and value[0] >= value[1]:
            raise PydanticCustomError("ipd_range", "must rise: the least distance first")
        return value


class Answering(Settings):
    """How participants answer on the panel in a headset."""

    dwell_s: Annotated[float, Field(ge=0.3, le=10)] = 1.2
    """Dwell time of a look on an answer, twice, where there is no button to press."""
    head: bool = True
    """Without controllers and an eye tracker, the middle of the head's view points."""
    stop_by_looks: bool = True
    """A look down asks to stop an exposure, with a controller in hand as without; the panel then
    asks whether they are sure."""
    stop_down_deg: Annotated[float, Field(ge=20, le=85)] = 60.0
    """Least angle of that look below the horizon."""
    stop_down_s: Annotated[float, Field(ge=0.5, le=30)] = 2.0
    """Least duration of that look."""


class Visibility(Settings):
    """Faults that `vrcomfort check` would refuse and the study intends."""

    unseen: tuple[str, ...] = ()
    """Conditions whose blur and streaks are below a pixel for nine tenths of the image."""
    alike: tuple[tuple[str, str], ...] = ()
    """Pairs of conditions that differ by less than a pixel there."""


class LocomotionSettings(Settings):
    """How participants move through a scene."""

    mode: Literal["walk", "teleport", "off"] = "walk"
    """`walk`: the left thumb-stick, or keys, move the participant on. `teleport`: each push moves
    by `teleport_m` at once. `off`: controls neither move nor turn. Along the path of a view there
    is no walking."""
    teleport_m: Annotated[float, Field(ge=0.1, le=100)] = 2.0
    """How far a teleport goes; not through walls, and no higher than a step."""
    walking_speed_m_s: Annotated[float, Field(ge=0.001, le=100)] = 1.4
    """Total speed, stairs included: climbing takes from the horizontal part."""
    turning_deg_s: Annotated[float, Field(ge=1, le=720)] = 60.0
    """Rate at which the right thumb-stick turns the participant."""
    snap_turn_deg: Annotated[float, Field(ge=1, le=180)] | None = None
    """The right thumb-stick turns by this angle at once, each time that it is pushed aside; without
    it, it turns at `turning_deg_s`. The mouse of a window always turns smoothly."""

    @property
    def step_at_once_m(self) -> float | None:
        """Return the length of a teleport, None without teleports."""
        return self.teleport_m if self.mode == "teleport" else None


class Photodiode(Settings):
    """A patch in a corner of both images, for a photodiode: black, and white in some frames."""

    corner: Literal["upper_left", "upper_right", "lower_left", "lower_right"] = "lower_left"
    """Place of the patch. Lenses may hide the corners: check in the headset."""
    size_deg: Annotated[float, Field(ge=0.5, le=45)] = 5.0
    """Width and height as angles from the eye."""
    inset_deg: Annotated[float, Field(ge=0, le=60)] = 0.0
    """How far from the edges of the field it begins."""
    white: Literal["onset", "every_other_frame"] = "onset"
    """`onset`: for `onset_s` from the first frame of each exposure on. `every_other_frame`: in the
    first drawn frame of each exposure, the third, the fifth …"""
    onset_s: Annotated[float, Field(ge=0.001, le=60)] = 0.1
    """How long it is white with `onset`."""


class SceneView(Settings):
    """A scene from a place, along a path, or for a time of its own.

    Its `name` stands in `scenes`, in sequences and in the column `scene`, beside those of whole
    scenes.
    """

    name: Name
    """Name of the view in trials."""
    scene: str
    """A shipped scene by name, or a .glb/.gltf file relative to the protocol file."""
    viewpoint: Word | None = None
    """Where the participant begins: a name of [viewpoints] in the scene's side-car."""
    path: Word | None = None
    """Along which the participant is carried: a name of [paths] in the scene's side-car."""
    points: PathPoints | None = None
    """Instead of a name, the path itself: floor points with times."""
    unwrapped: bool = False
    """Of `points`: whether `yaw_deg` turns as far as is written, from 0 to 360 once round to the
    left. Without it, headings turn the shorter way, and 360 degrees are none."""
    loop: bool = False
    """Whether `points` begin again when they are over: the last is where the first is, and headings
    differ by whole turns."""
    exposure_s: Annotated[float, Field(ge=0.001, le=14_400)] | None = None
    """How long a trial shows it; without it, the protocol's `exposure_s`."""

    @property
    def carried(self) -> bool:
        """Return whether the participant is moved along a path, and does not walk."""
        return self.path is not None or self.points is not None
