"""The shapes of JSON in a study folder: the keys that commands rely on."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

LONGEST_S = 1e8
"""Three years: no time of a session lies beyond."""

Count = Annotated[int, Field(ge=0, le=2**31)]
Number = Annotated[int, Field(ge=1, le=2**31)]
Seconds = Annotated[float, Field(ge=0, le=LONGEST_S)]


_YEARS = range(1900, 7000)
"""Beyond them, moving a moment could leave what a `datetime` can hold."""


def _with_zone(text: str) -> str:
    moment = datetime.fromisoformat(text)
    if moment.tzinfo is None:
        raise ValueError("should say its time zone")
    if moment.year not in _YEARS:
        raise ValueError(f"should lie between the years {_YEARS[0]} and {_YEARS[-1]}")
    return text


Moment = Annotated[str, AfterValidator(_with_zone)]
"""ISO 8601, with its offset from UTC."""


class _Part(BaseModel):
    """Strict, so that "1" is no number; what another version adds is kept as it is."""

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)


class _File(_Part):
    """A whole file; without a version, it is of the first."""

    schema_version: Number = 1


class ProtocolText(_Part):
    """The protocol as it was."""

    name: str
    sha256: str
    file: str | None = None
    text: str = ""


class HeadsetFacts(_Part):
    """What a headset says of itself; nothing before the first exposure."""

    name: str = ""
    refresh_hz: Annotated[float, Field(ge=0, le=10_000)] = 0.0
    image_size_px: Annotated[list[Number], Field(min_length=2, max_length=2)] = [1, 1]


class UnderWay(_Part):
    """The exposure that had begun and not ended: the beginning of a row of ``trials.csv``."""

    model_config = ConfigDict(extra="forbid")

    participant: str
    session: Number
    period: Number
    block: Number
    trial: Number
    condition: str
    scene: str
    start_s: Seconds
    attempt: Number
    resumed: Literal[0, 1]


class ExposureEnded(_Part):
    """The trial that ended last, and when."""

    trial: Number
    at: Moment


class WithdrawalUndone(_Part):
    """A withdrawal that was taken back; trial and attempt are None where none was cut short."""

    at: Moment
    reason: str
    trial: Number | None
    attempt: Number | None


class EarlierRun(_Part):
    """What a run that was interrupted said of itself."""

    started_at: Moment | None = None
    finished_at: Moment | None = None
    headset: HeadsetFacts = HeadsetFacts()
    clock_set_back: list[str] = []


class WordingUsed(_Part):
    """The language in which an instrument was asked."""

    instrument: str
    language: str


class _Named(_Part):
    name: str


class _View(_Named):
    scene: str


class _Adjustment(_Named):
    range: Annotated[list[float], Field(min_length=2, max_length=2)]


class _Trial(_Part):
    condition: str


class _Sequence(_Part):
    sessions: list[list[_Trial]]


class _Order(_Part):
    rule: str
    sequences: list[_Sequence] = []


class _OrderOfPart(_Part):
    group: str | None = None
    trials: list[_Trial]


class _PartOfStudy(_Part):
    orders: list[_OrderOfPart] = []
    repeats: Number = 1


class _Ask(_Part):
    instrument: str
    timepoint: str
    when: str


class _Consent(_Part):
    version: str


class SettingsShape(_Part):
    """The protocol's settings, as far as they are read without a check of the whole protocol.

    A protocol of another version may not pass that check, and its sessions are reported all the
    same.
    """

    participants: Count | None = None
    scenes: list[str] = []
    views: list[_View] = []
    conditions: list[_Named] = []
    order: _Order | None = None
    parts: list[_PartOfStudy] = []
    groups: list[_Named] = []
    practice: list[_Named] = []
    adjustments: list[_Adjustment] = []
    questionnaires: list[_Ask] = []
    consent: _Consent | None = None
    photodiode: dict[str, Any] | None = None


class ManifestShape(_File):
    """The keys that a continuation, or a tool, relies on."""

    participant: str
    session: Number
    sequence: str
    status: Literal["running", "completed", "ended", "withdrawn", "aborted"]
    started_at: Moment
    finished_at: Moment | None = None
    seed: Annotated[int, Field(ge=0)]
    respondent: str
    language: Annotated[str, Field(min_length=2)] | None = None
    headset: HeadsetFacts = HeadsetFacts()
    ipd_measured_m: Annotated[float, Field(gt=0, lt=1)] | None = None
    exposure_s: Annotated[float, Field(gt=0, le=LONGEST_S)]
    exposure_override_s: Annotated[float, Field(gt=0, le=LONGEST_S)] | None = None
    clamps: list[str] = []
    timing_flags: list[str]
    clock_set_back: list[str] = []
    frames_not_recorded: Count = 0
    changed_while_recorded: list[str] = []
    gpu: str = ""
    driver: str = ""
    runtime: str = ""
    shaders: dict[str, str] = {}
    passes: dict[str, list[str]] = {}
    text_layout: dict[str, str] = {}
    timing_trust: str = ""
    versions: dict[str, str] = {}
    protocol: ProtocolText
    settings: SettingsShape = SettingsShape()
    wordings: list[WordingUsed] = []
    earlier_runs: list[EarlierRun] = []
    under_way: UnderWay | None = None
    exposure_ended: ExposureEnded | None = None
    missed_questions: list[str] = []
    withdrawals_undone: list[WithdrawalUndone] = []
    memory: dict[str, Any] | None = None
    ended: dict[str, str] | None = None
    eye_heights: list[dict[str, Any]] = []


class DescribedShape(_File):
    """What ``dataset_description.json`` may say, also that of an import or of another program."""

    name: str = ""
    citation: str = ""
    protocol: str = ""
    conditions: dict[str, str] = {}
    not_asked: dict[str, list[str]] = {}
    """Instrument → the items that an import's short form of it does not have."""


class DescriptionShape(DescribedShape):
    """The keys of ``dataset_description.json`` that a study goes on with."""

    protocol: str
    seed: Annotated[int, Field(ge=0)]
    readable_by: Literal["owner", "group"] = "owner"


class ImportShape(_File):
    """What an import's ``import.json`` is: an object, any keys."""
