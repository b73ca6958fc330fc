"""`nine_ray`: a ray ahead and eight around it, less outliers (Carnegie & Rhee 2015, p. 36)."""

from __future__ import annotations

from typing import Any

from vrcomfort.optics.focus import RAYS, ray_tangents
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.narrow_rays import NarrowRays, ray_projections
from vrcomfort.render.focus.rule import FocusInputs, FocusRule, Sight
from vrcomfort.render.focus.search import FocusSearch, Look
from vrcomfort.render.planned_pass import PlannedPass


def plan(_: Focus) -> PlannedPass:
    """Plan nine rays."""
    return PlannedPass("focus", True, "depth of field follows what is in front of the head")


class NineRays:
    """Rays ahead of the head, and the mean of those that are no outliers."""

    fragment = "focus/focus.frag"

    def __init__(self, inputs: FocusInputs) -> None:
        settings = inputs.settings
        self.narrow = NarrowRays(inputs)
        self._ahead = ray_projections(ray_tangents(settings.ring_deg), inputs.near_m)
        dioptres = settings.mean == "dioptres"
        self.defines: dict[str, int] = {"RAYS": RAYS, **({"MEAN_DIOPTRES": 1} if dioptres else {})}
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
        return self.narrow.triangles

    def look(self, sight: Sight) -> Look:
        """Draw the rays ahead."""
        self.narrow.draw(self._ahead, sight.world_from_head)
        return Look({}, self.narrow.image)


def build(inputs: FocusInputs) -> FocusSearch:
    """Build the search by rays ahead."""
    return FocusSearch(inputs, NineRays(inputs))


RULE = FocusRule("nine_ray", plan, build)
