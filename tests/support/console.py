"""A console's server, and what speaks to it: requests, web sockets, and a session that waits."""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import parse_qs, urlsplit

from websockets.sync.client import ClientConnection, connect

from vrcomfort.console import ServerProcess

WAIT_S = 20.0


@dataclass
class Served:
    """A running server, and the sentences and addresses that the terminal got."""

    server: ServerProcess
    sentences: list[str] = field(default_factory=list)
    addresses: list[str] = field(default_factory=list)

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.server.port}"

    def token(self, number: int = -1) -> str:
        return parse_qs(urlsplit(self.addresses[number]).query)["token"][0]

    def get(self, path: str, **headers: str) -> tuple[int, dict[str, str], str]:
        """Return status, headers and text."""
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=WAIT_S)
        host = headers.pop("Host", f"127.0.0.1:{self.server.port}")
        connection.putrequest("GET", path, skip_host=True)
        for name, value in {"Host": host, **headers}.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        found = {name.lower(): value for name, value in answer.getheaders()}
        text = answer.read().decode()
        connection.close()
        return answer.status, found, text

    def cookie(self) -> str:
        """Come in as the next operator; return the cookie."""
        known = len(self.addresses)
        status, headers, text = self.get(f"/?token={self.token()}")
        assert status == 303, text
        wait_for(lambda: len(self.addresses) > known)
        return headers["set-cookie"].partition(";")[0]

    @contextmanager
    def page(self, cookie: str | None = None, origin: str | None = None) -> Iterator[PageSocket]:
        """Open a page's web socket."""
        headers = {"Cookie": cookie or self.cookie()}
        address = f"ws://127.0.0.1:{self.server.port}/session"
        with connect(
            address, origin=origin or self.origin, additional_headers=headers, open_timeout=WAIT_S
        ) as socket:
            yield PageSocket(socket)


@dataclass
class PageSocket:
    """What a page hears and says."""

    socket: ClientConnection
    states: list[dict[str, Any]] = field(default_factory=list)
    pictures: list[bytes] = field(default_factory=list)
    replies: list[dict[str, Any]] = field(default_factory=list)

    def say(self, action: str, step: int = 1, **more: Any) -> None:
        self.socket.send(json.dumps({"id": f"m-{time.monotonic_ns()}", "action": action,
                                     "step": step, **more}))  # fmt: skip

    def hear(self, wanted: Callable[[PageSocket], Any]) -> Any:
        """Listen until something is there; return it."""
        deadline = time.monotonic() + WAIT_S
        while not (found := wanted(self)):
            message = self.socket.recv(timeout=max(deadline - time.monotonic(), 0.01))
            if isinstance(message, bytes):
                self.pictures.append(message)
                continue
            content = json.loads(message)
            (self.states if content["kind"] == "state" else self.replies).append(content)
        return found


def wait_for(wanted: Callable[[], Any]) -> Any:
    """Return what `wanted` returns as soon as that is something."""
    deadline = time.monotonic() + WAIT_S
    while not (found := wanted()):
        assert time.monotonic() < deadline, "it did not come"
        time.sleep(0.02)
    return found


@contextmanager
def served() -> Iterator[Served]:
    """Run a server."""
    sentences: list[str] = []
    addresses: list[str] = []
    with ServerProcess(sentences.append, addresses.append) as server:
        found = Served(server, sentences, addresses)
        wait_for(lambda: addresses)
        yield found
