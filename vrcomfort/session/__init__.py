"""Sessions: one participant, one headset, one order, and everything written as it happens."""

from vrcomfort.session.clock import Clock, VirtualClock, WallClock
from vrcomfort.session.manifest_writer import headset_facts
from vrcomfort.session.interfaces import HeadsetFor, LoadScene, Progress, ProgressCallback, Renderer
from vrcomfort.session.enrolment import Reservation, reserve
from vrcomfort.session.run import run
from vrcomfort.session.participant_sessions import Outcome

__all__ = [
    "Clock",
    "HeadsetFor",
    "LoadScene",
    "Outcome",
    "Progress",
    "ProgressCallback",
    "Renderer",
    "Reservation",
    "VirtualClock",
    "WallClock",
    "headset_facts",
    "reserve",
    "run",
]
