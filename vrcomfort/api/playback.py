"""Head traces, the playback headset that moves along them, and conditions that need gaze."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from vrcomfort.api.outputs import Note, as_warning
from vrcomfort.errors import InputError
from vrcomfort.protocol import Condition, Protocol
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from vrcomfort.geometry import Pose
    from vrcomfort.headset.playback import PlaybackHeadset
    from vrcomfort.scene.data import Scene
    from vrcomfort.traces.trace import Trace


# Head traces, and the playback headset that moves along them.


@dataclass
class PlaybackSetup:
    """Stands one playback headset in one scene after the other, so that a session has one clock.

    Parameters
    ----------
    trace
        For every scene; without it each scene's own shipped walk.
    refresh_hz
        `None` plays the trace's own samples.
    real_time
        For people: no frame comes before its time.
    """

    size_px: tuple[int, int]
    ipd_m: float
    trace: Trace | None = None
    refresh_hz: float | None = None
    real_time: bool = False
    _headset: PlaybackHeadset | None = field(default=None, init=False)

    def __call__(self, scene_name: str, scene: Scene) -> PlaybackHeadset:
        """Return the headset, at the start of its trace in `scene`."""
        if self._headset is None:
            self._headset = self.standing_in(scene_name, scene.spawn, on_foot=scene.on_foot)
        else:
            self._headset.place(self._trace(scene_name, scene.on_foot), spawn=scene.spawn)
        return self._headset

    def standing_in(
        self, scene_name: str, spawn: Pose | None = None, *, on_foot: bool = True
    ) -> PlaybackHeadset:
        """Return a new headset, as it is at the start of a session that begins in this scene."""
        from vrcomfort.headset.playback import PlaybackHeadset

        return PlaybackHeadset(
            self._trace(scene_name, on_foot),
            image_size_px=self.size_px,
            refresh_hz=self.refresh_hz,
            ipd_m=self.ipd_m,
            spawn=spawn,
            real_time=self.real_time,
        )

    def at_start(self, protocol: Protocol) -> PlaybackHeadset:
        """Return a new headset, as it is at the start of a session of a protocol."""
        return self.standing_in(protocol.view(protocol.scenes[0]).scene)

    def _trace(self, scene_name: str, on_foot: bool) -> Trace:
        """Return the head's trace, without locomotion for a seated participant."""
        trace = self.trace or shipped_walk(scene_name)
        return trace if on_foot else replace(trace, avatar=None, snap_turns=None)


def shipped_walk(scene_name: str) -> Trace:
    """Return the walk that ships with a scene.

    Raises
    ------
    InputError
        If there is none: it is a scene of your own.
    """
    from vrcomfort.traces.trace import read_trace

    file = data_folder("scenes") / f"{scene_name}_walk.csv"
    if not file.exists():
        raise InputError(f"no walk ships with the scene {scene_name!r}; give a head trace: --trace")
    return read_trace(file)


def open_trace(
    path: Path, *, trial: str | None = None, gaze: Path | None = None, note: Note = as_warning
) -> Trace:
    """Read a trace, or one trial of it, with a record of gaze; note samples that are left out."""
    from vrcomfort.traces.trace import read_trace

    trace = read_trace(path)
    if gaze is not None:
        trace = _with_gaze(trace, gaze, note)
    for warning in trace.warnings:
        note(warning)
    return trace if trial is None else trace.only_trial(trial)


def _with_gaze(trace: Trace, file: Path, note: Note) -> Trace:
    from vrcomfort.traces.gaze_track import read_gaze

    gaze = read_gaze(file)
    covered = gaze.covers(trace.time_ns)
    if not covered.any():
        message = "none of its samples is within 50 ms of the trace's; it is of another recording"
        raise InputError(message, file=file)
    if not covered.all():
        without = int((~covered).sum())
        note(f"{file}: {without} of the trace's {len(trace)} samples have no gaze within 50 ms")
    return replace(trace, gaze=gaze)


# Conditions that need gaze are refused before anything is written.


def require_eye_tracker(conditions: Iterable[Condition], has_one: Callable[[], bool]) -> None:
    """Refuse a headset without an eye tracker where a condition needs one.

    Parameters
    ----------
    has_one
        Asks the headset; called only where it matters.

    Raises
    ------
    InputError
        Before anything is written; says what to do.
    """
    if (need := _need_of_gaze(conditions)) and not has_one():
        raise _without_gaze(need, "this headset has no eye tracker; use one that has")


def require_recorded_gaze(conditions: Iterable[Condition], trace: Trace | None) -> None:
    """Refuse a trace without gaze where a condition needs it.

    Parameters
    ----------
    trace
        None is a walk that ships with a scene.

    Raises
    ------
    InputError
        Before anything is written; says what to do.
    """
    need = _need_of_gaze(conditions)
    if need and (trace is None or trace.gaze is None):
        remedy = "give a frames.csv with its gaze.csv beside it (simulate: or [simulation.eyes])"
        raise _without_gaze(need, f"what is played back has no gaze; {remedy}")


class _Need(NamedTuple):
    """A need of gaze, the conditions that have it, and the protocol's setting to do without."""

    what: str
    conditions: list[str]
    remedy: str


def _need_of_gaze(conditions: Iterable[Condition]) -> _Need | None:
    """Return the first need of gaze; None where all can be shown without."""
    every = tuple(conditions)
    focused = [each.name for each in every if _focus_stops(each)]
    if focused:
        remedy = 'without_gaze = "nine_ray" under [conditions.focus]'
        return _Need("focus follows the gaze", focused, remedy)
    centred = [each.name for each in every if _centre_stops(each)]
    if centred:
        remedy = 'without_gaze = "head" under [conditions.gaze_centre]'
        return _Need("effects are centred on the gaze", centred, remedy)
    return None


def _focus_stops(condition: Condition) -> bool:
    focus = condition.focus
    follows = condition.depth_of_field is not None and focus.method == "gaze"
    return follows and focus.without_gaze == "stop"


def _centre_stops(condition: Condition) -> bool:
    centre = condition.gaze_centre
    return bool(condition.centred_on_gaze) and centre is not None and centre.without_gaze == "stop"


def _without_gaze(need: _Need, why: str) -> InputError:
    names = ", ".join(need.conditions)
    return InputError(f"{need.what} in {names}, and {why}, or write {need.remedy}")
