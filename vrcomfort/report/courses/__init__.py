"""Ratings during exposure over time, who left when, and what both say of conditions."""

from vrcomfort.report.courses.analysis import TimeCourseAnalysis, analyse_time_courses

__all__ = ["TimeCourseAnalysis", "analyse_time_courses"]
