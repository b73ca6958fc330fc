"""A protocol's own Python runs after this user's consent to its hash, and in no other command."""

from __future__ import annotations

import io
import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.support.tasks import PROTOCOL, with_own_tasks
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol, task_code_of
from vrcomfort.tasks import read_task_code

TASK = """
import counting.deep
from helper import score
from pathlib import Path
from vrcomfort.tasks import Result, Task, TaskSettings

Path(__file__).with_name("ran").touch()


class Nod(TaskSettings):
    kind: str
    every: int = 1

    def start(self, surroundings):
        import later
        return _Nod()


class _Nod(Task):
    def step(self, moment):
        return []

    def finish(self, time_s):
        return [Result("trial", 1, "", 0.0, score=score() + counting.deep.MORE)]


TASK = Nod
"""
MARKS = """
from pathlib import Path
(Path(__file__).parents[%d] / "ran").touch()
"""
FILES = {
    "nod.py": TASK,
    "helper.py": MARKS % 0 + "def score():\n    return 7.0\n",
    "later.py": MARKS % 0,
    "counting/__init__.py": MARKS % 1 + "from . import deep\n",
    "counting/deep.py": MARKS % 1 + "MORE = 1.0\n",
    "not_imported.py": MARKS % 0,
}
IMPORTED = FILES.keys() - {"not_imported.py"}
OWN_MODULES = {"helper", "later", "counting", "counting.deep"}
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return the folder of a protocol whose code leaves a file wherever it runs."""
    place = tmp_path / "study"
    for name, text in FILES.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(text)
    text = PROTOCOL.replace("aiming", "nod.py").replace("room.glb", "temple")
    text = text.replace("exposure_s = 20.0", "exposure_s = 1.0\nparticipants = 2")
    (place / "study.toml").write_text(text)
    return place


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """Return where this user's consents are kept."""
    return tmp_path / "home"


@pytest.fixture
def here(folder: Path, home: Path, monkeypatch: pytest.MonkeyPatch, run: Run) -> Iterator[Run]:
    """Return what runs a command with modules looked for in the protocol's folder first."""
    for name in ("XDG_CONFIG_HOME", "APPDATA"):
        monkeypatch.setenv(name, str(home))
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path])
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    known = set(sys.modules)
    yield run
    for name in OWN_MODULES - known:
        sys.modules.pop(name, None)


def files(*folders: Path) -> set[Path]:
    return {each for folder in folders for each in folder.rglob("*")}


SIMULATE = ("simulate", "study.toml", "-n", "1", "--no-draw", "--out", "data", "--quiet")
RUN = ("run", "study.toml", "--participant", "P01", "--respondent", "simulated", "--out", "data",
       "--size", "64x64", "--exposure-s", "0.2")  # fmt: skip


def refused_hash(code: int, err: str) -> str:
    """Return the hash that a refusal names."""
    assert code == 2, err
    assert err.count("\n") == 1
    return err.rpartition("--trust ")[2].strip()


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", [("check", "study.toml"), ("passes", "study.toml", "--size", "64x64")]
)
def test_a_command_that_reads_a_protocol_runs_and_writes_nothing(folder, home, here, command):
    before = files(folder)
    code, _, err = here(*command)
    assert code == 0, err
    assert files(folder, home / "vrcomfort") == before


@pytest.mark.slow
def test_a_preflight_runs_no_code_and_writes_one_file(folder, here):
    quick = ("--headset", "playback", "--size", "32x32", "--seconds", "0.2")
    before = files(folder)
    code, _, err = here("preflight", "study.toml", "--out", "data", *quick)
    assert code == 0, err
    assert files(folder) - before == {folder / "data", folder / "data" / "preflight.json"}


@pytest.mark.parametrize("command", [SIMULATE, RUN])
def test_without_a_consent_nothing_runs_and_nothing_is_written(folder, home, here, command):
    before = files(folder)
    code, _, err = here(*command)
    assert refused_hash(code, err) == task_code_of(load_protocol(folder / "study.toml")).sha256
    assert all(name in err for name in IMPORTED)
    assert files(folder, home / "vrcomfort") == before


def test_a_consent_is_kept_until_an_imported_file_changes(folder, here):
    code, _, err = here(*SIMULATE)
    given = refused_hash(code, err)
    code, _, err = here(*SIMULATE, "--trust", given)
    assert code == 0, err
    (folder / "ran").unlink()
    session = folder / "data/sub-P01/ses-1"
    manifest = json.loads((session / "manifest.json").read_text())
    assert manifest["task_code"].keys() == IMPORTED
    assert "8.0" in (session / "tasks.csv").read_text()  # 7 of the helper and 1 of the package
    for command in (("verify", "data"), ("report", "data", "--out", "r", "--figures", "none")):
        assert here(*command)[0] == 0
    assert not (folder / "ran").exists()
    again = [*SIMULATE[:3], "2", *SIMULATE[4:]]
    assert here(*again)[0] == 0  # it was kept
    (folder / "ran").unlink()
    (folder / "not_imported.py").write_text("")
    assert here(*again, "--out", "others")[0] == 0
    (folder / "ran").unlink()
    (folder / "counting/deep.py").write_text("MORE = 2.0\n")
    code, _, err = here(*again, "--out", "more")
    assert refused_hash(code, err) != given
    assert "hash of other files" in here(*again, "--trust", given)[2]
    assert not (folder / "ran").exists()
    assert not (folder / "more").exists()


class Terminal(io.StringIO):
    """What somebody types, or what stands on their screen."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("typed", "expected"), [("n\n", 2), ("y\n", 0)])
def test_at_a_terminal_the_files_are_shown_and_the_consent_is_typed(
    folder, home, here, monkeypatch, typed, expected
):
    monkeypatch.setattr(sys, "stdin", Terminal(typed))
    monkeypatch.setattr(sys, "stderr", screen := Terminal())
    code, _, _ = here(*SIMULATE)
    said = screen.getvalue()
    assert code == expected, said
    assert all(name in said for name in IMPORTED)
    assert (folder / "ran").exists() == (code == 0) == any(home.rglob("*.json"))


def test_what_was_hashed_is_what_runs(folder):
    code = task_code_of(load_protocol(folder / "study.toml"))
    for name in IMPORTED:
        (folder / name).write_text("raise AssertionError\n")
    assert code.run("nod.py").__name__ == "Nod"


def test_a_hash_is_that_of_what_sha256sum_prints(folder):
    code = task_code_of(load_protocol(folder / "study.toml"))
    names = sorted(IMPORTED)
    listed = subprocess.run(["sha256sum", *names], cwd=folder, capture_output=True, check=True)
    summed = subprocess.run(["sha256sum"], input=listed.stdout, capture_output=True, check=True)
    assert summed.stdout.decode().split()[0] == code.sha256


def test_a_file_that_is_called_like_a_module_of_python_is_not_imported(tmp_path):
    (tmp_path / "json.py").write_text("raise AssertionError\n")
    (tmp_path / "numpy.py").write_text("raise AssertionError\n")
    (tmp_path / "nod.py").write_text("import json, numpy\njson.dumps(1)\n" + "import os\n")
    assert read_task_code(tmp_path, ["nod.py"]).files.keys() == {"nod.py"}


def test_an_import_from_outside_of_the_folder_is_refused(folder, tmp_path):
    (folder / "helper.py").unlink()
    (tmp_path / "helper.py").write_text("score = None\n")
    (folder / "helper.py").symlink_to(tmp_path / "helper.py")
    with pytest.raises(InputError, match="outside of the protocol's folder"):
        task_code_of(load_protocol(folder / "study.toml"))


DECLARED = """
[settings.every]
type = "whole"
default = 1
low = 1

[settings.side]
type = "text"
one_of = ["left", "right"]
"""


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ('every = 3\nside = "left"', []),
        ("every = 0", ["`side` is missing", "`every`: should be greater than or equal to 1"]),
        (
            'evry = 3\nside = "lef"',
            [
                "unknown key `evry`; did you mean `every`?",
                "`side`: should be 'left' or 'right', got 'lef'; did you mean `left`?",
            ],
        ),
    ],
)
def test_check_validates_the_settings_that_are_declared_beside_a_task(
    folder, monkeypatch, run, keys, said
):
    (folder / "nod.toml").write_text(DECLARED)
    text = (folder / "study.toml").read_text()
    (folder / "study.toml").write_text(text.replace('"nod.py"', f'"nod.py"\n{keys}'))
    monkeypatch.chdir(folder)
    code, _, err = run("check", "study.toml", "--no-draw")
    assert (code == 0) == (said == [])
    assert all(each in err for each in said)
    assert not (folder / "ran").exists()


@pytest.mark.parametrize(
    ("text", "line"), [(DECLARED.replace("whole", "hole"), 3), (DECLARED + "[other]\n", 10)]
)
def test_a_faulty_declaration_is_told_with_its_line(folder, text, line):
    (folder / "nod.toml").write_text(text)
    with pytest.raises(InputError, match=rf"nod\.toml, line {line}"):
        load_protocol(folder / "study.toml")


def test_a_task_of_an_installed_package_needs_no_consent(folder, tmp_path, monkeypatch):
    packages = tmp_path / "packages"
    shutil.copytree(folder, packages)
    monkeypatch.syspath_prepend(packages)
    info = packages / "nods-1.5.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: nods\nVersion: 1.5\n")
    (info / "entry_points.txt").write_text("[vrcomfort.tasks]\nnods = nod:TASK\n")
    text = (folder / "study.toml").read_text().replace('"nod.py"', '"nods"\nevery = 3')
    (folder / "study.toml").write_text(text)
    protocol = load_protocol(folder / "study.toml")
    assert not task_code_of(protocol).files
    assert not (packages / "ran").exists()
    assert with_own_tasks(protocol).task_code == {"nods": "nods 1.5"}
    assert (packages / "ran").exists()
    monkeypatch.chdir(packages)  # what lies in the present folder is not installed
    with pytest.raises(InputError, match="no such task"):
        load_protocol(folder / "study.toml")
