"""Eye gaze through OpenXR, as far as Monado goes: it offers the extension, but no eyes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, needs_monado, validation
from tests.support.study import read_rows, strict_about_gaze
from vrcomfort.cli import main
from vrcomfort.geometry import EyeGaze, Pose, yaw_pitch_roll
from vrcomfort.headset.monado import Monado, RemoteFeed, RemoteState
from vrcomfort.records import FrameRow, Recorder, only_run
from vrcomfort.resources import data_folder
from vrcomfort.session.frame_log import FrameLog

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings, actions
from vrcomfort.headset.openxr.instance import Runtime

pytestmark = needs_monado

SETTINGS = OpenXrSettings(image_size_px=(32, 24))
HEAD = Pose(np.array([0.5, 1.6, -0.2]), yaw_pitch_roll(0.4, -0.2, 0.1))


@pytest.fixture
def participant(monado: Monado) -> Iterator[Participant]:
    with monado.feed() as feed:
        yield _still(feed)


def _still(feed: RemoteFeed) -> Participant:
    return Participant(feed, lambda _: RemoteState(HEAD))


@pytest.fixture
def says_it_has_eyes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Monado says of its headset that it has no eye tracker, but takes the bindings of one."""
    monkeypatch.setattr(Runtime, "has_gaze", True)


def refusal(monkeypatch: pytest.MonkeyPatch, folder: Path, *options: str) -> None:
    command = ["run", str(strict_about_gaze(folder)), "--participant", "P01", *options]
    shared = ["--headset", "openxr", "--out", str(folder / "study")]
    monkeypatch.setattr("sys.argv", ["vrcomfort", *command, *shared])
    with pytest.raises(SystemExit, match="2"):
        main()


@pytest.mark.parametrize("rehearsed", [True, False])
def test_a_study_that_needs_eyes_is_refused_before_a_folder_is_made(
    monado: Monado,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    rehearsed: bool,
) -> None:
    walk = data_folder("scenes") / "temple_walk.csv"
    refusal(monkeypatch, tmp_path, *(["--monado-trace", str(walk)] if rehearsed else []))
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "follows the gaze in gaze_19, gaze_7, gaze_2, and this headset has no eye" in said
    assert not (tmp_path / "study").exists()


@pytest.mark.usefixtures("monado", "says_it_has_eyes")
def test_a_study_that_needs_eyes_goes_on_where_there_are_some(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with only_run(tmp_path / "study", "P01"):
        refusal(monkeypatch, tmp_path)
    assert "P01 is being run by process" in capsys.readouterr().err


def test_a_headset_without_an_eye_tracker_gives_no_gaze(
    ctx: moderngl.Context, participant: Participant
) -> None:
    with OpenXrHeadset(ctx, SETTINGS, before_wait=participant) as headset:
        assert xr.EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME in headset.details["extensions"]
        assert headset.details["eye_tracker"] == "no"
        assert [frame.gaze for frame in islice(headset.frames(), 3)] == [None] * 3


@pytest.mark.usefixtures("says_it_has_eyes")
def test_eyes_that_are_not_seen_are_recorded_as_such(
    ctx: moderngl.Context, participant: Participant, tmp_path: Path
) -> None:
    with (
        validation(tmp_path / "validation.txt") as layers,
        OpenXrHeadset(
            ctx,
            OpenXrSettings(image_size_px=(32, 24), api_layers=layers),
            before_wait=participant,
        ) as headset,
        Recorder(tmp_path, "P1", 1) as recorder,
    ):
        log = FrameLog(recorder)
        for frame in islice(headset.frames(), 10):
            assert frame.gaze is not None
            assert not frame.gaze.valid
            headset.submit(frame, None)
            log.add(frame, None, trial=1, session_s=frame.index / 20)
        log.finish()
        heard = [event for event in headset.take_events() if event.name.startswith("openxr_")]
    assert heard == []
    rows = read_rows(recorder.folder / "gaze.csv")
    frames = read_rows(recorder.folder / FrameRow.FILE)
    assert [row["xr_time_ns"] for row in rows] == [row["xr_time_ns"] for row in frames]
    assert {(row["valid"], row["origin_x_m"], row["direction_z"]) for row in rows} == {
        ("0", "", "")
    }


class LeftEye:
    """The tracker of a runtime that tells of the left eye, where the head is."""

    def __init__(self, instance: xr.Instance, session: xr.Session) -> None:
        del instance, session

    def read(self, space: xr.Space, time_ns: int) -> tuple[tuple[EyeGaze, EyeGaze], int]:
        del space
        return (EyeGaze(HEAD), EyeGaze(Pose(), valid=False)), time_ns

    def release(self) -> None: ...


def test_each_eye_is_recorded(
    ctx: moderngl.Context,
    participant: Participant,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setattr(Runtime, "has_each_eye", True)
    monkeypatch.setattr(actions, "EachEye", LeftEye)
    with (
        OpenXrHeadset(ctx, SETTINGS, before_wait=participant) as headset,
        Recorder(tmp_path, "P1", 1) as recorder,
    ):
        assert headset.details["eye_tracker"] == "yes"
        assert headset.details["each_eye"] == xr.FB_EYE_TRACKING_SOCIAL_EXTENSION_NAME
        log = FrameLog(recorder)
        for frame in islice(headset.frames(), 5):
            headset.submit(frame, None)
            log.add(frame, None, trial=1, session_s=frame.index / 20)
        log.finish()
    rows = read_rows(recorder.folder / "gaze.csv")
    assert len(rows) == 5
    for row in rows:
        assert (row["valid"], row["left_valid"], row["right_valid"]) == ("0", "1", "0")
        assert float(row["left_origin_y_m"]) == pytest.approx(1.6)
        assert float(row["left_direction_z"]) == pytest.approx(HEAD.forward[2])
        assert {row["right_origin_x_m"], row["left_pupil_mm"], row["origin_x_m"]} == {""}


@pytest.mark.usefixtures("says_it_has_eyes")
def test_a_space_that_is_tracked_is_a_valid_gaze(
    ctx: moderngl.Context, participant: Participant
) -> None:
    with OpenXrHeadset(ctx, SETTINGS, before_wait=participant) as headset:
        # The head's own space stands in for that of the eyes, which no headset here has.
        headset._xr.actions._gaze_space = headset._xr.stage._head
        for frame in islice(headset.frames(), 10):
            headset.submit(frame, None)
        assert frame.gaze is not None
        assert frame.gaze.valid
        assert np.allclose(frame.gaze.pose.position, frame.head_pose.position, atol=1e-6)
        assert np.allclose(frame.gaze.pose.forward, frame.head_pose.forward, atol=1e-6)
