"""Sums over frames are those of plain NumPy, from CSV and from Parquet; damage has its place."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import partial
from itertools import pairwise

import duckdb
import numpy as np
import pandas as pd
import pytest

from tests.support.cluster import local_cluster
from tests.support.recordings import PERIOD_NS, frames, session
from tests.support.report import build_report, carnegie_like
from tests.support.study import frame
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.recordings import frame_measures, pack_study
from vrcomfort.records.checksums import write_checksums
from vrcomfort.records.disk import OWNER
from vrcomfort.records.recording import Memory, Recording, packed_facts
from vrcomfort.records.rows import cell_text, csv_line
from vrcomfort.session.frame_log import FrameLog


def packed(folder):
    return list(pack_study(folder, Memory()))


def by_hand(rows: pd.DataFrame) -> dict[str, float | None]:
    """Return the sums of one exposure, a frame at a time."""
    found = dict.fromkeys(("live", "frozen", "hidden", "unfocused"), 0.0)
    found |= dict.fromkeys(("path", "turning", "avatar", "focus"), 0.0)
    found["blur"] = 0
    table = rows.to_dict("records")
    for before, now in pairwise(table):
        cut = now["discontinuity"] == 1
        passed = now["xr_time_ns"] - before["xr_time_ns"]
        late = passed > 1.2 * before["period_ns"]
        unseen = not before["should_render"]
        seen = 0 if unseen else before["period_ns"] if late else passed
        found["unfocused" if before["session_state"] == "visible" else "live"] += seen / 1e9
        frozen = now["dropped"] and not cut and not unseen
        found["frozen" if frozen else "hidden"] += (passed - seen) / 1e9
        if unseen or not now["should_render"]:
            continue
        found["blur"] += before["max_blur_px"] != now["max_blur_px"]
        if not cut and not np.isnan(now["focus_m"]) and not np.isnan(before["focus_m"]):
            found["focus"] += abs(1 / now["focus_m"] - 1 / before["focus_m"])
        if cut or not (now["head_valid"] and before["head_valid"]):
            continue
        for name, key in (("head", "path"), ("avatar", "avatar")):
            ways = [now[f"{name}_{a}_m"] - before[f"{name}_{a}_m"] for a in "xyz"]
            found[key] += float(np.linalg.norm(ways))
        cosine = abs(sum(now[f"head_q{p}"] * before[f"head_q{p}"] for p in "xyzw"))
        found["turning"] += np.degrees(2 * np.arccos(min(1.0, cosine)))
    last = table[-1]
    kind = "unfocused" if last["session_state"] == "visible" else "live"
    found[kind if last["should_render"] else "hidden"] += last["period_ns"] / 1e9
    drawn = rows[rows["should_render"] == 1]
    found["lag"] = float(np.nanmean(np.abs(1 / drawn["focus_m"] - 1 / drawn["focus_raw_m"])))
    found["untracked"] = float(rows.loc[rows["head_tracked"] == 0, "period_ns"].sum()) / 1e9
    return found


def test_sums_are_those_of_one_frame_after_the_other(tmp_path):
    table = frames(600)
    file = session(tmp_path / "sub-P01" / "ses-1", table)
    measured, notes = frame_measures([file])
    assert notes == []
    assert [(each.participant, each.trial) for each in measured] == [("P01", 1), ("P01", 2)]
    for each in measured:
        rows = table[table["trial"] == each.trial]
        told = by_hand(rows)
        assert each.frames == len(rows)
        assert each.dropped == rows["dropped"].sum()
        assert each.missed_refreshes == rows["missed_refreshes"].sum()
        assert each.blur_changes == told["blur"]
        close = partial(pytest.approx, rel=1e-7)
        assert each.live_s == close(told["live"])
        assert each.frozen_s == close(told["frozen"])
        assert each.hidden_s == close(told["hidden"])
        assert each.unfocused_s == close(told["unfocused"])
        assert each.untracked_s == close(told["untracked"])
        assert each.head_path_m == close(told["path"])
        assert each.head_turning_deg == close(told["turning"])
        assert each.avatar_path_m == close(told["avatar"])
        assert each.focus_travel_dioptre == close(told["focus"])
        assert each.focus_lag_dioptre == close(told["lag"])


class OneFile:
    """Takes rows as a recorder does."""

    def __init__(self, file):
        self.file = file

    def write(self, *rows):
        new = not self.file.exists()
        with self.file.open("a", encoding="utf-8") as stream:
            for row in rows:
                stream.write(csv_line(row.columns()) if new else "")
                stream.write(csv_line(map(cell_text, row.cells())))
                new = False


def test_times_are_those_that_the_session_wrote_for_its_trial(tmp_path):
    random = np.random.default_rng(7)
    file = tmp_path / "frames.csv"
    trial = "participant,session,trial,start_s,end_s\nP01,1,1,0,99\n"
    file.with_name("trials.csv").write_text(trial)
    log, time_ns = FrameLog(OneFile(file)), 0
    for index in range(300):
        time_ns += PERIOD_NS * int(random.choice([1, 2, 5, 99], p=[0.9, 0.05, 0.03, 0.02]))
        shown = frame(index, period_ns=PERIOD_NS, time_ns=time_ns)
        shown = replace(
            shown,
            discontinuity=bool(random.random() < 0.03),
            head_pose=Pose(random.normal(size=3)),
            session_state=str(random.choice(["focused", "visible"])),
            should_render=bool(random.random() > 0.1),
            head_tracked=bool(random.random() > 0.2),
            user_present=random.choice([True, False, None], p=[0.5, 0.1, 0.4]),
        )
        if 9 < index < 290 and random.random() < 0.03:
            shown = replace(shown, paused=True)
            log.add_paused(shown, trial=1, session_s=time_ns / 1e9)
        else:
            log.add(shown, None, trial=1, session_s=time_ns / 1e9)
    log.finish()
    (found,), notes = frame_measures([file])
    seen = log.timing.seen
    assert notes == []
    counted = (log.frames, log.dropped, log.timing.missed_refreshes)
    assert (found.frames, found.dropped, found.missed_refreshes) == counted
    seen.end(0.0)
    told = seen.cells()
    assert {name: getattr(found, name) for name in told} == pytest.approx(told, abs=1e-9)
    assert min(told.values()) > 0


@pytest.mark.slow
@pytest.mark.smoke
def test_parquet_gives_the_same_numbers_to_the_last_digit(tmp_path):
    files = [
        session(tmp_path / f"sub-P{n}" / "ses-1", frames(500, seed=n), participant=f"P{n}")
        for n in range(3)
    ]
    before, _ = frame_measures(files)
    done = packed(tmp_path)
    assert [each.new for each in done] == [True] * 3
    assert all(Recording.find(file).parquet for file in files)
    assert frame_measures(files) == (before, [])
    assert [each.new for each in packed(tmp_path)] == [False] * 3


def test_the_parquet_holds_every_cell_of_the_record(tmp_path):
    table = frames(100)
    session(tmp_path, table)
    (done,) = packed(tmp_path)
    with Memory().database() as database:
        rows = database.read_parquet(str(done.parquet)).df()
    pd.testing.assert_frame_equal(rows, table, check_dtype=False)


def test_an_exposure_begun_again_is_two_attempts(tmp_path):
    table = frames(100, trials=1)
    file = session(tmp_path, table)
    rows = table[table["trial"] == 1]
    half = rows["session_s"].iloc[len(rows) // 2]
    text = file.with_name("trials.csv").read_text()
    first, last = rows["session_s"].iloc[0], rows["session_s"].iloc[-1]
    header = text.splitlines()[0]
    lines = [f"P01,1,1,a,temple,{first},{half - 0.02},aborted,,0,0",  # a blank is the first
             f"P01,1,1,a,temple,{half},{last},completed,2,0,0"]  # fmt: skip
    file.with_name("trials.csv").write_text("\n".join([header, *lines, ""]))
    (one, two), _ = frame_measures([file])
    assert (one.attempt, two.attempt) == (1, 2)
    assert one.frames == (rows["session_s"] < half).sum()
    assert two.frames == (rows["session_s"] >= half).sum()
    assert two.head_path_m == pytest.approx(by_hand(rows[rows["session_s"] >= half])["path"])


def test_a_recording_of_the_first_schema_has_blanks_where_nothing_was_recorded(tmp_path):
    later = ["head_valid", "head_tracked", "session_state", "missed_refreshes", "max_blur_px"]
    file = session(tmp_path, frames(60).drop(columns=later))
    (one, _), notes = frame_measures([file])
    assert notes == []
    assert (one.untracked_s, one.missed_refreshes, one.blur_changes) == (None, None, None)
    assert one.unfocused_s == 0


@pytest.mark.parametrize("how", ["longer", "same size", "older form", "damaged"])
def test_a_parquet_that_is_not_of_its_csv_is_told_and_not_read(whole, tmp_path, how):
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "frames.csv"
    text = file.read_text()
    if how == "longer":
        file.write_text(text.replace("focused", "visible", 1) + "\n")
    elif how == "same size":
        changed = text.replace("visible", "focused", 1)
        assert changed != text
        file.write_text(changed)
    elif how == "damaged":
        file.with_suffix(".parquet").write_bytes(b"PAR1 and then nothing")
    else:
        file.with_suffix(".parquet").unlink()
        with Memory().database() as database:
            database.execute(f"COPY (SELECT 1 AS a) TO '{file.with_suffix('.parquet')}'")
    fresh = frame_measures([file])[0]
    _, (note,) = frame_measures([file])
    assert "frames.parquet: not read, because" in note
    assert "vrcomfort pack" in note
    assert Recording.find(file).parquet is None
    file.with_suffix(".parquet").unlink()
    assert frame_measures([file]) == (fresh, [])


def test_a_copied_study_keeps_its_parquet(tmp_path):
    file = session(tmp_path, frames(60))
    packed(tmp_path)
    os.utime(file, ns=(0, 10**18))
    assert Recording.find(file).parquet is not None


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return a folder with a session that has been packed, to be copied."""
    folder = tmp_path_factory.mktemp("whole")
    session(folder, frames(60))
    packed(folder)
    return folder


def spoilt(file, line: int, column: str, cell: str) -> None:
    lines = file.read_text().splitlines()
    cells = lines[line - 1].split(",")
    cells[lines[0].split(",").index(column)] = cell
    lines[line - 1] = ",".join(cells)
    file.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("column", "cell", "what"),
    [
        ("head_x_m", "nan", "finite"),
        ("head_x_m", "left", "number"),
        ("period_ns", "1.5", "whole number"),
        ("xr_time_ns", "1e9", "whole number"),
        ("xr_time_ns", "1", "time does not go on"),
        ("head_y_m", "1,2", "cells"),
        ("dropped", "", "blank"),
    ],
)
def test_what_is_damaged_is_refused_with_its_place(whole, tmp_path, column, cell, what):
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "frames.csv"
    old = file.with_suffix(".parquet").read_bytes()
    spoilt(file, 41, column, cell)
    with pytest.raises(InputError, match=what) as refusal:
        packed(tmp_path)
    assert refusal.value.line == 41
    assert "\n" not in str(refusal.value)
    assert file.with_suffix(".parquet").read_bytes() == old
    assert [each.name for each in tmp_path.glob(".*")] == []
    measured, notes = frame_measures([file])
    assert measured == []
    assert "line 41" in notes[-1]


def test_a_column_of_blanks_is_refused_with_its_place(tmp_path):
    """A sum over blanks is no number."""
    table = frames(60)
    file = session(tmp_path, table)
    lines = file.read_text().splitlines()
    place = lines[0].split(",").index("dropped")
    cells = [line.split(",") for line in lines[1:]]
    blanked = [[*row[:place], "", *row[place + 1 :]] for row in cells]
    file.write_text("\n".join([lines[0], *map(",".join, blanked), ""]))
    measured, notes = frame_measures([file])
    assert measured == []
    assert "line 2, column dropped: this cell is blank" in notes[-1]


def test_a_half_written_last_row_is_left_out(tmp_path):
    table = frames(60)
    file = session(tmp_path, table)
    whole = file.read_bytes()
    before, _ = frame_measures([file])
    file.write_bytes(whole + whole.splitlines(keepends=True)[-1][:-12])
    assert frame_measures([file]) == (before, [])
    (done,) = packed(tmp_path)
    assert done.half_written
    assert frame_measures([file]) == (before, [])


def test_what_is_no_study_is_refused_in_a_sentence(tmp_path):
    with pytest.raises(InputError, match=r"there is no frames\.csv"):
        packed(tmp_path)
    with pytest.raises(InputError, match="no such folder"):
        packed(tmp_path / "gone")
    (tmp_path / "frames.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="session_s"):
        packed(tmp_path)
    for size in ("much", "10MB", "-1GB"):
        with pytest.raises(InputError, match="--memory"):
            Memory.of_text(size)
    assert Memory.of_text("1.5 GiB").limit_bytes == 3 * 2**29


def test_nothing_is_packed_while_a_session_runs(tmp_path):
    session(tmp_path / "sub-P01" / "ses-1", frames(30))
    lock = tmp_path / "sub-P01" / "lock"
    lock.touch()
    program = (
        "import sys, fcntl; f = open(sys.argv[1], 'r+'); fcntl.flock(f, fcntl.LOCK_EX); "
        "print('held', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(lock)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as holder:  # fmt: skip
        assert holder.stdout is not None
        holder.stdout.readline()
        with pytest.raises(InputError, match="P01 is being run"):
            packed(tmp_path)
        assert holder.stdin is not None
        holder.stdin.close()
    assert packed(tmp_path)[0].new


@pytest.mark.slow
def test_a_report_has_what_the_frames_say_and_tells_what_it_did_not_read(tmp_path):
    study = carnegie_like(tmp_path / "study")
    table = frames(400)
    table["session_s"] += 100 * table["trial"]  # as the trials of this study begin
    file = study.folder / "sub-P01" / "ses-1" / "frames.csv"
    table.to_csv(file, index=False)
    packed(study.folder)
    (found,) = {each for each in frame_measures([file])[0] if each.trial == 2}
    page = page_of(study.folder, tmp_path / "report")
    results = json.loads((tmp_path / "report" / "results.json").read_text())
    row = results["frame_measures"][1]
    assert (row["participant"], row["condition"]) == ("P01", "dof_on")
    assert row["head_path_m"] == pytest.approx(found.head_path_m)
    (blurred,) = [each for each in results["movement"] if each["condition"] == "dof_on"]
    assert blurred["exposures"] == 1
    assert blurred["head_turning_deg"] == pytest.approx(found.head_turning_deg)
    assert f"{found.head_turning_deg:.1f}" in page
    untracked = {row["condition"]: row["untracked_s"] for row in results["stimulus_time"]}
    assert untracked["dof_on"] == pytest.approx(found.untracked_s)
    spoilt(file, 9, "head_x_m", "left")
    said = page_of(study.folder, tmp_path / "report")
    assert "sub-P01/ses-1/frames.csv, line 9, column head_x_m" in said
    assert str(tmp_path) not in said


def page_of(study, out) -> str:
    return build_report(study, out=out).index.read_text(encoding="utf-8")


@pytest.mark.slow
def test_two_dask_workers_give_the_same_numbers(tmp_path):
    from vrcomfort.workers import workers

    files = [
        session(tmp_path / f"sub-P{n}" / "ses-1", frames(2000, seed=n), participant=f"P{n}")
        for n in range(6)
    ]
    alone = frame_measures(files)
    packed(tmp_path / "sub-P1")
    with local_cluster(2) as address, workers(1, address) as work:
        assert frame_measures(files, work=work) == alone
        with pytest.raises(InputError, match="all machines see it"):
            frame_measures([tmp_path / "elsewhere" / "frames.csv"], work=work)


@pytest.mark.slow
def test_memory_stays_under_its_limit(tmp_path):
    """A session of a million frames, 180 MB of numbers, is summed in a process of 256 MB."""
    from bench.recordings import make_recording

    file = make_recording(tmp_path, 1_000_000)
    program = (
        "import sys; from pathlib import Path; "
        "from vrcomfort.recordings import frame_measures; "
        "from vrcomfort.records.recording import Memory; "
        "found, notes = frame_measures([Path(sys.argv[1])], Memory(256 * 10**6)); "
        "assert not notes, notes; assert sum(each.frames for each in found) == 1_000_000; "
        "from bench.recordings import peak_mb; print(peak_mb())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(file)], capture_output=True, text=True, check=True
    )
    assert float(done.stdout) < 256


def test_a_parquet_that_was_altered_is_told_and_not_read(tmp_path):
    """Its facts of the CSV still hold; the session's list has its checksum."""
    csv = session(tmp_path, frames(400))
    write_checksums(csv.parent, OWNER)
    packed(tmp_path)
    parquet = csv.with_suffix(".parquet")
    assert Recording.find(csv).parquet == parquet
    facts = ", ".join(f"{name}: '{value}'" for name, value in packed_facts(parquet).items())
    moved = f"SELECT * REPLACE (head_x_m + 1 AS head_x_m) FROM '{parquet}'"  # noqa: S608
    with duckdb.connect() as database:
        other = tmp_path / "other.parquet"
        database.execute(f"COPY ({moved}) TO '{other}' (KV_METADATA {{{facts}}})")
    (tmp_path / "other.parquet").replace(parquet)
    found = Recording.find(csv)
    assert found.parquet is None
    assert "not as it was packed" in found.note
    assert [each.new for each in packed(tmp_path)] == [True]
    assert Recording.find(csv).parquet == parquet
