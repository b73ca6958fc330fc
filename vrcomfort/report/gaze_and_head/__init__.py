"""Where people looked and how their heads moved, from gaze.csv and frames.csv."""

from vrcomfort.report.gaze_and_head.analysis import GazeAndHeadAnalysis, analyse_gaze_and_head
from vrcomfort.report.gaze_and_head.figures import gaze_and_head_figures

__all__ = ["GazeAndHeadAnalysis", "analyse_gaze_and_head", "gaze_and_head_figures"]
