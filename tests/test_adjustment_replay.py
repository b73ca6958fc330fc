"""What was adjusted is seen again in a replay, at the frame in which it was seen first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.render import still_life
from tests.support.session import run
from tests.support.study import read_rows
from tests.support.tasks import doing_protocol
from vrcomfort.cli.playback import shipped_walk
from vrcomfort.cli.renderer import make_renderer
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.replay import Comparison, Wish, read_session, replay
from vrcomfort.respondent import SimulatedRespondent

SIZE_PX = (48, 40)
PROTOCOL = """\
name = "adjusting"
title = "As much blur as is comfortable"
exposure_s = 2.8
training_s = 0.1
scenes = ["room.glb"]

[[conditions]]
name = "lens"
[conditions.depth_of_field]
law = "dioptre"
max_radius_percent = 10

[order]
rule = "latin_square"

[[adjustments]]
name = "blur"
setting = "depth_of_field.full_blur_dioptre"
range = [0.05, 2.0]
start = "descending"
sweep_s = 0.5

[simulation]
reaction_s = 0.2
hazard_per_min = 0.0
adjusts_to = { blur = 0.3 }
"""


@pytest.mark.slow
def test_a_replay_has_the_images_that_were_adjusted(tmp_path: Path) -> None:
    protocol = doing_protocol(tmp_path, PROTOCOL)
    scene = still_life()
    headset = PlaybackHeadset(shipped_walk("temple"), image_size_px=SIZE_PX, refresh_hz=30)
    renderer = make_renderer(SIZE_PX, hash_every=3)
    outcome = run(
        protocol,
        "P01",
        study=tmp_path / "S",
        respondent=SimulatedRespondent(protocol.simulation, participant="P01", seed=0),
        headset_for=lambda *_: headset,
        load_scene=lambda _: scene,
        renderer=renderer,
    )
    assert outcome.status == "completed"
    folder = tmp_path / "S/sub-P01/ses-1"
    kinds = [row["kind"] for row in read_rows(folder / "dials.csv")]
    assert kinds.count("change") > 5
    assert kinds[-1] == "confirmed"
    images = read_rows(folder / "images.csv")
    session = read_session(folder)
    assert len({row["left_hash"] for row in images}) > 5

    def equal(of: object) -> int:
        comparison = Comparison()
        drawn = replay(
            of, Wish(), drawer=renderer, second=None, load_scene=lambda _: scene,
            size_px=SIZE_PX, comparison=comparison,
        )  # fmt: skip
        assert len(list(drawn)) > 30
        assert comparison.compared == len(images)
        return comparison.equal

    assert equal(session) == len(images)
    without = tuple(replace(each, adjusted=()) for each in session.exposures)
    assert equal(replace(session, exposures=without)) < len(images) / 2
