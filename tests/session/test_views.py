"""Views: trials of their own length, from named places, and along camera paths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from typer.testing import CliRunner

from tests.support.session import run
from tests.support.study import PROTOCOL, AheadHeadset, LateFocus, Scripted, read_rows
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.headset.locomotion import Locomotion, MoveCommand
from vrcomfort.protocol import SceneView, load_protocol, parse_protocol
from vrcomfort.records import session_folder
from vrcomfort.scene.camera_path import CameraPath
from vrcomfort.scene.floors import Floors
from vrcomfort.session.start_pose import place_faults, start_pose_of, without_meshes
from vrcomfort.settings.camera_path import PathPoint

SIDE_CAR = """\
[viewpoints.corner]
position = [3.0, 0.0, 2.0]
yaw_deg = 90.0

[paths.rail]
points = [
  { time_s = 0.0, position = [0.0, 0.0, 0.0] },
  { time_s = 4.0, position = [0.0, 0.0, -4.0] },
  { time_s = 8.0, position = [4.0, 0.0, -4.0] },
]
"""

VIEWS = """\
[[views]]
name = "corner"
scene = "room.glb"
viewpoint = "corner"
exposure_s = 2.0

[[views]]
name = "ride"
scene = "room.glb"
path = "rail"
exposure_s = 6.0

[[conditions]]
name = "plain"
"""


def study_text(views: str = VIEWS, scenes: str = '"corner", "ride"') -> str:
    head, _, rest = PROTOCOL.partition('[[conditions]]\nname = "plain"\n')
    head = head.replace('scenes = ["room.glb"]', f"scenes = [{scenes}]")
    order = rest.partition("sessions = [")
    ratings = order[2].partition("[[questionnaires]]")
    sessions = """
  [{ scene = "corner", condition = "plain" }, { scene = "ride", condition = "blur" }],
]

"""
    body = f"{order[0]}sessions = [{sessions}[[questionnaires]]{ratings[2]}"
    return f"{head}{views}{body.partition('[ratings]')[0]}"


def write(tmp_path, text: str, side_car: str = SIDE_CAR):
    (tmp_path / "room.glb").touch()
    (tmp_path / "room.toml").write_text(side_car, encoding="utf-8")
    file = tmp_path / "tiny.toml"
    file.write_text(text, encoding="utf-8")
    return file


def shown(tmp_path, **more):
    """Run a session; return the rows of its trials and frames, and the scenes led into."""
    protocol = load_protocol(write(tmp_path, study_text()))
    led: list[tuple[str, Pose, bool]] = []

    def headset_for(name, scene):
        led.append((name, scene.spawn, scene.on_foot))
        return AheadHeadset()

    run(
        protocol,
        "P01",
        study=tmp_path / "S",
        load_scene=without_meshes,
        headset_for=headset_for,
        renderer=LateFocus(),
        respondent=Scripted(),
        **more,
    )
    folder = session_folder(tmp_path / "S", "P01", 1)
    return read_rows(folder / "trials.csv"), read_rows(folder / "frames.csv"), led


@pytest.fixture(scope="module")
def ridden(tmp_path_factory):
    return shown(tmp_path_factory.mktemp("ridden"))


def test_a_trial_is_as_long_as_its_view_and_begins_where_that_says(ridden):
    trials, frames, led = ridden
    lasted = [float(row["end_s"]) - float(row["start_s"]) for row in trials]
    assert lasted == [pytest.approx(2.0), pytest.approx(6.0)]
    assert [row["scene"] for row in trials] == ["corner", "ride"]
    assert [sum(row["trial"] == str(n) for row in frames) for n in (1, 2)] == [20, 60]
    (corner_name, corner, on_foot), (_, start, carried_on_foot) = led
    assert corner_name == "room.glb"
    assert corner.position.tolist() == [3.0, 0.0, 2.0]
    assert on_foot
    assert start.position.tolist() == [0.0, 0.0, 0.0]
    assert not carried_on_foot


def test_a_shortened_study_shortens_what_is_longer_and_keeps_the_pace_of_paths(tmp_path):
    trials, frames, _ = shown(tmp_path, exposure_s=4.0)
    lasted = [float(row["end_s"]) - float(row["start_s"]) for row in trials]
    assert lasted == [pytest.approx(2.0), pytest.approx(4.0)]
    ride = [row for row in frames if row["trial"] == "2"]
    assert float(ride[-1]["avatar_z_m"]) == pytest.approx(-3.9, abs=0.1)


def test_frames_along_a_path_are_where_the_path_is_at_their_time(ridden):
    _, frames, _ = ridden
    ride = [row for row in frames if row["trial"] == "2"]
    points = [
        PathPoint(time_s=t, position=p)
        for t, p in ((0, (0, 0, 0)), (4, (0, 0, -4)), (8, (4, 0, -4)))
    ]
    path = CameraPath(points)
    for index in (0, 17, 40, 59):
        there = [float(ride[index][f"avatar_{axis}_m"]) for axis in "xyz"]
        assert there == pytest.approx(path.moved(index / 10).position.tolist(), abs=1e-9)
    assert [row["discontinuity"] for row in ride[:3]] == ["1", "0", "0"]


def test_a_path_reaches_each_point_at_its_time_and_overshoots_nowhere():
    random = np.random.default_rng(5)
    times_s = np.cumsum(random.uniform(0.5, 3.0, 12))
    times_s -= times_s[0]
    places = random.uniform(-5, 5, (12, 3))
    points = [
        PathPoint(time_s=float(t), position=tuple(map(float, p)))
        for t, p in zip(times_s, places, strict=True)
    ]
    path = CameraPath(points)
    assert path.positions(times_s) == pytest.approx(places)
    for before, after, a, b in zip(times_s, times_s[1:], places, places[1:], strict=False):
        between = path.positions(np.linspace(before, after, 50))
        assert (between >= np.minimum(a, b) - 1e-9).all()
        assert (between <= np.maximum(a, b) + 1e-9).all()
    fine = np.linspace(0, path.duration_s, 20_001)
    speed = np.diff(path.positions(fine), axis=0) / (fine[1] - fine[0])
    assert np.abs(np.diff(speed, axis=0)).max() < 0.1  # no jump of speed at any point
    inside = PchipInterpolator(times_s, places)
    middle = np.linspace(times_s[1], times_s[-2], 100)
    assert path.positions(middle) == pytest.approx(inside(middle))  # at the ends it goes straight
    assert path.pose(-1.0).position == pytest.approx(places[0])
    assert path.pose(1e4).position == pytest.approx(places[-1])


def test_headings_look_ahead_and_turn_the_shorter_way():
    ahead = CameraPath(
        [
            PathPoint(time_s=0, position=(0, 0, 0)),
            PathPoint(time_s=1, position=(1, 0, 0)),
            PathPoint(time_s=2, position=(1, 0, 0)),
        ]
    )
    right = ahead.pose(1.0).matrix()[:3, :3] @ np.array([0, 0, -1])
    assert right == pytest.approx([1, 0, 0])
    written = CameraPath(
        [
            PathPoint(time_s=0, position=(0, 0, 0), yaw_deg=170),
            PathPoint(time_s=1, position=(0, 0, 0), yaw_deg=-170),
        ]
    )
    middle = written.pose(0.5).matrix()[:3, :3] @ np.array([0, 0, -1])
    assert middle == pytest.approx([0, 0, 1])


TURNING = [
    PathPoint(time_s=float(second), position=(0, 0, 0), yaw_deg=yaw_deg)
    for second, yaw_deg in enumerate((0, 360, 720, 350))
]


def turned_deg(path, seconds):
    """Return how far a path turns, added up over small steps."""
    fine = np.linspace(0.0, seconds, 100 * seconds + 1)
    headings = [path.pose(t).matrix()[:3, :3] @ np.array([0, 0, -1]) for t in fine]
    yaws_rad = np.unwrap([np.arctan2(-x, -z) for x, _, z in headings])
    return np.degrees(yaws_rad[-1] - yaws_rad[0])


def test_unwrapped_headings_turn_as_far_as_is_written():
    path = CameraPath(TURNING, unwrapped=True)
    assert [turned_deg(path, seconds) for seconds in (1, 2, 3)] == pytest.approx([360, 720, 350])
    assert path.shortened == ()
    assert turned_deg(CameraPath(TURNING), 3) == pytest.approx(-10)


def test_unwrapped_headings_that_are_not_written_turn_the_shorter_way():
    onwards = [*TURNING[:3], PathPoint(time_s=3.0, position=(0, 0, 0)), TURNING[3]]
    onwards[2] = onwards[2].model_copy(update={"position": (1, 0, 0)})
    onwards[3] = onwards[3].model_copy(update={"position": (2, 0, 0)})
    onwards[4] = onwards[4].model_copy(update={"time_s": 4.0, "position": (3, 0, 0)})
    assert turned_deg(CameraPath(onwards, unwrapped=True), 3) == pytest.approx(720 - 90)


def test_a_path_turns_at_the_rates_of_its_points():
    points = (
        PathPoint(time_s=0, position=(0, 0, 0), yaw_deg=10, turning_deg_s=90),
        PathPoint(time_s=5, position=(0, 0, 0), turning_deg_s=90),
        PathPoint(time_s=8, position=(0, 0, 0)),
    )
    path = CameraPath(points)
    for time_s in np.arange(0.0, 8.0, 0.25).tolist():
        facing = path.pose(time_s).forward
        yaw_rad = np.radians(10 + 90 * time_s)
        np.testing.assert_allclose(facing, [-np.sin(yaw_rad), 0, -np.cos(yaw_rad)], atol=1e-9)


def test_a_path_that_loops_begins_again_at_the_same_speed():
    corners = [(0, 0, 0), (2, 0, 0), (2, 0, -2), (0, 0, -2), (0, 0, 0)]
    points = [PathPoint(time_s=2 * k, position=at, yaw_deg=0) for k, at in enumerate(corners)]
    path = CameraPath(points, loop=True)
    assert path.closes
    times_s = np.arange(0.0, 8.0, 0.1)
    np.testing.assert_allclose(path.positions(times_s + 24.0), path.positions(times_s), atol=1e-9)
    ends = path.positions(np.array([7.99, 8.0, 8.01]))
    np.testing.assert_allclose(ends[1] - ends[0], ends[2] - ends[1], atol=1e-3)
    assert not CameraPath(points[:-1], loop=True).closes


def test_steps_of_half_a_turn_and_more_that_are_not_turned_are_known():
    found = [each[:3] for each in CameraPath(TURNING).shortened]
    assert found == [(1, 0, 360), (2, 360, 720), (3, 720, 350)]
    assert [each.turned_deg for each in CameraPath(TURNING).shortened] == pytest.approx([0, 0, -10])


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            'viewpoint = "corner"',
            'viewpoint = "corners"',
            "no viewpoint `corners`; did you mean `corner`",
        ),
        ('path = "rail"', 'path = "train"', "no path `train`"),
        (
            "exposure_s = 6.0",
            "exposure_s = 9.0",
            "ends after 8 s and the trial after 9 s; add a point",
        ),
    ],
)
def test_places_that_are_not_there_are_told_with_line(tmp_path, old, new, told):
    protocol = load_protocol(write(tmp_path, study_text().replace(old, new)))
    (fault,) = place_faults(protocol)
    assert told in str(fault)
    assert fault.line is not None
    written = protocol.toml.splitlines()[fault.line - 1]
    assert written.startswith(("viewpoint", "path"))


@pytest.mark.parametrize(
    ("views", "told"),
    [
        (
            VIEWS.replace('path = "rail"', 'path = "rail"\nviewpoint = "corner"'),
            "exclude each other",
        ),
        (VIEWS.replace('name = "ride"', 'name = "temple"'), "is a shipped scene"),
        (VIEWS.replace('name = "ride"', 'name = "fall"'), "no trial shows the view `fall`"),
        (
            VIEWS.replace('path = "rail"', "points = [{ time_s = 1, position = [0, 0, 0] }]"),
            "needs at least 2",
        ),
        (
            VIEWS.replace(
                'path = "rail"',
                "points = [{ time_s = 1.0, position = [0.0, 0.0, 0.0] }, "
                "{ time_s = 2.0, position = [0.0, 0.0, 0.0] }]",
            ),
            "a path begins at time_s = 0",
        ),
        (
            VIEWS.replace(
                'path = "rail"',
                "points = [{ time_s = 0.0, position = [0.0, 0.0, 0.0] }, "
                "{ time_s = 0.0, position = [0.0, 0.0, 0.0] }]",
            ),
            "times must rise: 0 s follows 0 s",
        ),
        (
            VIEWS.replace(
                'path = "rail"',
                "points = [{ time_s = 0.0, position = [0.0, 0.0, 0.0] }, "
                "{ time_s = 9.0, position = [0.0, 0.0, 0.0], turning_deg_s = 9.0 }]",
            ),
            "the last point has nowhere to turn to",
        ),
        (
            VIEWS.replace(
                'path = "rail"',
                "points = [{ time_s = 0.0, position = [0.0, 0.0, 0.0] }, "
                "{ time_s = 2.0, position = [0.0, 0.0, 0.0] }]",
            ),
            "the path ends after 2 s and the trial after 6 s",
        ),
    ],
)
def test_impossible_views_are_refused(tmp_path, views, told):
    with pytest.raises(InputError) as caught:
        load_protocol(write(tmp_path, study_text(views)))
    assert any(told in str(each) for each in (caught.value, *caught.value.others))


OUTSIDE = """\
[[views]]
name = "out"
scene = "temple"
points = [
  { time_s = 0.0, position = [0.0, 0.0, 0.0] },
  { time_s = 0.5, position = [0.0, 0.0, -400.0] },
]
"""


def smoke_text(views: str, scenes: str) -> str:
    from vrcomfort.resources import data_folder

    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    head, conditions, rest = text.partition("[[conditions]]")
    head = head.replace('scenes = ["temple"]', f"scenes = [{scenes}]")
    rest = rest.replace("temple = ", "# temple = ")
    return f"{head}{views}\n{conditions}{rest}"


def test_check_refuses_a_path_that_leaves_the_scene(tmp_path):
    file = tmp_path / "smoke.toml"
    file.write_text(smoke_text(OUTSIDE, '"out"'), encoding="utf-8")
    result = CliRunner().invoke(app, ["check", str(file), "--no-draw"])
    assert result.exit_code == 2
    said = " ".join(result.output.split())
    assert "the path leaves the scene after" in said
    assert "move the points there" in said


def test_a_run_refuses_a_missing_place_before_it_makes_anything(tmp_path):
    file = tmp_path / "smoke.toml"
    away = '[[views]]\nname = "away"\nscene = "temple"\nviewpoint = "moon"\n'
    file.write_text(smoke_text(away, '"away"'), encoding="utf-8")
    result = CliRunner().invoke(
        app, ["simulate", str(file), "-n", "1", "--out", str(tmp_path / "S")]
    )
    assert isinstance(result.exception, InputError)
    assert "no viewpoint `moon`" in str(result.exception)
    assert not (tmp_path / "S").exists()


def test_streaks_are_those_of_the_path(tmp_path):
    from vrcomfort.cli.check_stimuli import moments_of

    def fastest_m_s(points: str) -> float:
        view = f'[[views]]\nname = "ride"\nscene = "temple"\n{points}'
        protocol = parse_protocol(smoke_text(view, '"ride"'), file=tmp_path / "smoke.toml")
        scene = without_meshes("temple")
        speeds = []
        for before, now in moments_of(protocol, "ride", scene, (16, 16), 90.0, 5):
            moved = (now.avatar_pose @ now.head_pose).position
            moved = moved - (before.avatar_pose @ before.head_pose).position
            speeds.append(float(np.linalg.norm(moved)) * 90.0)
        return max(speeds)

    ride = """points = [
  { time_s = 0.0, position = [0.0, 0.0, 0.0] },
  { time_s = 0.5, position = [0.0, 0.0, -2.5] },
]
"""
    assert fastest_m_s(ride) == pytest.approx(5.0, abs=0.5)
    assert fastest_m_s("") == pytest.approx(1.4, abs=0.5)  # on foot, at a walk
    standing = SceneView(name="temple", scene="temple")
    assert start_pose_of(without_meshes("temple"), standing, walks=False).scene.on_foot is False


class TestLocomotionModes:
    HEAD = Pose(np.array([0.0, 1.6, 0.0]))

    def walker(self, *, on_foot: bool = True, **settings) -> Locomotion:
        walker = Locomotion(1.4, **settings)
        walker.send(spawn=Pose(), floors=Floors(), on_foot=on_foot)
        walker.arrive(self.HEAD)
        walker.step(self.HEAD, MoveCommand(), 0.01)
        return walker

    def test_nobody_walks_or_turns_where_locomotion_is_off(self):
        walker = self.walker(on_foot=False)
        walker.step(self.HEAD, MoveCommand(forward=1.0, turn_rate=1.0, turn_rad=0.5), 0.1)
        assert walker.avatar.position.tolist() == [0.0, 0.0, 0.0]
        assert walker.avatar.orientation.tolist() == [0.0, 0.0, 0.0, 1.0]

    def test_a_push_teleports_once(self):
        walker = self.walker(teleport_m=2.0)
        jumps = []
        for pushed in (True, True, False, True):
            walker.step(self.HEAD, MoveCommand(forward=float(pushed)), 0.1)
            jumps.append((walker.teleported, float(walker.avatar.position[2])))
        assert jumps == [(True, -2.0), (False, -2.0), (False, -2.0), (True, -4.0)]

    @pytest.mark.parametrize(
        ("written", "key"),
        [
            ('mode = "off"\nwalking_speed_m_s = 1.0', "walking_speed_m_s"),
            ('mode = "off"\nsnap_turn_deg = 30', "snap_turn_deg"),
            ("teleport_m = 3.0", "teleport_m"),
        ],
    )
    def test_a_key_that_does_nothing_is_refused(self, tmp_path, written, key):
        text = study_text() + f"\n[locomotion]\n{written}\n"
        with pytest.raises(InputError, match=f"`{key}` does nothing with mode"):
            load_protocol(write(tmp_path, text))
