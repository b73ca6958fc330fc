"""Settings of the OpenXR headset."""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.headset.locomotion import TURNING_DEG_S, WALKING_SPEED_M_S
from vrcomfort.protocol.viewing import DepthMode


@dataclass(frozen=True)
class OpenXrSettings:
    """Settings of `OpenXrHeadset`.

    Parameters
    ----------
    application
        The name that the runtime shows to its operator.
    image_size_px
        (width, height) of one eye's image; None takes the size that the runtime recommends.
    refresh_hz
        To switch the display to; refused where the runtime cannot. None leaves it as it is.
    eye_height_m
        How far the floor is below the origin where the runtime does not know the floor.
    depth
        Depth given to a runtime that can use it (see `openxr.layers.DepthImages`): ``off``, or as
        what it is recorded. What it is of, the caller decides (`OpenXrHeadset.take_depth`).
    api_layers
        API layers to switch on, as validation does; what they say becomes events.
    image_timeout_s
        How long the runtime may take to give back an image before it counts as lost.
    patience_s
        How long the headset may sleep, or show something else, before the session is given up;
        rests do not count.
    walking_speed_m_s
        Total speed of walking by thumb-stick.
    turning_deg_s
        Rate at which the other thumb-stick turns.
    snap_turn_deg
        By which the other thumb-stick turns at once; None turns smoothly.
    teleport_m
        How far a push of the first thumb-stick goes at once; None walks.
    """

    application: str = "vrcomfort"
    image_size_px: tuple[int, int] | None = None
    refresh_hz: float | None = None
    eye_height_m: float = 1.6
    depth: DepthMode = "scene"
    api_layers: tuple[str, ...] = ()
    image_timeout_s: float = 5.0
    patience_s: float = 600.0
    walking_speed_m_s: float = WALKING_SPEED_M_S
    turning_deg_s: float = TURNING_DEG_S
    snap_turn_deg: float | None = None
    teleport_m: float | None = None
