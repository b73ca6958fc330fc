"""Which headset a session is shown in, and which options mean something for it."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from vrcomfort.cli.study_setup import RespondentKind
from vrcomfort.errors import InputError


class HeadsetKind(StrEnum):
    """Headsets that a session can run on."""

    PLAYBACK = "playback"
    OPENXR = "openxr"
    DESKTOP = "desktop"


PLAYBACK, OPENXR, DESKTOP = HeadsetKind
MEANT_FOR: Mapping[str, tuple[HeadsetKind, ...]] = {
    "--trace": (PLAYBACK,),
    "--refresh-hz": (PLAYBACK, OPENXR),
    "--monado-trace": (OPENXR,),
    "--monado-answers": (OPENXR,),
    "--mirror": (OPENXR,),
    "--one-eye": (DESKTOP,),
    "--respondent panel": (OPENXR, DESKTOP),
}


def usual_respondent(headset: HeadsetKind, *, with_console: bool = False) -> RespondentKind:
    """Return who answers where nothing is said: the panel in a headset, else an experimenter."""
    if headset is not PLAYBACK:
        return RespondentKind.PANEL
    return RespondentKind.CONSOLE if with_console else RespondentKind.TERMINAL


def require_meaning(
    headset: HeadsetKind, respondent: RespondentKind | None, options: Mapping[str, object]
) -> None:
    """Refuse options that mean nothing for a headset.

    Parameters
    ----------
    options
        Option → what was given; None or False where it was not.

    Raises
    ------
    InputError
        Names the first of them, and the headsets that it is for.
    """
    given = [name for name, value in options.items() if value not in {None, False}]
    if respondent is not None:
        given.append(f"--respondent {respondent}")
    for name in given:
        headsets = MEANT_FOR.get(name, tuple(HeadsetKind))
        if headset not in headsets:
            places = " or ".join(f"--headset {each}" for each in headsets)
            raise InputError(f"{name} is for {places}; leave it out with --headset {headset}")


def require_console(kind: RespondentKind, *, with_console: bool) -> None:
    """Refuse a console without its packages, and answers on one that is not asked for.

    Raises
    ------
    InputError
        Says what to type.
    """
    if kind is RespondentKind.CONSOLE and not with_console:
        raise InputError("--respondent console needs --console, where answers are entered")
