"""Builds what several commands need: traces, playback headsets, renderers, facts of the machine."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.cli.terminal import warn
from vrcomfort.errors import InputError
from vrcomfort.protocol import Condition, DepthOfField, Focus, MotionBlur, Protocol
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from vrcomfort.geometry import Pose
    from vrcomfort.headset.playback import PlaybackHeadset
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.scene.data import Scene
    from vrcomfort.traces.trace import Trace


EYE_HEIGHT_M = 1.6
"""Where a picture is taken from if nothing else is said."""

DEFAULT_CONDITION = Condition(
    name="default",
    label="Depth of field like an eye's, and motion blur without that of turning the head",
    focus=Focus(mean="dioptres", law="linear_dioptre"),
    depth_of_field=DepthOfField(law="dioptre"),
    motion_blur=MotionBlur(),
)


@dataclass
class PlaybackIn:
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
            self._headset = self.standing_in(scene_name, scene.spawn)
        else:
            self._headset.place(self._trace(scene_name), spawn=scene.spawn)
        return self._headset

    def standing_in(self, scene_name: str, spawn: Pose | None = None) -> PlaybackHeadset:
        """Return a new headset, as it is at the start of a session that begins in this scene."""
        from vrcomfort.headset.playback import PlaybackHeadset

        return PlaybackHeadset(
            self._trace(scene_name),
            image_size_px=self.size_px,
            refresh_hz=self.refresh_hz,
            ipd_m=self.ipd_m,
            spawn=spawn,
            real_time=self.real_time,
        )

    def _trace(self, scene_name: str) -> Trace:
        return self.trace or shipped_walk(scene_name)


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


def pick_condition(
    protocol: str | None, condition: str | None
) -> tuple[Protocol | None, Condition]:
    """Return the condition that a pair of options names; without both, the default.

    Raises
    ------
    InputError
        If only one of the two is given, or the protocol has no such condition.
    """
    from vrcomfort.protocol import load_protocol

    if protocol is None:
        if condition is not None:
            raise InputError("--condition needs --protocol, the file that defines it")
        return None, DEFAULT_CONDITION
    study = load_protocol(protocol)
    names = [each.name for each in study.conditions]
    if condition is None or condition not in names:
        given = f"no condition {condition!r}" if condition else "--condition is missing"
        raise InputError(f"{given}; protocol {study.name} has: {', '.join(names)}")
    return study, study.condition(condition)


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
    if (needing := _led_by_gaze(conditions)) and not has_one():
        raise _without_gaze(needing, "this headset has no eye tracker; use one that has")


def require_recorded_gaze(conditions: Iterable[Condition], trace: Trace | None) -> None:
    """Refuse what is played back, where a condition needs gaze and the trace has none.

    Parameters
    ----------
    trace
        None is a walk that ships with a scene.

    Raises
    ------
    InputError
        Before anything is written; says what to do.
    """
    needing = _led_by_gaze(conditions)
    if needing and (trace is None or trace.gaze is None):
        remedy = "give a frames.csv that has its gaze.csv beside it"
        raise _without_gaze(needing, f"what is played back has no gaze; {remedy}")


def _led_by_gaze(conditions: Iterable[Condition]) -> list[str]:
    """Return the names of the conditions that cannot be shown without gaze."""
    return [
        condition.name
        for condition in conditions
        if condition.depth_of_field is not None
        and condition.focus.method == "gaze"
        and condition.focus.without_gaze == "stop"
    ]


def _without_gaze(needing: list[str], why: str) -> InputError:
    return InputError(
        f"focus follows the gaze in {', '.join(needing)}, and {why}, "
        'or write without_gaze = "nine_ray" under [conditions.focus]'
    )


def make_renderer(size_px: tuple[int, int]) -> StereoRenderer:
    """Return a renderer on a context of its own, without a window."""
    from vrcomfort.gpu.gl import create_context
    from vrcomfort.render.pipeline import StereoRenderer

    return StereoRenderer(create_context(), size_px)


def describe_machine(renderer: StereoRenderer, protocol: Protocol) -> Machine:
    """Return what the manifest says of the machine and of the passes it draws."""
    from vrcomfort.gpu.gl import describe
    from vrcomfort.headset.timing import TimingTrust
    from vrcomfort.records import Machine
    from vrcomfort.render.plan import plan_passes
    from vrcomfort.scene.load import load_scene

    facts = describe(renderer.ctx)
    passes = {
        f"{condition.name} in {name}": [
            step.name for step in plan_passes(scene, condition) if step.needed
        ]
        for name in protocol.scenes
        for scene in [load_scene(protocol.scene_source(name))]
        for condition in protocol.conditions
    }
    return Machine(
        gpu=facts["renderer"],
        driver=facts["version"],
        runtime="playback",
        shaders=_shader_hashes(),
        passes=passes,
        timing_trust=TimingTrust.LOCKSTEP,
    )


def _shader_hashes() -> dict[str, str]:
    folder = data_folder("shaders")
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in files
    }
