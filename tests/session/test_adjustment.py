"""Method of adjustment: what a dial does to the condition, what is kept, and what is refused."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field

import pytest
from typer.testing import CliRunner

from tests.support.exchange import cell
from tests.support.protocols import (
    ASKED_AFTER_EACH,
    BLUR,
    NOBODY_LEAVES,
    PLAIN,
    explicit_order,
    protocol_text,
)
from tests.support.study import AheadHeadset, LateFocus, Scripted, read_rows
from tests.support.tasks import do, doing_protocol
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.headset.inputs import HandInput, Inputs, KeyInput
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.adjustments import ADJUSTABLE, Adjustment, value_of
from vrcomfort.report.measures import measure_of, values_of
from vrcomfort.report.study_data import read_study
from vrcomfort.session import NoPictures, StillHeadset

SETTING = "depth_of_field.full_blur_dioptre"


def adjusting(*session: str, exposure_s: float = 10.0) -> str:
    """Return a protocol whose only session shows these conditions; all but `plain` have a dial."""
    return protocol_text(
        ASKED_AFTER_EACH,
        f"""\
[[adjustments]]
name = "comfortable_blur"
setting = "{SETTING}"
range = [0.5, 8.0]
scale = "log"
""",
        f"{NOBODY_LEAVES}adjusts_to = {{ comfortable_blur = 2.0 }}\n",
        name="adjusting",
        exposure_s=exposure_s,
        conditions=(
            PLAIN,
            BLUR.replace("blur", "lens") + 'law = "dioptre"\n',
            BLUR.replace("blur", "film") + 'law = "dioptre"\n[conditions.motion_blur]\n',
        ),
        order=explicit_order(a=[session]),
    )


SESSION = ("lens", "plain", "film", "lens")
PROTOCOL, SHORT = adjusting(*SESSION), adjusting(*SESSION, exposure_s=1.0)
ONCE = adjusting("lens")


@dataclass
class Drawn(LateFocus):
    """Keeps what each frame would have been drawn with."""

    values: list[float | None] = field(default_factory=list)

    def begin(self, scene, condition):
        super().begin(scene, condition)
        self.condition = condition

    def adjust(self, condition):
        self.condition = condition

    def render(self, frame, scene_time_s):
        self.values.append(value_of(self.condition, SETTING))
        return super().render(frame, scene_time_s)


@dataclass
class Turned(AheadHeadset):
    """Somebody with a thumb-stick and a keyboard, who does something at each frame."""

    script: dict[int, Inputs] = field(default_factory=dict)
    arrows_turn: bool = False
    now: int = -1

    def frames(self):
        for each in super().frames():
            self.now = each.index
            yield each

    def inputs(self):
        assert self.arrows_turn
        return self.script.get(self.now, Inputs())


def adjust(folder, text=PROTOCOL, **more):
    return do(folder, text, **{"renderer": Drawn(), **more})


def turns(folder, participant="P01", study="S"):
    return read_rows(folder / study / f"sub-{participant}/ses-1/dials.csv")


def final(folder, participant="P01"):
    return {
        (row["trial"], row["attempt"]): float(row["value"])
        for row in turns(folder, participant)
        if row["kind"] == "confirmed"
    }


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("adjusted")
    for who in ("P01", "P02"):
        assert adjust(folder, participant=who).status == "completed"
    return folder


@pytest.fixture(scope="module")
def without_noise(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exact")
    text = PROTOCOL.replace("adjusts_to", "adjust_sd = 0.0\nadjust_noise = 0.0\nadjusts_to")
    adjust(folder, text)
    return folder


def by_hand(folder, script, text=ONCE):
    """Run somebody with these inputs in an exposure; return what was drawn in it."""
    drawn = Drawn()
    headset = lambda *_: Turned(script=script)  # noqa: E731
    adjust(folder, text, respondent=Scripted(), headset_for=headset, renderer=drawn)
    return drawn.values


def test_what_is_drawn_is_what_the_dial_says(tmp_path):
    up = Inputs(right=HandInput(thumbstick=(0.0, 1.0)))
    script = dict.fromkeys(range(10, 20), up) | {50: Inputs(right=HandInput(select=True))}
    text = ONCE.replace('"log"', '"linear"\nstart = "ascending"')
    drawn = by_hand(tmp_path, script, text)
    assert drawn[:10] == [0.5] * 10
    assert drawn[19:] == pytest.approx([0.5 + 7.5 / 5] * 81)  # 1 s of the 5 through the range
    rows = turns(tmp_path)
    assert [row["kind"] for row in rows] == ["start", *["change"] * 10, "confirmed"]
    assert [float(row["value"]) for row in rows[1:11]] == drawn[10:20]
    onset_s = [float(row["onset_s"]) for row in rows]
    (trial,) = read_rows(tmp_path / "S/sub-P01/ses-1/trials.csv")
    assert onset_s[0] == pytest.approx(float(trial["start_s"]))
    assert onset_s[1] - onset_s[0] == pytest.approx(1.0)
    assert onset_s[-1] - onset_s[0] == pytest.approx(5.0)


def test_arrow_keys_go_steps_and_enter_confirms(tmp_path):
    up, down = (Inputs(keys=KeyInput(arrow=(0, way))) for way in (-1, 1))
    script = {3: up, 4: up, 5: down, 8: Inputs(keys=KeyInput(enter=True)), 9: up}
    text = ONCE.replace('"log"', '"linear"\nstart = "ascending"\nsteps = 15')
    drawn = by_hand(tmp_path, script, text)
    assert drawn[:9] == [0.5, 0.5, 0.5, 1.0, 1.5, 1.0, 1.0, 1.0, 1.0]
    assert set(drawn[9:]) == {1.0}  # what is confirmed stays


def test_nobody_turns_it_beyond_its_range(tmp_path):
    up = Inputs(right=HandInput(thumbstick=(0.0, 1.0)))
    drawn = by_hand(tmp_path, dict.fromkeys(range(100), up))
    assert max(drawn) == drawn[-1] == 8.0
    assert turns(tmp_path)[-1]["kind"] == "end"  # and nobody confirmed
    measure = measure_of("dials.comfortable_blur")
    values = values_of(read_study(tmp_path / "S"), measure)
    assert {(each.number, each.reason) for each in values} == {(None, "it was not confirmed")}


def test_a_stick_that_rests_beside_its_middle_turns_nothing(tmp_path):
    off = Inputs(right=HandInput(thumbstick=(0.0, 0.14)), left=HandInput(thumbstick=(0.0, 1.0)))
    assert len(set(by_hand(tmp_path, dict.fromkeys(range(100), off)))) == 1


@pytest.mark.parametrize(
    ("start", "values"), [("ascending", {0.5}), ("descending", {8.0}), ("setting", {2.0})]
)
def test_it_begins_where_the_protocol_says(tmp_path, start, values):
    adjust(tmp_path, SHORT.replace('"log"', f'"log"\nstart = "{start}"'))
    begun = [float(row["value"]) for row in turns(tmp_path) if row["kind"] == "start"]
    assert set(begun) == values
    assert len(begun) == 3


def test_ends_alternate_and_the_first_is_drawn_for_each_participant(tmp_path):
    text = SHORT.replace('"log"', '"log"\nstart = "alternating"')
    orders = set()
    for who in ("P01", "P03"):
        adjust(tmp_path, text, participant=who)
        orders.add(tuple(starts(tmp_path, who)))
    assert orders == {("0.5", "8.0", "0.5"), ("8.0", "0.5", "8.0")}


def starts(folder, participant):
    return [row["value"] for row in turns(folder, participant) if row["kind"] == "start"]


def test_random_starts_fill_the_range_and_follow_from_the_seed(study, without_noise):
    assert len({*starts(study, "P01"), *starts(study, "P02")}) == 6
    again = starts(without_noise, "P01")
    assert again == starts(study, "P01")
    assert all(0.5 <= float(value) <= 8.0 for value in again)


def test_simulated_participants_come_to_what_they_want(study, without_noise):
    found = final(study)
    assert set(found) == {("1", "1"), ("3", "1"), ("4", "1")}
    # About 2, spread by 0.1 and 0.03 of a range of four octaves.
    assert all(1.0 < each < 4.0 for each in found.values())
    assert len(set(found.values())) == 3
    assert list(final(without_noise).values()) == pytest.approx([2.0] * 3, rel=0.02)


def test_without_frames_the_same_people_adjust_to_the_same(study, tmp_path):
    outcome = adjust(
        tmp_path,
        headset_for=lambda *_: StillHeadset(),
        renderer=NoPictures(),
        load_scene=lambda _: None,
        jumps=True,
    )
    assert outcome.status == "completed"
    assert final(tmp_path) == pytest.approx(final(study), rel=0.03)


def test_an_exposure_ends_with_what_is_confirmed_where_the_protocol_says_so(tmp_path):
    adjust(tmp_path, PROTOCOL.replace("scenes =", 'exposure_ends = "adjustment"\nscenes ='))
    trials = read_rows(tmp_path / "S/sub-P01/ses-1/trials.csv")
    lengths = {row["trial"]: float(row["end_s"]) - float(row["start_s"]) for row in trials}
    assert all(lengths[each] < 8 for each in "134")
    assert lengths["2"] == pytest.approx(10.0)  # nothing was adjusted in it
    assert {row["trial"]: row["abort_code"] for row in trials} == {
        "1": "adjustment", "2": "", "3": "adjustment", "4": "adjustment",
    }  # fmt: skip
    assert not verify_study(tmp_path / "S").faults


def test_an_exposure_that_is_shown_again_begins_at_the_same_value(tmp_path):
    class Breaks(AheadHeadset):
        def frames(self):
            for each in super().frames():
                if each.index == 25:
                    raise KeyboardInterrupt
                yield each

    assert adjust(tmp_path, ONCE, headset_for=lambda *_: Breaks()).status == "aborted"
    file = tmp_path / "S/sub-P01/ses-1/dials.csv"
    with file.open("ab") as stream:
        stream.write(b"P01,1,1,lens,1,comf")  # the power went
    assert adjust(tmp_path, ONCE, resume=True).status == "completed"
    begun = [row for row in turns(tmp_path) if row["kind"] == "start"]
    assert [(row["attempt"], row["resumed"]) for row in begun] == [("1", "0"), ("2", "1")]
    assert begun[0]["value"] == begun[1]["value"]
    found = verify_study(tmp_path / "S").findings
    assert not [each for each in found if each.fault and "dials.csv" in each.file]
    assert {row["attempt"] for row in read_study(tmp_path / "S").dials} == {"2"}


def test_the_report_has_the_value_that_was_confirmed(study):
    read = read_study(study / "S")
    values = values_of(read, measure_of("dials.comfortable_blur"))
    assert {(v.participant, v.trial): float(v.number) for v in values} == pytest.approx(
        {
            (who, trial): value
            for who in ("P01", "P02")
            for (trial, _), value in final(study, who).items()
        }
    )
    assert {v.condition for v in values} == {"lens", "film"}
    with pytest.raises(InputError, match="did you mean `comfortable_blur`"):
        values_of(read, measure_of("dials.comfortable_blurr"))


def test_verify_knows_the_file_and_anonymise_keeps_it(study, tmp_path):
    assert not verify_study(study / "S").faults
    anonymise(study / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    assert not verify_study(tmp_path / "shared").faults
    (file, _) = sorted((tmp_path / "shared").rglob("dials.csv"))
    assert {row["participant"] for row in read_rows(file)} == {
        file.parents[1].name.removeprefix("sub-")
    }
    shutil.copytree(study / "S", tmp_path / "S")
    file = tmp_path / "S/sub-P01/ses-1/dials.csv"
    (file.parent / "checksums.sha256").unlink()
    cell(file, 3, "condition", "elsewhere")
    (told,) = (str(each) for each in verify_study(tmp_path / "S").faults)
    assert "condition is elsewhere" in told


DIAL = Adjustment(name="d", setting=ADJUSTABLE[0], range=(2.0, 32.0))


@pytest.mark.parametrize(
    ("dial", "place", "value"),
    [
        (DIAL, 0.0, 2.0),
        (DIAL, 0.5, 17.0),
        (DIAL, 1.0, 32.0),
        (DIAL.model_copy(update={"scale": "log"}), 0.5, 8.0),
        (DIAL.model_copy(update={"steps": 3}), 0.4, 12.0),
        (DIAL.model_copy(update={"steps": 3}), 0.6, 22.0),
        (DIAL.model_copy(update={"scale": "log", "steps": 4}), 0.3, 4.0),
    ],
)
def test_places_of_a_dial_are_values_of_its_setting(dial, place, value):
    assert dial.value_at(place) == pytest.approx(value)
    if dial.steps is None:
        assert dial.place_of(dial.value_at(place)) == pytest.approx(place)


SECOND = """
[[adjustments]]
name = "shutter"
setting = "motion_blur.shutter_fraction"
range = [0.1, 1.0]
"""
TASK = """
[[tasks]]
name = "shoot"
kind = "aiming"
"""


@pytest.mark.parametrize(
    ("change", "line", "says"),
    [
        ((SETTING, "depth_of_field.full_blur_diopter"), "setting", f"did you mean `{SETTING}`"),
        (
            ("comfortable_blur = 2.0", "comfortable_blur = 200.0"),
            "adjusts_to",
            "200 is not in the range of `comfortable_blur`, 0.5 to 8",
        ),
        ((SETTING, "nothing"), "setting", "no condition has a number `nothing`"),
        (
            (SETTING, "depth_of_field.samples"),
            "setting",
            "`depth_of_field.samples` decides what is built before an exposure, and cannot change",
        ),
        ((SETTING, "depth_of_field.pupil_mm"), "setting", 'it has law = "dioptre"'),
        ((SETTING, "vignette.open_deg"), "setting", "does nothing in any condition"),
        (("[0.5, 8.0]", "[8.0, 0.5]"), "range", "must be more than the first"),
        (("[0.5, 8.0]", "[0.0, 8.0]"), "range", "needs a range above 0"),
        (("[0.5, 8.0]", "[0.5, 8000.0]"), "range", "less than or equal to 1000"),
        (('"log"', '"log"\nconditions = ["lense"]'), "conditions", "did you mean `lens`"),
        (('"log"', '"log"\nconditions = ["plain"]'), "conditions", "it has no depth_of_field"),
        (("[0.5, 8.0]", '[3.0, 8.0]\nstart = "setting"'), "start", "`lens` has 2"),
        (("[simulation]", SECOND + "[simulation]"), "[[adjustments]]", "one dial for an exposure"),
        (
            ("[[adjustments]]", TASK + "[[adjustments]]", "scenes", 'task = "shoot"\nscenes'),
            "[[adjustments]]",
            "both take the same button",
        ),
        (("{ comfortable_blur", "{ comfy_blur"), "adjusts_to", "this study has no adjustment"),
    ],
)
def test_what_cannot_be_adjusted_is_refused_with_its_place(tmp_path, change, line, says):
    text = PROTOCOL
    for old, new in zip(change[::2], change[1::2], strict=True):
        assert old in text
        text = text.replace(old, new, 1)
    with pytest.raises(InputError) as refused:
        doing_protocol(tmp_path, text)
    assert says in str(refused.value)
    assert line in text.splitlines()[refused.value.line - 1]


def test_an_exposure_cannot_end_with_what_is_not_there(tmp_path):
    text = PROTOCOL.split("[[adjustments]]", maxsplit=1)[0]
    with pytest.raises(InputError, match="nothing is adjusted in any exposure"):
        doing_protocol(tmp_path, text.replace("scenes", 'exposure_ends = "adjustment"\nscenes'))


def test_conditions_may_be_named(tmp_path):
    text = PROTOCOL.replace('"log"', '"log"\nconditions = ["film"]')
    protocol = load_protocol(doing_protocol(tmp_path, text).file)
    assert protocol.adjustment_in("film").name == "comfortable_blur"
    assert protocol.adjustment_in("lens") is None


def test_run_refuses_a_headset_without_a_dial(tmp_path):
    file = doing_protocol(tmp_path, PROTOCOL).file
    words = ["run", str(file), "--participant", "P01", "--out", str(tmp_path / "S")]
    refused = CliRunner().invoke(app, words)
    said = "participants turn the dial `comfortable_blur`, and the playback headset has none"
    assert said in str(refused.exception or refused.output)
    assert not (tmp_path / "S").exists()
