"""A whole session through the runtime: questions by controller, exposures along a trace."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pandas as pd
import pytest
from PIL import Image

from tests.support.openxr import fresh_monado, needs_monado
from tests.support.session import run as run_participant
from vrcomfort import session
from vrcomfort.errors import RuntimeLostError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.operator_interface import SessionProgress
from vrcomfort.protocol import load_protocol
from vrcomfort.recordings import frame_measures
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.seen_time import SEEN, SeenState
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import Rehearsal

pytest.importorskip("xr", reason="pyopenxr is not installed")

from tests.support.openxr_layers import Interceptor
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (16, 16)
EXPOSURES = """
name = "rehearsal"
title = "Two short exposures"
participants = 2
exposure_s = 2.0
scenes = ["temple"]
conditions = [{ name = "a" }, { name = "b" }]
order = { rule = "williams" }
ratings = { instrument = "fms", every_s = 1.2, timeout_s = 0.7 }
"""
PROTOCOL = f"""{EXPOSURES}
questionnaires = [
  {{ timepoint = "baseline", when = "session_start" }},
  {{ timepoint = "post", when = "after_trial" }},
]
"""
PREPARED = f"""{PROTOCOL}
practice = [{{ name = "try", draw = 1, exposure_s = 0.5 }}]
posture = {{ mode = "seated", eye_height_m = 1.2, settle_s = 0.3, measure_s = 0.4 }}
breaks = {{ min_s = 0.5 }}
instructions = [
  {{ name = "welcome", when = "session_start", text = "Welcome", picture = "way.png" }},
  {{ name = "again", when = "before_trial", trials = [2], text = "Once more", min_s = 0.5 }},
]
"""


class FlatRenderer:
    """Draws one colour: these tests are about what surrounds the pictures."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self.eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
        self.focus_samples: tuple[Any, ...] = ()
        self.hashed = False
        self.image_hashes: tuple[Any, ...] = ()
        self.max_blur_px = self.cpu_ms = self.gpu_times = self.effect_centre = None
        self.seeks_gaze = False
        self.gaze_hits: tuple[Any, ...] = ()
        self.times_parts, self.part_times = False, ()

    def begin(self, scene: object, condition: object) -> None:
        """Draw the same whatever is asked for."""

    def render(self, frame: Frame, scene_time_s: float) -> FlatRenderer:  # noqa: ARG002
        return self

    def drain(self) -> tuple[Any, ...]:
        return ()

    def drain_hashes(self) -> tuple[Any, ...]:
        return ()

    def drain_gaze_hits(self) -> tuple[Any, ...]:
        return ()

    def drain_part_times(self) -> tuple[Any, ...]:
        return ()

    def clamps(self) -> tuple[str, ...]:
        return ()


def walk() -> Iterator[Pose]:
    for frame in count():
        turn = axis_angle([0.0, 1.0, 0.0], 0.02 * frame)
        yield Pose(np.array([0.01 * frame, 1.6, -0.03 * frame]), turn)


def run(
    ctx: moderngl.Context, rehearsal: Rehearsal, folder: Path, **kwargs: Any
) -> session.RunOutcome:
    protocol = folder / "rehearsal.toml"
    protocol.write_text(kwargs.pop("text", PROTOCOL))
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=kwargs.pop("api_layers", ()))
    with OpenXrHeadset(ctx, settings, before_wait=rehearsal.before_frame) as headset:
        rehearsal.screen = PanelScreen(headset)
        return run_participant(
            load_protocol(str(protocol)),
            "P01",
            study=folder / "study",
            load_scene=lambda _: None,
            headset_for=lambda _, __: headset,
            renderer=FlatRenderer(ctx),
            respondent=PanelRespondent(
                rehearsal.screen, watch=rehearsal.watch, chose=rehearsal.chose
            ),
            clock=session.WallClock(),
            screen=rehearsal.screen,
            **kwargs,
        )


class Covers:
    """A runtime that wants no picture of three frames in ten: something else is shown."""

    def __init__(self) -> None:
        self._numbers = count()

    def __call__(self, follow: Any, session: Any, info: Any, state: Any) -> int:
        result = follow(session, info, state)
        if next(self._numbers) % 10 < 3:
            state.contents.should_render = 0
        return int(result)


def test_frames_that_the_runtime_wants_no_picture_of_are_no_exposure(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    layer = Interceptor(xrWaitFrame=Covers())
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), iter([0] * 9))
        outcome = run(ctx, rehearsal, tmp_path, text=EXPOSURES, api_layers=(layer.name,))
    assert outcome.status == "completed"
    frames, trials = read(tmp_path, "frames.csv"), read(tmp_path, "trials.csv")
    assert set(frames.groupby("trial")["should_render"].min()) == {0}, "they are recorded"
    measured, notes = frame_measures([tmp_path / "study/sub-P01/ses-1/frames.csv"])
    assert notes == []
    for (_, trial), found in zip(trials.iterrows(), measured, strict=True):
        rows = frames[frames["trial"] == trial["trial"]]
        seen = rows["should_render"] == 1
        assert float(trial["not_drawn_s"]) >= 0.9 * rows["period_ns"][~seen].sum() / 1e9 > 0
        longest_s = rows["xr_time_ns"].diff().max() / 1e9
        told = {state: float(trial[state.column]) for state in SeenState}
        shown_s = told[SeenState.FROZEN] + sum(told[state] for state in SEEN)
        assert abs(shown_s - 2.0) <= longest_s
        for state in set(SeenState) - {SeenState.HIDDEN}:  # time without frames has no row
            assert told[state] == pytest.approx(getattr(found, state.column), abs=1e-6)


def test_what_comes_before_exposures_passes_in_the_headset(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    """Instructions and a break end by the button, practice and the height of the eyes by time."""
    Image.new("RGB", (120, 80), (200, 0, 0)).save(tmp_path / "way.png")
    answers = np.random.default_rng(7).integers(0, 4, 200).tolist()
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), iter(answers))
        outcome = run(ctx, rehearsal, tmp_path, text=PREPARED)
    assert outcome.status == "completed"
    events = read(tmp_path, "events.csv")
    told = events[events["name"] == "instruction"]
    assert told["detail"].tolist() == [
        "welcome: text, picture way.png; ended by participant",
        "again: text; ended by participant",
    ]
    assert told["duration_s"].astype(float).iloc[1] >= 0.5
    (rest,) = events[events["name"] == "rest"]["detail"]
    assert rest == "break after trial 1; ended by participant"
    heights = events[events["name"] == "eye_height"]["detail"].tolist()
    assert heights == ["seated: 1.600 m, the scene is seen from 1.200 m"] * 2
    frames = read(tmp_path, "frames.csv")
    high_m = frames["avatar_y_m"].astype(float) + frames["head_y_m"].astype(float)
    assert high_m[frames["trial"] > 0].round(6).unique().tolist() == [1.2]
    (practised,) = read(tmp_path, "practice.csv")["status"]
    assert practised == "completed"


def read(folder: Path, file: str) -> pd.DataFrame:
    return pd.read_csv(folder / "study" / "sub-P01" / "ses-1" / file, keep_default_na=False)


def test_a_session_records_the_fed_poses_and_the_scripted_answers(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    answers = np.random.default_rng(7).integers(0, 4, 200).tolist()
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), iter(answers))
        outcome = run(ctx, rehearsal, tmp_path)
    assert outcome.status == "completed"

    frames = read(tmp_path, "frames.csv")
    seen = frames[["head_x_m", "head_y_m", "head_z_m"]].to_numpy()
    fed = np.array([pose.position for pose in rehearsal.fed])
    nearest = [int(np.argmin(np.abs(fed - position).max(axis=1))) for position in seen]
    assert np.abs(fed[nearest] - seen).max() <= 1e-6
    assert nearest == sorted(nearest)
    assert len(frames) == read(tmp_path, "trials.csv")["frames"].sum() > 10

    asked = read(tmp_path, "questionnaires.csv")
    assert asked["timepoint"].value_counts().to_dict() == {"baseline": 16, "post": 32}
    ratings = read(tmp_path, "ratings.csv")
    given = [*asked["response"], *(ratings["response"][ratings["missed"] == 0])]
    assert sorted(map(int, given)) == sorted(rehearsal.said)
    assert rehearsal.said == answers[: len(rehearsal.said)]
    assert asked["response"].astype(int).tolist()[:16] == answers[:16]
    assert set(read(tmp_path, "trials.csv")["status"]) == {"completed"}
    events = read(tmp_path, "events.csv")
    states = events[events["name"] == "session_state"]
    first_answer_s = events[events["name"] == "answer"]["onset_s"].min()
    assert states["detail"].tolist() == ["idle", "ready", "synchronized", "visible", "focused"]
    assert states["onset_s"].max() < first_answer_s


def test_a_runtime_that_dies_leaves_every_row_up_to_then(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), iter([0] * 200))

        def watch(progress: SessionProgress) -> None:
            if progress.step == "exposure" and progress.done > 1.0:
                monado.kill()

        with pytest.raises(RuntimeLostError, match="kept"):
            run(ctx, rehearsal, tmp_path, progress=watch)
    assert len(read(tmp_path, "questionnaires.csv")) == 16
    shown = len(read(tmp_path, "frames.csv"))
    assert shown == read(tmp_path, "trials.csv")["frames"].sum() > 2
    assert read(tmp_path, "trials.csv")["abort_code"].tolist() == ["runtime_lost"]

    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        outcome = run(ctx, Rehearsal(feed, walk(), iter([1] * 200)), tmp_path, resume=True)
    assert outcome.status == "completed"
    trials = read(tmp_path, "trials.csv")
    assert trials["trial"].tolist() == [1, 1, 2]
    assert trials["attempt"].tolist() == [1, 2, 1]
    assert trials["resumed"].tolist() == [0, 1, 1]
    asked = read(tmp_path, "questionnaires.csv")
    assert asked["timepoint"].tolist()[::16] == ["baseline", "baseline", "post", "post"]
    assert asked["response"].astype(int).tolist() == [0] * 16 + [1] * 48
    frames = read(tmp_path, "frames.csv")
    assert frames["resumed"].tolist() == [0] * shown + [1] * (len(frames) - shown)
    assert (np.diff(frames["xr_time_ns"]) > 0).all()
