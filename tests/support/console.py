"""A console's server, and what speaks to it: requests, web sockets, and a session that waits."""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from typing import Any, TypeVar
from urllib.parse import parse_qs, urlsplit

from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from tests.support.waiting import WAIT_S, wait_for
from vrcomfort.console import ServerProcess

NOT_YET = (OSError, http.client.HTTPException, WebSocketException)
"""How a connection fails while a server is killed and another started: it is refused, reset, or
taken by whom it is too late for, who ends it before, or in the middle of, the first answer."""
Answer = TypeVar("Answer")


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
        with page_socket(self.origin, cookie or self.cookie(), origin) as socket:
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


def answered(ask: Callable[[], Answer]) -> Answer:
    """Ask until a server that is killed, or started, answers."""
    deadline = time.monotonic() + WAIT_S
    while True:
        try:
            return ask()
        except NOT_YET:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.1)


def page_socket(server: str, cookie: str, origin: str | None = None) -> ClientConnection:
    """Open a page's web socket at a server ("http://127.0.0.1:1"); raises what `NOT_YET` has."""
    return connect(
        f"ws{server.removeprefix('http')}/session", origin=origin or server,
        additional_headers={"Cookie": cookie}, open_timeout=WAIT_S, ping_interval=None,
        max_queue=None,
    )  # fmt: skip


@contextmanager
def page_of(server: str, cookie: str) -> Iterator[PageSocket]:
    """Open a page as a browser does: again and again, until the server is there."""
    with answered(lambda: page_socket(server, cookie)) as socket:
        yield PageSocket(socket)


@contextmanager
def served() -> Iterator[Served]:
    """Run a server."""
    sentences: list[str] = []
    addresses: list[str] = []
    with ServerProcess(sentences.append, addresses.append) as server:
        found = Served(server, sentences, addresses)
        wait_for(lambda: addresses)
        yield found


@dataclass(frozen=True)
class Doing:
    """What an operator does when a step's name has these words, and when (paused or not)."""

    words: str
    action: str
    text: str = ""
    paused: bool = False
    after_s: float = 0.0


def come_in(address: str) -> tuple[str, str]:
    """Return origin and cookie of an operator who opens an address."""
    parts = urlsplit(address)

    def ask() -> tuple[int, str]:
        connection = http.client.HTTPConnection(parts.netloc, timeout=WAIT_S)
        with closing(connection):
            connection.request("GET", f"/?{parts.query}")
            answer = connection.getresponse()
            return answer.status, answer.getheader("set-cookie") or ""

    status, cookie = answered(ask)
    assert cookie, status
    return f"http://{parts.netloc}", cookie.partition(";")[0]


def steer(
    page: PageSocket, plan: list[Doing], *, answer: int = 1, until: tuple[str, ...] = ()
) -> list[dict[str, Any]]:
    """Answer everything and follow a plan to the end of the session; return its states.

    `until` ends it before, in a step whose name has any of these words.
    """
    plan, asked = list(plan), ""
    while not page.states or not page.states[-1]["ended"]:
        if page.states and any(each in page.states[-1]["step"]["words"] for each in until):
            break
        known = len(page.states)
        page.hear(lambda page, known=known: len(page.states) > known)
        state = page.states[-1]
        step, question = state["step"], state.get("question")
        doing = plan[0] if plan else None
        if doing and _is_time(state, doing):
            page.say(doing.action, step["number"], text=doing.text)
            plan.pop(0)
        elif question and (key := json.dumps([step, question])) != asked:
            asked = key
            _answer(page, step["number"], question, answer)
    assert plan == [], "the session ended before"
    return page.states


def _is_time(state: dict[str, Any], doing: Doing) -> bool:
    here = doing.words in state["step"]["words"] and state["paused"] == doing.paused
    return here and state["done"] >= doing.after_s


def _answer(page: PageSocket, step: int, question: dict[str, Any], answer: int) -> None:
    items, place = question["items"], question["current"]
    if place == len(items):
        page.say("confirm", step)
    else:
        page.say(question["action"], step, text=items[place]["name"], value=answer)
