"""Mutated files of every kind through every command that reads them, each in a child of its own."""

from __future__ import annotations

import contextlib
import csv
import importlib
import json
import os
import pkgutil
import resource
import shutil
import signal
import traceback
from collections.abc import Callable, Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from openpyxl import Workbook

import vrcomfort
from torture import inputs, resumed
from torture.case import OTHER, Result, Rig
from torture.damaged import command
from torture.mutate import in_bytes, in_json, pick, worse
from torture.session import Ended
from torture.worker import named, workers
from vrcomfort.resources import data_folder

MOST_BYTES, MOST_S = 2 << 30, 30
CASE_S = 180.0
REFERENCE = "reference"
OUT = "out"
MANIFEST = "study/sub-*/ses-*/manifest.json"
TABLES = "study/sub-*/ses-*/*.csv"
SPECIAL = 0.02
"""Share of cases in which a pipe, or a link to a device, takes the place of the file."""


class Reading(NamedTuple):
    """A command, and which of the files that it reads is changed.

    Parameters
    ----------
    pattern
        Of the file, in the folder that holds everything.
    words
        Of the command line; it runs in that folder.
    """

    pattern: str
    words: tuple[str, ...]


def _readings() -> list[Reading]:
    study = {
        "verify study": (MANIFEST, TABLES, "study/*.*", "study/sub-*/ses-*/checksums.sha256"),
        "status study": (MANIFEST, "study/*.*", TABLES),
        "pack study": ("study/sub-*/ses-*/frames.csv", "study/sub-*/ses-*/gaze.csv"),
        "export study --format bids --out out": (MANIFEST, TABLES, "study/*.*"),
        "export study --format psych-ds --out out": (MANIFEST, TABLES, "study/*.*"),
        "anonymise study --out out": (MANIFEST, TABLES, "study/*.*"),
        "report study --figures none --out out --quiet": (
            MANIFEST, TABLES, "study/*.*", "study/sub-*/ses-*/*.parquet",
        ),
        "play study/sub-P01/ses-1 --to 5 --protocol protocol.toml --size 32x40 --out out": (
            MANIFEST, TABLES,
        ),
        "design protocol.toml --study study": (MANIFEST, "study/*.*", "protocol.toml"),
        "note study P01 text": (MANIFEST, "study/*.*"),
        "exclude study P01 --reason why": ("study/*.*",),
        "undo-exclusion study P03 --reason why": ("study/participants.csv",),
        "undo-withdrawal study P01 --reason why": (MANIFEST, "study/*.*"),
        "simulate protocol.toml -n 4 --no-draw --out study --quiet": (
            MANIFEST, "study/*.*", TABLES, "protocol.toml",
        ),
    }  # fmt: skip
    others = {
        "check shipped.toml --no-draw": ("shipped.toml",),
        "check protocol.toml --no-draw": ("protocol.toml", "room.gltf"),
        "passes protocol.toml --no-draw": ("protocol.toml", "room.gltf"),
        "design shipped.toml": ("shipped.toml",),
        "power plan.toml --effect 0.5sd --participants 8:10 --studies 100": ("plan.toml",),
        "score scores.csv": ("scores.csv",),
        "score scores.csv --instrument mine.toml": ("mine.toml",),
        "import lab.xlsx --suggest --out out.toml": ("lab.xlsx",),
        "import scores.xlsx --suggest --out out.toml": ("scores.xlsx",),
        "import scores.xlsx --mapping book.toml --out out": ("scores.xlsx", "book.toml"),
        "import lab.json --suggest --out out.toml": ("lab.json",),
        "import lab.csv --suggest --out out.toml": ("lab.csv",),
        "import table.csv --mapping map.toml --out out": ("map.toml", "table.csv"),
        "import-trace unity.csv --out out.csv": ("unity.csv",),
        "import-trace unity.csv --suggest --out out.toml": ("unity.csv",),
        "import-trace unity.csv --mapping head.toml --out out.csv": ("unity.csv", "head.toml"),
        "report questionnaires.csv --figures none --out out --quiet": ("questionnaires.csv",),
        "report questionnaires.csv --plan plan.toml --figures none --out out --quiet": (
            "plan.toml",
        ),
        "report imported --figures none --out out --quiet": ("imported/*.*",),
        "verify imported": ("imported/*.*",),
        "export imported --format psych-ds --out out": ("imported/*.*",),
        "export imported --format bids --out out": ("imported/*.*",),
        "anonymise imported --out out": ("imported/*.*",),
    }
    return [
        Reading(file, tuple(words.split()))
        for words, files in chain(study.items(), others.items())
        for file in files
    ]


READINGS: Sequence[Reading] = _readings()


def torture(rig: Rig) -> Result:
    """Have every command read mutated files."""
    folder = rig.place("commands")
    make(folder / REFERENCE)
    count = rig.count(4000, 2 * len(READINGS))
    limits: dict[str, Any] = {"name": _name_of, "gigabytes": 0, "case_s": CASE_S}
    with workers("torture.commands", folder, **limits) as pool:
        outcomes = list(rig.all("commands", count, pool.run, limit_s=rig.count(900, 45)))
    how = (
        f"{len(READINGS)} pairs of a command and a file that it reads (protocols, plans, studies, "
        "recordings in CSV and Parquet, imports, mappings, workbooks, JSON), in turn: the file is "
        "changed in its bytes or values, or a pipe or a link to a device is in its place. Exit "
        f"code 0, or 2 with a sentence (1 from verify), in {MOST_S} s of processor time and "
        f"{MOST_BYTES >> 30} GiB."
    )
    return Result("commands", outcomes, how, count)


def _name_of(number: int) -> str:
    reading = READINGS[number % len(READINGS)]
    return f"{' '.join(reading.words)} ({reading.pattern})"


def make(folder: Path) -> None:
    """Make the good files, all of which the commands take."""
    folder.mkdir(parents=True)
    shutil.copy(resumed.STUDY, folder / "protocol.toml")
    shutil.copy(resumed.STUDY.with_name("room.gltf"), folder)
    shutil.copy(data_folder("protocols") / "carnegie_2015.toml", folder / "shipped.toml")
    good = {name: kind.good()[0] for name, kind in inputs.KINDS.items()}
    for file, kind in {
        "plan.toml": "analysis plans", "scores.csv": "scores",
        "lab.csv": "scores", "lab.xlsx": "workbooks", "lab.json": "JSON of labs",
        "unity.csv": "head logs", "questionnaires.csv": "questionnaires",
        "map.toml": "mappings",
    }.items():  # fmt: skip
        content = good[kind].replace(b",plain,", b",dof_off,").replace(b",dof,", b",dof_on,")
        (folder / file).write_bytes(content)
    table = inputs.LAB_TABLE.replace("pre", "post")
    (folder / "table.csv").write_text(table, encoding="utf-8")
    shutil.copy(data_folder("instruments") / "ssq.toml", folder / "mine.toml")
    book = Workbook()
    for row in csv.reader(good["scores"].decode().splitlines()):
        book.worksheets[0].append(row)
    book.save(folder / "scores.xlsx")
    resumed.work(folder / "study", resume=False)
    for words in (
        "pack study",
        "import table.csv --mapping map.toml --out imported",
        "import scores.xlsx --suggest --out book.toml",
        "import-trace unity.csv --suggest --out head.toml",
        "simulate protocol.toml -n 3 --no-draw --out study --quiet",
        "exclude study P03 --reason why",
    ):
        ended, _ = in_child(folder, lambda words=words: command(words.split()))
        if ended.code:
            raise RuntimeError(f"{words}: {ended.said}")
    file = folder / "book.toml"
    file.write_text(file.read_text("utf-8").replace('answer = ""', 'answer = "yes"'), "utf-8")


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Change a file, and let a command read it."""
    import_all()
    reading, rng = READINGS[number % len(READINGS)], np.random.default_rng(seed)
    place = folder / "files"
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(folder.parent / REFERENCE, place)
    files = sorted(file for file in place.glob(reading.pattern) if file.is_file())
    done = f"{_name_of(number)}, {_change(pick(rng, files), rng)}"
    with named(done):
        ended, used = in_child(place, lambda: command(list(reading.words)))
    codes = {0, 1, 2} if reading.words[0] == "verify" else {0, 2}
    fault, detail = ended.fault(codes, several=True)
    if reading.words[0] == "verify" and ended.code == 1:
        fault, detail = "", ""
    peak, took_s = used.ru_maxrss * 1024, used.ru_utime + used.ru_stime
    if not fault and (peak > MOST_BYTES or took_s > MOST_S):
        fault, detail = OTHER, f"{took_s:.1f} s of processor time, {peak / 1e9:.2f} GB"
    return {"name": done, "fault": fault, "detail": detail}


def _change(file: Path, rng: np.random.Generator) -> str:
    """Make a file worse; return how."""
    content = file.read_bytes()
    if rng.random() < SPECIAL:
        file.unlink()
        if rng.random() < 0.5:
            os.mkfifo(file)
            return f"{file.name} a pipe"
        file.symlink_to("/dev/zero")
        return f"{file.name} a link to a device"
    if file.suffix == ".json" and rng.random() < 0.3:
        with contextlib.suppress(ValueError, TypeError, IndexError):
            file.write_bytes(in_json(content, rng, top=True))
            return f"a key of {file.name}"
    change = in_bytes if file.suffix in {".parquet", ".sha256"} else None
    file.write_bytes(change(content, rng) if change else worse(content, file.suffix, rng))
    return f"{file.name} changed"


@cache
def import_all() -> None:
    """Import what commands import, once for all children."""
    for each in pkgutil.walk_packages(vrcomfort.__path__, "vrcomfort."):
        if not each.name.endswith("__main__"):
            importlib.import_module(each.name)
    for name in ("duckdb", "matplotlib.pyplot", "openpyxl", "pandas", "pingouin", "lifelines"):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)


def in_child(folder: Path, work: Callable[[], Ended]) -> tuple[Ended, resource.struct_rusage]:
    """Do work in a forked child that stands in `folder`; return its end, and what it took.

    An exception that the work does not catch is the end with ``Traceback`` in its words.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        try:
            os.chdir(folder)
            resource.setrlimit(resource.RLIMIT_CPU, (2 * MOST_S, 2 * MOST_S + 5))
            signal.alarm(int(CASE_S) - 30)
            try:
                ended = work()
            except BaseException:
                ended = Ended(1, traceback.format_exc())
            with os.fdopen(writing, "w", encoding="utf-8", errors="replace") as told:
                json.dump(ended, told)
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, encoding="utf-8") as told:
        said = told.read()
    _, status, used = os.wait4(child, 0)
    if said:
        return Ended(*json.loads(said)), used
    code = os.waitstatus_to_exitcode(status)
    hung = code in {-signal.SIGXCPU, -signal.SIGALRM, -signal.SIGKILL}
    return Ended(None if hung else code, f"Traceback: ended with {code}"), used
