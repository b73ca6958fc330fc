"""Tries one mutant: imports it in place of its module, and runs tests until one fails."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType
from typing import Any

import pytest

from mutants.child import PYTEST

VARIABLE = "MUTANT_OF_A_MODULE"
"""Environment variable with module name and file of the mutated text, for programs tests start."""


class _Loader(importlib.machinery.SourceFileLoader):
    """Loads a mutated text as if it stood in the module's own file."""

    def __init__(self, name: str, path: str, text: bytes) -> None:
        super().__init__(name, path)
        self._text = text

    def get_code(self, _name: str) -> CodeType:
        """Compile the mutated text, not what was compiled before."""
        return compile(self._text, self.path, "exec", dont_inherit=True)  # type: ignore[no-any-return]


class Finder:
    """Finds one module's mutant, and leaves the others to those that follow it."""

    def __init__(self, module: str, text: bytes) -> None:
        self._module, self._text = module, text

    def find_spec(self, name: str, path: Sequence[str] | None, _target: Any = None) -> Any:
        """Return the module's place with the mutant's loader, or None for another module."""
        if name != self._module:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is None or spec.origin is None:
            return None
        return importlib.util.spec_from_file_location(
            name,
            spec.origin,
            loader=_Loader(name, spec.origin, self._text),
            submodule_search_locations=spec.submodule_search_locations,
        )


def install_from_environment() -> None:
    """Put the mutant in place in a program that a test has started."""
    if VARIABLE in os.environ:
        module, _, file = os.environ[VARIABLE].partition("=")
        sys.meta_path.insert(0, Finder(module, Path(file).read_bytes()))


def install(module: str, text: bytes, folder: Path) -> None:
    """Put a mutant in place here, and in the Python programs that are started from here."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "mutant.txt"
    file.write_bytes(text)
    (folder / "sitecustomize.py").write_text(
        "from mutants.trial import install_from_environment\ninstall_from_environment()\n", "utf-8"
    )
    os.environ[VARIABLE] = f"{module}={file}"
    paths = [str(folder), str(Path(__file__).parent.parent), os.environ.get("PYTHONPATH", "")]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
    install_from_environment()


class _Chosen:
    """A pytest plugin: only some tests, in a given order; notes those that fail."""

    def __init__(self, tests: Sequence[str]) -> None:
        self._order = {test: place for place, test in enumerate(tests)}
        self.failed: list[str] = []
        self.run = 0

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Keep and sort."""
        kept = [item for item in items if item.nodeid in self._order]
        items[:] = sorted(kept, key=lambda item: self._order[item.nodeid])

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note a file that cannot be imported."""
        if report.failed:
            self.failed.append(report.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note what failed."""
        self.run += report.when == "call"
        if report.failed:
            self.failed.append(report.nodeid)


def run_tests(
    tests: Sequence[str], root: Path, folder: Path, *, go_on: bool = False
) -> dict[str, Any]:
    """Run tests in their order until one fails; return those that failed, and how many ran."""
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    chosen = _Chosen(tests)
    options = [*PYTEST, f"--basetemp={folder / 'tmp'}"]
    code = pytest.main(
        [
            *options,
            *([] if go_on else ["-x"]),
            f"--rootdir={root}",
            *(str(root / f) for f in files),
        ],
        plugins=[chosen],
    )
    if code not in {0, 1} and not chosen.failed:  # conftest.py cannot be imported
        chosen.failed.append(f"pytest ends with {int(code)}")
    return {"failed": chosen.failed, "run": chosen.run}
