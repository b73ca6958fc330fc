"""`nine_ray`: a ray ahead and eight around it, less outliers (Carnegie & Rhee 2015, p. 36)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from vrcomfort.geometry import Array, Pose
from vrcomfort.optics.focus import RAYS, ray_tangents
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.narrow_rays import NarrowRays, ray_lengths, ray_projections
from vrcomfort.render.focus.rule import FocusInputs, FocusRule, Sight
from vrcomfort.render.focus.search import FocusSearch, Look
from vrcomfort.render.planned_pass import PlannedPass


def plan(_: Focus) -> PlannedPass:
    """Plan nine rays."""
    reason = f"depth of field follows what is in front of the head: {RAYS} rays, a texel each"
    return PlannedPass("focus", True, reason)


class Aim(NamedTuple):
    """Nine rays.

    Parameters
    ----------
    clips_from_head
        (9, 4, 4) of :func:`ray_projections`.
    lengths
        (9,) metres of each ray's distance per metre along the head's forward axis.
    """

    clips_from_head: Array
    lengths: Array


class NineRays:
    """Rays ahead of the head, and the mean of those that are no outliers."""

    fragment = "focus/focus.frag"

    def __init__(self, inputs: FocusInputs) -> None:
        settings = inputs.settings
        self._narrow = NarrowRays(inputs)
        self._near_m, self._along_ray = inputs.near_m, inputs.along_ray
        self._ahead = self.aimed(ray_tangents(settings.ring_deg))
        dioptres = settings.mean == "dioptres"
        self.defines: dict[str, int] = {
            "RAYS": RAYS,
            **({"MEAN_DIOPTRES": 1} if dioptres else {}),
            **({"ALONG_RAY": 1} if inputs.along_ray else {}),
        }
        floor = settings.outlier_floor_dioptre if dioptres else settings.outlier_floor_fraction
        self.constants: dict[str, Any] = {
            "depth": 2,
            "near_m": inputs.near_m,
            "infinity_m": settings.infinity_m,
            "outlier_mad": settings.outlier_mad,
            "outlier_floor": floor,
        }

    @property
    def triangles(self) -> int:
        """Return those of the last look."""
        return self._narrow.triangles

    def look(self, sight: Sight) -> Look:
        """Draw the rays ahead."""
        return self.look_along(self._ahead, sight.world_from_head)

    def aimed(self, tangents: Array) -> Aim:
        """Return nine rays with these (9, 2) tangents (right, up)."""
        lengths = ray_lengths(tangents) if self._along_ray else np.ones(RAYS)
        return Aim(ray_projections(tangents, self._near_m), lengths)

    def look_along(self, aim: Aim, world_from_head: Pose) -> Look:
        """Draw nine rays."""
        self._narrow.draw(aim.clips_from_head, world_from_head)
        uniforms = {"ray_lengths": aim.lengths.tolist()} if self._along_ray else {}
        return Look(uniforms, self._narrow.image, aim.lengths)


def build(inputs: FocusInputs) -> FocusSearch:
    """Build the search by rays ahead."""
    return FocusSearch(inputs, NineRays(inputs))


RULE = FocusRule("nine_ray", plan, build)
