"""Validates the eye tracker: points on grey, and how far the gaze is from each."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.geometry import Array, EyeGaze, Gaze, Pose, normalize, yaw_pitch_roll
from vrcomfort.protocol import Condition
from vrcomfort.protocol.session_steps import GazeValidation, Point
from vrcomfort.protocol.timeline import GazeValidationStep, TrialPlace
from vrcomfort.records import FACTS, GazeValidationRow, set_fact
from vrcomfort.scene.data import Environment, Scene
from vrcomfort.scene.markers import Markers, Shown
from vrcomfort.session.context import EventLog, SessionContext
from vrcomfort.session.exposure import FrameLoop, Stimulus
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.session.operator_control import Redone, Skipped
from vrcomfort.session.ratings import StopRule
from vrcomfort.session.task_run import task_random
from vrcomfort.tasks import Ball, Demand
from vrcomfort.traces.gaze_quality import GazeQuality, quality_of

NAME = "gaze_validation"
EYES = ("combined", "left", "right")
"""In the order of their rows; one eye alone has rows where the tracker tells of it."""
_COLOUR = (0.9, 0.9, 0.9)
_GREY = (0.15, 0.15, 0.15)


@dataclass
class _Seen:
    """The gaze of an eye (or both) on a point: unit vectors in the stage, from the eye."""

    told: bool = False
    directions: list[Array] = field(default_factory=list)
    towards: list[Array] = field(default_factory=list)

    def add(self, gaze: Gaze | EyeGaze, point_m: Array) -> None:
        self.told = True
        if gaze.valid:
            self.directions.append(gaze.pose.forward)
            self.towards.append(normalize(point_m - gaze.pose.position))

    def quality(self) -> GazeQuality:
        gaze = np.array(self.directions).reshape(-1, 3)
        return quality_of(gaze, np.array(self.towards).reshape(-1, 3))


@dataclass
class _Shown:
    """One point in the stage, and the gaze on it."""

    at: Point
    since_s: float
    onset_s: float
    ball: Ball
    frames: int = 0
    seen: dict[str, _Seen] = field(default_factory=lambda: {eye: _Seen() for eye in EYES})

    def add(self, gaze: Gaze | None) -> None:
        """Take a frame after the eyes have settled."""
        self.frames += 1
        each = (None, None, None) if gaze is None else (gaze, *gaze.eyes)
        for eye, one in zip(EYES, each, strict=True):
            if one is not None:
                self.seen[eye].add(one, self.ball.position_m)


class PointsRun:
    """The points of one attempt, one after the other; shown as a task is."""

    def __init__(self, settings: GazeValidation, order: list[int], spawn: Pose) -> None:
        self._settings = settings
        self._left = [settings.points[k] for k in order]
        grey = Environment(
            sun_irradiance=(0.0, 0.0, 0.0), sky_zenith=_GREY, sky_horizon=_GREY, ground=_GREY
        )
        empty = Scene(NAME, (), (), (), environment=grey, spawn=spawn)
        self._markers = Markers(empty, [_COLOUR])
        self.shown: list[_Shown] = []
        self.now_s = 0.0
        self.saw_gaze = False

    @property
    def drawn(self) -> Scene:
        """Return the scene with the point in it."""
        return self._markers.scene

    @property
    def done(self) -> bool:
        """Return whether all is over before its time."""
        return False

    def demand(self, frame: Frame) -> Demand | None:
        """Return the current point as a demand."""
        if not self.shown:
            return None
        point = self.shown[-1]
        return Demand(_in_world(frame, point.ball), point.since_s, press=False)

    def step(self, frame: Frame, headset: object, elapsed_s: float, scene_time_s: float) -> None:
        """Take a frame before it is drawn."""
        del headset, scene_time_s
        # By the plan, not after the one before: slow frames would leave no time for the last.
        due = elapsed_s >= len(self.shown) * self._settings.each_s - 1e-6
        if due and self._left:
            self._appear(frame.head_pose, elapsed_s)
        point = self.shown[-1]
        # It goes with the stage: whoever is moved by a stick or a path is not led past it.
        self._markers.place([(_in_world(frame, point.ball), point.ball.radius_m)])
        self.saw_gaze |= frame.gaze is not None
        if elapsed_s < point.since_s + self._settings.settle_s:
            return
        point.add(frame.gaze)

    def next_s(self) -> None:
        """Return nothing: every frame counts."""

    def changed(self) -> tuple[Shown, ...]:
        """Return nothing: its frames are of no exposure, and are not shown again."""
        return ()

    def finish(self) -> None:
        """End with the exposure; nothing is open."""

    def _appear(self, head: Pose, elapsed_s: float) -> None:
        right_deg, up_deg, away_m = at = self._left.pop(0)
        look = yaw_pitch_roll(-np.radians(right_deg), np.radians(up_deg), 0.0)
        ray = head @ Pose(orientation=look)
        radius_m = away_m * float(np.sin(np.radians(self._settings.diameter_deg / 2)))
        ball = Ball(head.position + ray.forward * away_m, radius_m)
        self.shown.append(_Shown(at, elapsed_s, self.now_s, ball))


def _in_world(frame: Frame, ball: Ball) -> Array:
    """Return where in the world a ball of the stage is."""
    return (frame.avatar_pose @ Pose(ball.position_m)).position


class Validation:
    """The validations of one session.

    Parameters
    ----------
    seed
        Decides the order of the points.
    """

    def __init__(
        self, context: SessionContext, events: EventLog, log: FrameLog, settings: GazeValidation
    ) -> None:
        self._context = context
        self._events = events
        self._log = log
        self._settings = settings
        self._count = 0

    def hold(
        self, step: GazeValidationStep, headset: Any, spawn: Pose, *, resumed: bool
    ) -> str | None:
        """Validate before an exposure, again where the error is too large.

        Returns
        -------
        str or None
            A sentence where it could not be done, or was not good enough and only noted.

        Raises
        ------
        StopRule
            If the error stays above the limit, and the protocol ends something with it.
        Withdrew
            If the participant stops.
        """
        self._count += 1
        error: float | None = None
        for attempt in range(1, self._settings.attempts + 1):
            run = self._attempt(headset, spawn, step, attempt)
            if run is None:
                return "the gaze was not validated: an operator has skipped it"
            if not run.saw_gaze:
                self._events.event("gaze_not_validated", detail="there is no eye tracker")
                return "the gaze was not validated: there is no eye tracker"
            error = self._write(run, step.place, attempt, resumed=resumed)
            if error is not None and error <= self._settings.limit_deg:
                break
        return self._judge(error)

    def _judge(self, error: float | None) -> str | None:
        settings = self._settings
        if error is not None:
            who = self._context.participant
            set_fact(self._context.study, who, FACTS[0], f"{error:.3f}")
            if error <= settings.limit_deg:
                return None
        said = "the eyes were never seen" if error is None else f"{error:.2f} degrees"
        reason = f"gaze validation: {said}, and the limit is {settings.limit_deg:g} degrees"
        if settings.above == "note":
            return reason
        raise StopRule(reason, "session" if settings.above == "end_session" else "study", "gaze")

    def _attempt(
        self, headset: Any, spawn: Pose, step: GazeValidationStep, attempt: int
    ) -> PointsRun | None:
        context, settings = self._context, self._settings
        order = self._random(attempt).permutation(len(settings.points)).tolist()
        run = PointsRun(settings, order, spawn)
        run.now_s = start_s = context.clock.now_s()
        duration_s = len(order) * settings.each_s
        context.operators.begin("training", f"{step.words}, attempt {attempt}")
        context.renderer.begin(run.drawn, Condition(name=NAME))
        loop = FrameLoop(context, headset, self._events, self._log, None)
        tell = partial(self._events.tell, "training", step.place, total=duration_s)
        try:
            loop.show(Stimulus(0, NAME, duration_s, 1.0), task=run, progress=tell)
        except Skipped:
            return None
        except Redone:
            return self._attempt(headset, spawn, step, attempt)
        finally:
            self._events.event(NAME, start_s, detail=f"attempt {attempt}")
        for each in run.shown:
            each.onset_s = start_s + each.since_s
        return run

    def _random(self, attempt: int) -> np.random.Generator:
        context = self._context
        stream = 1_000_000 + 100 * self._count + attempt
        return task_random(context.seed, context.participant, self._events.session, stream)

    def _write(
        self, run: PointsRun, place: TrialPlace, attempt: int, *, resumed: bool
    ) -> float | None:
        """Write a row for each point and eye, and the means; return the error of both eyes."""
        told = [eye for eye in EYES if any(each.seen[eye].told for each in run.shown)]
        rows, means = [], []
        for eye in told or EYES[:1]:
            of_points = [each.seen[eye].quality() for each in run.shown]
            for number, (each, quality) in enumerate(zip(run.shown, of_points, strict=True), 1):
                right_deg, up_deg, away_m = each.at
                row = self._row(place, attempt, [each], eye, quality)
                rows.append(
                    replace(
                        row, point=number, right_deg=right_deg, up_deg=up_deg, distance_m=away_m
                    )
                )
            mean = GazeQuality(*map(_mean, zip(*of_points, strict=True)))
            means.append(self._row(place, attempt, run.shown, eye, mean))
        error = _mean(tuple(each.seen[EYES[0]].quality().accuracy_deg for each in run.shown))
        good = int(error is not None and error <= self._settings.limit_deg)
        means[0] = replace(means[0], good=good)
        recorder = self._events.recorder
        recorder.write(*(replace(row, resumed=int(resumed)) for row in (*rows, *means)))
        return error

    def _row(
        self,
        place: TrialPlace,
        attempt: int,
        shown: list[_Shown],
        eye: str,
        quality: GazeQuality,
    ) -> GazeValidationRow:
        """Return the row of one point, or of several, that says nothing of where they were."""
        frames = sum(each.frames for each in shown)
        valid = sum(len(each.seen[eye].directions) for each in shown)
        accuracy, rms, sd = (None if each is None else round(each, 4) for each in quality)
        return GazeValidationRow(
            participant=self._context.participant,
            session=self._events.session,
            validation=self._count,
            attempt=attempt,
            before_trial=place.trial or 0,
            onset_s=round(shown[0].onset_s, 9),
            point=None,
            eye=eye,
            right_deg=None,
            up_deg=None,
            distance_m=None,
            samples=frames,
            valid_percent=round(100 * valid / frames, 2) if frames else 0.0,
            accuracy_deg=accuracy,
            precision_rms_deg=rms,
            precision_sd_deg=sd,
        )


def _mean(values: tuple[float | None, ...]) -> float | None:
    """Return the mean over the points on which the eyes were seen."""
    known = [each for each in values if each is not None]
    return float(np.mean(known)) if known else None
