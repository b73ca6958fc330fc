"""The joints of both hands, where the runtime tracks them (``XR_EXT_hand_tracking``)."""

from __future__ import annotations

import ctypes
from contextlib import suppress

import numpy as np
import xr

from vrcomfort.frame import HAND_JOINTS, HandJoints
from vrcomfort.headset.openxr.native import native_extension, watched

EXTENSION = xr.EXT_HAND_TRACKING_EXTENSION_NAME
LOCATION = np.dtype(
    [("flags", "u8"), ("orientation", "f4", 4), ("position", "f4", 3), ("radius", "f4")]
)
"""``XrHandJointLocationEXT``."""
KNOWN = int(xr.SpaceLocationFlags.POSITION_VALID_BIT)
SEEN = KNOWN | int(xr.SpaceLocationFlags.POSITION_TRACKED_BIT)


class HandTrackers:
    """The trackers of both hands of a session.

    Parameters
    ----------
    instance, session
        OpenXR's handles; the extension is switched on.
    """

    def __init__(self, instance: xr.Instance, session: xr.Session) -> None:
        self._trackers = [
            watched(xr.create_hand_tracker_ext, session, xr.HandTrackerCreateInfoEXT(hand=hand))
            for hand in (xr.HandEXT.LEFT, xr.HandEXT.RIGHT)
        ]
        self._locate = native_extension(instance, "xrLocateHandJointsEXT")
        # Looked up now: a runtime that is going away need not find a function any more.
        self._destroy = native_extension(instance, "xrDestroyHandTrackerEXT")
        self._info = xr.HandJointsLocateInfoEXT()  # all made once: hot
        self._joints = (xr.HandJointLocationEXT * len(HAND_JOINTS))()
        self._found = xr.HandJointLocationsEXT(joint_locations=self._joints)
        self._table = np.frombuffer(self._joints, LOCATION)

    def read(self, space: xr.Space, time_ns: int) -> tuple[HandJoints | None, HandJoints | None]:
        """Return the joints of the left and the right hand in a space."""
        self._info.base_space, self._info.time = space, time_ns
        left, right = map(self._read, self._trackers)
        return left, right

    def _read(self, tracker: xr.HandTrackerEXT) -> HandJoints | None:
        self._locate(tracker, ctypes.byref(self._info), ctypes.byref(self._found))
        if not self._found.is_active:
            return None
        flags = self._table["flags"]
        known = flags & KNOWN == KNOWN
        if not known.any():
            return None
        positions = np.where(known[:, None], self._table["position"], np.nan)
        return HandJoints(positions, tracked=bool((flags & SEEN == SEEN).all()))

    def release(self) -> None:
        """Destroy the trackers."""
        for tracker in self._trackers:
            with suppress(xr.exception.ResultException):
                self._destroy(tracker)
