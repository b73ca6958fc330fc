"""Tasks: what they show and count, that the seed decides them, and that their rows are kept."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.oracles.raycast import cast
from tests.support.exchange import cell
from tests.support.places import ROOT
from tests.support.study import AheadHeadset, Scripted, read_rows
from tests.support.tasks import PROTOCOL, do, doing_protocol, room, with_own_tasks
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.geometry import Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.headset.inputs import HandInput, Inputs
from vrcomfort.protocol import load_protocol, task_code_of
from vrcomfort.report.measures import measure_of, values_of
from vrcomfort.report.study_data import read_study
from vrcomfort.scene.load import load_scene
from vrcomfort.scene.markers import Markers
from vrcomfort.scene.ray_cast import RayCaster
from vrcomfort.tasks import Ball, Surroundings, TaskFrame, read_task_code
from vrcomfort.tasks.aiming import Aiming
from vrcomfort.tasks.exploration import Exploration
from vrcomfort.tasks.fixation import Fixation
from vrcomfort.tasks.follow_path import FollowPath
from vrcomfort.tasks.search import VisualSearch


def around(seed=0, *, free_m=np.inf, duration_s=60.0):
    lamp = Ball(np.array([1.0, 0.0, -2.0]), 0.2)
    vase = Ball(np.array([-1.0, 0.0, -2.0]), 0.2)
    things = {"lamp": lamp, "vase": vase}
    return Surroundings(
        np.random.default_rng(seed),
        duration_s,
        Pose(),
        lambda name: lambda _: things[name],
        lambda _: free_m,
    )


def towards(point, *, off_deg=0.0):
    aim = Pose(orientation=turn_to(normalize(np.asarray(point, float))))
    return aim @ Pose(orientation=yaw_pitch_roll(np.radians(off_deg), 0.0, 0.0))


def rows_of(study, participant="P01", session=1):
    return read_rows(study / f"sub-{participant}" / f"ses-{session}" / "tasks.csv")


def aimed(seed=0, *, off_deg=0.0, late_s=0.5, seconds=40.0, **settings):
    """Play an aiming task with somebody who shoots each target once, `late_s` after it came."""
    task = Aiming(name="shoot", kind="aiming", **settings).start(around(seed))
    results, shot = [], set()
    for time_s in np.arange(0.0, seconds, 0.05):
        demand = task.demand()
        ready = demand is not None and time_s >= demand.since_s + late_s - 1e-9
        pressed = ()
        if ready and demand.since_s not in shot:
            shot.add(demand.since_s)
            pressed = (towards(demand.position_m, off_deg=off_deg),)
        results += task.step(TaskFrame(float(time_s), Pose(), pressed=pressed))
    return [*results, *task.finish(seconds)]


def test_who_aims_well_hits_every_target_and_is_as_fast_as_they_shoot():
    results = aimed(jitter_s=0.0)
    targets = [each for each in results if each.kind == "target"]
    assert [each.hit for each in targets] == [1] * 10
    assert {each.reaction_s for each in targets} == {0.5}
    assert [each.time_s for each in targets] == pytest.approx([4.0 * k for k in range(10)])
    (trial,) = (each for each in results if each.kind == "trial")
    assert (trial.targets, trial.hits, trial.shots, trial.score) == (10, 10, 10, 10.0)


def test_a_shot_beside_a_target_misses_it_by_the_angle_that_it_was_off():
    results = aimed(off_deg=1.5, diameter_deg=2.0)
    shots = [each for each in results if each.kind == "shot"]
    assert len(shots) == 10
    assert {each.hit for each in shots} == {0}
    assert [each.error_deg for each in shots] == pytest.approx([1.5] * 10, abs=1e-3)
    assert all(each.hit == 1 for each in aimed(off_deg=0.9) if each.kind == "shot")


def test_the_seed_decides_where_and_when_targets_appear():
    places = [[r.position_m for r in aimed(seed) if r.kind == "target"] for seed in (1, 1, 2)]
    assert places[0] == places[1]
    assert places[0] != places[2]


def test_targets_appear_in_the_cone_and_within_their_distances():
    targets = [
        np.array(r.position_m)
        for seed in range(20)
        for r in aimed(seed, field_deg=30.0, distance_m=(1.0, 3.0))
        if r.kind == "target"
    ]
    lengths = np.linalg.norm(targets, axis=1)
    aside_deg = np.degrees(np.arccos(-np.array(targets)[:, 2] / lengths))
    assert aside_deg.max() <= 15.01
    assert aside_deg.max() > 13.0  # and they fill it
    assert lengths.min() >= 0.999
    assert lengths.max() <= 3.001


def test_a_target_is_never_behind_a_wall():
    task = Aiming(name="shoot", kind="aiming", distance_m=(2.0, 4.0)).start(around(free_m=1.0))
    for time_s in np.arange(0.0, 2.0, 0.1):
        task.step(TaskFrame(float(time_s), Pose()))
    (ball,) = task.balls()
    assert np.linalg.norm(ball.position_m) == pytest.approx(0.9)


def test_places_of_the_scene_never_come_twice_in_a_row():
    places = ((0.0, 0.0, -2.0), (1.0, 0.0, -2.0), (0.0, 1.0, -2.0))
    found = [r.position_m for r in aimed(places_m=places, seconds=200.0) if r.kind == "target"]
    assert set(found) == set(places)
    assert all(a != b for a, b in pairwise(found))


def test_a_search_ends_with_what_was_pointed_at_and_goes_on_after_its_time():
    settings = VisualSearch(
        name="find", kind="search", things=("lamp", "vase"), order="as_written", within_s=5.0
    )
    task = settings.start(around())
    assert task.wanted == "lamp"
    beside = task.step(TaskFrame(1.0, Pose(), pressed=(towards([-1.0, 0.0, -2.0]),)))
    assert [(each.kind, each.hit) for each in beside] == [("shot", 0)]
    found = task.step(TaskFrame(2.0, Pose(), pressed=(towards([1.0, 0.0, -2.0]),)))
    assert [(each.kind, each.what, each.hit) for each in found] == [
        ("shot", "lamp", 1),
        ("target", "lamp", 1),
    ]
    assert found[1].reaction_s == 2.0
    assert task.wanted == "vase"
    (missed,) = task.step(TaskFrame(7.1, Pose()))
    assert (missed.what, missed.hit, missed.reaction_s) == ("vase", 0, None)
    (trial,) = task.finish(8.0)
    assert (trial.targets, trial.hits, trial.shots, trial.score) == (2, 1, 2, 1.0)


def test_the_distance_from_a_path_is_that_seen_from_above():
    path = ((0.0, 1.0, 0.0), (0.0, 1.0, -4.0), (4.0, 1.0, -4.0))
    task = FollowPath(name="follow", kind="follow_path", path_m=path, sample_s=1.0).start(around())
    heads = [(0.5, 1.6, -2.0), (0.5, 1.7, -3.0), (2.0, 1.6, -4.0), (5.0011, 1.6, -4.0)]
    rows = [
        row
        for time_s, head in enumerate(heads)
        for row in task.step(TaskFrame(float(time_s), Pose(np.array(head))))
    ]
    assert [row.distance_m for row in rows] == [0.5, 0.5, 0.0, 1.0011]
    (ball,) = task.balls()
    assert ball.position_m == pytest.approx([0.0, 1.0, -3.0])  # 3 s at 1 m/s
    assert task.finish(4.0)[-1].score == 0.5003


def test_looking_at_points_is_measured_by_the_eyes_and_blinks_do_not_count():
    settings = Fixation(
        name="look", kind="fixation", points=((0.0, 0.0, 1.0), (10.0, 0.0, 1.0)),
        order="as_written", each_s=2.0, settle_s=0.5,
    )  # fmt: skip
    task = settings.start(around())
    results = []
    for time_s in np.arange(0.0, 4.0, 0.1):
        ahead = towards([0.0, 0.0, -1.0], off_deg=1.0)
        blinks = round(time_s * 10) % 7 == 0
        results += task.step(TaskFrame(float(time_s), Pose(), gaze=None if blinks else ahead))
    *rest, trial = [*results, *task.finish(4.0)]
    assert [each.hit for each in rest] == [1, 0]
    assert [each.error_deg for each in rest] == pytest.approx([1.0, 11.0], abs=1e-3)
    assert trial.score == pytest.approx(0.5, abs=0.05)


def test_exploration_sums_the_way_that_was_gone():
    task = Exploration(name="go", kind="exploration", sample_s=1.0).start(around())
    for time_s in np.arange(0.0, 10.01, 0.1):
        task.step(TaskFrame(float(time_s), Pose(np.array([time_s, 1.6, 0.0]))))
    assert task.finish(10.0)[-1].score == pytest.approx(10.0)


def opaque_parts(scene):
    """Return a scene without what the two ray casts take differently."""
    opaque = {k for k, each in enumerate(scene.materials) if each.alpha_mode == "OPAQUE"}

    def part(node):
        mesh = tuple(k for k in node.mesh if scene.primitives[k].material in opaque)
        return replace(node, mesh=mesh, lod=())

    return replace(scene, nodes=tuple(map(part, scene.nodes)))


def test_rays_meet_what_an_independent_ray_cast_meets():
    scene = load_scene("temple")
    solid = opaque_parts(scene)
    caster = RayCaster(solid)
    eye = scene.spawn @ Pose(np.array([0.0, 1.6, 0.0]))
    rng = np.random.default_rng(3)
    rays = [
        eye @ Pose(orientation=yaw_pitch_roll(*rng.uniform(-0.7, 0.7, 2), 0.0)) for _ in range(12)
    ]
    wanted = cast(solid, 0.0, [r.position for r in rays], [r.forward for r in rays], head=eye)
    found = [caster.cast(ray).distance_m for ray in rays]
    assert np.isfinite(wanted).sum() >= 6
    np.testing.assert_allclose(found, wanted, rtol=1e-4)


def test_rays_meet_what_turns_wherever_it_is_at_a_time():
    """Arms and planets of the temple's orrery, which rays pass that miss all that is at rest."""
    solid = opaque_parts(load_scene("temple"))
    caster = RayCaster(solid)
    eye, orrery = np.array([-0.7, 1.6, -3.9]), np.array([-1.85, 1.55, -5.1])
    rng = np.random.default_rng(5)
    met = 0
    for time_s in rng.uniform(0.0, 20.0, 2):
        aimed = orrery + rng.uniform(-0.42, 0.42, (40, 3)) * [1.0, 0.3, 1.0]
        rays = [Pose(eye, turn_to(normalize(each - eye))) for each in aimed]
        found = [caster.cast(ray, time_s) for ray in rays]
        wanted = cast(solid, time_s, [eye] * 40, [ray.forward for ray in rays])
        np.testing.assert_allclose([hit.distance_m for hit in found], wanted, rtol=1e-4)
        met += sum(hit.node.startswith("orrery_") for hit in found)
    assert met > 4


def test_a_ray_names_the_node_that_it_meets():
    caster = RayCaster(room())
    assert caster.cast(towards([1.0, 0.0, -2.0])).node == "lamp"
    assert caster.cast(towards([0.0, 0.0, -1.0])) == (pytest.approx(4.95), "wall")
    assert caster.cast(towards([0.0, 0.0, 1.0])).node == ""


def test_balls_face_outwards_stand_where_they_are_put_and_grow_there():
    markers = Markers(room(), [(1.0, 0.0, 0.0)])
    caster = RayCaster(markers.scene)
    assert caster.cast(towards([0.0, 0.0, -1.0]), 0.0).node == "wall"
    ball = (np.array([0.0, 0.0, -3.0]), 0.5)
    markers.place([ball])  # there, and without a size, so that nothing leaves a streak
    assert markers.scene.world_from_node(0.1)[-1, :3, 3] == pytest.approx([0.0, 0.0, -3.0])
    assert caster.cast(towards([0.0, 0.0, -1.0]), 0.1).node == "wall"
    markers.place([ball])
    found = caster.cast(towards([0.0, 0.0, -1.0]), 0.2)
    assert found == (pytest.approx(2.5, abs=0.02), "marker_0")
    markers.place([None])
    assert caster.cast(towards([0.0, 0.0, -1.0]), 0.3).node == "wall"


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("doing")
    for name in ("P01", "P02"):
        assert do(folder, participant=name).status == "completed"
    return folder / "S"


@pytest.mark.smoke
def test_simulated_participants_do_a_task_and_every_shot_is_kept(study):
    rows = rows_of(study)
    trials = [row for row in rows if row["kind"] == "trial"]
    assert [(row["trial"], row["task"], row["targets"]) for row in trials] == [
        ("1", "shoot", "5"),
        ("2", "shoot", "5"),
    ]
    for trial in trials:
        own = [row for row in rows if row["trial"] == trial["trial"]]
        shots = [row for row in own if row["kind"] == "shot"]
        assert int(trial["shots"]) == len(shots) >= 5
        assert int(trial["hits"]) == sum(row["hit"] == "1" for row in shots) >= 1
    shown = {row["trial"]: row for row in read_rows(study / "sub-P01/ses-1/trials.csv")}
    for row in rows:
        trial = shown[row["trial"]]
        assert float(trial["start_s"]) <= float(row["onset_s"]) <= float(trial["end_s"])
        assert row["condition"] == trial["condition"]


def test_the_same_seed_gives_the_same_rows_and_each_person_and_trial_another_task(study, tmp_path):
    do(tmp_path)
    assert rows_of(tmp_path / "S") == rows_of(study)
    places = {
        (who, row["trial"]): row["x_m"]
        for who in ("P01", "P02")
        for row in rows_of(study, who)
        if row["kind"] == "target" and row["number"] == "1"
    }
    assert len(set(places.values())) == 4


def test_a_plan_reads_hits_precision_and_reaction_times(study):
    read = read_study(study)
    for name, least, most in (
        ("tasks.hits", 1, 5),
        ("tasks.targets_hit_percent", 20, 100),
        ("tasks.shots_hit_percent", 5, 100),
        ("tasks.reaction_s", 0.2, 3.0),
        ("tasks.error_deg", 0.1, 5.0),
    ):
        values = values_of(read, measure_of(name))
        assert {(v.participant, v.condition) for v in values} == {
            (who, condition) for who in ("P01", "P02") for condition in ("plain", "blur")
        }
        assert all(least <= v.number <= most for v in values), name
    rows = [row for row in rows_of(study) if row["kind"] == "target" and row["trial"] == "1"]
    (hits,) = (
        v.number
        for v in values_of(read, measure_of("tasks.targets_hit_percent"))
        if (v.participant, v.trial) == ("P01", "1")
    )
    assert hits == 100 * sum(row["hit"] == "1" for row in rows) / len(rows)


def test_verify_knows_the_file_and_sees_a_row_that_cannot_be(study, tmp_path):
    assert not verify_study(study).faults
    shutil.copytree(study, tmp_path / "S")
    file = tmp_path / "S" / "sub-P01/ses-1/tasks.csv"
    cell(file, 3, "condition", "elsewhere")
    cell(file, 4, "trial", "9")
    (tmp_path / "S" / "sub-P01/ses-1/checksums.sha256").unlink()
    told = [str(each) for each in verify_study(tmp_path / "S").faults]
    assert len(told) == 2
    assert "condition is elsewhere" in told[0]
    assert "no attempt 1 at trial 9" in told[1]


def test_anonymising_keeps_results_and_leaves_out_where_things_were(study, tmp_path):
    anonymise(study, tmp_path / "shared", AnonymisingOptions(seed=1))
    (file, *_) = sorted((tmp_path / "shared").rglob("tasks.csv"))
    rows = read_rows(file)
    assert {row["x_m"] for row in rows} == {""}
    assert any(row["hit"] == "1" for row in rows)
    assert {row["participant"] for row in rows} == {file.parents[1].name.removeprefix("sub-")}
    assert not verify_study(tmp_path / "shared").faults


def test_an_exposure_that_is_shown_again_counts_alone(tmp_path):
    class Breaks(AheadHeadset):
        def frames(self):
            for each in super().frames():
                if each.index == 150:
                    raise KeyboardInterrupt
                yield each

    assert do(tmp_path, headset=Breaks).status == "aborted"
    file = tmp_path / "S" / "sub-P01/ses-1/tasks.csv"
    with file.open("ab") as stream:
        stream.write(b"P01,1,1,plain,1,shoot,sh")  # the power went
    assert do(tmp_path, resume=True).status == "completed"
    rows = rows_of(tmp_path / "S")
    assert (file.parent / "tasks.csv.cut").exists()
    assert {(row["attempt"], row["resumed"]) for row in rows if row["trial"] == "1"} == {
        ("1", "0"),
        ("2", "1"),
    }
    found = verify_study(tmp_path / "S").findings
    assert not [each for each in found if each.fault and "tasks.csv" in each.file]
    again = [row for row in rows if row["attempt"] == "2" and row["kind"] == "target"]
    first = [row for row in rows if row["trial"] == "1" and row["kind"] == "target"]
    assert again[0]["x_m"] == first[0]["x_m"]  # the same targets
    kept = read_study(tmp_path / "S").tasks
    assert {row["attempt"] for row in kept if row["trial"] == "1"} == {"2"}


class Triggers(AheadHeadset):
    """A headset whose right hand points at the lamp, and presses once a second."""

    def frames(self):
        for each in super().frames():
            self.index = each.index
            yield each

    def inputs(self):
        aim = towards([1.0, 0.0, -2.0])
        return Inputs(right=HandInput(aim, select=self.index % 10 == 5))


FIND = PROTOCOL.replace('kind = "aiming"', 'kind = "search"\nthings = ["lamp", "wall"]')


def test_people_point_with_their_hands(tmp_path):
    assert do(tmp_path, FIND, respondent=Scripted(), headset=Triggers).status == "completed"
    rows = rows_of(tmp_path / "S")
    found = {row["what"] for row in rows if row["kind"] == "target" and row["hit"] == "1"}
    assert "lamp" in found
    lamp = next(row for row in rows if row["what"] == "lamp" and row["kind"] == "shot")
    assert float(lamp["error_deg"]) == pytest.approx(0.0, abs=1e-3)
    events = read_rows(tmp_path / "S" / "sub-P01/ses-1/events.csv")
    told = [each["detail"] for each in events if each["name"] == "task_target"]
    assert set(told) == {"lamp", "wall", ""}  # for the experimenter, who names it


def test_a_thing_that_the_scene_does_not_have_is_told_with_what_it_has(tmp_path):
    with pytest.raises(InputError, match=r"names `lamb`.*did you mean `lamp`"):
        do(tmp_path, FIND.replace('"lamp"', '"lamb"'))


NONE = PROTOCOL.replace('name = "blur"\n', 'name = "blur"\ntask = "none"\n')


def test_a_condition_may_name_its_own_task_or_none(tmp_path):
    assert do(tmp_path, NONE).status == "completed"
    assert {row["condition"] for row in rows_of(tmp_path / "S")} == {"plain"}


OWN = '''
"""Nod: how often the head went up and down."""
from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.tasks import Result, Task, TaskSettings


class Nod(TaskSettings):
    kind: str
    every: Annotated[int, Field(ge=1)] = 1
    """Frames from one row to the next."""

    def start(self, surroundings):
        return _Nod(self)


class _Nod(Task):
    def __init__(self, settings):
        self._settings = settings
        self._frames = 0

    def step(self, moment):
        self._frames += 1
        if self._frames % self._settings.every:
            return []
        number = self._frames // self._settings.every
        return [Result("sample", number, "", moment.time_s, distance_m=1.0)]

    def finish(self, time_s):
        return [Result("trial", 1, "", 0.0, score=float(self._frames))]


TASK = Nod
'''


def test_a_task_of_the_labs_own_is_a_file_beside_the_protocol(tmp_path):
    (tmp_path / "nod.py").write_text(OWN)
    text = PROTOCOL.replace('kind = "aiming"', 'kind = "nod.py"\nevery = 50')
    assert do(tmp_path, text).status == "completed"
    rows = rows_of(tmp_path / "S")
    assert [row["kind"] for row in rows] == [*["sample"] * 4, "trial"] * 2
    assert [row["score"] for row in rows if row["kind"] == "trial"] == ["200.0", "200.0"]
    kept = json.loads((tmp_path / "S/sub-P01/ses-1/manifest.json").read_text())
    assert kept["settings"]["tasks"] == [{"name": "shoot", "kind": "nod.py", "every": 50}]
    assert kept["task_code"] == {"nod.py": hashlib.sha256(OWN.encode()).hexdigest()}
    assert not verify_study(tmp_path / "S").faults


def test_the_task_of_the_docs_counts_nods(tmp_path):
    page = (ROOT / "docs/tasks.md").read_text(encoding="utf-8")
    (code,) = re.findall("```python\n(.*?)```", page, flags=re.DOTALL)
    (tmp_path / "count_nods.py").write_text(code)
    settings = read_task_code(tmp_path, ["count_nods.py"]).run("count_nods.py")
    task = settings(name="nod", kind="count_nods.py", depth_deg=10.0).start(around())
    for time_s, pitch_deg in enumerate([0, -15, -15, 0, -5, 0, -12, 3, 0]):
        pose = Pose(orientation=yaw_pitch_roll(0.0, np.radians(pitch_deg), 0.0))
        task.step(TaskFrame(float(time_s), pose))
    assert task.finish(9.0)[-1].score == 2.0


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (PROTOCOL.replace('task = "shoot"', 'task = "shot"'), "no task `shot`.*`shoot`"),
        (PROTOCOL.replace("aiming", "aimin"), "no such task.*did you mean `aiming`"),
        (PROTOCOL.replace("aiming", "gone.py"), "no such task file"),
        (PROTOCOL.replace('"aiming"', '"aiming"\nevery = 3'), "`every` is without a unit"),
        (PROTOCOL.replace('"aiming"', '"aiming"\nevery_s = 3.0'), "two targets at a time"),
        (PROTOCOL.replace('"shoot"', '"none"'), "says that there is no task"),
        (PROTOCOL.replace("blur = 2.0", "blurr = 2.0"), "no condition `blurr`"),
    ],
)
def test_faults_are_told_with_their_line(tmp_path, text, told):
    with pytest.raises(InputError, match=told) as refusal:
        doing_protocol(tmp_path, text)
    assert refusal.value.line is not None


@pytest.mark.parametrize(
    ("code", "keys", "told"),
    [
        ("1 / 0", "", "cannot be read: ZeroDivisionError"),
        ("", "", "has no `TASK"),
        (OWN, "every = 0", "`every`.*greater than or equal"),
        (OWN, "evry = 2", "`evry`"),
    ],
)
def test_faults_of_a_task_file_are_told_where_it_is_run(tmp_path, code, keys, told):
    (tmp_path / "nod.py").write_text(code)
    protocol = doing_protocol(tmp_path, PROTOCOL.replace('"aiming"', f'"nod.py"\n{keys}'))
    with pytest.raises(InputError, match=told) as refusal:
        with_own_tasks(protocol)
    assert refusal.value.line is not None


@pytest.mark.parametrize("kind", ["absolute", "../elsewhere/nod.py", "code.py", "folder/nod.py"])
def test_a_task_file_outside_of_the_protocols_folder_is_refused(tmp_path, kind):
    study, code = tmp_path / "study", tmp_path / "elsewhere" / "nod.py"
    for folder in (study, code.parent):
        folder.mkdir()
    code.write_text(OWN)
    (study / "code.py").symlink_to(code)
    (study / "folder").symlink_to(code.parent)
    kind = str(code) if kind == "absolute" else kind
    with pytest.raises(InputError, match=r"outside of the protocol's folder.*copy it into") as no:
        doing_protocol(study, PROTOCOL.replace("aiming", kind))
    assert no.value.line is not None


def test_a_task_file_in_a_folder_below_the_protocols_may_be_a_link_within_it(tmp_path):
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks/nod.py").write_text(OWN)
    (tmp_path / "now.py").symlink_to("tasks/nod.py")
    for kind in ("tasks/nod.py", "now.py"):
        protocol = doing_protocol(tmp_path, PROTOCOL.replace("aiming", kind))
        assert with_own_tasks(protocol).task_code.keys() == {kind}


MARKING = """
from pathlib import Path
Path(__file__).with_name("ran").touch()
"""


@pytest.mark.parametrize(
    "command",
    [
        "check study.toml --no-draw",
        "design study.toml",
        "schema protocol",
        "status data",
        "verify data",
        pytest.param("plan study.toml --size 64x64", marks=pytest.mark.slow),
        pytest.param("report data --out report", marks=pytest.mark.slow),
    ],
)
def test_a_command_that_reads_a_protocol_runs_and_writes_nothing(
    tmp_path, monkeypatch, run, marked, command
):
    monkeypatch.chdir(shutil.copytree(marked, tmp_path / "study"))
    before = {*Path().rglob("*")}
    code, out, err = run(*command.split())
    assert code == 0, out + err
    written = {*Path().rglob("*")} - before
    assert {each.parts[0] for each in written} <= {"report"}
    if command.startswith("check"):
        assert "the code of the task `shoot` (nod.py) is not run here" in err


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    """Return a folder with a protocol whose task file leaves a file, and its simulated study."""
    folder = tmp_path_factory.mktemp("marked")
    (folder / "nod.py").write_text(OWN + MARKING)
    text = PROTOCOL.replace("aiming", "nod.py").replace("room.glb", "temple")
    file = folder / "study.toml"
    file.write_text(text.replace("exposure_s = 20.0", "exposure_s = 1.0\nparticipants = 2"))
    words = ["simulate", str(file), "-n", "2", "--no-draw", "--out", str(folder / "data")]
    trust = task_code_of(load_protocol(file)).sha256
    told = CliRunner().invoke(app, [*words, "--trust", trust])
    assert told.exit_code == 0, told.output
    assert re.search(r"the code of the task file nod\.py is run \(SHA-256 \w{64}\)", told.stderr)
    (folder / "ran").unlink()
    return folder
