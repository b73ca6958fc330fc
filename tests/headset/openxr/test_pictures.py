"""What reaches the runtime is what the playback headset shows for the same poses."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, fresh_monado, needs_monado
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.headset.monado import RemoteState
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.protocol import Condition, DepthOfField, MotionBlur
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace

pytest.importorskip("xr", reason="pyopenxr is not installed")

from tests.support.openxr_images import ReleasedImages
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (48, 60)
BOTH_BLURS = Condition(name="both", depth_of_field=DepthOfField(), motion_blur=MotionBlur())


def track(poses: list[Pose]) -> PoseTrack:
    return PoseTrack(
        np.array([pose.position for pose in poses]), np.array([pose.orientation for pose in poses])
    )


def as_trace(frames: list[Frame]) -> Trace:
    angles = [
        [(f.left, f.right, f.up, f.down) for f in (view.fov for view in frame.views)]
        for frame in frames
    ]
    return Trace(
        time_ns=np.array([frame.predicted_display_time_ns for frame in frames]),
        head=track([frame.head_pose for frame in frames]),
        cuts=np.array([frame.discontinuity for frame in frames]),
        period_ns=np.array([frame.period_ns for frame in frames]),
        eyes=(
            track([frame.views[0].pose for frame in frames]),
            track([frame.views[1].pose for frame in frames]),
        ),
        fovs=np.array(angles),
        avatar=track([frame.avatar_pose for frame in frames]),
    )


def walk(frame: int) -> RemoteState:
    turn = yaw_pitch_roll(0.04 * frame, 0.01 * frame, 0.0)
    return RemoteState(Pose(np.array([0.02 * frame, 1.6, -0.06 * frame]), turn))


def test_the_runtime_gets_what_playback_shows(ctx: moderngl.Context, tmp_path: Path) -> None:
    scene = load_scene("temple")
    renderer = StereoRenderer(ctx, SIZE_PX)
    released = ReleasedImages(ctx)
    frames: list[Frame] = []
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        headset = OpenXrHeadset(
            ctx,
            OpenXrSettings(image_size_px=SIZE_PX, api_layers=(released.layer.name,)),
            before_wait=Participant(feed, walk),
        )
        with headset:
            headset.place(spawn=scene.spawn)
            renderer.begin(scene, BOTH_BLURS)
            for frame in islice((each for each in headset.frames() if not each.paused), 6):
                headset.submit(frame, renderer.render(frame, 0.05 * len(frames)).eyes)
                frames.append(frame)
    playback = PlaybackHeadset(as_trace(frames), image_size_px=SIZE_PX, loop=False)
    renderer.begin(scene, BOTH_BLURS)
    shown = [
        eye.read()
        for number, frame in enumerate(playback.frames())
        for eye in renderer.render(frame, 0.05 * number).eyes
    ]
    renderer.release()
    got = released.colour
    assert len(got) == len(shown) == 12
    images = [np.frombuffer(b"".join(each), np.uint8).astype(int) for each in (got, shown)]
    assert np.ptp(images[0]) > 50
    assert np.abs(images[0] - images[1]).max() <= 1
