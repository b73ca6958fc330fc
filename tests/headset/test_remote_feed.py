"""The feed of a rehearsal, and a driver that goes away."""

from __future__ import annotations

import socket
from itertools import repeat

import pytest

from vrcomfort.errors import RuntimeLostError
from vrcomfort.geometry import Pose
from vrcomfort.headset.monado import RemoteFeed, RemoteState


def test_a_driver_that_is_gone_is_a_runtime_lost() -> None:
    driver = socket.create_server(("127.0.0.1", 0))
    with driver, RemoteFeed(driver.getsockname()[1]) as feed:
        driver.accept()[0].close()
        states = repeat(RemoteState(Pose()), 1000)  # what is sent first finds room in a buffer
        with pytest.raises(RuntimeLostError, match=r"no more head poses.*--resume"):
            list(map(feed.send, states))
