"""Columns of the same name and meaning in several files, those of poses among them."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from vrcomfort.records.rows import Column

Body = Literal["head", "left", "right", "avatar", "left_hand", "right_hand"]
Eye = Literal["left", "right"]

_POSE_SUFFIXES = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
_FOV_SIDES = ("left", "right", "up", "down")


def pose_columns(body: Body) -> tuple[str, ...]:
    """Return the seven columns of a body: position (metres), then quaternion (x, y, z, w)."""
    return tuple(f"{body}_{suffix}" for suffix in _POSE_SUFFIXES)


def fov_columns(eye: Eye) -> tuple[str, ...]:
    """Return the four half-angle columns of an eye (radians; left and down negative)."""
    return tuple(f"{eye}_fov_{side}_rad" for side in _FOV_SIDES)


HEAD = pose_columns("head")
EYES = (*pose_columns("left"), *pose_columns("right"))
FOVS = (*fov_columns("left"), *fov_columns("right"))
AVATAR = pose_columns("avatar")
HANDS = (*pose_columns("left_hand"), *pose_columns("right_hand"))
POSE_COLUMNS = (*HEAD, *EYES, *FOVS, *AVATAR)

ParticipantName: TypeAlias = Annotated[str, Column("Identifier of a participant")]
SessionNumber: TypeAlias = Annotated[int, Column("Number of the session, from 1")]
TrialNumber: TypeAlias = Annotated[int, Column("Number of the exposure in the session, from 1")]
ConditionName: TypeAlias = Annotated[str, Column("Condition of the protocol")]
SceneName: TypeAlias = Annotated[str, Column("Scene that was shown")]
Attempt: TypeAlias = Annotated[
    int, Column("1, and one more each time that the exposure was begun again")
]
Resumed: TypeAlias = Annotated[int, Column("1 where it was recorded after the session was resumed")]

TrialOfSession: TypeAlias = Annotated[
    int | None,
    Column("Number of the exposure in the session, from 1", blank="the whole session is meant"),
]
ConditionOfSession: TypeAlias = Annotated[
    str | None, Column("Condition of the protocol", blank="the whole session is meant")
]
PartOfStudy: TypeAlias = Annotated[
    str | None,
    Column(
        "Part of the study that the exposure belongs to, or all exposures that are meant",
        blank="it has no parts, or several are meant",
        since=4,
    ),
]

StartS: TypeAlias = Annotated[float, Column("Begin of the exposure on the session's clock")]
EndS: TypeAlias = Annotated[float, Column("End of the exposure on the session's clock")]
AskedS: TypeAlias = Annotated[float, Column("When it was asked on the session's clock")]
AnsweredS: TypeAlias = Annotated[float, Column("When it was answered on the session's clock")]
OnsetS: TypeAlias = Annotated[float, Column("When it began, or was asked, on the session's clock")]

FrameS: TypeAlias = Annotated[float, Column("The frame's time on the session's clock")]
FrameTimeNs: TypeAlias = Annotated[
    int, Column("The frame's predicted display time on the runtime's clock", signed=True)
]
FrameTrial: TypeAlias = Annotated[
    int, Column("Number of the exposure in the session, from 1; 0 in training and practice")
]

Targets: TypeAlias = Annotated[
    int | None, Column("Targets of the whole exposure", blank="it means nothing for the row")
]
Hits: TypeAlias = Annotated[
    int | None, Column("Targets of them that were met", blank="it means nothing for the row")
]
Shots: TypeAlias = Annotated[
    int | None, Column("Shots of the whole exposure", blank="it means nothing for the row")
]
Score: TypeAlias = Annotated[
    float | None,
    Column(
        "The task's measure, of the whole exposure",
        blank="it means nothing for the row",
        signed=True,
    ),
]
