"""Packets for Monado's "remote" driver: a head, two eyes and two hands that follow a TCP feed.

Poses sent are the poses that the runtime reports, so a recorded trace and a script of button
presses play through a real OpenXR runtime without a headset.
"""

from __future__ import annotations

import socket
import struct
import time
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from vrcomfort.errors import RuntimeLostError
from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.geometry import Fov, Pose, View

HEADER = b"mndrmt3\0"
"""Layout of Monado 25 (``r_interface.h``): little-endian, 376 bytes."""

CONNECT_TIMEOUT_S = 10.0
HALF_FOV = Fov(-0.7, 0.7, 0.7, -0.7)


def _default_views() -> tuple[View, View]:
    left, right = (Pose(np.array([x, 0.0, 0.0])) for x in (-MEAN_IPD_M / 2, MEAN_IPD_M / 2))
    return View(left, HALF_FOV), View(right, HALF_FOV)


@dataclass(frozen=True)
class RemoteHand:
    """One controller (a Valve Index controller to the application).

    Parameters
    ----------
    pose
        stage-from-hand: the aim ray leaves along its −Z.
    thumbstick
        (right, forward), each −1 to 1.
    """

    pose: Pose
    trigger: bool = False
    a: bool = False
    b: bool = False
    thumbstick: tuple[float, float] = (0.0, 0.0)
    active: bool = True


@dataclass(frozen=True)
class RemoteState:
    """Everything the driver is told in one packet.

    Parameters
    ----------
    head
        stage-from-head.
    eyes
        Left and right, head-from-eye.
    """

    head: Pose
    eyes: tuple[View, View] = field(default_factory=_default_views)
    left: RemoteHand = field(default_factory=lambda: RemoteHand(Pose(np.array([-0.2, 1.2, -0.3]))))
    right: RemoteHand = field(default_factory=lambda: RemoteHand(Pose(np.array([0.2, 1.2, -0.3]))))

    def packet(self) -> bytes:
        """Return the 376 bytes of this state."""
        return b"".join(
            [
                HEADER,
                *map(_view_bytes, self.eyes),
                _pose_bytes(self.head),
                bytes([1, 0, 0, 0]),  # the views above count, not the driver's own
                _hand_bytes(self.left),
                _hand_bytes(self.right),
            ]
        )


def _pose_bytes(pose: Pose) -> bytes:
    return struct.pack("<7f", *pose.orientation, *pose.position)


def _view_bytes(view: View) -> bytes:
    fov = view.fov
    angles = struct.pack("<4f", fov.left, fov.right, fov.up, fov.down)
    return angles + _pose_bytes(view.pose) + bytes(4)


def _hand_bytes(hand: RemoteHand) -> bytes:
    velocities_and_curl = bytes(11 * 4)
    # trigger, squeeze, squeeze force, thumb-stick x and y, track-pad force, x and y
    analog = struct.pack("<8f", hand.trigger, 0, 0, *hand.thumbstick, 0, 0, 0)
    # hand tracking, active, then click and touch of system, a, b, trigger, thumb-stick
    pairs = [flag for click in (False, hand.a, hand.b, hand.trigger, False) for flag in (click, 0)]
    flags = bytes([0, hand.active, *pairs, 0, 0, 0, 0])
    return _pose_bytes(hand.pose) + velocities_and_curl + analog + flags


class RemoteFeed:
    """The connection to the driver; a context manager.

    Parameters
    ----------
    port
        Where the driver of this machine listens.
    """

    def __init__(self, port: int) -> None:
        self._socket = _connect(port)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, state: RemoteState) -> None:
        """Make `state` what the runtime reports from now on.

        Raises
        ------
        RuntimeLostError
            If the driver is gone.
        """
        try:
            self._socket.sendall(state.packet())
        except OSError as error:
            raise RuntimeLostError(
                f"the Monado runtime takes no more head poses ({error.strerror}); what was "
                "recorded up to here is kept: run with --resume"
            ) from error

    def close(self) -> None:
        """Close the connection; the driver keeps the last state."""
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _connect(port: int) -> socket.socket:
    """Connect; the driver serves one feed at a time and needs a moment between two."""
    deadline = time.monotonic() + CONNECT_TIMEOUT_S
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=CONNECT_TIMEOUT_S)
        except ConnectionRefusedError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.05)
