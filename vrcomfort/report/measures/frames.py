"""Measures of what the frames of an exposure say: the head's path, its turning, focus changes.

They are the sums of `vrcomfort.recordings`, of the last attempt at an exposure.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from vrcomfort.errors import InputError
from vrcomfort.report.measures.model import Measure, Quantity, Value, exactly

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.report.study_data import StudyData

QUANTITIES = {
    "head_path_m": Quantity("Path of the head", "m", "", "the sum of the head’s steps in the room"),
    "head_turning_deg": Quantity(
        "Turning of the head", "°", "", "the sum of the angles that the head turned by"
    ),
    "avatar_path_m": Quantity(
        "Path through the scene", "m", "", "the sum of the steps of what carries the head, jumps "
        "left out",
    ),
    "focus_travel_dioptre": Quantity(
        "Focus changes", "D", "", "the sum of the changes of the focus distance, in dioptres"
    ),
    "focus_lag_dioptre": Quantity(
        "Lag of focus", "D", "", "the mean distance, in dioptres, between the focus and where the "
        "refocus law was moving it to",
    ),
    "blur_changes": Quantity(
        "Changes of the blur limit", "", "", "how often the largest blur of the condition changed"
    ),
}  # fmt: skip


class Frames:
    """``frames.csv``, as `study_data.with_frames` has summed it."""

    quantities: ClassVar[dict[str, Quantity]] = QUANTITIES
    of_whole_exposures: ClassVar[bool] = True

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the value of each exposure of which there are frames."""
        if not study.frames:
            raise InputError(f"the study has no frames.csv, of which {measure.name} is measured")
        found = {
            (each.participant, each.session, str(each.trial), each.attempt): each
            for each in study.frames
        }
        for trial in study.trials:
            key = (trial["participant"], trial["session"], trial["trial"])
            frames = found.get((*key, int(trial.get("attempt") or 1)))
            value = None if frames is None else getattr(frames, measure.quantity)
            number = None if value is None else exactly(value)
            reason = "" if number is not None else "no frames say it"
            yield Value(*key, trial["condition"], number, reason)
