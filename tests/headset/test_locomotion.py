"""Walking: never beside the floor, never too fast, and where the torso points."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array, Pose, axis_angle, yaw_pitch_roll
from vrcomfort.headset.inputs import HandInput, Inputs, KeyInput
from vrcomfort.headset.locomotion import LONGEST_S, Locomotion, MoveCommand, move_command
from vrcomfort.scene.floors import STEP_M, Floors
from vrcomfort.scene.load import load_scene
from vrcomfort.scene.side_car import read_side_car

SPEED_M_S = 1.4
FRAME_S = 1 / 90


@dataclass(frozen=True)
class Piece:
    """A floor, as a scene has it."""

    polygon_xz: Array
    height_m: float = 0.0
    slope_xz: tuple[float, float] = (0.0, 0.0)


def box(
    x0: float, z0: float, x1: float, z1: float, height: float = 0.0, rise: float = 0.0
) -> Piece:
    corners = np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1]])
    return Piece(corners, height - rise * x0, (rise, 0.0))


L_SHAPE = Piece(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 4.0], [2.0, 2.0], [0.0, 2.0]]))
STAIRS = [box(0, -1, 2, 1), box(2, -1, 2.3, 1, 0.18), box(2.3, -1, 2.6, 1, 0.36)]
HOUSE = [*STAIRS, box(2.6, -1, 6, 1, 0.54), box(6, -1, 9, 1, 0.54, rise=0.4), L_SHAPE]
CLIFF = [box(0, -1, 2, 1), box(2, -1, 4, 1, STEP_M + 0.05)]


def distance_beside(pieces: list[Piece], feet: Array) -> float:
    """Return how far feet are from the nearest floor below, seen from above."""
    best = np.inf
    for piece in pieces:
        corners = piece.polygon_xz
        sides = np.roll(corners, -1, axis=0) - corners
        offset = feet[[0, 2]] - corners
        share = np.clip(np.sum(offset * sides, axis=1) / np.sum(sides**2, axis=1), 0, 1)
        away = np.linalg.norm(offset - share[:, None] * sides, axis=1).min()
        angles = np.arctan2(-offset[:, 1], -offset[:, 0])
        turns = np.angle(np.exp(1j * (np.roll(angles, -1) - angles))).sum()
        best = min(best, 0.0 if abs(turns) > np.pi else away)
    return float(best)


def feet_of(walker: Locomotion, head: Pose) -> Array:
    x, _, z = head.position
    return (walker.avatar @ Pose(np.array([x, 0.0, z]))).position


def placed(pieces: list[Piece], x: float = 1.0, z: float = 0.5, yaw: float = 0.0) -> Locomotion:
    walker = Locomotion(SPEED_M_S)
    spawn = Pose(np.array([x, 0.0, z]), axis_angle([0.0, 1.0, 0.0], yaw))
    walker.send(spawn=spawn, floors=Floors(pieces))
    assert walker.arrive(HEAD)
    return walker


HEAD = Pose(np.array([0.0, 1.6, 0.0]))
EAST = MoveCommand(right=1.0)

stick = st.floats(-1, 1)
commands = st.builds(MoveCommand, stick, stick, st.floats(-0.5, 0.5), stick)
strides = st.lists(st.tuples(commands, st.integers(1, 40)), min_size=1, max_size=8)
houses = st.sampled_from([[L_SHAPE], STAIRS, HOUSE, CLIFF])


def test_who_was_sent_nowhere_walks_into_the_scene_and_has_not_been_teleported() -> None:
    walker = Locomotion(SPEED_M_S)
    walker.send(spawn=Pose(), floors=Floors([box(-2, -2, 2, 2)]))
    assert not walker.teleported
    walker.step(HEAD, MoveCommand(forward=1.0), FRAME_S)
    assert feet_of(walker, HEAD) == pytest.approx([0.0, 0.0, -SPEED_M_S * FRAME_S])


@pytest.mark.slow
@settings(max_examples=60)
@given(houses, strides, st.floats(0.001, LONGEST_S))
def test_nobody_leaves_the_floor_or_is_too_fast(
    pieces: list[Piece], way: list[tuple[MoveCommand, int]], frame_s: float
) -> None:
    walker = placed(pieces)
    before = feet_of(walker, HEAD)
    for command, frames in way:
        for _ in range(frames):
            walker.step(HEAD, command, frame_s)
            feet = feet_of(walker, HEAD)
            assert distance_beside(pieces, feet) < 1e-6
            assert np.linalg.norm(feet - before) <= SPEED_M_S * frame_s + 1e-6
            before = feet


@pytest.mark.slow
@settings(max_examples=25)
@given(houses, strides)
def test_the_same_wishes_lead_to_the_same_place(
    pieces: list[Piece], way: list[tuple[MoveCommand, int]]
) -> None:
    one, other = placed(pieces), placed(pieces)
    for walker in (one, other):
        for command, frames in way:
            for _ in range(frames):
                walker.step(HEAD, command, FRAME_S)
    assert one.avatar == other.avatar


heads = st.builds(
    lambda x, z, yaw, pitch: Pose(np.array([x, 1.6, z]), yaw_pitch_roll(yaw, pitch, 0.0)),
    st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-3, 3), st.floats(-1, 1),
)  # fmt: skip


@pytest.mark.slow
@given(houses, st.lists(st.tuples(commands, heads), max_size=20))
def test_who_leans_beside_the_floor_gets_no_further_away_by_walking(
    pieces: list[Piece], way: list[tuple[MoveCommand, Pose]]
) -> None:
    walker = placed(pieces)
    for command, head in way:
        before = distance_beside(pieces, feet_of(walker, head))
        walker.step(head, MoveCommand(command.right, command.forward), 0.05)
        assert distance_beside(pieces, feet_of(walker, head)) <= before + 1e-6


@given(st.floats(-3, 3), st.floats(-3, 3), heads)
def test_feet_follow_the_torso_wherever_the_head_looks(
    yaw: float, turn: float, looking: Pose
) -> None:
    walker = Locomotion(SPEED_M_S)
    walker.send(spawn=Pose(orientation=axis_angle([0.0, 1.0, 0.0], yaw)), floors=Floors())
    walker.arrive(HEAD)
    walker.step(HEAD, MoveCommand(turn_rad=turn), FRAME_S)
    before = feet_of(walker, looking)
    walker.step(looking, MoveCommand(right=0.4, forward=0.3), FRAME_S)
    moved = feet_of(walker, looking) - before
    forward = Pose(orientation=axis_angle([0.0, 1.0, 0.0], yaw + turn)).forward
    expected = 0.8 * np.cross(forward, [0.0, 1.0, 0.0]) + 0.6 * forward
    assert moved == pytest.approx(expected * SPEED_M_S * FRAME_S, abs=1e-12)


@given(st.floats(-3, 3), heads)
def test_turning_leaves_the_feet_where_they_are(turn: float, head: Pose) -> None:
    walker = placed([L_SHAPE])
    before = feet_of(walker, head)
    walker.step(head, MoveCommand(turn_rad=turn), FRAME_S)
    assert feet_of(walker, head) == pytest.approx(before, abs=1e-12)


def test_the_total_speed_is_the_same_on_a_slope() -> None:
    walker = placed([box(0, -1, 20, 1, rise=0.75)])
    walker.step(HEAD, EAST, FRAME_S)  # reaches the slope's height from the spawn's
    start = feet_of(placed([box(0, -1, 20, 1, rise=0.75)]), HEAD)
    while abs(feet_of(walker, HEAD)[1] - 0.75 * feet_of(walker, HEAD)[0]) > 1e-9:
        walker.step(HEAD, EAST, FRAME_S)
        assert feet_of(walker, HEAD)[1] < start[1] + 1.0
    before = feet_of(walker, HEAD)
    for _ in range(90):
        walker.step(HEAD, EAST, FRAME_S)
    moved = feet_of(walker, HEAD) - before
    assert np.linalg.norm(moved) == pytest.approx(SPEED_M_S, abs=1e-9)
    assert moved == pytest.approx([0.8 * SPEED_M_S, 0.6 * SPEED_M_S, 0.0], abs=1e-9)


def test_a_stair_takes_its_height_from_the_way_across() -> None:
    walker = placed(HOUSE[:4])
    way_m = (2.6 - 1.0) + 3 * 0.18 + 1.0
    steps, last = int(way_m / (SPEED_M_S * FRAME_S)), 0.0
    for _ in range(steps):
        walker.step(HEAD, EAST, FRAME_S)
        height = feet_of(walker, HEAD)[1]
        assert last <= height <= last + SPEED_M_S * FRAME_S + 1e-12
        last = height
    walked = steps * SPEED_M_S * FRAME_S
    assert feet_of(walker, HEAD) == pytest.approx([1.0 + walked - 0.54, 0.54, 0.5], abs=1e-9)


def test_feet_on_a_step_between_two_floors_stay_where_they_are() -> None:
    floors = Floors([box(0, -1, 2, 1, 0.54), box(2, -1, 4, 1, 0.72)])
    for point in ([2.0, 0.6, 0.0], [2.0, 0.7, 0.5]):
        assert floors.settle(np.array(point)) == pytest.approx(point)


def test_a_trembling_head_climbs_stairs_too() -> None:
    walker = placed(HOUSE[:4])
    rng = np.random.default_rng(5)
    for _ in range(300):
        head = Pose(HEAD.position + rng.normal(0.0, 0.003, 3))
        walker.step(head, EAST, FRAME_S)
    assert feet_of(walker, HEAD)[1] == pytest.approx(0.54)
    for _ in range(300):
        head = Pose(HEAD.position + rng.normal(0.0, 0.003, 3))
        walker.step(head, MoveCommand(right=-1.0), FRAME_S)
    assert feet_of(walker, HEAD)[1] == pytest.approx(0.0, abs=1e-9)


def test_a_cliff_is_not_climbed() -> None:
    walker = placed(CLIFF)
    for _ in range(180):
        walker.step(HEAD, EAST, FRAME_S)
    assert feet_of(walker, HEAD) == pytest.approx([2.0, 0.0, 0.5], abs=1e-6)


def test_walls_are_slid_along() -> None:
    walker = placed([box(0, -1, 9, 1)], x=1.0, z=0.0)
    for _ in range(360):
        walker.step(HEAD, MoveCommand(right=1.0, forward=1.0), FRAME_S)
    half = np.sqrt(0.5)
    assert feet_of(walker, HEAD) == pytest.approx([1 + 4 * SPEED_M_S * half, 0, -1], abs=1e-6)


def test_a_hiccup_is_no_leap() -> None:
    walker = placed([box(0, -1, 9, 1)])
    walker.step(HEAD, EAST, 5.0)
    assert feet_of(walker, HEAD)[0] == pytest.approx(1.0 + SPEED_M_S * LONGEST_S)


def test_sticks_and_keys_mean_the_same_speed_and_rest_in_the_middle() -> None:
    assert move_command(Inputs(left=HandInput(thumbstick=(0.1, -0.1)))) == MoveCommand()
    walker = placed([])
    walker.step(HEAD, move_command(Inputs(left=HandInput(thumbstick=(0.0, 0.5)))), FRAME_S)
    with_keys = placed([])
    with_keys.step(HEAD, move_command(Inputs(keys=KeyInput(walk=(0, 1)))), FRAME_S)
    assert walker.avatar == with_keys.avatar
    assert move_command(Inputs(right=HandInput(thumbstick=(1.0, 0.0)))).turn_rate == -1.0


def test_without_a_floor_the_ground_is_level_and_endless() -> None:
    walker = placed([], x=0.0, z=0.0)
    for _ in range(900):
        walker.step(HEAD, EAST, FRAME_S)
    assert feet_of(walker, HEAD) == pytest.approx([14.0, 0.0, 0.0])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["temple", "mountain"])
def test_shipped_scenes_can_be_walked(name: str) -> None:
    scene = load_scene(name)
    walker = Locomotion(SPEED_M_S)
    walker.send(spawn=scene.spawn, floors=Floors(scene.walkable))
    walker.arrive(HEAD)
    rng = np.random.default_rng(1)
    seen = []
    for _ in range(60):
        command = MoveCommand(*rng.uniform(-1, 1, 2))
        for _ in range(40):
            walker.step(HEAD, command, 0.05)
        seen.append(feet_of(walker, HEAD))
        assert distance_beside(list(scene.walkable), seen[-1]) < 1e-6
    assert np.ptp(np.array(seen)[:, 0]) > 5


def test_a_ramp_in_a_side_car_rises_from_foot_to_top(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    text = """[[walkable]]
    height_m = 1.0
    polygon_xz = [[2, 0], [4, 0], [4, 1], [2, 1]]
    ramp = { foot_xz = [2, 0], top_xz = [4, 0], top_m = 2.0 }
    """
    scene.write_text(text)
    assert read_side_car(scene).walkable[0].floor().height_m == 0.0
    assert read_side_car(scene).walkable[0].floor().slope_xz == (0.5, 0.0)
    scene.write_text(text.replace("top_xz = [4, 0]", "top_xz = [2, 0]"))
    with pytest.raises(InputError, match="same place"):
        read_side_car(scene)


ASIDE, MIDDLE = MoveCommand(turn_rate=-1.0), MoveCommand()


def snapping(degrees=30.0) -> Locomotion:
    walker = Locomotion(SPEED_M_S, snap_turn_deg=degrees)
    walker.send(spawn=Pose(), floors=Floors([L_SHAPE]))
    walker.arrive(HEAD)
    return walker


def test_a_snap_turn_comes_once_for_each_push_of_the_stick() -> None:
    walker = snapping()
    commands = [ASIDE, MIDDLE, ASIDE, ASIDE, MIDDLE, MoveCommand(turn_rate=0.3), ASIDE]
    turned = [walker.step(HEAD, command, FRAME_S) for command in commands]
    # A stick that is held aside on arrival turns nobody.
    assert turned == [False, False, True, False, False, True, False]
    assert walker.avatar.orientation == pytest.approx([0, 0, 0, 1], abs=1e-12)


def test_a_stick_that_trembles_where_it_begins_to_turn_turns_once() -> None:
    walker = snapping()
    places = [0.1, 0.2, 0.251, 0.249, 0.252, 0.248, 0.26, 0.9, 0.9, 0.26, 0.249, 0.251, 0.2, 0.0]
    turned = [
        walker.step(HEAD, move_command(Inputs(right=HandInput(thumbstick=(x, 0.0)))), FRAME_S)
        for x in places
    ]
    assert turned.count(True) == 1
    assert walker.step(HEAD, move_command(Inputs(right=HandInput(thumbstick=(0.9, 0.0)))), FRAME_S)


@given(heads, st.floats(1, 180))
def test_a_snap_turn_has_its_angle_about_the_head(head: Pose, degrees: float) -> None:
    walker = snapping(degrees)
    before = walker.avatar @ head
    walker.step(head, MIDDLE, FRAME_S)
    assert walker.step(head, ASIDE, FRAME_S)
    after = walker.avatar @ head
    np.testing.assert_allclose(after.position, before.position, atol=1e-12)
    to_the_right = axis_angle([0.0, 1.0, 0.0], -np.radians(degrees))
    expected = Pose(before.position, to_the_right) @ Pose(orientation=before.orientation)
    np.testing.assert_allclose(after.matrix(), expected.matrix(), atol=1e-9)


def test_the_mouse_turns_smoothly_beside_snap_turns() -> None:
    walker = snapping()
    assert not walker.step(HEAD, MoveCommand(turn_rad=0.1), FRAME_S)
    np.testing.assert_allclose(walker.avatar.orientation, axis_angle([0.0, 1.0, 0.0], 0.1))


@pytest.mark.parametrize("turning_deg_s", [30.0, 60.0, 120.0])
def test_the_stick_turns_at_the_rate_of_the_protocol(turning_deg_s):
    walks = Locomotion(turning_deg_s=turning_deg_s)
    walks.send(spawn=Pose(), floors=Floors())
    walks.arrive(Pose())
    for _ in range(10):
        walks.step(Pose(), MoveCommand(turn_rate=1.0), 0.05)
    yaw_rad = np.radians(0.5 * turning_deg_s)
    ahead = [-np.sin(yaw_rad), 0.0, -np.cos(yaw_rad)]
    np.testing.assert_allclose(walks.avatar.forward, ahead, atol=1e-9)
