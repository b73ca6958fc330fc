"""The session's states as the runtime drives them, and the participant's presence."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import xr

from vrcomfort.frame import HeadsetEvent
from vrcomfort.geometry import Pose
from vrcomfort.headset.inputs import Inputs
from vrcomfort.headset.openxr.faults import asleep, lost
from vrcomfort.headset.openxr.instance import STEREO
from vrcomfort.headset.openxr.native import native, pose_from_xr, watched
from vrcomfort.headset.openxr.profiles import HANDS
from vrcomfort.headset.timing import RefreshPeriod

State = xr.SessionState
POLL_S = 0.01
_NO_EVENT = bytes(xr.EventDataBuffer())[: xr.EventDataBuffer.varying.offset]
"""The fields `type` and `next`, as OpenXR wants them before each poll."""
ABSENT_NS = 500_000_000
"""A presence sensor that sees nobody for less has slipped: the picture stays."""
EYES = ("left", "right")
SEEN = (State.VISIBLE, State.FOCUSED)
TAKEN_OFF = "the headset is off: exposures wait until its sensor sees somebody"
OUT_OF_REACH = (
    "a menu of the headset's is in front: the participant's controllers do not reach the program, "
    "and their stop button does not work now"
)


@dataclass(frozen=True)
class SpaceChange:
    """A change of the origin of one of the runtime's spaces.

    Parameters
    ----------
    space
        ``stage``, ``local_floor``, ``local`` ...
    time_ns
        From which time on poses are measured from the new origin.
    old_from_new
        The new origin seen from the old one; None where the runtime does not know.
    """

    space: str
    time_ns: int
    old_from_new: Pose | None


class Lifecycle:
    """Follows the session from idle to exit; begins and ends it when the runtime says so.

    Parameters
    ----------
    instance, session
        Handles of OpenXR.
    notify
        Called with each event worth recording.
    display_hz
        Returns the display's refresh rate as it was asked for, or as the runtime tells it; 0 where
        neither is known.

    Attributes
    ----------
    user_present
        Whether the headset's sensor sees somebody; None until the runtime tells.
    """

    def __init__(
        self,
        instance: xr.Instance,
        session: xr.Session,
        notify: Callable[[HeadsetEvent], None],
        display_hz: Callable[[], float],
    ) -> None:
        self._instance = instance
        self._session = session
        self._notify = notify
        self.state = State.IDLE
        self.running = False
        self.ended = False
        self.user_present: bool | None = None
        self.refresh_period = RefreshPeriod(display_hz, notify)
        self._space_changes: list[SpaceChange] = []
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
                self._on_space_change,
            ),
            kind.EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB: (
                xr.EventDataDisplayRefreshRateChangedFB,
                self._on_refresh_rate,
            ),
            kind.EVENT_DATA_USER_PRESENCE_CHANGED_EXT: (
                xr.EventDataUserPresenceChangedEXT,
                self._on_presence,
            ),
            kind.EVENT_DATA_INTERACTION_PROFILE_CHANGED: (
                xr.EventDataInteractionProfileChanged,
                lambda _: notify(HeadsetEvent("controllers_changed")),
            ),
            kind.EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR: (
                xr.EventDataVisibilityMaskChangedKHR,
                lambda event: notify(
                    HeadsetEvent("visibility_mask_changed", EYES[event.view_index])
                ),
            ),
            kind.EVENT_DATA_EVENTS_LOST: (
                xr.EventDataEventsLost,
                lambda event: notify(HeadsetEvent("events_lost", str(event.lost_event_count))),
            ),
        }

    @property
    def state_name(self) -> str:
        """Return the session's state in OpenXR's word, in lower case."""
        name: str = self.state.name
        return name.lower()

    @property
    def seen(self) -> bool:
        """Return whether the participant sees the submitted frames."""
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

    def take_space_changes(self, time_ns: int) -> list[SpaceChange]:
        """Return, once, the changes of spaces that are in force at `time_ns`, in their order."""
        if not self._space_changes:
            return []
        due = [change for change in self._space_changes if change.time_ns <= time_ns]
        self._space_changes = [each for each in self._space_changes if each.time_ns > time_ns]
        return due

    def poll(self) -> None:
        """Handle the events that have arrived.

        Raises
        ------
        RuntimeLostError
            If the runtime says that it is going away.
        """
        event = self._event
        while True:
            ctypes.memmove(ctypes.byref(event), _NO_EVENT, len(_NO_EVENT))
            if self._poll_event(self._instance, event) != 0:
                return
            kind, handle = self._handlers.get(event.type, (None, None))
            if kind is not None and handle is not None:
                handle(ctypes.cast(ctypes.byref(event), ctypes.POINTER(kind)).contents)

    def _on_state(self, event: Any) -> None:
        was_focused, self.state = self.focused, State(event.state)
        self._notify(HeadsetEvent("session_state", self.state_name))
        if self.focused != was_focused:
            name, detail = ("focused", "") if self.focused else ("unfocused", OUT_OF_REACH)
            self._notify(HeadsetEvent(name, detail))
        if self.state == State.READY:
            watched(xr.begin_session, self._session, xr.SessionBeginInfo(STEREO))
            self.running = True
        elif self.state == State.STOPPING:
            self.running = False
            self.user_present = None  # told anew when the session begins again
            watched(xr.end_session, self._session)
        elif self.state == State.EXITING:
            self.ended = True
        elif self.state == State.LOSS_PENDING:
            raise lost("it announced the loss of the session")

    def _on_instance_loss(self, _: Any) -> None:
        raise lost("it announced that it is going away")

    def _on_space_change(self, event: Any) -> None:
        space = xr.ReferenceSpaceType(event.reference_space_type).name.lower()
        pose = pose_from_xr(event.pose_in_previous_space) if event.pose_valid else None
        self._space_changes.append(SpaceChange(space, int(event.change_time), pose))

    def _on_refresh_rate(self, event: Any) -> None:
        before_hz, now_hz = event.from_display_refresh_rate, event.to_display_refresh_rate
        self.refresh_period.take_rate(float(before_hz), float(now_hz))

    def _on_presence(self, event: Any) -> None:
        self.user_present = bool(event.is_user_present)
        name, detail = ("headset_on", "") if self.user_present else ("headset_off", TAKEN_OFF)
        self._notify(HeadsetEvent(name, detail))


class Presence:
    """Waits, up to a limit, for a participant after the headset was taken off.

    Parameters
    ----------
    lifecycle
        Of the session.
    patience_s
        How long nobody may look before the session is given up.
    notify
        Called when a controller is lost and found.

    Attributes
    ----------
    away
        Whether the participant sees nothing of the present frame.
    leaving
        Whether the session is being ended: a frame that is seen then earns no more patience.
    """

    def __init__(
        self, lifecycle: Lifecycle, patience_s: float, notify: Callable[[HeadsetEvent], None]
    ) -> None:
        self._lifecycle = lifecycle
        self._patience_s = patience_s
        self._notify = notify
        self._held = [True, True]
        self._absent_since_ns: int | None = None
        self.away = self.leaving = False
        self.allow(0.0)

    def allow(self, absence_s: float) -> None:
        """Wait for an absence of this duration, and the usual patience after it."""
        self.until(absence_s + self._patience_s)

    def until(self, duration_s: float) -> None:
        """Set the patience to a duration from now."""
        self._until_s = time.monotonic() + duration_s

    def wait(self) -> bool:
        """Wait until frames are wanted; return False where the session has ended.

        Raises
        ------
        RuntimeLostError
            If the headset sleeps on when patience is over.
        """
        running = self._lifecycle.wait_until_running(self._until_s - time.monotonic())
        if not running and not self._lifecycle.ended:
            raise asleep(self._patience_s)
        return running

    def update(
        self,
        inputs: Inputs,
        time_ns: int = 0,
        *,
        located: bool = True,
        rendered: bool = True,
        reached: bool = True,
    ) -> bool:
        """Take note of a frame; return True where the participant comes back with it.

        Parameters
        ----------
        time_ns
            Its display time.
        located
            Whether the head has ever been found: nothing is shown before.
        rendered
            Whether the runtime wants a picture: nothing is seen without.
        reached
            Whether the controllers are the session's, and not those of the runtime's menu.

        Raises
        ------
        RuntimeLostError
            If they have seen nothing until patience is over.
        """
        present = self._lifecycle.user_present is not False
        if present:
            self._absent_since_ns = None
        elif self._absent_since_ns is None:
            self._absent_since_ns = time_ns
        since_ns = time_ns if self._absent_since_ns is None else self._absent_since_ns
        taken_off = time_ns - since_ns >= ABSENT_NS
        before, self.away = self.away, taken_off or not (self._lifecycle.seen and located)
        if rendered and present and not self.away:
            if not self.leaving:
                self.allow(0.0)
        elif time.monotonic() > self._until_s:
            raise asleep(self._patience_s)
        if self._lifecycle.focused and reached:
            self._notice(inputs)
        return before and not self.away

    def _notice(self, inputs: Inputs) -> None:
        for number, hand in enumerate(inputs.hands):
            held = hand.aim is not None
            if held != self._held[number]:
                name = "controller_found" if held else "controller_lost"
                self._notify(HeadsetEvent(name, HANDS[number]))
            self._held[number] = held
