"""`gaze`: the median of nine rays around the line of sight (Mantiuk et al. 2011, section 4)."""

from __future__ import annotations

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array, Pose
from vrcomfort.optics.focus import RAYS, gaze_tangents
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.nine_ray import NineRays
from vrcomfort.render.focus.rule import FocusInputs, FocusRule, Sight
from vrcomfort.render.focus.search import FocusSearch, Look
from vrcomfort.render.planned_pass import PlannedPass

NO_EYE_TRACKER = (
    'focus follows the gaze (method = "gaze"), and this headset has no eye tracker; use one that '
    'has, or write without_gaze = "nine_ray" under [conditions.focus]'
)


def plan(settings: Focus) -> PlannedPass:
    """Plan rays around the line of sight."""
    nine = settings.without_gaze == "nine_ray"
    instead = "nine rays ahead without one" if nine else "the session stops without one"
    reason = f"depth of field follows the gaze: {RAYS} rays, a texel each; needs an eye tracker"
    reason += f"; {instead}"
    return PlannedPass("focus", True, reason)


class GazeRays:
    """Rays around the line of sight, and their median.

    A blink (gaze not valid) keeps the target of before. Where there is none, at the first frame and
    after a cut, the ray straight ahead stands in until the tracker has the eyes.
    """

    MEAN, MEDIAN, KEEP = range(3)

    def __init__(self, inputs: FocusInputs) -> None:
        self._ahead = NineRays(inputs)
        self._settings = inputs.settings
        self._has_target = False
        self.fragment = self._ahead.fragment
        self.defines = {**self._ahead.defines, "GAZE": 1}
        self.constants = self._ahead.constants

    @property
    def triangles(self) -> int:
        """Return those of the last look."""
        return self._ahead.triangles

    def look(self, sight: Sight) -> Look:
        """Draw the rays around the line of sight, if there is one.

        Raises
        ------
        InputError
            Without an eye tracker, unless the settings say what else to do.
        """
        if sight.gaze is None:
            if self._settings.without_gaze == "stop":
                raise InputError(NO_EYE_TRACKER)
            return _estimated(self.MEAN, self._ahead.look(sight))
        tangents = self._around(sight.gaze.pose) if sight.gaze.valid else None
        cut = sight.discontinuity
        self._has_target = tangents is not None or (self._has_target and not cut)
        if tangents is None and self._has_target:
            return Look({"estimate": self.KEEP})
        if tangents is None:
            tangents = self._around(Pose())
        assert tangents is not None  # noqa: S101 - straight ahead is always within reach
        look = self._ahead.look_along(self._ahead.aimed(tangents), sight.world_from_head)
        return _estimated(self.MEDIAN, look)

    def _around(self, head_from_gaze: Pose) -> Array | None:
        return gaze_tangents(head_from_gaze, self._settings.gaze_radius_deg)


def _estimated(estimate: int, look: Look) -> Look:
    return look._replace(uniforms={**look.uniforms, "estimate": estimate})


def build(inputs: FocusInputs) -> FocusSearch:
    """Build the search by gaze."""
    return FocusSearch(inputs, GazeRays(inputs))


RULE = FocusRule("gaze", plan, build)
