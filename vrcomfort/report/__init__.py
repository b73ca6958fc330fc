"""Statistical reports of study folders: `build_report` is the whole of it."""

from vrcomfort.report.build import FORMS, Form, ReportSummary, build_report

__all__ = ["FORMS", "Form", "ReportSummary", "build_report"]
