"""Gaze and head motion during exposures, from gaze.csv and frames.csv."""

from vrcomfort.report.analyses.contract import SectionAnalysis
from vrcomfort.report.gaze_and_head.analysis import GazeAndHeadAnalysis, analyse_gaze_and_head
from vrcomfort.report.gaze_and_head.renderings import (
    gaze_and_head_figures,
    gaze_and_head_tables,
    gaze_paragraphs,
)
from vrcomfort.report.gaze_and_head.settings import GazeAndHead

__all__ = ["GAZE_AND_HEAD", "GazeAndHeadAnalysis", "analyse_gaze_and_head"]

GAZE_AND_HEAD = SectionAnalysis(
    key="gaze_and_head",
    anchor="gaze",
    heading="Gaze and head",
    template="report/gaze_and_head.html.j2",
    asked=GazeAndHead,
    about="How gaze and head motion are analysed; None: they are not.",
    compute=lambda data, asked: analyse_gaze_and_head(
        data.study, asked, list(data.conditions), data.memory
    ),
    results=lambda found: {"gaze_and_head": found.results},
    tables=gaze_and_head_tables,
    figures=gaze_and_head_figures,
    figure_kinds=("gaze", "head"),
    methods=gaze_paragraphs,
    notes=lambda found: found.notes,
)
