"""A recorded session is shown again: the same images, the same times, and what is drawn in."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from PIL import Image

from tests.support.exchange import cell, edit
from tests.support.resume import go
from tests.support.session import run as run_session
from tests.support.study import PROTOCOL as TINY
from tests.support.study import LateFocus, Scripted, read_rows, tiny_protocol
from vrcomfort.api.playback import shipped_walk
from vrcomfort.api.rendering import describe_machine, make_renderer
from vrcomfort.frame import Frame
from vrcomfort.geometry import Gaze, Pose, axis_angle
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.viewing import Photodiode
from vrcomfort.records import Machine
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.replay import Comparison, ReplaySelection, read_session, replay
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.session.start_pose import without_meshes

Run = Callable[..., tuple[int, str, str]]
SIZE_PX = 64, 80
SESSION = "S/sub-P01/ses-1"
PROTOCOL = """\
name = "again"
title = "Shown again"
exposure_s = 0.3
training_s = 0.06
scenes = ["temple", "rail"]
questionnaires = [{ timepoint = "post", when = "session_end" }]
ratings = { instrument = "fms", every_s = 0.1, timeout_s = 0.05 }

[photodiode]
size_deg = 12.0
white = "every_other_frame"

[order]
rule = "explicit"
[[order.sequences]]
name = "one"
sessions = [[
  { scene = "temple", condition = "streaks" },
  { scene = "rail", condition = "blur" },
]]

[[views]]
name = "rail"
scene = "temple"
points = [
  { time_s = 0.0, position = [0.0, 0.0, 3.0] },
  { time_s = 1.0, position = [0.5, 0.0, 0.0], yaw_deg = 40.0 },
]

[[conditions]]
name = "streaks"
[conditions.motion_blur]

[[conditions]]
name = "blur"
[conditions.depth_of_field]
max_radius_percent = 10

[[conditions]]
name = "plain"
"""
DROPPED = {9, 10}
UNSEEN = {14, 15}
"""Frames that the runtime did not want drawn; the second is a cut."""


class Bumpy(PlaybackHeadset):
    """A walk with eyes, on which frames are dropped, and some are not wanted."""

    def frames(self) -> Iterator[Frame]:
        for count, frame in enumerate(super().frames()):
            if count in DROPPED:
                continue
            turn = axis_angle([0.0, 1.0, 0.0], 0.3 * np.sin(count / 5))
            gaze = Gaze(frame.head_pose @ Pose((0.0, 0.0, 0.0), turn), valid=count % 9 != 4)
            yield replace(
                frame,
                gaze=gaze,
                should_render=count not in UNSEEN,
                discontinuity=frame.discontinuity or count == max(UNSEEN),
                snap_turn=count == 17,
            )


class Quick(Scripted):
    """Answers every other question, after 20 ms."""

    def rating(self, elapsed_s: float) -> int | None:
        late = elapsed_s >= self.asked_s + 0.02
        return 4 if late and round(self.asked_s * 10) % 2 else None


@cache
def temple() -> Scene:
    return load_scene("temple")


@cache
def drawer(photodiode: Photodiode | None) -> StereoRenderer:
    """Return what draws all replays of these tests: making it takes longer than a replay."""
    return make_renderer(SIZE_PX, photodiode=photodiode)


def recorded(folder: Path, scene: Any, renderer: Any, machine: Machine) -> Path:
    """Run the study in a folder, which has its protocol, too."""
    (folder / "again.toml").write_text(PROTOCOL)
    protocol = load_protocol(folder / "again.toml")
    headset = Bumpy(shipped_walk("temple"), image_size_px=SIZE_PX, refresh_hz=72)

    def headset_for(_name: str, scene: Any) -> Bumpy:
        headset.place(spawn=scene.spawn)
        return headset

    outcome = run_session(
        protocol,
        "P01",
        study=folder / "S",
        respondent=Quick(),
        headset_for=headset_for,
        load_scene=lambda _: scene,
        renderer=renderer,
        machine=machine,
    )
    assert outcome.status == "completed"
    return folder


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a study that was drawn, and the protocol that it was run with."""
    folder = tmp_path_factory.mktemp("again")
    (folder / "again.toml").write_text(PROTOCOL)
    protocol = load_protocol(folder / "again.toml")
    renderer = make_renderer(SIZE_PX, hash_every=4, photodiode=protocol.photodiode)
    return recorded(folder, temple(), renderer, describe_machine(renderer, protocol))


@pytest.fixture(scope="module")
def undrawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the same, where nothing was drawn, and so no image has a hash."""
    folder = tmp_path_factory.mktemp("undrawn")
    scene = without_meshes("temple")
    return recorded(folder, scene, LateFocus(), Machine("none", "none"))


@pytest.fixture
def study(undrawn: Path, tmp_path: Path) -> Path:
    """Return a copy that may be changed."""
    return Path(shutil.copytree(undrawn, tmp_path / "copy"))


def drawn_again(
    place: Path, selection: ReplaySelection | None = None, **changed: Any
) -> tuple[list, Comparison]:
    session = read_session(place / SESSION)
    if changed:
        session = replace(session, **changed)
    comparison = Comparison()
    drawing = drawer(session.photodiode)
    with drawing.ctx:  # there are two of them
        frames = list(
            replay(
                session,
                selection or ReplaySelection(),
                drawer=drawing,
                second=None,
                load_scene=lambda _: temple(),
                size_px=SIZE_PX,
                comparison=comparison,
            )
        )
    return frames, comparison


@pytest.mark.slow
def test_a_replay_has_the_recorded_images_and_times(place: Path) -> None:
    """Training goes over into the first exposure, and what was not drawn is not drawn again."""
    frames, comparison = drawn_again(place)

    rows = read_rows(place / SESSION / "frames.csv")
    images = read_rows(place / SESSION / "images.csv")
    drawn = [row for row in rows if row["should_render"] == "1"]
    assert [each.row for each in frames] == [rows.index(row) for row in drawn]
    assert [str(each.trial) for each in frames] == [row["trial"] for row in drawn]
    assert {each.trial for each in frames} == {0, 1, 2}
    assert len(images) > 8
    assert (comparison.equal, comparison.compared) == (len(images), len(images))
    assert sum(row["dropped"] == "1" for row in rows) == 2  # once in each exposure
    assert len(drawn) == len(rows) - 2 * len(UNSEEN)


@pytest.mark.slow
def test_a_replay_drawn_with_another_condition_has_not_the_recorded_images(place: Path) -> None:
    session = read_session(place / SESSION)
    plain = session.condition("plain")
    instead = dict.fromkeys(session.conditions, plain)

    _, comparison = drawn_again(place, ReplaySelection(trial=2, instead=instead))

    assert comparison.compared > 3
    assert comparison.equal == 0


@pytest.mark.slow
def test_the_patch_for_a_photodiode_is_part_of_the_images_and_its_onset_is_on_record(
    place: Path,
) -> None:
    _, comparison = drawn_again(place, ReplaySelection(trial=2), photodiode=None)

    assert comparison.compared > 3
    assert comparison.equal == 0
    frames = read_rows(place / SESSION / "frames.csv")
    first = {row["trial"]: row["xr_time_ns"] for row in reversed(frames)}
    events = read_rows(place / SESSION / "events.csv")
    told = [row["detail"] for row in events if row["name"] == "photodiode"]
    assert told == [f"white from xr_time_ns {first[trial]} on" for trial in "12"]


@pytest.mark.slow
@pytest.mark.smoke
def test_times_in_the_video_are_those_that_frames_stood(place: Path) -> None:
    """Dropped and undrawn frames leave the picture standing; exposures follow without a gap."""
    frames, _ = drawn_again(place, ReplaySelection(trial=1))

    steps = np.diff([each.video_s for each in frames]) * 72
    times = np.diff([each.frame.predicted_display_time_ns for each in frames]) / 1e9 * 72
    cuts = np.array([each.frame.discontinuity for each in frames])[1:]
    np.testing.assert_allclose(steps[~cuts], times[~cuts], atol=1e-3)
    assert steps.max() > 2.5  # two frames were dropped in a row
    assert frames[0].video_s == 0.0


@pytest.mark.slow
def test_a_range_of_time_is_drawn_as_it_is_in_the_whole(place: Path) -> None:
    """Focus, and what is blurred by motion, hang on the frames before those that are shown."""
    rows = [r for r in read_rows(place / SESSION / "frames.csv") if r["trial"] == "2"]
    from_s, to_s = float(rows[8]["session_s"]), float(rows[15]["session_s"])

    frames, comparison = drawn_again(place, ReplaySelection(from_s=from_s, to_s=to_s))

    drawn = [row for row in rows[8:16] if row["should_render"] == "1"]
    assert [each.session_s for each in frames] == [float(row["session_s"]) for row in drawn]
    assert comparison.compared == comparison.equal > 0


@pytest.mark.slow
def test_the_command_writes_a_video_in_which_frames_stand(
    run: Run, place: Path, tmp_path: Path
) -> None:
    options = ("--trial", "1", "--video", tmp_path / "seen.mp4", "--quiet")
    assert run("play", place / SESSION, *options) == (0, "", "")

    with av.open(str(tmp_path / "seen.mp4")) as container:
        decoded = list(container.decode(video=0))
    rows = [r for r in read_rows(place / SESSION / "frames.csv") if r["trial"] == "1"]
    drawn = [r for r in rows if r["should_render"] == "1"]
    assert len(decoded) == len(drawn)
    assert (decoded[0].width, decoded[0].height) == (2 * SIZE_PX[0], SIZE_PX[1])
    steps = np.diff([float(each.time) for each in decoded]) * 72
    assert steps.max() == pytest.approx(3, abs=0.01)


@pytest.mark.slow
def test_the_command_says_how_many_images_are_equal(run: Run, place: Path, tmp_path: Path) -> None:
    code, out, err = run("play", place / SESSION, "--trial", "2", "--out", tmp_path / "o")
    assert (code, err) == (0, "")
    facts = json.loads((tmp_path / "o" / "replay.json").read_text())
    equal = facts["images_equal"]
    assert equal == facts["images_compared"] > 3
    assert f"{equal} of {equal} recorded images are equal to the last bit." in out
    first = np.asarray(Image.open(tmp_path / "o" / "frames" / "000000.png"))
    from vrcomfort.render.display import image_hash

    row = next(r for r in read_rows(place / SESSION / "images.csv") if r["trial"] == "2")
    assert image_hash(first[:, : SIZE_PX[0]]) == row["left_hash"]
    assert image_hash(first[:, SIZE_PX[0] :]) == row["right_hash"]


@pytest.mark.slow
def test_another_quality_is_not_the_recorded_image_and_this_is_told(
    run: Run, place: Path, tmp_path: Path
) -> None:
    options = ("--trial", "2", "--quality", "fast", "--out", tmp_path / "o")
    code, out, err = run("play", place / SESSION, *options)
    assert code == 0
    assert "0 of " in out
    assert "another condition or quality is drawn in place of what was seen" in err
    facts = json.loads((tmp_path / "o" / "replay.json").read_text())
    assert facts["conditions"]["blur"]["quality"] == "fast"
    fast = load_protocol(place / "again.toml").condition("blur").at_level("fast")
    assert facts["conditions"]["blur"] == fast.model_dump(mode="json")


@pytest.mark.slow
def test_beside_another_condition_with_gaze_and_ratings(
    run: Run, place: Path, tmp_path: Path
) -> None:
    """One eye of each; the other condition is what it would be alone; words stand below."""
    alone = tmp_path / "alone", ("--condition", "plain", "--eye", "left")
    both = tmp_path / "both", ("--beside", "plain")
    marked = tmp_path / "marked", ("--beside", "plain", "--show", "gaze,ratings")
    for out, options in (alone, both, marked):
        code, _, err = run("play", place / SESSION, "--trial", "2", *options, "--out", out)
        assert code == 0, err

    def picture(out: Path, number: int) -> Any:
        return np.asarray(Image.open(out / "frames" / f"{number:06d}.png"), dtype=int)

    width, height = SIZE_PX
    pair = picture(both[0], 12)
    assert pair.shape[1] == 2 * width
    assert pair.shape[0] > height
    np.testing.assert_array_equal(pair[:height, width:], picture(alone[0], 12))
    assert abs(pair[:height, :width] - pair[:height, width:]).max() > 20
    with_marks = picture(marked[0], 12)
    assert with_marks.shape[0] > pair.shape[0]
    assert (with_marks[:height] == (255, 64, 208)).all(axis=2).any()
    assert not (pair[:height] == (255, 64, 208)).all(axis=2).any()


@pytest.mark.slow
def test_the_cross_stands_where_the_recorded_gaze_meets_the_focus(place: Path) -> None:
    from vrcomfort.replay.film import gaze_point, looked_at

    frames, _ = drawn_again(place, ReplaySelection(trial=2))
    drawn = next(each for each in frames[8:] if each.frame.gaze and each.frame.gaze.valid)
    point = gaze_point(drawn)
    head = drawn.frame.head_pose
    assert (point - head.position) @ head.forward == pytest.approx(drawn.focus_m)
    left, right = (looked_at(view, point, SIZE_PX) for view in drawn.frame.views)
    assert left[0] > right[0]  # a near point lies more to the right for the left eye
    behind = head.position - 5 * head.forward
    assert looked_at(drawn.frame.views[0], behind, SIZE_PX) is None


def test_the_ratings_that_are_shown_are_those_given_by_then(undrawn: Path) -> None:
    from vrcomfort.replay.film import rating_words

    session = read_session(undrawn / SESSION)
    recorded = read_rows(undrawn / SESSION / "ratings.csv")
    told = [each for exposure in session.exposures for each in exposure.ratings]
    assert [(str(each.onset_s), each.response) for each in told] == [
        (row["onset_s"], int(row["response"]) if row["response"] else None) for row in recorded
    ]
    assert {each.response for each in told} == {4, None}
    for each in told:
        assert rating_words([each]) == f"fms: {'missed' if each.response is None else 4}"
    assert rating_words([]) == "no rating yet"


def test_it_is_noted_that_frames_have_no_row(undrawn: Path, tmp_path: Path) -> None:
    study = Path(shutil.copytree(undrawn, tmp_path / "copy"))
    notes = read_session(study / SESSION).notes
    file = study / SESSION / "manifest.json"
    manifest = json.loads(file.read_text("utf-8"))
    file.write_text(json.dumps({**manifest, "frames_not_recorded": 3}), "utf-8")
    (more,) = {*read_session(study / SESSION).notes} - {*notes}
    assert more.endswith(": 3 frames that were shown have no row; they cannot be shown again")


REFUSED: dict[str, tuple[tuple[str, ...], str]] = {
    "no place": ((), "give --video FILE.mp4, or --out FOLDER"),
    "no video": (("--video", "seen.avi"), "a video's name ends in .mp4"),
    "no condition": (("--beside", "nobody", "--out", "o"), "it has: streaks, blur, plain"),
    "no trial": (("--trial", "7", "--out", "o"), "there are: trial 1 ("),
    "no number": (("--trial", "one", "--out", "o"), "is not a trial"),
    "no time": (("--from-s", "1e6", "--out", "o"), "no recorded frame is among what"),
    "no thing": (("--show", "pulse", "--out", "o"), "there are: gaze, ratings"),
    "no eye": (("--eye", "third", "--out", "o"), "write left, right or both"),
    "a scene": (("--scene", "temple", "--out", "o"), "means nothing for a recorded session"),
    "another protocol": (("--protocol", "smoke", "--out", "o"), "this session is of again"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_shown_is_refused_in_a_sentence(
    run: Run, undrawn: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    options, words = REFUSED[name]
    code, _, err = run("play", undrawn / SESSION, *options)
    assert code == 2
    (said,) = (line for line in err.splitlines() if not line.startswith("note: "))
    assert said.startswith("error: ")
    assert words in said


def remove_frames(session: Path) -> None:
    (session / "frames.csv").unlink()


def only_headers(session: Path) -> None:
    file = session / "frames.csv"
    file.write_text(file.read_text().splitlines()[0] + "\n")


def unknown_setting(session: Path) -> None:
    file = session / "manifest.json"
    manifest = json.loads(file.read_text())
    manifest["settings"]["conditions"][1]["depth_of_field"]["sharpness"] = 3
    manifest["versions"]["vrcomfort"] = "0.0.7"
    file.write_text(json.dumps(manifest))


def later_schema(session: Path) -> None:
    edit(session / "manifest.json", 2, lambda _: '  "schema_version": 99,\n')


def broken_cell(session: Path) -> None:
    cell(session / "frames.csv", 5, "head_x_m", "left")


def blank_cell(session: Path) -> None:
    cell(session / "frames.csv", 6, "should_render", "")


def wrong_trial(session: Path) -> None:
    cell(session / "frames.csv", 7, "trial", "1.5")


def missing_column(session: Path) -> None:
    file = session / "frames.csv"
    file.write_text(file.read_text().replace(",should_render,", ",drawn,", 1))


DAMAGED: dict[str, tuple[Callable[[Path], None], str]] = {
    "no frames": (remove_frames, "frames.csv is missing, and without it nothing can be shown"),
    "no rows": (only_headers, "there is a header but no complete row"),
    "other settings": (unknown_setting, "the vrcomfort that ran it: 0.0.7"),
    "later": (later_schema, "schema version 99"),
    "blank": (blank_cell, "line 6, column should_render: this cell is empty"),
    "no whole number": (wrong_trial, "line 7, column trial: '1.5' is not a whole number"),
    "no column": (missing_column, "line 1, column should_render: the column is missing"),
    "broken": (broken_cell, "line 5, column head_x_m: 'left' is not a finite number"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_session_that_cannot_be_read_is_refused_with_its_place(
    run: Run, study: Path, tmp_path: Path, name: str
) -> None:
    damage, words = DAMAGED[name]
    damage(study / SESSION)
    code, _, err = run("play", study / SESSION, "--out", tmp_path / "o")
    assert code == 2
    assert words in err
    assert err.rstrip().count("\n") == 0


def test_a_folder_that_is_no_session_names_one(run: Run, undrawn: Path, tmp_path: Path) -> None:
    code, _, err = run("play", undrawn / "S", "--out", tmp_path / "o")
    assert code == 2
    assert "is no session's folder" in err
    assert "ses-1" in err


@pytest.mark.slow
def test_a_protocol_that_has_changed_is_told_and_the_session_keeps_its_own(
    run: Run, place: Path, tmp_path: Path
) -> None:
    study = Path(shutil.copytree(place, tmp_path / "copy"))
    text = PROTOCOL.replace("max_radius_percent = 10", "max_radius_percent = 2")
    (study / "again.toml").write_text(text)
    options = ("--protocol", study / "again.toml", "--trial", "2", "--out", tmp_path / "o")
    code, _, err = run("play", study / SESSION, *options)
    assert code == 0
    assert "has changed since this session" in err
    facts = json.loads((tmp_path / "o" / "replay.json").read_text())
    assert facts["images_equal"] == facts["images_compared"] > 3


def test_an_exposure_that_was_cut_short_by_a_kill_is_shown_too(study: Path) -> None:
    """No row of ``trials.csv`` came, the manifest tells what was under way."""
    session = study / SESSION
    rows = read_rows(session / "trials.csv")
    lines = (session / "trials.csv").read_text().splitlines(keepends=True)
    (session / "trials.csv").write_text("".join(lines[:-1]))
    numbers = {k: int(rows[1][k]) for k in ("session", "period", "block", "trial", "attempt")}
    begun = {key: rows[1][key] for key in ("participant", "condition", "scene")}
    manifest = json.loads((session / "manifest.json").read_text())
    manifest["under_way"] = {
        **begun, **numbers, "start_s": float(rows[1]["start_s"]), "resumed": 0,
    }  # fmt: skip
    (session / "manifest.json").write_text(json.dumps(manifest))

    killed = read_session(session).exposures[-1]

    assert (killed.trial, killed.status) == (2, "")
    assert killed.end - killed.shown == int(rows[1]["frames"])


def test_what_is_measured_and_practised_before_is_no_part_of_an_exposure(tmp_path: Path) -> None:
    """Its frames are no trial's, as those of training are."""
    table = "[gaze_validation]\npoints = [[0.0, 0.0, 1.0], [9.0, 0.0, 1.0], [0.0, 9.0, 2.0]]\n\n"
    table += '[posture]\nmode = "standing"\n\n[[practice]]\nname = "try"\nexposure_s = 2.0\n'
    table += 'trials = [{ scene = "room.glb", condition = "plain" }]\n\n'
    text = TINY.replace("[[conditions]]", table + "[[conditions]]", 1)
    go(tmp_path, protocol=tiny_protocol(tmp_path, text))

    session = read_session(tmp_path / SESSION)

    rows = read_rows(tmp_path / SESSION / "frames.csv")
    before = [row for row in rows if row["trial"] == "0"]
    first = session.exposures[0]
    assert first.shown - first.first == 10  # a second of training
    assert len(before) > 10 + 20 + 10  # 2 s of practice, and a validation
    assert first.first == len(before) - 10
    assert [each.first == each.shown for each in session.exposures[1:]] == [True]

    file = tmp_path / SESSION / "events.csv"
    header, *lines = file.read_text().splitlines(keepends=True)
    place = next(n for n, line in enumerate(lines) if ",training," in line)
    onset, rest = lines[place].split(",", 1)
    lines.insert(place + 1, f"{float(onset) + 0.5},{rest}")  # it began again
    file.write_text("".join([header, *lines]))
    assert read_session(tmp_path / SESSION).exposures[0].first == first.first


def test_the_first_frame_begins_anew_whatever_came_before_the_file(study: Path) -> None:
    file = study / SESSION / "frames.csv"
    header, line, rest = file.read_text().split("\n", 2)
    cells = dict(zip(header.split(","), line.split(","), strict=True)) | {"discontinuity": "0"}
    file.write_text("\n".join([header, ",".join(cells.values()), rest]))
    assert read_session(study / SESSION).trace.cuts[0]
