"""A recorded session with tasks is shown again with their balls, as they were seen."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from tests.support.exchange import cell
from tests.support.session import run as run_session
from tests.support.study import Scripted, read_rows
from tests.support.tasks import with_own_tasks
from vrcomfort.api.playback import shipped_walk
from vrcomfort.api.rendering import describe_machine, make_renderer
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose
from vrcomfort.headset.inputs import HandInput, Inputs
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import load_protocol
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.replay import Comparison, ReplaySelection, read_session, replay
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene

Run = Callable[..., tuple[int, str, str]]
pytestmark = pytest.mark.slow
SIZE_PX = 64, 80
SESSION = "S/sub-P01/ses-1"
PROTOCOL = """\
name = "busy"
title = "Something to do"
exposure_s = 0.8
training_s = 0.06
scenes = ["temple"]

[order]
rule = "explicit"
[[order.sequences]]
name = "one"
sessions = [[
  { scene = "temple", condition = "streaks", task = "shoot" },
  { scene = "temple", condition = "blur", task = "walk" },
  { scene = "temple", condition = "plain", task = "juggle" },
  { scene = "temple", condition = "turned" },
]]

[[tasks]]
name = "shoot"
kind = "aiming"
every_s = 0.4
shown_s = 0.3
jitter_s = 0.1
diameter_deg = 20.0
field_deg = 0.0
distance_m = [0.5, 0.8]
aim_with = "head"

[[tasks]]
name = "walk"
kind = "follow_path"
path_m = [[-0.5, 1.5, -2.0], [0.5, 1.5, -2.0]]
diameter_m = 0.5

[[tasks]]
name = "juggle"
kind = "juggle.py"

[[conditions]]
name = "streaks"
[conditions.motion_blur]

[[conditions]]
name = "blur"
[conditions.depth_of_field]
max_radius_percent = 10

[[conditions]]
name = "plain"

[[conditions]]
name = "turned"
[conditions.depth_of_field]
law = "dioptre"
max_radius_percent = 10

[[adjustments]]
name = "sharpness"
setting = "depth_of_field.full_blur_dioptre"
range = [0.2, 8.0]
scale = "log"
sweep_s = 1.0

[[questionnaires]]
timepoint = "post"
when = "session_end"
"""
OWN = """\
import numpy as np

from vrcomfort.tasks import Ball, Result, Task, TaskSettings


class Juggle(TaskSettings):
    kind: str

    def start(self, surroundings):
        self_made = _Juggle()
        self_made.random = surroundings.random
        return self_made


class _Juggle(Task):
    looks = ((0.8, 0.1, 0.1), (0.1, 0.8, 0.1))
    now = ()

    def step(self, moment):
        ahead = moment.head.position + moment.head.forward * 0.8
        place = ahead + self.random.uniform(-0.2, 0.2, 3)
        self.now = (Ball(place, 0.1), None if moment.time_s < 0.5 else Ball(ahead, 0.05))
        return ()

    def balls(self):
        return self.now

    def finish(self, time_s):
        return (Result("trial", 1, "", 0.0, score=1.0),)


TASK = Juggle
"""
UNSEEN = {21, 22}
"""Frames that the runtime did not want drawn."""
SHOTS = {8, 32}
"""Frames in which a button goes down."""


class Busy(PlaybackHeadset):
    """A walk with a hand that presses, and in the last exposure turns a dial."""

    exposures = 0

    def frames(self) -> Iterator[Frame]:
        self.exposures += 1
        turns = self.exposures == 4
        for count, frame in enumerate(super().frames()):
            presses, push = count in SHOTS and not turns, 0.9 if count % 16 < 9 else -0.7
            stick = (0.0, push if turns else 0.0)
            self.now = Inputs(right=HandInput(Pose(), select=presses, thumbstick=stick))
            yield replace(frame, should_render=count not in UNSEEN)

    def inputs(self) -> Inputs:
        return self.now


@cache
def temple() -> Scene:
    return load_scene("temple")


@cache
def drawer() -> StereoRenderer:
    """Return what draws all replays of these tests: making it takes longer than a replay."""
    return make_renderer(SIZE_PX)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a study of three tasks, without the program of one of them."""
    folder = tmp_path_factory.mktemp("busy")
    (folder / "busy.toml").write_text(PROTOCOL)
    (folder / "juggle.py").write_text(OWN)
    protocol = with_own_tasks(load_protocol(folder / "busy.toml"))
    scene = temple()
    headset = Busy(shipped_walk("temple"), image_size_px=SIZE_PX, refresh_hz=36)
    renderer = make_renderer(SIZE_PX, hash_every=3)
    outcome = run_session(
        protocol,
        "P01",
        study=folder / "S",
        respondent=Scripted(),
        headset_for=lambda _name, scene: headset.place(spawn=scene.spawn) or headset,
        load_scene=lambda _: scene,
        renderer=renderer,
        machine=describe_machine(renderer, protocol),
    )
    assert outcome.status == "completed"
    (folder / "juggle.py").unlink()
    return folder


@pytest.fixture
def copy(place: Path, tmp_path: Path) -> Path:
    """Return a copy that may be changed."""
    return Path(shutil.copytree(place, tmp_path / "copy"))


def drawn_again(place: Path, selection: ReplaySelection | None = None) -> Comparison:
    session, comparison = read_session(place / SESSION), Comparison()
    with drawer().ctx:
        frames = replay(
            session,
            selection or ReplaySelection(),
            drawer=drawer(),
            second=None,
            load_scene=lambda _: temple(),
            size_px=SIZE_PX,
            comparison=comparison,
        )
        assert list(frames)
    return comparison


def balls_of(place: Path, trial: int) -> list[dict[str, str]]:
    return [r for r in read_rows(place / SESSION / "balls.csv") if r["trial"] == str(trial)]


def test_a_replay_with_tasks_has_the_recorded_images(place: Path) -> None:
    """Targets that come, are hit and go; one that moves; and those of a task of the lab's own."""
    images = read_rows(place / SESSION / "images.csv")
    tasks = read_rows(place / SESSION / "tasks.csv")

    comparison = drawn_again(place)

    assert {row["hit"] for row in tasks if row["kind"] == "target"} == {"0", "1"}
    assert {row["trial"] for row in images} == {"0", "1", "2", "3", "4"}
    assert (comparison.equal, comparison.compared) == (len(images), len(images))


def test_what_was_adjusted_is_drawn_as_it_was(place: Path, copy: Path) -> None:
    values = [r["value"] for r in read_rows(place / SESSION / "dials.csv") if r["kind"] == "change"]
    assert len(set(values)) > 10
    turned = drawn_again(place, ReplaySelection(trial=4))
    assert turned.compared == turned.equal > 4
    (copy / SESSION / "dials.csv").unlink()
    still = drawn_again(copy, ReplaySelection(trial=4))
    assert still.equal < still.compared


@pytest.mark.parametrize("trial", [1, 2, 3])
def test_the_balls_are_in_the_images(copy: Path, run: Run, trial: int) -> None:
    """Without what is recorded of them, images of each task are others, and this is told."""
    (copy / SESSION / "balls.csv").unlink()

    comparison = drawn_again(copy, ReplaySelection(trial=trial))

    assert comparison.equal < comparison.compared
    (note,) = (n for n in read_session(copy / SESSION).notes if "balls" in n)
    assert "there is no balls.csv; balls that its tasks showed are not drawn" in note


def test_a_part_of_an_exposure_has_its_balls_from_the_beginning(place: Path) -> None:
    rows = [r for r in read_rows(place / SESSION / "frames.csv") if r["trial"] == "1"]
    comparison = drawn_again(place, ReplaySelection(from_s=float(rows[20]["session_s"]), trial=1))
    assert comparison.compared == comparison.equal > 4


def test_a_ball_has_a_row_where_it_is_drawn_otherwise_than_before(place: Path) -> None:
    frames = {row["xr_time_ns"]: row for row in read_rows(place / SESSION / "frames.csv")}
    for trial in (1, 2, 3):
        rows = balls_of(place, trial)
        shown: dict[str, tuple[str, ...]] = {}
        for row in rows:
            frame = frames[row["xr_time_ns"]]
            assert (row["session_s"], row["trial"]) == (frame["session_s"], frame["trial"])
            state = tuple(row[name] for name in ("x_m", "y_m", "z_m", "radius_m"))
            assert shown.get(row["ball"]) != state
            shown[row["ball"]] = state
    targets = [r for r in read_rows(place / SESSION / "tasks.csv") if r["what"] == "target_1"]
    first = next(row for row in balls_of(place, 1) if float(row["radius_m"]))
    assert [float(first[n]) for n in ("x_m", "y_m", "z_m")] == pytest.approx(
        [float(targets[-1][n]) for n in ("x_m", "y_m", "z_m")], abs=1e-4
    )
    assert {row["ball"] for row in balls_of(place, 3)} == {"1", "2"}
    assert {row["red"] for row in balls_of(place, 1)} == {"0.9"}


def test_verify_reads_them_and_finds_a_ball_of_no_frame(copy: Path) -> None:
    assert verify_study(copy / "S").findings == []
    cell(copy / SESSION / "balls.csv", 4, "xr_time_ns", "1")
    told = " ".join(str(each) for each in verify_study(copy / "S").faults)
    assert "balls.csv, line 4: frames.csv has no row of this time" in told


@pytest.mark.parametrize("keep_motion", [False, True])
def test_an_anonymous_copy_has_them_only_with_the_motion(
    place: Path, tmp_path: Path, keep_motion: bool
) -> None:
    """Where targets appear is decided by where the head looks."""
    anonymise(place / "S", tmp_path / "out", AnonymisingOptions(keep_motion=keep_motion))
    (session,) = (tmp_path / "out").glob("sub-*/ses-1")
    assert (session / "balls.csv").exists() == keep_motion


def damaged_cell(session: Path) -> None:
    cell(session / "trials.csv", 3, "start_s", "soon")


def cells_missing(session: Path) -> None:
    file = session / "trials.csv"
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join([*lines[:1], "1,2\n", *lines[2:]]))


def column_missing(session: Path) -> None:
    file = session / "trials.csv"
    file.write_text(file.read_text().replace("start_s", "begin_s", 1))


def header_of_other_bytes(session: Path) -> None:
    file = session / "ratings.csv"
    file.write_bytes(b"\0" + file.read_bytes())


def header_not_utf8(session: Path) -> None:
    file = session / "events.csv"
    file.write_bytes(b"\xff\xfe" + file.read_bytes())


DAMAGED: dict[str, tuple[Callable[[Path], None], str]] = {
    "cell": (damaged_cell, "line 3, column start_s: 'soon' is not a number"),
    "cells": (cells_missing, "line 2: is no row"),
    "header": (header_of_other_bytes, "ratings.csv, line 1: is no row"),
    "header of other bytes": (header_not_utf8, "events.csv, line 1: is no row"),
    "column": (column_missing, "line 1, column start_s: the column is missing"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_trials_that_cannot_be_read_are_refused_with_their_place(
    copy: Path, run: Run, tmp_path: Path, name: str
) -> None:
    damage, words = DAMAGED[name]
    damage(copy / SESSION)
    code, _, err = run("play", copy / SESSION, "--out", tmp_path / "o")
    assert code == 2
    assert words in err
    assert err.rstrip().count("\n") == 0


def test_a_half_written_row_of_a_killed_program_is_left_out(copy: Path) -> None:
    whole = read_session(copy / SESSION)
    for name in ("trials.csv", "balls.csv", "images.csv", "events.csv"):
        with (copy / SESSION / name).open("a") as stream:
            stream.write("12,3")
    cut: Any = read_session(copy / SESSION)
    assert [each.balls for each in cut.exposures] == [each.balls for each in whole.exposures]
    assert cut.hashes == whole.hashes
