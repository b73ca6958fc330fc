"""What every headset gives and takes: frames with poses, and images."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from vrcomfort.frame import Frame, HeadsetEvent

if TYPE_CHECKING:
    import moderngl


class Headset(Protocol):
    """A headset, a playback of one, or a window that stands in for one."""

    @property
    def name(self) -> str:
        """Return what the manifest calls this headset."""

    @property
    def refresh_hz(self) -> float:
        """Return the display's refresh rate."""

    @property
    def image_size_px(self) -> tuple[int, int]:
        """Return (width, height) of one eye's image."""

    @property
    def details(self) -> dict[str, Any]:
        """Return what else the manifest should know: runtime, tracked space, image format ..."""

    def frames(self) -> Iterator[Frame]:
        """Yield frames until the headset (or its trace) ends; each must be submitted."""

    def submit(self, frame: Frame, eyes: tuple[moderngl.Texture, moderngl.Texture] | None) -> None:
        """Show the two images (linear sRGB already tone-mapped, RGBA8), or nothing for `None`."""

    def take_events(self) -> list[HeadsetEvent]:
        """Return what happened since the last call: taken off, tracking lost, recentered ..."""


@runtime_checkable
class TellsTime(Protocol):
    """A headset whose display times can be put on the system's clock."""

    def display_now_ns(self) -> int | None:
        """Return the present moment as a display time; None where it is not known."""
