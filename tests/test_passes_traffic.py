"""`vrcomfort passes` draws a frame of each condition and tells what effects send through memory."""

import json

import pytest

from vrcomfort.cli import main


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
def test_effects_have_passes_draws_and_bytes_and_plain_frames_have_none(passes):
    found = json.loads(passes("motion_blur_2020", "--size", "64x48", "--json"))["traffic"]
    assert {(row["condition"], row["effect"]) for row in found} == {
        (name, "motion_blur") for name in ("full", "objects", "translation", "translation_faded")
    }
    for row in found:
        assert row["draws"] >= row["passes"] >= 2
        # Colour and velocity are read, and colour is written: at least.
        assert row["bytes_per_pixel"] >= 8 + 4 + 8
        both_eyes = 2 * 64 * 48 * row["bytes_per_pixel"] / 1e6
        assert row["megabytes_both_eyes"] == pytest.approx(both_eyes, abs=0.01)


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
    assert "motion_blur" in said
    assert "reads each of its textures once" in " ".join(said.split())
