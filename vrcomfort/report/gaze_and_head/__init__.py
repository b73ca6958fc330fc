"""Where people looked and how their heads moved, from gaze.csv and frames.csv."""

from vrcomfort.report.gaze_and_head.analysis import Looked, look_at
from vrcomfort.report.gaze_and_head.figures import gaze_and_head_figures

__all__ = ["Looked", "gaze_and_head_figures", "look_at"]
