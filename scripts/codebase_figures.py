#!/usr/bin/env python3
"""Print how large the package is and how it hangs together.

    .venv/bin/python scripts/codebase_figures.py

Counts files, lines, classes, protocol classes, imports, public names that are used twice, untyped
dictionaries in `report/`, and docstring summaries that are clauses; measures the longest import
chain, the modules that one other module alone imports, and the modules whose functions run while
a small study is reported. The figures are places to look, not limits.

Forms of an SSQ answer: a study of two simulated participants is recorded and reported, and at every
call and return of a function of the package its arguments and its result, and the first 40 members
of each, are looked through for the answer to one item of the SSQ. A form is a type that has the
item beside an answer: a dataclass with the item's name and a number in its fields, a mapping with
it as a key, a data frame with it as a column or in the column `item`, a line of CSV. The
questionnaire's own types, which have the items without answers, do not count. Passed are the
modules of the functions whose arguments or results have a form.
"""

from __future__ import annotations

import argparse
import ast
import dataclasses
import re
import sys
import tempfile
import threading
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "vrcomfort"
CLAUSE = re.compile(r"\b(what|who|whom|whose|whoever|whatever)\b", re.IGNORECASE)
UNTYPED = re.compile(r"\b(?:dict|Mapping|MutableMapping)\[str, (?:Any|object)\]")
SUBSCRIPT = re.compile(r'\["[a-z_0-9]+"\]')
DEFINITIONS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def modules() -> dict[str, ast.Module]:
    """Return the syntax trees of the package's modules by their dotted names."""
    trees = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(ROOT).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        trees[name] = ast.parse(file.read_text(encoding="utf-8"))
    return trees


def imports_of(trees: Mapping[str, ast.Module]) -> dict[str, set[str]]:
    """Return the modules of the package that each module imports, wherever in the module."""
    found: dict[str, set[str]] = {name: set() for name in trees}
    for name, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                found[name] |= {each.name for each in node.names if each.name in trees}
            elif isinstance(node, ast.ImportFrom) and node.module in trees:
                submodules = {f"{node.module}.{each.name}" for each in node.names}
                found[name] |= (submodules & trees.keys()) or {node.module}
        found[name].discard(name)
    return found


def longest_chain(imports: Mapping[str, set[str]]) -> list[str]:
    """Return the longest chain of modules, each of which imports the next."""

    @cache
    def below(name: str) -> tuple[str, ...]:
        return (name, *max((below(each) for each in sorted(imports[name])), key=len, default=()))

    return list(max((below(name) for name in imports), key=len))


def single_importers(imports: Mapping[str, set[str]]) -> int:
    """Count the modules that exactly one other module imports."""
    importers = Counter(each for names in imports.values() for each in names)
    return sum(count == 1 for count in importers.values())


def classes(trees: Mapping[str, ast.Module]) -> Iterator[tuple[str, ast.ClassDef]]:
    """Yield each class with the module that defines it."""
    for name, tree in trees.items():
        yield from ((name, node) for node in ast.walk(tree) if isinstance(node, ast.ClassDef))


def is_protocol(node: ast.ClassDef) -> bool:
    """Return whether a class is a typing.Protocol."""
    return any(ast.unparse(base).split("[")[0] == "Protocol" for base in node.bases)


def names_used_twice(trees: Mapping[str, ast.Module]) -> dict[str, list[str]]:
    """Return the public classes' names that more than one module defines, with the modules."""
    places: dict[str, list[str]] = defaultdict(list)
    for module, tree in trees.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(module)
    return {name: where for name, where in sorted(places.items()) if len(where) > 1}


def summaries(trees: Mapping[str, ast.Module]) -> list[str]:
    """Return the first paragraph of every docstring."""
    docs = (
        ast.get_docstring(node)
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, DEFINITIONS)
    )
    return [doc.split("\n\n")[0] for doc in docs if doc]


def vrcomfort(*words: str) -> None:
    """Run a command in this process."""
    from vrcomfort.cli import main  # noqa: PLC0415 - only here is the program itself needed

    sys.argv = ["vrcomfort", *words]
    try:
        main()
    except SystemExit as ended:
        if ended.code:
            raise


@contextmanager
def profiled(see: Callable[[FrameType, str, object], None]) -> Iterator[None]:
    """Show every call and return of a function of the package."""

    def called(frame: FrameType, event: str, result: object) -> None:
        code = frame.f_code
        if code.co_name != "<module>" and code.co_filename.startswith(f"{PACKAGE}/"):
            see(frame, event, result)

    threading.setprofile(called)
    sys.setprofile(called)
    try:
        yield
    finally:
        sys.setprofile(None)
        threading.setprofile(None)


def modules_run_by_a_report() -> int:
    """Count the modules of the package whose functions run while a study of twelve is reported."""
    ran: set[str] = set()
    with tempfile.TemporaryDirectory() as folder:
        study = f"{folder}/study"
        vrcomfort("simulate", "smoke", "-n", "12", "--no-draw", "--out", study)
        with profiled(lambda frame, _event, _result: ran.add(frame.f_code.co_filename)):
            vrcomfort("report", study, "--figures", "svg", "--out", f"{folder}/report")
    return len(ran)


ITEM = "stomach_awareness"
"""An item of the SSQ whose name is that of no score."""
LINE_OF_CSV = re.compile(rf"\b{ITEM},\d")
MOST_MEMBERS, DEEPEST = 40, 1


def forms_in(value: object, depth: int = DEEPEST) -> set[str]:
    """Return the types that have the item's answer in a value; see the head of this file."""
    kind = type(value)
    if isinstance(value, str | bytes):
        text = value if isinstance(value, str) else value.decode(errors="replace")
        return {"line of CSV"} if ITEM in text and LINE_OF_CSV.search(text) else set()
    if kind.__name__ == "DataFrame":
        items = value.columns  # type: ignore[attr-defined]
        there = ITEM in items or ("item" in items and ITEM in set(value["item"]))  # type: ignore[index]
        return {"DataFrame"} if there else set()
    if kind.__module__.startswith("vrcomfort.questionnaire"):
        return set()
    members: list[object] = []
    if isinstance(value, Mapping):
        if isinstance(value.get(ITEM), str | int | float):
            return {kind.__name__}
        members = list(value.values())
    elif dataclasses.is_dataclass(value):
        members = [getattr(value, each.name, None) for each in dataclasses.fields(value)]
        if any(isinstance(each, str) and each == ITEM for each in members) and any(
            isinstance(each, int | float) or (isinstance(each, str) and each.isdecimal())
            for each in members
        ):
            return {kind.__name__}
    elif isinstance(value, list | tuple):
        members = list(value)
    found = (forms_in(each, depth - 1) for each in members[:MOST_MEMBERS] if depth)
    return set().union(*found)


def forms_of_an_answer() -> tuple[set[str], set[str]]:
    """Return the forms of an SSQ answer from the participant to the page, and the modules."""
    forms: set[str] = set()
    passed: set[str] = set()

    def see(frame: FrameType, event: str, result: object) -> None:
        code = frame.f_code
        names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        values = [result] if event == "return" else [frame.f_locals.get(name) for name in names]
        if event in {"call", "return"} and (found := set().union(*map(forms_in, values))):
            forms.update(found)
            passed.add(code.co_filename)

    with tempfile.TemporaryDirectory() as folder, profiled(see):
        study = f"{folder}/study"
        vrcomfort("simulate", "smoke", "-n", "2", "--no-draw", "--out", study)
        vrcomfort("report", study, "--figures", "none", "--out", f"{folder}/report")
    return forms, passed


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--static", action="store_true", help="run no report")
    options = parser.parse_args()
    trees = modules()
    imports = imports_of(trees)
    texts = [file.read_text(encoding="utf-8") for file in sorted(PACKAGE.rglob("*.py"))]
    of_report = [f.read_text(encoding="utf-8") for f in (PACKAGE / "report").rglob("*.py")]
    all_classes = [node for _, node in classes(trees)]
    firsts = summaries(trees)
    twice = names_used_twice(trees)
    chain = longest_chain(imports)
    rows: list[tuple[str, object]] = [
        ("files", len(trees)),
        ("lines", sum(text.count("\n") for text in texts)),
        ("classes", len(all_classes)),
        ("protocol classes", sum(map(is_protocol, all_classes))),
        ("imports within the package", sum(map(len, imports.values()))),
        ("longest import chain", len(chain)),
        ("modules with one importer", single_importers(imports)),
        ("untyped dictionaries in report/", sum(len(UNTYPED.findall(t)) for t in of_report)),
        ("string subscripts in report/", sum(len(SUBSCRIPT.findall(t)) for t in of_report)),
        (
            "docstring summaries with what/who/whose",
            f"{100 * sum(map(bool, map(CLAUSE.search, firsts))) / len(firsts):.1f} %",
        ),
        ("names of classes used twice", len(twice)),
    ]
    if not options.static:
        rows.append(("modules run by one report", modules_run_by_a_report()))
        forms, passed = forms_of_an_answer()
        rows.append(("forms of an SSQ answer", len(forms)))
        rows.append(("modules that an SSQ answer passes", len(passed)))
    for name, value in rows:
        print(f"{name:42} {value:>9}")
    print("\nused twice: " + (", ".join(twice) or "none"))
    if not options.static:
        print("forms of an SSQ answer: " + ", ".join(sorted(forms)))


if __name__ == "__main__":
    main()
