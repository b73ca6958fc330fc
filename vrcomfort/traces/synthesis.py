"""Synthesizes head traces: seeded walks with bob, sway, roll, fast turns and long fixations.

An itinerary says where to walk and what to look at. The walk itself is locomotion (the avatar's
pose in the world), the head moves in the tracked stage, as with a participant who walks by
thumb-stick and turns and leans in place.

Amplitudes are of the order that walking people show: Hirasaki et al., "Effects of walking velocity
on vertical head and body movements during locomotion", Exp. Brain Res. 127 (1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, axis_angle, quaternion_multiply, rotate
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace

Point: TypeAlias = tuple[float, float, float]
Steps: TypeAlias = NDArray[np.intp]


@dataclass(frozen=True)
class Walk:
    """Go straight to a floor point, looking ahead or at a thing on the way."""

    to: Point
    look_at: Point | None = None


@dataclass(frozen=True)
class Look:
    """Stand and look at a thing."""

    at: Point
    seconds: float


@dataclass(frozen=True)
class Gait:
    """A manner of walking and standing; amplitudes at full speed."""

    eye_height_m: float = 1.65
    speed_m_s: float = 1.4
    """The paper's limit (Carnegie & Rhee 2015)."""
    stride_m: float = 1.4
    """Two steps."""
    bob_m: float = 0.022
    sway_m: float = 0.018
    roll_deg: float = 1.1
    nod_deg: float = 0.8
    look_ahead_pitch_deg: float = -7.0
    neck_to_head_m: Point = (0.0, 0.075, -0.085)
    """From the neck's pivot to the point between the eyes, so that turning moves the head."""
    gaze_turn_s: float = 0.5
    """A turn of the head; 90° then peak at 360°/s."""
    torso_turn_s: float = 1.0
    path_rounding_s: float = 0.7
    idle_sway_m: float = 0.004
    idle_turn_deg: float = 0.35


def synthesize(
    start: Point,
    itinerary: Sequence[Walk | Look],
    *,
    seed: int,
    gait: Gait | None = None,
    rate_hz: int = 72,
) -> Trace:
    """Return the head trace of a walk along an itinerary.

    Parameters
    ----------
    start
        Floor point in the world.
    seed
        Decides everything that is left to chance: how one sways.
    rate_hz
        Samples per second.

    Returns
    -------
    Stage-from-head and world-from-stage, rounded to 1 µm and 1e-7, so that another processor's
    last bits do not show.
    """
    gait = Gait() if gait is None else gait
    knots_s, knots, looks = _timeline(start, itinerary, gait)
    count = int(knots_s[-1] * rate_hz) + 1
    time_s = np.arange(count) / rate_hz
    step = np.clip(np.searchsorted(knots_s, time_s, side="right") - 1, 0, len(looks) - 1)

    path = np.stack([np.interp(time_s, knots_s, axis) for axis in knots.T], axis=1)
    path = smooth(path, gait.path_rounding_s * rate_hz)
    gaze = np.unwrap(_gaze(path, knots, looks, step, gait), axis=0)
    torso = smooth(_torso(gaze[:, :1], knots, step), gait.torso_turn_s * rate_hz)[:, 0]
    gaze = smooth(gaze, gait.gaze_turn_s * rate_hz)

    head = _head_in_stage(path, gaze - np.stack([torso, 0 * torso], axis=1), time_s, gait, seed)
    avatar = PoseTrack(path, axis_angle(np.array([[0.0, 1.0, 0.0]]), torso))
    cuts = np.arange(count) == 0
    return Trace(
        time_ns=np.array([round(k * 10**9 / rate_hz) for k in range(count)], dtype=np.int64),
        period_ns=np.full(count, round(10**9 / rate_hz), dtype=np.int64),
        head=_rounded(head),
        avatar=_rounded(avatar),
        cuts=cuts,
    )


def with_hands(
    trace: Trace, *, before_m: Point = (0.17, -0.33, -0.42), swing_m: float = 0.05
) -> Trace:
    """Return the trace with both hands held before the chest.

    The hands follow the head, averaged over a quarter of a second, as they do when they carry
    something; while walking, they swing, one forwards as the other comes back.

    Parameters
    ----------
    trace
        With an avatar: the hands swing while it moves.
    before_m
        Of the right hand, to the right of, above and behind the head; the left one is its mirror
        image.
    swing_m
        How far each hand swings to either side, at 1.4 m/s.

    Raises
    ------
    ValueError
        If the trace has no avatar.
    """
    if trace.avatar is None:
        raise ValueError("a trace without an avatar does not say when its hands swing")
    gait, rate_hz = Gait(), 1e9 / trace.median_period_ns
    path = trace.avatar.positions[:, [0, 2]]
    moved = np.linalg.norm(np.diff(path, axis=0, prepend=path[:1]), axis=1)
    swing = np.sin(2 * np.pi * np.cumsum(moved) / gait.stride_m) * moved * rate_hz / gait.speed_m_s
    ahead = rotate(trace.head.orientations, np.array([[0.0, 0.0, -1.0]]))
    yaw = smooth(np.unwrap(_yaw(ahead))[:, None], 0.25 * rate_hz)[:, 0]
    at = smooth(trace.head.positions, 0.25 * rate_hz)
    upright = axis_angle(np.array([[0.0, 1.0, 0.0]]), yaw)

    def hand(side: float) -> PoseTrack:
        place = np.tile(before_m, (len(trace), 1)) * (side, 1.0, 1.0)
        place[:, 2] -= side * swing_m * swing
        return _rounded(PoseTrack(at + rotate(upright, place), upright))

    return replace(trace, left_hand=hand(-1.0), right_hand=hand(1.0))


def smooth(values: Array, window: float) -> Array:
    """Return (n, k) values averaged over a Hann window of about `window` samples."""
    half = max(round(window / 2), 1)
    weights = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    columns = [np.convolve(column, weights / weights.sum(), mode="valid") for column in padded.T]
    return np.stack(columns, axis=1)


def _timeline(
    start: Point, itinerary: Sequence[Walk | Look], gait: Gait
) -> tuple[Array, Array, list[Point | None]]:
    """Return (k + 1,) times and (k + 1, 3) floor points between steps, and k things to look at."""
    times, points = [0.0], [np.array(start)]
    looks: list[Point | None] = []
    for step in itinerary:
        if isinstance(step, Walk):
            to = np.array(step.to)
            times.append(times[-1] + float(np.linalg.norm(to - points[-1])) / gait.speed_m_s)
            points.append(to)
            looks.append(step.look_at)
        else:
            times.append(times[-1] + step.seconds)
            points.append(points[-1])
            looks.append(step.at)
    return np.array(times), np.array(points), looks


def _gaze(path: Array, knots: Array, looks: list[Point | None], step: Steps, gait: Gait) -> Array:
    """Return (n, 2) yaw and pitch of the gaze in the world, jumping from thing to thing."""
    gaze = np.zeros((len(path), 2))
    for index, thing in enumerate(looks):
        here = step == index
        if thing is None:
            gaze[here] = (
                _yaw(knots[index + 1] - knots[index]),
                np.radians(gait.look_ahead_pitch_deg),
            )
            continue
        towards = np.array(thing) - path[here] - [0.0, gait.eye_height_m, 0.0]
        level = np.hypot(towards[:, 0], towards[:, 2])
        gaze[here] = np.stack([_yaw(towards), np.arctan2(towards[:, 1], level)], axis=1)
    return gaze


def _torso(gaze_yaw: Array, knots: Array, step: Steps) -> Array:
    """Return (n, 1) yaw of the torso: along each walk, and towards the gaze while standing."""
    torso = np.zeros_like(gaze_yaw)
    for index, (before, after) in enumerate(pairwise(knots)):
        here = step == index
        stands = np.array_equal(before, after)
        torso[here] = gaze_yaw[here] if stands else _yaw(after - before)
    # The neck holds the two within half a turn of each other, so both turn the same way round.
    return gaze_yaw + (torso - gaze_yaw + np.pi) % (2 * np.pi) - np.pi


def _head_in_stage(path: Array, turn: Array, time_s: Array, gait: Gait, seed: int) -> PoseTrack:
    """Return stage-from-head: gait and idle sway around the neck, (n, 2) `turn` above the torso."""
    idle = _idle(time_s, seed)
    moved = np.linalg.norm(np.diff(path[:, [0, 2]], axis=0, prepend=path[:1, [0, 2]]), axis=1)
    phase = 2 * np.pi * np.cumsum(moved) / gait.stride_m
    effort = (moved / (gait.speed_m_s * (time_s[1] - time_s[0])))[:, None]
    # Twice per stride the body falls and rises; once it leans over to each foot.
    sway = effort * np.stack([gait.sway_m * np.sin(phase), gait.bob_m * np.cos(2 * phase)], axis=1)
    lean = effort * np.radians(
        np.stack([gait.nod_deg * np.cos(2 * phase + 0.6), -gait.roll_deg * np.sin(phase)], axis=1)
    )
    yaw_pitch_roll = np.concatenate([turn, np.zeros((len(turn), 1))], axis=1)
    yaw_pitch_roll[:, 1:] += lean
    yaw_pitch_roll += np.radians(gait.idle_turn_deg) * idle[:, 3:]
    orientations = _from_angles(yaw_pitch_roll)
    arm = np.array(gait.neck_to_head_m)
    positions = gait.idle_sway_m * idle[:, :3] + rotate(orientations, arm[None]) - arm
    positions[:, :2] += sway
    positions[:, 1] += gait.eye_height_m
    return PoseTrack(positions, orientations)


def _idle(time_s: Array, seed: int) -> Array:
    """Return (n, 6) slow noise of about unit amplitude: postural sway."""
    random = np.random.default_rng(np.random.SeedSequence(seed))
    hertz = random.uniform(0.1, 0.7, size=(6, 4))
    phases = random.uniform(0.0, 2 * np.pi, size=(6, 4))
    waves = np.sin(2 * np.pi * time_s[:, None, None] * hertz + phases)
    return np.asarray(waves.mean(axis=2))


def _from_angles(yaw_pitch_roll: Array) -> Array:
    """Return (n, 4) quaternions of (n, 3) angles, as `geometry.yaw_pitch_roll` defines them."""
    axes = ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    yaw, pitch, roll = (
        axis_angle(np.array([axis]), angle)
        for axis, angle in zip(axes, yaw_pitch_roll.T, strict=True)
    )
    return quaternion_multiply(quaternion_multiply(yaw, pitch), roll)


def _yaw(direction: Array) -> Array:
    """Return the (...) turn to the left from −Z to a (..., 3) direction."""
    yaw: Array = np.arctan2(-direction[..., 0], -direction[..., 2])
    return yaw


def _rounded(track: PoseTrack) -> PoseTrack:
    # Adding zero turns -0.0 into 0.0.
    return PoseTrack(track.positions.round(6) + 0.0, track.orientations.round(7) + 0.0)
