"""Sums over the frames of each exposure, read out of core: the same from CSV and from Parquet.

Lengths, angles and dioptres are added as whole steps of 10⁻⁹ m and 10⁻¹² rad or dioptre, so that a
sum does not hang on the order, on threads or on machines.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

import duckdb

from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.frame import DROPPED_INTERVAL_PERIODS
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.frame_rows import CUT
from vrcomfort.records.reader import Session
from vrcomfort.records.recording import Kind, Memory, Recording, damage_of, kinds
from vrcomfort.seen_time import FREEZE_S, UNSEEN, SeenState

_LENGTH, _ANGLE = 1e9, 1e12
"""Steps in a metre; in a radian and in a dioptre."""
_ROUNDING_S = 1e-6
"""Of session times in files."""

_OPTIONAL: dict[str, Kind] = kinds((
    "should_render", "head_valid", "head_tracked", "session_state", "missed_refreshes", "focus_m",
    "focus_raw_m", "max_blur_px", "avatar_x_m", "avatar_y_m", "avatar_z_m", "user_present",
    "paused",
))  # fmt: skip
"""What a recording may lack, or leave blank."""
# Without a blank in any row: a sum over blanks alone would be none.
_PLAIN = ("session_s", "xr_time_ns", "period_ns", "trial", "dropped", "discontinuity")
_HEAD = ("head_x_m", "head_y_m", "head_z_m", "head_qx", "head_qy", "head_qz", "head_qw")
_BEFORE = (
    "session_s", "xr_time_ns", "period_ns", "trial", *_HEAD, "should_render", "head_valid",
    "head_tracked", "session_state", "user_present", "paused", "focus_m", "max_blur_px",
    "avatar_x_m", "avatar_y_m", "avatar_z_m",
)  # fmt: skip


@dataclass(frozen=True)
class ExposureFrames:
    """Sums over the frames of one attempt at an exposure; None where it was not recorded.

    Parameters
    ----------
    frames, dropped, missed_refreshes
        As in ``trials.csv``.
    live_s, frozen_s, hidden_s, unfocused_s, untracked_s, off_s, not_drawn_s, half_rate_s
        As in ``trials.csv``, but for what no frame tells of. In recordings before version 5 of the
        schema `untracked_s` are the periods of all frames whose head pose was not measured, and the
        last three are not told apart; a gap after which no frame counts as dropped was hidden.
    head_path_m
        Way of the head in the stage: the sum of its steps between seen frames, without cuts, and
        without frames in which its pose was not known.
    head_turning_deg
        Sum of the angles between the head's orientations, over the same frames.
    avatar_path_m
        Way of the avatar in the world, over the same frames.
    focus_travel_dioptre
        Sum of the changes of 1 / focus distance between seen frames.
    focus_lag_dioptre
        Mean distance, in dioptres, of seen frames' focus after and before the refocus law.
    blur_changes
        Seen frames whose largest blur radius (`max_blur_px`) is not that of the frame before.
    """

    participant: str
    session: str
    trial: int
    attempt: int
    frames: int
    dropped: int
    missed_refreshes: int | None
    live_s: float
    frozen_s: float
    hidden_s: float
    unfocused_s: float
    untracked_s: float | None
    off_s: float | None
    not_drawn_s: float | None
    half_rate_s: float | None
    head_path_m: float | None
    head_turning_deg: float | None
    avatar_path_m: float | None
    focus_travel_dioptre: float | None
    focus_lag_dioptre: float | None
    blur_changes: int | None

    @property
    def seen_s(self) -> float:
        """Return the time in which the stimulus was seen; before version 5 the live time alone."""
        if self.half_rate_s is None:
            return self.live_s
        return self.live_s + self.unfocused_s + self.half_rate_s + (self.untracked_s or 0.0)


@dataclass(frozen=True)
class MeasuredSession:
    """The exposures of one session, with a sentence for each file that was not read."""

    exposures: tuple[ExposureFrames, ...]
    notes: tuple[str, ...] = ()


def frame_measures(
    files: Iterable[Path],
    memory: Memory | None = None,
    work: Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]] = map,
) -> tuple[list[ExposureFrames], list[str]]:
    """Sum the frames of each exposure of some sessions.

    Parameters
    ----------
    files
        ``frames.csv`` files. What lies beside no ``trials.csv`` is no session and is left alone.
    memory
        The most that a process may take; 512 MB without it.
    work
        Calls a function for every file: `map`, or that of `vrcomfort.workers`, whose machines see
        the same files.

    Returns
    -------
    exposures, notes
        By participant, session, trial and attempt; and, a sentence each, what was not read: a
        Parquet file that is not of its CSV, a recording that is damaged.
    """
    parts = list(work(partial(measure, memory or Memory()), sorted(set(files))))
    exposures = sorted(
        (each for part in parts for each in part.exposures),
        key=lambda each: (each.participant, each.session, each.trial, each.attempt),
    )
    return exposures, sorted(note for part in parts for note in part.notes)


def measure(memory: Memory, csv: Path) -> MeasuredSession:
    """Sum the frames of the exposures of one session, with a note on a damaged recording.

    Raises
    ------
    InputError
        If this machine does not see the file.
    """
    if not csv.is_file():
        message = "is not seen by the cluster's workers; put the study where all machines see it"
        raise InputError(message, file=csv)
    try:
        attempts = _attempts(Session(csv.parent).table(TrialRow))
        if not attempts:
            return MeasuredSession(())
        recording = Recording.find(csv)
        notes = (recording.note,) if recording.note else ()
        try:
            found = _summed(recording, attempts, memory)
        except InputError as error:
            if recording.parquet is None:
                raise
            notes = (f"{error}; {csv.name} is read",)
            found = _summed(replace(recording, parquet=None), attempts, memory)
    except InputError as error:
        return MeasuredSession((), (f"{error}; nothing of these frames is reported",))
    return MeasuredSession(found, notes)


@dataclass(frozen=True)
class _Attempt:
    """One attempt at an exposure, and which of the trial's frames are its own, by session time."""

    participant: str
    session: str
    trial: int
    attempt: int
    from_s: float
    until_s: float


def _attempts(table: CsvTable) -> list[_Attempt]:
    """Return the attempts of a session; none where this is no session.

    Where an exposure was begun again, its attempts are told apart in the middle between them.
    """
    needed = ("participant", "session", "trial", "start_s", "end_s")
    if not set(needed) <= set(table.header):
        return []
    there = "attempt" in table.header
    attempts = table.whole_numbers("attempt", blank=1) if there else [1] * len(table.rows)
    numbers, starts_s = table.whole_numbers("trial"), table.numbers("start_s")
    rows = zip(numbers, starts_s, table.numbers("end_s"), attempts, table.dicts(), strict=True)
    found: list[_Attempt] = []
    for trial, start_s, end_s, attempt, row in sorted(rows, key=itemgetter(0, 1)):
        from_s = start_s - _ROUNDING_S
        if found and found[-1].trial == trial:
            from_s = (found[-1].until_s + start_s) / 2
            found[-1] = replace(found[-1], until_s=from_s)
        who, session = row["participant"], row["session"]
        found.append(_Attempt(who, session, trial, attempt, from_s, end_s))
    last = {each.trial: place for place, each in enumerate(found)}
    for place in last.values():
        found[place] = replace(found[place], until_s=math.inf)
    return found


def _summed(
    recording: Recording, attempts: Sequence[_Attempt], memory: Memory
) -> tuple[ExposureFrames, ...]:
    """Read a recording once and sum its frames by attempt.

    Raises
    ------
    InputError
        If it is damaged, with its place.
    """
    with (
        recording.told_with_its_place(),
        memory.database() as database,
        recording.table() as (table, columns),
    ):
        database.execute(
            "CREATE TABLE attempts (number INT, trial BIGINT, from_s DOUBLE, until_s DOUBLE)"
        )
        database.executemany(
            "INSERT INTO attempts VALUES (?, ?, ?, ?)",
            [(i, each.trial, each.from_s, each.until_s) for i, each in enumerate(attempts)],
        )
        found = _rows(database, _query(table, columns))
    if any(row["wrong"] for row in found):
        raise damage_of(recording.csv, "a number is missing or not finite, or time goes back")
    return tuple(_exposure(attempts[row["number"]], row) for row in found)


def _rows(database: duckdb.DuckDBPyConnection, query: str) -> list[dict[str, Any]]:
    answer = database.execute(query)
    names = [each[0] for each in answer.description or ()]
    return [dict(zip(names, row, strict=True)) for row in answer.fetchall()]


def _exposure(attempt: _Attempt, row: dict[str, Any]) -> ExposureFrames:
    def scaled(name: str, steps: float) -> float | None:
        return None if row[name] is None else row[name] / steps

    degrees, both = 180 / math.pi, row["focused"]
    return ExposureFrames(
        participant=attempt.participant,
        session=attempt.session,
        trial=attempt.trial,
        attempt=attempt.attempt,
        frames=row["frames"],
        dropped=int(row["dropped"]),
        missed_refreshes=None if row["missed"] is None else int(row["missed"]),
        live_s=row["live"] / 1e9,
        frozen_s=row["frozen"] / 1e9,
        hidden_s=row["hidden"] / 1e9,
        unfocused_s=row["unfocused"] / 1e9,
        untracked_s=scaled("untracked", 1e9),
        off_s=scaled("off", 1e9),
        not_drawn_s=scaled("not_drawn", 1e9),
        half_rate_s=scaled("half_rate", 1e9),
        head_path_m=scaled("head_path", _LENGTH),
        head_turning_deg=scaled("turning", _ANGLE / degrees),
        avatar_path_m=scaled("avatar_path", _LENGTH),
        focus_travel_dioptre=scaled("focus_change", _ANGLE),
        focus_lag_dioptre=row["focus_lag"] / _ANGLE / both if both else None,
        blur_changes=None if row["blur_changes"] is None else int(row["blur_changes"]),
    )


def _query(table: str, columns: dict[str, Kind]) -> str:
    """Return the aggregation in SQL: three steps over the rows, in their order, each read once.

    `lag() OVER ()` streams. Windows by trial, sorted by time, would put all rows on the disk.
    """
    absent = [
        f"CAST(NULL AS {kind}) AS {name}" for name, kind in _OPTIONAL.items() if name not in columns
    ]
    there = [*_PLAIN, *_HEAD, *(name for name in _OPTIONAL if name in columns)]
    read = f"SELECT {', '.join([*there, *absent])} FROM {table}"  # noqa: S608
    lags = ", ".join(f"lag({name}) OVER () AS {name}_before" for name in _BEFORE)
    pairs = f"SELECT *, {lags} FROM ({read})"  # noqa: S608
    steps = f"SELECT a.number, {_STEPS} FROM ({pairs}) f JOIN attempts a ON {_OF_ATTEMPT}"  # noqa: S608
    times, seconds = (_TIMES, _SECONDS) if "paused" in columns else (_TIMES_BEFORE_5, _BEFORE_5)
    sums = f"SELECT number, {_SUMS}, {seconds} FROM (SELECT *, {times} FROM ({steps}))"  # noqa: S608
    return f"{sums} GROUP BY number ORDER BY number"


_OF_ATTEMPT = "f.trial = a.trial AND f.session_s >= a.from_s AND f.session_s < a.until_s"


def _distance(name: str, steps: float) -> str:
    """Return SQL for the way between two frames, in whole steps."""
    squares = [f"({name}_{axis}_m - {name}_{axis}_m_before)" for axis in "xyz"]
    return _whole_steps(f"sqrt({' + '.join(f'{each} * {each}' for each in squares)})", steps)


def _turn() -> str:
    """Return SQL for the angle between two orientations, in whole steps.

    The half chord of two quaternions is the sine of a quarter of the angle; it keeps the digits
    of small angles, which the arc cosine of their product loses. q and −q are one orientation.
    """
    minus = " + ".join(f"(head_q{p} - head_q{p}_before) ^ 2" for p in "xyzw")
    plus = " + ".join(f"(head_q{p} + head_q{p}_before) ^ 2" for p in "xyzw")
    return _whole_steps(f"4 * asin(least(1, sqrt(least({minus}, {plus})) / 2))", _ANGLE)


def _dioptres(one: str, other: str) -> str:
    return _whole_steps(f"abs(1 / {one} - 1 / {other})", _ANGLE)


def _whole_steps(value: str, steps: float) -> str:
    return f"CAST(round({steps:.0f} * {value}) AS BIGINT)"


def _state(of: str = "") -> str:
    """Return SQL for the state of a frame while it is shown; `of` is the suffix of its columns."""
    told = {
        SeenState.OFF: f"user_present{of} = 0",
        SeenState.HIDDEN: f"paused{of} = 1",
        SeenState.NOT_DRAWN: f"should_render{of} = 0",
        SeenState.UNTRACKED: f"head_tracked{of} = 0",
        SeenState.UNFOCUSED: f"session_state{of} = 'visible'",
    }
    cases = " ".join(f"WHEN {holds} THEN '{state.value}'" for state, holds in told.items())
    return f"CASE {cases} ELSE '{SeenState.LIVE.value}' END"


_UNSEEN_STATES = ", ".join(repr(each.value) for each in UNSEEN)
_FOLLOWS = "trial_before = f.trial AND session_s_before >= a.from_s"
_SEEN = f"({_state()} NOT IN ({_UNSEEN_STATES}))"
_BOTH_SEEN = f"({_FOLLOWS} AND {_SEEN} AND {_state('_before')} NOT IN ({_UNSEEN_STATES}))"
_STEADY = (
    f"({_BOTH_SEEN} AND discontinuity <> {CUT} AND coalesce(head_valid, 1) = 1 "
    "AND coalesce(head_valid_before, 1) = 1)"
)
_STEPS = f"""
    xr_time_ns, period_ns, dropped, missed_refreshes, head_tracked, discontinuity,
    coalesce(should_render = 0, false) AS unseen,
    coalesce(should_render_before = 0, false) AS unseen_before,
    coalesce(session_state = 'visible', false) AS menu,
    coalesce(session_state_before = 'visible', false) AS menu_before,
    CASE WHEN {_FOLLOWS} THEN xr_time_ns - xr_time_ns_before END AS passed,
    CASE WHEN {_FOLLOWS} THEN period_ns_before END AS shown,
    coalesce(paused = 1, false) AS waits, {_state()} AS state, {_state("_before")} AS state_before,
    xr_time_ns <= xr_time_ns_before OR NOT isfinite({" + ".join(_HEAD)})
        OR (f.{" + f.".join(_PLAIN)}) IS NULL AS wrong,
    CASE WHEN {_STEADY} THEN {_distance("head", _LENGTH)} END AS head_step,
    CASE WHEN {_STEADY} THEN {_turn()} END AS turn,
    CASE WHEN {_STEADY} THEN {_distance("avatar", _LENGTH)} END AS avatar_step,
    CASE WHEN {_BOTH_SEEN} AND discontinuity <> {CUT} AND focus_m > 0 AND focus_m_before > 0
        THEN {_dioptres("focus_m", "focus_m_before")} END AS focus_step,
    CASE WHEN {_SEEN} AND focus_m > 0 AND focus_raw_m > 0
        THEN {_dioptres("focus_m", "focus_raw_m")} END AS lag_step,
    max_blur_px IS NOT NULL AS has_blur,
    CASE WHEN {_BOTH_SEEN} THEN max_blur_px <> max_blur_px_before END AS blur_changed"""

_TIMES_BEFORE_5 = f"""
    CASE WHEN unseen_before THEN 0 WHEN discontinuity = {CUT} THEN least(passed, shown)
        WHEN passed > {DROPPED_INTERVAL_PERIODS} * shown THEN shown ELSE passed END AS seen,
    discontinuity <> {CUT} AND dropped > 0 AND NOT unseen_before AS froze"""

_SUMS = """
    count(*) FILTER (NOT waits) AS frames, sum(dropped) AS dropped,
    sum(missed_refreshes) AS missed, coalesce(bool_or(wrong), false) AS wrong,
    sum(head_step) AS head_path, sum(turn) AS turning,
    sum(avatar_step) AS avatar_path, sum(focus_step) AS focus_change,
    sum(lag_step) AS focus_lag, count(lag_step) AS focused,
    CASE WHEN bool_or(has_blur) THEN count(*) FILTER (blur_changed) END AS blur_changes"""

_BEFORE_5 = """
    NULL AS off, NULL AS not_drawn, NULL AS half_rate,
    coalesce(sum(seen) FILTER (NOT menu_before), 0)
        + CASE WHEN arg_max(menu OR unseen, xr_time_ns) THEN 0
        ELSE arg_max(period_ns, xr_time_ns) END AS live,
    coalesce(sum(seen) FILTER (menu_before), 0)
        + CASE WHEN arg_max(menu AND NOT unseen, xr_time_ns) THEN arg_max(period_ns, xr_time_ns)
        ELSE 0 END AS unfocused,
    coalesce(sum(passed - seen) FILTER (froze), 0) AS frozen,
    coalesce(sum(passed - seen) FILTER (NOT froze), 0)
        + CASE WHEN arg_max(unseen, xr_time_ns) THEN arg_max(period_ns, xr_time_ns) ELSE 0 END
        AS hidden,
    sum(CASE WHEN head_tracked = 0 THEN period_ns WHEN head_tracked = 1 THEN 0 END) AS untracked"""

# As `vrcomfort.seen_time.display_intervals`, which a test compares.
_WAITED = f"state_before IN ({_UNSEEN_STATES})"
_LATE = f"passed > {DROPPED_INTERVAL_PERIODS} * shown"
_STOOD = f"({_LATE} AND passed - shown > {FREEZE_S * 1e9:.0f})"
_TIMES = f"""
    CASE WHEN NOT {_WAITED} AND NOT {_STOOD} AND discontinuity <> {CUT} AND {_LATE}
        THEN 'half_rate' ELSE state_before END AS first_state,
    CASE WHEN {_WAITED} THEN passed WHEN discontinuity = {CUT} THEN least(passed, shown)
        WHEN {_STOOD} THEN shown ELSE passed END AS first_ns,
    CASE WHEN discontinuity = {CUT} THEN 'hidden' ELSE 'frozen' END AS rest_state,
    passed - first_ns AS rest_ns"""


def _seconds(state: SeenState) -> str:
    """Return SQL for the nanoseconds in a state; the last frame has its period."""
    mine = f"= '{state.value}'"
    last = f"CASE WHEN arg_max(state, xr_time_ns) {mine} THEN arg_max(period_ns, xr_time_ns) END"
    parts = [f"sum({each}_ns) FILTER ({each}_state {mine})" for each in ("first", "rest")]
    return f"{' + '.join(f'coalesce({part}, 0)' for part in [*parts, last])} AS {state.value}"


_SECONDS = ", ".join(map(_seconds, SeenState))
