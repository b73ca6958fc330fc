"""The checks of a preflight, each declared once: its name, its moment and its function."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from vrcomfort.api.playback import require_eye_tracker, require_recorded_gaze
from vrcomfort.cli.doctor import (
    EXTRAS,
    Diagnosis,
    examine_openxr,
    find_extra,
    find_gpu,
    find_opengl,
)
from vrcomfort.cli.headset_setup import tracks_eyes
from vrcomfort.cli.run import OPENXR, PLAYBACK, RunOptions
from vrcomfort.cli.session_devices import open_outlets, open_speaker
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.load import missing_wording
from vrcomfort.protocol.model import trial_counts

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.api.timed_show import TimedShow

FRAME_BYTES = 2_500
"""Room for the rows of a frame: 820 in frames.csv, 1,340 of both hands, and those of the gaze."""
FLOOR_M = (0.7, 2.2)
"""Heights of a head over the floor, from a child's on a chair to a tall adult's."""
STANDING_ROOM_M = 1.0
"""Clear width and depth for somebody who stands and turns."""
LEAST_MARGIN_PERCENT = 15.0
"""Of a period; with less, a busier moment of the machine drops frames."""

Stage = Literal["machine", "runtime", "frames"]
"""Without a headset; before a session in it; after it has shown frames."""


@dataclass
class Preflight:
    """State of a preflight: a planned session, its protocol, and the facts found so far.

    Parameters
    ----------
    facts
        Of the headset, as a manifest has them.
    timing_trust
        As a manifest has it.
    shown
        The dearest condition, after it was shown; None where the headset sleeps.
    """

    run: RunOptions
    protocol: Protocol
    ctx: moderngl.Context | None = None
    facts: dict[str, Any] = field(default_factory=dict)
    timing_trust: str = ""
    shown: TimedShow | None = None

    @property
    def worn(self) -> bool:
        """Return whether a headset is worn: no playback, and no window."""
        return self.run.headset is OPENXR

    @property
    def headset_is_said(self) -> bool:
        """Return whether the protocol says which headset the study is for."""
        return "headset" in self.protocol.model_fields_set


class Check(NamedTuple):
    """One thing that is looked at, and when."""

    name: str
    looks_at: str
    stage: Stage
    find: Callable[[Preflight], Iterable[Diagnosis]]


def refuse(part: str, found: str, remedy: str) -> Diagnosis:
    """Return a finding that stands in the way."""
    return Diagnosis(part, False, found, remedy)


def _there(part: str, found: str) -> Diagnosis:
    return Diagnosis(part, True, found)


def _notice(part: str, found: str, remedy: str) -> Diagnosis:
    return Diagnosis(part, False, found, remedy, needed=False)


# Before a headset is connected: the protocol and the machine.


def _wording(flight: Preflight) -> Iterator[Diagnosis]:
    from vrcomfort.session.panel_wording import undrawable_wording

    protocol = flight.protocol
    languages = protocol.languages or (None,)
    spoken = [protocol.spoken(each) for each in languages]
    faults = list(missing_wording(protocol))
    if flight.run.headset is not PLAYBACK:
        drawn = {str(each): each for one in spoken for each in undrawable_wording(one)}
        faults += drawn.values()
    for fault in faults:
        yield refuse("wording", "people would not be asked what is meant", str(fault))
    if not faults:
        asked = ", ".join(
            dict.fromkeys(spoken[0].form(ask).short for ask in protocol.questionnaires)
        )
        yield _there("wording", f"every item of {asked}" if asked else "no questionnaires")


def _gpu(flight: Preflight) -> Iterator[Diagnosis]:
    finding, flight.ctx = find_opengl()
    yield finding
    if flight.ctx is not None:
        yield find_gpu(flight.ctx)


def _disk(flight: Preflight) -> Iterator[Diagnosis]:
    protocol, out = flight.protocol, flight.run.out
    there = next(each for each in (out, *out.absolute().parents) if each.exists())
    free = shutil.disk_usage(there).free
    sessions, trials = trial_counts(protocol)
    session = trials * protocol.longest_s * protocol.headset.refresh_hz * FRAME_BYTES
    study = session * sessions * (protocol.participants or 1)
    words = (
        f"{free / 1e9:.1f} GB free on {there}; about {max(session / 1e9, 0.001):.3g} GB a session"
    )
    if free < 2 * session:
        yield refuse("disk", words, "free some room, or choose another --out")
    elif free < study:
        needs = f"the study's {protocol.participants} participants need about {study / 1e9:.3g} GB"
        yield _notice("disk", words, f"{needs}; free some room, or move what is done")
    else:
        yield _there("disk", words)


def _clock(flight: Preflight) -> Iterator[Diagnosis]:
    from vrcomfort.records.study import now
    from vrcomfort.records.wall_clock import set_back_before

    out = flight.run.out
    for sentence in set_back_before(out, "") if out.is_dir() else ():
        yield _notice("clock", sentence, "set the machine's clock, by a time server if it has one")
        return
    yield _there("clock", f"{now()}, after all that the study has on record")


def _sound(flight: Preflight) -> Iterator[Diagnosis]:
    if not any(each.sound for each in flight.protocol.told):
        yield _there("sound", "no instruction is heard")
        return
    try:
        with open_speaker(flight.protocol) as speaker:
            told = "the sounds of instructions can be played" if speaker else "texts stand in"
            yield Diagnosis("sound", speaker is not None, told, needed=False)
    except InputError as error:
        yield refuse("sound", "no device", str(error))


def _outlets(flight: Preflight) -> Iterator[Diagnosis]:
    options = flight.run
    wanted = {"lsl": options.lsl, "ttl": options.ttl is not None}
    for extra in EXTRAS:
        if wanted.get(extra.name):
            finding = find_extra(extra)
            yield replace(finding, needed=True)
            if not finding.ok:
                return
    if not any(wanted.values()):
        yield _there("LSL", "not asked for (--lsl, --ttl)")
        return
    try:
        with open_outlets("preflight", "P", lsl=options.lsl, ttl=options.ttl, simulated=False):
            yield _there("LSL", "outlets open")
    except InputError as error:
        yield refuse("LSL", "an outlet does not open", str(error))


def _gaze(flight: Preflight) -> Iterator[Diagnosis]:
    """Look for an eye tracker where a condition needs one."""
    try:
        if flight.run.headset is PLAYBACK:
            trace = flight.run.playback(flight.protocol).trace
            require_recorded_gaze(flight.protocol.conditions, trace)
        else:
            require_eye_tracker(flight.protocol.conditions, lambda: flight.worn and tracks_eyes())
        yield _there("gaze", "all that the conditions need")
    except InputError as error:
        yield refuse("gaze", "a condition needs it", str(error))


# Before a session in the headset.


NEEDED_PARTS = {"OpenXR bindings", "OpenXR runtime", "headset"}
EYES = {"eye tracker", "each eye"}
"""Parts that are a notice only where a condition needs them: the check `gaze` says so."""


def _runtime(flight: Preflight) -> Iterator[Diagnosis]:
    """Examine the runtime as `doctor` does; a fault that would stop a session is refused."""
    if not flight.worn:
        yield _there("runtime", str(flight.run.headset))
        return
    for finding in examine_openxr(None, timing=False):
        if finding.part in EYES:
            yield _there(finding.part, finding.found)
        else:
            yield replace(finding, needed=finding.part in NEEDED_PARTS)


# After the dearest condition was shown for a time.


def _image_size(flight: Preflight) -> Iterator[Diagnosis]:
    wanted, shown = flight.protocol.headset.image_size_px, flight.facts["image_size_px"]
    words = "×".join(map(str, shown))
    if list(wanted) == list(shown) or not flight.headset_is_said:
        yield _there("image size", f"{words} pixels an eye")
    else:
        meant = "×".join(map(str, wanted))
        remedy = f"the protocol's [headset] says {meant}: give --size {meant.replace('×', 'x')}"
        yield _notice("image size", f"{words} pixels an eye", f"{remedy}, or mend the protocol")


def _refresh_rate(flight: Preflight) -> Iterator[Diagnosis]:
    rate_hz, meant_hz = flight.facts["refresh_hz"], flight.protocol.headset.refresh_hz
    words = f"{rate_hz:.4g} Hz" if rate_hz else "not told"
    differs = rate_hz and abs(rate_hz - meant_hz) > 0.5
    if flight.worn and differs and flight.headset_is_said:
        remedy = f"the protocol's [headset] says {meant_hz:g} Hz: give --refresh-hz {meant_hz:g}"
        yield _notice("refresh rate", words, f"{remedy}, or mend the protocol")
    else:
        yield _there("refresh rate", words)


def _room(flight: Preflight) -> Iterator[Diagnosis]:
    posture = flight.protocol.posture
    room = flight.facts.get("room", "not told")
    if not flight.worn or (posture is not None and posture.mode == "seated"):
        yield _there("room", "nobody walks")
        return
    if room == "not told":
        remedy = "draw the boundary (guardian, chaperone) in the headset's software, then again"
        yield _notice("room", "the runtime tells no boundary", remedy)
        return
    width_m, depth_m = (float(side.split()[0]) for side in room.split("×"))
    if min(width_m, depth_m) < STANDING_ROOM_M:
        remedy = f"clear at least {STANDING_ROOM_M:g} m × {STANDING_ROOM_M:g} m, and draw it again"
        yield _notice("room", room, remedy)
    else:
        yield _there("room", room)


def _rate_holds(flight: Preflight) -> Iterator[Diagnosis]:
    shown, part = flight.shown, "rate holds"
    if shown is None:
        yield _notice(part, "the headset sleeps", "put it on, or cover its sensor; then again")
        return
    facts, left = shown.facts(flight.protocol), shown.margin_percent
    words = (
        f"{shown.cost.words}, {facts['seconds']:.0f} s: {facts['frames']} frames, "
        f"{facts['dropped']} dropped; 99 % of them take {shown.busy_ms() or 0:.2f} ms or less, and "
        f"{left or 0:.0f} % of the period of {shown.period_ms:.2f} ms is left"
    )
    cheaper = "take a smaller --size, a lower --refresh-hz or a cheaper quality"
    why = "; ".join([*facts["flags"], f"{cheaper}; close other programs"])
    if shown.holds(flight.protocol) and (left is None or left >= LEAST_MARGIN_PERCENT):
        yield _there(part, words)
    elif shown.holds(flight.protocol):
        yield _notice(part, words, f"a busier moment of this machine drops frames: {cheaper}")
    elif flight.timing_trust == "runtime":
        yield refuse(part, words, why)
    else:
        yield _notice(part, words, f"no display was timed; {why}")


def _tracking(flight: Preflight) -> Iterator[Diagnosis]:
    shown = flight.shown
    if shown is None or not flight.worn:
        return
    timing = shown.timing
    lost = 100 * timing.untracked / max(timing.frames, 1)
    words = f"the head was not measured in {lost:.3g} % of the frames"
    if lost > flight.protocol.flag_above_percent.untracked:
        remedy = "light the room evenly, cover mirrors and windows, clean the cameras"
        yield _notice("tracking", words, remedy)
    else:
        yield _there("tracking", words)


def _floor(flight: Preflight) -> Iterator[Diagnosis]:
    shown = flight.shown
    if shown is None or not flight.worn or not shown.head_heights_m:
        return
    height_m = sorted(shown.head_heights_m)[len(shown.head_heights_m) // 2]
    space = flight.facts.get("space", "")
    words = f"the head is {height_m:.2f} m over it (space {space})"
    if space == "local":
        remedy = "the runtime does not know the floor: a height of the eyes is assumed; set it up"
        yield _notice("floor", words, remedy)
    elif not FLOOR_M[0] <= height_m <= FLOOR_M[1]:
        remedy = "put the headset on; if it was, set the floor in its software, and recentre"
        yield _notice("floor", words, remedy)
    else:
        yield _there("floor", words)


def _ipd(flight: Preflight) -> Iterator[Diagnosis]:
    shown_m, limits = flight.facts.get("ipd_m"), flight.protocol.headset.ipd_range_m
    words = "not told" if shown_m is None else f"{1000 * shown_m:.1f} mm shown"
    if limits is not None:
        words += f"; people from {1000 * limits[0]:g} to {1000 * limits[1]:g} mm can be fitted"
        yield _there("IPD", words)
    elif flight.worn:
        remedy = (
            "write `ipd_range_m` into the protocol's [headset]: `run --ipd-mm` compares with it"
        )
        yield _notice("IPD", f"{words}; nobody says whom the headset fits", remedy)
    else:
        yield _there("IPD", words)


def _stop(flight: Preflight) -> Iterator[Diagnosis]:
    """Look whether a participant can stop: with either hand, with gaze or head alone."""
    if not flight.worn:
        way = "by keyboard" if flight.run.headset is not PLAYBACK else "the operator, by Ctrl-C"
        yield _there("stop", way)
        return
    from vrcomfort.headset.openxr.profiles import stop_of

    answering = flight.protocol.answering
    looks = f"a look {answering.stop_down_deg:g}° down for {answering.stop_down_s:g} s"
    seen = flight.shown.hands_seen if flight.shown else [0, 0]
    known = [flight.facts.get(f"{hand}_controller", "") for hand in ("left", "right")]
    hands = [
        f"{hand}: {stop_of(profile, hand)}"
        for hand, profile, frames in zip(("left", "right"), known, seen, strict=True)
        if profile and frames
    ]
    words = "; ".join([*hands, *([looks] if answering.stop_by_looks else [])]) or "nothing"
    if not hands and not answering.stop_by_looks:
        remedy = "switch the controllers on, or leave `stop_by_looks` true in [answering]"
        yield refuse("stop", words, remedy)
    elif len(hands) < 2:
        missing = "no controller" if not hands else "one controller only"
        yield _notice("stop", words, f"{missing} was seen: switch both on, and hold them in view")
    else:
        yield _there("stop", words)


CHECKS = (
    Check(
        "wording",
        "words of every item in every language; characters of the panel",
        "machine",
        _wording,
    ),
    Check("GPU", "OpenGL, the GPU that draws, and whether a faster one is there", "machine", _gpu),
    Check("disk", "room for a session, and for the study", "machine", _disk),
    Check("clock", "whether it stands before what the study has on record", "machine", _clock),
    Check("sound", "the device, where instructions are heard", "machine", _sound),
    Check(
        "LSL", "LabStreamingLayer and serial port, where they are asked for", "machine", _outlets
    ),
    Check(
        "runtime", "bindings, runtime, headset and eye tracker, as `doctor`", "runtime", _runtime
    ),
    Check(
        "gaze", "an eye tracker, or gaze in the trace, where a condition needs it", "runtime", _gaze
    ),
    Check("image size", "pixels of an eye's image, against the protocol's", "frames", _image_size),
    Check("refresh rate", "the display's rate, against the protocol's", "frames", _refresh_rate),
    Check("room", "the boundary, where participants stand", "frames", _room),
    Check(
        "rate holds",
        "the condition that takes longest to draw: dropped frames, margin",
        "frames",
        _rate_holds,
    ),
    Check("tracking", "the share of the frames without a measured head", "frames", _tracking),
    Check("floor", "the height of the head over it", "frames", _floor),
    Check(
        "IPD", "the distance between the eyes that is shown; whom the headset fits", "frames", _ipd
    ),
    Check("stop", "a stop with either hand, or with gaze or head alone", "frames", _stop),
)
"""All, in their order."""
