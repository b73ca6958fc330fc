"""Where head and eyes are, frame by frame; the last known place while tracking is lost."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import xr

from vrcomfort.frame import HeadsetEvent
from vrcomfort.geometry import Fov, Pose, View
from vrcomfort.headset.openxr.convert import view_from_xr
from vrcomfort.headset.openxr.instance import EYES, STEREO
from vrcomfort.headset.openxr.native import native
from vrcomfort.headset.openxr.spaces import VALID, Stage

UNKNOWN = View(Pose(), Fov(-0.7, 0.7, 0.7, -0.7))


class Tracking:
    """Head and eyes in the stage.

    Parameters
    ----------
    session
        OpenXR's handle.
    stage
        Where they are measured.
    notify
        Called when tracking is lost and found.

    Attributes
    ----------
    head
        stage-from-head.
    views
        Left and right eye, stage-from-eye.
    xr_views
        The same as the runtime gave them.
    """

    def __init__(
        self, session: xr.Session, stage: Stage, notify: Callable[[HeadsetEvent], None]
    ) -> None:
        self._session, self._stage, self._notify = session, stage, notify
        self._known = True
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
        valid = state._view_state_flags & VALID == VALID  # the enum costs 10 µs
        known = head is not None and valid
        if head is not None and valid:
            left, right = views
            self.head, self.views = head, (view_from_xr(left), view_from_xr(right))
            self.xr_views, self._next_views = views, self.xr_views
        changed = known != self._known
        if changed:
            self._notify(HeadsetEvent("tracking_found" if known else "tracking_lost"))
        self._known = known
        return changed


def _two_views() -> Sequence[xr.View]:
    views: Sequence[xr.View] = (xr.View * EYES)(*(xr.View() for _ in range(EYES)))
    return views
