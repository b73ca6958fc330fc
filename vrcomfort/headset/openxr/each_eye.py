"""The gaze of each eye, through XR_FB_eye_tracking_social.

Of the extensions that pyopenxr knows it is the only one on a PC that tells the eyes apart. None
tells the size of the pupils.
"""

from __future__ import annotations

import ctypes
from contextlib import suppress

import xr

from vrcomfort.geometry import EyeGaze, Pose, normalize, turn_to
from vrcomfort.headset.inputs import SeenGaze
from vrcomfort.headset.openxr.convert import pose_from_xr
from vrcomfort.headset.openxr.native import native_extension, watched

EXTENSION = xr.FB_EYE_TRACKING_SOCIAL_EXTENSION_NAME

Eyes = tuple[EyeGaze, EyeGaze]
"""The left and the right one."""


class EachEye:
    """The eye tracker of a session.

    Parameters
    ----------
    instance, session
        OpenXR's handles; the extension is switched on.
    """

    def __init__(self, instance: xr.Instance, session: xr.Session) -> None:
        self._tracker = watched(xr.create_eye_tracker_fb, session, xr.EyeTrackerCreateInfoFB())
        self._get = native_extension(instance, "xrGetEyeGazesFB")
        self._info, self._found = xr.EyeGazesInfoFB(), xr.EyeGazesFB()  # made once: hot

    def read(self, space: xr.Space, time_ns: int) -> tuple[Eyes, int]:
        """Return both eyes in a space, and when the tracker saw them (0: it does not say)."""
        self._info.base_space, self._info.time = space, time_ns
        self._get(self._tracker, ctypes.byref(self._info), ctypes.byref(self._found))
        return eyes_of(self._found), int(self._found.time)

    def release(self) -> None:
        """Destroy the tracker."""
        with suppress(xr.exception.ResultException):
            watched(xr.destroy_eye_tracker_fb, self._tracker)


def eyes_of(found: xr.EyeGazesFB) -> Eyes:
    """Return what a tracker has found."""
    left, right = (
        EyeGaze(pose_from_xr(eye.gaze_pose)) if eye.is_valid else EyeGaze(Pose(), valid=False)
        for eye in found.gaze
    )
    return left, right


def both(eyes: Eyes, time_ns: int) -> SeenGaze:
    """Return where both eyes look: from between them, along the mean of their directions.

    For runtimes that tell of each eye alone. It is valid where both eyes are seen.
    """
    left, right = eyes
    if not (left.valid and right.valid):
        return SeenGaze(Pose(), valid=False, eyes=eyes, time_ns=time_ns)
    between = (left.pose.position + right.pose.position) / 2
    along = normalize(left.pose.forward + right.pose.forward)
    return SeenGaze(Pose(between, turn_to(along)), eyes=eyes, time_ns=time_ns)
