"""Sessions: one participant, one headset, one order, and everything written as it happens."""

from vrcomfort.session.clock import Clock, VirtualClock, WallClock
from vrcomfort.session.context import SessionSettings
from vrcomfort.session.enrolment import OpenEnrolment, open_enrolment
from vrcomfort.session.interfaces import HeadsetFor, LoadScene, Renderer
from vrcomfort.session.manifest_writer import headset_facts
from vrcomfort.session.no_frames import NoPictures, StillHeadset, scenes_for
from vrcomfort.session.run import RunOutcome, run

__all__ = [
    "Clock",
    "HeadsetFor",
    "LoadScene",
    "NoPictures",
    "OpenEnrolment",
    "Renderer",
    "RunOutcome",
    "SessionSettings",
    "StillHeadset",
    "VirtualClock",
    "WallClock",
    "headset_facts",
    "open_enrolment",
    "run",
    "scenes_for",
]
