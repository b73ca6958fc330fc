"""Whether the participant is there: sees the frames, and has controllers."""

from __future__ import annotations

import time
from collections.abc import Callable

from vrcomfort.frame import HeadsetEvent
from vrcomfort.headset.inputs import Inputs
from vrcomfort.headset.openxr.action_bindings import HANDS
from vrcomfort.headset.openxr.faults import asleep
from vrcomfort.headset.openxr.lifecycle import Lifecycle


class Presence:
    """Waits for a participant who has taken the headset off, but not for ever.

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
        self.away = self.leaving = False
        self.allow(0.0)

    def allow(self, absence_s: float) -> None:
        """Begin to be patient in so many seconds, not now."""
        self.until(absence_s + self._patience_s)

    def until(self, duration_s: float) -> None:
        """Be patient for so many seconds from now."""
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

    def update(self, inputs: Inputs, *, located: bool = True, rendered: bool = True) -> bool:
        """Take note of a frame; return True where the participant comes back with it.

        Parameters
        ----------
        located
            Whether the head has ever been found: nothing is shown before.
        rendered
            Whether the runtime wants a picture: nothing is seen without.

        Raises
        ------
        RuntimeLostError
            If they have seen nothing until patience is over.
        """
        before, self.away = self.away, not (self._lifecycle.seen and located)
        if rendered and not self.away:
            if not self.leaving:
                self.allow(0.0)
        elif time.monotonic() > self._until_s:
            raise asleep(self._patience_s)
        if self._lifecycle.focused:  # else the runtime's own menu has the controllers
            self._notice(inputs)
        return before and not self.away

    def _notice(self, inputs: Inputs) -> None:
        for number, hand in enumerate(inputs.hands):
            held = hand.aim is not None
            if held != self._held[number]:
                name = "controller_found" if held else "controller_lost"
                self._notify(HeadsetEvent(name, HANDS[number]))
            self._held[number] = held
