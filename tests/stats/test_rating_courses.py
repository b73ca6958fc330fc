"""Courses of ratings: each summary against numbers worked out by hand."""

import numpy as np
import pytest

from vrcomfort.errors import InputError
from vrcomfort.stats.rating_courses import RatingCourse, Reached

NAN = float("nan")
COURSE = RatingCourse.of([60, 0, 120, 180], [NAN, 0, 4, 2])
"""0 at once, one missed after a minute, then 4 and 2."""


def test_summaries_are_those_of_the_answered_ratings() -> None:
    assert COURSE.peak() == 4
    assert COURSE.mean() == 2
    assert COURSE.last() == 2
    assert COURSE.area() == 120 * 2 + 60 * 3
    # minutes −5/3, 1/3, 4/3 about their mean: (0 + 4/3 + 8/3) / (25/9 + 1/9 + 16/9)
    assert COURSE.slope_per_min() == pytest.approx(4 / (42 / 9))


def test_ratings_in_a_row_are_those_that_were_answered() -> None:
    course = RatingCourse(np.arange(1.0, 7.0), np.array([5, 9, 2, 9, np.nan, 9]))
    assert course.time_to(9, in_a_row=2, ended_s=8) == Reached(6.0, reached=True)
    assert course.time_to(9, in_a_row=3, ended_s=8) == Reached(8.0, reached=False)


def test_a_threshold_is_reached_at_the_first_rating_there_or_above() -> None:
    assert COURSE.time_to(4) == Reached(120, reached=True)
    assert COURSE.time_to(1.5) == Reached(120, reached=True)
    assert COURSE.time_to(5) == Reached(180, reached=False)
    assert COURSE.time_to(5, ended_s=200) == Reached(200, reached=False)


def test_a_missed_last_rating_was_watched_and_carries_the_one_before() -> None:
    course = RatingCourse.of([10, 20, 30], [1, 3, NAN])
    assert course.time_to(9) == Reached(30, reached=False)
    assert course.last() == 3


def test_the_last_rating_is_carried_forward() -> None:
    at = [0, 59, 120, 400]
    np.testing.assert_array_equal(COURSE.carried_forward(at), [0, 0, 4, 2])
    np.testing.assert_array_equal(COURSE.carried_forward(at, until_s=180), [0, 0, 4, NAN])
    early = RatingCourse.of([10], [7]).carried_forward([0, 10])
    np.testing.assert_array_equal(early, [NAN, 7])


def test_nothing_answered_has_no_summary() -> None:
    for course in (RatingCourse.of([], []), RatingCourse.of([1, 2], [NAN, NAN])):
        assert course.peak() is course.mean() is course.last() is course.area() is None
        assert course.slope_per_min() is course.time_to(1) is None
        assert np.isnan(course.carried_forward([0, 5])).all()


def test_one_rating_has_no_slope_and_no_area() -> None:
    course = RatingCourse.of([30], [6])
    assert (course.peak(), course.mean(), course.last(), course.area()) == (6, 6, 6, 0)
    assert course.slope_per_min() is None
    assert RatingCourse.of([30, 30], [6, 8]).slope_per_min() is None


def test_refuses_what_is_no_course() -> None:
    with pytest.raises(InputError, match="one time for each rating"):
        RatingCourse.of([1, 2], [3])
    with pytest.raises(InputError, match="a time of a rating is missing"):
        RatingCourse.of([1, NAN], [3, 4])


def test_a_level_course_has_no_slope_of_rounding():
    """A model of such slopes once had a p of .035."""
    times = 10.0 * np.arange(1, 9) + 0.1
    assert {RatingCourse.of(times, np.full(8, level)).slope_per_min() for level in range(21)} == {0}
