"""Outcomes that are no scores: ratings, trials, tasks, participants and frames, in any plan."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from tests.support.report import HEAD, WITHOUT_MODELS, Study, planned_report, write_csv
from vrcomfort.errors import InputError
from vrcomfort.records import RatingRow
from vrcomfort.report.exposures import Exposures
from vrcomfort.report.measures import (
    Measure,
    MeasuredValue,
    MeasureSettings,
    fault_of,
    measure_of,
    values_of,
)
from vrcomfort.report.measures.model import in_steps
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.rated_exposures import rated_exposures
from vrcomfort.report.results import analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study, with_frames
from vrcomfort.stats.rating_courses import RatingCourse

PEOPLE = tuple(f"P{i:02d}" for i in range(1, 9))
COURSES = {"off": (1, 3, None, 8), "on": (0, 1, None, 2)}
"""Ratings of an exposure, one every 20 s; None: missed."""


def rated(folder: Path, *, left_early: str = "") -> Path:
    """Eight people, two conditions, four ratings in each exposure; no questionnaire."""
    study = Study(folder)
    study.describe("rated", off="No blur", on="Blur")
    for place, name in enumerate(PEOPLE):
        order = ("off", "on") if place % 2 else ("on", "off")
        status = "withdrawn" if name == left_early else "completed"
        exposures = [(each, "room", None) for each in order]
        session = study.session(name, 1, None, exposures, status=status)
        (session / "questionnaires.csv").unlink()
        rows = [
            {"participant": name, "session": 1, "trial": trial, "condition": condition,
             "onset_s": 100.0 * trial + 20 * k, "instrument": "fms",
             "response": "" if answer is None else answer + place % 3,
             "missed": int(answer is None)}
            for trial, condition in enumerate(order, start=1)
            for k, answer in enumerate(COURSES[condition])
        ]  # fmt: skip
        write_csv(session / "ratings.csv", RatingRow.columns(), rows)
        study.person(name, "a")
    return folder


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study of `rated`, which no test changes."""
    return rated(tmp_path_factory.mktemp("rated") / "study")


@pytest.fixture(scope="module")
def left_early(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, in which P04 leaves the second exposure, on, after 40 s."""
    return rated(tmp_path_factory.mktemp("left") / "study", left_early="P04")


def course_of(study: Path, who: str) -> RatingCourse:
    """Return the ratings of somebody's second exposure."""
    exposures = rated_exposures(read_study(study), "fms")
    return next(each.course for each in exposures if each.key[:3] == (who, "1", "2"))


def of(study: Path, name: str, **said: object) -> dict[tuple[str, str], Fraction | None]:
    """Return (participant, condition) → value."""
    own = MeasureSettings(name="m", measure=name, **said) if said else None
    measure = measure_of("m", own) if own else measure_of(name)
    found = values_of(with_frames(read_study(study)), measure)
    return {(value.participant, value.condition): value.number for value in found}


def scored_by(study: Path, *lines: str) -> tuple[dict, Exposures]:
    """Return the results, without a page, and the scores."""
    plan = read_plan(HEAD + WITHOUT_MODELS + "\n".join(lines) + "\n", None)
    results, scored = analyse(read_study(study), plan)
    return as_json(results), scored


def test_ratings_are_summed_up_over_those_that_were_answered(study: Path) -> None:
    assert of(study, "ratings.peak")["P01", "off"] == 8
    assert of(study, "ratings.mean")["P01", "off"] == 4
    assert of(study, "ratings.last")["P01", "on"] == 2
    # 20 s at a mean of 2 and, the missed one bridged, 40 s at a mean of 5.5
    assert of(study, "ratings.area")["P01", "off"] == 40 + 220
    assert of(study, "ratings.time_to", threshold=3)["P01", "off"] == 20


def test_slope_is_that_of_least_squares_per_minute(study: Path) -> None:
    course = course_of(study, "P01").answered
    assert course.times_s.tolist() == [0, 20, 60]
    at, ratings = course.times_s / 60, course.ratings
    expected = ((at - at.mean()) * (ratings - ratings.mean())).sum() / ((at - at.mean()) ** 2).sum()
    slope = of(study, "ratings.slope")["P01", "off"]
    assert float(slope) == pytest.approx(expected, rel=1e-8)


def test_who_finished_below_a_threshold_ties_at_the_longest_and_who_left_has_none(
    left_early: Path,
) -> None:
    reached = of(left_early, "ratings.time_to", threshold=6)
    assert reached["P01", "on"] == 90
    assert reached["P04", "on"] is None
    assert reached["P04", "off"] == 60


def test_ratings_after_the_end_of_the_last_attempt_do_not_count(left_early: Path) -> None:
    assert course_of(left_early, "P04").answered.times_s.tolist() == [0, 20]


def test_ratings_without_numbers_of_exposures_are_told_apart_by_condition(tmp_path: Path) -> None:
    """As the time courses of the same ratings tell them apart."""
    study = rated(tmp_path / "study")
    for session in study.glob("sub-*/ses-1"):
        (session / "trials.csv").unlink()
        header, *lines = (session / "ratings.csv").read_text("utf-8").splitlines()
        place = header.split(",").index("trial")
        rows = [line.split(",") for line in lines]
        rows = [[*row[:place], "", *row[place + 1 :]] for row in rows]
        text = "\n".join([header, *map(",".join, rows), ""])
        (session / "ratings.csv").write_text(text, "utf-8")
    peaks = of(study, "ratings.peak")
    assert (peaks["P01", "off"], peaks["P01", "on"]) == (8, 2)


def test_an_exposure_with_no_answered_rating_is_left_out_with_its_reason(tmp_path: Path) -> None:
    study = rated(tmp_path / "study")
    file = study / "sub-P01" / "ses-1" / "ratings.csv"
    rows = [line for line in file.read_text().splitlines() if ",on," not in line]
    file.write_text("\n".join(rows) + "\n")
    results, _ = scored_by(study, 'outcomes = ["ratings.peak"]')
    assert results["tests"][0]["n"] == 7
    (row,) = results["quality"]["excluded_questionnaires"]
    assert (row["participant"], row["reason"]) == ("P01", "nothing was rated")


def test_a_plan_compares_conditions_on_ratings_and_trials_without_any_questionnaire(
    tmp_path: Path, study: Path
) -> None:
    lines = (
        'outcomes = ["fast", "trials.length_s", "trials.dropped_percent"]\n'
        '[[measures]]\nname = "fast"\nmeasure = "ratings.peak"\nlabel = "Worst sickness"\n'
        'unit = "FMS"\nbetter = "lower"\n[[contrasts]]\na = "off"\nb = "on"\n'
    )
    built = planned_report(study, out=tmp_path / "out", lines=WITHOUT_MODELS + lines)
    first, second, third = json.loads(built.results.read_text())["tests"]
    assert (first["n"], first["shift"]["estimate"], first["p"]) == (8, 6.0, 0.0078125)
    assert (second["shift"]["estimate"], third["p"]) == (0, 1)
    page = built.index.read_text()
    assert "Worst sickness: higher under No blur" in page
    assert "difference was 6.00 FMS" in page
    assert "lower is better" in page


def test_tasks_are_averaged_over_the_rows_of_an_exposure_and_compared(tmp_path: Path) -> None:
    rows = [
        {"participant": name, "condition": condition, "time_s": f"{base + 0.1 * place + shot:.2f}"}
        for place, name in enumerate(PEOPLE)
        for condition, base in (("off", 2), ("on", 1.5))
        for shot in (0, 1)
    ]
    write_csv(tmp_path / "study" / "tasks.csv", ("participant", "condition", "time_s"), rows)
    assert of(tmp_path / "study", "tasks.time_s")["P02", "on"] == Fraction("2.1")
    results, _ = scored_by(tmp_path / "study", 'outcomes = ["tasks.time_s"]')
    (test,) = results["tests"]
    assert test["n"] == 8
    assert test["shift"]["estimate"] == pytest.approx(0.5)
    assert test["ties"] == 8  # 2.1 − 1.6 and 2.2 − 1.7 are alike, though not in floating point


def test_a_task_measure_stands_in_the_row_of_its_exposures_questionnaire(tmp_path: Path) -> None:
    study = Study(tmp_path / "study")
    for place, name in enumerate(PEOPLE):
        study.session(name, 1, 0, [("off", "room", 3 + place), ("on", "room", place)])
        study.person(name, "a")
    rows = [{"participant": n, "session": 1, "trial": t, "hits": t} for n in PEOPLE for t in (1, 2)]
    write_csv(study.folder / "tasks.csv", ("participant", "session", "trial", "hits"), rows)
    _, scored = scored_by(study.folder, 'outcomes = ["T", "tasks.hits"]')
    assert scored.table[["T", "tasks.hits"]].notna().to_numpy().all()
    assert len(scored.table) == 2 * len(PEOPLE)


def test_a_column_of_participants_has_one_value_per_person(tmp_path: Path) -> None:
    study = rated(tmp_path / "study")
    rows = [{"participant": n, "status": "completed", "age": 20 + i} for i, n in enumerate(PEOPLE)]
    write_csv(study / "participants.csv", ("participant", "status", "age"), rows)
    assert of(study, "participants.age")["P03", ""] == 22


def test_frames_give_path_turning_and_focus_changes_of_the_last_attempt(tmp_path: Path) -> None:
    study = rated(tmp_path / "study")
    header = ("session_s", "trial", "discontinuity", "head_x_m", "head_y_m", "head_z_m",
              "head_qx", "head_qy", "head_qz", "head_qw", "focus_m", "xr_time_ns", "period_ns",
              "dropped")  # fmt: skip
    turn = 2**-0.5
    frames = [
        (50.0, 1, 1, 9, 9, 9, 0, 0, 0, 1, 1),  # of an earlier attempt
        (100.0, 1, 1, 0, 0, 0, 0, 0, 0, 1, 1),
        (100.1, 1, 0, 3, 4, 0, 0, turn, 0, turn, 2),
        (100.2, 1, 1, 0, 0, 0, 0, 0, 0, 1, 4),  # jumped
        (100.3, 1, 0, 0, 0, 1, 0, 0, 0, -1, ""),
        (200.0, 2, 0, 7, 7, 7, 0, 0, 0, 1, 1),
    ]
    rows = [
        dict(zip(header, (*frame, round(frame[0] * 1e9), 10**8, 0), strict=True))
        for frame in frames
    ]
    write_csv(study / "sub-P01" / "ses-1" / "frames.csv", header, rows)
    assert float(of(study, "frames.head_path_m")["P01", "on"]) == pytest.approx(6)
    assert float(of(study, "frames.head_turning_deg")["P01", "on"]) == pytest.approx(90)
    assert float(of(study, "frames.focus_travel_dioptre")["P01", "on"]) == pytest.approx(0.5)
    assert of(study, "frames.head_path_m")["P01", "off"] is None


def test_values_that_differ_by_rounding_alone_are_tied() -> None:
    numbers = [Fraction(0.1 + 0.2), Fraction(0.3), Fraction("0.3000001")]
    values = [MeasuredValue("P", "", "", "", number) for number in numbers]
    one, two, three = (value.number for value in in_steps(values))
    assert one == two != three


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("rating.peak", "measures are called ratings.…"),
        ("ratings.peek", "did you mean `ratings.peak`?"),
        ("frames.", "is no measure"),
    ],
)
def test_a_name_that_is_no_measure_is_told_with_the_nearest(name: str, said: str) -> None:
    assert said in str(fault_of(name))


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ('outcomes = ["ratings.time_to"]', "needs a threshold"),
        ('outcomes = ["tasks.time_s"]', "needs tasks.csv, which the study does not have"),
        ('outcomes = ["trials.lenght"]', "trials.csv has no column `lenght`"),
        ('outcomes = ["participants.status"]', "which is no number"),
        ('outcomes = ["frames.head_path_m"]', "needs frames.csv, which the study does not have"),
        ('[[measures]]\nname = "T"\nmeasure = "ratings.peak"', "is a score of an instrument"),
        ('[[measures]]\nname = "x"\nmeasure = "ratings.peak"\nthreshold = 3', "has a threshold"),
    ],
)
def test_what_cannot_be_measured_is_one_sentence_with_its_place(
    study: Path, lines: str, said: str
) -> None:
    with pytest.raises(InputError, match=said) as error:
        scored_by(study, lines)
    assert error.value.line is not None


def test_ratings_of_two_instruments_need_the_name_of_one(tmp_path: Path) -> None:
    study = rated(tmp_path / "study")
    file = study / "sub-P01" / "ses-1" / "ratings.csv"
    file.write_text(file.read_text() + "P01,1,1,on,165,,presence,3,0,0\n")
    with pytest.raises(InputError, match="fms, presence; name the instrument"):
        of(study, "ratings.peak")
    assert of(study, "ratings.peak", instrument="presence")["P01", "on"] == 3


def test_a_measure_has_the_words_that_the_plan_gives_it() -> None:
    said = MeasureSettings(name="late", measure="ratings.time_to", threshold=6)
    assert measure_of("late", said) == Measure(
        "late", "Time to a rating of 6", "ratings", "time_to", "s", "higher", threshold=6.0
    )
