"""The sound device of a session whose instructions are heard."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import warn
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol

if TYPE_CHECKING:
    from vrcomfort.headset.sound import SystemSpeaker


@contextmanager
def open_speaker(protocol: Protocol) -> Iterator[SystemSpeaker | None]:
    """Open the sound device, where the protocol needs one; None where texts stand in for it.

    Raises
    ------
    InputError
        If there is none, and an instruction has nothing but its sound.
    """
    heard = [each for each in protocol.told if each.sound]
    if not heard:
        yield None
        return
    from vrcomfort.headset.sound import SystemSpeaker
    from vrcomfort.session.instructor import sounds_of

    try:
        speaker = SystemSpeaker()
    except InputError as error:
        alone = [each.name for each in heard if not each.text]
        if alone:
            message = f"{error.message}; or give instruction `{alone[0]}` a text to be read instead"
            raise InputError(message, file=protocol.file) from error
        names = ", ".join(each.name for each in heard)
        warn(f"{error.message}; until then texts stand in for the sounds of {names}")
        speaker = None
    if speaker is None:
        yield None
        return
    with speaker:
        for sound in sounds_of(protocol).values():
            speaker.prepare(sound)
        yield speaker
