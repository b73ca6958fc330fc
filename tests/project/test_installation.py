"""What is to be typed where a package is missing can be typed, however vrcomfort was installed."""

from __future__ import annotations

import ast
import importlib
import os
import re
import subprocess
import sys
import sysconfig
import tomllib
import venv
from importlib.metadata import requires
from pathlib import Path

import pytest

import vrcomfort
from tests.support.places import ROOT
from vrcomfort.cli.doctor import EXTRAS as LISTED

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
REMEDY = re.compile(r"pip install ((?:--[a-z-]+ )*)((?:[\w.-]+ ?)+|'[^']+')")


def name_of(requirement: str) -> str:
    found = re.match(r"[\w.-]+", requirement)
    assert found
    return found[0].lower()


def text_of(argument: ast.expr, file: Path) -> str:
    """Return an argument that is a literal, or the name of a constant of its module."""
    if not isinstance(argument, ast.Name):
        return ast.literal_eval(argument)
    parts = file.relative_to(Path(vrcomfort.__file__).parent.parent).with_suffix("").parts
    return getattr(importlib.import_module(".".join(parts)), argument.id)


def known() -> set[str]:
    """Packages of pyproject.toml, and what those bring that vrcomfort itself depends on."""
    own = {name_of(each) for each in PROJECT["dependencies"]}
    extra = {name_of(each) for listed in EXTRAS.values() for each in listed}
    brought = {name_of(each) for name in own & {"pyopenxr"} for each in requires(name) or ()}
    return own | extra | brought


def test_every_remedy_names_packages_of_the_project():
    root = Path(vrcomfort.__file__).parent
    names = set()
    for file in root.rglob("*.py"):
        text = file.read_text("utf-8")
        assert file.name == "errors.py" or "pip install" not in text, (
            f"{file}: errors.pip_install says what to type"
        )
        for node in ast.walk(ast.parse(text)) if "pip_install" in text else ():
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "pip_install":
                names |= {
                    name_of(text_of(each, file))
                    for each in node.args
                    if not isinstance(each, ast.Attribute)  # of EXTRAS, see below
                }
    assert {"pylsl", "pyserial", "miniaudio", "distributed", "pyopenxr"} <= names
    assert names <= known()


def test_what_the_pages_say_to_install_is_the_checkout_or_a_package_of_the_project():
    said = 0
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for _, packages in REMEDY.findall(page.read_text("utf-8")):
            said += 1
            if from_checkout := re.fullmatch(r"'\.\[([\w,]+)\]'", packages):
                assert set(from_checkout[1].split(",")) <= EXTRAS.keys(), (page.name, packages)
            else:
                assert packages.split()[0].lower() in {".", *known()}, (page.name, packages)
    assert said > 5


def test_the_console_belongs_to_the_installation():
    """A plain `pip install .` runs `--console`."""
    own = {name_of(each) for each in PROJECT["dependencies"]}
    imported = {
        (node.module or "").partition(".")[0]
        for file in (ROOT / "vrcomfort" / "console").glob("*.py")
        for node in ast.walk(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and not node.level
    }
    assert "starlette" in imported
    assert {"starlette", "uvicorn", "websockets"} <= own


def test_doctor_lists_all_extras():
    extras = {name: listed for name, listed in EXTRAS.items() if name != "dev"}
    assert {each.name: [each.package] for each in LISTED} == {
        name: [name_of(each) for each in listed] for name, listed in extras.items()
    }
    assert EXTRAS["dev"][0] == f"vrcomfort[{','.join(sorted(extras))}]"


def remedy(python: Path, path: Path, again: str = "False") -> str:
    """Return what is to be typed where this Python lacks pylsl."""
    code = f"from vrcomfort.errors import pip_install; print(pip_install('pylsl', again={again}))"
    run = subprocess.run(
        [python, "-c", code],
        env={**os.environ, "PYTHONPATH": str(ROOT), "PATH": str(path)},
        capture_output=True,
        text=True,
        check=True,
    )
    return run.stdout.strip()


def test_the_remedy_is_for_the_environment_that_lacks_the_package(tmp_path):
    """Also where it is not active: the first pip of the path may be another's."""
    here = Path(sys.executable)
    assert remedy(here, Path(sysconfig.get_path("scripts"))) == "pip install pylsl"
    command = remedy(here, tmp_path, "True")
    assert command == f"{here} -m pip install --force-reinstall pylsl"
    asked = [*command.split()[:3], "--version"]
    assert subprocess.run(asked, capture_output=True, check=False).returncode == 0


def test_the_remedy_is_for_environments_of_uv_and_of_pipx(tmp_path):
    without_pip = tmp_path / "an environment"
    venv.create(without_pip, symlinks=True)
    python = without_pip / "bin" / "python"
    assert remedy(python, tmp_path) == f'uv pip install --python "{python}" pylsl'
    assert " --reinstall " in remedy(python, tmp_path, "True")
    (without_pip / "pipx_metadata.json").write_text("{}")
    assert remedy(python, tmp_path) == "pipx inject vrcomfort pylsl"


def test_without_the_extra_a_video_is_refused_before_anything_is_drawn(tmp_path):
    """And `doctor` says what to install."""
    (tmp_path / "av.py").write_text("raise ModuleNotFoundError('No module named av', name='av')")
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    command = [sys.executable, "-c", "from vrcomfort.cli import main; main()"]
    trace = ROOT / "scenes" / "temple_walk.csv"
    words = ["play", trace, "--scene", "temple", "--out", "new", "--video", "film.mp4"]
    run = subprocess.run(
        [*command, *words],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 2
    assert re.fullmatch(r"error: videos need PyAV \(.*\); .*pip install av\n", run.stderr)
    assert not (tmp_path / "new").exists()


def test_without_flip_a_reference_is_refused_before_anything_is_drawn(monkeypatch):
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)
    with pytest.raises(vrcomfort.InputError, match=r"FLIP needs flip-evaluator .* install flip-e"):
        vrcomfort.render_views("nosuch", reference_samples=4)
