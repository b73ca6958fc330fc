"""What a draft does not read is asked about: cells, rows, columns and people."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.layouts import CONDITIONS, PEOPLE, study, write
from vrcomfort.errors import InputError
from vrcomfort.importing.files import as_table, read_grids
from vrcomfort.importing.source import Reading
from vrcomfort.importing.suggest import suggest_mapping

ANSWERS = study(times=("post",))


def records(folder: Path, *more: int) -> Path:
    """Write answers as lists in cells, each with some more numbers, and a rating of comfort."""
    each = [
        {"Participant": p, "Condition": c, "How comfortable was it?": 1 + n % 7}
        | {"SSQ": " ".join(map(str, (*ANSWERS[p, c, "post"], *more)))}
        for n, p in enumerate(PEOPLE)
        for c in CONDITIONS
    ]
    file = folder / "answers.json"
    file.write_text(json.dumps(each), encoding="utf-8")
    return file


def test_a_list_with_a_number_for_each_item_is_read_as_the_items(tmp_path: Path) -> None:
    found = suggest_mapping([records(tmp_path)])
    assert found.imported is not None
    answers = {
        (m.participant, m.condition, "post"): tuple(response.answers.values())
        for (instrument, m), response in found.imported.responses.items()
        if instrument == "ssq"
    }
    assert answers == ANSWERS
    assert "'SSQ' the answers to all items" in found.doubts[0]


def test_answers_that_share_a_cell_are_asked_about(tmp_path: Path) -> None:
    doubts = suggest_mapping([records(tmp_path, 3)]).doubts
    asked = next(doubt for doubt in doubts if "'SSQ' hold several numbers each" in doubt)
    assert "answers to SSQ would be missing" in asked


def test_a_column_of_lists_is_refused_with_its_row_where_a_cell_is_none(tmp_path: Path) -> None:
    file = write(tmp_path / "a.csv", [["ID", "SSQ"], ["P1", "1 2 3 0"], ["P2"], ["P3", "1 2"]])
    (grid,) = read_grids(file, Reading(spread=("SSQ",)))
    with pytest.raises(InputError, match="row 4: '1 2' in 'SSQ' is no list of 4 numbers"):
        as_table(grid)
    table = as_table(replace(grid, rows=grid.rows[:3], numbers=grid.numbers[:3]))
    assert table.headings == ("ID", "SSQ_1", "SSQ_2", "SSQ_3", "SSQ_4")
    assert table.rows == (("P1", "1", "2", "3", "0"), ("P2", "", "", "", ""))
    other = replace(grid, reading=Reading(spread=("IPQ",)))
    with pytest.raises(InputError, match="no column 'IPQ', which is to be spread"):
        as_table(other)
