"""What a manifest must look like to be gone on with."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

LONGEST_S = 1e8
"""Three years: no time of a session lies beyond."""

Count = Annotated[int, Field(ge=0, le=2**31)]
Number = Annotated[int, Field(ge=1, le=2**31)]
Seconds = Annotated[float, Field(ge=0, le=LONGEST_S)]


def _with_zone(text: str) -> str:
    if datetime.fromisoformat(text).tzinfo is None:
        raise ValueError("should say its time zone")
    return text


Moment = Annotated[str, AfterValidator(_with_zone)]
"""ISO 8601, with its offset from UTC."""


class _Part(BaseModel):
    """Strict, so that "1" is no number; what another version adds is kept as it is."""

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)


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
    trial: Number | None = None
    attempt: Number | None = None


class ManifestShape(_Part):
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
    timing_trust: str = ""
    versions: dict[str, str] = {}
    protocol: ProtocolText
    settings: dict[str, Any] = {}
    earlier_runs: list[dict[str, Any]] = []
    under_way: UnderWay | None = None
    exposure_ended: ExposureEnded | None = None
    missed_questions: list[str] = []
    withdrawals_undone: list[WithdrawalUndone] = []
    memory: dict[str, Any] | None = None
    ended: dict[str, str] | None = None
    eye_heights: list[dict[str, Any]] = []


class DescriptionShape(_Part):
    """The keys of ``dataset_description.json`` that a study goes on with."""

    protocol: str
    seed: Annotated[int, Field(ge=0)]
    readable_by: Literal["owner", "group"] = "owner"


class ImportShape(_Part):
    """What an import's ``dataset_description.json`` and ``import.json`` are: objects, any keys."""
