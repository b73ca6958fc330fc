"""Mutated protocols, plans, traces, gaze, answers and scenes: each loads, or is refused."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping
from datetime import date
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from openpyxl import Workbook

from torture import small_scene
from torture.case import OTHER, Result, Rig
from torture.mutate import worse
from torture.worker import named, workers
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.geometry import EyeGaze, Gaze, Pose
from vrcomfort.importing import import_files, load_mapping
from vrcomfort.importing.files import read_tables
from vrcomfort.importing.head_logs import suggest_log_mapping
from vrcomfort.importing.suggest import suggest_mapping
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import read_instrument, score_file, shipped_instruments
from vrcomfort.records import GazeRow, QuestionnaireRow
from vrcomfort.records.rows import csv_line
from vrcomfort.report.plan_files import load_plan
from vrcomfort.report.study_data import read_study
from vrcomfort.resources import Folder, data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.gaze_track import read_gaze
from vrcomfort.traces.trace import read_trace

SSQ = shipped_instruments()["ssq"]

GIGABYTES, CASE_S = 3, 120.0
TRACE_LINES = 120


class Kind(NamedTuple):
    """A kind of file: what its name is, what a good one holds, and who reads it."""

    name: str
    good: Callable[[], list[bytes]]
    read: Callable[[Path], object]
    beside: Callable[[], Mapping[str, bytes]] = dict


def torture(rig: Rig) -> Result:
    """Have mutated files read."""
    count = rig.count(6000, 900)
    limits: dict[str, Any] = {"name": _kind_of, "gigabytes": GIGABYTES, "case_s": CASE_S}
    with workers("torture.inputs", rig.place("inputs"), **limits) as pool:
        outcomes = list(rig.all("inputs", count, pool.run, limit_s=rig.count(240, 30)))
    how = (
        f"{', '.join(KINDS)} in turn, changed in their bytes or values, read under "
        f"{GIGABYTES} GiB of address space and {CASE_S:g} s: each loads whole or is refused in "
        "one sentence."
    )
    return Result("inputs", outcomes, how, count)


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Change a file and read it."""
    kind_name = _kind_of(number)
    kind, rng = KINDS[kind_name], np.random.default_rng(seed)
    good = _good(kind_name)
    file = folder / kind.name
    for name, content in kind.beside().items():
        (folder / name).write_bytes(content)
    file.write_bytes(worse(good[int(rng.integers(len(good)))], file.suffix, rng))
    fault = detail = ""
    try:
        with named(kind_name):
            kind.read(file)
    except InputError as error:
        if "\n" in str(error):
            fault, detail = OTHER, f"more than one line: {str(error)[:200]!r}"
    return {"name": kind_name, "fault": fault, "detail": detail}


def _kind_of(number: int) -> str:
    return list(KINDS)[number % len(KINDS)]


@cache
def _good(name: str) -> list[bytes]:
    return KINDS[name].good()


def _shipped(folder: Folder, names: str) -> Callable[[], list[bytes]]:
    return lambda: [file.read_bytes() for file in sorted(data_folder(folder).glob(names))]


def _walks() -> list[bytes]:
    return [
        b"".join(walk.splitlines(True)[:TRACE_LINES]) for walk in _shipped("scenes", "*walk.csv")()
    ]


def _gaze() -> list[bytes]:
    lines = [csv_line(GazeRow.columns())]
    ahead = Pose((0.0, 1.6, 0.0))
    for number in range(60):
        seen = number % 7 != 0
        left = EyeGaze(ahead, valid=seen, pupil_mm=3.5 if seen else None)
        right = EyeGaze(ahead, valid=number % 5 != 0) if number % 3 else None
        gaze = Gaze(ahead, valid=seen, eyes=(left, right))
        time_ns = number * 16_666_667
        row = GazeRow(time_ns / 1e9, time_ns, gaze, 2.5, "chair", "gaze" if seen else "held")
        lines.append(csv_line(row.cells()))
    return ["".join(lines).encode()]


def _unity() -> list[bytes]:
    rows = [f"{number / 60:.4f},0.1,1.6,{number / 100},0,{number},359.5" for number in range(60)]
    return ["\n".join(["Time x y z alpha beta gamma", *rows, ""]).encode()]


def _answers() -> list[bytes]:
    lines = [",".join(QuestionnaireRow.columns())]
    for trial, condition in enumerate(("", "plain", "dof")):
        place = f"1,1,{trial},{condition},post" if trial else ",,,,baseline"
        lines += [
            f"P01,1,{place},ssq,{item.name},{order % 4},{order}.5,{order + 2}.25,{order},,0"
            for order, item in enumerate(SSQ.items, start=1)
        ]
    return ["\n".join([*lines, ""]).encode()]


def _wide_answers() -> list[bytes]:
    names = [item.name for item in SSQ.items]
    rows = [",".join(["participant", *names])]
    rows += [",".join([f"P{row}", *("0123"[row % 4] for _ in names)]) for row in range(6)]
    return ["\n".join([*rows, ""]).encode()]


def _workbooks() -> list[bytes]:
    """Return a workbook with merged headings, a date and a formula's place."""
    book = Workbook()
    sheet = book.worksheets[0]
    sheet.append(["code", "day", "before", None, "after", None])
    sheet.append([None, None, *[item.name for item in SSQ.items[:2]] * 2])
    for row in range(6):
        sheet.append([f"P{row}", date(2026, 3, 1 + row), row % 4, 0.5, "slight", row % 2 == 0])
    for merged in ("A1:A2", "B1:B2", "C1:D1", "E1:F1"):
        sheet.merge_cells(merged)
    more = book.create_sheet("more")
    for row in (["code", "age"], ["P1", 31], ["P2", 29.5]):
        more.append(row)
    file = io.BytesIO()
    book.save(file)
    return [file.getvalue()]


def _lab_json() -> list[bytes]:
    rows = [{"code": f"P{n}", "ssq": {"nausea": n % 4, "when": ["pre", 1]}} for n in range(6)]
    columns = {"code": ["P1", "P2"], "nausea": [1, 2.5]}
    return [json.dumps(each).encode() for each in (rows, columns, {"P1": rows[0], "P2": rows[1]})]


def _mapping() -> list[bytes]:
    """Return a mapping that says of a table what can be said."""
    others = [item.name for item in SSQ.items if item.name not in {"nausea", "fatigue"}]
    return [
        f"""format_version = 1
name = "A study"
condition_labels = {{ a_1 = "60 Hz" }}
ignore_sheets = ["notes"]

[[tables]]
files = ["*.csv"]
read = {{ separator = ";", decimal = ".", heading_rows = [1], skip_rows = [2] }}
participant = {{ column = "code", values = {{ "p 1" = "P1" }} }}
condition = {{ columns = ["group", "round"] }}
trial = {{ count = true }}
participants = {{ age = "Age" }}
leave_out = {{ code = ["Mean", ""] }}
missing = ["-99"]
ignore = ["Date"]

[[tables.questionnaires]]
instrument = "ssq"
heading = "{{timepoint}}_{{item}}"
answers = {{ none = 0, slight = 1 }}
items = {{ nausea = "Nausea", fatigue = ["Fatigue", "Tired"] }}
item_coding = {{ nausea = {{ coded_from = 1, times = 2.0 }} }}
not_asked = {others}

[[tables.scores]]
instrument = "ssq"
pattern = '(?P<item>T|N)_(?P<timepoint>.+)'
kind = "other"
scales = {{ T = "T" }}

[[doubts]]
question = "Is it?"
answer = "yes"
""".encode()
    ]


LAB_TABLE = """code;group;round;Age;Date;pre_Nausea;pre_Tired;T_pre
in words;;;;;;;
p 1;a;1;30;x;1;slight;22.740000000000002
"""


def _read_mapping(file: Path) -> object:
    """Read a mapping, and a table as it says."""
    table = file.with_name("lab.csv")
    table.write_text(LAB_TABLE, encoding="utf-8")
    loaded = load_mapping(file)
    return import_files([table], loaded.mapping, loaded.instruments)


def _read_protocol(file: Path) -> object:
    return build_design(load_protocol(file), seed=0)


def _side_cars() -> list[bytes]:
    """Return what shipped ones say of light and floors: nodes are their own scenes'."""
    return [text.partition(b"\n[nodes")[0] for text in _shipped("scenes", "*.toml")()]


def _scene_file() -> list[bytes]:
    return [json.dumps(small_scene.whole()).encode()]


KINDS: Mapping[str, Kind] = {
    "protocols": Kind("protocol.toml", _shipped("protocols", "*.toml"), _read_protocol),
    "analysis plans": Kind("plan.toml", _shipped("analysis", "*.toml"), load_plan),
    "instruments": Kind("mine.toml", _shipped("instruments", "*.toml"), read_instrument),
    "traces": Kind("trace.csv", _walks, read_trace),
    "gaze": Kind("gaze.csv", _gaze, read_gaze),
    "head logs": Kind("unity.csv", _unity, suggest_log_mapping),
    "questionnaires": Kind("questionnaires.csv", _answers, read_study),
    "scores": Kind("scores.csv", _wide_answers, lambda file: score_file(file, SSQ)),
    "workbooks": Kind("lab.xlsx", _workbooks, read_tables),
    "JSON of labs": Kind("lab.json", _lab_json, read_tables),
    "tables of labs": Kind("lab.csv", _wide_answers, lambda file: suggest_mapping([file])),
    "mappings": Kind("map.toml", _mapping, _read_mapping),
    "glTF": Kind("scene.gltf", _scene_file, load_scene),
    "binary glTF": Kind("scene.glb", lambda: [small_scene.glb(small_scene.whole())], load_scene),
    "side-cars": Kind(
        "room.toml",
        _side_cars,
        lambda file: load_scene(file.with_suffix(".gltf")),
        lambda: {"room.gltf": _scene_file()[0]},
    ),
}
