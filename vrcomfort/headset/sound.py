"""Sounds for participants: read from WAV files, and played by the system's sound device.

Playing needs `miniaudio` (the extra `sound`), which has its own thread.
"""

from __future__ import annotations

import io
import os
import sys
import wave
from collections.abc import Generator, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, Self

from vrcomfort.errors import InputError, pip_install
from vrcomfort.files import read_bytes

LONGEST_S = 600.0
_RATE_HZ, _CHANNELS, _SAMPLE_BYTES = 48_000, 2, 2


@dataclass(frozen=True)
class Sound:
    """A WAV file as it was read.

    Parameters
    ----------
    content
        The whole file.
    """

    name: str
    duration_s: float
    content: bytes = field(repr=False)


def read_sound(file: Path) -> Sound:
    """Return a WAV file of at most ten minutes.

    Raises
    ------
    InputError
        If it cannot be read, is no WAV file of whole numbers, or is too long.
    """
    try:
        content = read_bytes(file)
        with wave.open(io.BytesIO(content)) as opened:
            frames, rate_hz, width = (
                opened.getnframes(),
                opened.getframerate(),
                opened.getsampwidth(),
            )
            there = len(opened.readframes(frames)) // (width * opened.getnchannels())
    except OSError as error:
        message = f"this sound cannot be read: {error.strerror or error}"
        raise InputError(message, file=file) from error
    except (wave.Error, EOFError) as error:
        message = f"this sound cannot be played ({error}); save it as WAV with 16-bit PCM"
        raise InputError(message, file=file) from error
    if there < frames or not frames or not rate_hz:
        message = "this WAV file is cut off or empty; save it again"
        raise InputError(message, file=file)
    if frames / rate_hz > LONGEST_S:
        message = f"this sound lasts {frames / rate_hz / 60:.1f} minutes, and instructions at most"
        raise InputError(f"{message} {LONGEST_S / 60:g}; shorten it", file=file)
    return Sound(file.name, frames / rate_hz, content)


class Speaker(Protocol):
    """Plays one sound at a time, without waiting for it."""

    def play(self, sound: Sound) -> None:
        """Begin to play."""

    def stop(self) -> None:
        """Play no more."""


class SilentSpeaker:
    """Plays nothing: simulated participants know how long a sound is."""

    def play(self, sound: Sound) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""


class SystemSpeaker:
    """The system's usual sound device; open from making to `close`.

    Parameters
    ----------
    backends
        Of miniaudio, for tests; without it, all that are heard.

    Raises
    ------
    InputError
        If there is no device, or the library is missing.
    """

    def __init__(self, backends: list[Any] | None = None) -> None:
        try:
            import miniaudio  # noqa: PLC0415 - only studies with sounds need it
        except ImportError as error:
            message = "sounds need miniaudio, which is not installed"
            raise InputError(f"{message}; {pip_install('miniaudio')}") from error
        self._library = miniaudio
        unheard = miniaudio.Backend.NULL, miniaudio.Backend.CUSTOM
        heard = [each for each in miniaudio.Backend if each not in unheard]
        try:
            with _no_chatter():
                self._device = miniaudio.PlaybackDevice(
                    nchannels=_CHANNELS, sample_rate=_RATE_HZ, backends=backends or heard
                )
        except miniaudio.MiniaudioError as error:
            message = "there is no sound device; plug in headphones, or switch the headset's on"
            raise InputError(message) from error
        self._samples: dict[Sound, bytes] = {}

    def __enter__(self) -> Self:
        """Return it, open."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the device."""
        self.close()

    def prepare(self, sound: Sound) -> None:
        """Decode a sound now, so that `play` begins at once.

        Raises
        ------
        InputError
            If it is a kind of WAV that cannot be played.
        """
        try:
            decoded = self._library.decode(sound.content, nchannels=_CHANNELS, sample_rate=_RATE_HZ)
        except self._library.MiniaudioError as error:
            message = f"{sound.name} cannot be played; save it as WAV with 16-bit PCM"
            raise InputError(message) from error
        self._samples[sound] = decoded.samples.tobytes()

    def play(self, sound: Sound) -> None:
        """Begin to play a sound from its beginning, in place of one that plays."""
        self.stop()
        if sound not in self._samples:
            self.prepare(sound)
        stream = _chunks(self._samples[sound])
        next(stream)
        self._device.start(stream)

    def stop(self) -> None:
        """Play no more."""
        if self._device.running:
            self._device.stop()

    def close(self) -> None:
        """Give the device back."""
        with suppress(self._library.MiniaudioError):
            self.stop()
        self._device.close()


def _chunks(samples: bytes) -> Generator[bytes, int, None]:
    """Yield as many frames as are asked for; then silence, until the device is stopped."""
    frame_bytes = _CHANNELS * _SAMPLE_BYTES
    at = 0
    wanted = yield b""
    while True:
        chunk = samples[at : at + wanted * frame_bytes]
        at += len(chunk)
        wanted = yield chunk.ljust(wanted * frame_bytes, b"\0")


@contextmanager
def _no_chatter() -> Iterator[None]:
    """Keep messages of ALSA's library about missing devices off the terminal."""
    if sys.platform != "linux":
        yield
        return
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
