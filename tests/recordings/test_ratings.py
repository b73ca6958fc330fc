"""Long ratings are the same from text, from CSV and from Parquet; what is wrong has its place."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.support.rated import RatedStudy
from tests.support.report import build_report
from vrcomfort.errors import InputError
from vrcomfort.recordings import pack, pack_study, ratings, read_ratings
from vrcomfort.recordings.ratings import KEYS_OF_RATINGS, _as_text
from vrcomfort.records.recording import LONG_BYTES, Memory, Recording

HEADER = "participant,session,trial,condition,onset_s,latency_s,instrument,response,missed,resumed"
RATINGS = 100


@pytest.fixture
def sooner(monkeypatch):
    """A file is long at a fortieth of what makes it so."""
    for module in (pack, ratings):
        monkeypatch.setattr(module, "LONG_BYTES", LONG_BYTES // 40)


def rows(*, shuffled=False):
    """Return rows of ten exposures, as labs write them."""
    random = np.random.default_rng(7)
    missed = {0: ("", "1"), 1: ("NA", "0"), 2: ("n/a", "")}
    found = []
    for exposure in range(10):
        who, trial = f"P{exposure // 2}", exposure % 2 + 1
        for place in range(RATINGS):
            said, code = missed.get(place % 50, (f"{random.uniform(0, 20):.3f}", "0"))
            where = f"{who},pre,{trial},{'ab'[trial - 1]}"
            found.append(f"{where},{100 + place / 2}, ,fms,{said},{code},0")
    if shuffled:
        found = [found[i] for i in random.permutation(len(found))]
    return found


def write(folder, lines):
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "ratings.csv"
    file.write_text("\n".join([HEADER, *lines, ""]), "utf-8")
    assert file.stat().st_size > ratings.LONG_BYTES
    return file


def content(series):
    return {
        tuple(getattr(each, name) for name in KEYS_OF_RATINGS): (each.onset_s, each.response)
        for each in series
    }


@pytest.mark.usefixtures("sooner")
def test_text_csv_and_parquet_are_the_same(tmp_path):
    file = write(tmp_path, rows(shuffled=True))
    text, out_of_core = _as_text(file), read_ratings([file])
    (packed,) = pack_study(tmp_path, Memory())
    assert packed.new
    assert Recording.find(file).parquet == packed.parquet
    expected = content(text.series)
    assert len(expected) == 10
    for found in (out_of_core, read_ratings([file])):
        assert not found.notes
        assert [*content(found.series)] == [*expected]
        for key, (onset_s, response) in content(found.series).items():
            np.testing.assert_array_equal(onset_s, expected[key][0])
            np.testing.assert_array_equal(response, expected[key][1])
    assert sum(each.missed for each in text.series) == 10 * RATINGS * 3 // 50


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        (",101.5,", ",soon,", "column onset_s: 'soon' is not a number"),
        (",101.5,", ",,", "no onset_s|is blank"),
        (",fms,", ",fms,1_0", "column response: '1_0"),
    ],
)
@pytest.mark.usefixtures("sooner")
def test_a_wrong_cell_of_a_long_file_has_its_place(tmp_path, old, new, where):
    lines = rows()
    at = next(i for i, line in enumerate(lines) if i > 5 and old in line and ",0,0" in line)
    lines[at] = lines[at].replace(old, new, 1)
    file = write(tmp_path, lines)
    with pytest.raises(InputError, match=where) as told:
        read_ratings([file])
    assert told.value.line == at + 2
    with pytest.raises(InputError, match=where) as told:
        list(pack_study(tmp_path, Memory()))
    assert told.value.line == at + 2


@pytest.mark.parametrize(("who", "told"), [("P1", "this rating of P1"), ("", "this rating")])
def test_a_rating_without_a_moment_says_whose_it_is(tmp_path, who, told):
    file = tmp_path / "ratings.csv"
    file.write_text(f"participant,session,onset_s,response,missed\n{who},pre,,3,0\n", "utf-8")
    with pytest.raises(InputError, match=rf"{told} has no onset_s; give seconds"):
        read_ratings([file])


@pytest.mark.usefixtures("sooner")
def test_a_half_written_last_row_is_told_and_left_out(tmp_path):
    file = write(tmp_path, rows())
    whole = sum(each.response.size for each in read_ratings([file]).series)
    with file.open("a", encoding="utf-8") as stream:
        stream.write("P9,pre,1,a,77")
    found = read_ratings([file])
    assert sum(each.response.size for each in found.series) == whole
    assert "half-written" in found.notes[0]


@pytest.mark.usefixtures("sooner")
def test_a_parquet_of_another_csv_is_told_and_not_read(tmp_path):
    file = write(tmp_path, rows())
    list(pack_study(tmp_path, Memory()))
    lines = rows()
    lines[5] = lines[5].replace(",0,0", ",0,1")
    lines[6] = lines[6].replace("P0", "P7")
    write(tmp_path, lines)
    found = read_ratings([file])
    assert "P7" in {each.participant for each in found.series}
    assert "has changed since it was packed" in found.notes[0]


def test_silent_gaps_are_gaps(tmp_path):
    study = RatedStudy()
    for who in ("P1", "P2", "P3"):
        study.expose(who, "a", [2, 3, 4, 5, 6, 7, 8, 9])
        study.expose(who, "b", [1] * 8)
    gone = [row for row in study.ratings if row[:2] == ("P1", 1) and row[3] == "a"][2:6]
    study.ratings = [row for row in study.ratings if row not in gone]
    folder = study.write(tmp_path / "study")
    plan = tmp_path / "plan.toml"
    lines = ['name = "p"', 'title = "P"', 'outcomes = ["ratings.area"]', "anova = []"]
    plan.write_text("\n".join([*lines, "[ratings]", 'summaries = ["area"]', ""]), "utf-8")
    report = build_report(folder, out=tmp_path / "report", plan=plan)
    results = json.loads(report.results.read_text("utf-8"))
    (counts,) = [row for row in results["ratings"]["summaries"] if row["summary"] == "area"][:1]
    assert counts["n"] == 2
    at_40 = [p for p in results["ratings"]["curves"] if p["condition"] == "a" and p["time_s"] == 40]
    assert at_40[0]["n"] == 2
