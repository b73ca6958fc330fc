"""Ratings during exposure over time, who left when, and what both say of conditions."""

from vrcomfort.report.courses.analysis import Courses, analyse_courses

__all__ = ["Courses", "analyse_courses"]
