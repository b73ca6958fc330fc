"""What a simulated tracker says of each eye: its line of sight and its pupil."""

from __future__ import annotations

import numpy as np

from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.geometry import Array, EyeGaze, Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.protocol.gaze_validation import SimulatedEyes

_PUPIL_NOISE_MM = 0.05


class EyePair:
    """Both eyes of one simulated participant: they converge on what is fixated.

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
