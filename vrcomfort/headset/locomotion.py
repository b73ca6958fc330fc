"""Walking by thumb-stick or keys, as in Carnegie & Rhee (2015).

Where one looks and where one walks are independent: feet follow the torso, which the mouse or the
right thumb-stick turns; the head turns freely on it. Nobody jumps, and nobody is faster than the
walking speed. See `floors` for slopes and steps.

What a participant does with their real head and body is never touched: locomotion moves the stage
in the world, and they move in the stage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrcomfort.geometry import Array, Pose, axis_angle, heading, rotate
from vrcomfort.headset.inputs import Inputs
from vrcomfort.scene.floors import STEP_M, Floors

WALKING_SPEED_M_S = 1.4
"""Carnegie & Rhee (2015); a protocol may say otherwise."""

TURNING_DEG_S = 60.0
"""Of the right thumb-stick; not in the paper, where a mouse turns the torso. A protocol may say
otherwise."""

DEAD_ZONE = 0.25
"""Dead zone of a thumb-stick around its middle. Beyond, speed is always the same."""

LONGEST_S = 0.1
"""Longest step of one frame: a hiccup is no leap."""


@dataclass(frozen=True)
class MoveCommand:
    """The participant's locomotion input.

    Parameters
    ----------
    right, forward
        Where to walk, seen from the torso; only the direction counts.
    turn_rad
        How far to turn the torso to the left, now.
    turn_rate
        The same as a share of the turning speed, −1 to 1.
    stick_at_rest
        The stick that turns is in the middle, not only below where it begins to turn.
    """

    right: float = 0.0
    forward: float = 0.0
    turn_rad: float = 0.0
    turn_rate: float = 0.0
    stick_at_rest: bool = True

    def without_turn(self) -> MoveCommand:
        """Return the same walk without turning."""
        return MoveCommand(self.right, self.forward, stick_at_rest=self.stick_at_rest)


class Locomotion:
    """Keeps where the stage stands in the world.

    Parameters
    ----------
    speed_m_s
        Total speed, along slopes and steps too.
    turning_deg_s
        Rate at which the thumb-stick turns.
    snap_turn_deg
        The thumb-stick turns by this angle at once, each time that it leaves its middle; None
        turns smoothly.
    teleport_m
        A push to walk goes so far at once, and no further until the next; None walks on.

    Attributes
    ----------
    avatar
        world-from-stage.
    teleported
        Whether the last `step` was a teleport: where the participant was before means nothing.
    """

    def __init__(
        self,
        speed_m_s: float = WALKING_SPEED_M_S,
        *,
        turning_deg_s: float = TURNING_DEG_S,
        snap_turn_deg: float | None = None,
        teleport_m: float | None = None,
    ) -> None:
        self._speed_m_s, self._turning_rad_s = speed_m_s, np.radians(turning_deg_s)
        self._teleport_m = teleport_m
        self._pushed, self._on_foot = True, True
        self.teleported = False
        self._snap_turn_rad = None if snap_turn_deg is None else np.radians(snap_turn_deg)
        # Who comes with the stick held aside does not turn by that.
        self._stick_aside = True
        self._floors = Floors()
        self._spawn: Pose | None = None
        self._torso_rad = 0.0
        self.avatar = Pose()

    def send(self, *, spawn: Pose, floors: Floors, on_foot: bool = True) -> None:
        """Choose where the participant will `arrive`, and on which floors they walk there.

        Parameters
        ----------
        on_foot
            False where controls neither move nor turn them.
        """
        self._spawn, self._floors, self._on_foot = spawn, floors, on_foot

    def arrive(self, head: Pose) -> bool:
        """Put the floor point below `head` (stage-from-head) and its heading where they were sent.

        Returns
        -------
        bool
            False where they have been since, or were sent nowhere.
        """
        spawn, self._spawn = self._spawn, None
        if spawn is None:
            return False
        self._torso_rad = _yaw_rad(spawn)
        self._stick_aside = self._pushed = True
        self.avatar = spawn @ floor_under(head).inverse()
        return True

    def relocate(self, new_from_old: Pose) -> None:
        """Follow a move of the stage's origin, without moving the participant in the world."""
        self.avatar = self.avatar @ new_from_old.inverse()

    def step(self, head: Pose, command: MoveCommand, duration_s: float) -> bool:
        """Walk and turn for one frame.

        Who leans or steps beside the floor walks as if from the nearest point on it, and so
        never gets further away.

        Returns
        -------
        bool
            True where the stick has turned the stage at once.
        """
        self.teleported = False
        if not self._on_foot:
            return False
        seconds = min(duration_s, LONGEST_S)
        snap_rad = self._snap_rad(command)
        smooth_rad = command.turn_rate * self._turning_rad_s * seconds
        stick_rad = smooth_rad if self._snap_turn_rad is None else snap_rad
        self._turn(head, command.turn_rad + stick_rad)
        length = np.hypot(command.right, command.forward)
        walk_m = self._way_m(seconds, pushed=length > 1e-9)
        if walk_m:
            wanted = np.array([command.right, command.forward]) / length
            self._walk(head, self._world_from_torso(wanted), walk_m)
        return snap_rad != 0

    def _way_m(self, seconds: float, *, pushed: bool) -> float:
        """Return how far a push to walk leads in this frame."""
        before, self._pushed = self._pushed, pushed
        if self._teleport_m is None:
            return self._speed_m_s * seconds if pushed else 0.0
        self.teleported = pushed and not before
        return self._teleport_m if self.teleported else 0.0

    def _snap_rad(self, command: MoveCommand) -> float:
        """Return the snap turn to the left that begins now, or 0."""
        before, pushed = self._stick_aside, command.turn_rate != 0
        # A stick that trembles where it begins to turn is pushed once.
        self._stick_aside = pushed or (before and not command.stick_at_rest)
        if self._snap_turn_rad is None or before or not pushed:
            return 0.0
        return float(np.copysign(self._snap_turn_rad, command.turn_rate))

    def _turn(self, head: Pose, angle_rad: float) -> None:
        """Turn the stage about the place where the participant stands."""
        if angle_rad == 0:
            return
        self._torso_rad += angle_rad
        feet = _feet(self.avatar, head)
        turn = Pose(orientation=axis_angle([0.0, 1.0, 0.0], angle_rad))
        self.avatar = Pose(feet) @ turn @ Pose(-feet) @ self.avatar

    def _walk(self, head: Pose, direction_xz: Array, length_m: float) -> None:
        feet = _feet(self.avatar, head)
        start = self._floors.settle(feet)
        # Real steps on a slope have left the stage at the old height: walking climbs to the new.
        start[1] += np.clip(feet[1] - start[1], -STEP_M, STEP_M)
        move = self._floors.walk(start, direction_xz, length_m) - start
        self.avatar = Pose(self.avatar.position + move, self.avatar.orientation)

    def _world_from_torso(self, right_forward: Array) -> Array:
        """Return the (2,) direction x, z of a (right, forward) seen from the torso."""
        right, forward = right_forward
        sine, cosine = np.sin(self._torso_rad), np.cos(self._torso_rad)
        return np.array([right * cosine - forward * sine, -right * sine - forward * cosine])


def move_command(inputs: Inputs) -> MoveCommand:
    """Return the command of thumb-sticks, keys and mouse: left to walk, right to turn."""
    keys, stick = inputs.keys, inputs.left.thumbstick
    right, forward = stick if np.hypot(*stick) > DEAD_ZONE else (0.0, 0.0)
    turn = inputs.right.thumbstick[0]
    return MoveCommand(
        right=right + keys.walk[0],
        forward=forward + keys.walk[1],
        turn_rad=keys.turn_rad,
        turn_rate=-turn if abs(turn) > DEAD_ZONE else 0.0,
        stick_at_rest=abs(turn) < DEAD_ZONE / 2,
    )


def floor_under(head: Pose) -> Pose:
    """Return the floor point below `head`, turned to its heading."""
    x, _, z = head.position
    return Pose(np.array([x, 0.0, z]), heading(head))


def _feet(avatar: Pose, head: Pose) -> Array:
    """Return the floor point below the head, in the world."""
    x, _, z = head.position
    feet: Array = avatar.position + rotate(avatar.orientation, [x, 0.0, z])
    return feet


def _yaw_rad(pose: Pose) -> float:
    _, y, _, w = heading(pose)
    return float(2.0 * np.arctan2(y, w))
