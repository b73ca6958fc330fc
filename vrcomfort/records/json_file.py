"""JSON of a study's folder: its shapes, reading with the place of a fault, and writing."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.json_text import KeyPath, escape_surrogates, name_of, parse_json, place_of
from vrcomfort.records.schema import check_schema_version
from vrcomfort.settings import in_words

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
    """Strict, so that "1" is no number; keys of another version are kept as they are."""

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
    """Facts of a headset; none before the first exposure."""

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
    """The manifest's facts of an interrupted run."""

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


class _Condition(_Named):
    levels: dict[str, str] = {}
    """Crossed factor → its level; empty without factors."""


class _View(_Named):
    scene: str


class _Adjustment(_Named):
    range: Annotated[list[float], Field(min_length=2, max_length=2)]


class _Trial(_Part):
    condition: str


class TrialSequence(_Part):
    """An order of conditions, session after session."""

    sessions: list[list[_Trial]]


class _Order(_Part):
    rule: str
    unbalanced: bool = False
    sequences: list[TrialSequence] = []


class _OrderOfPart(_Part):
    group: str | None = None
    trials: list[_Trial]


class PartOfStudy(_Part):
    """A part with orders of its own."""

    orders: list[_OrderOfPart] = []
    repeats: Number = 1


class _Ask(_Part):
    instrument: str
    timepoint: str
    when: str
    sessions: list[int] = []
    trials: list[int] = []


def _each(found: object) -> object:
    return [found] if isinstance(found, dict) else found


class StopRuleOfRatings(_Part):
    """The ratings of an instrument, and the rule by which they end an exposure."""

    instrument: str
    stop_at: float | None = None
    stop_in_a_row: Number = 1


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
    conditions: list[_Condition] = []
    order: _Order | None = None
    parts: list[PartOfStudy] = []
    groups: list[_Named] = []
    practice: list[_Named] = []
    adjustments: list[_Adjustment] = []
    questionnaires: list[_Ask] = []
    ratings: Annotated[list[StopRuleOfRatings], BeforeValidator(_each)] = []
    """The first schema has a single table."""
    consent: _Consent | None = None
    photodiode: dict[str, Any] | None = None
    flag_above_percent: dict[str, float] = {}
    """State of seen time → the share above which an exposure is flagged."""


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
    stimulus_version: Count = 0
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
    preflight: dict[str, str] | None = None
    sees_sharp: str | None = None


class DescribedShape(_File):
    """``dataset_description.json`` of a study, of an import or of another program."""

    name: str = ""
    citation: str = ""
    protocol: str = ""
    conditions: dict[str, str] = {}
    levels: dict[str, dict[str, str]] = {}
    """Condition → factor → level, where the conditions are those of crossed factors."""
    not_asked: dict[str, list[str]] = {}
    """Instrument → the items that an import's short form of it does not have."""


class DescriptionShape(DescribedShape):
    """The keys of ``dataset_description.json`` that a study goes on with."""

    protocol: str
    seed: Annotated[int, Field(ge=0)]
    readable_by: Literal["owner", "group"] = "owner"


class ImportShape(_File):
    """``import.json`` of an import: an object with any keys."""


class CopyShape(_File):
    """``anonymised.json`` of an anonymous copy."""

    sessions_left_out: list[str] = []


class _Checked(_Part):
    part: str
    outcome: Literal["ok", "notice", "refuse"]
    found: str
    remedy: str = ""


class PreflightShape(_File):
    """``preflight.json`` of a study: the checks before people come."""

    at: Moment
    outcome: Literal["ok", "notice", "refuse"]
    protocol: ProtocolText
    headset: str
    rehearsed: bool = False
    apparatus: dict[str, str]
    findings: list[_Checked]
    timing: dict[str, Any] | None = None


_ENCODER = json.JSONEncoder(ensure_ascii=False)
Shape = TypeVar("Shape", bound=BaseModel)


def read_json(file: Path, model: type[BaseModel], what: str) -> dict[str, Any]:
    """Return the content of a file that has the shape of `model`; see `read_shape`."""
    content, _ = _read(file, model, what)
    return content if isinstance(content, dict) else {}


def read_shape(file: Path, model: type[Shape], what: str) -> Shape:
    """Return the content of a file as a `model`.

    Parameters
    ----------
    what
        The file in words: "manifest".

    Raises
    ------
    DamagedError
        If a value is missing or of another shape; numbers must be finite.
    InputError
        If it cannot be read, is no JSON, or a newer version of this program wrote it.
    """
    _, shape = _read(file, model, what)
    return shape


def _read(file: Path, model: type[Shape], what: str) -> tuple[Any, Shape]:
    text = read_text(file, what)
    content = parse_json(text, file, what=what)
    if isinstance(content, dict):
        check_schema_version(content, file)  # first: a newer one may well have another shape
    path, fault = ((), "") if _is_finite(content) else next(_endless(content), ((), ""))
    if not fault:
        try:
            return content, model.model_validate(content)
        except ValidationError as error:
            path, fault = _in_words(error.errors()[0])
    raise damaged(file, what, fault, text=text, path=path)


def indented(content: Mapping[str, Any]) -> str:
    """Return `json_of(content)`; parts that were written before take no time.

    A manifest is written a dozen times in a session, and most of it is what it was.
    """
    parts = (
        f"  {_key(key)}: {_indented(_ENCODER.encode(value))}" for key, value in content.items()
    )
    return escape_surrogates("{\n" + ",\n".join(parts) + "\n}")


@lru_cache(maxsize=256)
def _key(name: str) -> str:
    return _ENCODER.encode(name)


@lru_cache(maxsize=256)
def _indented(compact: str) -> str:
    """Return a value of a table, from its JSON in one line."""
    text = json.dumps(json.loads(compact), indent=2, ensure_ascii=False)
    return text.replace("\n", "\n  ")


class DamagedError(InputError):
    """JSON with a value that cannot be; `fault` says which and why."""

    fault = ""


def damaged(
    file: Path, what: str, fault: str, *, text: str = "", path: KeyPath = ()
) -> DamagedError:
    """Return the error for a value that cannot be, at `path` of `text`."""
    line, column = place_of(text, path) if text else (None, None)
    message = f"{fault}: this {what} is damaged; restore it"
    error = DamagedError(message, file=file, line=line, column=column)
    error.fault = fault
    return error


def _is_finite(content: Any) -> bool:
    """Return whether all numbers are: much faster than to walk through."""
    try:
        json.dumps(content, allow_nan=False)
    except ValueError:
        return False
    return True


def _endless(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, str]]:
    """Yield the numbers that Python reads and JSON does not have."""
    if isinstance(value, float) and not math.isfinite(value):
        yield path, f"{name_of(path)} is not a finite number"
    elif isinstance(value, dict | list):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _endless(each, (*path, key))


def _in_words(detail: ErrorDetails) -> tuple[KeyPath, str]:
    path = detail["loc"]
    if detail["type"] == "missing":
        return path[:-1], f"{name_of(path)} is missing"
    if detail["type"] in ("model_type", "model_attributes_type", "dict_type"):
        return path, f"{name_of(path)} should be an object {{...}}"
    return path, f"{name_of(path)}: {in_words(detail)}"
