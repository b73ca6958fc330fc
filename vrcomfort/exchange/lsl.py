"""LabStreamingLayer: markers, ratings, head and gaze as streams that other programs record.

Needs `pylsl`, which brings the library (the extra `lsl`).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from typing import Any, Self

from vrcomfort.errors import InputError, pip_install
from vrcomfort.exchange.queued import Queued
from vrcomfort.frame import Frame
from vrcomfort.json_text import json_of
from vrcomfort.records import EventRow, RatingRow

HEAD = ("x", "y", "z", "qx", "qy", "qz", "qw", "valid")
GAZE = ("x", "y", "z", "dx", "dy", "dz", "valid")
_KINDS = {
    "markers": ("Markers", ("marker",)),
    "ratings": ("Ratings", ("rating",)),
    "head": ("MoCap", HEAD),
    "gaze": ("Gaze", GAZE),
}
"""Stream → its type, and its channels."""
_TRIES = 3
"""Of readings of two clocks the one that took the least time counts: others were interrupted."""
# As LSL's metadata of motion capture spells it; quaternions and directions have no unit.
_UNITS = {"x": "meters", "y": "meters", "z": "meters"}


class LslOutlet:
    """Sends a session's markers to LabStreamingLayer, from a thread of its own.

    Markers are JSON: ``{"name": "exposure_begins", "trial": 1, …}``. Head, gaze and that an
    exposure begins carry the time at which their frame is to be seen, where the headset tells it
    on the system's clock; everything else the time at which it was passed on.

    Parameters
    ----------
    study, participant
        Name the source, so that a recorder finds the streams again after a crash.

    Raises
    ------
    InputError
        If there is no pylsl, or no library that it can use.
    """

    def __init__(self, study: str, participant: str) -> None:
        self._lsl = _pylsl()
        self._outlets = {
            name: self._lsl.StreamOutlet(self._info(name, study, participant)) for name in _KINDS
        }
        self._queue = Queued("lsl")

    def now_s(self) -> float:
        """Return LabStreamingLayer's clock."""
        return float(self._lsl.local_clock())

    def mark(self, row: EventRow) -> None:
        """Send an event; its beginning is `onset_s` of the session."""
        content = {"name": row.name, "onset_s": row.onset_s, "duration_s": row.duration_s}
        self._mark({**content, "detail": row.detail}, self.now_s())

    def begin_exposure(self, trial: int, condition: str, monotonic_ns: int | None) -> None:
        """Send that an exposure begins, with the time at which its first frame is to be seen."""
        content = {"name": "exposure_begins", "trial": trial, "condition": condition}
        self._mark(content, self._seen_s(monotonic_ns))

    def end_exposure(self, trial: int) -> None:
        """Send that an exposure is over."""
        self._mark({"name": "exposure_ends", "trial": trial}, self.now_s())

    def rate(self, row: RatingRow) -> None:
        """Send a rating; a missed one is no number."""
        value = float("nan") if row.response is None else float(row.response)
        self._push("ratings", [value], self.now_s())

    def show(self, frame: Frame, monotonic_ns: int | None) -> None:
        """Send the head and, if it is known, the gaze of a frame, both in the stage."""
        at_s = self._seen_s(monotonic_ns)
        self._push("head", [*frame.head_pose.numbers, float(frame.head_valid)], at_s)
        if frame.gaze is None:
            return
        ray = [float("nan")] * 6
        if frame.gaze.valid:
            ray = [*frame.gaze.pose.numbers[:3], *frame.gaze.pose.forward.tolist()]
        self._push("gaze", [*ray, float(frame.gaze.valid)], at_s)

    def take_left_out(self) -> int:
        """Return how many samples could not be sent since the last call."""
        return self._queue.take_left_out()

    def close(self) -> None:
        """Send the waiting markers, and close the streams."""
        self._queue.close()
        self._outlets.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _seen_s(self, monotonic_ns: int | None) -> float:
        if monotonic_ns is None:
            return self.now_s()
        _, lsl_minus_monotonic_s = min(self._clocks() for _ in range(_TRIES))
        return monotonic_ns / 1e9 + lsl_minus_monotonic_s

    def _clocks(self) -> tuple[int, float]:
        """Read both clocks; return how many ns that took, and how far they are apart."""
        before_ns = time.monotonic_ns()
        lsl_s = self.now_s()
        took_ns = time.monotonic_ns() - before_ns
        return took_ns, lsl_s - (before_ns + took_ns / 2) / 1e9

    def _mark(self, content: dict[str, Any], at_s: float) -> None:
        self._push("markers", [json_of(content, indent=None)], at_s)

    def _push(self, name: str, sample: list[Any], at_s: float) -> None:
        self._queue.put(partial(self._outlets[name].push_sample, sample, at_s))

    def _info(self, name: str, study: str, participant: str) -> Any:
        """Describe a stream; frames come as they come, so none has a nominal rate."""
        kind, channels = _KINDS[name]
        form = self._lsl.cf_string if name == "markers" else self._lsl.cf_double64
        source = f"vrcomfort-{study}-{participant}-{name}"
        info = self._lsl.StreamInfo(
            f"vrcomfort {name}", kind, len(channels), self._lsl.IRREGULAR_RATE, form, source
        )
        _describe(info.desc(), channels, study, participant)
        return info


def _describe(desc: Any, channels: Sequence[str], study: str, participant: str) -> None:
    desc.append_child_value("study", study)
    desc.append_child_value("participant", participant)
    desc.append_child_value("frame", "OpenXR stage: right-handed, +Y up, metres; -Z is forward")
    listed = desc.append_child("channels")
    for label in channels:
        channel = listed.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", _UNITS.get(label, "none"))


def _pylsl() -> Any:
    try:
        import pylsl  # noqa: PLC0415 - it loads a library
    except (ImportError, RuntimeError, OSError) as error:
        reason = str(error).partition("\n")[0]
        message = f"LabStreamingLayer cannot be used ({reason}); {pip_install('pylsl')}"
        raise InputError(message) from error
    return pylsl
