"""Wilcoxon's signed-rank tests of a plan's contrasts of pairs, with t tests of the same pairs."""

from vrcomfort.report.analyses.contract import Analysis, AnalysisSet
from vrcomfort.report.analyses.signed_rank.computation import SignedRankRow, compute, intervals
from vrcomfort.report.analyses.signed_rank.methods import methods
from vrcomfort.report.analyses.signed_rank.renderings import (
    R_FUNCTIONS,
    R_LINES,
    TABLE,
    TABLE_OF_MEANS,
    sentences,
)

__all__ = ["TESTS", "SignedRankRow"]

TESTS = Analysis(
    "tests",
    AnalysisSet.COMPLETE_PAIRS,
    compute,
    tables=(TABLE, TABLE_OF_MEANS),
    section="primary",
    place=0,
    order=0,
    by_outcome=True,
    intervals=intervals,
    sentences=sentences,
    methods=methods,
    analysed=lambda rows: [row.participants for row in rows],
    r_lines=R_LINES,
    r_functions=R_FUNCTIONS,
)
