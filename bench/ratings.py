"""Cost of long ratings: `python -m bench.ratings [--rows 10000000]`.

Makes a study of four exposures a person, 10,000 ratings each, packs it, and in programs of their
own, on one thread: scans the Parquet file with DuckDB (count, mean, peak and last rating of each
exposure), reads and summarises the ratings as a report does (peak, mean, last, area, slope), and
makes the whole report. Ratios are those of processor time in one run.
"""

from __future__ import annotations

import csv
import tempfile
import time
from pathlib import Path
from typing import Any

from bench.apart import in_a_program, main_of_ways
from bench.recordings import peak_mb
from bench.table import Result
from vrcomfort.recordings.pack import pack
from vrcomfort.records.recording import Memory, parquet_of
from vrcomfort.report.build import build_report
from vrcomfort.report.rated_exposures import rated_exposures
from vrcomfort.report.ratings.time_courses import SUMMARIES
from vrcomfort.report.study_data import read_study

RATINGS_OF_AN_EXPOSURE, CONDITIONS = 10_000, ("off", "weak", "middle", "strong")
LENGTH_S = 500.0

_RATINGS = f"""
    SELECT 'P' || lpad(CAST(i // {4 * RATINGS_OF_AN_EXPOSURE} AS VARCHAR), 4, '0') AS participant,
    1 AS session, 1 + (i // {RATINGS_OF_AN_EXPOSURE}) % 4 AS trial,
    {list(CONDITIONS)}[1 + (i // {RATINGS_OF_AN_EXPOSURE}) % 4] AS condition,
    round(600 * (1 + (i // {RATINGS_OF_AN_EXPOSURE}) % 4) + (i % {RATINGS_OF_AN_EXPOSURE}) * 0.05,
        3) AS onset_s,
    0.0 AS latency_s, 'fms' AS instrument,
    CASE WHEN i % 97 > 0 THEN greatest(0, least(20, round(5 * sin(i * 0.0001)
        + (i % {RATINGS_OF_AN_EXPOSURE}) / 1000 + random() * 2, 2))) END AS response,
    CAST(i % 97 = 0 AS INTEGER) AS missed, 0 AS resumed FROM range(ROWS) t(i)"""  # noqa: S608 - of numbers

_PLAN = """
name = "ratings"
title = "Ratings"
outcomes = ["ratings.peak"]
anova = []
"""
_SCAN = """
    SELECT participant, session, trial, condition, instrument, count(*), avg(response),
    max(response), arg_max(response, onset_s), min(onset_s), max(onset_s)
    FROM read_parquet('FILE') GROUP BY ALL"""


def make_study(folder: Path, rows: int) -> Path:
    """Write a study of `rows` ratings, as CSV and packed; return its ``ratings.csv``."""
    folder.mkdir(parents=True)
    file = folder / "ratings.csv"
    with Memory().database() as database:
        database.execute("SELECT setseed(0.5)")
        database.execute(f"COPY ({_RATINGS.replace('ROWS', str(rows))}) TO '{file}' (HEADER)")
    with (folder / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        names = ("participant", "session", "trial", "condition", "scene", "status")
        writer.writerow((*names, "start_s", "end_s"))
        for exposure in range(-(-rows // RATINGS_OF_AN_EXPOSURE)):
            person, place = divmod(exposure, 4)
            start_s = 600.0 * (1 + place)
            where = (f"P{person:04d}", 1, 1 + place, CONDITIONS[place], "near", "completed")
            writer.writerow((*where, start_s, start_s + LENGTH_S))
    pack(folder, Memory(), file)  # the command leaves short files as they are
    return file


def once(way: str, file: Path) -> dict[str, float]:
    """Return processor time, peak memory, and the sum of all peaks of ratings."""
    start_s = time.process_time()
    total = _WAYS[way](file)
    return {"cpu_s": time.process_time() - start_s, "peak_mb": peak_mb(), "total": total}


def _scan(file: Path) -> float:
    with Memory().database() as database:
        rows = database.execute(_SCAN.replace("FILE", str(parquet_of(file)))).fetchall()
    return float(sum(row[7] for row in rows))


def _summarised(file: Path) -> float:
    study = read_study(file.parent)
    found = [
        {name: of(each.course) for name, of in SUMMARIES.items()}
        for each in rated_exposures(study, "fms")
    ]
    return float(sum(each["peak"] or 0.0 for each in found))


def _unpacked(file: Path) -> float:
    parquet_of(file).rename(file.with_suffix(".away"))
    try:
        return _summarised(file)
    finally:
        file.with_suffix(".away").rename(parquet_of(file))


def _reported(file: Path) -> float:
    plan = file.with_name("plan.toml")
    plan.write_text(_PLAN, encoding="utf-8")
    build_report(file.parent, out=file.parent.parent / "report", plan=plan, forms=("svg",))
    return 0.0


_WAYS = {"scan": _scan, "packed": _summarised, "CSV": _unpacked, "report": _reported}


def measure(rows: int, *, rounds: int = 3) -> Result:
    """Return a row for each number of ratings: a sixteenth, a quarter, all."""
    table = []
    with tempfile.TemporaryDirectory() as folder:
        for part in (16, 4, 1):
            file = make_study(Path(folder) / str(part), rows // part)
            runs: dict[str, list[dict[str, float]]] = {way: [] for way in _WAYS}
            for _ in range(rounds):
                for way in _WAYS:  # in turns: what else the machine does meets all of them
                    asked = (way, "--file", file)
                    runs[way].append(in_a_program("bench.ratings", *asked, one_thread=True))
            table.append(_row(rows // part, file, runs))
    return Result("Ratings during exposure", table, _NOTES)


_NOTES = (
    "Four exposures a person, 10,000 ratings each. Each run is a program of its own on one thread; "
    "quickest of the rounds, the ways in turns. Peaks are of the whole program.",
    "The scan is DuckDB's of the Parquet file: number, mean, peak and last of each exposure. "
    "Ours reads the study and sums up peak, mean, last rating, area and slope.",
)


def _row(rows: int, file: Path, runs: dict[str, list[dict[str, float]]]) -> dict[str, Any]:
    cpu_s = {way: min(each["cpu_s"] for each in made) for way, made in runs.items()}
    peak = {way: max(each["peak_mb"] for each in made) for way, made in runs.items()}
    if abs(runs["scan"][0]["total"] - runs["packed"][0]["total"]) > 1e-6:
        raise AssertionError("the ways do not agree")
    return {
        "ratings": rows,
        "CSV, MB": file.stat().st_size / 1e6,
        "Parquet, MB": parquet_of(file).stat().st_size / 1e6,
        "scan, s of CPU": cpu_s["scan"],
        "read and summarised": cpu_s["packed"],
        "ratio": cpu_s["packed"] / cpu_s["scan"],
        "from the CSV": cpu_s["CSV"],
        "whole report": cpu_s["report"],
        "peak, MB": peak["packed"],
        "peak from the CSV, MB": peak["CSV"],
        "peak of the report, MB": peak["report"],
    }


def main() -> None:
    """Read the command line, make the studies and read them."""
    main_of_ways("bench.ratings", __doc__, "ratings.csv", _WAYS, once, measure)


if __name__ == "__main__":
    main()
