"""Ratings over time and who left when: what a study of ratings says, and what it cannot say."""

import json
import re

import numpy as np
import pytest

from tests.support.rated import RatedStudy, with_drop_outs
from tests.support.report import manifest
from vrcomfort.errors import InputError
from vrcomfort.records.recording import FORMS
from vrcomfort.report.analyses.contract import SectionData
from vrcomfort.report.build import build_report
from vrcomfort.report.exclusions import PERSON, ExcludedByRule
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.rated_exposures import LiveClock, LiveTime, rated_exposures
from vrcomfort.report.ratings import analyse_time_courses
from vrcomfort.report.ratings.figures import course_figure, survival_figure
from vrcomfort.report.ratings.survival import TimeToEvent
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study
from vrcomfort.report.vocabulary import Vocabulary


def plan_of(**ratings):
    lines = [f"{key} = {json.dumps(value)}" for key, value in ratings.items()]
    return read_plan('name = "p"\ntitle = "p"\n[ratings]\n' + "\n".join(lines) + "\n", None)


def data_of(folder, *exclusions, **ratings):
    """Return the data of a report that compares nothing."""
    return SectionData(read_study(folder), plan_of(**ratings), [], {}, [], exclusions)


def analysed(folder, *exclusions, **ratings):
    data = data_of(folder, *exclusions, **ratings)
    return analyse_time_courses(data, data.plan.ratings)


def courses_of(study, folder, **ratings):
    return analysed(study.write(folder), **ratings)


def results_of(study, folder, **ratings):
    """Return the part of results.json."""
    return as_json(courses_of(study, folder, **ratings).results)


def two_conditions(*, people=6):
    study = RatedStudy()
    for person in range(people):
        for condition, more in (("a", 0), ("b", 3)):
            study.expose(f"P{person}", condition, [person % 3, more + person % 3, 2 * more + 1])
    return study


def test_nobody_left(tmp_path):
    found = results_of(two_conditions(), tmp_path, threshold=7)
    ratings = found["ratings"]
    assert found["leaving"] is None
    assert (ratings["exposures"], ratings["people"], ratings["missed"]) == (12, 6, 0)
    assert ratings["sensitivity"] == []
    (reached,) = ratings["reached"]
    assert (reached["n"], reached["came"]) == (12, 6)
    (model, _) = ratings["models"]
    assert model["terms"]["condition: b − a"]["estimate"] == pytest.approx(
        np.mean([max(3 + p % 3, 7) - max(p % 3, 1) for p in range(6)])
    )


def test_everybody_left_at_once(tmp_path):
    study = RatedStudy()
    for person in range(5):
        study.expose(f"P{person}", "a", [4, 9], ended_s=25.0 + (person == 4), status="withdrawn")
    found = results_of(study, tmp_path, threshold=15)
    leaving = found["leaving"]
    assert (leaving["n"], leaving["came"]) == (5, 5)
    (curve,) = leaving["curves"]
    assert curve["median_s"] == 25
    assert [each["time_s"] for each in curve["at"]] == [6.5, 13, 19.5, 26]
    assert curve["at"][-1]["survival"] == 0
    assert curve["at"][-1]["standard_error"] is None
    assert "one condition in one position" in leaving["cox"]["not_fitted"]
    ways = {way["analysis"]: way for way in found["ratings"]["reached"]}
    assert ways["all available"]["came"] == 0
    assert ways["worst case"]["came"] == 5
    assert "completers" not in ways


def test_those_who_left_change_the_result_as_assumed(tmp_path):
    study = RatedStudy()
    for person in range(4):
        study.expose(f"P{person}", "a", [1, 2, 3, person])
        gone = person < 2
        study.expose(f"P{person}", "b", [5, 6] if gone else [4, 4, 5, 6],
                     ended_s=25.0 if gone else None,
                     status="withdrawn" if gone else "completed")  # fmt: skip
    rows = results_of(study, tmp_path)["ratings"]["sensitivity"]
    found = {(row["summary"], row["analysis"]): row for row in rows}
    assert found["mean", "completers"]["n"] == 6
    assert found["mean", "all available"]["n"] == 8
    # planned 50 s, left at 25 s: half the time at 5.5, half at the last rating or the highest
    left, stayed, a = 5.5, 4.75, np.mean([1.5, 1.75, 2, 2.25])
    for way, half in (("all available", 5.5), ("carried forward", 6), ("worst case", 20)):
        mean = np.mean([(left + half) / 2, stayed])
        assert found["mean", way]["estimate"] == pytest.approx(mean - a), way
    assert found["peak", "worst case"]["estimate"] == pytest.approx(np.mean([20, 6]) - 3)


def test_the_stop_rule_counts_as_leaving_and_an_undone_withdrawal_does_not(tmp_path):
    study = RatedStudy().expose("P1", "a", [9], ended_s=12.0, status="stopped")
    study.expose("P2", "a", [3], ended_s=12.0, status="withdrawn").expose("P3", "a", [2, 2])
    folder = study.write(tmp_path)
    at = "2026-01-01T11:00:00+00:00"
    undone = {"trial": 1, "attempt": 1, "at": at, "reason": "slip"}
    text = manifest("P2", schema_version=2, withdrawals_undone=[undone])
    (folder / "manifest.json").write_text(text, "utf-8")
    exposures = rated_exposures(read_study(folder), "fms")
    assert [e.ending for e in exposures] == ["stop rule", "interrupted", "completed"]


def test_all_ratings_missed(tmp_path):
    study = RatedStudy().expose("P1", "a", [None, None]).expose("P2", "b", [None])
    courses = courses_of(study, tmp_path)
    ratings = as_json(courses.results)["ratings"]
    assert (ratings["missed"], ratings["without_answer"]) == (3, 2)
    assert ratings["curves"] == ratings["reached"] == []
    assert courses.curves is None
    assert {m["not_fitted"] is not None for m in ratings["models"]} == {True}


def test_one_rating_of_one_person(tmp_path):
    ratings = results_of(RatedStudy().expose("P1", "a", [4]), tmp_path)["ratings"]
    (row,) = ratings["curves"]
    assert (row["mean"], row["n"], row["low"]) == (4, 1, None)
    assert ratings["summaries"][0] == {
        "summary": "peak", "condition": "a", "n": 1, "people": 1, "mean": 4.0, "sd": None,
        "median": 4.0,
    }  # fmt: skip
    assert ratings["reached"][0]["came"] == 0


def test_one_condition_has_no_effects_and_its_curve_an_interval(tmp_path):
    study = RatedStudy()
    for person in range(6):
        study.expose(f"P{person}", "a", [1, 2, person]).expose(f"P{person}", "a", [0, 3, 4])
    ratings = results_of(study, tmp_path)["ratings"]
    assert ratings["models"][0]["not_fitted"] == "no effect has two levels in the data"
    assert ratings["curves"][-1]["low"] < ratings["curves"][-1]["mean"]
    assert [t["by"] for t in ratings["reached"][0]["log_rank"]] == ["position", "position"]


def test_no_ratings_and_no_trials_have_nothing(tmp_path):
    folder = two_conditions().write(tmp_path)
    (folder / "trials.csv").unlink()
    found = analysed(folder)
    assert found.leaving is None
    assert not found.ratings.counts.endings_recorded
    with pytest.raises(InputError, match="nothing was rated with `misc`; ratings are of: fms"):
        analysed(folder, instrument="misc")


def test_who_is_excluded_is_in_nothing(tmp_path):
    folder = two_conditions().write(tmp_path)
    people = (folder / "participants.csv").read_text("utf-8")
    (folder / "participants.csv").write_text(people.replace("P1,,completed", "P1,,excluded"))
    rule = ExcludedByRule("age", "P2", PERSON, "too old")
    assert analysed(folder, rule).ratings.counts.people == 4


def test_a_rating_that_is_no_number_is_told(tmp_path):
    folder = two_conditions().write(tmp_path)
    file = folder / "ratings.csv"
    file.write_text(file.read_text("utf-8").replace("2010.0", "soon", 1), "utf-8")
    with pytest.raises(InputError, match=r"ratings\.csv, line 2, column onset_s: 'soon' is not"):
        rated_exposures(read_study(folder), "fms")


@pytest.mark.parametrize("recorded", [False, True])
def test_time_that_stood_still_or_was_not_seen_does_not_count(tmp_path, recorded):
    """No frame came for 10 s; or they came, and the runtime wanted no picture of them."""
    study = RatedStudy().expose("P1", "a", [1, None, 3], ended_s=40.0, lost_s=10.0)
    folder = study.write(tmp_path)
    unplaced = rated_exposures(read_study(folder), "fms", clock=LiveClock(read_study(folder)))
    assert unplaced[0].unplaced
    assert unplaced[0].course.times_s.tolist() == [10, 20, 30]
    frames = [(t / 10, 1) for t in (*range(150), *range(250, 400))]  # not from 15 to 25 s
    frames += [(15.1 + t / 10, 0) for t in range(99)] if recorded else []
    columns = ("session_s", "trial", "period_ns", "should_render")
    others = [name for name in FORMS["frames.csv"].needed if name not in columns]
    blank = "," * len(others)
    rows = "".join(f"{2000 + t!r},1,100000000,{drawn}{blank}\n" for t, drawn in sorted(frames))
    (folder / "frames.csv").write_text(f"{','.join((*columns, *others))}\n{rows}", "utf-8")
    data = read_study(folder)
    (found,) = rated_exposures(data, "fms", clock=LiveClock(data))
    assert not found.unplaced
    np.testing.assert_allclose(found.course.times_s, [10, 15, 20], atol=1e-6)
    np.testing.assert_allclose(found.freezes, [(15, 10)], atol=1e-6)
    assert found.ended_s == 30


def test_live_time_of_even_frames_is_the_time():
    even = LiveTime.of(np.arange(10) / 10, np.full(10, 0.1), 1.0)
    assert even.freezes == ()
    assert [even.at(t) for t in (0.0, 0.55, 1.0)] == pytest.approx([0, 0.55, 1])


def words_of(*conditions):
    return Vocabulary.of((), {name: name for name in conditions}, [], (), None)


def test_below_a_curve_of_who_left_stand_the_exposures_at_risk():
    ends_s = {"a": [60.0, 120.0, 180.0, 240.0], "b": [150.0, 240.0]}
    events = [
        TimeToEvent(f"P{n}", condition, 1, end_s, came=(condition, n) not in {("a", 2), ("b", 1)})
        for condition, times_s in ends_s.items()
        for n, end_s in enumerate(times_s)
    ]
    drawing = survival_figure("leaving_curves", events, "share", words_of("a", "b"), 0.95)
    above, below = drawing.figure.axes
    minutes = [tick for tick in above.get_xticks() if 0 <= tick <= above.get_xlim()[1]]
    assert len(minutes) > 3
    assert [text.get_text() for text in below.texts] == [
        str(sum(end_s >= 60 * tick for end_s in times_s))
        for times_s in ends_s.values()
        for tick in minutes
    ]
    assert marks_in(above) == [[3.0], [4.0]]  # of those who were not seen to leave


def marks_in(axes):
    return [line.get_xdata().tolist() for line in axes.lines if line.get_marker() == "|"]


def test_several_conditions_have_a_panel_each_and_one_together(tmp_path):
    several = courses_of(two_conditions(people=2), tmp_path / "two")
    panels = course_figure(several, words_of("a", "b")).figure.axes
    assert [marks_in(panel) for panel in panels] == [[], [], []]
    one = courses_of(RatedStudy().expose("P1", "a", [4, None, 5]), tmp_path / "one")
    (panel,) = course_figure(one, words_of("a")).figure.axes
    assert marks_in(panel) == [[20.0]]  # where a rating was missed


PLAN = """
name = "mine"
title = "Ratings"
outcomes = ["ratings.mean"]
scores = "raw"
withdrawals = "available_pairs"
[ratings]
symptom_model = "fast_slow"
"""


def page_of(study, folder):
    there = study.write(folder / "study")
    (folder / "plan.toml").write_text(PLAN, "utf-8")
    made = build_report(there, plan=folder / "plan.toml", out=folder / "out", forms=("svg",))
    text = re.sub(r"<svg.*?</svg>", "", made.index.read_text("utf-8"), flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", text).split()), made


@pytest.mark.slow
def test_the_page_tells_of_drop_outs(tmp_path):
    text, made = page_of(with_drop_outs(), tmp_path)
    for words in (
        "Ratings during exposure", "Time to withdrawal", "robust SE", "carried forward",
        "worst case",
        "condition: blurred to sharp", "Model of symptom development", "Kaplan, E. L.",
        "the middle of the scale, as neither plan nor protocol names a threshold", "Lin, D. Y.",
    ):  # fmt: skip
        assert words in text, words
    drawn = {figure.name for figure in made.figures}
    assert {"ratings.svg", "survival_rating.svg", "survival_leaving.svg"} <= drawn
    assert {"rated_exposures.csv", "symptom_model.csv", "leaving_hazards.csv"} <= {
        table.name for table in made.tables
    }


EXTREMES = {
    "one rating": RatedStudy().expose("P1", "a", [4]),
    "all missed": RatedStudy().expose("P1", "a", [None]).expose("P2", "b", [None, None]),
    "all zero": RatedStudy().expose("P1", "a", [0, 0]).expose("P1", "b", [0, 0]),
    "left at once": RatedStudy().expose("P1", "a", [], ended_s=0.0, status="withdrawn")
    .expose("P2", "a", [3], ended_s=12.0, status="withdrawn"),
    "two": two_conditions(people=2),
}  # fmt: skip


def test_intervals_of_groups_are_not_called_within_participants(tmp_path):
    study = RatedStudy()
    for person in range(8):
        study.expose(f"P{person}", "ab"[person % 2], [person % 3, 2 + person % 3, person % 5])
    text, made = page_of(study, tmp_path)
    assert "ithin-participant" not in text
    assert "random intercept" not in text
    assert "no difference was shown between a and b; the mean difference was −0.25" in text
    assert "Linear model of these measures" in text
    found = json.loads(made.results.read_text("utf-8"))["ratings"]["curves"]
    assert any(point["low"] < point["mean"] < point["high"] for point in found)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXTREMES)
def test_a_page_of_very_little_is_made(tmp_path, name):
    text, _ = page_of(EXTREMES[name], tmp_path)
    assert "Ratings during exposure" in text
    assert not re.search(r"\b(nan|None(?! has)|inf)\b", text)
