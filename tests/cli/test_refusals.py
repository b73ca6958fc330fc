"""A command that is refused leaves the disk as it was: no folder, no file."""

from __future__ import annotations

import hashlib
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from vrcomfort.cli.app import COMMANDS
from vrcomfort.resources import data_folder

Run = Callable[..., tuple[int, str, str]]

REFUSED = """
run nosuch --participant P01 --out new
run smoke --participant P/1 --out new
run smoke --participant P01 --out new --covariate unknown=3
run smoke --participant P01 --out new --language xx
run smoke --participant P01 --out new/deep --resume
run smoke --participant P01 --out empty --resume
run smoke --participant P01 --out new --respondent simulated --ttl /dev/nosuch
run smoke --participant P01 --out new --consented-on 2026-01-01
simulate nosuch -n 2 --out new
simulate smoke -n 2 --out new --trace binary.csv
simulate smoke -n 2 --out new --no-draw --refresh-hz 90
demo --out other.csv
demo --out holds
render --scene nosuch --out new
render --scene temple --pose 1,2 --out new/deep
render --scene temple --size 3 --out new
play binary.csv --scene temple --out new
play TRACE --scene nosuch --out new
play TRACE --scene temple --out new --video nosuch/film.mp4
play TRACE --scene temple --out new --video film.avi
play empty --out new
import-trace binary.csv --format unity-euler --out new.csv
import-trace binary.csv --format unity-euler --out new/trace.csv
import binary.csv --mapping binary.csv --out new
import other.csv --suggest --out new/map.toml
report nosuch --out new
report empty --out new/deep
report other.csv --out new
report tidy.csv --plan nosuch --out new
report wide.csv --plan nosuch --out new
report wide.csv --plan nosuch --out empty
report wide.csv --instrument nosuch --out new
report wide.csv --memory much --out new
report --plan carnegie_2015 --out new
score other.csv
pack empty
pack nosuch
design nosuch
design smoke --study new
new empty/a+b
new nosuch/study
check binary.csv
schema nosuch
passes nosuch
plan nosuch
power nosuch --effect 1 --out new
power carnegie_2015 --effect 0.5sd --pilot empty --out new
doctor --nosuch
tradeoff --quick --methods nosuch --out new
tradeoff --quick --view 99 --out new
tradeoff --effects focus --size 3 --out new
undo-withdrawal empty P01 --reason x
exclude empty P01 --reason x
undo-exclusion empty P01 --reason x
erase empty P01
note nosuch P01 x
verify empty
status nosuch
anonymise empty --out new
anonymise empty --out new --key new/key.csv
export empty --format bids --out new
erase empty P01
list nosuch
docs nosuch nosuch
preflight nosuch --out new
preflight smoke --out new --headset playback --monado-trace binary.csv
"""
CASES = [line for line in REFUSED.strip().splitlines() if line.split()[0] in COMMANDS]

WIDE = (
    "participant,condition,timepoint,"
    "general_discomfort,fatigue,headache,eyestrain,difficulty_focusing,increased_salivation,"
    "sweating,nausea,difficulty_concentrating,fullness_of_head,blurred_vision,dizzy_eyes_open,"
    "dizzy_eyes_closed,vertigo,stomach_awareness,burping"
)


def everything_in(folder: Path) -> dict[str, str]:
    """Return all folders and files, with hashes of what is in them."""
    return {
        str(each.relative_to(folder)): hashlib.sha256(
            b"" if each.is_dir() else each.read_bytes()
        ).hexdigest()
        for each in folder.rglob("*")
    }


@pytest.fixture
def desk(tmp_path, monkeypatch) -> Path:
    (tmp_path / "empty").mkdir()
    (tmp_path / "holds").mkdir()
    (tmp_path / "holds" / "thesis.txt").write_text("mine")
    (tmp_path / "binary.csv").write_bytes(b"\x00\xff\x00garbage")
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    (tmp_path / "tidy.csv").write_text("participant,condition,item,response\nP1,a,x,1\n")
    rows = [
        f"{who},{condition},{when}" + ",0,1,2,3" * 4
        for who in ("P1", "P2", "P3", "P4")
        for condition in ("sharp", "soft")
        for when in ("pre", "post")
    ]
    (tmp_path / "wide.csv").write_text("\n".join([WIDE, *rows]) + "\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("line", CASES)
def test_a_refused_command_leaves_nothing_behind(desk, run: Run, line) -> None:
    trace = str(data_folder("scenes") / "temple_walk.csv")
    before = everything_in(desk)
    code, _, err = run(*(trace if word == "TRACE" else word for word in shlex.split(line)))
    assert code == 2, err
    assert "Traceback" not in err
    assert everything_in(desk) == before


def test_a_labs_own_instrument_stays_where_it_lay(desk, run: Run) -> None:
    """The study's folder may be the protocol's, beside which its instruments lie."""
    smoke = (data_folder("protocols") / "smoke.toml").read_text("utf-8")
    own = 'instrument = "instruments/own.toml"\ntimepoint = "post"\nwhen = "after_trial"\n'
    (desk / "mine.toml").write_text(f"{smoke}\n[[questionnaires]]\n{own}", "utf-8")
    mine = (data_folder("instruments") / "sus.toml").read_text("utf-8")
    (desk / "instruments").mkdir()
    (desk / "instruments" / "own.toml").write_text(mine.replace('name = "sus"', 'name = "own"'))
    before = everything_in(desk)
    for out in (".", "new"):
        code, _, err = run("run", "mine.toml", "--participant", "P01", "--out", out, "--resume")
        assert code == 2
        assert "no session of P01 was interrupted" in err
        assert everything_in(desk) == before


def test_every_command_is_refused_here() -> None:
    assert {line.split()[0] for line in CASES} == set(COMMANDS)


@pytest.mark.slow
def test_a_report_is_not_written_over_that_of_another_study(desk, run: Run) -> None:
    """Until that is asked for; one of the same study is replaced."""
    code, _, err = run("simulate", "smoke", "-n", "2", "--no-draw", "--out", "first")
    assert code == 0, err
    shutil.copytree("first", "second")
    out = ("--out", "page", "--figures", "none")
    for _ in range(2):
        assert run("report", "first", *out)[0] == 0
    before = everything_in(desk)
    code, _, err = run("report", "second", *out)
    assert code == 2
    told = "holds the report of another study, first; choose another output folder, or replace it"
    assert err == f"error: page: {told}\n"
    for source in ("second/sub-P01/ses-1/questionnaires.csv", "wide.csv"):
        assert run("report", source, *out)[0] == 2
    assert everything_in(desk) == before
    assert run("report", "second", *out, "--replace")[0] == 0
    assert run("report", "first", *out)[0] == 2
