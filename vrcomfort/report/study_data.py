"""Reads a study: its questionnaires at any depth, and its other tables."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from vrcomfort.csv_table import CsvTable, number_in, number_or_none, whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import (
    FOLDER,
    Instrument,
    Sheet,
    find_instrument,
    guess,
    instruments_in,
    read_long,
    shipped_instruments,
    short_form,
)
from vrcomfort.recordings import (
    KEYS_OF_RATINGS,
    ExposureFrames,
    RatingSeries,
    frame_measures,
    joined,
    read_ratings,
    series_of,
    usual_interval_s,
)
from vrcomfort.records.choice import SessionName
from vrcomfort.records.exposure_rows import DialRow, RatingRow, TaskRow, TimingRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.json_file import (
    DamagedError,
    DescribedShape,
    ManifestShape,
    Shape,
    StopRuleOfRatings,
    read_shape,
)
from vrcomfort.records.names import natural
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.recording import Memory
from vrcomfort.records.rows import Row
from vrcomfort.records.session_rows import ParticipantRow, QuestionnaireRow, ScreeningRow
from vrcomfort.records.study import DESCRIPTION, ERASED
from vrcomfort.report.gaps import gaps, unreadable
from vrcomfort.seen_time import SEEN, SeenState
from vrcomfort.workers import workers

_KEYS = (
    "participant", "session", "period", "trial", "condition", "scene", "sequence", "timepoint",
    "group", "part",
)  # fmt: skip
NEEDED = ("participant", "item", "response")
SIMULATED = "simulated"
"""The respondent of a simulated participant's sessions."""
_NEEDED_ELSEWHERE: Mapping[type[Row], tuple[str, ...]] = {
    ParticipantRow: ("participant",),
    TrialRow: ("participant", "session", "trial", "condition", "scene", "status"),
    TaskRow: ("participant",),
    ScreeningRow: ("participant", "rule", "decision"),
    DialRow: ("participant", "dial", "kind", "value"),
    TimingRow: ("participant", "session", "condition"),
}
_INSTEAD = (TaskRow, DialRow, RatingRow, ParticipantRow)
"""What a study may have instead of questionnaires."""
_NUMBERS = (
    "start_s", "end_s", "frames", "dropped", "missed", "missed_refreshes",
    *(state.column for state in SeenState),
)  # fmt: skip


FEWEST_WHOLE = 2
"""People with an answer to every other item, from whom on a missing item is a design."""
_CUT_SHORT = frozenset(["withdrawn", "stopped", "skipped", "aborted"])
_WHOLE = frozenset(["", "task", "adjustment"])
"""What may have ended an exposure that was done."""


@dataclass(frozen=True)
class StudyData:
    """Everything a report is made from."""

    title: str
    protocol: str | None
    labels: dict[str, str]
    """Condition → label, in the protocol's order; empty without a study description."""
    imported_levels: dict[str, dict[str, str]]
    """Condition → factor → level, as an import says it."""
    instruments: Mapping[str, Instrument]
    """Name → shipped instruments, and those of the study's own."""
    sheets: tuple[Sheet, ...]
    participants: tuple[dict[str, str], ...]
    trials: tuple[dict[str, str], ...]
    ratings: tuple[RatingSeries, ...]
    manifests: tuple[ManifestShape, ...]
    files: int
    warnings: tuple[str, ...]
    frames: tuple[ExposureFrames, ...] = ()
    """What the frames of each attempt at an exposure say; see `with_frames`."""
    tasks: tuple[dict[str, str], ...] = ()
    """Rows of tasks.csv: participant, trial or condition, and numbers."""
    screening: tuple[dict[str, str], ...] = ()
    """Rows of screening.csv."""
    dials: tuple[dict[str, str], ...] = ()
    """Rows of dials.csv."""
    timing: tuple[dict[str, str], ...] = ()
    """Rows of timing.csv."""
    folder: Study = field(default_factory=lambda: Study("."))
    """What was read."""

    @property
    def source(self) -> Path:
        """Return the folder, or file, that was read."""
        return self.folder.folder

    @cached_property
    def rating_intervals_s(self) -> dict[str, float]:
        """Return instrument → the interval at which its ratings come, where they are regular."""
        found = {
            name: usual_interval_s(each for each in self.ratings if each.instrument == name)
            for name in {each.instrument for each in self.ratings}
        }
        return {name: usual for name, usual in found.items() if usual is not None}

    @property
    def recorded_sessions(self) -> list[Session]:
        """Return the sessions with recorded frames, in the order of their paths."""
        return [Session(file.parent) for file in sorted(self.folder.files(FrameRow))]

    @property
    def planned_participants(self) -> int | None:
        """Return how many participants the protocol plans, where a session's manifest says so."""
        for manifest in reversed(self.manifests):
            if planned := manifest.settings.participants:
                return planned
        return None

    @property
    def levels(self) -> dict[str, dict[str, str]]:
        """Return condition → crossed factor → level, as the last session's protocol has them.

        Or as the import says them.
        """
        for manifest in reversed(self.manifests):
            if manifest.settings.conditions:
                return {each.name: each.levels for each in manifest.settings.conditions}
        return self.imported_levels

    def stop_rule(self, instrument: str) -> StopRuleOfRatings | None:
        """Return the rule by which ratings end exposures, as the last session's protocol has it."""
        for manifest in reversed(self.manifests):
            for each in manifest.settings.ratings:
                if each.instrument == instrument and each.stop_at is not None:
                    return each
        return None

    def instruments_at(self, timepoint: str) -> tuple[str, ...]:
        """Return the instruments asked at a timepoint, those with most questionnaires first."""
        counts = Counter(s.keys["instrument"] for s in self.sheets if s.timepoint == timepoint)
        return tuple(name for name, _ in counts.most_common())

    def between(self, column: str) -> dict[str, str]:
        """Return participant → value of a column, where it is unique.

        The column may be one of participants.csv or, as `sequence`, of the questionnaires.
        """
        found: dict[str, set[str]] = defaultdict(set)
        for person in self.participants:
            found[person["participant"]].add(person.get(column, ""))
        for sheet in self.sheets:
            found[sheet.participant].add(sheet.keys.get(column, ""))
        values = {who: those - {""} for who, those in found.items()}
        return {who: next(iter(those)) for who, those in values.items() if len(those) == 1}


def short_forms(study: StudyData) -> list[Instrument]:
    """Return the instruments that were answered without some of their items, by design."""
    answered = dict.fromkeys(sheet.keys["instrument"] for sheet in study.sheets)
    return [study.instruments[name] for name in answered if study.instruments[name].not_asked]


def conditions_in(study: StudyData, timepoint: str) -> list[str]:
    """Return the conditions asked about at a timepoint, in the protocol's order."""
    order = {name: place for place, name in enumerate(study.labels)}
    found = {sheet.condition for sheet in study.sheets if sheet.timepoint == timepoint} - {""}
    return sorted(found, key=lambda name: (order.get(name, len(order)), natural(name)))


def read_study(
    source: Path, instrument: str | None = None, without: Collection[SessionName] = ()
) -> StudyData:
    """Read a study folder, any folder with ``questionnaires.csv`` in it, or one such file.

    Parameters
    ----------
    instrument
        The name or the file of the only instrument to read; what rows without one are answers to.
    without
        Sessions that are passed over.

    Raises
    ------
    InputError
        If there is no questionnaire, or a table is wrong, with file, line and column.
    """
    warnings = unreadable(source) if source.is_dir() else []
    folder = Study(source, without=without)
    files = folder.files(QuestionnaireRow)
    if not files and not any(map(folder.files, _INSTEAD)):
        raise InputError("there is no questionnaires.csv in this folder", file=source)
    if source.is_file() and not source.stat().st_size:
        raise InputError("this file is empty", file=source)
    description = _description(source, warnings)
    known = _known_instruments(source)
    only = None if instrument is None else find_instrument(instrument, known=known)
    if only is not None:
        known[only.name] = only
    known = _as_asked(known, description.not_asked if description else {})
    only = None if only is None else known[only.name]
    sheets = [
        sheet
        for table in _tables(folder, QuestionnaireRow, warnings)
        for sheet in _sheets(table, source, known, only, warnings)
    ]
    known = _as_asked(known, _never_asked(sheets, known))
    if not sheets and only is not None:
        raise InputError(f"this table has no answers to the {only.short}", file=source)
    instead = (_table(folder, each, []) for each in (TaskRow, DialRow))
    if files and not sheets and not any(instead):
        raise InputError("this table has no answers to a known questionnaire", file=source)
    participants = _table(folder, ParticipantRow, warnings)
    manifests = _manifests(folder, warnings)
    warnings += gaps(source, description, participants, manifests, without)
    dials = _of_last_attempts(_table(folder, DialRow, warnings))
    return StudyData(
        title=(description.name if description else "") or source.resolve().name,
        protocol=_protocol(description),
        labels=description.conditions if description else {},
        imported_levels=description.levels if description else {},
        instruments=known,
        sheets=tuple(sorted(sheets, key=lambda s: natural(s.participant))),
        participants=participants,
        trials=_last_attempts(_table(folder, TrialRow, warnings)),
        ratings=joined([*_ratings(folder, warnings), *series_of(_slid(dials))]),
        manifests=manifests,
        files=len(files),
        warnings=tuple(warnings),
        tasks=_of_last_attempts(_table(folder, TaskRow, warnings)),
        dials=dials,
        timing=_of_last_attempts(_table(folder, TimingRow, [])),
        screening=_table(folder, ScreeningRow, warnings),
        folder=folder,
    )


def people_of(study: StudyData) -> set[str]:
    """Return every participant that any file names."""
    rows = (*study.participants, *study.trials, *study.tasks, *study.dials)
    named = {row.get("participant", "") for row in rows}
    named |= {each.participant for each in study.ratings}
    return {sheet.participant for sheet in study.sheets} | (named - {""})


def of_one_kind(study: StudyData, *, simulated: bool) -> StudyData:
    """Keep the simulated participants of a study, or everybody else; say so where it had both.

    Raises
    ------
    InputError
        If the study has none of that kind.
    """
    kinds = {each.participant: each.respondent == SIMULATED for each in study.manifests}
    everybody = people_of(study)
    kept = {name for name in everybody if kinds.get(name, False) == simulated}
    what = "simulated" if simulated else "real"
    if not kept:
        raise InputError(f"this study has no {what} participants")
    left = len(everybody - kept)
    if not left:
        return study
    other = "real" if simulated else "simulated"
    note = f"this study has {len(kept)} {what} and {left} {other} participants; only the {what} are"
    hint = "leave --simulated out" if simulated else "give --simulated"

    def of_them(rows: tuple[dict[str, str], ...]) -> tuple[dict[str, str], ...]:
        return tuple(r for r in rows if kinds.get(r.get("participant", ""), False) == simulated)

    return replace(
        study,
        sheets=tuple(sheet for sheet in study.sheets if sheet.participant in kept),
        participants=of_them(study.participants),
        trials=of_them(study.trials),
        ratings=tuple(each for each in study.ratings if each.participant in kept),
        manifests=tuple(each for each in study.manifests if kinds[each.participant] == simulated),
        tasks=of_them(study.tasks),
        dials=of_them(study.dials),
        timing=of_them(study.timing),
        screening=of_them(study.screening),
        warnings=(*study.warnings, f"{note} in this report; for the others {hint}"),
    )


def with_frames(
    study: StudyData, *, memory: Memory | None = None, cluster: str | None = None
) -> StudyData:
    """Return a study with the sums over the frames of its exposures, and notes on those not read.

    Parameters
    ----------
    memory
        The most that reading frames may take.
    cluster
        Address of a running Dask scheduler, whose workers read instead of this process.

    Raises
    ------
    InputError
        If no scheduler answers, or its workers do not see the study.
    """
    files = study.folder.files(FrameRow)
    if not files:
        return study
    with workers(1, cluster) as work:
        frames, notes = frame_measures(files, memory, work)
    people = {trial["participant"] for trial in study.trials}
    notes = [note.replace(f"{study.source}/", "") for note in notes]
    return replace(
        study,
        frames=tuple(each for each in frames if each.participant in people),
        warnings=(*study.warnings, *notes),
    )


def trial_s(trial: Mapping[str, str]) -> float | None:
    """Return how long a trial's stimulus was seen, or (not recorded) its length."""
    seen = seen_s(trial)
    return length_s(trial) if seen is None else seen


def seen_s(trial: Mapping[str, str]) -> float | None:
    """Return the seconds in which a trial's stimulus was seen; None where they were not recorded.

    Before version 5 of the schema these are the live ones alone.
    """
    whole = bool(trial.get(SeenState.OFF.column))
    states = SEEN if whole else (SeenState.LIVE,)
    seconds = [number_or_none(trial.get(state.column) or "") for state in states]
    return None if seconds[-1] is None else math.fsum(each or 0.0 for each in seconds)


def length_s(trial: Mapping[str, str]) -> float | None:
    """Return a trial's length, from its start to its end."""
    start, end = (number_or_none(trial.get(name) or "") for name in ("start_s", "end_s"))
    return None if start is None or end is None else end - start


def undone_attempts(study: StudyData) -> set[tuple[str, ...]]:
    """Return the attempts that ended in a withdrawal which an operator undid."""
    return {
        (of.participant, str(of.session), str(undone.trial), str(undone.attempt))
        for of in study.manifests
        for undone in of.withdrawals_undone
    }


def cut_short(trial: Mapping[str, str]) -> bool:
    """Return whether an exposure ended early, with less time for tasks and ratings.

    One that a task or a confirmed adjustment ended was whole.
    """
    ended_by = trial.get("abort_code", "")
    return trial["status"] in _CUT_SHORT or ended_by not in _WHOLE


def _tables(folder: Study, row_type: type[Row], warnings: list[str]) -> Iterator[CsvTable]:
    """Yield the tables of a name; half-written rows are reported."""
    source = folder.folder
    prefix = f"{source}/" if source.is_dir() else f"{source.parent}/"
    for found in folder.tables(row_type):
        warnings.extend(warning.removeprefix(prefix) for warning in found.warnings)
        yield found


def _table(folder: Study, row_type: type[Row], warnings: list[str]) -> tuple[dict[str, str], ...]:
    """Read an optional table of a study; foreign files of that name are reported and ignored."""
    rows: list[dict[str, str]] = []
    columns = ("participant", "status") if row_type is ParticipantRow else row_type.columns()
    for found in _tables(folder, row_type, warnings):
        missing = [name for name in _NEEDED_ELSEWHERE[row_type] if name not in found.header]
        if missing and found.header:
            place = found.file.relative_to(folder.folder)
            warnings.append(f"{place}: not used, because it has no column {missing[0]}")
        else:
            found.require_numbers(_NUMBERS)
            rows += ({**dict.fromkeys(columns, ""), **row} for row in found.dicts())
    if row_type is ParticipantRow:
        rows = [row for row in rows if row.get("status") != ERASED]
        _require_each_once(folder.folder, rows)
    return tuple(rows)


def _require_each_once(source: Path, rows: list[dict[str, str]]) -> None:
    """Raise `InputError` where a participant has two statuses: either may be wrong."""
    known: dict[str, str] = {}
    for row in rows:
        who, status = row["participant"], row.get("status", "")
        if known.setdefault(who, status) != status:
            message = f"participants.csv has {who} twice, as `{known[who]}` and as `{status}`"
            raise InputError(f"{message}; leave one", file=source)


def _last_attempts(trials: tuple[dict[str, str], ...]) -> tuple[dict[str, str], ...]:
    """Drop attempts that were repeated later; a table without attempts stays as it is."""
    if not all(trial["attempt"] for trial in trials):
        return trials
    last = {(trial["participant"], trial["session"], trial["trial"]): trial for trial in trials}
    return tuple(last.values())


def _of_last_attempts(rows: tuple[dict[str, str], ...]) -> tuple[dict[str, str], ...]:
    """Leave out rows of attempts at a trial that was begun again later."""
    if not all(row["attempt"] for row in rows):
        return rows
    last: dict[tuple[str, ...], int] = {}
    for row in rows:
        key = tuple(row.get(name, "") for name in ("participant", "session", "trial"))
        attempt = whole_or_none(row["attempt"]) or 0
        last[key] = max(attempt, last.get(key, 0))
    return tuple(
        row
        for row in rows
        if (whole_or_none(row["attempt"]) or 0)
        == last[tuple(row.get(name, "") for name in ("participant", "session", "trial"))]
    )


def _ratings(folder: Study, warnings: list[str]) -> tuple[RatingSeries, ...]:
    """Read the ratings of a study; unread rows are reported."""
    read = read_ratings(folder.files(RatingRow))
    warnings += [note.removeprefix(f"{folder.folder}/") for note in read.notes]
    return read.series


def _slid(dials: Iterable[dict[str, str]]) -> Iterator[tuple[tuple[str, ...], float, float]]:
    """Yield the samples of sliders, as ratings that came at once: key, onset and value."""
    for row in dials:
        if row["kind"] == "sample" and row.get("instrument"):
            onset_s, value = (_sample(row, name) for name in ("onset_s", "value"))
            yield tuple(row.get(name, "") for name in KEYS_OF_RATINGS), onset_s, value


def _sample(row: Mapping[str, str], name: str) -> float:
    """Return a number of a sample; NaN of a blank value.

    Raises
    ------
    InputError
        If it is none, or a time is blank.
    """
    text = row.get(name) or ""
    try:
        found = number_in(text, words=True)
    except ValueError:
        message = f"`{name}` of {row['participant']} is `{text}` in dials.csv; give a number"
        raise InputError(message) from None
    if found is None and name == "onset_s":
        raise InputError(f"a sample of {row['participant']} in dials.csv has no onset_s")
    return math.nan if found is None else found


def _stored(
    file: Path, model: type[Shape], what: str, source: Path, warnings: list[str]
) -> Shape | None:
    """Read JSON of a study; values of another shape are reported with their place, and not used.

    Raises
    ------
    InputError
        If it is no JSON, or a newer version of this program wrote it.
    """
    try:
        return read_shape(file, model, what)
    except DamagedError as error:
        place = f"{file.relative_to(source).as_posix()}, line {error.line}"
        warnings.append(f"{place}: not used, because it is no whole {what}: {error.fault}")
        return None


def _description(source: Path, warnings: list[str]) -> DescribedShape | None:
    """Read the description of a study, an import or another dataset; None without one."""
    file = source / DESCRIPTION
    if not file.is_file():
        return None
    return _stored(file, DescribedShape, "study description", source, warnings)


def _protocol(description: DescribedShape | None) -> str | None:
    """Return the protocol that a description names; one without the key has none."""
    named = description is not None and "protocol" in description.model_fields_set
    return description.protocol if description and named else None


def _manifests(study: Study, warnings: list[str]) -> tuple[ManifestShape, ...]:
    source = study.folder
    files = study.at_any_depth("manifest.json") if source.is_dir() else []
    found = (_stored(file, ManifestShape, "manifest", source, warnings) for file in files)
    return tuple(content for content in found if content is not None)


def _known_instruments(source: Path) -> dict[str, Instrument]:
    """Return the shipped instruments and those that lie in folders ``instruments`` of the study."""
    folder = source if source.is_dir() else source.parent
    files = folder.rglob(f"{FOLDER}/*.toml") if source.is_dir() else folder.glob(f"{FOLDER}/*.toml")
    own = instruments_in(sorted({file.parent.parent for file in files}))
    return {**shipped_instruments(), **own}


def _as_asked(
    known: dict[str, Instrument], not_asked: Mapping[str, list[str]]
) -> dict[str, Instrument]:
    """Return the instruments, short forms of those of which a study left out items by design."""
    return {
        name: short_form(each, not_asked[name]) if name in not_asked else each
        for name, each in known.items()
    }


def _never_asked(sheets: Iterable[Sheet], known: Mapping[str, Instrument]) -> dict[str, list[str]]:
    """Return the items of each instrument that no questionnaire has, where that is its design.

    It is one where all questionnaires lack the same few items, or all but a subscale's, and most
    have an answer to every other one: what a session that was cut short lacks is missing.
    """
    by_name: dict[str, list[Sheet]] = defaultdict(list)
    for sheet in sheets:
        by_name[sheet.keys["instrument"]].append(sheet)
    found = {}
    for name, mine in by_name.items():
        there = {item for sheet in mine for item in sheet.answers}
        needed = [item.name for item in known[name].asked]
        asked = [item for item in needed if item in there]
        whole = [s for s in mine if all(s.answers.get(item) is not None for item in asked)]
        several = len({sheet.participant for sheet in whole}) >= FEWEST_WHOLE
        subscales = [{term.item for term in scale.terms} for scale in known[name].scales]
        enough = 2 * len(asked) >= len(needed) or any(each and each <= there for each in subscales)
        most = len(whole) > len(mine) / 2 and enough
        if len(asked) < len(needed) and several and most:
            lost = [item for item in needed if item not in there]
            found[name] = [*known[name].not_asked, *lost]
    return found


def _sheets(
    found: CsvTable,
    source: Path,
    known: Mapping[str, Instrument],
    only: Instrument | None,
    warnings: list[str],
) -> list[Sheet]:
    if found.header:
        found.require(NEEDED)
        if len(_values(found, "timepoint")) < 2:  # else timepoints can be compared
            found.require(("condition",))
    name = found.file.relative_to(source).as_posix() if source.is_dir() else found.file.name
    sheets = []
    guessed = only or _of_the_items(found, known)
    for instrument in _instruments(found, name, known, guessed, warnings):
        if only is not None and instrument.name != only.name:
            continue
        nameless = guessed is not None and guessed.name == instrument.name
        for sheet in read_long(found, instrument, _KEYS, nameless=nameless):
            if not sheet.participant:
                raise found.fault("a participant is missing", sheet.line, "participant")
            sheet.keys["timepoint"] = sheet.timepoint or "post"
            sheet.keys["instrument"] = instrument.name
            sheet.place = f"{name}, line {sheet.line}"
            sheets.append(sheet)
    return sorted(sheets, key=lambda sheet: sheet.line)


def _values(found: CsvTable, column: str) -> set[str]:
    """Return the different cells of a column that is there, without blank ones."""
    if column not in found.header:
        return set()
    place = found.header.index(column)
    return {row[place] for row in found.rows} - {""}


def _instruments(
    found: CsvTable,
    name: str,
    known: Mapping[str, Instrument],
    guessed: Instrument | None,
    warnings: list[str],
) -> list[Instrument]:
    """Return the instruments of a table; answers of others are told and not used."""
    columns = {heading.lower(): place for place, heading in enumerate(found.header)}
    if not found.rows:
        return []
    place = columns.get("instrument")
    cells = Counter("" if place is None else row[place] for row in found.rows)
    named: Counter[str] = Counter()
    for cell, count in cells.items():
        named[cell.strip().lower()] += count
    if blank := named.pop("", 0):
        if guessed is None:
            message = "the items are of no instrument that is known, or of several"
            hint = "name it in a column `instrument`, or give --instrument"
            raise found.fault(f"{message}; {hint}", found.lines[0], "item")
        named[guessed.name] += blank
    warnings += [
        f"{name}: {named[other]} answers of `{other}` are not used: known are "
        f"{', '.join(known)}; give the file of yours as --instrument"
        for other in sorted(named.keys() - known.keys())
    ]
    return [each for each in known.values() if each.name in named]


def _of_the_items(found: CsvTable, known: Mapping[str, Instrument]) -> Instrument | None:
    """Return the instrument that rows without a name are of, by their items."""
    columns = {heading.lower(): place for place, heading in enumerate(found.header)}
    if not found.rows:
        return None
    item, instrument = columns["item"], columns.get("instrument")
    items = {row[item] for row in found.rows if instrument is None or not row[instrument].strip()}
    return guess(sorted(items), known) if items else None
