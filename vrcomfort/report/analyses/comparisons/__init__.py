"""Comparisons by other tests than the signed-rank test: of pairs, and of groups of people."""

from vrcomfort.report.analyses.comparisons.computation import (
    ComparisonRow,
    compute,
    intervals,
    people_of_tests,
)
from vrcomfort.report.analyses.comparisons.renderings import (
    R_LINES,
    TABLE,
    figures,
    heading,
    methods,
    sentences,
)
from vrcomfort.report.analyses.contract import Analysis, AnalysisSet

__all__ = ["COMPARISONS", "ComparisonRow"]

COMPARISONS = Analysis(
    "comparisons",
    AnalysisSet.COMPLETE_PAIRS,
    compute,
    tables=(TABLE,),
    heading=heading,
    figures=figures,
    figure_kinds=("paired",),
    side_by_side=True,
    place=1,
    order=1,
    by_outcome=True,
    intervals=intervals,
    sentences=sentences,
    methods=methods,
    analysed=people_of_tests,
    r_lines=R_LINES,
)
