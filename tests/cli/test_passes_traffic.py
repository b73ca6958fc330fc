"""`vrcomfort passes` draws a frame of each condition and tells what effects send through memory."""

import json

import pytest

from tests.support.gl_trace import traced
from vrcomfort.cli import main
from vrcomfort.gpu.passes import Pass, PassImage, watched
from vrcomfort.gpu.traffic import DrawnPass, TrafficCounter, added_up
from vrcomfort.protocol import load_protocol
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.costs import a_step


@pytest.fixture
def passes(monkeypatch, capsys):
    def call(*arguments):
        monkeypatch.setattr("sys.argv", ["vrcomfort", "passes", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        assert not end.value.code
        return capsys.readouterr().out

    return call


@pytest.mark.slow
def test_all_parts_of_a_frame_have_passes_draws_and_bytes(passes):
    found = json.loads(passes("motion_blur_2020", "--size", "64x48", "--json"))["traffic"]
    whole = {(row["condition"], row["part"]): row for row in found}
    assert {condition for condition, part in whole if part == "motion_blur"} == {
        "full", "objects", "translation", "translation_faded",
    }  # fmt: skip
    parts = {part for condition, part in whole if condition == "off"}
    assert parts == {"shadow", "scene", "resolve", "tone_map", "headset", "whole frame"}
    blurred = whole["full", "motion_blur"]
    assert blurred["draws"] >= blurred["passes"] >= 2
    # Colour and velocity are read, and colour is written: at least.
    assert blurred["bytes_per_pixel"] >= 8 + 4 + 8
    assert whole["off", "headset"]["bytes_per_pixel"] == 4 * 4  # colour and depth, read and written
    for condition in {condition for condition, _ in whole}:
        rows = [row for (name, _), row in whole.items() if name == condition]
        *each, total = (row["megabytes_both_eyes"] for row in rows)
        assert total == pytest.approx(sum(each), abs=0.005 * len(rows))


@pytest.mark.slow
def test_nothing_is_drawn_where_nobody_asks(passes):
    assert (
        json.loads(passes("motion_blur_2020", "--size", "64x48", "--json", "--no-draw"))["traffic"]
        == []
    )


@pytest.mark.slow
def test_the_table_says_how_it_was_counted(passes):
    said = passes("motion_blur_2020", "--size", "64x48")
    assert "Passes and draws of an eye" in said
    assert "whole frame" in said
    assert "motion_blur" in said
    assert "reads each of its textures once" in " ".join(said.split())


@pytest.mark.parametrize(
    ("sizes", "runs"),
    [([(9, 5), (5, 3), (2, 1), (1, 1)], 1), ([(9, 5), (9, 2)], 2), ([(1, 1), (1, 1)], 2)],
)
def test_draws_into_halves_of_an_image_are_one_chain(sizes, runs):
    images = [PassImage(n, size, 4) for n, size in enumerate(sizes)]
    drawn = [DrawnPass(Pass("halve", (), (image,)), 1, 1, 0) for image in images]
    assert added_up(drawn).passes == runs


@pytest.mark.parametrize("case", ["plain", "both"])
def test_the_bytes_of_a_whole_frame_are_those_that_opengl_tells(ctx, case):
    """Within 5 %, with every texture, target and sample asked of OpenGL at each call."""
    condition = load_protocol("smoke").condition(case)
    scene, size_px = load_scene("temple"), (96, 80)
    before, frame = a_step(scene.spawn, size_px)
    renderer, counter = StereoRenderer(ctx, size_px), TrafficCounter(ctx)
    with traced(ctx) as trace:
        renderer.build(scene, condition)
        renderer.render(before, 0.0)
        trace.begin()
        renderer.render(frame, 0.1)
        told = trace.bytes
    renderer.render(before, 0.0)
    with watched(counter):
        renderer.render(frame, 0.1)
    renderer.release()
    declared = sum(each.bytes for each in counter.drawn)
    assert declared > 200 * size_px[0] * size_px[1]
    assert declared == pytest.approx(told, rel=0.05)
