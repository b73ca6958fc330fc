"""The session's states, as the runtime drives them, and the other events it sends."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable
from typing import Any

import xr

from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.openxr.faults import lost
from vrcomfort.headset.openxr.instance import STEREO
from vrcomfort.headset.openxr.native import native, watched

State = xr.SessionState
POLL_S = 0.01
_ANY_EVENT = xr.StructureType.EVENT_DATA_BUFFER.value
SEEN = (State.VISIBLE, State.FOCUSED)


class Lifecycle:
    """Follows the session from idle to exit; begins and ends it when the runtime says so.

    Parameters
    ----------
    instance, session
        Handles of OpenXR.
    notify
        Called with each event worth recording.
    """

    def __init__(
        self, instance: xr.Instance, session: xr.Session, notify: Callable[[HeadsetEvent], None]
    ) -> None:
        self._instance = instance
        self._session = session
        self._notify = notify
        self.state = State.IDLE
        self.running = False
        self.ended = False
        self._recentered_at_ns: int | None = None
        self._poll_event = native("xrPollEvent", usual=xr.Result.EVENT_UNAVAILABLE)
        self._event = xr.EventDataBuffer()
        kind = xr.StructureType
        self._handlers: dict[xr.StructureType, tuple[Any, Callable[[Any], None]]] = {
            kind.EVENT_DATA_SESSION_STATE_CHANGED: (
                xr.EventDataSessionStateChanged,
                self._on_state,
            ),
            kind.EVENT_DATA_INSTANCE_LOSS_PENDING: (
                xr.EventDataInstanceLossPending,
                self._on_instance_loss,
            ),
            kind.EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING: (
                xr.EventDataReferenceSpaceChangePending,
                self._on_recenter,
            ),
            kind.EVENT_DATA_USER_PRESENCE_CHANGED_EXT: (
                xr.EventDataUserPresenceChangedEXT,
                self._on_presence,
            ),
            kind.EVENT_DATA_INTERACTION_PROFILE_CHANGED: (
                xr.EventDataInteractionProfileChanged,
                lambda _: notify(HeadsetEvent("controllers_changed")),
            ),
            kind.EVENT_DATA_EVENTS_LOST: (
                xr.EventDataEventsLost,
                lambda event: notify(HeadsetEvent("events_lost", str(event.lost_event_count))),
            ),
        }

    @property
    def seen(self) -> bool:
        """Return whether the participant sees what is submitted."""
        return self.state in SEEN

    @property
    def focused(self) -> bool:
        """Return whether the controllers are the session's, not those of the runtime's menu."""
        return bool(self.state == State.FOCUSED)

    def wait_until_running(self, timeout_s: float = math.inf) -> bool:
        """Handle events until frames are wanted; return False where the session has ended.

        While the headset is asleep this waits: False also means that the time is over.
        """
        give_up_s = time.monotonic() + timeout_s
        self.poll()
        while not (self.running or self.ended) and time.monotonic() < give_up_s:
            time.sleep(POLL_S)
            self.poll()
        return self.running and not self.ended

    def recentered_by(self, time_ns: int) -> bool:
        """Return, once, whether the runtime moved the origin of the stage by `time_ns`."""
        if self._recentered_at_ns is None or time_ns < self._recentered_at_ns:
            return False
        self._recentered_at_ns = None
        return True

    def poll(self) -> None:
        """Handle the events that have arrived.

        Raises
        ------
        RuntimeLostError
            If the runtime says that it is going away.
        """
        event = self._event
        while True:
            event._type, event._next = _ANY_EVENT, None
            if self._poll_event(self._instance, event) != 0:
                return
            kind, handle = self._handlers.get(event.type, (None, None))
            if kind is not None and handle is not None:
                handle(ctypes.cast(ctypes.byref(event), ctypes.POINTER(kind)).contents)

    def _on_state(self, event: Any) -> None:
        self.state = State(event.state)
        self._notify(HeadsetEvent("session_state", self.state.name.lower()))
        if self.state == State.READY:
            watched(xr.begin_session, self._session, xr.SessionBeginInfo(STEREO))
            self.running = True
        elif self.state == State.STOPPING:
            self.running = False
            watched(xr.end_session, self._session)
        elif self.state == State.EXITING:
            self.ended = True
        elif self.state == State.LOSS_PENDING:
            raise lost("it announced the loss of the session")

    def _on_instance_loss(self, _: Any) -> None:
        raise lost("it announced that it is going away")

    def _on_recenter(self, event: Any) -> None:
        self._recentered_at_ns = int(event.change_time)
        space = xr.ReferenceSpaceType(event.reference_space_type).name.lower()
        self._notify(HeadsetEvent("recentered", f"{space} by the runtime"))

    def _on_presence(self, event: Any) -> None:
        self._notify(HeadsetEvent("headset_on" if event.is_user_present else "headset_off"))
