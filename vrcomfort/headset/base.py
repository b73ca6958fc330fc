"""The interface of all headsets, and the capabilities that some of them have."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from vrcomfort.frame import Frame, FrameWaits, HeadsetEvent
from vrcomfort.headset.inputs import Inputs

if TYPE_CHECKING:
    import moderngl


class Headset(Protocol):
    """A headset, a playback of one, or a window that stands in for one."""

    @property
    def name(self) -> str:
        """Return the headset's name for the manifest."""

    @property
    def refresh_hz(self) -> float:
        """Return the display's refresh rate."""

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image."""

    @property
    def details(self) -> dict[str, Any]:
        """Return further facts for the manifest: runtime, tracked space, image format ..."""

    def frames(self) -> Iterator[Frame]:
        """Yield frames until the headset (or its trace) ends; each must be submitted."""

    def submit(self, frame: Frame, eyes: tuple[moderngl.Texture, moderngl.Texture] | None) -> None:
        """Show the two images (linear sRGB already tone-mapped, RGBA8), or nothing for `None`."""

    def take_events(self) -> list[HeadsetEvent]:
        """Return the events since the last call: taken off, tracking lost, recentered ..."""


# Capabilities that only some headsets have; a session asks for each with `isinstance`.


@runtime_checkable
class HasDisplayClock(Protocol):
    """A headset with display times that can be converted to the system's clock."""

    def display_now_ns(self) -> int | None:
        """Return the present moment as a display time; None where it is not known."""


@runtime_checkable
class HasWaits(Protocol):
    """A headset with a runtime that makes frames wait."""

    def waits(self) -> FrameWaits:
        """Return the waits of the frame that was submitted last."""


@runtime_checkable
class CanSleep(Protocol):
    """A headset that shows nothing while it is not worn."""

    def wake(self, timeout_s: float) -> bool:
        """Wait until the headset wants frames; return False where it sleeps on."""


@runtime_checkable
class HasInputs(Protocol):
    """A headset with controllers, tracked hands, an eye tracker or keys."""

    def inputs(self) -> Inputs:
        """Return the inputs of hands, eyes and keys in the last frame."""


@runtime_checkable
class HasHaptics(Protocol):
    """A headset with controllers that vibrate."""

    def tick(self, hand: int) -> None:
        """Let a controller tick (0 left, 1 right)."""


@runtime_checkable
class HasArrowKeys(Protocol):
    """A headset with a window: its arrow keys walk unless something else takes them."""

    arrows_turn: bool
    """Whether the arrow keys turn a dial."""


@runtime_checkable
class CanRecenter(Protocol):
    """A headset with a forward direction that can be set anew."""

    def recenter(self) -> None:
        """Make the floor point and heading of the head the origin."""
