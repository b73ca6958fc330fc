"""Ratings during exposure: time courses, times to a rating and to withdrawal, a symptom model."""

from vrcomfort.report.analyses.contract import SectionAnalysis
from vrcomfort.report.ratings.analysis import (
    TimeCourseAnalysis,
    analyse_time_courses,
    course_paragraphs,
    course_tables,
)
from vrcomfort.report.ratings.figures import rating_figures
from vrcomfort.report.ratings.headline import rating_sentences
from vrcomfort.report.ratings.settings import RatingAnalysis
from vrcomfort.report.ratings.time_courses import MEANINGS, TITLES

__all__ = ["RATINGS", "TimeCourseAnalysis", "analyse_time_courses"]

RATINGS = SectionAnalysis(
    key="ratings",
    anchor="ratings",
    heading="Ratings",
    template="report/ratings.html.j2",
    asked=RatingAnalysis,
    default=RatingAnalysis(),
    about="How ratings during exposure are analysed, where there are any.",
    compute=analyse_time_courses,
    results=lambda courses: courses.results,
    tables=course_tables,
    figures=rating_figures,
    figure_kinds=("ratings", "survival"),
    methods=course_paragraphs,
    sentences=rating_sentences,
    conditions=lambda courses: courses.conditions,
    names={"rating_titles": TITLES, "rating_ways": MEANINGS},
)
