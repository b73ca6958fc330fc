"""The process behind the page: takes the session's state from a pipe and shows it to browsers.

Run by `process.ServerProcess`; standard input and output are the pipes. It ends with them.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import io
import json
import math
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import uvicorn
from PIL import Image
from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from vrcomfort.console import wire
from vrcomfort.console.access import NO_COOKIE, ConsoleAccess
from vrcomfort.escaping import escape_unprintable
from vrcomfort.operator_interface import Command

LONGEST_CHARACTERS = 4096
"""Of a message; a note of a page's length fits."""

LONGEST_WORD = 100
ACTIONS_PER_S = 20
"""More than a person asks for."""


def read_command(message: str) -> Command | str:
    """Return the command that a page has sent, or the sentence that refuses it."""
    if len(message) > LONGEST_CHARACTERS:
        found, most = len(message), LONGEST_CHARACTERS
        return f"a message of {found} characters is too long; {most} is the most: shorten the text"
    try:
        content = json.loads(message)
    except (ValueError, RecursionError):
        return "a message is not JSON; reload the page"
    if not isinstance(content, dict):
        return "a message is not a JSON object; reload the page"
    if unknown := sorted(set(content) - {"id", "action", "step", "text", "value"}):
        return f"a message has {unknown[0][:LONGEST_WORD]!r}, which means nothing; reload the page"
    return _checked(content)


def _checked(content: dict[str, Any]) -> Command | str:
    for name in ("id", "action"):
        word = content.get(name)
        if not isinstance(word, str) or not 0 < len(word) <= LONGEST_WORD:
            return f"`{name}` of a message is no word; reload the page"
    step, text, value = content.get("step"), content.get("text", ""), content.get("value")
    if type(step) is not int or not 0 <= step < 10**9:
        return "`step` of a message is no number of a step; reload the page"
    if not isinstance(text, str):
        return "`text` of a message is no text; reload the page"
    numeric = isinstance(value, int | float) and not isinstance(value, bool)
    if value is not None and not (numeric and math.isfinite(value) and abs(value) < 1e9):
        return "`value` of a message is no number; reload the page"
    own_words = content["action"] == "write"  # kept to the letter, escaped: `one_line`
    said = text.strip() if own_words else escape_unprintable(" ".join(text.split()))
    number, action = (escape_unprintable(content[key]) for key in ("id", "action"))
    return Command(number, action, step, said, value)


PAGE = Path(__file__).parent / "page"
# An operator has a few; a page that opens itself again and again stops here.
MOST_PAGES = 100
LAST_STATE_S = 2.0
"""So long pages have, at most, to take the last state, which says how the session ended."""
# Nothing from elsewhere is loaded, no other site frames the page, and no cache keeps a participant.
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
_FILES = {"/console.js": "text/javascript", "/console.css": "text/css"}


class ConsolePage:
    """One open page and its next messages. A slow one misses those between."""

    def __init__(self) -> None:
        self.wants_pictures = False
        self.replies: deque[str] = deque(maxlen=50)
        self._news = asyncio.Event()
        self._told = asyncio.Event()
        self._state: str | None = None
        self._picture: bytes | None = None

    def show(self, state: str) -> None:
        """Show this state, and no older one."""
        self._state = state
        self._news.set()

    def show_picture(self, picture: bytes) -> None:
        """Show this picture, if any are wanted, and no older one."""
        if self.wants_pictures:
            self._picture = picture
            self._news.set()

    def reply(self, content: dict[str, Any]) -> None:
        """Tell this page something."""
        self.replies.append(json.dumps(content))
        self._news.set()

    async def send(self, socket: WebSocket) -> None:
        """Send new messages while the page is open."""
        while True:
            await self._news.wait()
            self._news.clear()
            while self.replies:
                await socket.send_text(self.replies.popleft())
            state, self._state = self._state, None
            if state is not None:
                await socket.send_text(state)
            picture, self._picture = self._picture, None
            if picture is not None:
                await socket.send_bytes(picture)
            if not self._news.is_set():
                self._told.set()

    async def told(self) -> None:
        """Wait until all that was shown so far is on its way."""
        self._told.clear()
        self._news.set()
        await self._told.wait()


class ConsoleServer:
    """Serves the page to operators, and passes on their commands.

    Parameters
    ----------
    access
        Who may come in.
    tell
        Takes a message for the session.
    """

    def __init__(self, access: ConsoleAccess, tell: Callable[[dict[str, Any]], None]) -> None:
        self._access, self._tell = access, tell
        self._pages: set[ConsolePage] = set()
        self._state: str | None = None
        routes: list[Route | WebSocketRoute] = [Route("/", self._page)]
        routes += [Route(path, self._file) for path in _FILES]
        routes.append(WebSocketRoute("/session", self._socket))
        self.app = Starlette(routes=routes)

    def tell_access(self) -> None:
        """Tell the session the next operator's address."""
        access = self._access
        facts = {"port": access.port, "token": access.token, "operators": access.operators}
        self._tell({"kind": "access", **facts})

    def take(self, kind: bytes, body: bytes) -> None:
        """Show a message of the session's to all pages."""
        if kind == wire.PICTURE:
            picture = jpeg(body)
            for page in self._pages:
                page.show_picture(picture)
            return
        self._state = body.decode()
        for page in self._pages:
            page.show(self._state)

    async def show_last(self) -> None:
        """Wait until all pages have the last state, at most `LAST_STATE_S`."""
        telling = [asyncio.create_task(page.told()) for page in self._pages]
        if telling:
            await asyncio.wait(telling, timeout=LAST_STATE_S)

    def _refusal(self, connection: HTTPConnection, *, socket: bool = False) -> str:
        refusal = self._access.refusal(connection.headers, socket=socket)
        return refusal or ("" if self._operator(connection) else NO_COOKIE)

    def _operator(self, connection: HTTPConnection) -> str | None:
        return self._access.operator(connection.cookies.get(self._access.cookie_name))

    async def _page(self, request: Request) -> Response:
        token = request.query_params.get("token")
        refusal = self._access.refusal(request.headers, socket=False)
        if token is not None and not refusal and (cookie := self._access.exchange(token)):
            self.tell_access()
            welcome = RedirectResponse("/", 303, HEADERS)
            name = self._access.cookie_name
            welcome.set_cookie(name, cookie, httponly=True, samesite="strict", path="/")
            return welcome
        if refusal := self._refusal(request):
            return PlainTextResponse(refusal, 403, HEADERS)
        return FileResponse(PAGE / "console.html", headers=HEADERS)

    async def _file(self, request: Request) -> Response:
        if refusal := self._refusal(request):
            return PlainTextResponse(refusal, 403, HEADERS)
        path = request.url.path
        return FileResponse(PAGE / path[1:], headers=HEADERS, media_type=_FILES[path])

    async def _socket(self, socket: WebSocket) -> None:
        refusal = self._refusal(socket, socket=True)
        if not refusal and len(self._pages) >= MOST_PAGES:
            refusal = f"{MOST_PAGES} pages are open, which is the most; close some."
        if refusal:
            await socket.send_denial_response(PlainTextResponse(refusal, 403, HEADERS))
            return
        await socket.accept()
        page = ConsolePage()
        self._pages.add(page)
        self._tell_watching()
        page.reply({"kind": "you", "operator": self._operator(socket)})
        if self._state is not None:
            page.show(self._state)
        sending = asyncio.create_task(page.send(socket))
        try:
            await self._listen(socket, page)
        except WebSocketDisconnect:
            pass
        finally:
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
                await sending
            self._pages.discard(page)
            self._tell_watching()

    async def _listen(self, socket: WebSocket, page: ConsolePage) -> None:
        """Pass on a page's commands."""
        times: deque[float] = deque(maxlen=ACTIONS_PER_S)
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            now_s = time.monotonic()
            if len(times) == ACTIONS_PER_S and now_s - times[0] < 1.0:
                sentence = f"more than {ACTIONS_PER_S} messages a second; this one was dropped"
                page.reply({"kind": "reply", "id": "", "refusal": sentence})
                continue
            times.append(now_s)
            self._entered(message.get("text"), page, self._operator(socket) or "")

    def _entered(self, message: str | None, page: ConsolePage, operator: str) -> None:
        entered = "a message is not text; reload the page" if message is None else ""
        found = entered or read_command(message or "")
        if isinstance(found, str):
            page.reply({"kind": "reply", "id": "", "refusal": found})
        elif found.action == "watch":
            page.wants_pictures = found.value == 1
            self._tell_watching()
        else:
            self._tell({"kind": "command", **found.content(), "operator": operator})

    def _tell_watching(self) -> None:
        watching = sum(page.wants_pictures for page in self._pages)
        self._tell({"kind": "watching", "pages": len(self._pages), "pictures": watching})


def jpeg(body: bytes) -> bytes:
    """Return a picture as JPEG; width and height are its first four bytes, then RGB, bottom up."""
    width, height = int.from_bytes(body[:2], "little"), int.from_bytes(body[2:4], "little")
    picture = Image.frombytes("RGB", (width, height), body[4:]).transpose(
        Image.Transpose.FLIP_TOP_BOTTOM
    )
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=75)
    return file.getvalue()


class _Serving(uvicorn.Server):
    """Tells when it serves; hears no signals, for the session decides when it ends."""

    def __init__(self, config: uvicorn.Config, started: Callable[[], None]) -> None:
        super().__init__(config)
        self._tell_started = started

    async def startup(self, sockets: list[Any] | None = None) -> None:
        """Begin to serve."""
        await super().startup(sockets)
        self._tell_started()

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Hear none."""
        yield


def _read_pipe(
    server: ConsoleServer, uvicorn_server: uvicorn.Server, loop: asyncio.AbstractEventLoop
) -> None:
    """Pass messages of the session on, until it is gone; pages get to know how it ended."""
    while (message := wire.read_message(sys.stdin.buffer)) is not None:
        loop.call_soon_threadsafe(server.take, *message)
    with contextlib.suppress(concurrent.futures.CancelledError):
        asyncio.run_coroutine_threadsafe(server.show_last(), loop).result()
    uvicorn_server.should_exit = True


def main() -> None:
    """Serve until standard input ends; its first message has port and credentials."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the session decides what Ctrl-C means
    first = wire.read_message(sys.stdin.buffer)
    if first is None:
        return
    settings = json.loads(first[1])
    pipe = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # nothing else may write into the pipe
    lock = threading.Lock()

    def tell(content: dict[str, Any]) -> None:
        with lock, contextlib.suppress(OSError):
            pipe.write(wire.packed(content))

    config = uvicorn.Config(
        app="", host="127.0.0.1", port=settings["port"], log_level="error", access_log=False,
        ws="websockets-sansio", ws_max_size=4 * LONGEST_CHARACTERS, ws_per_message_deflate=False,
        server_header=False, timeout_graceful_shutdown=1,
    )  # fmt: skip
    socket = config.bind_socket()
    access = ConsoleAccess(
        socket.getsockname()[1], settings["key"], settings["token"], settings["operators"]
    )
    server = ConsoleServer(access, tell)
    config.app = server.app
    serving = _Serving(config, server.tell_access)

    async def serve() -> None:
        loop = asyncio.get_running_loop()
        reading = threading.Thread(target=_read_pipe, args=(server, serving, loop), daemon=True)
        reading.start()
        await serving.serve(sockets=[socket])

    asyncio.run(serve())


if __name__ == "__main__":
    main()
