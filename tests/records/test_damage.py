"""A session that something has damaged goes on, or is refused in one sentence; nothing else."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import pytest

from tests.support.damage import Damage, of_bytes, of_csv, of_json
from tests.support.resume import attempts, folder, go, manifest, rows
from tests.support.study import tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.records import Interrupted, enrol
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.session import open_enrolment

FILES = ("trials", "timing", "questionnaires", "ratings", "frames", "events")


def simulated(tmp_path: Path) -> SimulatedRespondent:
    settings = tiny_protocol(tmp_path).simulation
    return SimulatedRespondent(settings, participant="P01", seed=0)


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated session that was killed in its second exposure."""
    place = tmp_path_factory.mktemp("killed")
    go(place, simulated(place), interrupt=(2, 30))
    session = folder(place)
    content = manifest(place)
    trials = (session / "trials.csv").read_text().splitlines(keepends=True)
    content["under_way"] = {
        "participant": "P01", "session": 1, "period": 2, "block": 1, "trial": 2,
        "condition": "blur", "scene": "room.glb", "attempt": 1, "resumed": 0,
        "start_s": float(rows(place, "trials")[1]["start_s"]),
    }  # fmt: skip
    content["status"] = "running"
    (session / "manifest.json").write_text(json.dumps(content, indent=2))
    (session / "trials.csv").write_text("".join(trials[:-1]))
    return place


class Damaged:
    """A copy of the killed session, which is damaged again and again."""

    def __init__(self, place: Path, killed: Path) -> None:
        self.study = place / "S"
        shutil.copytree(killed / "S", self.study)
        self._whole = {file: file.read_bytes() for file in self.study.rglob("*") if file.is_file()}
        self._protocol = tiny_protocol(place)
        self._respondent = simulated(place)

    def refusal(self, damage: Damage, inside: str = "") -> str | None:
        """Take it up, as `run --resume` does first; return what is said."""
        self._restore()
        damage[1](self.study / inside)
        try:
            taken = self._take_up()
        except InputError as error:
            return str(error)
        assert taken.done <= 2
        assert taken.session_s < 1e9
        return None

    def _take_up(self) -> Interrupted:
        with open_enrolment(
            self._protocol,
            "P01",
            study=self.study,
            respondent="simulated",
            sessions=[1],
            resume=True,
        ) as enrolment:
            row = enrol(self.study, enrolment.design, "P01")
            enrolment.interrupted.check_memory(self._respondent)
            return enrolment.interrupted.repair_session(enrolment.design.sequence(row.sequence))[1]

    def _restore(self) -> None:
        for file in self.study.rglob("*.cut"):
            file.unlink()
        for file, content in self._whole.items():
            if not file.exists() or file.read_bytes() != content:
                file.write_bytes(content)


@pytest.fixture
def damaged(
    tmp_path: Path, killed: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., str | None]:
    monkeypatch.setattr("os.fsync", lambda _: None)  # thousands of cases, and no power cut
    monkeypatch.setattr("os.fdatasync", lambda _: None)
    return Damaged(tmp_path, killed).refusal


SESSION = "sub-P01/ses-1"


def damages(killed: Path) -> Iterator[tuple[str, Damage]]:
    session = folder(killed)
    for damage in of_json("manifest.json", manifest(killed)):
        yield SESSION, damage
    description = json.loads((killed / "S" / "dataset_description.json").read_text())
    for damage in of_json("dataset_description.json", description):
        yield "", damage
    for name in FILES:
        for damage in of_csv(session / f"{name}.csv"):
            yield SESSION, damage
    for damage in of_csv(killed / "S" / "participants.csv"):
        yield "", damage


SOME_OR_ALL = pytest.mark.parametrize("every", [23, pytest.param(1, marks=pytest.mark.slow)])


@pytest.mark.slow
def test_every_damaged_value_is_refused_in_a_sentence_or_does_no_harm(damaged, killed):
    # Five divides neither 23 (values of a key) nor 19 and 6 (of a cell): every place is damaged,
    # and every value comes to a fifth of them.
    cases = islice(damages(killed), 0, None, 5)
    said = [(damage[0], damaged(damage, inside)) for inside, damage in cases]
    refused = [(what, sentence) for what, sentence in said if sentence]
    assert len(said) > 400
    assert len(refused) > 200
    for what, sentence in refused:
        assert "\n" not in sentence
        file = what.split()[0].rstrip(":")
        told = ("protocol `", "seed ", "begun with", "in sequence", "an exposure of", "no session")
        assert file in sentence or any(words in sentence for words in told), (what, sentence)


@SOME_OR_ALL
def test_every_cut_is_mended_or_told(damaged, killed, every):
    session = folder(killed)
    sizes = {name: (session / name).stat().st_size for name in ("manifest.json", "frames.csv")}
    steps = {"manifest.json": 50, "frames.csv": max(1, sizes["frames.csv"] // 40)}
    for name in ("manifest.json", *(f"{each}.csv" for each in FILES)):
        for damage in islice(of_bytes(session / name, steps.get(name, 50)), 0, None, every):
            sentence = damaged(damage, SESSION)
            assert sentence is None or name in sentence, (damage[0], sentence)
            if name != "manifest.json" and " at " not in damage[0]:
                at = int(damage[0].split()[-1])
                header = (session / name).read_bytes().index(b"\n")
                assert sentence is None or 0 < at <= header, (damage[0], sentence)


def test_it_goes_on_where_nothing_is_damaged(damaged):
    assert damaged(("nothing", lambda _: None)) is None


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("memory", {}, "`memory` is not the state of a simulated participant"),
        ("earlier_runs", 1, "`earlier_runs`: should be a list"),
        ("status", [], "`status`: should be 'running', 'completed'"),
        ("exposure_s", float("inf"), "`exposure_s` is not a finite number"),
        ("seed", 1e300, "`seed`: should be a whole number"),
        ("participant", "P02", "this manifest is that of sub-P02/ses-1"),
        ("schema_version", 9, "written in schema version 9"),
    ],
)
def test_a_manifest_is_refused_with_its_place(tmp_path, killed, key, value, says):
    shutil.copytree(killed / "S", tmp_path / "S")
    file = folder(tmp_path) / "manifest.json"
    content = json.loads(file.read_text())
    file.write_text(json.dumps({**content, key: value}, indent=2))
    with pytest.raises(InputError) as caught:
        go(tmp_path, simulated(tmp_path), resume=True)
    assert says in caught.value.message
    assert caught.value.file == file
    if caught.value.line is not None and key in content:
        assert f'"{key}"' in file.read_text().splitlines()[caught.value.line - 1]


def test_broken_json_is_told_with_line_and_column(tmp_path, killed):
    shutil.copytree(killed / "S", tmp_path / "S")
    file = folder(tmp_path) / "manifest.json"
    file.write_text('{\n  "participant": P01\n}')
    with pytest.raises(InputError, match="this manifest is damaged; restore it") as caught:
        go(tmp_path, simulated(tmp_path), resume=True)
    assert (caught.value.line, caught.value.column) == (2, 18)
    file.write_text("[" * 100_000)
    with pytest.raises(InputError, match="nested too deep"):
        go(tmp_path, simulated(tmp_path), resume=True)


@pytest.mark.parametrize(
    ("old", "new", "column", "says"),
    [
        ("P01,1,1,1,1,plain", "P01,1,1,1,99,plain", "trial", "has 2 trials, and no 99"),
        ("P01,1,1,1,1,plain", "P01,1,1,1,2,blur", "trial", "trial 1 was not completed before"),
        ("P01,1,1,1,1,plain", "P01,1,1,1,1,blur", "condition", "planned with 'plain', not"),
        ("P01,1,1,1,1,plain", "P02,1,1,1,1,plain", "participant", "is of participant P01"),
        (",completed,", ",finished,", "status", "'finished' is no status of a trial"),
    ],
)
def test_a_trial_that_the_order_does_not_have_never_counts(
    tmp_path, killed, old, new, column, says
):
    shutil.copytree(killed / "S", tmp_path / "S")
    file = folder(tmp_path) / "trials.csv"
    text = file.read_text()
    file.write_text(text.replace(old, new, 1))
    before = file.read_bytes()
    with pytest.raises(InputError, match=says) as caught:
        go(tmp_path, simulated(tmp_path), resume=True)
    assert (caught.value.file, caught.value.line, caught.value.column) == (file, 2, column)
    assert file.read_bytes() == before


@pytest.mark.parametrize(
    ("name", "column", "time_s"),
    [
        *(("events", "onset_s", time_s) for time_s in ("inf", "1e300", "nan", "-1.0")),
        ("frames", "session_s", "inf"),
        ("questionnaires", "answered_s", "nan"),
    ],
)
def test_a_time_that_cannot_be_is_refused(tmp_path, killed, name, column, time_s):
    shutil.copytree(killed / "S", tmp_path / "S")
    file = folder(tmp_path) / f"{name}.csv"
    lines = file.read_text().splitlines(keepends=True)
    at = lines[0].strip().split(",").index(column)
    cells = lines[-1].split(",")
    cells[at] = time_s
    file.write_text("".join([*lines[:-1], ",".join(cells)]))
    with pytest.raises(InputError, match="mend it first") as caught:
        go(tmp_path, simulated(tmp_path), resume=True)
    assert (caught.value.line, caught.value.column) == (len(lines), column)


def test_nul_bytes_at_the_end_are_a_half_written_row(tmp_path):
    go(tmp_path, interrupt=(2, 30))
    file = folder(tmp_path) / "ratings.csv"
    whole = file.read_bytes()
    file.write_bytes(whole + b"P01,1," + bytes(4096))
    (warning,) = go(tmp_path, resume=True).warnings
    assert "ratings.csv, line 4: a half-written row was moved to ratings.csv.cut" in warning
    assert file.read_bytes().startswith(whole)
    assert bytes(4096) in file.with_name("ratings.csv.cut").read_bytes()
    assert [row[:3] for row in attempts(tmp_path)][-1] == ("2", "2", "1")
