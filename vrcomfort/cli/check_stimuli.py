"""Measures blur and streaks for `vrcomfort check`, by drawing small frames of a walk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.api.playback import PlaybackSetup
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose, focal_length_px, yaw_pitch_roll
from vrcomfort.optics.motion import clear_deg, moved_towards, widest_angle_deg
from vrcomfort.protocol import Condition, Protocol
from vrcomfort.render.camera import HeadStep, speed_share

if TYPE_CHECKING:
    import moderngl

    from vrcomfort.frame import Frame
    from vrcomfort.protocol.conditions import Vignette
    from vrcomfort.render.stimulus_check import Fault, Moment, StimulusExtent, StimulusSize
    from vrcomfort.scene.camera_path import CameraPath
    from vrcomfort.scene.data import Scene
    from vrcomfort.session.start_pose import StartPose

# Sizes are proportional to the image's width: they are found on a small one, and scaled.
PROBE_WIDTH_PX = 160
_MOMENT_S, _SUSTAINED = 0.1, 300
"""Steps of this length, so many, are a motion that lasts."""
_STEPS_HZ = 30.0
"""So often speeds along a walk are looked at."""
_QUICK_LOOK_DEG_PER_S = 200.0


@dataclass(frozen=True)
class Stimuli:
    """Amounts of every condition in every scene, and their faults."""

    rows: list[StimulusExtent]
    faults: list[Fault]
    notes: list[str]


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
    from vrcomfort.render.stimulus_check import (
        faults,
        measure,
        needlessly_meant,
        seen,
        turning_left,
        turning_twins,
    )
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
        shown = [condition.in_scene(name) for condition in protocol.conditions]
        drawn = measure(ctx, scene, [*shown, *turning_twins(shown)], looks, probe_px)
        sizes[name] = {condition: found.scaled(scale) for condition, found in drawn.items()}
        advance()
    rows = [
        seen(condition.name, name, sizes[name][condition.name], focal_px)
        for condition in protocol.conditions
        for name in protocol.scenes
    ]
    notes = [*needlessly_meant(protocol, sizes), *turning_left(protocol, sizes)]
    return Stimuli(rows, list(faults(protocol, sizes)), notes)


def moments_of(
    protocol: Protocol,
    name: str,
    scene: Scene,
    size_px: tuple[int, int],
    refresh_hz: float,
    count: int,
) -> list[Moment]:
    """Return moments of the walk that ships with a scene; without one, of a look around its start.

    A moment is a frame at the headset's rate, and the one before.
    """
    standing = _standing(protocol, name, scene)
    carried = _carried(standing.path, refresh_hz)
    if frames := _walk(protocol, name, standing, size_px, refresh_hz):
        places = np.linspace(1, len(frames) - 1, count).astype(int)
        pairs = [(frames[place - 1], frames[place]) for place in places]
        pairs = [pair for pair in pairs if not (pair[1].discontinuity or pair[1].snap_turn)]
    else:
        pairs = list(_around(protocol, standing.scene.spawn, size_px, refresh_hz, count))
    return [(carried(before), carried(now)) for before, now in pairs]


def _standing(protocol: Protocol, name: str, scene: Scene) -> StartPose:
    from vrcomfort.session.start_pose import start_pose_of

    return start_pose_of(scene, protocol.view(name), walks=protocol.locomotion.mode != "off")


def _walk(
    protocol: Protocol,
    name: str,
    standing: StartPose,
    size_px: tuple[int, int],
    refresh_hz: float,
) -> list[Frame]:
    """Return the frames of the walk that ships with a scene; none where none does.

    Who does not walk (in a view with a path, or without locomotion) looks as on that walk; callers
    carry them along the path.
    """
    try:
        playback = PlaybackSetup(size_px, protocol.headset.ipd_m, refresh_hz=refresh_hz)
        headset = playback(protocol.view(name).scene, standing.scene)
    except InputError:
        return []
    length_s = protocol.length_s(name) if standing.path else headset.trace_s
    return list(islice(headset.frames(), int(length_s * refresh_hz + 1e-6) + 1))


def _carried(path: CameraPath | None, refresh_hz: float) -> Callable[[Frame], Frame]:
    """Return a function that moves a frame along a path, by the frame's index."""
    if path is None:
        return lambda frame: frame
    return lambda frame: replace(
        frame, avatar_pose=path.moved(frame.index / refresh_hz) @ frame.avatar_pose
    )


def open_vignettes(
    protocol: Protocol, size_px: tuple[int, int], refresh_hz: float
) -> Iterator[str]:
    """Yield a note on each vignette that narrows in no scene; nothing is drawn.

    The walks are those that blur is measured on. Where none ships with a scene, people are taken to
    walk and to turn their heads quickly. Where they can move by locomotion, its speeds count, too.
    """
    restricted = [each for each in protocol.conditions if each.vignette is not None]
    if not restricted:
        return
    steps = [_steps_in(protocol, name, size_px, refresh_hz) for name in protocol.scenes]
    for condition in restricted:
        if reason := _never_narrows(condition, steps, size_px):
            yield f"the vignette of `{condition.name}` never narrows the view: {reason}"


def _steps_in(
    protocol: Protocol, name: str, size_px: tuple[int, int], refresh_hz: float
) -> list[HeadStep | None]:
    """Return the steps of a scene's walk in their order, None at cuts, and those of locomotion."""
    from vrcomfort.render.stimulus_check import step_between
    from vrcomfort.scene.load import load_scene

    standing = _standing(protocol, name, load_scene(protocol.scene_source(name)))
    rate_hz = min(refresh_hz, _STEPS_HZ)
    carried = _carried(standing.path, rate_hz)
    frames = list(map(carried, _walk(protocol, name, standing, size_px, rate_hz)))
    steps: list[HeadStep | None] = [
        None if now.discontinuity or now.snap_turn else step_between(before, now)
        for before, now in pairwise(frames)
    ]
    still = Pose()
    if not frames:
        for moved in (_ahead(LOOK_M_PER_S), _turned(_QUICK_LOOK_DEG_PER_S)):
            steps += _SUSTAINED * [HeadStep(still, moved, still, still, _MOMENT_S)]
        if standing.path is not None:
            path = [
                standing.path.moved(time_s)
                for time_s in np.arange(0, standing.path.duration_s, _MOMENT_S)
            ]
            steps += [
                HeadStep(still, still, before, now, _MOMENT_S) for before, now in pairwise(path)
            ]
    walks = protocol.locomotion
    if walks.mode == "walk" and standing.path is None:
        turning_deg_s = 0.0 if walks.snap_turn_deg else walks.turning_deg_s
        for moved in (_ahead(walks.walking_speed_m_s), _turned(turning_deg_s)):
            steps += _SUSTAINED * [HeadStep(still, still, still, moved, _MOMENT_S)]
    return steps


def _ahead(speed_m_s: float) -> Pose:
    return Pose(np.array([0.0, 0.0, -speed_m_s * _MOMENT_S]))


def _turned(speed_deg_s: float) -> Pose:
    return Pose(orientation=yaw_pitch_roll(np.radians(speed_deg_s * _MOMENT_S), 0.0, 0.0))


def _never_narrows(
    condition: Condition, scenes: Sequence[Sequence[HeadStep | None]], size_px: tuple[int, int]
) -> str | None:
    """Return why a vignette leaves the view as it is everywhere; None where it narrows it."""
    from vrcomfort.headset.playback import default_fovs

    settings = condition.vignette
    if settings is None:
        return None
    if settings.turning is None and settings.moving is None:
        if "open_deg" not in settings.model_fields_set:
            return "it has neither `turning` nor `moving`; write one of them"
        narrowest = settings.open_deg
    elif settings.restricted_deg == settings.open_deg:
        return "`restricted_deg` is `open_deg`; make it smaller"
    else:
        strength = max(_strongest(settings, steps) for steps in scenes)
        if strength == 0.0:
            return _too_slow(settings, [step for steps in scenes for step in steps if step])
        narrowest = clear_deg(settings.open_deg, settings.restricted_deg, strength)
    widest = max(widest_angle_deg(fov, Pose()) for fov in default_fovs(size_px))
    if condition.centred_on_gaze or narrowest / 2 < widest:
        return None
    seen = f"the image ends {widest:.0f} degrees from its middle"
    return f"its field is at least {narrowest:.0f} degrees wide, and {seen}; make it smaller"


def _strongest(settings: Vignette, steps: Sequence[HeadStep | None]) -> float:
    """Return how far the field closes at most, 0 to 1, along steps that follow each other."""
    strongest = strength = 0.0
    for step in steps:
        wanted = speed_share(settings, step)
        if step is None:
            strength = 0.0
            continue
        strength = moved_towards(
            strength,
            wanted,
            elapsed_s=step.seconds,
            attack_s=settings.attack_s,
            release_s=settings.release_s,
        )
        strongest = max(strongest, strength)
    return strongest


def _too_slow(settings: Vignette, steps: Sequence[HeadStep]) -> str:
    of = settings.speed_of
    found = []
    if settings.turning is not None:
        fastest = max((step.turn_deg_s(of) for step in steps), default=0.0)
        begins = f"begins at {settings.turning.from_deg_s:g}"
        found.append(f"turning reaches {fastest:.0f} deg/s, and `turning` {begins}")
    if settings.moving is not None:
        fastest = max((step.speed_m_s(of) for step in steps), default=0.0)
        begins = f"begins at {settings.moving.from_m_s:g}"
        found.append(f"moving reaches {fastest:.1f} m/s, and `moving` {begins}")
    told = "; ".join(found)
    return f'in its scenes (speed_of = "{of}") {told}; let it begin at a lower speed'


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
