"""TTL triggers over a serial port: one byte when an exposure begins and ends.

Needs `pyserial` (the extra `ttl`).
"""

from __future__ import annotations

from functools import partial
from typing import Any, Self

from vrcomfort.errors import InputError, pip_install
from vrcomfort.exchange.queued import Queued
from vrcomfort.frame import Frame
from vrcomfort.records import EventRow, RatingRow

LAST_TRIAL = 126
"""What one byte can say of a trial and of its end."""
# The highest bit, so that a trial and its end differ in one line of the port.
END = 128


class TtlOutlet:
    """Writes to a serial port from a thread of its own.

    An exposure begins with its trial's number + 1 (training is 1, and trials from 126 on are 127),
    and ends with 128 more. The byte is written when the first frame has been submitted: when it is
    seen, a photodiode knows.

    Parameters
    ----------
    port
        Such as ``/dev/ttyUSB0`` or ``COM3``.
    baud
        Of the port.

    Raises
    ------
    InputError
        If there is no pyserial, or the port cannot be opened.
    """

    def __init__(self, port: str, *, baud: int = 115_200) -> None:
        self._port = _opened(port, baud)
        self._queue = Queued("ttl")

    def now_s(self) -> float | None:
        """Return None: a serial port has no clock."""
        return None

    def mark(self, row: EventRow) -> None:
        """Write nothing of an event."""

    def rate(self, row: RatingRow) -> None:
        """Write nothing of a rating."""

    def show(self, frame: Frame, monotonic_ns: int | None) -> None:
        """Write nothing of a frame."""

    def begin_exposure(self, trial: int, condition: str, monotonic_ns: int | None) -> None:
        """Write the byte of a trial that begins."""
        del condition, monotonic_ns
        self._write(byte_of(trial))

    def end_exposure(self, trial: int) -> None:
        """Write the byte of a trial that ends."""
        self._write(END + byte_of(trial))

    def take_left_out(self) -> int:
        """Return how many bytes could not be written since the last call."""
        return self._queue.take_left_out()

    def close(self) -> None:
        """Write the waiting bytes, and close the port."""
        self._queue.close()
        self._port.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _write(self, byte: int) -> None:
        self._queue.put(partial(self._port.write, bytes([byte])))


def byte_of(trial: int) -> int:
    """Return the byte that is written when a trial begins.

    >>> byte_of(0), byte_of(3), byte_of(400)
    (1, 4, 127)
    """
    return min(trial, LAST_TRIAL) + 1


def _opened(port: str, baud: int) -> Any:
    try:
        import serial  # noqa: PLC0415 - only who asks for it needs it
    except ImportError as error:
        raise InputError(f"TTL triggers need pyserial; {pip_install('pyserial')}") from error
    try:
        return serial.Serial(port, baud, write_timeout=1.0)
    except (serial.SerialException, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(f"the serial port {port} cannot be opened: {reason}") from error
