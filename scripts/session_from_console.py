"""A whole session under Monado, run from the console alone, and shown again beside a condition.

``scripts/in_runtime.sh python scripts/session_from_console.py FOLDER [WIDTHxHEIGHT]``

An operator who is a program starts it, notes something, pauses, has the first exposure redone,
rates and fills in the questionnaires on the page's own socket. Then `vrcomfort play` shows the
session again. FOLDER gets the study, both.mp4 and the pictures of the last exposure.
"""

from __future__ import annotations

import http.client
import itertools
import json
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from vrcomfort.resources import data_folder

PROTOCOL = """\
name = "steered"
title = "A short study that is steered"
exposure_s = 3.0
training_s = 0.5
scenes = ["temple"]
questionnaires = [{ timepoint = "post", when = "after_trial" }]
ratings = { instrument = "fms", every_s = 0.7, timeout_s = 0.5 }

[order]
rule = "explicit"
[[order.sequences]]
name = "one"
sessions = [[
  { scene = "temple", condition = "plain" },
  { scene = "temple", condition = "blur" },
]]

[[conditions]]
name = "plain"

[[conditions]]
name = "blur"
[conditions.depth_of_field]
max_radius_percent = 3
"""
CLIENT = "from vrcomfort.cli import main; main()"
WAIT_S = 120.0
"""Guards against waiting for ever; a busy machine takes long."""
ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/\?token=\S+")


class Operator:
    """Goes by what the page shows, and does each thing once."""

    def __init__(self) -> None:
        self._numbers = itertools.count()
        self._did: set[object] = set()
        self._since_s: dict[int, float] = {}
        self._exposures: list[int] = []

    def wants(self, state: dict[str, Any]) -> Iterator[dict[str, Any]]:
        """Yield what to send now."""
        step = state.get("step")
        if not step:
            return
        number, kind = step["number"], step["kind"]
        since_s = time.monotonic() - self._since_s.setdefault(number, time.monotonic())
        question = state.get("question")
        if kind == "ready":
            yield from self._once("start", number)
        elif kind == "exposure":
            if number not in self._exposures:
                self._exposures.append(number)
            if self._exposures.index(number) == 0:
                yield from self._first(number, since_s)
        if question and question["action"] == "rate":
            key = (number, len(state["ratings"]))
            yield from self._once("rate", number, key=key, value=2 + len(state["ratings"]))
        elif question:
            yield from self._fill_in(number, question)

    def _first(self, number: int, since_s: float) -> Iterator[dict[str, Any]]:
        """Note something, pause for a while, and have it all again."""
        if since_s > 0.3:
            yield from self._once("note", number, text="looks around a lot")
        if since_s > 0.6:
            yield from self._once("pause", number)
        if since_s > 1.4:
            yield from self._once("go_on", number)
        if since_s > 2.0:
            yield from self._once("redo", number)

    def _fill_in(self, number: int, question: dict[str, Any]) -> Iterator[dict[str, Any]]:
        open_items = [each for each in question["items"] if not each["answered"]]
        for place, item in enumerate(open_items):
            key = (number, item["name"])
            yield from self._once("answer", number, key=key, text=item["name"], value=place % 4)
        if not open_items:
            yield from self._once("confirm", number, key=(number, "confirm"))

    def _once(
        self, action: str, step: int, *, key: object = None, **more: Any
    ) -> Iterator[dict[str, Any]]:
        key = (action, key)
        if key not in self._did:
            self._did.add(key)
            yield {"id": f"m{next(self._numbers)}", "action": action, "step": step, **more}


def main(folder: Path, size: str) -> None:
    """Run the session and show it again."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "steered.toml").write_text(PROTOCOL, encoding="utf-8")
    words = [
        *("run", folder / "steered.toml", "--participant", "P01", "--out", folder / "study"),
        *("--headset", "openxr", "--monado-trace", data_folder("scenes") / "temple_walk.csv"),
        *("--size", size, "--console", "--respondent", "console"),
    ]
    process = subprocess.Popen(
        _command(words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        _operate(*_come_in(process))
        code = process.wait(WAIT_S)
    finally:
        process.kill()
    if code:
        raise SystemExit(f"the session ended with code {code}")
    session = folder / "study" / "sub-P01" / "ses-1"
    play = ["play", session, "--beside", "plain", "--show", "ratings"]
    subprocess.run(_command([*play, "--video", folder / "both.mp4"]), check=True)
    last = ["--trial", "2", "--out", folder / "pictures"]
    subprocess.run(_command([*play, *last, "--quiet"]), check=True)


def _command(words: list[object]) -> list[str]:
    return [sys.executable, "-c", CLIENT, *map(str, words)]


def _come_in(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Return the console's address and cookie, once it is there."""
    assert process.stdout is not None  # noqa: S101 - it is a pipe
    for line in process.stdout:
        print(line, end="")
        if found := ADDRESS.search(line):
            break
    else:
        raise SystemExit("the session told no console's address")
    threading.Thread(target=lambda: [print(line, end="") for line in process.stdout or ()]).start()
    parts = urlsplit(found[0])
    connection = http.client.HTTPConnection(parts.netloc, timeout=WAIT_S)
    connection.request("GET", f"{parts.path}?{parts.query}")
    cookie = connection.getresponse().getheader("set-cookie") or ""
    return parts.netloc, cookie.partition(";")[0]


def _operate(place: str, cookie: str) -> None:
    """Steer the session until it has ended."""
    operator, state = Operator(), {}
    headers = {"Cookie": cookie}
    address = f"ws://{place}/session"
    with connect(
        address, origin=f"http://{place}", additional_headers=headers, open_timeout=WAIT_S,
        ping_interval=None,
    ) as page:  # fmt: skip
        while not state.get("ended"):
            try:
                message = page.recv(timeout=0.1)
            except TimeoutError:
                message = b""
            except ConnectionClosed:
                return
            if isinstance(message, str):
                heard = json.loads(message)
                state = heard if heard["kind"] == "state" else state
            for wish in operator.wants(state):
                page.send(json.dumps(wish))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "160x200")
