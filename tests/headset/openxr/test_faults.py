"""What a session says when the runtime refuses, lacks something, or stops answering."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import islice
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, fresh_monado, needs_monado
from tests.support.waiting import WAIT_S
from vrcomfort.errors import InputError, RuntimeLostError
from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset.monado import Monado, RemoteFeed, RemoteState

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_layers import Interceptor, answer
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.openxr.graphics_binding import OPENGL
from vrcomfort.headset.openxr.instance import connect

pytestmark = needs_monado

SIZE_PX = (16, 16)
STANDING = RemoteState(Pose([0.0, 1.6, 0.0]))


def headset(ctx: moderngl.Context, feed: RemoteFeed, **calls: Any) -> OpenXrHeadset:
    layer = Interceptor(**calls)
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=(layer.name,))
    return OpenXrHeadset(ctx, settings, before_wait=Participant(feed, lambda _: STANDING))


@pytest.mark.parametrize(
    ("function", "result", "words"),
    [
        ("xrGetSystem", xr.Result.ERROR_FORM_FACTOR_UNAVAILABLE, "finds no headset; connect it"),
        ("xrGetSystem", xr.Result.ERROR_FORM_FACTOR_UNSUPPORTED, "does not drive head-mounted"),
        ("xrCreateSession", xr.Result.ERROR_GRAPHICS_DEVICE_INVALID, "another graphics device"),
        ("xrCreateSession", xr.Result.ERROR_LIMIT_REACHED, "another application; close it"),
        ("xrCreateSession", xr.Result.ERROR_OUT_OF_MEMORY, "refuses to start a session"),
    ],
)
def test_a_refusal_says_what_to_do(
    ctx: moderngl.Context, feed: RemoteFeed, function: str, result: Any, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        headset(ctx, feed, **{function: answer(result)})


def offer(*formats: int) -> Any:
    def enumerate_formats(_: Any, __: Any, capacity: int, found: Any, numbers: Any) -> Any:
        found[0] = len(formats)
        for index in range(min(capacity, len(formats))):
            numbers[index] = formats[index]
        return xr.Result.SUCCESS

    return enumerate_formats


def test_without_srgb_images_the_session_is_refused(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    with pytest.raises(InputError, match=r"offers no SRGB8_ALPHA8 images.*0x881a"):
        headset(ctx, feed, xrEnumerateSwapchainFormats=offer(0x881A, 0x8058))


def test_without_float_depth_images_the_record_says_so(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    with headset(ctx, feed, xrEnumerateSwapchainFormats=offer(0x8C43, 0x81A5)) as session:
        assert "no DEPTH_COMPONENT32F" in session.details["depth_layer"]


def test_an_image_that_never_comes_is_a_runtime_lost(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)

    def late(*_: Any) -> Any:
        return xr.Result.TIMEOUT_EXPIRED

    session = headset(ctx, feed, xrWaitSwapchainImage=late)
    frame = next(frame for frame in session.frames() if frame.should_render)
    with pytest.raises(RuntimeLostError, match=r"no image within 5 s.*--resume"):
        session.submit(frame, eyes)
    session.close()


@pytest.mark.parametrize(
    ("function", "result", "words"),
    [
        ("xrWaitFrame", xr.Result.SESSION_LOSS_PENDING, "announced the loss of the session"),
        ("xrEndFrame", xr.Result.ERROR_POSE_INVALID, "pose of a frame invalid"),
        ("xrEndFrame", xr.Result.ERROR_TIME_INVALID, "display time of a frame invalid"),
        ("xrLocateViews", xr.Result.ERROR_TIME_INVALID, "display time of a frame invalid"),
    ],
)
def test_a_runtime_that_refuses_to_go_on_is_one_sentence(
    ctx: moderngl.Context, feed: RemoteFeed, function: str, result: Any, words: str
) -> None:
    refusing = {"now": False}

    def refuse(follow: Any, *arguments: Any) -> Any:
        return result if refusing["now"] else follow(*arguments)

    with headset(ctx, feed, **{function: refuse}) as session:
        frames = session.frames()
        session.submit(next(frames), None)
        refusing["now"] = True
        with pytest.raises(RuntimeLostError, match=rf"{words}.*is kept.*--resume"):
            session.submit(next(frames), None)
        refusing["now"] = False


def test_a_frame_that_the_runtime_discards_is_an_event(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    results = iter([xr.Result.SUCCESS, xr.Result.FRAME_DISCARDED])

    def begin(follow: Any, *arguments: Any) -> Any:
        follow(*arguments)
        return next(results, xr.Result.SUCCESS)

    with headset(ctx, feed, xrBeginFrame=begin) as session:
        for frame in islice(session.frames(), 4):
            session.submit(frame, None)
        told = [event.name for event in session.take_events()]
    assert told.count("frame_discarded") == 1


def test_a_runtime_that_is_gone_is_told_whatever_is_asked_of_it(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    quad = Quad(Pose([0.0, 1.5, -1.5]), (1.0, 1.0))
    with fresh_monado(tmp_path) as service, service.feed() as feed:
        session = headset(ctx, feed)
        list(islice(session.frames(), 4))
        panel = session.show_panel((8, 8), quad)
        service.kill()
        for ask in (
            lambda: panel.draw(np.zeros((8, 8, 4), np.uint8)),
            lambda: session.details,
            lambda: session.refresh_hz,
            lambda: session.show_panel((8, 8), quad),
        ):
            with pytest.raises(RuntimeLostError, match="--resume"):
                ask()
        session.close()


def test_a_runtime_without_a_needed_extension_is_refused_by_name(monado: Monado) -> None:
    with pytest.raises(InputError, match=r"does not offer XR_KHR_nothing, which OpenGL"):
        connect(OpenXrSettings(), (OPENGL, "XR_KHR_nothing"), lambda _: None)


def test_without_a_context_there_is_nothing_to_bind(tmp_path: Path) -> None:
    client = (
        "from vrcomfort.headset.openxr.graphics_binding import current_binding; current_binding()"
    )
    done = subprocess.run(
        [sys.executable, "-c", client], capture_output=True, text=True, check=False
    )
    assert "InputError: no OpenGL context is current" in done.stderr


def doctor(*options: str) -> dict[str, dict[str, Any]]:
    command = ["vrcomfort", "doctor", "--json", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=WAIT_S, check=False)
    assert done.returncode == 0, done.stderr
    return {finding["part"]: finding for finding in json.loads(done.stdout)}


def test_doctor_describes_the_runtime(monado: Monado, feed: RemoteFeed) -> None:
    feed.send(STANDING)
    parts = doctor("--timing")
    assert "Monado" in parts["OpenXR runtime"]["found"]
    assert "XR_KHR_opengl_enable" in parts["extensions"]["details"]
    assert "320×240" in parts["headset"]["found"]
    assert "EGL binding, images SRGB8_ALPHA8" in parts["OpenXR session"]["found"]
    assert "depth layer DEPTH_COMPONENT32F" in parts["OpenXR session"]["found"]
    assert "20 Hz" in parts["refresh rate"]["found"]
    assert parts["timing_trust"]["found"].startswith("simulated: ")
    assert "dropped" in parts["timing test"]["found"]


def test_doctor_says_which_runtime_does_not_answer(
    monado: Monado, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    runtime = doctor()["OpenXR runtime"]
    assert not runtime["ok"]
    assert "start your headset's software" in runtime["remedy"]


def test_warnings_of_layers_become_events(ctx: moderngl.Context, feed: RemoteFeed) -> None:
    told = xr.DebugUtilsMessengerCallbackDataEXT(function_name="xrTest", message="mind this")

    with headset(ctx, feed) as session:
        next(iter(islice(session.frames(), 1)))
        xr.submit_debug_utils_message_ext(
            session._xr.runtime.instance,
            xr.DebugUtilsMessageSeverityFlagsEXT.WARNING_BIT,
            xr.DebugUtilsMessageTypeFlagsEXT.GENERAL_BIT,
            told,
        )
        events = [(event.name, event.detail) for event in session.take_events()]
    assert ("openxr_warning", "xrTest: mind this") in events
