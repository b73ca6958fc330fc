"""Copies a study without what tells who its participants are; the original stays as it is.

People are recognised by how they move their head and hands (Miller et al. 2020, Sci. Rep. 10:17404;
Nair et al. 2023, USENIX Security), and by their gaze. So both are left out unless they are asked
for.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from vrcomfort import __version__
from vrcomfort.errors import InputError
from vrcomfort.exchange.private_facts import EPOCH, Moved, of_event, of_manifest
from vrcomfort.exchange.room import new_folder, require_whole
from vrcomfort.questionnaire import FOLDER as INSTRUMENTS
from vrcomfort.records.checksums import seal
from vrcomfort.records.disk import Access, make_folders, replace_text
from vrcomfort.records.exposure_rows import BallRow, DialRow, PracticeRow, TaskRow
from vrcomfort.records.frame_rows import RAYS, FrameRow, GazeRow, ImageRow
from vrcomfort.records.manifest import read_manifest
from vrcomfort.records.pose_columns import AVATAR, EYES, HANDS, HEAD
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.row_files import SESSION_ROWS
from vrcomfort.records.rows import cell_text, csv_line
from vrcomfort.records.session_rows import (
    IPD_RULE,
    EventRow,
    GazeValidationRow,
    ParticipantRow,
    ScreeningRow,
)
from vrcomfort.records.study import DESCRIPTION, access_of, read_participants, recorded_sessions

RECORD = "anonymised.json"
Dates: TypeAlias = Literal["shift", "remove"]
MOTION = (*HEAD, *EYES, *AVATAR, *HANDS, "focus_m", "focus_raw_m", *RAYS, "rays_used")
"""Poses, and what they decide: how far the things are that the head is turned to."""

_PLACES = ("x_m", "y_m", "z_m")
"""Of ``tasks.csv``: where the head was, or what appeared in its view."""


@dataclass(frozen=True)
class Wishes:
    """What is to become of a study.

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


def anonymise(study: Path, out: Path, wishes: Wishes) -> dict[str, Any]:
    """Write the anonymous copy; return what was done to it, as its ``anonymised.json`` says.

    Raises
    ------
    InputError
        If the study is an import or not whole, or `out` or the key cannot be where they should.
    """
    require_whole(study)
    _require_room_for_key(study, out, wishes.key)
    rows = read_participants(study)
    names = new_names([row.participant for row in rows], wishes.seed)
    access = access_of(study)
    with new_folder(study, out) as draft:
        make_folders(draft, draft, access)
        record = _write(study, draft, names, wishes, access)
        if wishes.key is not None:
            lines = [csv_line(("participant", "anonymous"))]
            replace_text(wishes.key, "".join(lines + [csv_line(pair) for pair in names.items()]))
    return record


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
    study: Path, out: Path, names: Mapping[str, str], wishes: Wishes, access: Access
) -> dict[str, Any]:
    text = (study / DESCRIPTION).read_text(encoding="utf-8")
    replace_text(out / DESCRIPTION, text, access)
    _copy_instruments(study, out, access)
    rows = {row.participant: row for row in read_participants(study)}
    for old in sorted(names, key=lambda each: names[each]):
        moved = _moved(study, rows[old], wishes)
        for number in recorded_sessions(study, old):
            _Session(study, out, old, names[old], number, moved, wishes, access).write()
    _write_participants(out, rows, names, access)
    record = _record(list(rows.values()), wishes)
    replace_text(out / RECORD, json.dumps(record, indent=2, ensure_ascii=False) + "\n", access)
    return record


def _copy_instruments(study: Path, out: Path, access: Access) -> None:
    for file in sorted((study / INSTRUMENTS).glob("*.toml")):
        make_folders(out, out / INSTRUMENTS, access)
        replace_text(out / INSTRUMENTS / file.name, file.read_text(encoding="utf-8"), access)


def _moved(study: Path, row: ParticipantRow, wishes: Wishes) -> Moved:
    """Return where a participant's moments go: the first of them to the epoch."""
    texts = [row.enrolled_at]
    for number in recorded_sessions(study, row.participant):
        manifest = read_manifest(session_folder(study, row.participant, number))
        runs = [manifest, *manifest.get("earlier_runs", [])]
        texts += [str(run["started_at"]) for run in runs if run.get("started_at")]
    moments = []
    for text in texts:
        try:
            moment = datetime.fromisoformat(text)
        except ValueError:  # entered by hand
            continue
        moments.append(moment if moment.tzinfo else moment.replace(tzinfo=UTC))
    return Moved(min(moments, default=EPOCH), all_one=wishes.dates == "remove")


def _write_participants(
    out: Path, rows: Mapping[str, ParticipantRow], names: Mapping[str, str], access: Access
) -> None:
    """Write the list in the order of the new names: that of the enrolment would tell."""
    enrolled = EPOCH.isoformat()
    blank = [
        replace(row, participant=names[old], enrolled_at=enrolled, note="")
        for old, row in rows.items()
    ]
    others = list(dict.fromkeys(name for row in blank for name, _ in row.others))
    lines = [csv_line((*ParticipantRow.columns(), *others))]
    for row in sorted(blank, key=lambda each: each.participant):
        more = [dict(row.others).get(name, "") for name in others]
        lines.append(csv_line(map(cell_text, (*row.cells(), *more))))
    replace_text(out / ParticipantRow.FILE, "".join(lines), access)


@dataclass(frozen=True)
class _Session:
    """One session on its way."""

    study: Path
    out: Path
    old: str
    new: str
    number: int
    moved: Moved
    wishes: Wishes
    access: Access

    def write(self) -> None:
        """Write its files, and their checksums."""
        source = session_folder(self.study, self.old, self.number)
        folder = session_folder(self.out, self.new, self.number)
        make_folders(self.out, folder, self.access)
        manifest = of_manifest(read_manifest(source), self.new, self.moved)
        text = json.dumps(manifest, indent=2, ensure_ascii=False) + "\n"
        replace_text(folder / "manifest.json", text, self.access)
        more = (TaskRow, DialRow, ScreeningRow, GazeValidationRow, PracticeRow)
        there = [each for each in more if (source / each.FILE).exists()]
        for row_type in (*SESSION_ROWS, *there):
            name = row_type.FILE
            change = _of_frames(source, self.wishes) if row_type is FrameRow else self._of_row(name)
            _rewrite(source / name, folder / name, change, self.access)
        motion = self.wishes.keep_motion
        kept = {GazeRow.FILE: self.wishes.keep_gaze, ImageRow.FILE: motion, BallRow.FILE: motion}
        for name, wished in kept.items():
            if wished and (source / name).exists():
                _rewrite(source / name, folder / name, _in_time(source), self.access)
        if manifest["status"] != "running":
            seal(folder, self.access)

    def _of_row(self, name: str) -> Callable[[dict[str, str]], dict[str, str]]:
        def change(row: dict[str, str]) -> dict[str, str]:
            if "participant" in row:
                row["participant"] = self.new
            if name == ScreeningRow.FILE and row["rule"].startswith(IPD_RULE):
                row["value"] = ""
            if name == TaskRow.FILE and not self.wishes.keep_motion:
                row.update(dict.fromkeys(_PLACES, ""))
            return of_event(row) if name == EventRow.FILE else row

        return change


def _in_time(source: Path) -> Callable[[dict[str, str]], dict[str, str]]:
    """Return what lets the runtime's clock begin at 0 with the session's first frame.

    Else it would tell in which order participants of one day came.
    """
    with (source / FrameRow.FILE).open(encoding="utf-8", newline="") as stream:
        first = next(csv.DictReader(stream), None)
    begin_ns = int(first["xr_time_ns"]) if first else 0

    def change(row: dict[str, str]) -> dict[str, str]:
        row["xr_time_ns"] = str(int(row["xr_time_ns"]) - begin_ns)
        return row

    return change


def _of_frames(source: Path, wishes: Wishes) -> Callable[[dict[str, str]], dict[str, str]]:
    in_time = _in_time(source)
    left_out = dict.fromkeys(() if wishes.keep_motion else MOTION, "")

    def change(row: dict[str, str]) -> dict[str, str]:
        row.update((name, "") for name in left_out if name in row)
        return in_time(row)

    return change


def _rewrite(
    source: Path, target: Path, change: Callable[[dict[str, str]], dict[str, str]], access: Access
) -> None:
    """Copy a CSV file row by row."""
    target.touch(mode=access.file_mode, exist_ok=False)
    target.chmod(access.file_mode)
    with (
        source.open(encoding="utf-8", newline="") as read,
        target.open("w", encoding="utf-8", newline="") as written,
    ):
        rows = csv.DictReader(read)
        writer = csv.DictWriter(written, rows.fieldnames or (), lineterminator="\n")
        writer.writeheader()
        writer.writerows(map(change, rows))


def _record(rows: Sequence[ParticipantRow], wishes: Wishes) -> dict[str, Any]:
    covariates = [tuple(sorted(row.covariates.items())) for row in rows]
    known = sorted({name for each in covariates for name, _ in each})
    dates = {
        "shift": f"every participant's first moment is {EPOCH.date()}; times between stay",
        "remove": f"every moment is {EPOCH.date()}",
    }
    kept = [
        name
        for name, is_kept in (("head and hand motion", wishes.keep_motion),
                              ("gaze", wishes.keep_gaze))
        if is_kept
    ]  # fmt: skip
    return {
        "made_with": f"vrcomfort {__version__}",
        "participants": "named anew, in random order; the list is in the order of the new names",
        "dates": dates[wishes.dates],
        "frame_times": "xr_time_ns begins at 0 with each session's first frame",
        "head_and_hand_motion": (
            "kept"
            if wishes.keep_motion
            else f"blank: {', '.join(MOTION)}, and in tasks.csv {', '.join(_PLACES)}"
        ),
        "gaze": "kept" if wishes.keep_gaze else "left out (gaze.csv)",
        "texts": "notes, reasons and details of events that people may have typed are blank; "
        "answers in one's own words (texts.csv) are left out",
        "consents": "left out (consents.csv): days would tell",
        "images": "hashes kept" if wishes.keep_motion else "hashes left out (images.csv)",
        "balls_of_tasks": "kept" if wishes.keep_motion else "left out (balls.csv)",
        "left_out": "distances between pupils; readings of clocks (clocks.csv); memory of "
        "respondents; moved-aside rows (.cut, .schemaN, .replacedN), Parquet files, locks, files "
        "that are not of vrcomfort's making",
        "still_there": {
            "people_are_recognised_by": kept,
            "covariates": known,
            "smallest_group_with_the_same_covariates": (
                min(Counter(covariates).values()) if known else None
            ),
            "sequence": "an order of its own (r1, r2, …) is numbered as people were enrolled",
            "protocol": "its text, with comments, is in every manifest",
        },
    }
