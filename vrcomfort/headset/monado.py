"""A Monado runtime with a null compositor, fed with poses: OpenXR without a headset.

Poses sent are the poses that the runtime reports, so a recorded trace and a script of button
presses play through a real OpenXR runtime without a headset.

Use it for tests and rehearsals. Its timing means nothing: the null compositor runs at its own pace.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np

from vrcomfort.errors import InputError, RuntimeLostError
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
        """Send `state`, which the runtime reports from now on.

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


SERVICE = "monado-service"
READY_SOCKET = "monado_comp_ipc"
START_TIMEOUT_S = 60.0
STOP_TIMEOUT_S = 10.0


class Monado:
    """A Monado service of our own: own settings, own sockets, one process; a context manager.

    Inside the context the process's environment points OpenXR applications to it.

    Parameters
    ----------
    log
        Where the service's output goes; default: its own folder, which goes with it.
    sways
        Monado's own simulated head, which sways, in the place of one that follows a feed.

    Raises
    ------
    InputError
        If Monado is not installed, or does not start.
    """

    def __init__(self, log: Path | None = None, *, sways: bool = False) -> None:
        self._sways = sways
        self._service = find_service()
        self._folder = Path(tempfile.mkdtemp(prefix="monado-"))
        self._log = log or self._folder / "log.txt"
        self._port = _free_port()
        self._process: subprocess.Popen[bytes] | None = None
        self._environment = client_environment(self._folder)

    @property
    def pid(self) -> int:
        """Return the process id of the running service."""
        if self._process is None:
            raise InputError("the Monado service is not running; start it first")
        return self._process.pid

    @property
    def environment(self) -> dict[str, str]:
        """Return the variables that lead an OpenXR application to this service."""
        return dict(self._environment)

    def start(self) -> None:
        """Start the service and wait until it takes applications and feeds."""
        self._write_settings()
        environment = {
            **os.environ,
            **self._environment,
            "XDG_CONFIG_HOME": str(self._folder),
            **(
                {"SIMULATED_ENABLE": "1"} if self._sways else {"P_OVERRIDE_ACTIVE_CONFIG": "remote"}
            ),
            "XRT_COMPOSITOR_NULL": "1",
            "XRT_NO_STDIN": "1",
        }
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(  # noqa: S603 - found on PATH
                [self._service],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        self._wait_until_ready()

    def feed(self) -> RemoteFeed:
        """Connect to the driver that plays the headset and the controllers."""
        return RemoteFeed(self._port)

    def kill(self) -> None:
        """End the service as a crash would: at once, without a word to its applications."""
        self._end(signal.SIGKILL)

    def stop(self) -> None:
        """End the service and remove its folder."""
        self._end(signal.SIGTERM)
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        self._outer = active_environment(self._environment)
        self._outer.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        self._outer.__exit__(None, None, None)
        self.stop()

    def _write_settings(self) -> None:
        if self._sways:
            return
        settings = self._folder / "monado" / "config_v0.json"
        settings.parent.mkdir(exist_ok=True)
        remote = {"version": 0, "port": self._port, "view_count": 2}
        settings.write_text(json.dumps({"active": "remote", "remote": remote}))

    def _wait_until_ready(self) -> None:
        deadline = time.monotonic() + START_TIMEOUT_S
        while not _listens(self._folder / READY_SOCKET):
            if self._process is None or self._process.poll() is not None:
                raise InputError(f"the Monado service ended while starting: {self._last_words()}")
            if time.monotonic() > deadline:
                raise InputError(f"the Monado service did not get ready: {self._last_words()}")
            time.sleep(0.05)

    def _last_words(self) -> str:
        lines = self._log.read_text(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"

    def _end(self, number: signal.Signals) -> None:
        if self._process is None:
            return
        self._process.send_signal(number)
        try:
            self._process.wait(STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process = None


def find_service() -> str:
    """Return the path of the Monado service.

    Raises
    ------
    InputError
        If there is none.
    """
    service = shutil.which(SERVICE)
    if service is None:
        raise InputError(
            f"{SERVICE} is not installed here; install Monado, or run the same command "
            "through scripts/in_runtime.sh of the repository, which makes a system that has it"
        )
    return service


def client_environment(runtime_folder: Path) -> dict[str, str]:
    """Return the environment in which an OpenXR application finds the service in this folder."""
    prefix = Path(find_service()).resolve().parent.parent
    return {
        "XR_RUNTIME_JSON": str(prefix / "share/openxr/1/openxr_monado.json"),
        "XDG_RUNTIME_DIR": str(runtime_folder),
    }


@contextmanager
def active_environment(variables: dict[str, str]) -> Iterator[None]:
    """Set environment variables of this process, and restore them afterwards."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _listens(path: Path) -> bool:
    """Return whether the socket takes connections; its file appears too early."""
    with socket.socket(socket.AF_UNIX) as probe:
        return probe.connect_ex(str(path)) == 0
