"""The columns of a study's tables, and what a copy for others has to keep for each of them.

``vrcomfort anonymise`` and its ``anonymised.json`` derive from this declaration.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from vrcomfort.records.consents import ConsentRow
from vrcomfort.records.exposure_rows import (
    BallRow,
    DialRow,
    PracticeRow,
    RatingRow,
    TaskRow,
    TimingRow,
    TrialRow,
)
from vrcomfort.records.frame_rows import EYE_GAZES, RAYS, FrameRow, GazeRow, ImageRow, gaze_columns
from vrcomfort.records.pose_columns import AVATAR, EYES, FOVS, HANDS, HEAD
from vrcomfort.records.session_rows import (
    FACTS,
    ClockRow,
    EventRow,
    GazeValidationRow,
    ParticipantRow,
    QuestionnaireRow,
    ScreeningRow,
    TextRow,
)

Trait: TypeAlias = Literal["motion", "gaze", "text", "date"]
"""What people can be recognised by: motion and gaze may be kept on request, the others never."""
Needs: TypeAlias = frozenset[Trait]

ALWAYS: Needs = frozenset()
MOTION: Needs = frozenset({"motion"})
GAZE: Needs = frozenset({"gaze"})
BOTH: Needs = frozenset({"motion", "gaze"})
TEXT: Needs = frozenset({"text"})
DATE: Needs = frozenset({"date"})

_RAYS = ("focus_m", "focus_raw_m", *RAYS, "rays_used")
"""The head decides them and, in conditions that focus by gaze, the gaze."""
_WHEN = ("session_s", "xr_time_ns", "trial")
_WHOSE = ("participant", "session", "trial", "condition")


@dataclass(frozen=True)
class SharedFile:
    """What becomes of a file in a copy for others.

    Parameters
    ----------
    columns
        Column → the traits that have to be kept for it; it is blank otherwise. Ids and times in
        columns that stay are replaced, details of events are kept where `EVENTS` says so.
    needs
        The traits that have to be kept for the file.
    """

    columns: Mapping[str, Needs]
    needs: Needs = ALWAYS

    def lacking(self, kept: Needs) -> Needs:
        """Return the traits that the file is left out for; none where it stays."""
        return self.needs - kept

    def blank(self, kept: Needs) -> list[str]:
        """Return the columns that are blank in a copy with these traits."""
        return [name for name, needs in self.columns.items() if not needs <= kept]


def _columns(*always: str, **groups: tuple[Needs, tuple[str, ...]]) -> Mapping[str, Needs]:
    more = {name: needs for needs, names in groups.values() for name in names}
    return {**dict.fromkeys(always, ALWAYS), **more}


SHARED: Mapping[str, SharedFile] = {
    ParticipantRow.FILE: SharedFile(
        _columns(
            "participant", "sequence", "status", "enrolled_at", "group", note=(TEXT, ("note",)),
            facts=(GAZE, FACTS),
        )
    ),
    ConsentRow.FILE: SharedFile(
        _columns("participant", "version", "given_on", "text_sha256", "recorded_at"), needs=DATE
    ),
    TrialRow.FILE: SharedFile(
        _columns(
            *_WHOSE, "period", "block", "scene", "start_s", "end_s", "status", "abort_code",
            "attempt", "resumed", "frames", "dropped", "missed_refreshes", "live_s", "frozen_s",
            "hidden_s", "unfocused_s", "part",
        )
    ),
    TimingRow.FILE: SharedFile(
        _columns(
            *_WHOSE, "attempt", "frames", "dropped", "dropped_percent", "interval_median_ms",
            "interval_p95_ms", "interval_p99_ms", "cpu_median_ms", "cpu_p95_ms", "cpu_p99_ms",
            "gpu_median_ms", "gpu_p95_ms", "gpu_p99_ms", "flagged", "resumed",
        )
    ),
    QuestionnaireRow.FILE: SharedFile(
        _columns(
            *_WHOSE, "period", "block", "timepoint", "instrument", "item", "response", "asked_s",
            "answered_s", "order", "part", "resumed",
        )
    ),
    RatingRow.FILE: SharedFile(
        _columns(*_WHOSE, "onset_s", "latency_s", "instrument", "response", "missed", "resumed")
    ),
    FrameRow.FILE: SharedFile(
        _columns(
            *_WHEN, "period_ns", "should_render", *FOVS, "head_valid", "head_tracked",
            "session_state", "max_blur_px", "cpu_ms", "gpu_ms", "dropped", "missed_refreshes",
            "discontinuity", "resumed",
            poses=(MOTION, (*HEAD, *EYES, *AVATAR, *HANDS)), focus=(BOTH, _RAYS),
        )
    ),
    EventRow.FILE: SharedFile(_columns("onset_s", "duration_s", "name", "detail", "resumed")),
    GazeRow.FILE: SharedFile(
        _columns(
            "session_s", "xr_time_ns", "valid", *gaze_columns(), "hit_m", "hit_node",
            "effect_centre", *EYE_GAZES, "resumed",
        ),
        needs=GAZE,
    ),
    GazeValidationRow.FILE: SharedFile(
        _columns(
            "participant", "session", "validation", "attempt", "before_trial", "onset_s", "point",
            "eye", "right_deg", "up_deg", "distance_m", "samples", "valid_percent", "accuracy_deg",
            "precision_rms_deg", "precision_sd_deg", "good", "resumed",
        ),
        needs=GAZE,
    ),
    ImageRow.FILE: SharedFile(_columns(*_WHEN, "left_hash", "right_hash", "resumed"), needs=BOTH),
    BallRow.FILE: SharedFile(
        _columns(
            *_WHEN, "ball", "x_m", "y_m", "z_m", "radius_m", "red", "green", "blue", "resumed"
        ),
        needs=MOTION,
    ),
    ClockRow.FILE: SharedFile(
        _columns(
            "session_s", "xr_time_ns", "monotonic_ns", "unix_ns", "lsl_s", "took_ns", "resumed"
        ),
        needs=DATE,
    ),
    TaskRow.FILE: SharedFile(
        _columns(
            *_WHOSE, "attempt", "task", "kind", "number", "what", "onset_s", "reaction_s", "hit",
            "error_deg", "distance_m", "targets", "hits", "shots", "score", "resumed",
            places=(MOTION, ("x_m", "y_m", "z_m")),
        )
    ),
    DialRow.FILE: SharedFile(
        _columns(
            *_WHOSE, "attempt", "dial", "setting", "instrument", "kind", "onset_s", "value",
            "resumed",
        )
    ),
    TextRow.FILE: SharedFile(
        _columns(*_WHOSE, "question", "text", "asked_s", "answered_s", "resumed"), needs=TEXT
    ),
    ScreeningRow.FILE: SharedFile(
        _columns("participant", "session", "rule", "value", "decision", "decided_s", "resumed")
    ),
    PracticeRow.FILE: SharedFile(
        _columns(
            "participant", "session", "practice", "before_trial", "repetition", "number",
            "condition", "scene", "task", "start_s", "end_s", "status", "targets", "hits", "shots",
            "score", "met", "over", "resumed",
        )
    ),
}  # fmt: skip
"""File → what becomes of it. Covariates are columns of participants.csv that the protocol names;
they stay."""
