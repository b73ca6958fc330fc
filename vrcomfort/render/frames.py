"""What goes into the renderer and what comes out: data only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import moderngl

from vrcomfort.frame import FocusSample, Frame, GazeHit, GpuTime, ImageHash
from vrcomfort.geometry import Gaze
from vrcomfort.render.camera import EyeCamera, PreviousCamera


def head_from_gaze(frame: Frame) -> Gaze | None:
    """Return a frame's gaze in the head's frame."""
    if frame.gaze is None:
        return None
    return Gaze(frame.head_pose.inverse() @ frame.gaze.pose, frame.gaze.valid)


class EyeImages(NamedTuple):
    """The textures of the eye that was just drawn; the next eye overwrites all but `encoded`.

    `pinhole` and `linear` are linear HDR light before and after the effects, `depth` is reverse-Z
    with `near_m`, `velocity` is px per frame, `encoded` is what the display gets. `previous` is
    where the eye counts as having been, None where motion blur needs none.
    """

    camera: EyeCamera
    previous: PreviousCamera | None
    pinhole: moderngl.Texture
    linear: moderngl.Texture
    depth: moderngl.Texture
    velocity: moderngl.Texture | None
    encoded: moderngl.Texture


@dataclass(frozen=True, eq=False)
class RenderedFrame:
    """Two images and what is known about them.

    Parameters
    ----------
    eyes
        Left and right, RGBA8, sRGB-encoded, rows from the bottom; valid until the next frame.
    focus_samples
        Those that arrived during this frame; each carries its own frame index.
    max_blur_px
        Largest radius (or half streak) that the condition allows at this image size; None where
        views through the lens have no limit.
    draws, triangles
        Draw calls for geometry, and triangles sent, of all views including shadow and focus.
    passes
        Names of the passes that ran.
    cpu_ms
        Wall time of this call.
    gpu_times
        Those of earlier frames that have arrived; None where the GPU is not timed.
    hashed
        Whether its images are being hashed.
    image_hashes
        Those of earlier frames that have arrived, where images are hashed.
    seeks_gaze
        Whether it is being found out what the gaze of this frame meets.
    gaze_hits
        Of earlier frames that have arrived, what their gaze meets.
    effect_centre
        What effects that are centred on the gaze are centred on: ``gaze``, ``held`` or ``head``;
        None where the condition has none.
    """

    eyes: tuple[moderngl.Texture, moderngl.Texture]
    focus_samples: tuple[FocusSample, ...]
    max_blur_px: float | None
    draws: int
    triangles: int
    passes: tuple[str, ...]
    cpu_ms: float
    gpu_times: tuple[GpuTime, ...] | None = None
    hashed: bool = False
    image_hashes: tuple[ImageHash, ...] = ()
    seeks_gaze: bool = False
    gaze_hits: tuple[GazeHit, ...] = ()
    effect_centre: str | None = None
