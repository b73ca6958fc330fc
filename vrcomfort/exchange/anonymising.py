"""Copies a study without the identity of its participants; the original stays as it is.

People are recognised by how they move their head and hands (Miller et al. 2020, Sci. Rep. 10:17404;
Nair et al. 2023, USENIX Security), and by their gaze. So both are left out unless they are asked
for.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from vrcomfort import __version__
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymous_import import write_anonymous
from vrcomfort.exchange.export_checks import (
    flagged_sessions,
    from_damaged,
    new_folder,
    require_whole,
)
from vrcomfort.exchange.imports import Import, is_import
from vrcomfort.exchange.verifying.findings import Finding
from vrcomfort.files import read_text
from vrcomfort.json_text import json_of
from vrcomfort.questionnaire import FOLDER as INSTRUMENTS
from vrcomfort.records.checksums import replace_listed, write_checksums
from vrcomfort.records.choice import EVERYTHING, Choice, SessionName
from vrcomfort.records.disk import OWNER, Access, make_folders, replace_text
from vrcomfort.records.events import EVENTS, shared_detail
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.rows import ALWAYS, GAZE, MOTION, Needs, Row, Trait, csv_line
from vrcomfort.records.schema import OPTIONAL_ROWS, SESSION_ROWS, TABLES, SharedFile, traits_text
from vrcomfort.records.session_rows import IPD_RULE, EventRow, ParticipantRow, ScreeningRow
from vrcomfort.records.study import DESCRIPTION, access_of

EPOCH = datetime(2000, 1, 1, tzinfo=UTC)
"""Where moments are moved to: midnight, so that the time of day goes, too."""

_OF_EYES = ("ipd_m",)
_REMOVED = "left out"


@dataclass(frozen=True)
class DateShift:
    """How a participant's moments are moved.

    Parameters
    ----------
    first
        Becomes `EPOCH`.
    all_one
        All others become that as well.
    """

    first: datetime
    all_one: bool

    def __call__(self, text: str) -> str:
        """Return a moment, ISO 8601 in UTC."""
        moment = datetime.fromisoformat(text)
        gone = moment - self.first
        return EPOCH.isoformat() if self.all_one else (EPOCH + gone).isoformat(timespec="seconds")


def of_manifest(manifest: dict[str, Any], participant: str, moved: DateShift) -> dict[str, Any]:
    """Return a session's manifest for another name, without typed texts, dates and eyes."""
    found = _of_run(manifest, moved)
    found["participant"] = participant
    found["earlier_runs"] = [_of_run(run, moved) for run in manifest.get("earlier_runs", [])]
    found["memory"] = None
    found["eye_heights"] = [
        {**each, "measured_m": None, "offset_m": None} for each in manifest.get("eye_heights", [])
    ]
    if ended := manifest.get("exposure_ended"):
        found["exposure_ended"] = {**ended, "at": moved(ended["at"])}
    if early := manifest.get("ended"):
        found["ended"] = {**early, "reason": _REMOVED}
    if begun := manifest.get("under_way"):
        found["under_way"] = {**begun, "participant": participant}
    found["withdrawals_undone"] = [
        {**each, "at": moved(each["at"]), "reason": _REMOVED}
        for each in manifest.get("withdrawals_undone", [])
    ]
    return found


def _of_run(run: dict[str, Any], moved: DateShift) -> dict[str, Any]:
    """Return the facts of one run, with shifted dates and without free text."""
    found = dict(run)
    for key in ("started_at", "finished_at"):
        if found.get(key):
            found[key] = moved(found[key])
    if "participant" in found:
        found.pop("participant")
    if found.get("clock_set_back"):
        found["clock_set_back"] = [_REMOVED for _ in found["clock_set_back"]]
    if "ipd_measured_m" in found:
        found["ipd_measured_m"] = None
    if isinstance(found.get("headset"), dict):
        found["headset"] = {k: v for k, v in found["headset"].items() if k not in _OF_EYES}
    return found


RECORD = "anonymised.json"
Dates: TypeAlias = Literal["shift", "remove"]


@dataclass(frozen=True)
class AnonymisingOptions:
    """Options of the anonymous copy of a study.

    Parameters
    ----------
    seed
        Decides the new names; None draws them from the operating system. Whoever knows it can undo
        them, so it is written nowhere.
    dates
        "shift": every participant's enrolment becomes 2000-01-01, and the times between their
        sessions stay; "remove": every moment becomes that.
    keep_motion, keep_gaze
        Leave in what people can be recognised by.
    key
        Where old and new names are written, outside of both folders; None: nowhere.
    """

    seed: int | None = None
    dates: Dates = "shift"
    keep_motion: bool = False
    keep_gaze: bool = False
    key: Path | None = None

    def kept(self, *, gaze_recorded: bool) -> Needs:
        """Return the traits that a copy keeps; where there is no gaze, nothing can tell of it."""
        motion = MOTION if self.keep_motion else ALWAYS
        return motion | (GAZE if self.keep_gaze or not gaze_recorded else ALWAYS)


def anonymise(
    study: Path, out: Path, options: AnonymisingOptions, choice: Choice = EVERYTHING
) -> dict[str, Any]:
    """Write the anonymous copy; return the content of its ``anonymised.json``.

    Raises
    ------
    InputError
        If the study is not whole, or `out` or the key cannot be where they should.
    """
    faults = require_whole(study, choice)
    _require_room_for_key(study, out, options.key)
    recorded = Study(study, without=choice.without)
    imported = Import(study) if is_import(study) else None
    people = imported.names if imported else [row.participant for row in recorded.enrolled]
    names = new_names(people, options.seed)
    access = OWNER if imported else access_of(study)
    with new_folder(study, out) as draft:
        make_folders(draft, draft, access)
        if imported:
            record = _write_import(imported, draft, names, options, access)
        else:
            said = {
                "sessions_left_out": _anonymous(choice.without, names),
                "sessions_with_faults": _anonymous(flagged_sessions(faults), names),
            }
            record = _write(recorded, draft, names, options, access, said, faults)
        if options.key is not None:
            lines = [csv_line(("participant", "anonymous"))]
            replace_text(options.key, "".join(lines + [csv_line(pair) for pair in names.items()]))
    return record


def _anonymous(sessions: Iterable[SessionName], names: Mapping[str, str]) -> list[str]:
    """Return sessions by the new names of their participants."""
    known = (SessionName(names[s.participant], s.number) for s in sessions if s[0] in names)
    return [str(each) for each in sorted(known)]


def new_names(names: Sequence[str], seed: int | None) -> dict[str, str]:
    """Return old name → new name: P01, P02, … in random order."""
    digits = max(2, len(str(len(names))))
    drawn = np.random.default_rng(np.random.SeedSequence(seed)).permutation(len(names))
    return {old: f"P{new + 1:0{digits}d}" for old, new in zip(names, drawn.tolist(), strict=True)}


def _require_room_for_key(study: Path, out: Path, key: Path | None) -> None:
    if key is None:
        return
    if any(each.resolve() in key.resolve().parents for each in (study, out)):
        message = "the key would lie in a folder that is handed on; choose a place outside"
        raise InputError(message, file=key)
    if not key.resolve().parent.is_dir():
        raise InputError("there is no such folder for the key; make it first", file=key.parent)
    if key.exists():
        raise InputError("is there already; choose a new file for the key", file=key)


def _write(
    recorded: Study,
    out: Path,
    names: Mapping[str, str],
    options: AnonymisingOptions,
    access: Access,
    said: Mapping[str, Any],
    faults: Sequence[Finding],
) -> dict[str, Any]:
    study = recorded.folder
    text = read_text(study / DESCRIPTION, "study description")
    replace_listed(out / DESCRIPTION, text, access)
    _copy_instruments(study, out, access)
    rows = {row.participant: row for row in recorded.enrolled}
    of_gaze = (name for name, table in TABLES.items() if table.NEEDS == GAZE)
    kept = options.kept(gaze_recorded=any(any(study.rglob(name)) for name in of_gaze))
    unknown: set[str] = set()
    for old in sorted(names, key=lambda each: names[each]):
        sessions = recorded.sessions_of(old)
        moved = _moved(rows[old], sessions, options)
        for session in sessions:
            with from_damaged(session, faults):
                _Copy(session, out, names[old], moved, kept, access, unknown).write()
    _write_participants(out, rows, names, kept, access)
    record = {**_record(study, list(rows.values()), options, kept, unknown), **said}
    replace_text(out / RECORD, json_of(record) + "\n", access)
    return record


_MADE_WITH = f"vrcomfort {__version__}"
_PEOPLE = "named anew, in random order; the list is in the order of the new names"


def _write_import(
    source: Import,
    out: Path,
    names: Mapping[str, str],
    options: AnonymisingOptions,
    access: Access,
) -> dict[str, Any]:
    _copy_instruments(source.folder, out, access)
    kept = options.kept(gaze_recorded=False)
    record = {
        "made_with": _MADE_WITH,
        "participants": _PEOPLE,
        **write_anonymous(source, out, names, kept, access),
    }
    replace_text(out / RECORD, json_of(record) + "\n", access)
    return record


def _copy_instruments(study: Path, out: Path, access: Access) -> None:
    for file in sorted((study / INSTRUMENTS).glob("*.toml")):
        make_folders(out, out / INSTRUMENTS, access)
        replace_text(out / INSTRUMENTS / file.name, read_text(file, "instrument"), access)


def _moved(
    row: ParticipantRow, sessions: Sequence[Session], options: AnonymisingOptions
) -> DateShift:
    """Return where a participant's moments go: the first of them to the epoch."""
    texts = [row.enrolled_at]
    for session in sessions:
        runs = [session.manifest, *session.manifest.get("earlier_runs", [])]
        texts += [str(run["started_at"]) for run in runs if run.get("started_at")]
    moments = []
    for text in texts:
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:  # entered by hand
            continue
        moments.append(moment if moment.tzinfo else moment.replace(tzinfo=UTC))
    return DateShift(min(moments, default=EPOCH), all_one=options.dates == "remove")


def _write_participants(
    out: Path,
    rows: Mapping[str, ParticipantRow],
    names: Mapping[str, str],
    kept: Needs,
    access: Access,
) -> None:
    """Write the list in the order of the new names: that of the enrolment would tell."""
    enrolled = EPOCH.isoformat()
    blank = [
        replace(row, participant=names[old], enrolled_at=enrolled, note="")
        for old, row in rows.items()
    ]
    private = SharedFile.of(ParticipantRow).blank(kept)
    others = dict.fromkeys(name for row in blank for name, _ in row.others if name not in private)
    lines = [csv_line((*ParticipantRow.columns(), *others))]
    for row in sorted(blank, key=lambda each: each.participant):
        more = [dict(row.others).get(name, "") for name in others]
        lines.append(csv_line((*row.cells(), *more)))
    replace_listed(out / ParticipantRow.FILE, "".join(lines), access)


@dataclass(frozen=True)
class _Copy:
    """The copy of a session that is being made."""

    session: Session
    out: Path
    new: str
    moved: DateShift
    kept: Needs
    access: Access
    unknown: set[str]
    """Names of events that are not declared, which it adds to."""

    def write(self) -> None:
        """Write its files, and their checksums."""
        folder = session_folder(self.out, self.new, self.session.number)
        make_folders(self.out, folder, self.access)
        manifest = of_manifest(self.session.manifest, self.new, self.moved)
        text = json_of(manifest) + "\n"
        replace_text(folder / "manifest.json", text, self.access)
        begin_ns = _begin_ns(self.session)
        for row_type in (*SESSION_ROWS, *OPTIONAL_ROWS):
            if self.session.has(row_type) and not SharedFile.of(row_type).lacking(self.kept):
                self._rewrite(row_type, folder / row_type.FILE, begin_ns)
        if manifest["status"] != "running":
            write_checksums(folder, self.access)

    def _rewrite(self, row_type: type[Row], target: Path, begin_ns: int) -> None:
        """Copy a table row by row."""
        target.touch(mode=self.access.file_mode, exist_ok=False)
        target.chmod(self.access.file_mode)
        change = self._change(row_type, begin_ns)
        header = self.session.header(row_type)
        with target.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, header, lineterminator="\n")
            writer.writeheader()
            writer.writerows(map(change, self.session.text_rows(row_type)))

    def _change(
        self, row_type: type[Row], begin_ns: int
    ) -> Callable[[dict[str, str]], dict[str, str]]:
        """Return the function that makes a row of a table anonymous.

        The runtime's clock begins at 0 with the session's first frame: else it would tell in which
        order participants of one day came.
        """
        private = SharedFile.of(row_type).blank(self.kept)

        def change(row: dict[str, str]) -> dict[str, str]:
            row.update((column, "") for column in private if column in row)
            if "participant" in row:
                row["participant"] = self.new
            if "xr_time_ns" in row:
                row["xr_time_ns"] = str(int(row["xr_time_ns"]) - begin_ns)
            if row_type is ScreeningRow and row["rule"].startswith(IPD_RULE):
                row["value"] = ""
            if row_type is EventRow:
                row["detail"] = shared_detail(row["name"], row["detail"])
                self.unknown.update({row["name"]} - EVENTS.keys())
            return row

        return change


def _begin_ns(session: Session) -> int:
    """Return the runtime's time of a session's first frame."""
    first = next(session.text_rows(FrameRow), None)
    return int(first["xr_time_ns"]) if first else 0


def _record(
    study: Path,
    rows: Sequence[ParticipantRow],
    options: AnonymisingOptions,
    kept: Needs,
    unknown: Collection[str],
) -> dict[str, Any]:
    covariates = [tuple(sorted(row.covariates.items())) for row in rows]
    known = sorted({name for each in covariates for name, _ in each})
    dates = {
        "shift": f"every participant's first moment is {EPOCH.date()}; times between stay",
        "remove": f"every moment is {EPOCH.date()}",
    }
    recognised = {"head and hand motion": options.keep_motion, "gaze": options.keep_gaze}
    there = {name: SharedFile.of(t) for name, t in TABLES.items() if any(study.rglob(name))}
    left_out = {name: lacking for name, f in there.items() if (lacking := f.lacking(kept))}
    stays = {name: f for name, f in there.items() if name not in left_out}
    return {
        "made_with": _MADE_WITH,
        "participants": _PEOPLE,
        "dates": dates[options.dates],
        "frame_times": "xr_time_ns begins at 0 with each session's first frame",
        "files_left_out": {name: _in_words(traits) for name, traits in left_out.items()},
        "columns_blank": {name: blank for name, f in stays.items() if (blank := f.blank(kept))},
        "details_blank": "of events that people may have typed, or that are of the body, the "
        "machine or its clock",
        "events_not_known": sorted(unknown),
        "left_out": "notes and reasons; distances between pupils, heights of eyes; memory of "
        "respondents; moved-aside rows (.cut, .schemaN, .replacedN), Parquet files, locks, files "
        "that are not of vrcomfort's making",
        "still_there": {
            "people_are_recognised_by": [name for name, stay in recognised.items() if stay],
            "covariates": known,
            "smallest_group_with_the_same_covariates": (
                min(Counter(covariates).values()) if known else None
            ),
            "sequence": "an order of its own (r1, r2, …) is numbered as people were enrolled",
            "protocol": "its text, with comments, is in every manifest",
            "columns": {
                name: {
                    column: traits_text(needs) or "none" for column, needs in f.stays(kept).items()
                }
                | (dict.fromkeys(known, "covariate") if name == ParticipantRow.FILE else {})
                for name, f in stays.items()
            },
        },
    }


_WORDS: Mapping[Trait, str] = {
    "motion": "head and hands",
    "gaze": "gaze",
    "text": "own words",
    "date": "it tells the date",
}


def _in_words(traits: Needs) -> str:
    return ", ".join(words for trait, words in _WORDS.items() if trait in traits)
