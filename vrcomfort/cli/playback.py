"""Head traces, and the playback headset that moves along them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import warn
from vrcomfort.errors import InputError
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from vrcomfort.geometry import Pose
    from vrcomfort.headset.playback import PlaybackHeadset
    from vrcomfort.scene.data import Scene
    from vrcomfort.traces.trace import Trace


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

    def _trace(self, scene_name: str, on_foot: bool) -> Trace:
        """Return what the head does; of somebody who does not walk, without their locomotion."""
        trace = self.trace or shipped_walk(scene_name)
        return trace if on_foot else replace(trace, avatar=None, snap_turns=None)


def shipped_walk(scene_name: str) -> Trace:
    """Return the walk that ships with a scene.

    Raises
    ------
    InputError
        If there is none: it is somebody's own scene.
    """
    from vrcomfort.traces.trace import read_trace

    file = data_folder("scenes") / f"{scene_name}_walk.csv"
    if not file.exists():
        raise InputError(f"no walk ships with the scene {scene_name!r}; give a head trace: --trace")
    return read_trace(file)


def open_trace(path: Path, *, trial: str | None = None, gaze: Path | None = None) -> Trace:
    """Read a trace, or one trial of it, with a record of gaze; say what was left out."""
    from vrcomfort.traces.trace import read_trace

    trace = read_trace(path)
    if gaze is not None:
        trace = _with_gaze(trace, gaze)
    for warning in trace.warnings:
        warn(warning)
    return trace if trial is None else trace.only_trial(trial)


def _with_gaze(trace: Trace, file: Path) -> Trace:
    from vrcomfort.traces.gaze_track import read_gaze

    gaze = read_gaze(file)
    covered = gaze.covers(trace.time_ns)
    if not covered.any():
        message = "none of its samples is within 50 ms of the trace's; it is of another recording"
        raise InputError(message, file=file)
    if not covered.all():
        without = int((~covered).sum())
        warn(f"{file}: {without} of the trace's {len(trace)} samples have no gaze within 50 ms")
    return replace(trace, gaze=gaze)
