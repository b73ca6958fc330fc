"""The console's server lets in whom it should, refuses the rest in a sentence; it may be killed."""

from __future__ import annotations

import json
import os
import signal
import socket
import time
from contextlib import ExitStack

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosedError, InvalidStatus

from tests.support.console import Served, page_of, served
from tests.support.waiting import WAIT_S, wait_for
from vrcomfort.console import wire
from vrcomfort.console.access import (
    NO_COOKIE,
    OTHER_HOST,
    OTHER_ORIGIN,
    ConsoleAccess,
    operator_name,
)
from vrcomfort.console.server import ACTIONS_PER_S, LONGEST_CHARACTERS, read_command
from vrcomfort.operator_interface import Command


@pytest.fixture(scope="module")
def console():
    with served() as found:
        yield found


@pytest.mark.smoke
def test_a_token_works_once_and_becomes_a_cookie_that_scripts_and_other_sites_never_get(console):
    token, known = console.token(), len(console.addresses)
    status, headers, _ = console.get(f"/?token={token}")
    assert (status, headers["location"]) == (303, "/")
    cookie = headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert token not in cookie
    assert console.get(f"/?token={token}")[::2] == (403, NO_COOKIE)
    status, headers, text = console.get("/", Cookie=cookie.partition(";")[0])
    assert status == 200
    assert "<title>vrcomfort console</title>" in text
    assert "default-src 'none'" in headers["content-security-policy"]
    wait_for(lambda: len(console.addresses) == known + 1)
    assert console.token() != token


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=x", "/?token=é", "/console.js"])
def test_without_token_or_cookie_nothing_is_shown(console, path):
    path = path.encode().decode("latin-1") if "é" not in path else "/?token=%C3%A9"
    assert console.get(path)[::2] == (403, NO_COOKIE)


def test_a_cookie_of_somebody_else_is_none(console):
    name = f"vrcomfort_console_{console.server.port}"
    for forged in ("A", "A.", f"A.{'0' * 64}", ".", "Z.é"):
        cookie = f"{name}={forged}".encode().decode("latin-1")
        assert console.get("/", Cookie=cookie)[::2] == (403, NO_COOKIE)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:1", "127.0.0.1:1", "[::1]", ""])
def test_another_host_is_refused_even_with_the_cookie(console, host):
    cookie = console.cookie()
    assert console.get("/", Cookie=cookie, Host=host)[::2] == (403, OTHER_HOST)


def test_pages_of_another_origin_may_not_ask_nor_open_a_socket(console):
    cookie = console.cookie()
    for origin in ("http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1"):
        assert console.get("/", Cookie=cookie, Origin=origin)[::2] == (403, OTHER_ORIGIN)
        with pytest.raises(InvalidStatus) as refused, console.page(cookie, origin):
            pass
        assert refused.value.response.status_code == 403
        assert refused.value.response.body.decode() == OTHER_ORIGIN


def test_a_socket_without_a_cookie_is_refused(console):
    with pytest.raises(InvalidStatus) as refused, console.page("nothing=1"):
        pass
    assert refused.value.response.body.decode() == NO_COOKIE


def test_a_token_cannot_be_spent_from_another_origin(console):
    token = console.token()
    assert console.get(f"/?token={token}", Origin="http://evil.example")[0] == 403
    assert console.get(f"/?token={token}")[0] == 303
    wait_for(lambda: console.token() != token)


def test_only_this_machine_is_listened_to(console):
    with socket.socket() as other:
        other.settimeout(2.0)
        name = "127.0.0.2"  # the loopback too, but not the address that is bound
        assert other.connect_ex((name, console.server.port)) != 0


def test_what_the_session_shows_comes_to_every_page_and_what_a_page_wants_to_the_session(console):
    with console.page() as first, console.page() as second:
        operators = [
            page.hear(lambda page: [r for r in page.replies if r["kind"] == "you"])[0]["operator"]
            for page in (first, second)
        ]
        assert len(set(operators)) == 2
        console.server.show({"kind": "state", "step": {"number": 7}, "mark": "both"})
        for page in (first, second):
            page.hear(lambda page: page.states and page.states[-1].get("mark") == "both")
        second.say("note", 7, text=" sits  down ")
        command = wait_for(console.server.next_command)
        assert (command.action, command.step, command.text) == ("note", 7, "sits down")
        assert command.operator == operators[1]


def test_a_page_that_comes_back_gets_the_state_at_once(console):
    cookie = console.cookie()
    console.server.show({"kind": "state", "mark": "again"})
    for _ in range(2):
        with console.page(cookie) as page:
            page.hear(lambda page: page.states and page.states[-1]["mark"] == "again")


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        ("no json", "a message is not JSON; reload the page"),
        ("[" * 2000, "a message is not JSON; reload the page"),
        ("[1]", "a message is not a JSON object; reload the page"),
        ('{"id": "1"}', "`action` of a message is no word; reload the page"),
        ('{"id": "1", "action": "skip"}', "`step` of a message is no number of a step"),
        ('{"id": "1", "action": "skip", "step": true}', "`step` of a message is no number"),
        ('{"id": "1", "action": "skip", "step": 1, "text": 2}', "`text` of a message is no text"),
        ('{"id": "1", "action": "a", "step": 1, "value": NaN}', "`value` of a message is no num"),
        ('{"id": "1", "action": "a", "step": 1, "operator": "B"}', "a message has 'operator'"),
        (json.dumps({"id": "x" * 101, "action": "a", "step": 1}), "`id` of a message is no word"),
        ("x" * (LONGEST_CHARACTERS + 1), "a message of 4097 characters is too long"),
    ],
)
def test_malformed_and_oversized_messages_are_refused_in_a_sentence(console, message, sentence):
    with console.page() as page:
        page.socket.send(message)
        reply = page.hear(lambda page: [r for r in page.replies if r["kind"] == "reply"])[0]
        assert reply["refusal"].startswith(sentence)
        assert console.server.next_command() is None


def test_a_message_that_is_not_text_is_refused_and_a_huge_one_ends_the_socket(console):
    with console.page() as page:
        page.socket.send(b"\x00")
        reply = page.hear(lambda page: [r for r in page.replies if r["kind"] == "reply"])[0]
        assert reply["refusal"] == "a message is not text; reload the page"
        page.socket.send("x" * 100_000)
        with pytest.raises(ConnectionClosedError) as closed:
            page.hear(lambda _: False)
        assert closed.value.rcvd.code == 1009


def test_a_page_that_says_too_much_is_not_heard_for_a_moment(console):
    began_s = time.monotonic()
    with console.page() as page:
        for _ in range(10 * ACTIONS_PER_S):
            page.say("note", text="x")
        reply = page.hear(lambda page: [r for r in page.replies if r["kind"] == "reply"])[0]
        assert reply["refusal"].startswith(f"more than {ACTIONS_PER_S} messages a second")
        wait_for(lambda: console.server.pages == 1)  # which may be told later than the reply
    wait_for(lambda: console.server.pages == 0)
    seconds = 1 + int(time.monotonic() - began_s)
    heard = sum(1 for _ in iter(console.server.next_command, None))
    assert ACTIONS_PER_S <= heard <= seconds * ACTIONS_PER_S


def test_pictures_come_where_they_are_wanted_and_are_off_where_nobody_looks(console):
    red = np.zeros((4, 6, 3), np.uint8)
    red[..., 0] = 255
    body = b"\x06\x00\x04\x00" + red.tobytes()
    with console.page() as looks, console.page() as does_not:
        wait_for(lambda: console.server.pages == 2)
        assert console.server.pictures == 0
        looks.say("watch", value=1)
        wait_for(lambda: console.server.pictures == 1)
        console.server.show_picture(lambda: body)
        looks.hear(lambda page: page.pictures)
        assert looks.pictures[0][:2] == b"\xff\xd8"  # JPEG
        console.server.show({"kind": "state", "mark": "later"})
        does_not.hear(lambda page: page.states and page.states[-1].get("mark") == "later")
        assert does_not.pictures == []
    wait_for(lambda: console.server.pictures == 0)


def test_a_slow_server_drops_the_oldest_states_and_never_makes_anybody_wait(console: Served):
    os.kill(console.server.pid, signal.SIGSTOP)
    try:
        for number in range(5000):
            console.server.show({"kind": "state", "mark": number, "fill": "x" * 1000})
    finally:
        os.kill(console.server.pid, signal.SIGCONT)
    with console.page() as page:
        page.hear(lambda page: page.states and page.states[-1]["mark"] == 4999)


@pytest.mark.slow
def test_the_server_may_be_killed_and_another_takes_its_place_with_pages_and_state():
    with served() as console:
        cookie = console.cookie()
        console.server.show({"kind": "state", "mark": "kept"})
        port, killed = console.server.port, console.server.pid
        with console.page(cookie) as page:
            page.hear(lambda page: page.states)
        os.kill(killed, signal.SIGKILL)
        wait_for(lambda: console.sentences)
        assert console.sentences[0].startswith("the console's server ended (killed by signal 9)")
        wait_for(lambda: console.server.pid != killed)

        with page_of(console.origin, cookie) as page:
            assert page.hear(lambda page: page.states)[0]["mark"] == "kept"
        assert console.server.port == port
        operator = console.cookie().partition("=")[2][0]
        assert operator == "B"  # it still counts


def test_a_server_that_ends_again_and_again_is_left_alone(monkeypatch):
    monkeypatch.setattr("vrcomfort.console.process.STARTS_WITHIN_S", 3600.0)  # however slow it is
    with served() as console:
        console.server._begun[0] -= 7200.0  # the first is none of those that ended quickly
        killed = {None}
        for count in range(1, 7):
            wait_for(lambda: console.server.pid not in killed)
            killed.add(console.server.pid)
            if count == 1:
                console.server._end_input(console.server._process)  # then it ends by itself
            else:
                os.kill(console.server.pid, signal.SIGKILL)
            wait_for(lambda count=count: len(console.sentences) == count)
        assert "ended (exit code 0)" in console.sentences[0]
        assert ["again and again" in each for each in console.sentences] == [False] * 5 + [True]
        assert "the session goes on without it" in console.sentences[-1]
        assert (console.server.pages, console.server.pictures) == (0, 0)
        console.server.show({"kind": "state"})
        assert console.server.next_command() is None


@pytest.mark.slow
def test_a_new_server_hears_first_who_may_come_in_whatever_is_shown_meanwhile(monkeypatch):
    packed = wire.packed

    def slowly(content):
        if "key" in content:
            time.sleep(0.3)  # in which the other thread has states to send
        return packed(content)

    monkeypatch.setattr(wire, "packed", slowly)
    with served() as console:
        cookie = console.cookie()
        os.kill(console.server.pid, signal.SIGKILL)
        wait_for(lambda: console.sentences)
        for number in range(100):
            console.server.show({"kind": "state", "mark": number})
            time.sleep(0.01)
        with page_of(console.origin, cookie) as page:
            page.hear(lambda page: page.states and page.states[-1]["mark"] == 99)
        assert len(console.sentences) == 1


def test_the_server_tells_all_pages_how_the_session_ended_and_ends_with_its_block():
    """It is of another session of the system: Ctrl-C is for the session that records."""
    with served() as console, ExitStack() as open_pages:
        pid = console.server.pid
        if os.name == "posix":
            assert os.getsid(pid) == pid
        cookie = console.cookie()
        pages = [open_pages.enter_context(console.page(cookie)) for _ in range(20)]
        console.server.show({"kind": "state", "mark": "ended", "fill": "x" * 100_000})
        console.server.close()
        for page in pages:
            page.hear(lambda page: page.states and page.states[-1]["mark"] == "ended")
    if os.name == "posix":
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


@pytest.mark.slow
def test_a_server_that_stands_still_does_not_keep_the_session_from_its_end(monkeypatch):
    monkeypatch.setattr("vrcomfort.console.process.END_S", 1.0)
    with served() as console:
        stopped = console.server.pid
        os.kill(stopped, signal.SIGSTOP)
        for number in range(200):  # more than a pipe holds
            console.server.show({"kind": "state", "mark": number, "fill": "x" * 100_000})
            time.sleep(0.001)
        began_s = time.monotonic()
    assert time.monotonic() - began_s < WAIT_S
    with pytest.raises(ProcessLookupError):
        os.kill(stopped, 0)


def test_operators_have_letters_and_every_message_has_its_limit():
    assert [operator_name(n) for n in (1, 26, 27, 53)] == ["A", "Z", "A2", "A3"]
    access = ConsoleAccess(port=1)
    assert access.exchange("") is None
    assert access.operators == 0
    assert read_command('{"id": "1", "action": "rate", "step": 2, "value": 3}') == Command(
        "1", "rate", 2, "", 3
    )
