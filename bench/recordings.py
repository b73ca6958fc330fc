"""Cost of sums over frames: `python -m bench.recordings [--rows 10000000]`.

Makes recordings of one session with a sixteenth, a quarter and all of the rows, in Parquet, and
sums their frames by exposure: with `frame_measures`, and with the same aggregates written by hand
in DuckDB's SQL (over the rows in their order, and over windows by trial sorted by time). Each run
is a program of its own, on one thread; ours and those by hand take turns. The slope is that of the
logarithm of time over that of rows: 1 is linear.
"""

from __future__ import annotations

import csv
import math
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import duckdb

from bench.apart import in_a_program, main_of_ways
from bench.table import Result
from vrcomfort.recordings import frame_measures
from vrcomfort.records.recording import Fingerprint, Memory, parquet_of

PERIOD_NS, FRAMES_OF_A_TRIAL = 13_888_889, 21_600
MEMORY_MB = 512
WAYS = ("frame_measures", "by hand, in order", "by hand, by trial")

_FRAMES = f"""
    SELECT i * {PERIOD_NS} / 1e9 AS session_s, i * {PERIOD_NS} AS xr_time_ns,
    CAST({PERIOD_NS} AS BIGINT) AS period_ns, 1 + i // {FRAMES_OF_A_TRIAL} AS trial,
    round(sin(i * 0.001) + 0.01 * random(), 6) AS head_x_m,
    round(1.6 + 0.01 * random(), 6) AS head_y_m, round(cos(i * 0.0013), 6) AS head_z_m,
    0.0 AS head_qx, sin(sin(i * 0.01)) AS head_qy, 0.0 AS head_qz, cos(sin(i * 0.01)) AS head_qw,
    i * 0.001 AS avatar_x_m, 0.0 AS avatar_y_m, 0.0 AS avatar_z_m,
    CAST(1 AS BIGINT) AS head_valid, CAST(1 AS BIGINT) AS head_tracked,
    'focused' AS session_state, 1 + random() AS focus_m, 1 + random() AS focus_raw_m,
    11.2 AS max_blur_px, CAST(random() < 0.01 AS BIGINT) AS dropped,
    CAST(0 AS BIGINT) AS missed_refreshes,
    CAST(i % {FRAMES_OF_A_TRIAL} = 0 AS BIGINT) AS discontinuity FROM range(ROWS) t(i)"""  # noqa: S608 - of numbers


def make_recording(folder: Path, rows: int) -> Path:
    """Write a session of `rows` frames, as CSV and packed; return its ``frames.csv``."""
    session = folder / "sub-P01" / "ses-1"
    session.mkdir(parents=True)
    file = session / "frames.csv"
    with (session / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("participant", "session", "trial", "start_s", "end_s"))
        for trial in range(math.ceil(rows / FRAMES_OF_A_TRIAL)):
            ends = (trial * FRAMES_OF_A_TRIAL, min((trial + 1) * FRAMES_OF_A_TRIAL, rows) - 1)
            writer.writerow(("P01", 1, trial + 1, *(each * PERIOD_NS / 1e9 for each in ends)))
    with Memory().database() as database:
        database.execute("SELECT setseed(0.5)")
        frames = _FRAMES.replace("ROWS", str(rows))
        database.execute(f"COPY ({frames}) TO '{file}' (HEADER)")
    subprocess.run([sys.executable, "-c", _PACK, str(folder)], check=True)
    return file


_PACK = (
    "import sys; from pathlib import Path; from vrcomfort.recordings import pack_study; "
    "from vrcomfort.records.recording import Memory; "
    "list(pack_study(Path(sys.argv[1]), Memory()))"
)

_LAGGED = (
    "head_x_m", "head_y_m", "head_z_m", "head_qx", "head_qy", "head_qz", "head_qw", "avatar_x_m",
    "avatar_y_m", "avatar_z_m", "focus_m", "max_blur_px", "xr_time_ns", "period_ns", "head_valid",
    "session_state", "trial",
)  # fmt: skip


def sql_by_hand(packed: Path, window: str) -> str:
    """Return the aggregates as one would write them without this program, in floating point."""
    lags = ", ".join(f"lag({name}) OVER ({window}) AS b_{name}" for name in _LAGGED)
    head = " + ".join(f"(head_{a}_m - b_head_{a}_m) ^ 2" for a in "xyz")
    avatar = " + ".join(f"(avatar_{a}_m - b_avatar_{a}_m) ^ 2" for a in "xyz")
    cosine = " + ".join(f"head_q{p} * b_head_q{p}" for p in "xyzw")
    late = "xr_time_ns - b_xr_time_ns > 1.2 * b_period_ns"
    passed = f"CASE WHEN {late} THEN b_period_ns ELSE xr_time_ns - b_xr_time_ns END"
    over = f"CASE WHEN {late} THEN xr_time_ns - b_xr_time_ns - b_period_ns END"
    steady = "same AND discontinuity <> 1 AND head_valid = 1 AND b_head_valid = 1"
    return f"""
        SELECT trial, count(*), sum(dropped), sum(missed_refreshes),
        sum({passed}) FILTER (same AND b_session_state <> 'visible') + max(period_ns),
        sum({passed}) FILTER (same AND b_session_state = 'visible'),
        sum({over}) FILTER (same AND dropped > 0), sum({over}) FILTER (same AND dropped = 0),
        sum(period_ns) FILTER (head_tracked = 0),
        sum(sqrt({head})) FILTER ({steady}), sum(sqrt({avatar})) FILTER ({steady}),
        sum(2 * acos(least(1, abs({cosine})))) FILTER ({steady}),
        sum(abs(1 / focus_m - 1 / b_focus_m)) FILTER (same AND discontinuity <> 1),
        avg(abs(1 / focus_m - 1 / focus_raw_m)),
        count(*) FILTER (same AND max_blur_px <> b_max_blur_px)
        FROM (SELECT *, b_trial = trial AS same FROM
            (SELECT *, {lags} FROM read_parquet('{packed}')))
        GROUP BY trial ORDER BY trial"""  # noqa: S608 - of names in this file


def once(way: str, file: Path) -> dict[str, float]:
    """Sum one recording and return processor time, peak memory and the whole path of the head."""
    start_s = time.process_time()
    if way == WAYS[0]:
        found, notes = frame_measures([file], Memory(MEMORY_MB * 10**6))
        assert not notes, notes  # noqa: S101 - else the CSV was measured
        path_m = sum(each.head_path_m for each in found)
    else:
        window = "" if way == WAYS[1] else "PARTITION BY trial ORDER BY xr_time_ns"
        with tempfile.TemporaryDirectory() as folder:
            database = duckdb.connect(
                config={"memory_limit": f"{MEMORY_MB}MB", "threads": 1, "temp_directory": folder}
            )
            rows = database.execute(sql_by_hand(parquet_of(file), window)).fetchall()
        path_m = sum(row[9] or 0 for row in rows)
    cpu_s = time.process_time() - start_s
    return {"cpu_s": cpu_s, "peak_mb": peak_mb(), "path_m": path_m}


def peak_mb() -> float:
    """Return the peak memory of this program (Linux; rusage may give its parent's)."""
    said = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    (line,) = (each for each in said if each.startswith("VmHWM"))
    return int(line.split()[1]) * 1024 / 1e6


def measure(rows: int, *, rounds: int = 3) -> Result:
    """Return a row for each number of frames: a sixteenth, a quarter, all."""
    table = []
    with tempfile.TemporaryDirectory() as folder:
        for part in (16, 4, 1):
            file = make_recording(Path(folder) / str(part), rows // part)
            runs: dict[str, list[dict[str, float]]] = {way: [] for way in WAYS}
            for _ in range(rounds):
                for way in WAYS:  # in turns: what else the machine does meets all of them
                    runs[way].append(in_a_program("bench.recordings", way, "--file", file))
            table.append(_row(rows // part, file, runs))
    for before, now in pairwise(table):
        ratio = now["ours, s of CPU"] / before["ours, s of CPU"]
        now["slope"] = math.log(ratio) / math.log(now["frames"] / before["frames"])
    return Result("Sums over frames, by exposure", table, _NOTES)


_NOTES = (
    "One session; 23 columns in Parquet (zstd). Each run is a program of its own on one thread; "
    "quickest of the rounds, the ways in turns. The peak is of the whole program.",
    f"The database by hand has {MEMORY_MB} MB of its own; ours keeps the whole program under that.",
)


def _row(rows: int, file: Path, runs: dict[str, list[dict[str, float]]]) -> dict[str, Any]:
    ours, ordered, by_trial = (min(each["cpu_s"] for each in runs[way]) for way in WAYS)
    paths = [runs[way][0]["path_m"] for way in WAYS]
    return {
        "frames": rows,
        "CSV, MB": Fingerprint.of(file).size / 1e6,
        "Parquet, MB": parquet_of(file).stat().st_size / 1e6,
        "ours, s of CPU": ours,
        "by hand, in order": ordered,
        "by hand, by trial": by_trial,
        "ours / faster by hand": ours / min(ordered, by_trial),
        "peak of ours, MB": max(each["peak_mb"] for each in runs[WAYS[0]]),
        "peak by trial, MB": max(each["peak_mb"] for each in runs[WAYS[2]]),
        "paths differ by": max(abs(path / paths[0] - 1) for path in paths),
        "slope": math.nan,
    }


def main() -> None:
    """Read the command line, make the recordings and sum them."""
    main_of_ways("bench.recordings", __doc__, "frames.csv", WAYS, once, measure)


if __name__ == "__main__":
    main()
