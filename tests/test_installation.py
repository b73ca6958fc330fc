"""What is to be typed where a package is missing can be typed, however vrcomfort was installed."""

from __future__ import annotations

import ast
import importlib
import re
import tomllib
from importlib.metadata import requires
from pathlib import Path

import vrcomfort

ROOT = Path(__file__).resolve().parent.parent
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
                names |= {name_of(text_of(each, file)) for each in node.args}
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
