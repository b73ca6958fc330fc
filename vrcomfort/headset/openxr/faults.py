"""Turns OpenXR's error codes into sentences."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from xr import exception

from vrcomfort.errors import InputError, RuntimeLostError

LOST = (
    exception.InstanceLostError,
    exception.SessionLostError,
    exception.RuntimeFailureError,
    exception.SessionNotRunningError,
)

REFUSED = {
    exception.SessionLossPending: "it announced the loss of the session",
    exception.PoseInvalidError: "it found the pose of a frame invalid",
    exception.TimeInvalidError: "it found the display time of a frame invalid",
}
"""Other exceptions that end a session, each with its cause in words."""

CANNOT_START = {
    exception.RuntimeUnavailableError: (
        "no OpenXR runtime is active; start your headset's software (SteamVR, Oculus, Windows "
        "Mixed Reality, Monado) and make it the active OpenXR runtime, or set XR_RUNTIME_JSON"
    ),
    exception.InstanceLostError: (
        "the OpenXR runtime does not answer; start your headset's software, then run again"
    ),
    exception.RuntimeFailureError: (
        "the OpenXR runtime does not answer; start your headset's software, then run again"
    ),
    exception.FormFactorUnavailableError: (
        "the OpenXR runtime runs, but finds no headset; connect it, switch it on, then run again"
    ),
    exception.FormFactorUnsupportedError: (
        "the active OpenXR runtime does not drive head-mounted displays; make your headset's "
        "runtime the active one"
    ),
    exception.ApiLayerNotPresentError: (
        "an OpenXR API layer that was asked for is not installed; check XR_API_LAYER_PATH"
    ),
    exception.GraphicsDeviceInvalidError: (
        "the OpenXR runtime does not accept this OpenGL context: the headset is driven by another "
        "graphics device or window system; run on the GPU that the headset is plugged into"
    ),
    exception.LimitReachedError: (
        "the OpenXR runtime already serves another application; close it, then run again"
    ),
}


@contextmanager
def starting() -> Iterator[None]:
    """Say in one sentence why a session could not start."""
    try:
        yield
    except exception.ResultException as error:
        for kind, message in CANNOT_START.items():
            if isinstance(error, kind):
                raise InputError(message) from error
        raise InputError(f"the OpenXR runtime refuses to start a session: {error}") from error


@contextmanager
def running() -> Iterator[None]:
    """Tell a runtime that went away, or refuses to go on, from every other fault."""
    try:
        yield
    except LOST as error:
        raise lost(str(error)) from error
    except tuple(REFUSED) as error:
        raise lost(REFUSED[type(error)]) from error


def asleep(patience_s: float) -> RuntimeLostError:
    """Return the exception for a headset that has shown nothing for too long."""
    return RuntimeLostError(
        f"the headset has shown nothing for {patience_s:g} s (it sleeps, or its runtime shows "
        "something else); what was recorded up to here is kept: put it on, then run with --resume"
    )


def lost(reason: str) -> RuntimeLostError:
    """Return the exception for a runtime that is gone."""
    return RuntimeLostError(
        f"the OpenXR runtime stopped in the middle of the session ({reason}); what was recorded "
        "up to here is kept: start the runtime again, then run with --resume"
    )
