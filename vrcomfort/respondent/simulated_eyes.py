"""The eyes of simulated participants, and the samples that a tracker makes of them."""

from __future__ import annotations

import math

import numpy as np

from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.geometry import Array, EyeGaze, Gaze, Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.protocol.simulation import SimulatedEyes
from vrcomfort.traces.gaze_quality import angles_deg

# Standard deviation from frame to frame.
_PUPIL_NOISE_MM = 0.05


class EyePair:
    """Both eyes of one simulated participant, converging on a fixated point.

    Parameters
    ----------
    random
        Of noise.
    offsets_deg
        (2, 2): the tracker's (right, up) for the left and the right eye, all of a person's session.
    """

    def __init__(
        self, settings: SimulatedEyes, random: np.random.Generator, offsets_deg: Array
    ) -> None:
        self._settings = settings
        self._random = random
        self._offsets_deg = offsets_deg

    def look(self, head: Pose, point: Array) -> tuple[EyeGaze, EyeGaze]:
        """Return both eyes as the tracker sees them.

        Parameters
        ----------
        head
            stage-from-head.
        point
            (3,) in the stage: what is fixated.
        """
        left, right = (self._look(head, point, index) for index in (0, 1))
        return left, right

    def _look(self, head: Pose, point: Array, index: int) -> EyeGaze:
        settings = self._settings
        side_m = (index - 0.5) * MEAN_IPD_M
        eye = (head @ Pose((side_m, 0.0, 0.0))).position
        noise_deg = settings.noise_deg * self._random.standard_normal(2)
        seen = beside(head, normalize(point - eye), self._offsets_deg[index] + noise_deg)
        pupil_mm = settings.pupil_mm + _PUPIL_NOISE_MM * float(self._random.standard_normal())
        return EyeGaze(Pose(eye, turn_to(seen)), pupil_mm=round(max(pupil_mm, 0.1), 3))

    def closed(self) -> tuple[EyeGaze, EyeGaze]:
        """Return both eyes in a blink."""
        shut = EyeGaze(Pose(), valid=False)
        return shut, shut


def beside(head: Pose, direction: Array, off_deg: Array) -> Array:
    """Return a (3,) direction in the stage, turned by (right, up) degrees that go with the head."""
    right, up = np.radians(off_deg)
    in_head = head.rotation.T @ direction
    turned = Pose(orientation=turn_to(in_head)) @ Pose(orientation=yaw_pitch_roll(-right, up, 0.0))
    return normalize(head.rotation @ turned.forward)


_LATENCY_S = 0.2
"""From the appearance of something to look at to the saccade."""
# Durations of fixations are skewed to the right: standard deviation of their logarithm.
_SPREAD_OF_LOG = 0.5
_SACCADE_S, _SACCADE_S_PER_DEG = 0.021, 0.0022
"""Duration of a saccade: 21 ms and 2.2 ms per degree (Carpenter 1988, from the main sequence)."""
_JUMP_DEG = 2.0
"""A target that moves further from one frame to the next is another target."""
_WANDER_DEG = 0.15
"""Spread of a fixation around its target, along each axis."""
_MADE_UP_S = 1.0
"""Eye movements in a longer gap between frames are not simulated."""
_FAR_M = 2.0
"""Where both eyes' lines of sight meet while nothing is to be looked at."""


class Eyes:
    """The eyes of one simulated participant, and their tracker.

    Parameters
    ----------
    random
        Of fixations and blinks.
    offset_deg
        (right, up): the tracker's, the same for all of a person's session.
    pair
        What it says of each eye; None: it does not tell them apart.
    """

    def __init__(
        self,
        settings: SimulatedEyes,
        random: np.random.Generator,
        offset_deg: Array,
        pair: EyePair | None = None,
    ) -> None:
        self._settings = settings
        self._random = random
        self._offset_deg = offset_deg
        self._pair = pair
        self._until_s = -math.inf
        self._from = self._to = np.array([0.0, 0.0, -1.0])
        self._jump_s = self._jumped_s = 0.0
        self._way: Array | None = None
        self._off_rad = np.zeros(2)
        self._follows = False
        self._blink_s = math.nan
        self._time_s = -math.inf

    def look(self, time_s: float, head: Pose, point: Array | None) -> Gaze:
        """Return the tracker's sample at a time.

        Parameters
        ----------
        head
            stage-from-head.
        point
            (3,) in the stage: what is to be looked at; None: whatever one likes.
        """
        before_s = self._go_on_at(time_s)
        if math.isnan(self._blink_s):
            self._blink_s = time_s + self._random.exponential(self._settings.blink_every_s)
        way = None if point is None else normalize(point - head.position)
        if way is not None and (self._way is None or angles_deg(way, self._way) > _JUMP_DEG):
            self._until_s = min(self._until_s, before_s + _LATENCY_S)
            self._follows = False
        self._way = way
        if way is not None and self._follows:
            self._to = self._beside(way)
        while time_s >= self._until_s:  # when it is due, whatever the frame rate is
            self._fixate(max(self._until_s, time_s - _MADE_UP_S), head)
        truth = self._direction(time_s)
        closed = self._blinks(time_s)
        measured = self._measured(head, truth)
        eyes = self._each(head, truth, point, closed=closed)
        if closed:
            return Gaze(Pose(), valid=False, eyes=eyes)
        return Gaze(Pose(head.position, turn_to(measured)), eyes=eyes)

    def _go_on_at(self, time_s: float) -> float:
        """Return the time of the frame before, in which a target that is new now was first shown.

        Where time goes back (frames of a new step), take what is under way along.
        """
        before_s = self._time_s
        if time_s < before_s:
            back_s = self._time_s - time_s
            self._until_s -= back_s
            self._jumped_s -= back_s
            self._blink_s -= back_s
            before_s = time_s
        self._time_s = time_s
        return before_s

    def _each(
        self, head: Pose, truth: Array, point: Array | None, *, closed: bool
    ) -> tuple[EyeGaze | None, EyeGaze | None]:
        """Return the tracker's sample of each eye: both meet at the fixated point."""
        if self._pair is None:
            return None, None
        if closed:
            return self._pair.closed()
        away_m = _FAR_M if point is None else float(np.linalg.norm(point - head.position))
        return self._pair.look(head, head.position + truth * away_m)

    def _fixate(self, time_s: float, head: Pose) -> None:
        """Choose where to look next, and begin to turn there."""
        settings, random = self._settings, self._random
        self._from = self._direction(time_s)
        self._follows = self._way is not None
        if self._way is None:
            side, up = np.radians(settings.spread_deg) * random.standard_normal(2)
            self._to = (head @ Pose(orientation=yaw_pitch_roll(-side, up, 0.0))).forward
        else:
            self._off_rad = np.radians(_WANDER_DEG) * random.standard_normal(2)
            self._to = self._beside(self._way)
        size_deg = float(angles_deg(self._from, self._to))
        self._jumped_s, self._jump_s = time_s, _SACCADE_S + _SACCADE_S_PER_DEG * size_deg
        length_s = settings.fixation_s * math.exp(_SPREAD_OF_LOG * random.standard_normal())
        self._until_s = time_s + self._jump_s + length_s

    def _beside(self, way: Array) -> Array:
        """Return where a fixation of something is: it is followed while it or the head moves."""
        side, up = self._off_rad
        return (
            Pose(orientation=turn_to(way)) @ Pose(orientation=yaw_pitch_roll(-side, up, 0.0))
        ).forward

    def _direction(self, time_s: float) -> Array:
        """Return the true (3,) direction in the stage: held while the head moves, or on its way."""
        share = (time_s - self._jumped_s) / self._jump_s if self._jump_s else 1.0
        if share >= 1.0:
            return self._to
        eased = share * share * (3 - 2 * share)
        return normalize(self._from + (self._to - self._from) * eased)

    def _blinks(self, time_s: float) -> bool:
        if time_s < self._blink_s:
            return False
        if time_s < self._blink_s + self._settings.blink_s:
            return True
        self._blink_s = time_s + self._random.exponential(self._settings.blink_every_s)
        return False

    def _measured(self, head: Pose, truth: Array) -> Array:
        """Return the direction with the tracker's offset, which goes with the head, and noise."""
        noise = self._settings.noise_deg * self._random.standard_normal(2)
        return beside(head, truth, self._offset_deg + noise)
