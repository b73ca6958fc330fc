"""Measures how high a participant's eyes are, and moves the scene's floor accordingly."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.protocol import Condition
from vrcomfort.protocol.timeline import WHOLE_SESSION, EyeHeightStep
from vrcomfort.scene.data import Environment, Scene
from vrcomfort.scene.markers import Shown
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.exposure import FrameLoop, Stimulus
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.manifest_writer import ManifestWriter
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.tasks import Demand

NAME = "eye_height"
STEADY_M = 0.05
"""A larger movement up or down is measured again."""
ATTEMPTS = 3
POSSIBLE_M = 0.5, 2.3
"""Of eyes over the floor: outside of it the headset does not know where the floor is."""
_GREY = (0.15, 0.15, 0.15)


@dataclass
class _Heights:
    """The heights of the head after a time in which nothing counts; taken as a task takes frames.

    Parameters
    ----------
    settle_s
        That time.
    """

    settle_s: float
    heights_m: list[float] = field(default_factory=list)

    @property
    def done(self) -> bool:
        """Return whether all is over before its time."""
        return False

    def demand(self, frame: Frame) -> Demand | None:
        """Return that nothing is to be looked at."""
        del frame
        return None

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame, if the headset measured the head in it."""
        del headset, scene_time_s
        if elapsed_s >= self.settle_s - 1e-6 and frame.head_tracked:
            self.heights_m.append(float(frame.head_pose.position[1]))

    def next_s(self) -> None:
        """Return nothing: every frame counts."""

    def changed(self) -> tuple[Shown, ...]:
        """Return nothing: there are no balls."""
        return ()

    def finish(self) -> None:
        """End; nothing is open."""


class EyeHeight:
    """Measures the height of the eyes before an exposure."""

    def __init__(
        self,
        context: SessionContext,
        events: EventLog,
        log: FrameLog,
        manifest: ManifestWriter,
        step: EyeHeightStep,
    ) -> None:
        self._context = context
        self._events = events
        self._log = log
        self._manifest = manifest
        self._step = step
        self._settings = step.posture

    def measure(self, headset: Any) -> None:
        """Measure before an exposure; from then on the scene is seen from the right height.

        Raises
        ------
        Withdrew
            If the participant stops.
        """
        words, screen = self._context.protocol.words, self._context.screen
        asked = words.sit_up if self._settings.mode == "seated" else words.stand_up
        start_s = self._context.clock.now_s()
        if screen is not None:
            screen.rest_on(asked)
        try:
            heights_m = self._steady(headset)
        except Skipped:
            self._events.event("eye_height_skipped", detail="the scene's floor stays where it was")
            return
        finally:
            if screen is not None:
                screen.rest_on(None)
        if not heights_m:
            self._tell("the head was not tracked: the height of the eyes is not known")
            return
        self._apply(float(np.median(heights_m)), start_s)

    def _steady(self, headset: Any) -> list[float]:
        """Return the heights of a steady head, or those of the last attempt."""
        heights_m: list[float] = []
        for attempt in range(1, ATTEMPTS + 1):
            heights_m = self._attempt(headset, attempt)
            if heights_m and np.ptp(heights_m) <= STEADY_M:
                return heights_m
        if heights_m:
            moved_m = np.ptp(heights_m)
            self._tell(f"the eyes moved up or down by {moved_m:.2f} m while they were measured")
        return heights_m

    def _attempt(self, headset: Any, attempt: int) -> list[float]:
        context, settings = self._context, self._settings
        duration_s = settings.settle_s + settings.measure_s
        run = _Heights(settings.settle_s)
        grey = Environment(
            sun_irradiance=(0.0, 0.0, 0.0), sky_zenith=_GREY, sky_horizon=_GREY, ground=_GREY
        )
        context.operators.begin("training", f"{self._step.words}, attempt {attempt}")
        context.renderer.begin(Scene(NAME, (), (), (), environment=grey), Condition(name=NAME))
        loop = FrameLoop(context, headset, self._events, self._log, None)
        tell = partial(self._events.tell, "training", self._step.place, total=duration_s)
        try:
            loop.show(Stimulus(0, NAME, duration_s, 1.0), task=run, progress=tell)
        except Redone:
            return self._attempt(headset, attempt)
        return run.heights_m

    def _apply(self, measured_m: float, start_s: float) -> None:
        settings = self._settings
        own = settings.eyes == "own"
        offset_m = 0.0 if own else settings.eye_height_m - measured_m
        self._context.floor.offset_m = offset_m
        seen_m = measured_m + offset_m
        detail = f"{settings.mode}: {measured_m:.3f} m, the scene is seen from {seen_m:.3f} m"
        self._events.event(NAME, start_s, detail=detail)
        fact = {
            "before_trial": self._step.place.trial,
            "measured_m": round(measured_m, 4),
            "offset_m": round(offset_m, 4),
        }
        self._manifest.note_eye_height(fact)
        if not POSSIBLE_M[0] <= measured_m <= POSSIBLE_M[1]:
            self._tell(
                f"eyes {measured_m:.2f} m over the floor: the headset does not know where the "
                "floor is; set up its room"
            )

    def _tell(self, sentence: str) -> None:
        """Tell the experimenter at once, and write it down."""
        self._events.event("eye_height_doubtful", detail=sentence)
        self._events.tell("notice", WHOLE_SESSION, 0, 0, sentence)
