"""Continuous ratings: where a slider stands all through an exposure, and what is made of it."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.session.test_adjustment import Turned
from tests.support.protocols import ASKED_AFTER_EACH, BLUR, NOBODY_LEAVES, PLAIN, protocol_text
from tests.support.report import build_report
from tests.support.study import Scripted, read_rows
from tests.support.tasks import do, doing_protocol
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.headset.inputs import HandInput, Inputs, KeyInput
from vrcomfort.report.measures import measure_of, values_of
from vrcomfort.report.study_data import read_study
from vrcomfort.session import NoPictures, StillHeadset

PROTOCOL = protocol_text(
    ASKED_AFTER_EACH,
    '[[sliders]]\nname = "how_bad"\n',
    f"{NOBODY_LEAVES}baseline_sd = 0.0\nrate_per_min = 6.0\ncondition_effects = {{ calm = 0.1 }}\n",
    name="sliding",
    exposure_s=10.0,
    conditions=(PLAIN.replace("plain", "calm"), BLUR.replace("blur", "wild")),
)
TASK = """
[[tasks]]
name = "shoot"
kind = "aiming"
"""


def slide(folder, text=PROTOCOL, **more):
    return do(folder, text, **more)


def places(folder, participant="P01", trial="1"):
    rows = read_rows(folder / f"S/sub-{participant}/ses-1/dials.csv")
    return [row for row in rows if row["trial"] == trial]


def by_hand(folder, script, text=PROTOCOL):
    slide(folder, text, respondent=Scripted(), headset_for=lambda *_: Turned(script=script))
    return [float(row["value"]) for row in places(folder) if row["kind"] == "sample"]


def pushed(stick):
    return Inputs(right=HandInput(thumbstick=(0.0, stick)))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slid")
    for who in ("P01", "P02"):
        assert slide(folder, participant=who).status == "completed"
    return folder


def test_the_stick_is_the_slider_and_rests_at_the_lowest_answer(tmp_path):
    up, down = (dict.fromkeys(range(at, at + 25), pushed(to)) for at, to in ((25, 1.0), (50, -1.0)))
    found = by_hand(tmp_path, up | down)
    assert len(found) == 19  # twice a second, and none at the very end
    assert found[:4] == [0.0] * 4
    assert found[5:9] == [20.0] * 4  # the top of FMS
    assert found[10:] == [0.0] * 9


def test_a_stick_may_move_the_slider_instead(tmp_path):
    script = dict.fromkeys(range(10, 20), pushed(1.0))
    found = by_hand(tmp_path, script, PROTOCOL.replace('"how_bad"', '"how_bad"\nstick = "rate"'))
    assert found[0] == 0.0
    assert found[5:] == pytest.approx([4.0] * 14)  # 1 s of the 5 through the range


def test_a_slider_that_is_moved_ticks_at_each_answer_that_it_passes(tmp_path):
    ticks = []

    class Felt(Turned):
        def tick(self, hand):
            ticks.append((self.now, hand))

    script = dict.fromkeys(range(10, 20), pushed(1.0))
    for stick in ("rate", "place"):
        text = PROTOCOL.replace('"how_bad"', f'"how_bad"\nstick = "{stick}"')
        headset = lambda *_: Felt(script=script)  # noqa: E731
        slide(tmp_path / stick, text, respondent=Scripted(), headset_for=headset)
        if stick == "rate":
            assert len(ticks) == 2 * 4  # from 0 to 4 in each of two exposures
            assert {hand for _, hand in ticks} == {1}
            assert all(10 <= frame < 20 for frame, _ in ticks)
    assert len(ticks) == 2 * 4  # a stick that is the slider is felt by itself


def test_arrow_keys_go_a_twentieth(tmp_path):
    up, down = (Inputs(keys=KeyInput(arrow=(0, way))) for way in (-1, 1))
    assert by_hand(tmp_path, {3: up, 4: up, 8: down})[2:] == [1.0] * 17


def test_samples_come_at_their_rate_with_their_time(study):
    rows = places(study)
    assert [row["kind"] for row in rows] == ["start", *["sample"] * 19, "end"]
    onset_s = [float(row["onset_s"]) for row in rows]
    assert onset_s == sorted(onset_s)
    assert [b - a for a, b in pairwise(onset_s[1:-1])] == pytest.approx([0.5] * 18)
    assert {(row["instrument"], row["setting"]) for row in rows} == {("fms", "")}


def test_simulated_participants_rate_what_they_feel(study, tmp_path):
    slopes = {
        (v.participant, v.condition): float(v.number)
        for v in values_of(read_study(study / "S"), measure_of("ratings.slope"))
    }
    assert len(slopes) == 4
    for who in ("P01", "P02"):
        assert slopes[who, "wild"] > slopes[who, "calm"]
        assert slopes[who, "wild"] > 0
    slide(tmp_path)
    assert [row["value"] for row in places(tmp_path)] == [row["value"] for row in places(study)]


def test_measures_are_those_of_the_samples(study):
    read = read_study(study / "S")
    samples = [float(row["value"]) for row in places(study) if row["kind"] == "sample"]
    expected = {"peak": max(samples), "mean": sum(samples) / 19, "last": samples[-1]}
    for name, value in expected.items():
        (found,) = (
            v.number
            for v in values_of(read, measure_of(f"ratings.{name}"))
            if (v.participant, v.trial) == ("P01", "1")
        )
        assert float(found) == pytest.approx(value), name


def test_answers_to_questionnaires_are_the_same_with_and_without_a_slider(study, tmp_path):
    slide(tmp_path, PROTOCOL.replace('[[sliders]]\nname = "how_bad"\n', ""))
    asked = "S/sub-P01/ses-1/questionnaires.csv"
    with_slider, without = (
        [row["response"] for row in read_rows(folder / asked)] for folder in (study, tmp_path)
    )
    assert with_slider == without


def test_without_frames_the_same_people_rate_alike(study, tmp_path):
    outcome = slide(
        tmp_path, headset_for=lambda *_: StillHeadset(), renderer=NoPictures(),
        load_scene=lambda _: None, jumps=True,
    )  # fmt: skip
    assert outcome.status == "completed"
    ends = [float(places(folder)[-1]["value"]) for folder in (study, tmp_path)]
    assert ends[0] == pytest.approx(ends[1], abs=2.0)


def test_a_slider_stands_beside_a_task(tmp_path):
    text = PROTOCOL.replace("[[sliders]]", TASK + "[[sliders]]")
    slide(tmp_path, text.replace("scenes", 'task = "shoot"\nscenes'))
    assert len(places(tmp_path)) == 21
    assert read_rows(tmp_path / "S/sub-P01/ses-1/tasks.csv")
    assert not verify_study(tmp_path / "S").faults


def test_verify_and_anonymise_know_it(study, tmp_path):
    assert not verify_study(study / "S").faults
    anonymise(study / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    assert not verify_study(tmp_path / "shared").faults


@pytest.mark.slow
def test_the_report_draws_its_courses(study, tmp_path):
    build_report(study / "S", out=tmp_path / "report")
    page = (tmp_path / "report/index.html").read_text(encoding="utf-8")
    assert "76 ratings" in page  # 19 in each of four exposures


@pytest.mark.slow
def test_a_condition_without_a_slider_has_an_empty_panel(tmp_path):
    text = PROTOCOL.replace('"how_bad"', '"how_bad"\nconditions = ["wild"]')
    for who in ("P01", "P02"):
        slide(tmp_path, text, participant=who)
    build_report(tmp_path / "S", out=tmp_path / "report", forms=("svg",))
    drawn = (tmp_path / "report/figures").glob("*.svg")
    assert any("0 exposures" in each.read_text(encoding="utf-8") for each in drawn)


@pytest.mark.parametrize(
    ("extra", "says"),
    [
        ('instrument = "ssq"', "a slider is one question"),
        ('instrument = "fmss"', "did you mean"),
        ('conditions = ["wilt"]', "did you mean `wild`"),
        ('[[ratings]]\ninstrument = "fms"\nevery_s = 5.0\ntimeout_s = 2.0', "keep one"),
        ('[[sliders]]\nname = "other"\ninstrument = "misc"', "one dial for an exposure"),
        ('[[sliders]]\nname = "again"\nconditions = ["wild"]', "the FMS is rated twice"),
        (
            '[[adjustments]]\nname = "a"\nsetting = "depth_of_field.full_blur_m"\n'
            "range = [1.0, 9.0]",
            "one dial for an exposure",
        ),
        (
            '[[adjustments]]\nname = "how_bad"\nsetting = "depth_of_field.full_blur_m"\n'
            "range = [1.0, 9.0]",
            "an adjustment is called `how_bad`",
        ),
    ],
)
def test_what_cannot_be_rated_so_is_refused(tmp_path, extra, says):
    text = PROTOCOL.replace('name = "how_bad"\n', f'name = "how_bad"\n{extra}\n')
    with pytest.raises(InputError) as refused:
        doing_protocol(tmp_path, text)
    assert says in str(refused.value)
    assert refused.value.line is not None
