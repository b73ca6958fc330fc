"""Scenes as trials show them: from where, along which path, for how long."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from vrcomfort.settings import Name, Settings, Word
from vrcomfort.settings.camera_path import PathPoints


class View(Settings):
    """A scene from a place, along a path, or for a time of its own.

    Its `name` stands in `scenes`, in sequences and in the column `scene`, beside those of whole
    scenes.
    """

    name: Name
    """What trials call it."""
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
    exposure_s: Annotated[float, Field(ge=0.001, le=14_400)] | None = None
    """How long a trial shows it; without it, the protocol's `exposure_s`."""

    @property
    def carried(self) -> bool:
        """Return whether the participant is moved along a path, and does not walk."""
        return self.path is not None or self.points is not None
