"""What a session in a headset, or in a window, needs."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from typing import Protocol as Shape

from vrcomfort.errors import InputError, pip_install

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.geometry import Pose
    from vrcomfort.headset.base import Headset
    from vrcomfort.headset.watchdog import Watchdog
    from vrcomfort.headset.window import Window
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent import Respondent
    from vrcomfort.scene.floors import Floors
    from vrcomfort.session.panel_screen import PanelScreen

    class LiveHeadset(Headset, Shape):
        """A headset on somebody's head, or a window before them."""

        def place(self, *, spawn: Pose, floors: Floors | None = None, on_foot: bool = True) -> None:
            """Put the participant on `spawn`."""


@dataclass(frozen=True)
class HeadsetSetup:
    """What a session in a headset needs.

    Parameters
    ----------
    panel, screen
        A respondent who answers in the headset, and where the questions stand.
    watchdog
        Of the headset's runtime, where it has one.
    """

    headset: LiveHeadset
    renderer: StereoRenderer
    panel: Respondent
    screen: PanelScreen
    machine: Machine
    watchdog: Watchdog | None = None

    def headset_for(self, scene_name: str, scene: Any) -> LiveHeadset:
        """Lead the participant to the scene's starting point."""
        from vrcomfort.scene.floors import Floors

        del scene_name
        self.headset.place(spawn=scene.spawn, floors=Floors(scene.walkable), on_foot=scene.on_foot)
        return self.headset


def open_window(
    owned: ExitStack, title: str, size_px: tuple[int, int], *, participant: bool = True
) -> tuple[Window, moderngl.Context]:
    """Open a window for a participant or an operator, and prepare its context for drawing."""
    try:
        from vrcomfort.headset.window import Window
    except ImportError as error:
        message = "windows need GLFW, which is not installed"
        raise InputError(f"{message}; {pip_install('glfw')}") from error
    from vrcomfort.gpu.gl import prepare

    window = Window(title, size_px, wait_for_display=participant, drag_turns=not participant)
    owned.enter_context(window)
    ctx = prepare(window.context())
    owned.callback(ctx.release)
    return window, ctx
