"""A value of any type, in any place of a settings file, is refused in words or means something."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.places import ROOT
from vrcomfort.errors import InputError
from vrcomfort.importing.mapping import LabMapping
from vrcomfort.protocol import Protocol
from vrcomfort.questionnaire.instrument_file import InstrumentTable
from vrcomfort.report.plan_files import AnalysisPlan as Plan
from vrcomfort.resources import data_folder
from vrcomfort.scene.side_car import SideCar
from vrcomfort.settings import Settings
from vrcomfort.settings.reading import parse_data

FILES: dict[type[Settings], list[Path]] = {
    Protocol: sorted(data_folder("protocols").glob("*.toml")),
    Plan: sorted(data_folder("analysis").glob("*.toml")),
    InstrumentTable: sorted(data_folder("instruments").glob("*.toml")),
    SideCar: sorted(data_folder("scenes").glob("*.toml")),
    LabMapping: [ROOT / "tests" / "data/fms/mapping.toml"],
}
WRONG: tuple[Any, ...] = ({"x": {"x": 1}}, [["x"]], [{}], 10**30, float("nan"), "\u2028")


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    for key, each in value.items() if isinstance(value, dict) else enumerate(value):
        yield (*path, key)
        if isinstance(each, dict | list):
            yield from places(each, (*path, key))


def with_value(root: dict[str, Any], place: tuple[Any, ...], value: Any) -> dict[str, Any]:
    changed = holder = copy.deepcopy(root)
    for key in place[:-1]:
        holder = holder[key]
    holder[place[-1]] = value
    return changed


@pytest.mark.parametrize("model", FILES, ids=lambda model: model.__name__)
def test_no_value_of_another_type_ends_in_a_traceback(model):
    done: set[tuple[Any, ...]] = set()
    for file in FILES[model]:
        root = tomllib.loads(file.read_text("utf-8"))
        for place in places(root):
            kind = tuple(0 if isinstance(key, int) else key for key in place)
            if kind in done:
                continue
            done.add(kind)
            for value in WRONG:
                try:
                    parse_data(model, with_value(root, place, value), lambda _: InputError(""))
                except InputError:
                    continue
    assert len(done) > 5
