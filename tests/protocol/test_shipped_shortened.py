"""Each shipped protocol with pictures: all of its steps, and exposures of a second."""

from __future__ import annotations

import pytest

from tests.support.shortened import EXPOSURE_S, FRAMES, SHIPPED, assert_whole, shortened
from vrcomfort.protocol import load_protocol


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_protocol_is_shown_whole_on_the_playback_headset(run, name, tmp_path):
    file = shortened(name, tmp_path)
    short = ("--exposure-s", EXPOSURE_S)
    show = ("--size", "48x60", "--refresh-hz", FRAMES / EXPOSURE_S, *short)
    code, _, err = run("simulate", file, "-n", 1, "--out", tmp_path / "study", *show)
    assert code == 0, err
    rehearsed = tmp_path / "rehearsed"
    code, _, err = run("simulate", file, "-n", 1, "--no-draw", *short, "--out", rehearsed)
    assert code == 0, err
    assert_whole(tmp_path / "study", load_protocol(file), rehearsed)
