"""Where people looked and how their heads moved, from gaze.csv and frames.csv."""

from vrcomfort.report.gaze_and_head.figures import gaze_and_head_figures
from vrcomfort.report.gaze_and_head.results import Looked, look_at

__all__ = ["Looked", "gaze_and_head_figures", "look_at"]
