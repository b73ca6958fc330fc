#!/usr/bin/env python3
"""Print how large the package is and how it hangs together.

    .venv/bin/python scripts/codebase_figures.py

Counts files, lines, classes, protocol classes, imports, public names that are used twice, untyped
dictionaries in `report/`, and docstring summaries that are clauses; measures the longest import
chain, the modules that one other module alone imports, and the modules whose functions run while
a small study is reported. The figures are places to look, not limits.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from types import FrameType

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "vrcomfort"
CLAUSE = re.compile(r"\b(what|who|whom|whose|whoever|whatever)\b", re.IGNORECASE)
UNTYPED = re.compile(r"\b(?:dict|Mapping|MutableMapping)\[str, (?:Any|object)\]")
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
    for module, node in classes(trees):
        if not node.name.startswith("_") and node in trees[module].body:
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


def modules_run_by_a_report() -> int:
    """Count the modules of the package whose functions run while a study of twelve is reported."""
    from vrcomfort.cli import main  # noqa: PLC0415 - only here is the program itself needed

    ran: set[str] = set()

    def called(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_name != "<module>":
            ran.add(frame.f_code.co_filename)

    def vrcomfort(*words: str) -> None:
        sys.argv = ["vrcomfort", *words]
        try:
            main()
        except SystemExit as ended:
            if ended.code:
                raise

    with tempfile.TemporaryDirectory() as folder:
        study = f"{folder}/study"
        vrcomfort("simulate", "smoke", "-n", "12", "--no-frames", "--out", study)
        sys.setprofile(called)
        try:
            vrcomfort("report", study, "--figures", "svg", "--out", f"{folder}/report")
        finally:
            sys.setprofile(None)
    return sum(Path(name).is_relative_to(PACKAGE) for name in ran)


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
        (
            "docstring summaries with what/who/whose",
            f"{100 * sum(map(bool, map(CLAUSE.search, firsts))) / len(firsts):.1f} %",
        ),
        ("names of classes used twice", len(twice)),
    ]
    if not options.static:
        rows.append(("modules run by one report", modules_run_by_a_report()))
    for name, value in rows:
        print(f"{name:42} {value:>9}")
    print("\nused twice: " + (", ".join(twice) or "none"))


if __name__ == "__main__":
    main()
