"""Where head and eyes are, frame by frame; the last known place while tracking is lost."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import numpy as np
import xr

from vrcomfort.frame import HeadsetEvent
from vrcomfort.geometry import Fov, Pose, View
from vrcomfort.headset.openxr.convert import pose_from_xr, pose_to_xr, view_from_xr
from vrcomfort.headset.openxr.instance import EYES, STEREO
from vrcomfort.headset.openxr.native import native, raw_field
from vrcomfort.headset.openxr.spaces import VALID, Stage

UNKNOWN = View(Pose(), Fov(-0.7, 0.7, 0.7, -0.7))
VIEW_STATE_FLAGS = raw_field(xr.ViewState, "view_state_flags")
VIEWS_TRACKED = VALID | int(
    xr.ViewStateFlags.ORIENTATION_TRACKED_BIT | xr.ViewStateFlags.POSITION_TRACKED_BIT
)


class Tracking:
    """Head and eyes in the stage.

    Parameters
    ----------
    session
        OpenXR's handle.
    stage
        Where they are measured.
    notify
        Called when the head is first found, and when tracking is lost and found.

    Attributes
    ----------
    head
        stage-from-head.
    views
        Left and right eye, stage-from-eye.
    xr_views
        The same as the runtime gave them.
    found
        Whether head and eyes have ever been known: before, all poses mean nothing.
    valid
        Whether they are known in this frame; else they are the last known.
    tracked
        Whether they are seen by sensors in this frame; else the runtime infers them.
    ipd_m
        The distance between the eyes where they were first found; None before.
    """

    def __init__(
        self, session: xr.Session, stage: Stage, notify: Callable[[HeadsetEvent], None]
    ) -> None:
        self._session, self._stage, self._notify = session, stage, notify
        self.found = self.tracked = False
        self.valid = True  # until told otherwise: the first frame without a pose is an event
        self.ipd_m: float | None = None
        self._where = xr.ViewLocateInfo(STEREO)
        self._locate = native("xrLocateViews")
        self._state, self._count = xr.ViewState(), ctypes.c_uint32()
        self.head = Pose()
        self.views = UNKNOWN, UNKNOWN
        self.xr_views: Sequence[xr.View] = _two_views()
        self._next_views: Sequence[xr.View] = _two_views()

    def update(self, time_ns: int) -> bool:
        """Locate head and eyes at `time_ns`; return True where poses jump (tracking came back)."""
        head = self._stage.locate_head(time_ns)
        self._where.display_time, self._where.space = time_ns, self._stage.space
        state, count, views = self._state, self._count, self._next_views
        self._locate(self._session, self._where, state, EYES, count, views)
        flags = VIEW_STATE_FLAGS(state)
        known = head is not None and flags & VALID == VALID
        self.tracked = known and self._stage.head_tracked and flags & VIEWS_TRACKED == VIEWS_TRACKED
        if head is not None and known:
            left, right = views
            self.head, self.views = head, (view_from_xr(left), view_from_xr(right))
            self.xr_views, self._next_views = views, self.xr_views
        return self._take_note(known)

    def relocate(self, new_from_old: Pose) -> None:
        """Take note that the stage's origin has moved under poses that are not measured anew."""
        self.head = new_from_old @ self.head
        left, right = (View(new_from_old @ view.pose, view.fov) for view in self.views)
        self.views = left, right
        for view in self.xr_views:
            view.pose = pose_to_xr(new_from_old @ pose_from_xr(view.pose))

    def _take_note(self, known: bool) -> bool:
        before, self.valid = self.valid, known
        if known and not self.found:
            self.found = True
            left, right = (view.pose.position for view in self.views)
            self.ipd_m = round(float(np.linalg.norm(right - left)), 6)
            self._notify(HeadsetEvent("head_found"))
            return True
        if known != before:
            self._notify(HeadsetEvent("tracking_found" if known else "tracking_lost"))
        return known != before


def _two_views() -> Sequence[xr.View]:
    views: Sequence[xr.View] = (xr.View * EYES)(*(xr.View() for _ in range(EYES)))
    return views
