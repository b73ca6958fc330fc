"""A session in an OpenXR headset, or a rehearsal of one with a Monado runtime of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from itertools import cycle
from typing import TYPE_CHECKING

from vrcomfort.cli.headset_setup import HeadsetSetup, open_window
from vrcomfort.cli.openxr_bindings import require_bindings
from vrcomfort.cli.renderer import describe_machine
from vrcomfort.cli.terminal import ask_to_type
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.viewing import Answering

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.headset.mirror import Mirror
    from vrcomfort.headset.watchdog import Watchdog
    from vrcomfort.respondent.dwell import LookDown
    from vrcomfort.respondent.panel import PanelRespondent
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.session.rehearsal import Rehearsal


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
def openxr_setup(
    protocol: Protocol,
    *,
    size_px: tuple[int, int] | None = None,
    refresh_hz: float | None = None,
    rehearsal: Rehearsal | None = None,
    mirror: bool = False,
    watchdog: Watchdog | None = None,
) -> Iterator[HeadsetSetup]:
    """Connect to the active OpenXR runtime; everything is released at the end.

    Parameters
    ----------
    rehearsal
        Who moves the head and answers, where no person does.
    mirror
        Show the operator what the participant sees.
    watchdog
        Of the runtime.

    Raises
    ------
    InputError
        If a part is missing; says what to do.
    """
    require_bindings()
    from vrcomfort.gpu.gl import create_context
    from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
    from vrcomfort.render.display import HASH_EVERY
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.respondent.panel_layout import SIZE_PX
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
            snap_turn_deg=protocol.locomotion.snap_turn_deg,
            teleport_m=protocol.locomotion.step_at_once_m,
        )
        before_wait = rehearsal.before_frame if rehearsal else None
        headset = owned.enter_context(
            OpenXrHeadset(ctx, settings, before_wait=before_wait, window=window)
        )
        headset.prepare_panel(SIZE_PX)
        screen = PanelScreen(
            headset, words=protocol.words, points_with_head=protocol.answering.head
        )
        renderer = StereoRenderer(
            ctx,
            headset.image_size_px,
            on_eye=lambda eye, images: headset.take_depth(eye, images.depth, images.camera.near_m),
            hash_every=HASH_EVERY,
            photodiode=protocol.photodiode,
            finds_hits=True,
        )
        owned.callback(renderer.release)
        machine = replace(
            describe_machine(renderer, protocol),
            runtime=headset.details["runtime"],
            timing_trust=headset.timing.trust,
        )
        person = _person(protocol, screen, rehearsal, keyboard=mirror)
        yield HeadsetSetup(headset, renderer, person, screen, machine, watchdog)


def open_mirror(owned: ExitStack) -> tuple[Mirror, moderngl.Context]:
    """Open an operator's window; its context is to draw the frames."""
    title = "vrcomfort: what the participant sees"
    window, ctx = open_window(owned, title, (480, 600), participant=False)
    from vrcomfort.headset.mirror import Mirror

    return Mirror(ctx, window), ctx


def look_down_of(wish: Answering) -> LookDown | None:
    """Return how a look asks to stop an exposure; None where the protocol wants none."""
    from vrcomfort.respondent.dwell import LookDown

    return LookDown(wish.stop_down_deg, wish.stop_down_s) if wish.stop_by_looks else None


def _person(
    protocol: Protocol, screen: PanelScreen, rehearsal: Rehearsal | None, *, keyboard: bool
) -> PanelRespondent:
    """Return whoever answers on the panel: a participant, or the script of a rehearsal."""
    from vrcomfort.respondent import keys
    from vrcomfort.respondent.panel import PanelRespondent

    dwell_s = protocol.answering.dwell_s
    if rehearsal is None:
        return PanelRespondent(
            screen,
            keyboard=keyboard,
            dwell_s=dwell_s,
            look_down=look_down_of(protocol.answering),
            words=protocol.words,
            prompt=ask_to_type,
        )
    rehearsal.screen = screen
    return PanelRespondent(
        screen,
        watch=rehearsal.watch,
        chose=rehearsal.chose,
        waiting_line=cycle(("", keys.YES)).__next__,  # says nothing, and goes on
        keyboard=keyboard,
        dwell_s=dwell_s,
        words=protocol.words,
    )
