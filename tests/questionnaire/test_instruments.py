"""Instruments: how a file says what is asked and scored, and the shipped ones."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from statistics import mean, stdev

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.places import ROOT
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import (
    find_instrument,
    guess,
    parse_instrument,
    read_sheets,
    score,
    score_file,
    shipped_instruments,
)
from vrcomfort.resources import data_folder

SHIPPED = shipped_instruments()

OWN = """\
name = "ours"
title = "Our questions"

[answers]
low = 1
high = 5

[[items]]
name = "calm"
text = "I felt calm"
reversed = true

[[items]]
name = "ill"
text = "I felt ill"

[[items]]
name = "tired"

[[scales]]
name = "bad"
title = "How bad"
made = "mean"
items = ["calm", "ill"]
"""


def own(*changes: tuple[str, str]) -> str:
    text = OWN
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def raw(name: str, answers: dict) -> dict[str, int | None]:
    return {n: s.raw if s else None for n, s in score(SHIPPED[name], answers).items()}


def points(name: str, answers: dict) -> dict[str, float | None]:
    return {n: s.points if s else None for n, s in score(SHIPPED[name], answers).items()}


def test_every_shipped_instrument_is_named_after_its_file_and_cites_its_source():
    for name, instrument in SHIPPED.items():
        assert instrument.name == name
        assert instrument.citation
        assert instrument.sources
        assert instrument.licence
        assert instrument.rule
        assert instrument.scale(instrument.primary) is not None


def test_scores_reach_the_ends_of_their_scales_and_no_further():
    for instrument in SHIPPED.values():
        asked = instrument.asked
        lowest = {i.name: i.answers.high if i.reversed else i.answers.low for i in asked}
        highest = {i.name: i.answers.low if i.reversed else i.answers.high for i in asked}
        for answers, end in ((lowest, "low"), (highest, "high")):
            found = score(instrument, answers)
            for name in instrument.needed:
                expected = float(getattr(instrument.scale(name), end))
                assert found[name].points == expected, (instrument.name, name)


def test_the_five_answers_are_another_instrument_which_is_never_guessed():
    four, five = SHIPPED["ssq"], SHIPPED["ssq_five_point"]
    assert [item.name for item in four.items] == [item.name for item in five.items]
    assert [s.unit for s in four.scales] == [s.unit for s in five.scales]
    answers = {item.name: 4 for item in five.items}
    assert score(five, answers)["T"].raw == 4 * 21
    with pytest.raises(InputError, match="answers are 0 to 3"):
        score(four, answers)
    assert guess([item.name for item in five.items], SHIPPED) is four


def test_vrsq_of_kim_et_al():
    """100 ΣO / 12, 100 ΣD / 15, and the mean of the two."""
    answers = dict.fromkeys([item.name for item in SHIPPED["vrsq"].items], 0)
    answers |= {"eyestrain": 2, "fatigue": 1, "vertigo": 3}
    assert raw("vrsq", answers) == {"O": 3, "D": 3, "T": 5 * 3 + 4 * 3}
    assert points("vrsq", answers) == {"O": 25.0, "D": 20.0, "T": 22.5}


def test_sus_of_the_example_of_brooke():
    """The filled form of Brooke (1996): contributions 4 1 1 4 1 2 1 1 4 3, SUS 55."""
    marks = [5, 4, 2, 1, 2, 3, 2, 4, 5, 2]
    answers = {f"sus_{number}": mark for number, mark in enumerate(marks, start=1)}
    assert raw("sus", answers) == {"usability": 22}
    assert points("sus", answers) == {"usability": 55.0}


TLX = {"mental_demand": 30, "physical_demand": 15, "temporal_demand": 60, "performance": 40,
       "effort": 40, "frustration": 30}  # fmt: skip
WEIGHTS = {"weight_mental_demand": 3, "weight_physical_demand": 0, "weight_temporal_demand": 5,
           "weight_performance": 1, "weight_effort": 3, "weight_frustration": 3}  # fmt: skip


def test_tlx_is_the_mean_and_with_weights_the_sum_of_products_over_fifteen():
    without = points("nasa_tlx", TLX)
    assert without["raw_tlx"] == pytest.approx(215 / 6, abs=1e-12)
    assert without["weighted_tlx"] is None
    found = points("nasa_tlx", TLX | WEIGHTS)
    assert found["weighted_tlx"] == pytest.approx((90 + 0 + 300 + 40 + 120 + 90) / 15, abs=1e-12)
    assert found["raw_tlx"] == without["raw_tlx"]
    assert found["TD"] == 60


@pytest.mark.parametrize(
    ("change", "says"),
    [({"weight_effort": 4}, "add up to 16, not 15"), ({"weight_effort": None}, "only 5 of the 6")],
)
def test_weights_that_are_not_those_of_fifteen_comparisons(change, says):
    with pytest.raises(InputError, match=says):
        score(SHIPPED["nasa_tlx"], TLX | WEIGHTS | change)


def test_csq_vr_is_sums_of_pairs():
    names = [item.name for item in SHIPPED["csq_vr"].items]
    answers = dict(zip(names, [1, 2, 3, 4, 5, 6], strict=True))
    assert points("csq_vr", answers) == {"N": 3.0, "V": 7.0, "O": 11.0, "T": 21.0}


@given(st.lists(st.integers(0, 3), min_size=9, max_size=9))
@settings(max_examples=30)
def test_raw_numbers_are_the_exact_scores(marks):
    vrsq = SHIPPED["vrsq"]
    answers = dict(zip([item.name for item in vrsq.items], marks, strict=True))
    found = score(vrsq, answers)
    ocular, disorient = Fraction(100 * sum(marks[:4]), 12), Fraction(100 * sum(marks[4:]), 15)
    assert found["T"].raw * vrsq.scale("T").unit == (ocular + disorient) / 2


def test_words_in_several_languages_find_items_and_answers():
    ssq = SHIPPED["ssq"]
    assert ssq.item("Übelkeit").name == ssq.item("NAUSÉE").name == "nausea"
    assert ssq.item("Übelkeit", language="de").name == "nausea"
    assert ssq.item("Übelkeit", language="fr") is None
    assert ssq.item("eyestrain", language="de").name == "eyestrain"
    assert ssq.answers.words["none"] == ssq.answers.words["gar nicht"] == 0
    assert ssq.answers.words["severe"] == 3
    assert ssq.lacks("en") == ssq.lacks("de") == []


def test_an_own_instrument_is_scored_with_its_reversed_item_and_what_stands_alone():
    ours = parse_instrument(OWN)
    found = score(ours, {"calm": 5, "ill": 2, "tired": 4})
    assert found["bad"].points == (1 + 2) / 2
    assert found["tired"].points == 4
    assert ours.scale("tired").alone
    assert not ours.scale("bad").alone
    assert score(ours, {"calm": 5, "tired": 4})["bad"] is None


def test_percent_of_a_scale_goes_from_its_lowest_answers_to_its_highest():
    ours = parse_instrument(own(('made = "mean"', 'made = "percent"')))
    for calm, ill, percent in ((5, 1, 0), (3, 3, 50), (2, 2, 50), (1, 5, 100)):
        assert score(ours, {"calm": calm, "ill": ill})["bad"].points == percent


def test_with_min_valid_the_mean_of_the_others_stands_for_what_is_missing():
    ours = parse_instrument(own(('items = ["calm"', 'min_valid = 1\nitems = ["calm"')))
    whole = score(ours, {"calm": 4, "ill": 3})["bad"]
    part = score(ours, {"calm": 4})["bad"]
    assert whole.points == 2.5
    assert part.points == 2
    assert isinstance(part.raw, int)
    assert whole.raw * ours.scale("bad").unit == Fraction(5, 2)
    assert score(ours, {"tired": 1})["bad"] is None


def test_answers_in_decimal_steps_are_exact():
    ours = parse_instrument(own(("low = 1\nhigh = 5", "low = 0\nhigh = 1\nstep = 0.1")))
    assert score(ours, {"calm": 0.7, "ill": 0.1})["bad"].raw == 4
    assert [str(tenths / 10) for tenths in range(1, 10)] == [*ours.items[0].answers.plain][1:-1]
    with pytest.raises(InputError, match=r"0 to 1 in steps of 0\.1"):
        score(ours, {"calm": 0.75, "ill": 0})


@pytest.mark.parametrize(
    ("old", "new", "line", "says"),
    [
        ('name = "ours"', 'name = "Ours"', 1, "`name`: must start with a small letter"),
        ('title = "Our questions"\n', "", 1, "`title` is missing; add it"),
        ("high = 5", "hihg = 5", 6, "unknown key `hihg`; did you mean `high`"),
        ("high = 5", "high = 1", 6, "the lowest answer, 1, is not below the highest, 1"),
        ("high = 5", "high = 5\nstep = 3", 7, "steps of 3 do not lead from 1 to 5"),
        ("high = 5", 'high = 5\nlabels = ["a", "b", "c"]', 7, "3 labels for 5 answers"),
        ("high = 5", "high = 5\nasked_step = 0.5", 7, "the form's answers are not all possible"),
        ('name = "ill"', 'name = "calm"', 13, "`calm` is there twice"),
        ('name = "ill"', 'name = "condition"', 14, "cannot be called `condition`"),
        ('"I felt ill"', '"I felt calm"', 13, "`I felt calm` means item calm and item ill"),
        ('"calm", "ill"]', '"calm", "il"]', 24, "there is no item `il`; did you mean `ill`"),
        ('"calm", "ill"]', '"ill", "ill"]', 24, "to count it twice write ill = 2"),
        ('items = ["calm", "ill"]', "", 20, "this has none: give one"),
        ('name = "bad"', 'name = "ill"', 21, "a scale has the name of the item `ill`"),
        ('made = "mean"', 'made = "median"', 23, "should be 'sum', 'mean' or 'percent'"),
        ('made = "mean"', "min_valid = 3", 23, "more than the 2 items of the scale"),
        ('made = "mean"', 'weighted_by = { calm = "tired" }', 23, "name each item of the scale"),
        ('title = "Our questions"', 'title = "x"\nprimary = "good"', 3, "there is no scale `good`"),
        ("[[scales]]", '[translations.de]\nlabel = ["a"]\n[[scales]]', 21, "did you mean `labels`"),
        ("[[scales]]", '[translations.de]\nitems = {ill = 1}\n[[scales]]', 21, "`ill`: should be"),
        ("low = 1", 'low = "1"', 5, "`low`: should be a number, got '1'"),
        ("[[scales]]", '[translations.de.items]\nil = "krank"\n[[scales]]', 21, "mean `ill`?"),
    ],
)  # fmt: skip
def test_every_fault_of_a_file_is_told_with_its_place(old, new, line, says):
    with pytest.raises(InputError) as caught:
        parse_instrument(own((old, new)), Path("mine.toml"))
    assert says in caught.value.message
    assert caught.value.line == line
    assert caught.value.file == Path("mine.toml")


def test_an_instrument_is_found_by_name_by_file_and_beside_a_protocol(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(OWN, encoding="utf-8")
    assert find_instrument("vrsq") is SHIPPED["vrsq"]
    assert find_instrument(file).name == "ours"
    assert find_instrument("mine.toml", beside=tmp_path).name == "ours"
    with pytest.raises(InputError, match="there is no instrument `vsrq`; did you mean `vrsq`"):
        find_instrument("vsrq")
    with pytest.raises(InputError, match="no such instrument file"):
        find_instrument("none.toml")
    file.write_text(own(('name = "ours"', 'name = "ssq"')), encoding="utf-8")
    with pytest.raises(InputError, match="`ssq` is a shipped instrument; give this one another"):
        find_instrument(file)


def test_files_of_weights_and_without_are_scored(tmp_path):
    file = tmp_path / "tlx.csv"
    cells = ",".join(map(str, TLX.values()))
    file.write_text(f"who,{','.join(TLX)}\nA,{cells}\n", encoding="utf-8")
    (row,) = score_file(file, SHIPPED["nasa_tlx"]).rows
    assert row["who"] == "A"
    assert row["raw_tlx"] == pytest.approx(35.8333, abs=1e-4)
    assert "weighted_tlx" not in row
    weights = ",".join(map(str, WEIGHTS.values()))
    text = f"who,{','.join([*TLX, *WEIGHTS])}\nA,{cells},{weights}\n"
    file.write_text(text, encoding="utf-8")
    (row,) = score_file(file, SHIPPED["nasa_tlx"]).rows
    assert row["weighted_tlx"] == pytest.approx(42.6667, abs=1e-4)
    file.write_text(text.replace(f"{weights}\n", "5,5,5,5,5,5\n"), encoding="utf-8")
    with pytest.raises(InputError, match="the weights add up to 30, not 15") as caught:
        score_file(file, SHIPPED["nasa_tlx"])
    assert caught.value.line == 2


def test_the_answers_of_thirty_people_in_words():
    """Real answers (tests/data/README.md), with the means that their publication comes to."""
    vrsq = SHIPPED["vrsq"]
    table = CsvTable.read(ROOT / "tests" / "data" / "vrsq" / "answers.csv")
    found = []
    for row in table.dicts():
        said = {vrsq.item(heading): word for heading, word in row.items() if vrsq.item(heading)}
        assert len(said) == 9
        answers = {item.name: vrsq.answers.words[word.lower()] for item, word in said.items()}
        found.append(score(vrsq, answers))
    assert len(found) == 30
    scores = {name: [each[name].points for each in found] for name in "ODT"}
    assert mean(scores["O"]) == pytest.approx(15.5556, abs=1e-4)
    assert mean(scores["D"]) == pytest.approx(7.1111, abs=1e-4)
    assert mean(scores["T"]) == pytest.approx(11.3333, abs=1e-4)
    assert stdev(scores["T"]) == pytest.approx(9.9221, abs=1e-4)


def test_no_shipped_file_is_left_out():
    assert {file.stem for file in data_folder("instruments").glob("*.toml")} == set(SHIPPED)
    assert len(SHIPPED) == 17


def test_instruments_can_be_looked_up_by():
    shipped = shipped_instruments()
    assert {instrument: name for name, instrument in shipped.items()} == {
        instrument: instrument.name for instrument in shipped.values()
    }


def test_the_printed_form_of_18_questions_scores_14():
    form = SHIPPED["ssq_18"]
    worst = {item.name: 4 for item in form.items}
    found = {name: each.points for name, each in score(form, worst).items()}
    assert len(worst) == 18
    assert [found[name] for name in "NODT"] == pytest.approx([228.96, 212.24, 334.08, 284.24])
    for item in ("anxiety", "drowsiness", "loss_of_appetite", "desire_to_move_bowels"):
        alone = score(form, {**dict.fromkeys(worst, 0), item: 4})
        assert [alone[name].points for name in "NODT"] == [0, 0, 0, 0]


def test_an_answer_is_the_same_number_however_it_is_written(tmp_path):
    file = tmp_path / "answers.csv"
    file.write_text("item,response\ncalm,02.50\nill,03.0\n", "utf-8")
    (sheet,) = read_sheets(file, parse_instrument(own(("high = 5", "high = 5\nstep = 0.5"))))
    assert sheet.answers == {"calm": 2.5, "ill": 3}
    assert isinstance(sheet.answers["ill"], int)
