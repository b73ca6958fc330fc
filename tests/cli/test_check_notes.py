"""What `check` notes: what a protocol says and participants would not get."""

from __future__ import annotations

import pytest

STUDY = """\
name = "noted"
title = "Noted"
participants = 24
exposure_s = 40.0
break_s = 60.0
scenes = ["spin"]

[[views]]
name = "spin"
scene = "temple"
points = [
  {{ time_s = 0.0, position = [0.0, 0.0, 3.0], yaw_deg = 0.0 }},
  {{ time_s = 200.0, position = [0.0, 0.0, 3.0], yaw_deg = {yaw_deg} }},
]

[[conditions]]
name = "plain"

[[conditions]]
name = "narrow"
{vignette}

[[conditions]]
name = "wide"

[order]
rule = "williams"

[[questionnaires]]
timepoint = "post"
when = "after_trial"
"""
CLOSES = "turning = { from_deg_s = 10.0, to_deg_s = 60.0 }"


@pytest.fixture
def noted(run, tmp_path):
    """Return what `check` says of the study: its exit code, and both of its outputs."""

    def check(*replaced, yaw_deg="90.0", vignette=None):
        table = "" if vignette is None else f"[conditions.vignette]\n{vignette}"
        text = STUDY.format(yaw_deg=yaw_deg, vignette=table)
        for old, new in replaced:
            assert old in text
            text = text.replace(old, new)
        file = tmp_path / "noted.toml"
        file.write_text(text, encoding="utf-8")
        code, out, err = run("check", file, "--no-draw", "--refresh-hz", 15)
        return code, out, [line for line in err.splitlines() if line.startswith("note:")]

    return check


def test_a_study_that_means_what_it_says_has_no_note(noted):
    code, out, notes = noted()
    assert (code, notes) == (0, [])
    assert "nothing is wrong" in out


@pytest.mark.parametrize("yaw_deg", ["180.0", "-350.0"])
def test_a_step_of_half_a_turn_or_more_is_named(noted, yaw_deg):
    code, out, (note,) = noted(yaw_deg=yaw_deg)
    assert code == 0
    assert "no fault; 1 note" in " ".join(out.split())
    told = f"view `spin`: from point 1 to point 2 `yaw_deg` goes from 0 to {yaw_deg[:-2]}, but"
    assert told in note
    assert "write `unwrapped = true`" in note


def test_a_step_that_is_turned_is_not_named(noted):
    turns = ('scene = "temple"', 'scene = "temple"\nunwrapped = true')
    assert noted(turns, yaw_deg="360.0")[2] == []


def test_unwrapped_without_points_is_refused(run, tmp_path):
    text = STUDY.format(yaw_deg="90.0", vignette="")
    start, end = text.index("points = ["), text.index("[[conditions]]")
    file = tmp_path / "noted.toml"
    file.write_text(f"{text[:start]}unwrapped = true\n\n{text[end:]}", encoding="utf-8")
    code, _, err = run("check", file, "--no-draw")
    assert code == 2
    assert "`unwrapped` does nothing without `points`" in err


AVATAR = 'speed_of = "avatar"\nmoving = { from_m_s = 0.2, to_m_s = 1.5 }'
NEVER_NARROW = [
    ("", "it has neither `turning` nor `moving`"),
    ("restricted_deg = 40.0", "it has neither `turning` nor `moving`"),
    ("open_deg = 170.0", "its field is at least 170 degrees wide"),
    (f"{CLOSES}\nopen_deg = 60.0", "`restricted_deg` is `open_deg`"),
    (f"{CLOSES}\nopen_deg = 170.0\nrestricted_deg = 160.0", "at least 160 degrees wide"),
    (f"{CLOSES}\nopen_deg = 180.0\nattack_s = 3600.0", "at least 1"),
    (CLOSES.replace("10.0", "800.0").replace("60.0", "900.0"), "`turning` begins at 800"),
    (AVATAR, 'speed_of = "avatar") moving reaches 0.0 m/s, and `moving` begins at 0.2'),
]


def conditions(vignettes):
    """Return a replacement of the study's conditions by one for each vignette."""
    written = STUDY.format(yaw_deg="", vignette="")
    there = written[written.index("[[conditions]]") : written.index("[order]")]
    tables = "".join(
        f'[[conditions]]\nname = "v{number}"\n[conditions.vignette]\n{vignette}\n\n'
        for number, vignette in enumerate(vignettes)
    )
    return there, tables


def test_vignettes_that_never_narrow_the_view_are_noted(noted):
    notes = noted(conditions([vignette for vignette, _ in NEVER_NARROW]))[2]
    assert len(notes) == len(NEVER_NARROW)
    for number, (note, (_, says)) in enumerate(zip(notes, NEVER_NARROW, strict=True)):
        assert f"the vignette of `v{number}` never narrows the view: " in note
        assert says in note


def test_vignettes_that_narrow_it_in_one_scene_are_not(noted):
    walking = ('scenes = ["spin"]', 'scenes = ["spin", "temple"]')
    notes = noted(walking, conditions([CLOSES, "open_deg = 60.0", AVATAR]))[2]
    assert not any("never narrows" in note for note in notes)


LONG = ("exposure_s = 40.0", "exposure_s = 120.0")
UNSAID, ZERO = ("break_s = 60.0\n", ""), ("break_s = 60.0", "break_s = 0.0")


def test_exposures_without_a_rest_are_noted(noted):
    for replaced in (UNSAID, ZERO):
        _, _, (note,) = noted(LONG, replaced)
        assert "3 exposures of a session, 6.0 min together, follow each other" in note
        assert note.endswith("give `break_s` a length, or write [breaks]")


@pytest.mark.parametrize(
    "rest", [("[order]", "[breaks]\n\n[order]"), ('"after_trial"', '"after_trial"\nwait_s = 60.0')]
)
def test_breaks_and_waiting_for_questions_are_rests(noted, rest):
    assert noted(LONG, UNSAID, rest)[2] == []


def test_a_few_minutes_without_a_rest_may_be_meant(noted):
    assert noted(ZERO)[2] == []
    _, _, (note,) = noted(UNSAID)
    assert "or `break_s = 0.0` where none is meant" in note


RATINGS = """
[[ratings]]
instrument = "{}"
every_s = {}
timeout_s = {}
"""


def rated(*ratings):
    """Return a replacement that adds ratings of (instrument, every_s, timeout_s)."""
    asked = 'timepoint = "post"\nwhen = "after_trial"\n'
    return asked, asked + "".join(RATINGS.format(*each) for each in ratings)


def test_ratings_that_are_asked_less_often_than_they_are_due_are_noted(noted):
    _, _, (one, other) = noted(rated(("fms", 10.0, 10.0), ("misc", 10.0, 10.0)))
    assert "the rating `fms` is due 3 times in an exposure of 40 s, and may be asked 2" in one
    assert "the rating `misc` is due 3 times in an exposure of 40 s, and may be asked 1" in other
    _, _, (note,) = noted(rated(("fms", 5.0, 15.0)))
    assert "the rating `fms` is due 5 times" in note


def test_ratings_with_time_for_each_are_not(noted):
    assert noted(rated(("fms", 10.0, 5.0), ("misc", 20.0, 5.0)))[2] == []
