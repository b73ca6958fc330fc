from __future__ import annotations

import csv
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import never_zero, read_sheets, score, score_file, shipped_instruments

SSQ = shipped_instruments()["ssq"]

NAMES = [item.name for item in SSQ.items]
HEADINGS = [
    "General discomfort",
    "Fatigue",
    "Headache",
    "Eye strain",
    "Difficulty focusing",
    "Salivation increasing",
    "Sweating",
    "Nausea",
    "Difficulty concentrating",
    "Fullness of the head",
    "Blurred vision",
    "Dizziness with eyes open",
    "Dizziness with eyes closed",
    "Vertigo",
    "Stomach awareness",
    "Burping",
]
ANSWERS = st.fixed_dictionaries({name: st.integers(0, 3) for name in NAMES})


def wide(
    folder: Path, *rows: str, headings: list[str] = HEADINGS, start: str = "\ufeffNo."
) -> Path:
    file = folder / "answers.csv"
    file.write_text("\n".join([",".join([start, *headings]), *rows]), encoding="utf-8")
    return file


LOADINGS = {scale.name: {term.item: term.slope for term in scale.terms} for scale in SSQ.scales[:3]}
"""Subscale → item → how often it counts."""


def score_ssq(file):
    return score_file(file, SSQ).rows


@pytest.mark.smoke
def test_the_published_loadings_and_maxima():
    assert [scale.name for scale in SSQ.scales] == ["N", "O", "D", "T"]
    assert [len(loads) for loads in LOADINGS.values()] == [7, 7, 7]
    assert {item for loads in LOADINGS.values() for item in loads} == set(NAMES)
    worst = score(SSQ, dict.fromkeys(NAMES, 3))
    found = {name: each.points for name, each in worst.items()}
    assert found == {"N": 200.34, "O": 159.18, "D": 292.32, "T": 235.62}
    assert {scale.name: float(scale.high) for scale in SSQ.scales} == found


def test_scores_are_the_decimals_that_they_are():
    weights = {"N": "9.54", "O": "7.58", "D": "13.92", "T": "3.74"}
    for raw in range(190):
        for scale in SSQ.scales:
            assert Decimal(repr(scale.points(raw))) == raw * Decimal(weights[scale.name])


def test_each_item_counts_where_kennedy_says():
    answers = dict.fromkeys(NAMES, 0) | {"nausea": 2, "eyestrain": 1}
    found = score(SSQ, answers)
    assert [found[name].raw for name in "NODT"] == [2, 1, 2, 5]


@given(ANSWERS, st.randoms())
@settings(max_examples=30)
def test_the_order_of_answers_does_not_matter(answers, random):
    items = list(answers.items())
    random.shuffle(items)
    assert score(SSQ, dict(items)) == score(SSQ, answers)


@given(ANSWERS, st.sampled_from(NAMES))
@settings(max_examples=40)
def test_scores_are_bounded_and_grow_with_every_answer(answers, item):
    low, high = score(SSQ, answers | {item: 0}), score(SSQ, answers | {item: 3})
    assert 0 <= low["T"].points < high["T"].points <= 235.62
    loads = sum(item in each for each in LOADINGS.values())
    assert high["T"].raw - low["T"].raw == 3 * loads


def test_an_incomplete_questionnaire_has_no_score():
    whole = dict.fromkeys(NAMES, 1)
    found = score(SSQ, whole | {"burping": None})
    assert found["N"] is None
    assert found["T"] is None
    assert found["O"].raw == 7
    assert score(SSQ, {name: 1 for name in NAMES if name != "burping"}) == found


@pytest.mark.parametrize(("item", "answer"), [("nausea", 4), ("nausea", -2), ("anxiety", 1)])
def test_a_wrong_answer_is_refused(item, answer):
    with pytest.raises(InputError, match=item):
        score(SSQ, dict.fromkeys(NAMES, 1) | {item: answer})


def test_wide_files_are_read_by_heading_in_any_order(tmp_path):
    headings = [heading.upper() + " " for heading in reversed(HEADINGS)]
    file = wide(tmp_path, "P1,3" + ",0" * 15, headings=headings)
    (row,) = score_ssq(file)
    assert row["No."] == "P1"
    assert (row["nausea_raw"], row["total_raw"], row["total"]) == (3, 3, 3.74 * 3)


def test_every_item_name_and_every_text_is_a_heading():
    for instrument in shipped_instruments().values():
        for item in instrument.items:
            assert instrument.item(item.name) is item
            assert instrument.item(f" {item.text.upper()} ") is item


@pytest.mark.parametrize(
    ("rows", "line", "column", "says"),
    [
        (["P1" + ",0" * 16, "P2,4" + ",0" * 15], 3, "General discomfort", "out of range"),
        (["P1,0,-2" + ",0" * 14], 2, "Fatigue", "out of range"),
        (["P1,0,1.5" + ",0" * 14], 2, "Fatigue", "not a whole number"),
        (["P1,0,None" + ",0" * 14], 2, "Fatigue", "not a whole number"),
        (["P1,0,inf" + ",0" * 14], 2, "Fatigue", "not a whole number"),
        (["P1,0," + ",0" * 14], 2, "Fatigue", "missing"),
        (["P1,0" + ",0" * 14], 2, None, "16 cells, the header has 17"),
    ],
)
def test_a_wrong_cell_is_told_with_its_place(tmp_path, rows, line, column, says):
    with pytest.raises(InputError, match=says) as caught:
        score_ssq(wide(tmp_path, *rows))
    assert (caught.value.line, caught.value.column) == (line, column)


def test_a_missing_column_is_named_with_what_may_be_meant(tmp_path):
    headings = ["Vertigoo" if heading == "Vertigo" else heading for heading in HEADINGS]
    with pytest.raises(InputError, match="item vertigo; is it `Vertigoo`"):
        score_ssq(wide(tmp_path, "P1" + ",0" * 16, headings=headings))


def test_a_column_that_is_there_twice(tmp_path):
    with pytest.raises(InputError, match="second column for `nausea`"):
        score_ssq(wide(tmp_path, "0,P1" + ",0" * 15, start="nausea"))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        score_ssq(tmp_path / "none.csv")
    (tmp_path / "empty.csv").touch()
    with pytest.raises(InputError, match="this file is empty"):
        score_ssq(tmp_path / "empty.csv")


def long_file(folder: Path, rows: list[tuple[str, str, str, str]]) -> Path:
    file = folder / "questionnaires.csv"
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["participant", "timepoint", "instrument", "item", "response"])
        writer.writerows([who, when, "ssq", item, answer] for who, when, item, answer in rows)
    return file


def test_long_files_are_grouped_and_incomplete_ones_score_blank(tmp_path):
    rows = [("P1", when, name, "1") for when in ("baseline", "post") for name in NAMES]
    rows[20] = ("P1", "post", NAMES[4], "")
    baseline, post = score_ssq(long_file(tmp_path, rows))
    assert (baseline["timepoint"], baseline["total_raw"]) == ("baseline", 21)
    assert (post["timepoint"], post["total_raw"], post["total"]) == ("post", None, None)


@pytest.mark.parametrize(
    ("row", "column", "says"),
    [
        (("P1", "post", "nausae", "1"), "item", "did you mean `nausea`"),
        (("P1", "post", "nausea", "7"), "response", "out of range"),
        (("P1", "baseline", "nausea", "1"), "item", "answered twice"),
    ],
)
def test_a_wrong_row_of_a_long_file(tmp_path, row, column, says):
    rows = [("P1", "baseline", "nausea", "1"), row]
    with pytest.raises(InputError, match=says) as caught:
        read_sheets(long_file(tmp_path, rows), SSQ)
    assert (caught.value.line, caught.value.column) == (3, column)


def test_what_was_asked_otherwise_is_no_candidate(tmp_path):
    for other in ("comfort", "FMS nausea", "general_discomfort_rt", "nausea time"):
        file = wide(tmp_path, "P1" + ",0" * 16 + ",1", headings=[*HEADINGS, other])
        assert len(score_ssq(file)) == 1, other


def test_two_headings_for_one_item_are_both_named(tmp_path):
    others = ("8. Nausea", "ssq_nausea", "SsqNausea8", "Nausea (item)", "Nausae")
    for own in (*others, "Feeling of nausea"):
        headings = [own if heading == "Nausea" else heading for heading in HEADINGS]
        with pytest.raises(InputError) as caught:
            score_ssq(wide(tmp_path, "P1" + ",0" * 16 + ",1", headings=[*headings, "Nausea"]))
        assert caught.value.message.startswith(f"`Nausea` and `{own}` may both be item nausea")


def test_other_columns_are_no_second_heading(tmp_path):
    sums = ("Nausea sum", "nausea_raw", "NauseaScore", "Total score")
    for other in (*sums, "Sickness", "Age", "Vert"):
        file = wide(tmp_path, "P1" + ",1" * 16 + ",7", headings=[*HEADINGS, other])
        assert score_ssq(file)[0]["total_raw"] == 21, other


def coded_from_one(folder: Path) -> Path:
    rows = [f"P{n}" + ",1" * (16 - n) + ",3" * n for n in range(4)]
    return wide(folder, *rows)


def test_answers_of_which_none_is_0_are_asked_about(tmp_path):
    file = coded_from_one(tmp_path)
    with pytest.raises(InputError, match=r"none of 64 answers is 0: are they 1 to 4.*--coded-from"):
        score_file(file, SSQ)
    one, zero = (score_file(file, SSQ, coded_from=n).rows for n in (1, 0))
    assert [row["total_raw"] for row in one] == [0, 2, 4, 6]
    assert [row["total_raw"] for row in zero] == [21, 23, 25, 27]


def test_few_answers_without_a_0_are_taken_as_they_are(tmp_path):
    assert score_ssq(wide(tmp_path, "P1" + ",1" * 16))[0]["total_raw"] == 21


def test_a_sum_in_the_column_of_an_item_is_found(tmp_path):
    headings = ["Feeling unwell" if heading == "Nausea" else heading for heading in HEADINGS]
    subscale = [NAMES.index(item) for item in LOADINGS["N"]]
    rows = []
    for n in range(6):
        answers = [0] * 16
        answers[subscale[n % 7]] = n % 3
        answers[3] = 1
        rows.append(",".join(map(str, [f"P{n}", *answers, sum(answers[i] for i in subscale)])))
    file = wide(tmp_path, *rows, headings=[*headings, "Nausea"])
    with pytest.raises(InputError, match="sum of Nausea, with `Feeling unwell` as nausea") as found:
        score_ssq(file)
    assert found.value.column == "Nausea"
    file = wide(tmp_path, *rows, headings=[*HEADINGS, "Nausea sum"])
    assert len(score_ssq(file)) == 6
    file = wide(tmp_path, "P1" + ",0" * 17, "P2" + ",0" * 17, headings=[*headings, "Nausea"])
    assert len(score_ssq(file)) == 2, "of zeros alone nobody knows"


def test_two_whole_ssqs_without_a_zero_are_asked_about():
    assert [never_zero(SSQ, {1: 16, 2: count}) for count in (15, 16)] == [0, 32]
    assert never_zero(SSQ, {0: 1, 1: 40}) == 0
