"""The events that sessions record: their meanings, and whether copies for others keep details.

``vrcomfort anonymise``, the export to BIDS and docs/data_dictionary.md derive from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

_TYPED = "people may have typed it"
_OF_BODY = "it is a measure of the body"
_PATH = "it may hold paths of this machine"


class EventKind(NamedTuple):
    """A kind of event.

    Parameters
    ----------
    meaning
        What happened.
    private
        Why copies for others are without its detail; blank where they keep it.
    """

    meaning: str
    private: str = ""


_OPERATOR = {
    "start": "started the session",
    "pause": "paused the step",
    "go_on": "ended a pause",
    "skip": "skipped the step",
    "redo": "had the step begun again",
    "recentre": "recentred the headset",
    "note": "wrote a note",
    "abort": "ended the program's run of the session",
    "withdraw": "asked for the participant's withdrawal",
    "withdraw_surely": "confirmed the withdrawal",
    "withdraw_not": "took the withdrawal back",
    "answer": "entered an answer",
    "confirm": "confirmed the answers",
    "rate": "entered a rating",
    "write": "entered an answer in the participant's own words",
    "decide": "decided on a screening rule",
    "refused": "asked for what was refused",
}

EVENTS: Mapping[str, EventKind] = {
    "adjusted": EventKind("An adjustment was confirmed"),
    "answer": EventKind("A question was answered, or an answer corrected"),
    "blur_limited": EventKind("A limit made a blur of the exposure smaller"),
    "break_cut_short": EventKind("An operator ended a break before its minimum"),
    "break_too_long": EventKind("A break took longer than its maximum"),
    "controller_found": EventKind("A controller was tracked again"),
    "controller_lost": EventKind("A controller was no longer tracked"),
    "controllers_changed": EventKind("The runtime told of other controllers"),
    "ended": EventKind("The session ended before its time; the study goes on", _TYPED),
    "events_lost": EventKind("The OpenXR runtime lost events"),
    "exposure": EventKind("An exposure"),
    "exposure_ended": EventKind("An exposure ended before its time; the session goes on", _TYPED),
    "exposure_stopped": EventKind("An exposure ended together with session or study", _TYPED),
    "eye_height": EventKind("The height of the eyes was measured", _OF_BODY),
    "eye_height_doubtful": EventKind("The height of the eyes cannot be right", _OF_BODY),
    "eye_height_skipped": EventKind("An operator skipped the measurement of the eyes' height"),
    "focused": EventKind("The application had the input again (OpenXR)"),
    "frame_discarded": EventKind("The OpenXR runtime did not show a frame"),
    "frames_not_recorded": EventKind("Frames that were shown have no row: the disk was too slow"),
    "free_text": EventKind("A question was answered in the participant's own words"),
    "free_text_cut": EventKind("Only the beginning of an answer in own words was kept"),
    "free_text_skipped": EventKind("An operator skipped a question to be answered in own words"),
    "gaze_not_validated": EventKind("The gaze was not validated"),
    "gaze_validation": EventKind("The accuracy of the gaze was measured"),
    "head_found": EventKind("The head was tracked for the first time"),
    "headset_off": EventKind("The headset was taken off"),
    "headset_on": EventKind("The headset was put on"),
    "instruction": EventKind("An instruction was given"),
    "ipd_differs": EventKind(
        "The distance between the eyes that is shown is not the participant's", _OF_BODY
    ),
    "not_passed_on": EventKind("Samples for other devices were lost: these were too slow"),
    "openxr_error": EventKind("The OpenXR runtime reported an error", _PATH),
    "openxr_warning": EventKind("The OpenXR runtime reported a warning", _PATH),
    **{
        f"operator_{action}": EventKind(f"An operator {meaning}", _TYPED)
        for action, meaning in _OPERATOR.items()
    },
    "pause": EventKind("An operator's pause: nothing was to be seen"),
    "photodiode": EventKind(
        "The patch for the photodiode became white", "it is a time of the runtime's clock"
    ),
    "practice": EventKind("An exposure of practice"),
    "practice_not_met": EventKind("The criterion of practice was not met in its repetitions"),
    "questionnaire_missed": EventKind("Questions were not asked: it was too late"),
    "questionnaire_refused": EventKind("The participant did not answer questions", _TYPED),
    "questionnaire_resumed": EventKind("Questions that were open were asked after an interruption"),
    "questionnaire_skipped": EventKind("An operator skipped questions"),
    "ratings_planned": EventKind("The times of ratings were drawn"),
    "recentered": EventKind("The headset's origin and heading were set anew"),
    "refresh_rate_changed": EventKind("The display's refresh rate was no longer that of the start"),
    "refresh_rate_restored": EventKind("The display's refresh rate was that of the start again"),
    "rest": EventKind("A break"),
    "row_cut_off": EventKind("A half-written row was moved aside", _PATH),
    "runtime_hung": EventKind("The OpenXR runtime did not answer; the session was interrupted"),
    "runtime_stalled": EventKind("The OpenXR runtime did not answer for a while"),
    "screening": EventKind(
        "A number was beyond a screening rule", "it may be a measure of the body or of health"
    ),
    "session_end": EventKind("The session was completed"),
    "session_resumed": EventKind("The session went on after an interruption"),
    "session_start": EventKind("The session began"),
    "session_state": EventKind("The state of the OpenXR session changed"),
    "space_changed": EventKind("The OpenXR runtime moved a space that is not in use"),
    "task_target": EventKind("A task asked for another target"),
    "timing_flag": EventKind("The timing of a trial was worse than the protocol allows"),
    "tracking_found": EventKind("The head was tracked again"),
    "tracking_lost": EventKind("The head was no longer tracked"),
    "training": EventKind("Training before the first exposure"),
    "unfocused": EventKind("Something of the OpenXR runtime had the input"),
    "visibility_mask_changed": EventKind(
        "The lenses hide another part of an eye's image than at the start, and frames do not follow"
    ),
    "window_focus": EventKind("The window gained or lost the input"),
    "withdrawal_undone": EventKind("An operator took a withdrawal back", _TYPED),
    "withdrawn": EventKind("The participant's study ended in this session", _TYPED),
}


def shared_detail(name: str, detail: str) -> str:
    """Return an event's detail as copies for others have it: blank where it is private."""
    kind = EVENTS.get(name)
    return "" if kind is None or kind.private else detail
