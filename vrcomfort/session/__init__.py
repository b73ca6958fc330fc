"""Sessions: one participant, one headset, one order, and everything written as it happens."""

from vrcomfort.session.clock import Clock, VirtualClock, WallClock
from vrcomfort.session.parts import HeadsetFor, LoadScene, Progress, ProgressCallback, Renderer
from vrcomfort.session.run import Outcome, run

__all__ = [
    "Clock",
    "HeadsetFor",
    "LoadScene",
    "Outcome",
    "Progress",
    "ProgressCallback",
    "Renderer",
    "VirtualClock",
    "WallClock",
    "run",
]
