"""Every code block of the documentation: commands and Python run, TOML is read by its schema."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from contextlib import chdir
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from pydantic import BaseModel, ValidationError
from typer.testing import CliRunner

from tests.importing.test_head_logs import uxf, walk
from tests.support.doc_blocks import ELSEWHERE, ROOT, Block, blocks, shortened
from tests.support.resume import go
from vrcomfort.cli.app import app
from vrcomfort.importing.mapping import LabMapping
from vrcomfort.importing.suggest.vocabulary import VocabularyFile
from vrcomfort.protocol import Protocol
from vrcomfort.questionnaire import find_instrument
from vrcomfort.questionnaire.instrument_file import parse_instrument
from vrcomfort.report.plan_files import AnalysisPlan
from vrcomfort.scene.side_car import SideCar
from vrcomfort.settings.schema import json_schema
from vrcomfort.tasks.declared import TaskDeclaration
from vrcomfort.tasks.own_code import read_task_code

Run = Callable[..., tuple[int, str, str]]
COMMANDS = list(blocks("sh", "console"))
ROOM = """participant,condition,felt_there,felt_flat,would_return
P1,off,4,2,5
P1,on,5,1,5
P2,off,2,4,3
"""
SLOW = {
    "README.md",
    "gaze_and_head.md",
    "gaze_validation.md",
    "import.md",
    "instruments.md",
    "plans.md",
    "power.md",
    "preflight.md",
    "protocols.md",
    "ratings.md",
    "replay.md",
    "tasks.md",
}
"""Pages whose commands take more than two seconds of a core."""
FOLLOWED = {"tutorial.md"}
"""By tests/project/test_tutorial.py, in its whole length."""


def text_of(page: str, start: str, language: str = "toml") -> str:
    """Return the block of a page that starts like this."""
    (found,) = (
        each.text for each in blocks(language) if each.page == page and each.text.startswith(start)
    )
    return found


def vrcomfort(folder: Path, *words: str) -> None:
    with chdir(folder):
        done = CliRunner().invoke(app, words, catch_exceptions=False)
    assert done.exit_code == 0, done.output


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the files that pages speak of, a study among them."""
    folder = tmp_path_factory.mktemp("lab")
    shutil.copy(ROOT / "protocols" / "carnegie_2015.toml", folder / "my_study.toml")
    told = ["simulate", "my_study.toml", "--out", "my_study"]
    vrcomfort(folder, *told, "-n", "8", "--no-draw", "--seed", "1")  # P05 withdraws
    for data in ("import", "fms"):
        shutil.copytree(ROOT / "tests" / "data" / data, folder / "tests" / "data" / data)
    shutil.copytree(ROOT / "docs" / "plans", folder / "docs" / "plans")
    return folder


def with_frames(folder: Path) -> None:
    shutil.rmtree(folder / "my_study")
    go(folder, study="my_study")


def with_pictures(folder: Path) -> None:
    shutil.rmtree(folder / "my_study")
    small = ["--exposure-s", "0.2", "--refresh-hz", "10", "--size", "16x20"]
    vrcomfort(folder, "simulate", "my_study.toml", "--out", "my_study", "-n", "1", *small)


def of_the_readme(folder: Path) -> None:
    shutil.rmtree(folder / "my_study")
    (folder / "lens_study.toml").write_text(text_of("README.md", 'name = "lens'), "utf-8")


def of_another_lab(folder: Path) -> None:
    displays = folder / "tests" / "data" / "import" / "two_displays.csv"
    (folder / "raw").mkdir()
    shutil.copy(displays, folder / "raw")
    shutil.copy(displays, folder / "answers.csv")
    plan = 'name = "own"\ntitle = "Own"\noutcomes = ["T"]\n' + text_of("import.md", "[data]")
    (folder / "my_plan.toml").write_text(plan, "utf-8")
    (folder / "words.toml").write_text(text_of("import.md", "# words.toml"), "utf-8")


def with_a_mapping(folder: Path) -> None:
    of_another_lab(folder)
    vrcomfort(folder, "import", "answers.csv", "--suggest", "--out", "map.toml")
    mapping = answered((folder / "map.toml").read_text("utf-8"))
    (folder / "map.toml").write_text(mapping.replace("answers.csv", "two_displays.csv"), "utf-8")


def with_a_pilot(folder: Path) -> None:
    shutil.copy(ROOT / "analysis" / "carnegie_2015.toml", folder / "my_plan.toml")
    (folder / "my_study").rename(folder / "my_pilot")


def with_head_logs(folder: Path) -> None:
    shutil.copy(uxf(folder, walk()), folder / "log.csv")


def with_answers(folder: Path) -> None:
    own = text_of("instruments.md", 'name = "room_quality"')
    (folder / "room_quality.toml").write_text(own, "utf-8")
    (folder / "room.csv").write_text(ROOM, "utf-8")
    for name, file in {"ssq": "answers.csv", "vrsq": "vrsq.csv"}.items():
        items = [item.name for item in find_instrument(name).asked]
        rows = [["participant", *items], ["P1", *(str(n % 4) for n in range(len(items)))]]
        (folder / file).write_text("\n".join(map(",".join, rows)), "utf-8")


def in_languages(folder: Path) -> None:
    shutil.rmtree(folder / "my_study")
    spoken = text_of("languages.md", "languages") + (folder / "my_study.toml").read_text("utf-8")
    (folder / "my_study.toml").write_text(spoken, "utf-8")


def with_a_task(folder: Path) -> None:
    code = next(each.text for each in blocks("python") if each.page == "tasks.md")
    (folder / "count_nods.py").write_text(code, "utf-8")
    task = 'task = "nods"\ntasks = [{ name = "nods", kind = "count_nods.py" }]\n'
    (folder / "study.toml").write_text(task + text_of("README.md", 'name = "lens'), "utf-8")


PREPARED: dict[str, Callable[[Path], object]] = {
    "README.md": of_the_readme,
    "import.md": of_another_lab,
    "import_traces.md": with_head_logs,
    "instruments.md": with_answers,
    "languages.md": in_languages,
    "plans.md": with_a_mapping,
    "power.md": with_a_pilot,
    "protocols.md": lambda folder: (folder / "my_study.toml").unlink(),
    "recordings.md": with_frames,
    "replay.md": with_pictures,
    "sharing.md": lambda folder: (folder.parent / "keys").mkdir(),
    "tasks.md": with_a_task,
}
"""What a page's commands name beside the files of the lab."""


def answered(mapping: str) -> str:
    """Return a mapping whose doubts a person has answered."""
    return mapping.replace('answer = ""', 'answer = "as assumed"')


def remove(made: Path) -> None:
    if made.is_dir():
        shutil.rmtree(made)
    else:
        made.unlink()


def run_here(block: Block) -> list[str]:
    """Return the commands of a block that this test runs."""
    typed = [shortened(each) for each in block.commands]
    return [each for each in typed if not any(re.match(start, each) for start in ELSEWHERE)]


def as_typed(block: Block, folder: Path) -> list[str]:
    typed = run_here(block)
    if "3f6c…" in block.text:
        sha256 = read_task_code(folder, ["count_nods.py"]).sha256
        typed = [each.replace("3f6c…", sha256) for each in typed]
    return typed


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[pytest.mark.slow] if page in SLOW else [])
        for page in sorted({each.page for each in COMMANDS if run_here(each)} - FOLLOWED)
    ],
)
def test_the_commands_of_a_page_run(
    page: str, lab: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    folder = tmp_path / "here"
    shutil.copytree(lab, folder)
    PREPARED.get(page, lambda _: None)(folder)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    made: set[str] = set()
    for block in (each for each in COMMANDS if each.page == page):
        for command in as_typed(block, folder):
            words, _, written = (part.strip() for part in command.partition(" > "))
            program, *arguments = shlex.split(words)
            if program == "python":
                subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
                continue
            assert program == "vrcomfort", command
            out_to = arguments[arguments.index("--out") + 1] if "--out" in arguments else ""
            if out_to in made:  # the next line is another way to the same place
                remove(Path(out_to))
            made |= {out_to} if out_to and not Path(out_to).exists() else set()
            code, out, err = run(*arguments)
            assert code == 0, f"{command}\n{err}"
            if written:
                Path(written).write_text(out, encoding="utf-8")
            for mapping in Path().glob("*.toml"):
                if "answer = " in (text := mapping.read_text("utf-8")):
                    mapping.write_text(answered(text), encoding="utf-8")


def test_what_is_not_run_here_is_declared() -> None:
    """And nothing that is declared is left over."""
    told = [each for block in COMMANDS for each in block.commands]
    for start in ELSEWHERE:
        assert any(re.match(start, each) for each in told), start
    shown = [each for each in told if not each.startswith(("vrcomfort ", "python "))]
    assert [each for each in shown if not any(re.match(start, each) for start in ELSEWHERE)] == []


MODELS: dict[str, type[BaseModel]] = {
    "protocol": Protocol,
    "plan": AnalysisPlan,
    "side-car": SideCar,
    "mapping": LabMapping,
    "vocabulary": VocabularyFile,
    "task": TaskDeclaration,
}
NOT_OURS = "[[rule]]"
"""How the settings of another program begin: taplo's."""


def is_valid(model: type[BaseModel], data: dict[str, Any]) -> bool:
    try:
        model.model_validate(data)
    except ValidationError:
        return False
    return True


@pytest.fixture(scope="module")
def schemas() -> dict[str, jsonschema.Draft202012Validator]:
    """Return the schema of each kind of file; a block need not have what a whole file must."""
    found = {}
    for name, model in MODELS.items():
        schema = json_schema(model)
        for table in (schema, *schema.get("$defs", {}).values()):
            table.pop("required", None)
        found[name] = jsonschema.Draft202012Validator(schema)
    return found


def test_toml_is_read_by_a_schema(schemas: dict[str, jsonschema.Draft202012Validator]) -> None:
    for block in blocks("toml"):
        text = block.text
        if text.startswith(NOT_OURS):
            continue
        if "[[items]]" in text:
            assert parse_instrument(text).items
            continue
        for table in ("conditions", "tables"):  # a part of an entry of a list
            if f"[{table}." in text and f"[[{table}]]" not in text:
                text = f"[[{table}]]\n{text}"
        data = tomllib.loads(text)
        if whole := [name for name, model in MODELS.items() if is_valid(model, data)]:
            assert len(whole) == 1, block
            continue
        faults = {kind: [e.message for e in each.iter_errors(data)]
                  for kind, each in schemas.items()}  # fmt: skip
        assert [] in faults.values(), (block, faults)


def test_a_misspelt_key_would_be_found(
    schemas: dict[str, jsonschema.Draft202012Validator],
) -> None:
    data = {"exposre_s": 1.0}
    assert all(list(each.iter_errors(data)) for each in schemas.values())


@pytest.mark.slow
@pytest.mark.filterwarnings("default::UserWarning")  # notes on the simulated data
@pytest.mark.parametrize("page", ["README.md", "python_api.md"])
def test_python_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """tasks/test_tasks.py runs that of tasks.md, records/test_clocks.py that of timing.md."""
    (code,) = (each.text for each in blocks("python") if each.page == page)
    code = code.replace('"my_report")', '"my_report", forms=())')
    code = code.replace('render_views("temple",', 'render_views("temple", size_px=(32, 40),')
    of_protocol = text_of("README.md", 'name = "lens')
    (tmp_path / "lens_study.toml").write_text(of_protocol, "utf-8")
    told = ["-n", "4", "--no-draw", "--out", "my_study"]
    vrcomfort(tmp_path, "simulate", "lens_study.toml", *told)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, page, "exec"), {})  # noqa: S102
