"""Statistical reports of study folders: `build_report` is the whole of it."""

from vrcomfort.report.build import ReportSummary, build_report

__all__ = ["ReportSummary", "build_report"]
