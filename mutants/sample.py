"""Draws mutants by subpackage on lines that tests cover, or finds those of an earlier run again."""

from __future__ import annotations

import ast
import difflib
import random
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mutants.coverage_map import CoverageMap
from mutants.operators import Site, sites

FEWEST = 5
"""Mutants of a small subpackage."""


@dataclass(frozen=True)
class Module:
    """A module of the package, and where it can be mutated."""

    root: Path
    file: Path
    source: bytes
    sites: tuple[Site, ...]

    @property
    def path(self) -> str:
        """Its path in the checkout."""
        return self.file.relative_to(self.root).as_posix()

    @property
    def subpackage(self) -> str:
        """The folder in the package; modules beside the folders are together."""
        package, *inner = Path(self.path).parts
        return inner[0] if len(inner) > 1 else package


@dataclass
class Mutant:
    """A mutated module, and what became of it."""

    number: int
    module: Module
    site: Site
    covering: list[str]
    """Tests that cover its line, fastest first."""
    status: str = "not tried"
    killer: str | None = None
    run: int = 0
    """Tests that were run."""
    not_run: int = 0
    """Covering tests for which the time was too short."""
    key: tuple[Any, ...] = field(default=(), repr=False)

    @property
    def place(self) -> str:
        """File and line."""
        return f"{self.module.path}:{self.site.line}"

    @property
    def module_name(self) -> str:
        """What is imported."""
        return self.module.path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")

    def text(self) -> bytes:
        """Return the module's text with the mutation."""
        return self.site.mutate(self.module.source)

    def diff(self) -> list[str]:
        """Return the lines that differ."""
        texts = (text.decode().splitlines() for text in (self.module.source, self.text()))
        return [line for line in difflib.unified_diff(*texts, lineterm="", n=0)
                if line[0] in "+-" and line[:3] not in {"---", "+++"}]  # fmt: skip

    def facts(self) -> dict[str, Any]:
        """Return what a report has of it."""
        return {
            "subpackage": self.module.subpackage,
            "place": self.place,
            "key": list(self.key),
            "operator": self.site.operator,
            "diff": self.diff(),
            "status": self.status,
            "killer": self.killer,
            "covering": len(self.covering),
            "run": self.run,
            "not_run": self.not_run,
        }


def modules(root: Path, package: str, only: Iterable[str] | None = None) -> list[Module]:
    """Read the package's modules, or those of some subpackages."""
    read = []
    for file in sorted((root / package).rglob("*.py")):
        source = file.read_bytes()
        module = Module(root, file, source, tuple(sites(source)))
        if not only or module.subpackage in only:
            read.append(module)
    return read


def draw(modules: Sequence[Module], seed: int, count: int, covered: CoverageMap) -> list[Mutant]:
    """Draw mutants: from each subpackage its share of all places, at most one in a line.

    All places are put in a random order that only the code and the seed decide; the first ones that
    tests cover are taken.
    """
    by_subpackage: dict[str, list[tuple[Module, Site]]] = defaultdict(list)
    for module in modules:
        by_subpackage[module.subpackage] += [(module, site) for site in module.sites]
    tests: dict[Path, dict[int, list[str]]] = {}
    drawn: list[Mutant] = []
    shares = _shares({name: len(places) for name, places in by_subpackage.items()}, count)
    for name, places in sorted(by_subpackage.items()):
        random.Random(f"{seed} {name}").shuffle(places)  # noqa: S311 - no secret
        taken: set[tuple[Path, int]] = set()
        for module, site in places:
            if len(taken) == shares[name]:
                break
            if module.file not in tests:
                tests[module.file] = covered.tests_by_line(module.file)
            covering = tests[module.file].get(site.line)
            if covering and (module.file, site.line) not in taken and _compiles(module, site):
                taken.add((module.file, site.line))
                key = _keys(module)[site]
                drawn.append(Mutant(len(drawn), module, site, covering, key=key))
    return drawn


def _shares(sizes: dict[str, int], count: int) -> dict[str, int]:
    total = sum(sizes.values())
    return {
        name: min(size, max(min(FEWEST, count), round(count * size / total)))
        for name, size in sizes.items()
    }


def _compiles(module: Module, site: Site) -> bool:
    try:
        ast.parse(site.mutate(module.source))
    except SyntaxError:
        return False
    return True


def _keys(module: Module) -> dict[Site, tuple[Any, ...]]:
    """Return what tells a place from others of its module, wherever its lines have moved."""
    seen: Counter[tuple[str, ...]] = Counter()
    keys = {}
    for site in module.sites:
        before = module.source[site.start : site.end].decode()
        same = (module.path, site.function, site.operator, before, site.after)
        seen[same] += 1
        keys[site] = (*same, seen[same])
    return keys


def found_again(
    modules: Sequence[Module], earlier: Sequence[dict[str, Any]], covered: CoverageMap
) -> list[Mutant]:
    """Return the mutants of an earlier run, but for those whose code has changed.

    Tests need not cover their lines any more.
    """
    wanted = {tuple(each["key"]) for each in earlier}
    found = []
    for module in modules:
        tests = None
        for site, key in _keys(module).items():
            if key in wanted:
                tests = covered.tests_by_line(module.file) if tests is None else tests
                covering = tests.get(site.line, [])
                found.append(Mutant(len(found), module, site, covering, key=key))
    return found
