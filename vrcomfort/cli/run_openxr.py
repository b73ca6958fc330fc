"""A session in an OpenXR headset, or a rehearsal of one with a Monado runtime of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any
from typing import Protocol as Shape

from vrcomfort.cli.openxr_bindings import require_bindings
from vrcomfort.cli.playback import describe_machine, open_trace
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.settings_file import read_text

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.geometry import Pose
    from vrcomfort.headset.base import Headset
    from vrcomfort.headset.mirror import Mirror
    from vrcomfort.headset.window import Window
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent import Respondent
    from vrcomfort.respondent.panel import PanelRespondent
    from vrcomfort.scene.floors import Floors
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.session.rehearsal import Rehearsal

    class LiveHeadset(Headset, Shape):
        """A headset on somebody's head, or a window before them."""

        def place(self, *, spawn: Pose, floors: Floors | None = None) -> None:
            """Put the participant on `spawn`."""


@dataclass(frozen=True)
class LiveLab:
    """What a session in a headset needs.

    Parameters
    ----------
    panel, screen
        A respondent who answers in the headset, and where the questions stand.
    """

    headset: LiveHeadset
    renderer: StereoRenderer
    panel: Respondent
    screen: PanelScreen
    machine: Machine

    def headset_for(self, scene_name: str, scene: Any) -> LiveHeadset:
        """Lead the participant to the scene's starting point."""
        from vrcomfort.scene.floors import Floors

        del scene_name
        self.headset.place(spawn=scene.spawn, floors=Floors(scene.walkable))
        return self.headset


@contextmanager
def rehearse(trace: Path | None, answers: Path | None) -> Iterator[Rehearsal | None]:
    """Start a Monado runtime of our own where there is a trace; it is the active one meanwhile.

    Parameters
    ----------
    trace
        What its head follows: one sample per frame.
    answers
        What its controllers answer: whole numbers, in the order of the questions.

    Raises
    ------
    InputError
        If a file cannot be used, or there is no Monado.
    """
    if trace is None:
        if answers is not None:
            raise InputError("--monado-answers needs --monado-trace, the trace of the head")
        yield None
        return
    from vrcomfort.headset.monado import Monado
    from vrcomfort.session.rehearsal import Rehearsal

    head_trace = open_trace(trace)
    script = _read_answers(answers) if answers else []
    with Monado() as monado, monado.feed() as feed:
        heads = map(head_trace.head.pose, cycle(range(len(head_trace))))
        yield Rehearsal(feed, heads, iter(script))


def tracks_eyes() -> bool:
    """Ask the active OpenXR runtime whether its headset has an eye tracker.

    Raises
    ------
    InputError
        If there is no runtime, or no headset; says what to do.
    """
    require_bindings()
    from vrcomfort.headset.openxr.capabilities import find_headset

    return find_headset().gaze


@contextmanager
def live_lab(
    protocol: Protocol,
    *,
    size_px: tuple[int, int] | None = None,
    refresh_hz: float | None = None,
    rehearsal: Rehearsal | None = None,
    mirror: bool = False,
) -> Iterator[LiveLab]:
    """Connect to the active OpenXR runtime; everything is released at the end.

    Parameters
    ----------
    rehearsal
        Who moves the head and answers, where no person does.
    mirror
        Show the operator what the participant sees.

    Raises
    ------
    InputError
        If a part is missing; says what to do.
    """
    require_bindings()
    from vrcomfort.gpu.gl import create_context
    from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.session.panel_screen import PanelScreen

    with ExitStack() as owned:
        if mirror:
            window, ctx = open_mirror(owned)
        else:
            window, ctx = None, create_context()
            owned.callback(ctx.release)
        settings = OpenXrSettings(
            image_size_px=size_px,
            refresh_hz=refresh_hz,
            walking_speed_m_s=protocol.locomotion.walking_speed_m_s,
        )
        before_wait = rehearsal.before_frame if rehearsal else None
        headset = owned.enter_context(
            OpenXrHeadset(ctx, settings, before_wait=before_wait, window=window)
        )
        screen = PanelScreen(headset)
        renderer = StereoRenderer(
            ctx,
            headset.image_size_px,
            on_eye=lambda eye, images: headset.take_depth(eye, images.depth, images.camera.near_m),
        )
        owned.callback(renderer.release)
        machine = replace(
            describe_machine(renderer, protocol),
            runtime=headset.details["runtime"],
            timing_trust=headset.timing.trust,
        )
        person = _person(screen, rehearsal, keyboard=mirror)
        yield LiveLab(headset, renderer, person, screen, machine)


def open_window(
    owned: ExitStack, title: str, size_px: tuple[int, int], *, participant: bool = True
) -> tuple[Window, moderngl.Context]:
    """Open a window for a participant or an operator, and prepare its context for drawing."""
    try:
        from vrcomfort.headset.window import Window
    except ImportError as error:
        raise InputError(
            "windows need GLFW, which is not installed; pip install 'vrcomfort[desktop]'"
        ) from error
    from vrcomfort.gpu.gl import prepare

    window = Window(title, size_px, wait_for_display=participant, drag_turns=not participant)
    owned.enter_context(window)
    ctx = prepare(window.context())
    owned.callback(ctx.release)
    return window, ctx


def open_mirror(owned: ExitStack) -> tuple[Mirror, moderngl.Context]:
    """Open an operator's window; its context is to draw the frames."""
    title = "vrcomfort: what the participant sees"
    window, ctx = open_window(owned, title, (480, 600), participant=False)
    from vrcomfort.headset.mirror import Mirror

    return Mirror(ctx, window), ctx


def _read_answers(path: Path) -> list[int]:
    numbers = []
    for line, words in enumerate(read_text(path, "script of answers").splitlines(), start=1):
        for word in words.partition("#")[0].split():
            if not word.isdecimal():
                raise InputError(f"an answer is a whole number, not {word!r}", file=path, line=line)
            numbers.append(int(word))
    return numbers


def _person(screen: PanelScreen, rehearsal: Rehearsal | None, *, keyboard: bool) -> PanelRespondent:
    """Return whoever answers on the panel: a participant, or the script of a rehearsal."""
    from vrcomfort.respondent.panel import PanelRespondent

    if rehearsal is None:
        return PanelRespondent(screen, keyboard=keyboard)
    rehearsal.screen = screen
    watch, chose = rehearsal.watch, rehearsal.chose
    return PanelRespondent(screen, watch=watch, chose=chose, keyboard=keyboard)
