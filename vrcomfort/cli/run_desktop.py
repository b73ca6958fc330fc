"""A session in a window, and windows that mirror a headset."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from vrcomfort.cli.headset_setup import HeadsetSetup, open_window
from vrcomfort.cli.renderer import describe_machine
from vrcomfort.cli.terminal import ask_to_type
from vrcomfort.protocol import Protocol

if TYPE_CHECKING:
    from vrcomfort.headset.desktop import DesktopSettings


@contextmanager
def desktop_setup(
    protocol: Protocol, *, size_px: tuple[int, int] | None = None, one_eye: bool = False
) -> Iterator[HeadsetSetup]:
    """Open a window for a participant; everything is released at the end.

    Parameters
    ----------
    size_px
        (width, height) of one eye's image.
    one_eye
        Show the left eye's image alone.

    Raises
    ------
    InputError
        If no window can be had; says what to do.
    """
    settings = _settings(protocol, size_px, one_eye)
    with ExitStack() as owned:
        window, ctx = open_window(owned, "vrcomfort", settings.window_size_px)
        from vrcomfort.headset.desktop import DesktopHeadset
        from vrcomfort.render.display import HASH_EVERY
        from vrcomfort.render.pipeline import StereoRenderer
        from vrcomfort.respondent.panel import PanelRespondent
        from vrcomfort.session.panel_screen import PanelScreen

        headset = DesktopHeadset(ctx, window, settings)
        size, eyes = settings.image_size_px, settings.columns
        renderer = StereoRenderer(
            ctx, size, eyes=eyes, hash_every=HASH_EVERY, photodiode=protocol.photodiode
        )
        owned.callback(renderer.release)
        machine = replace(
            describe_machine(renderer, protocol),
            runtime="desktop window",
            timing_trust="low: a window's frames pass through the desktop's compositor",
        )
        screen = PanelScreen(headset, words=protocol.words)
        panel = PanelRespondent(screen, keyboard=True, words=protocol.words, prompt=ask_to_type)
        yield HeadsetSetup(headset, renderer, panel, screen, machine)


def _settings(
    protocol: Protocol, size_px: tuple[int, int] | None, one_eye: bool
) -> DesktopSettings:
    from vrcomfort.headset.desktop import DesktopSettings

    given = DesktopSettings(
        layout="one_eye" if one_eye else "side_by_side",
        ipd_m=protocol.headset.ipd_m,
        walking_speed_m_s=protocol.locomotion.walking_speed_m_s,
        teleport_m=protocol.locomotion.step_at_once_m,
    )
    return given if size_px is None else replace(given, image_size_px=size_px)
