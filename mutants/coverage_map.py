"""Which tests cover which lines, and how long each takes: recorded once for a state of the code.

Files are in ``~/.cache/vrcomfort/mutants``, one folder for each folder of tests and state.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import coverage
import pytest

from mutants.child import PYTEST, Job

MARKS = "not slow and not monado and not browser and not needs_reference_data"
"""Tests that are left out take too long for hundreds of mutants, or need what few machines have."""


def cache_folder() -> Path:
    """Return the folder of all maps."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "vrcomfort" / "mutants"


@dataclass(frozen=True)
class Part:
    """A folder (or file) of tests, whose map is made by one process."""

    root: Path
    package: str
    tests: Path
    marks: str

    @property
    def folder(self) -> Path:
        """Where its map is: the name is a hash of the code, its tests and what tests share.

        Also of where they are, as maps name files by their whole path.
        """
        state = hashlib.sha256(f"{self.tests} {self.marks}".encode())
        shared = [self.root / "tests" / "conftest.py", self.root / "tests" / "support"]
        for place in (self.root / self.package, *shared, self.tests):
            for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
                if file.exists():
                    state.update(f"\0{file.relative_to(self.root)}\0".encode() + file.read_bytes())
        return cache_folder() / state.hexdigest()[:16]

    @property
    def job(self) -> Job:
        """What makes the map."""
        return Job(partial(_record, self, self.folder), 3600, self.folder / "log.txt")


def parts(root: Path, package: str, tests: Sequence[Path], marks: str) -> list[Part]:
    """Return the parts of some folders of tests, or of all."""
    places = tests or [
        each
        for each in sorted((root / "tests").iterdir())
        if each.name.startswith("test_") or (each.is_dir() and any(each.rglob("test_*.py")))
    ]
    return [Part(root, package, each.resolve(), marks) for each in places]


def _record(part: Part, folder: Path) -> bool:
    for old in folder.glob("coverage.sqlite*"):
        old.unlink()
    measured = coverage.Coverage(
        data_file=folder / "coverage.sqlite",
        source=[str(part.root / part.package)],
        config_file=False,
    )
    measured.start()
    recorder = Recorder(measured)
    options = [*PYTEST, "-m", part.marks, f"--rootdir={part.root}"]
    pytest.main([*options, str(part.tests)], plugins=[recorder])
    measured.stop()
    measured.save()
    recorded = {"tests": recorder.tests, "shared": recorder.shared}
    (folder / "tests.json").write_text(json.dumps(recorded), "utf-8")
    return True


def _cpu_s() -> float:
    return sum(os.times()[:4])


class Recorder:
    """A pytest plugin: each test, and each fixture that tests share, is a context of coverage."""

    def __init__(self, measured: coverage.Coverage) -> None:
        self._measured = measured
        self._within = [""]
        self._of_fixtures_s = 0.0
        self.tests: dict[str, dict[str, Any]] = {}
        self.shared: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Function) -> Iterator[None]:
        """Measure a test."""
        defined = getattr(item, "_fixtureinfo", None)
        wider = [
            f"fixture {each.baseid} {each.argname}"
            for found in (defined.name2fixturedefs.values() if defined else ())
            for each in found
            if each.scope != "function"
        ]
        self.tests[item.nodeid] = {"fixtures": sorted(wider), "passed": None}
        self._of_fixtures_s = 0.0
        spent_s = yield from self._in_context(item.nodeid)
        self.tests[item.nodeid]["cpu_s"] = round(spent_s - self._of_fixtures_s, 3)
        return True

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[None]:
        """Measure a fixture that is set up once for several tests."""
        if fixturedef.scope == "function":
            return (yield)
        name = f"fixture {fixturedef.baseid} {fixturedef.argname}"
        before = _cpu_s()
        self._within.append(name)
        self._measured.switch_context(name)
        try:
            return (yield)
        finally:
            self._within.pop()
            self._measured.switch_context(self._within[-1])
            self.shared[name] = _cpu_s() - before
            self._of_fixtures_s += self.shared[name]

    def _in_context(self, name: str) -> Iterator[None]:
        before = _cpu_s()
        self._within.append(name)
        self._measured.switch_context(name)
        yield
        self._within.pop()
        self._measured.switch_context(self._within[-1])
        return _cpu_s() - before

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note whether a test passed."""
        test = self.tests[report.nodeid]
        if report.failed or report.skipped:
            test["passed"] = False
        elif report.when == "call" and test["passed"] is None:
            test["passed"] = True


@dataclass
class CoverageMap:
    """The tests that pass, with what each takes, and the lines that each covers."""

    cpu_s: dict[str, float] = field(default_factory=dict)
    """Of tests that pass, with the fixtures that they share."""
    left_out: list[str] = field(default_factory=list)
    """Tests that do not pass without a mutant."""
    _parts: list[tuple[coverage.CoverageData, dict[str, list[str]]]] = field(default_factory=list)

    @classmethod
    def read(cls, folders: Sequence[Path]) -> CoverageMap:
        """Read the maps of some parts as one."""
        made = cls()
        for folder in folders:
            recorded = json.loads((folder / "tests.json").read_text("utf-8"))
            data = coverage.CoverageData(str(folder / "coverage.sqlite"))
            data.read()
            users = defaultdict(list)
            for test, facts in recorded["tests"].items():
                if not facts["passed"]:
                    made.left_out.append(test)
                    continue
                shared_s = sum(recorded["shared"].get(name, 0.0) for name in facts["fixtures"])
                made.cpu_s[test] = facts["cpu_s"] + shared_s
                for name in (test, *facts["fixtures"]):
                    users[name].append(test)
            made._parts.append((data, dict(users)))
        return made

    def tests_by_line(self, module: Path) -> dict[int, list[str]]:
        """Return line → tests that cover it, fastest first."""
        found: dict[int, set[str]] = defaultdict(set)
        for data, users in self._parts:
            for line, contexts in data.contexts_by_lineno(str(module)).items():
                for context in contexts:
                    found[line].update(users.get(context, ()))
        return {line: self.fastest_first(tests) for line, tests in found.items() if tests}

    def fastest_first(self, tests: set[str]) -> list[str]:
        """Sort tests by what they take, then by name."""
        return sorted(tests, key=lambda test: (self.cpu_s[test], test))
