from __future__ import annotations

import tomllib
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.protocol import Protocol, load_protocol, parse_protocol
from vrcomfort.protocol.condition_check import NEEDS, condition_tables
from vrcomfort.protocol.conditions import Condition
from vrcomfort.resources import data_folder
from vrcomfort.settings.locate import locate


def test_a_protocol_knows_its_text_and_its_scene_files(tmp_path):
    protocol = tiny_protocol(tmp_path)
    assert protocol.toml == PROTOCOL
    assert len(protocol.sha256) == 64
    assert protocol.scene_source("room.glb") == str(tmp_path / "room.glb")
    assert protocol.condition("blur").depth_of_field is not None
    assert protocol.condition("plain").depth_of_field is None


@pytest.mark.parametrize(
    ("old", "new", "place", "says"),
    [
        ("exposure_s = 10.0", "exposure_ms = 10.0", (3, 1), "use `exposure_s`"),
        ("exposure_s = 10.0", "exposure = 10.0", (3, 1), "without a unit"),
        ("exposure_s = 10.0", "exposure_min = 10.0", (3, 1), "is in minutes"),
        ("exposure_s = 10.0", "exposure_s = '10'", (3, 1), "should be a number, got '10'"),
        ("exposure_s = 10.0", "exposure_s = true", (3, 1), "should be a number, got True"),
        ("exposure_s = 10.0", "exposure_s = -1", (3, 1), "equal to 0.001, got -1"),
        ("exposure_s = 10.0", "exposure_s = 1e300", (3, 1), "equal to 14400, got 1e+300"),
        ("training_s = 1.0", "training_s = 1e300", (5, 1), "equal to 14400, got 1e+300"),
        ("wait_s = 60.0", "wait_s = 1e308", (34, 1), "equal to 86400, got 1e+308"),
        ("exposure_s = 10.0", "exposure_s = nan", (3, 1), "exposure_s"),
        ("exposure_s = 10.0", "exposure_s = ", (3, 14), "not valid TOML"),
        ('title = "A tiny study"\n', "", (1, 1), "`title` is missing"),
        ("[ratings]", "[rating]", (36, 1), "did you mean `ratings`?"),
        ("[ratings]", "[locomotion]\nsnap_turn_deg = 0.1\n[ratings]", (37, 1), "or equal to 1"),
        ('"blur"\n', '"blur"\nlable = "x"\n', (12, 1), "did you mean `label`?"),
        ('rule = "explicit"', 'rule = "explict"', (15, 1), "'williams'"),
        ('[{ scene = "room.glb", condition = "p', '[{ scene = "room.glb", condition = "b',
         (19, 26), "no condition `blain`; did you mean `plain`?"),
        ('[{ scene = "room', '[{ scene = "rom', (19, 6), "no scene `rom.glb`"),
        ('[{ scene = "room.glb", cond', '[{ scene = "room.glb", conditon', (19, 26),
         "did you mean `condition`?"),
        ('scenes = ["room.glb"]', 'scenes = ["room.glb", "hall.glb"]', (4, 23), "no scene file"),
        ('name = "blur"', 'name = "plain"', (10, 1), "there twice"),
        ('name = "blur"', 'name = "Plain"', (10, 1), "`plain` and `Plain` are one name to some"),
        ('name = "blur"', 'name = "lpt1"', (11, 1), "Windows takes `lpt1` for a device"),
        ('name = "tiny"', 'name = "CON"', (1, 1), "Windows takes `CON` for a device"),
        ('rule = "explicit"', 'rule = "williams"', (16, 1), "makes its own sequences"),
        ("stop_at = 15", "stop_at = 15\n[simulation.condition_effects]\nblurr = 1.0", (42, 1),
         "did you mean `blur`?"),
        ('name = "ab"', 'name = "a b"', (17, 1), "only letters, digits, - and _, got 'a b'"),
        ('name = "tiny"', 'name = "tiny"\nparticipants = 4.5', (2, 1), "a whole number"),
        ("every_s = 3.0", "every_s = 9.0", (36, 1), "no rating fits into an exposure"),
        ('instrument = "fms"', 'instrument = "misc"', (40, 1), "the MISC goes from 0 to 10"),
    ],
)  # fmt: skip
def test_every_fault_is_told_with_its_place(tmp_path, old, new, place, says):
    assert old in PROTOCOL
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, PROTOCOL.replace(old, new, 1))
    assert (caught.value.line, caught.value.column) == place, str(caught.value)
    assert caught.value.file == tmp_path / "tiny.toml"
    assert says in caught.value.message


@pytest.mark.parametrize(("word", "value"), [("rings", "3"), ("taps", "24")])
def test_words_of_an_earlier_version_are_told_with_what_says_the_same_now(tmp_path, word, value):
    blur = "[conditions.depth_of_field]"
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    file = tmp_path / "old.toml"
    file.write_text(text.replace(blur, f"{blur}\n{word} = {value}", 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_protocol(file)
    assert caught.value.message.startswith(f"`{word}` is `samples` since there is one dial")
    assert "write `samples = 36`" in caught.value.message
    line = text[: text.index(blur)].count("\n") + 2
    assert (caught.value.line, caught.value.column) == (line, 1)


def test_further_faults_are_counted(tmp_path):
    text = PROTOCOL.replace("training_s", "traning_s").replace("timeout_s = 2.0", "timeout_s = 0")
    with pytest.raises(InputError, match="1 more problem in this file"):
        tiny_protocol(tmp_path, text)


def test_a_shipped_scene_that_does_not_exist():
    with pytest.raises(InputError, match="there is no scene `hall`"):
        parse_protocol(PROTOCOL.replace('"room.glb"', '"hall"'))


@pytest.mark.parametrize("name", ["carnegy_2015", "nowhere/at_all.toml"])
def test_a_protocol_that_does_not_exist(name):
    with pytest.raises(InputError, match=r"no protocol file .* `"):
        load_protocol(name)


def test_a_protocol_that_is_not_text(tmp_path):
    (tmp_path / "p.toml").write_bytes(b'name = "\xff"')
    with pytest.raises(InputError, match="UTF-8"):
        load_protocol(tmp_path / "p.toml")


def test_carnegie_2015_has_the_numbers_of_the_paper():
    protocol = load_protocol("carnegie_2015")
    on, off = protocol.condition("dof_on"), protocol.condition("dof_off")
    assert off.depth_of_field is None
    assert on.depth_of_field is not None
    assert (on.depth_of_field.law, on.depth_of_field.max_radius_percent) == ("linear", 1.75)
    assert (on.focus.law, on.focus.refocus_s, on.focus.infinity_m) == ("linear", 0.5, 30_000)
    assert (protocol.exposure_s, protocol.training_s) == (900, 60)
    assert protocol.headset.ipd_m == 0.063
    assert protocol.locomotion.walking_speed_m_s == 1.4
    assert protocol.locomotion.snap_turn_deg is None
    asked = [(ask.timepoint, ask.when, ask.wait_s) for ask in protocol.questionnaires]
    assert asked == [
        ("baseline", "session_start", 0),
        ("post", "after_trial", 0),
        ("recovery", "session_end", 900),
    ]


def test_motion_blur_2020_has_the_articles_camera_forms():
    protocol = load_protocol("motion_blur_2020")
    modes = {c.name: c.motion_blur.mode for c in protocol.conditions if c.motion_blur}
    assert modes == {
        "full": "full",
        "objects": "objects_only",
        "translation": "rotation_cancelled",
        "translation_faded": "rotation_cancelled",
    }
    assert protocol.condition("off").motion_blur is None
    assert protocol.condition("translation_faded").motion_blur.fade_with_turning
    for sequence in build_design(protocol).plan(20):
        assert [len(session) for session in sequence.sessions] == [1] * 5


def test_carnegie_2015_reverses_scenes_and_keeps_the_place_of_blur():
    for sequence in load_protocol("carnegie_2015").order.sequences:
        first, second = sequence.sessions
        assert [trial.scene for trial in first] == [trial.scene for trial in second][::-1]
        assert [trial.condition for trial in first] == [trial.condition for trial in second]


def test_smoke_shows_every_effect_in_seconds():
    protocol = load_protocol("smoke")
    effects = [
        (c.depth_of_field is not None, c.motion_blur is not None) for c in protocol.conditions
    ]
    assert sorted(effects) == [(False, False), (False, True), (True, False), (True, True)]
    trials = len(protocol.conditions) * len(protocol.scenes)
    assert trials * protocol.exposure_s < 10


def test_locate_follows_every_form_of_key():
    text = (
        'a.b = 1\n"c d" = """x = [\n"""\n'
        "[t.'u']\nv = { w = [1, { x = 'y]' }] } # z = 3\n"
        "[[r]]\nk = 1979-05-27 07:32:00\n[r.s]\nq=0\n[[r]]\n  k = [\n  [1, 2], # one\n  [3]]\n"
    )
    tomllib.loads(text)
    places = locate(text)
    assert places.of(("a", "b")) == (1, 3)
    assert places.of(("c d",)) == (2, 1)
    assert places.of(("t", "u", "v", "w", 1, "x")) == (5, 17)
    assert places.of(("r", 0, "s", "q")) == (9, 1)
    assert places.of(("r", 1, "k", 1, 0)) == (13, 4)
    assert places.of(("r", 1, "no", "such")) == (10, 1)


_KEYS = st.from_regex(r"[A-Za-z0-9_-]{1,6}", fullmatch=True)
_VALUES = st.recursive(
    st.one_of(st.integers(-9, 9), st.booleans(), st.text("ab]}#',= \\", max_size=5)),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_KEYS, inner, max_size=3),
    max_leaves=8,
)


def _toml(value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\") + '"'
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(each)}" for key, each in value.items()) + "}"
    return str(value)


def _paths(value, path=()):
    pairs = value.items() if isinstance(value, dict) else enumerate(value)
    for key, each in pairs:
        yield (*path, key)
        if isinstance(each, dict | list):
            yield from _paths(each, (*path, key))


@pytest.mark.slow
@given(st.dictionaries(_KEYS, _VALUES, max_size=5))
def test_locate_finds_exactly_the_keys_that_a_parser_finds(data):
    text = "".join(f"{key} = {_toml(value)}  # note = 1\n" for key, value in data.items())
    assert tomllib.loads(text) == data
    assert set(locate(text).offsets) == set(_paths(data))


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ("focus = { fixed_m = 3.0 }", '`fixed_m` does nothing with method = "nine_ray"'),
        ('focus = { method = "fixed", law = "instant" }', 'nothing with method = "fixed"'),
        ('focus = { law = "instant", cutoff_hz = 4.0 }', 'nothing with law = "instant"'),
        ('focus = { method = "gaze", ring_deg = 3.0 }', 'nothing with method = "gaze"'),
        ('motion_blur = { mode = "full", neck = {} }', '`neck` does nothing with mode = "full"'),
        (
            'focus = { method = "autofocus_zone", zone_statistic = "maximum", mean = "metres" }',
            '`mean` does nothing with zone_statistic = "maximum"',
        ),
        ('focus = { zone_statistic = "mean" }', 'nothing with method = "nine_ray"'),
        ("depth_of_field = { pupil_mm = 3.0 }", '`pupil_mm` does nothing with law = "linear"'),
        ('depth_of_field = { kernel = "mip", samples = 36 }', 'nothing with kernel = "mip"'),
        ("depth_of_field = { slices_m = [1, 2] }", "`slices_m` does nothing with kernel ="),
        ("depth_of_field = { rotate_taps = false }", "`rotate_taps` does nothing with kernel ="),
        ("depth_of_field = { over_blur = 0.5 }", "nothing with views = 1"),
        ('quality = "fast"', "`quality` does nothing without depth_of_field or motion_blur"),
        ('focus = { method = "gaze", without_gaze = "nine_ray", ring_deg = 3.0 }', None),
        ('quality = "fast"\ndepth_of_field = { kernel = "mip" }', None),
        ('depth_of_field = { law = "eye", views = 4, over_blur = 0.5 }', None),
    ],
)  # fmt: skip
def test_settings_that_do_nothing_are_refused(tmp_path, settings, says):
    text = PROTOCOL.replace('name = "plain"\n', f'name = "plain"\n{settings}\n', 1)
    assert text != PROTOCOL
    if says is None:
        tiny_protocol(tmp_path, text)
        return
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text)
    assert says in caught.value.message


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        (
            "focus = { infinity_m = 1e39 }",
            "`infinity_m`: should be less than or equal to 1000000000",
        ),
        (
            "focus = { infinity_m = 5e-324 }",
            "`infinity_m`: should be greater than or equal to 0.001",
        ),
        ('focus = { method = "fixed", fixed_m = 1e-9 }', "`fixed_m`: should be greater than"),
        ('focus = { law = "duration", duration_s = 1e308 }', "`duration_s`: should be less than"),
        ("focus = { refocus_s = 5e-324 }", "`refocus_s`: should be greater than or equal to 0.001"),
        ("depth_of_field = { slices_m = [2, 1] }", "`slices_m`: must rise: the nearest"),
        ("motion_blur = { neck = { behind_m = 10 } }", "`behind_m`: should be less than or equal"),
        ("motion_blur = { fade_with_turning = 3 }", "`fade_with_turning`: should be a table {"),
        ("depth_of_field = { full_blur_m = 1e308 }", "`full_blur_m`: should be less than"),
    ],
)
def test_what_cannot_be_seen_or_waited_for_is_refused_with_its_place(tmp_path, settings, says):
    text = PROTOCOL.replace('name = "plain"\n', f'name = "plain"\n{settings}\n', 1)
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text)
    assert says in caught.value.message
    assert caught.value.line == 9
    assert caught.value.column == settings.rindex(" ", 0, settings.rindex("=") - 1) + 2


@pytest.mark.parametrize(
    ("value", "says"), [("9" * 5000, "not valid TOML"), ("[" * 9999, "nested too deep")]
)
def test_what_python_cannot_hold_is_refused(tmp_path, value, says):
    with pytest.raises(InputError, match=says) as caught:
        tiny_protocol(tmp_path, f"participants = {value}\n{PROTOCOL}")
    assert caught.value.file == tmp_path / "tiny.toml"


@pytest.mark.parametrize("model", [Condition, Protocol])
def test_no_number_of_a_protocol_is_without_bounds(model):
    """What has a least but no greatest value is accepted where nothing can show it."""
    assert list(unbounded(model)) == []


def unbounded(model):
    for name, field in model.model_fields.items():
        parts = [field.annotation, *get_args(field.annotation)]
        for part in [*parts, *(inner for each in parts for inner in get_args(each))]:
            if isinstance(part, type) and issubclass(part, BaseModel):
                yield from unbounded(part)
        limits = {side for limit in field.metadata for side in ("le", "lt") if hasattr(limit, side)}
        if {int, float} & set(parts) and not limits:
            yield f"{model.__name__}.{name}"


def test_needs_name_settings_and_values_that_there_are():
    assert sum(map(len, NEEDS.values())) > 30
    for effect, model in condition_tables():
        fields = model.model_fields
        for key, needs in NEEDS[effect].items():
            assert {key, *needs} <= fields.keys()
            for choice, values in needs.items():
                known = get_args(fields[choice].annotation) or range(1, 257)
                assert set(values) < set(known), (key, choice)


NOTHING = """name = "n"
title = "N"
exposure_s = 300.0
scenes = ["temple"]
[[conditions]]
name = "plain"
[order]
rule = "latin_square"
"""


@pytest.mark.parametrize(
    "asked",
    [
        '[[questionnaires]]\ntimepoint = "post"\nwhen = "after_trial"\n',
        "[[ratings]]\n",
        '[[tasks]]\nname = "shoot"\nkind = "aiming"\n',
    ],
)
def test_a_study_asks_rates_or_has_something_done(asked):
    assert parse_protocol(NOTHING + asked).name == "n"
    with pytest.raises(InputError, match=r"nothing is asked, rated or done; add \[\[quest"):
        parse_protocol(NOTHING)
