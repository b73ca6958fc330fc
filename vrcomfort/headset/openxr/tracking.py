"""Head and eyes frame by frame, in the stage and in the world."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import numpy as np
import xr

from vrcomfort.frame import HeadsetEvent
from vrcomfort.geometry import Fov, Pose, View, heading
from vrcomfort.headset.inputs import Inputs
from vrcomfort.headset.locomotion import Locomotion, floor_under, move_command
from vrcomfort.headset.openxr.connection import Connection
from vrcomfort.headset.openxr.instance import EYES, STEREO
from vrcomfort.headset.openxr.lifecycle import SpaceChange
from vrcomfort.headset.openxr.native import (
    native,
    pose_from_xr,
    pose_to_xr,
    raw_field,
    view_from_xr,
)
from vrcomfort.headset.openxr.spaces import VALID, Stage
from vrcomfort.scene.floors import Floors

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


class ParticipantPose:
    """Head and eyes in the stage, and the stage in the world.

    Parameters
    ----------
    connection
        The session.
    locomotion
        Where the stage stands in the world.
    notify
        Called when tracking is lost and found, and when the runtime moves a space.
    relocated
        Called with new-stage-from-old-stage when the stage's origin has moved.

    Attributes
    ----------
    tracking
        Head and eyes in the stage.
    snap_turned
        Whether the last `move` turned the avatar at once.
    """

    def __init__(
        self,
        connection: Connection,
        locomotion: Locomotion,
        notify: Callable[[HeadsetEvent], None],
        relocated: Callable[[Pose], None],
    ) -> None:
        self._xr, self._notify, self._relocated = connection, notify, relocated
        self._locomotion = locomotion
        self.snap_turned = False
        self.tracking = Tracking(connection.session, connection.stage, notify)

    @property
    def avatar(self) -> Pose:
        """Return world-from-stage."""
        return self._locomotion.avatar

    def send(self, spawn: Pose, floors: Floors, *, on_foot: bool = True) -> None:
        """Choose where the participant will be with the next frame, and where they walk there."""
        self._locomotion.send(spawn=spawn, floors=floors, on_foot=on_foot)

    def update(self, time_ns: int) -> bool:
        """Locate the participant at `time_ns`; return True where poses jump."""
        before = self.tracking.head
        jumps = self.tracking.update(time_ns)
        for change in self._xr.lifecycle.take_space_changes(time_ns):
            jumps |= self._follow(change, before)
        return jumps

    def _follow(self, change: SpaceChange, before: Pose) -> bool:
        """Take a change of the runtime's spaces; return True where the stage is of that space."""
        stage = self._xr.stage
        if change.space != stage.kind:
            words = f"{change.space} by the runtime: not in use, nothing moves"
            self._notify(HeadsetEvent("space_changed", words))
            return False
        self._notify(HeadsetEvent("recentered", f"{change.space} by the runtime"))
        if change.old_from_new is not None:
            moved = stage.origin.inverse() @ _level(change.old_from_new).inverse() @ stage.origin
        else:  # nobody is elsewhere within one frame: what has moved is the origin
            moved = floor_under(self.tracking.head) @ floor_under(before).inverse()
        if not self.tracking.valid:
            self.tracking.relocate(moved)
        self._relocate(moved)
        return True

    def move(self, inputs: Inputs, passed_s: float, *, in_scene: bool) -> bool:
        """Go to a new place, or walk; return True where poses jump.

        Walk in a scene only, for nobody walks blindly.
        """
        self.snap_turned = False
        if not self.tracking.found:
            return False  # nobody is anywhere yet
        if self._locomotion.arrive(self.tracking.head):
            return True
        if in_scene:
            head = self.tracking.head
            self.snap_turned = self._locomotion.step(head, move_command(inputs), passed_s)
            return self._locomotion.teleported
        return False

    def recenter(self) -> None:
        """Make the floor under the head the stage's origin, and its heading straight ahead."""
        origin = floor_under(self.tracking.head)
        self._xr.stage.recenter(self.tracking.head)
        self._relocate(origin.inverse())

    def _relocate(self, new_from_old: Pose) -> None:
        """Leave the participant where they are in the world, and the panels where they stand."""
        self._locomotion.relocate(new_from_old)
        self._relocated(new_from_old)


def _level(pose: Pose) -> Pose:
    """Return a pose of the same place and heading: the world stays upright."""
    return Pose(pose.position, heading(pose))
