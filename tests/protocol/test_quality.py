"""The dial `quality` of a condition: what it fills in, what it never touches, and its table."""

import tomllib
from itertools import pairwise
from typing import get_args

import pytest

from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.protocol import quality as dial
from vrcomfort.protocol.conditions import Condition, DepthOfField, MotionBlur
from vrcomfort.protocol.quality_levels import (
    Effects,
    MeasurementSource,
    Quality,
    QualityFigure,
    QualityLevel,
    QualityTable,
    quality_table,
)
from vrcomfort.resources import data_folder

LEVELS = get_args(Quality)
DIALLED = ("depth_of_field", "motion_blur")
TABLE = data_folder("analysis") / "measured" / "quality.toml"


def with_level(level, **effects):
    return Condition.model_validate({"name": "c", "quality": level, **effects})


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("law", ["linear", "dioptre", "thin_lens", "eye"])
def test_every_level_gives_valid_settings(level, law):
    found = with_level(level, depth_of_field={"law": law}, motion_blur={})
    wanted = quality_table().levels[level]
    for effect, settings in (
        ("depth_of_field", found.depth_of_field),
        ("motion_blur", found.motion_blur),
    ):
        for key, value in wanted.settings(effect, law=law).items():
            assert getattr(settings, key) == value
    assert dial.level_of(found) == level


def test_levels_rise_in_what_they_sample():
    settings = [with_level(level, depth_of_field={}, motion_blur={}) for level in LEVELS]
    for effect in DIALLED:
        samples = [getattr(each, effect).samples for each in settings]
        assert samples == sorted(samples)
        assert samples[0] < samples[1] < samples[2]


def test_each_level_of_depth_of_field_was_measured_dearer_and_a_quarter_closer():
    found = {
        each.level: each
        for each in quality_table().figures
        if (each.effects, each.scene) == ("depth_of_field", "temple")
    }
    for cheap, dear in pairwise(found[level] for level in LEVELS):
        assert cheap.cost_ratio < dear.cost_ratio
        assert cheap.reads_per_pixel < dear.reads_per_pixel
        assert 10 ** ((cheap.psnr_db - dear.psnr_db) / 20) <= 0.75


@pytest.mark.parametrize("effects", get_args(Effects))
@pytest.mark.parametrize("scene", ["temple", "mountain"])
def test_fast_was_measured_cheaper_than_balanced_and_no_closer(effects, scene):
    found = {
        each.level: each
        for each in quality_table().figures
        if (each.effects, each.scene) == (effects, scene)
    }
    fast, balanced = found["fast"], found["balanced"]
    assert fast.cost_ratio < balanced.cost_ratio
    assert fast.reads_per_pixel < balanced.reads_per_pixel
    assert fast.psnr_db <= balanced.psnr_db
    assert fast.flip >= balanced.flip


def test_balanced_is_what_is_taken_without_a_level():
    effects = {"depth_of_field": DepthOfField(), "motion_blur": MotionBlur()}
    plain, balanced = Condition(name="c", **effects), with_level("balanced", **effects)
    assert balanced == plain.model_copy(update={"quality": "balanced"})


def test_what_the_condition_says_itself_wins():
    found = with_level("fast", depth_of_field={"samples": 70}, motion_blur=MotionBlur(samples=33))
    assert (found.depth_of_field.samples, found.motion_blur.samples) == (70, 33)
    assert dial.level_of(found) is None


@pytest.mark.parametrize("level", LEVELS)
def test_peripheral_blur_is_of_one_view(level):
    found = with_level(level, depth_of_field={"law": "eye", "peripheral": {}})
    assert found.depth_of_field.views == 1


def test_a_level_adds_no_effect_and_changes_no_strength():
    assert with_level("fast").depth_of_field is None
    strong = with_level("fast", depth_of_field={"max_radius_percent": 4.0, "full_blur_m": 3.0})
    assert strong.motion_blur is None
    assert strong.depth_of_field.max_radius_percent == 4.0
    assert strong.depth_of_field.full_blur_m == 3.0


def test_resolved_settings_read_back_as_they_are():
    found = with_level("accurate", depth_of_field={}, motion_blur={"samples": 5})
    assert Condition.model_validate(found.model_dump(mode="json")) == found


def test_a_protocol_records_the_resolved_settings(tmp_path):
    text = PROTOCOL.replace('"blur"\n', '"blur"\nquality = "fast"\n', 1)
    settings = tiny_protocol(tmp_path, text).model_dump(mode="json")
    blur = next(each for each in settings["conditions"] if each["name"] == "blur")
    assert blur["quality"] == "fast"
    assert (
        blur["depth_of_field"]["samples"]
        == with_level("fast", depth_of_field={}).depth_of_field.samples
    )


def test_an_unknown_level_is_told_with_its_place(tmp_path):
    text = PROTOCOL.replace('"blur"\n', '"blur"\nquality = "ultra"\n', 1)
    with pytest.raises(InputError, match="'fast', 'balanced', 'accurate' or 'reference'") as caught:
        tiny_protocol(tmp_path, text)
    assert caught.value.line == 12


def test_settings_of_a_lens_are_left_out_where_no_lens_follows_the_law():
    level = QualityLevel(depth_of_field={"samples": 4}, lens={"views": 16})
    assert level.settings("depth_of_field", law="linear") == {"samples": 4}
    assert level.settings("depth_of_field", law="thin_lens") == {"samples": 4}
    assert level.settings("depth_of_field", law="dioptre") == {"samples": 4, "views": 16}
    assert level.settings("motion_blur") == {}


def test_figures_go_by_what_is_drawn():
    assert dial.effects_of(["scene", "tone_map"]) is None
    assert dial.effects_of(["motion_blur", "scene"]) == "motion_blur"
    assert dial.effects_of(["depth_of_field", "motion_blur"]) == "both"
    assert dial.effects_of(["depth_of_field", "speed_blur"]) is None
    odd = with_level("fast", depth_of_field={"samples": 70}, motion_blur={})
    assert dial.level_of(odd) is None
    assert dial.level_of(odd, ["motion_blur"]) == "fast"


def test_figures_are_found_by_the_settings_not_by_the_name_of_a_level():
    for figure in quality_table().figures:
        drawn = [name for name in DIALLED if figure.effects in {name, "both"}]
        effects = {"depth_of_field": {"law": "dioptre"}, "motion_blur": {}}
        named = with_level(figure.level, **{name: effects[name] for name in drawn})
        unnamed = named.model_copy(update={"quality": None})
        found = dial.figure_for(named, figure.scene, drawn)
        assert found == dial.figure_for(unnamed, figure.scene, drawn)
        # Two levels may have the same settings of an effect: either's figures are right.
        assert found is not None
        assert (found.effects, found.scene) == (figure.effects, figure.scene)
        assert found == figure or (found.psnr_db, found.flip) == (figure.psnr_db, figure.flip)
        assert dial.figure_for(named, "nowhere", drawn) is None


def test_blur_of_objects_alone_has_no_figures():
    """The figures are of cameras that move."""
    for mode, known in (("full", True), ("rotation_cancelled", True), ("objects_only", False)):
        blurred = with_level("fast", motion_blur={"mode": mode})
        figure = dial.figure_for(blurred, "temple", ["motion_blur"])
        assert (figure is not None) is known


@pytest.mark.parametrize("other", [{"samples": 7}, {"method": "per_pixel"}])
def test_another_method_has_no_figures_of_ours(other):
    for settings, known in (({}, True), (other, False)):
        condition = with_level("balanced", motion_blur={"mode": "full"} | settings)
        found = dial.figure_for(condition, "temple", ["motion_blur"])
        assert (found is not None) == known


def test_the_shipped_figures_are_complete_and_say_where_they_are_from():
    table = quality_table()
    assert table.measured is not None
    assert table.measured.command
    assert table.measured.device
    keys = [(each.level, each.effects, each.scene) for each in table.figures]
    scenes = {scene for _, _, scene in keys}
    assert sorted(keys) == sorted(
        (level, effects, scene)
        for level in LEVELS
        for effects in {effects for _, effects, _ in keys}
        for scene in scenes
    )


def test_writing_figures_keeps_the_levels_and_replaces_the_rest(tmp_path):
    file = tmp_path / "quality.toml"
    file.write_text(TABLE.read_text(encoding="utf-8"), encoding="utf-8")
    measured = MeasurementSource(command='do "it"', device="none", date="2026-01-01", how="±1")
    figure = QualityFigure(level="fast", effects="both", scene="s", cost_ratio=1.5, flip=0.25)
    for _ in range(2):
        dial.write_figures(file, measured, [figure])
    text = file.read_text(encoding="utf-8")
    table = QualityTable.model_validate(tomllib.loads(text))
    assert table == QualityTable(
        levels=quality_table().levels, measured=measured, figures=(figure,)
    )
    head = TABLE.read_text(encoding="utf-8").partition(dial.MARK)[0]
    assert text.startswith(head.rstrip())
