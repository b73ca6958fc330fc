"""Targets of a task shot with a controller's trigger: poses and presses go through the runtime."""

from __future__ import annotations

from pathlib import Path

import moderngl
import pytest

from tests.support.openxr import fresh_monado, needs_monado
from tests.support.protocols import PLAIN, protocol_text
from tests.support.session import run
from tests.support.study import Scripted, read_rows
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.geometry import Pose, normalize, turn_to
from vrcomfort.headset.monado import RemoteFeed, RemoteHand, RemoteState
from vrcomfort.protocol import load_protocol
from vrcomfort.session import WallClock
from vrcomfort.session.task_run import TaskRun

pytest.importorskip("xr", reason="pyopenxr is not installed")

from tests.headset.openxr.test_session import FlatRenderer
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

HEAD = Pose((0.0, 1.6, 0.0))
HAND_M = (HEAD @ Pose((0.15, -0.3, -0.25))).position
AIMED_FRAMES = 4
"""So long a hand rests on a target before its trigger is pulled: poses are there a frame late."""

PROTOCOL = protocol_text(
    """\
[[tasks]]
name = "shoot"
kind = "aiming"
every_s = 4.0
shown_s = 3.8
jitter_s = 0.1
diameter_deg = 4.0
""",
    '[[questionnaires]]\ntimepoint = "post"\nwhen = "session_end"\n',
    name="shots",
    exposure_s=20.0,
    keys='task = "shoot"\n',
    conditions=[PLAIN],
)


class Shooter:
    """Points the right hand at whatever the task wants, and pulls the trigger once at each."""

    def __init__(self, feed: RemoteFeed) -> None:
        self._feed = feed
        self._aimed = 0
        self._since_s = -1.0
        self.pulled = 0
        self.task: TaskRun | None = None

    def before_frame(self) -> None:
        demand = self.task._task.demand() if self.task is not None else None
        hand = RemoteHand(Pose(HAND_M))
        if demand is not None and demand.press:
            same = demand.since_s == self._since_s
            self._since_s, self._aimed = demand.since_s, self._aimed + 1 if same else 0
            aim = Pose(HAND_M, turn_to(normalize(demand.position_m - HAND_M)))
            pull = self._aimed in {AIMED_FRAMES, AIMED_FRAMES + 1}
            self.pulled += self._aimed == AIMED_FRAMES
            hand = RemoteHand(aim, trigger=pull)
        self._feed.send(RemoteState(HEAD, right=hand))


def test_targets_are_shot_with_the_trigger(
    ctx: moderngl.Context, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "room.glb").touch()
    file = tmp_path / "shots.toml"
    file.write_text(PROTOCOL)
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        shooter = Shooter(feed)
        step = TaskRun.step

        def watched(task: TaskRun, *frame: object) -> None:
            shooter.task = task
            step(task, *frame)

        settings = OpenXrSettings(image_size_px=(16, 16))
        with (
            monkeypatch.context() as patch,  # over before `ctx` looks for objects that stayed
            OpenXrHeadset(ctx, settings, before_wait=shooter.before_frame) as headset,
        ):
            patch.setattr(TaskRun, "step", watched)
            outcome = run(
                load_protocol(str(file)),
                "P01",
                study=tmp_path / "S",
                respondent=Scripted(),
                load_scene=lambda _: None,
                headset_for=lambda *_: headset,
                renderer=FlatRenderer(ctx),
                clock=WallClock(),
            )
    assert outcome.status == "completed"
    recorded = tmp_path / "S/sub-P01/ses-1"
    rows = read_rows(recorded / "tasks.csv")
    shots = [row for row in rows if row["kind"] == "shot"]
    targets = [row for row in rows if row["kind"] == "target"]
    assert len(targets) >= 4
    assert len(shots) == shooter.pulled >= 4  # each pull is one shot, as long as it is held
    for shot in shots:
        assert shot["hit"] == "1"
        assert float(shot["error_deg"]) < 0.1
    hit = [row for row in targets if row["hit"] == "1"]
    assert len(hit) == len(shots)
    shown_s = [float(row["session_s"]) for row in read_rows(recorded / "frames.csv")]
    for target in hit:  # four or five frames, and one or two until the pose is there
        appeared_s = float(target["onset_s"])
        met_s = appeared_s + float(target["reaction_s"])
        assert 4 <= sum(appeared_s < each_s <= met_s + 0.001 for each_s in shown_s) <= 8
    assert not verify_study(tmp_path / "S").faults
