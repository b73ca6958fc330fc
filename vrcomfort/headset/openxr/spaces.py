"""Where poses are measured: the tracked space, the head in it, and recentering."""

from __future__ import annotations

import numpy as np
import xr

from vrcomfort.geometry import Pose
from vrcomfort.headset.locomotion import floor_under
from vrcomfort.headset.openxr.native import native, pose_from_xr, pose_to_xr, raw_field, watched

Space = xr.ReferenceSpaceType
PREFERRED = (Space.STAGE, Space.LOCAL_FLOOR, Space.LOCAL)
"""The floor as origin where there is one; LOCAL starts at eye height."""

HEAD_TRACKED = int(
    xr.SpaceLocationFlags.ORIENTATION_TRACKED_BIT | xr.SpaceLocationFlags.POSITION_TRACKED_BIT
)
LOCATION_FLAGS = raw_field(xr.SpaceLocation, "location_flags")
VALID = int(xr.SpaceLocationFlags.ORIENTATION_VALID_BIT | xr.SpaceLocationFlags.POSITION_VALID_BIT)


class Stage:
    """The tracked space, and the head in it.

    Parameters
    ----------
    session
        OpenXR's handle.
    eye_height_m
        Used where the runtime does not know the floor.

    Attributes
    ----------
    kind
        Which of the runtime's spaces it is, as ``stage``, ``local_floor`` or ``local``.
    space
        The handle that layers and locations refer to.
    origin
        Of the stage, in that space of the runtime.
    head_tracked
        Whether sensors saw the head when it was last located.
    """

    def __init__(self, session: xr.Session, eye_height_m: float) -> None:
        self._session = session
        offered = {Space(each) for each in watched(xr.enumerate_reference_spaces, session)}
        self._type = next(each for each in PREFERRED if each in offered)
        self.kind = self._type.name.lower()
        floor_m = -eye_height_m if self._type is Space.LOCAL else 0.0
        self.origin = Pose(np.array([0.0, floor_m, 0.0]))
        self.space = self._reference(self._type, self.origin)
        self._head = self._reference(Space.VIEW, Pose())
        self._locate = native("xrLocateSpace")
        self._location = xr.SpaceLocation()
        self.head_tracked = False

    def locate(self, space: xr.Space, time_ns: int) -> Pose | None:
        """Return stage-from-`space`, or None where it is not known."""
        location = self._location
        self._locate(space, self.space, time_ns, location)
        if LOCATION_FLAGS(location) & VALID != VALID:
            return None
        return pose_from_xr(location.pose)

    def locate_head(self, time_ns: int) -> Pose | None:
        """Return stage-from-head, or None where tracking is lost."""
        head = self.locate(self._head, time_ns)
        self.head_tracked = LOCATION_FLAGS(self._location) & HEAD_TRACKED == HEAD_TRACKED
        return head

    def room_m(self) -> tuple[float, float] | None:
        """Return the width and depth in which people may walk; None where it is not told."""
        try:
            room = watched(xr.get_reference_space_bounds_rect, self._session, Space.STAGE)
        except (
            xr.exception.SpaceBoundsUnavailable,  # nobody has drawn a boundary
            xr.exception.ReferenceSpaceUnsupportedError,
        ):
            return None
        size_m = float(room.width), float(room.height)
        return size_m if min(size_m) > 0 else None

    def recenter(self, head: Pose) -> None:
        """Move the origin to the floor under `head`, and turn −Z to where it looks."""
        self.origin = self.origin @ floor_under(head)
        watched(xr.destroy_space, self.space)
        self.space = self._reference(self._type, self.origin)

    def _reference(self, kind: xr.ReferenceSpaceType, origin: Pose) -> xr.Space:
        return watched(
            xr.create_reference_space,
            self._session,
            xr.ReferenceSpaceCreateInfo(kind, pose_to_xr(origin)),
        )
