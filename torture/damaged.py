"""Files of interrupted sessions that something has damaged, into whatever reads a study."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import shutil
import signal
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from torture.case import HANG, OTHER, Outcome, Result, Rig
from torture.mutate import Rng, in_json, pick, worse
from torture.rows import TRIALS, session_folder
from torture.session import Ended, Victim, run_words
from torture.worker import named, workers
from vrcomfort.cli import main as command_line

START_S, CASE_S = 180.0, 120.0
BEFORE_RENEWAL = 40
"""Cases of one process: each opens OpenGL again."""

REFERENCE = "interrupted"


def torture(rig: Rig) -> Result:
    """Interrupt one session, and damage copies of it."""
    folder = rig.place("damaged")
    if (fault := _interrupt(folder / REFERENCE)) is not None:
        return Result("damaged", [fault], "no session could be interrupted")
    limits: dict[str, Any] = {
        "name": _command_of,
        "gigabytes": 0,
        "case_s": CASE_S,
        "renewed": BEFORE_RENEWAL,
    }
    count = rig.count(400, 78)
    with workers("torture.damaged", folder, **limits) as pool:
        outcomes = list(rig.all("damaged", count, pool.run, limit_s=rig.count(300, 45)))
    how = (
        "Copies of a session that was killed in its third exposure, damaged in one or two places "
        "(values of the manifest, cells, bytes, zeros at the end, files gone, a trial that nobody "
        "planned), into each command that reads a study, in turn: exit code 0, or 2 with one "
        "sentence (1 from verify). "
        "Rows count that stood in files which were not damaged."
    )
    return Result("damaged", outcomes, how, count)


def _interrupt(folder: Path) -> Outcome | None:
    folder.mkdir(parents=True)
    victim = Victim(run_words(folder / "study"), folder / "said.txt")

    def in_last_exposure() -> bool:
        shown = [
            row for row in victim.rows("frames.csv") if dict(row.cells)["trial"] == str(TRIALS)
        ]
        return len(shown) > 20

    reached = victim.wait_for(in_last_exposure, START_S)
    victim.send(signal.SIGKILL)
    ended = victim.end(START_S)
    return None if reached else Outcome("interrupting", 0, fault=HANG, detail=ended.said[-300:])


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Damage a copy, and give it to a command."""
    study = folder / "study"
    shutil.rmtree(study, ignore_errors=True)
    shutil.copytree(folder.parent / REFERENCE / "study", study)
    before = {file: file.read_bytes() for file in session_folder(study).glob("*.csv")}
    done = damage(study, number, np.random.default_rng(seed))
    wanted = _command_of(number)
    resumed = wanted == "--resume"
    changes = "; ".join(f"{file}: {change}" for file, change in done.items())
    name = f"{wanted} after {changes}"
    with named(name):
        ended = command(run_words(study, "--resume") if resumed else _words(wanted, study))
    told = wanted == "verify" and ended.code == 1
    fault, detail = ("", "") if told else ended.fault({0, 2})
    handed, lost = _rows_kept(before, done)
    if not fault and resumed and ended.code == 0 and "nobody planned" in "".join(done.values()):
        fault, detail = _all_shown(study)
    return {"name": name, "handed": handed, "lost": lost, "fault": fault, "detail": detail}


COMMANDS = (
    "--resume", "report", "verify", "status", "pack", "play", "anonymise", "export bids",
    "export psych-ds",
)  # fmt: skip


def _command_of(number: int) -> str:
    """Return what a case runs: the known damages go into the first two commands."""
    known = number // 2 < len(KNOWN)
    return COMMANDS[number % (2 if known else len(COMMANDS))]


def _words(wanted: str, study: Path) -> list[str]:
    """Return the words of a command that reads a study."""
    name, _, form = wanted.partition(" ")
    out = study.with_name(name)
    shutil.rmtree(out, ignore_errors=True)
    source = session_folder(study) if name == "play" else study
    options = {
        "report": ["--out", str(out), "--quiet"],
        "play": ["--out", str(out), "--to", "0.5", "--quiet"],
        "anonymise": ["--out", str(out)],
        "export": ["--format", form, "--out", str(out)],
    }
    return [name, str(source), *options.get(name, [])]


def command(words: list[str]) -> Ended:
    """Run a command in this process; an exception that it does not hear of itself goes on."""
    said = io.StringIO()
    code: int | None = 0
    sys.argv = ["vrcomfort", *words]
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        try:
            command_line()
        except SystemExit as end:
            code = int(end.code or 0)
    return Ended(code, said.getvalue())


def damage(study: Path, number: int, rng: Rng) -> dict[str, str]:
    """Damage a study; return file → what was done to it. The known damages come first."""
    changes = list(KNOWN)
    if number // 2 < len(changes):
        name = changes[number // 2]
        file, change = KNOWN[name]
        path = session_folder(study) / file
        path.write_bytes(change(path.read_bytes()))
        return {file: name}
    done = {}
    files = sorted(file for file in study.rglob("*") if file.suffix in {".csv", ".json"})
    for path in [pick(rng, files) for _ in range(int(rng.integers(1, 3)))]:
        if rng.random() < 0.1:
            path.unlink(missing_ok=True)
            done[path.name] = "gone"
        elif path.exists():
            path.write_bytes(_worse(path, rng))
            done[path.name] = "changed"
    return done


def _worse(path: Path, rng: Rng) -> bytes:
    """Change a file; of a manifest mostly what the program reads again."""
    content = path.read_bytes()
    if path.suffix == ".json" and content and rng.random() < 0.7:
        with contextlib.suppress(ValueError, TypeError, IndexError):
            return in_json(content, rng, top=True)
    return worse(content, path.suffix, rng) if content else b"\0" * 9


def _rows_kept(before: Mapping[Path, bytes], done: Mapping[str, str]) -> tuple[int, int]:
    """Return how many whole rows undamaged files had, and how many of them are gone."""
    handed = lost = 0
    for file, content in before.items():
        if file.name in done:
            continue
        rows = content.splitlines(keepends=True)[1:]
        whole = [row for row in rows if row.endswith(b"\n")]
        there = set(file.read_bytes().splitlines(keepends=True)) if file.exists() else set()
        handed += len(whole)
        lost += sum(row not in there for row in whole)
    return handed, lost


def _all_shown(study: Path) -> tuple[str, str]:
    """Say whether every planned exposure was shown to its end."""
    with (session_folder(study) / "trials.csv").open(encoding="utf-8", newline="") as stream:
        done = {row["trial"] for row in csv.DictReader(stream) if row["status"] == "completed"}
    wanted = {str(number) for number in range(1, TRIALS + 1)}
    return (OTHER, f"shown: {sorted(done)}") if wanted - done else ("", "")


def _manifest(**values: Any) -> tuple[str, Callable[[bytes], bytes]]:
    def change(content: bytes) -> bytes:
        return json.dumps(json.loads(content) | values).encode()

    return "manifest.json", change


def _cell(file: str, column: str, value: str) -> tuple[str, Callable[[bytes], bytes]]:
    """Change a cell of the last row."""

    def change(content: bytes) -> bytes:
        rows = list(csv.reader(io.StringIO(content.decode(), newline="")))
        rows[-1][rows[0].index(column)] = value
        text = io.StringIO(newline="")
        csv.writer(text, lineterminator="\n").writerows(rows)
        return text.getvalue().encode()

    return file, change


def _unplanned(content: bytes) -> bytes:
    """Repeat the last row as one of trial 99."""
    header, *rows = content.decode().splitlines()
    cells = rows[-1].split(",")
    cells[header.split(",").index("trial")] = "99"
    return content + ",".join(cells).encode() + b"\n"


KNOWN: Mapping[str, tuple[str, Callable[[bytes], bytes]]] = {
    "memory = {}": _manifest(memory={}),
    "memory = 1": _manifest(memory=1),
    "earlier_runs = 1": _manifest(earlier_runs=1),
    "status = []": _manifest(status=[]),
    "under_way = {}": _manifest(under_way={}),
    "under_way = [1]": _manifest(under_way=[1]),
    "protocol = []": _manifest(protocol=[]),
    "exposure_s = inf": _manifest(exposure_s=float("inf")),
    "exposure_s = 'x'": _manifest(exposure_s="x"),
    "seed = nan": _manifest(seed=float("nan")),
    "timing_flags = 1": _manifest(timing_flags=1),
    "a list": ("manifest.json", lambda _: b"[]\n"),
    "no file content": ("manifest.json", lambda _: b""),
    "answered at inf": _cell("questionnaires.csv", "answered_s", "inf"),
    "answered at 1e300": _cell("questionnaires.csv", "answered_s", "1e300"),
    "onset at -inf": _cell("events.csv", "onset_s", "-inf"),
    "onset at 1e300": _cell("events.csv", "onset_s", "1e300"),
    "frame at nan": _cell("frames.csv", "session_s", "nan"),
    "frame at 10^30 ns": _cell("frames.csv", "xr_time_ns", "1" + "0" * 30),
    "attempt 10^30": _cell("trials.csv", "attempt", "1" + "0" * 30),
    "trial 0": _cell("trials.csv", "trial", "0"),
    "trial 99, which nobody planned": ("trials.csv", _unplanned),
    "an end at inf": _cell("trials.csv", "end_s", "inf"),
    "zeros at the end of trials": ("trials.csv", lambda content: content + bytes(64)),
    "zeros at the end of answers": ("questionnaires.csv", lambda content: content + bytes(64)),
    "zeros at the end of events": ("events.csv", lambda content: content + bytes(4096)),
    "zeros at the end of frames": ("frames.csv", lambda content: content + bytes(700)),
    "zeros for the last half of ratings": (
        "ratings.csv",
        lambda content: content[: len(content) // 2] + bytes(len(content) - len(content) // 2),
    ),
    "half a row of answers": ("questionnaires.csv", lambda content: content[:-9]),
    "only zeros": ("ratings.csv", lambda content: bytes(len(content))),
}
"""What has fallen once, or what power cuts leave; each into `--resume` and into `report`."""
