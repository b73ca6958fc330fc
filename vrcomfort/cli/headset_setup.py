"""Headsets of a session: OpenXR, a desktop window, a rehearsal in Monado."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.api.playback import open_trace
from vrcomfort.api.rendering import describe_machine
from vrcomfort.api.study_setup import HeadsetSetup
from vrcomfort.cli.terminal import ask_to_type, warn
from vrcomfort.errors import InputError, pip_install
from vrcomfort.files import read_text
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.viewing import Answering

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.headset.desktop import DesktopSettings
    from vrcomfort.headset.watchdog import Watchdog
    from vrcomfort.headset.window import Mirror, Window
    from vrcomfort.respondent.panel import PanelRespondent
    from vrcomfort.respondent.panel_input import LookDown
    from vrcomfort.session.panel_screen import PanelScreen
    from vrcomfort.session.rehearsal import Rehearsal


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


# A session in a window, and windows that mirror a headset.


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
    settings = _desktop_settings(protocol, size_px, one_eye)
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


def _desktop_settings(
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


# A rehearsal of a session, in a Monado runtime of its own.


@contextmanager
def rehearse(
    trace: Path | None, answers: Path | None, watchdog: Watchdog | None = None
) -> Iterator[Rehearsal | None]:
    """Start a Monado runtime of our own where there is a trace; it is the active one meanwhile.

    Parameters
    ----------
    trace
        What its head follows: one sample per frame.
    answers
        What its controllers answer: whole numbers, in the order of the questions.
    watchdog
        Ends the runtime, too, where it must end the program.

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

    head_trace = open_trace(trace, note=warn)
    script = _read_answers(answers) if answers else []
    with Monado() as monado, monado.feed() as feed:
        if watchdog is not None:
            watchdog.last_acts += [monado.kill, monado.stop]
        heads = map(head_trace.head.pose, cycle(range(len(head_trace))))
        yield Rehearsal(feed, heads, iter(script))


def _read_answers(path: Path) -> list[int]:
    numbers = []
    for line, words in enumerate(read_text(path, "script of answers").split("\n"), start=1):
        for word in words.partition("#")[0].split():
            if not word.isdecimal():
                raise InputError(f"an answer is a whole number, not {word!r}", file=path, line=line)
            numbers.append(int(word))
    return numbers


# The OpenXR bindings.


REQUIREMENT = "pyopenxr>=1.1.6301,<1.1.6302"
"""As in pyproject.toml: eye trackers fail with 1.1.5301; later ones need a debug C runtime."""
_DEBUG_SINCE = (1, 1, 6302)
_REDISTRIBUTABLE = "https://aka.ms/vs/17/release/vc_redist.x64.exe"


def require_bindings() -> str:
    """Return the version of pyopenxr.

    Raises
    ------
    InputError
        If it, or the OpenXR loader that it brings, is missing.
    """
    try:
        from xr.version import PYOPENXR_VERSION
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] == "xr":
            raise InputError(
                f"the OpenXR bindings are not installed; {pip_install(REQUIREMENT)}"
            ) from error
        raise _not_loaded(error) from error
    except (ImportError, AttributeError) as error:  # as PyOpenGL says that a library is missing
        raise _not_loaded(error) from error
    except OSError as error:
        message = f"a library of the OpenXR bindings cannot be loaded ({error})"
        raise InputError(f"{message}; {_library_remedy()}") from error
    return str(PYOPENXR_VERSION)


def _library_remedy() -> str:
    if sys.platform == "win32":
        if (installed := _installed_version()) >= _DEBUG_SINCE:
            release = ".".join(map(str, installed))
            needs = f"pyopenxr {release} needs a debug C runtime on Windows"
            return f"{needs}; install another version: {pip_install(REQUIREMENT)}"
        return f"install the Microsoft Visual C++ Redistributable: {_REDISTRIBUTABLE}"
    return f"reinstall the bindings that bring it: {pip_install(REQUIREMENT, again=True)}"


def _installed_version() -> tuple[int, ...]:
    try:
        release = version("pyopenxr")
    except PackageNotFoundError:
        return ()
    return tuple(int(part) for part in release.split(".") if part.isdecimal())


def _not_loaded(error: Exception) -> InputError:
    return InputError(
        f"the OpenXR bindings cannot be loaded ({error}); install the graphics libraries (on "
        "Debian or Ubuntu 'apt-get install libgl1 libegl1', elsewhere your graphics driver) and "
        f"the bindings: {pip_install(REQUIREMENT, 'PyOpenGL', again=True)}"
    )


# A session in an OpenXR headset, or a rehearsal of one with a Monado runtime of its own.


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
    from vrcomfort.gpu.timer import TIME_PARTS_EVERY
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
            depth=protocol.headset.depth,
            walking_speed_m_s=protocol.locomotion.walking_speed_m_s,
            turning_deg_s=protocol.locomotion.turning_deg_s,
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
            on_eye=lambda eye, images: headset.take_depth(
                eye, images.headset_depth, images.camera.near_m
            ),
            headset_depth=headset.details["depth"],
            hash_every=HASH_EVERY,
            time_parts_every=TIME_PARTS_EVERY,
            photodiode=protocol.photodiode,
            finds_hits=True,
            hidden=headset.hidden_areas,
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
    from vrcomfort.headset.window import Mirror

    return Mirror(ctx, window), ctx


def look_down_of(wish: Answering) -> LookDown | None:
    """Return how a look asks to stop an exposure; None where the protocol wants none."""
    from vrcomfort.respondent.panel_input import LookDown

    return LookDown(wish.stop_down_deg, wish.stop_down_s) if wish.stop_by_looks else None


def _person(
    protocol: Protocol, screen: PanelScreen, rehearsal: Rehearsal | None, *, keyboard: bool
) -> PanelRespondent:
    """Return the panel's respondent: a participant, or the script of a rehearsal."""
    from vrcomfort.respondent.keyboard import YES
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
        waiting_line=cycle(("", YES)).__next__,  # says nothing, and goes on
        keyboard=keyboard,
        dwell_s=dwell_s,
        words=protocol.words,
    )
