"""Where the participant is: in the stage, as they are tracked, and in the world, as they walk."""

from __future__ import annotations

from collections.abc import Callable

from vrcomfort.frame import HeadsetEvent
from vrcomfort.geometry import Pose, heading
from vrcomfort.headset.inputs import Inputs
from vrcomfort.headset.locomotion import Locomotion, floor_under, wish_of
from vrcomfort.headset.openxr.connection import Connection
from vrcomfort.headset.openxr.lifecycle import SpaceChange
from vrcomfort.headset.openxr.tracking import Tracking
from vrcomfort.scene.floors import Floors


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
            self.snap_turned = self._locomotion.step(head, wish_of(inputs), passed_s)
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
