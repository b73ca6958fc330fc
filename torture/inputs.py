"""Mutated protocols, plans, traces, gaze, answers and scenes: each loads, or is refused."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from torture import small_scene
from torture.case import OTHER, Result, Rig
from torture.mutate import worse
from torture.worker import named, workers
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.geometry import EyeGaze, Gaze, Pose
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import read_instrument, score_file, shipped_instruments
from vrcomfort.records import GazeRow, QuestionnaireRow
from vrcomfort.records.rows import csv_line
from vrcomfort.report.plan import load_plan
from vrcomfort.report.study_data import read_study
from vrcomfort.resources import Folder, data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.gaze_track import read_gaze
from vrcomfort.traces.trace import import_trace, read_trace

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
    "logs of Unity": Kind("unity.csv", _unity, import_trace),
    "questionnaires": Kind("questionnaires.csv", _answers, read_study),
    "scores": Kind("scores.csv", _wide_answers, lambda file: score_file(file, SSQ)),
    "glTF": Kind("scene.gltf", _scene_file, load_scene),
    "binary glTF": Kind("scene.glb", lambda: [small_scene.glb(small_scene.whole())], load_scene),
    "side-cars": Kind(
        "room.toml",
        _side_cars,
        lambda file: load_scene(file.with_suffix(".gltf")),
        lambda: {"room.gltf": _scene_file()[0]},
    ),
}
