"""What `vrcomfort check` finds out about blur and streaks, by drawing small frames of a walk."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.cli.playback import PlaybackSetup
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose, focal_length_px, yaw_pitch_roll
from vrcomfort.protocol import Protocol

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.render.stimulus_size import Moment, StimulusSize
    from vrcomfort.render.visibility import Fault, Seen
    from vrcomfort.scene.camera_path import CameraPath
    from vrcomfort.scene.data import Scene

PROBE_WIDTH_PX = 160


@dataclass(frozen=True)
class Stimuli:
    """Amounts of every condition in every scene, and what is wrong with them."""

    rows: list[Seen]
    faults: list[Fault]
    excused: list[str]


def measure_stimuli(
    ctx: moderngl.Context,
    protocol: Protocol,
    size_px: tuple[int, int],
    refresh_hz: float,
    moments: int,
    advance: Callable[..., None],
) -> Stimuli:
    """Measure all conditions in all scenes."""
    from vrcomfort.headset.playback import default_fovs
    from vrcomfort.render.stimulus_size import measure
    from vrcomfort.render.visibility import faults, needlessly_meant, seen
    from vrcomfort.scene.load import load_scene

    width, height = size_px
    probe_px = (PROBE_WIDTH_PX, max(round(PROBE_WIDTH_PX * height / width), 16))
    scale = width / PROBE_WIDTH_PX
    focal_px = focal_length_px(default_fovs(size_px)[0], size_px)[0]
    sizes: dict[str, dict[str, StimulusSize]] = {}
    for name in protocol.scenes:
        advance(0, f"looking at {name}")
        scene = load_scene(protocol.scene_source(name))
        looks = moments_of(protocol, name, scene, probe_px, refresh_hz, moments)
        drawn = measure(ctx, scene, protocol.conditions, looks, probe_px)
        sizes[name] = {condition: found.scaled(scale) for condition, found in drawn.items()}
        advance()
    rows = [
        seen(condition.name, name, sizes[name][condition.name], focal_px)
        for condition in protocol.conditions
        for name in protocol.scenes
    ]
    return Stimuli(rows, list(faults(protocol, sizes)), list(needlessly_meant(protocol, sizes)))


def moments_of(
    protocol: Protocol,
    name: str,
    scene: Scene,
    size_px: tuple[int, int],
    refresh_hz: float,
    count: int,
) -> list[Moment]:
    """Return moments of the walk that ships with a scene; without one, of a look around its start.

    A moment is a frame at the headset's rate, and the one before. Who does not walk (in a view with
    a path, or without locomotion) looks as on that walk, and is carried along the path.
    """
    from vrcomfort.session.standing import stand

    view = protocol.view(name)
    standing = stand(scene, view, walks=protocol.locomotion.mode != "off")
    try:
        playback = PlaybackSetup(size_px, protocol.headset.ipd_m, refresh_hz=refresh_hz)
        headset = playback(view.scene, standing.scene)
    except InputError:
        spawn = standing.scene.spawn
        moments = list(_around(protocol, spawn, size_px, refresh_hz, count))
        return [_carried(pair, standing.path, refresh_hz) for pair in moments]
    length_s = protocol.length_s(name) if standing.path else headset.trace_s
    frames = list(islice(headset.frames(), int(length_s * refresh_hz + 1e-6) + 1))
    places = np.linspace(1, len(frames) - 1, count).astype(int)
    moments = [(frames[place - 1], frames[place]) for place in places]
    return [
        _carried(pair, standing.path, refresh_hz)
        for pair in moments
        if not (pair[1].discontinuity or pair[1].snap_turn)
    ]


def _carried(moment: Moment, path: CameraPath | None, refresh_hz: float) -> Moment:
    """Return a moment along a path, whose time its first frame's index tells."""
    if path is None:
        return moment
    before, now = (
        replace(frame, avatar_pose=path.moved(frame.index / refresh_hz) @ frame.avatar_pose)
        for frame in moment
    )
    return before, now


LOOK_M_PER_S, LOOK_DEG_PER_S = 1.4, 30.0


def _around(
    protocol: Protocol, spawn: Pose, size_px: tuple[int, int], refresh_hz: float, count: int
) -> Iterator[Moment]:
    """Yield looks in all directions where a scene begins, walking and turning as people do."""
    from vrcomfort.frame import EYE_HEIGHT_M, Frame
    from vrcomfort.geometry import View
    from vrcomfort.headset.playback import default_fovs

    period_ns = round(1e9 / refresh_hz)
    half = np.array([protocol.headset.ipd_m / 2, 0.0, 0.0])
    left, right = default_fovs(size_px)

    def look(index: int, yaw_rad: float, ahead_m: float) -> Frame:
        at = np.array([-np.sin(yaw_rad) * ahead_m, EYE_HEIGHT_M, -np.cos(yaw_rad) * ahead_m])
        head = Pose(at, yaw_pitch_roll(yaw_rad, 0.0, 0.0))
        views = (View(head @ Pose(-half), left), View(head @ Pose(half), right))
        return Frame(index, index * period_ns, period_ns, head, views, spawn)

    for number in range(count):
        yaw_rad = 2 * np.pi * number / count
        turned = yaw_rad + np.radians(LOOK_DEG_PER_S) / refresh_hz
        yield (
            look(2 * number, yaw_rad, 0.0),
            look(2 * number + 1, turned, LOOK_M_PER_S / refresh_hz),
        )
