"""Put faults into the package, and list those that no test notices.

Writes ``mutants.json`` and ``mutants.md``. The checkout stays as it is: mutants are imported in
place of their module. The same seed and code give the same mutants.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from mutants import child, report, sample
from mutants.coverage_map import MARKS, CoverageMap, parts
from mutants.sample import Mutant
from mutants.trial import install, run_tests

FIRST = 10
"""Fastest tests that are run before all others."""


def main() -> None:
    """Read the command line, run, and tell."""
    parser = argparse.ArgumentParser(prog="python -m mutants", description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of the sample (default 0)")
    parser.add_argument("--count", type=int, default=300, help="mutants (default 300)")
    parser.add_argument("--only", nargs="+", metavar="SUBPACKAGE", help="mutate these")
    parser.add_argument("--tests", nargs="+", type=Path, default=[], help="folders (default: all)")
    parser.add_argument("--marks", default=MARKS, help=f"pytest's -m (default: {MARKS})")
    parser.add_argument("--again", type=Path, help="mutants.json whose mutants are tried again")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes at once")
    parser.add_argument("--budget", type=float, default=60.0, metavar="S",
                        help="processor time of the tests of a mutant (default 60)")  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("out/mutants"), help="folder to write to")
    parser.add_argument("--root", type=Path, default=child.ROOT, help=argparse.SUPPRESS)
    parser.add_argument("--package", default="vrcomfort", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    arguments.root = arguments.root.resolve()
    child.prepare()
    covered = _covered(arguments)
    mutants = _sample(arguments, covered)
    facts = {
        "command": " ".join(["python -m mutants", *sys.argv[1:]]),
        "tests": len(covered.cpu_s),
        "marks": arguments.marks,
        "left_out": covered.left_out,
    }
    scratch = Path(tempfile.mkdtemp(prefix="mutants"))
    try:
        Run(arguments, covered, scratch).run(mutants)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
        print(report.write(arguments.out, mutants, facts))


def _covered(arguments: argparse.Namespace) -> CoverageMap:
    wanted = parts(arguments.root, arguments.package, arguments.tests, arguments.marks)
    jobs = {part.tests.name: part.job for part in wanted
            if not (part.folder / "tests.json").exists()}  # fmt: skip
    for name, ended in child.in_children(jobs.items(), arguments.jobs):
        if ended.result is None:
            sys.exit(f"error: tests of {name} could not be mapped; see {jobs[name].log}")
        print(f"mapped: {name}", file=sys.stderr, flush=True)
    return CoverageMap.read([part.folder for part in wanted])


def _sample(arguments: argparse.Namespace, covered: CoverageMap) -> list[Mutant]:
    modules = sample.modules(arguments.root, arguments.package, arguments.only)
    if arguments.again:
        earlier = json.loads(arguments.again.read_text("utf-8"))["mutants"]
        found = sample.found_again(modules, earlier, covered)
        if gone := len(earlier) - len(found):
            print(f"{gone} mutants have gone: their code has changed", file=sys.stderr)
        return found
    return sample.draw(modules, arguments.seed, arguments.count, covered)


class Run:
    """Runs tests on mutants, some at once."""

    def __init__(self, arguments: argparse.Namespace, covered: CoverageMap, scratch: Path) -> None:
        self._arguments, self._covered, self._scratch = arguments, covered, scratch

    def run(self, mutants: list[Mutant]) -> None:
        """Try each mutant with the fastest tests, those left with more, and the killers without."""
        for stage, tried in ((self._first, "not tried"), (self._rest, "survived")):
            chosen = [(mutant, stage(mutant)) for mutant in mutants if mutant.status == tried]
            jobs = ((mutant, self._job(mutant, tests)) for mutant, tests in chosen if tests)
            for mutant, ended in child.in_children(jobs, self._arguments.jobs):
                _judge(mutant, ended)
                told = f"{mutant.place}: {mutant.status} {mutant.killer or ''}"
                print(told, file=sys.stderr, flush=True)
            for mutant, tests in chosen:
                mutant.status = mutant.status if tests else "survived"
        self._check_killers(mutants)

    def _first(self, mutant: Mutant) -> list[str]:
        return mutant.covering[:FIRST]

    def _rest(self, mutant: Mutant) -> list[str]:
        """Return the other covering tests, then those beside them, within the budget.

        Tests beside them may use what another test has made and a cache has kept.
        """
        files = {test.partition("::")[0] for test in mutant.covering}
        covering = set(mutant.covering)
        beside = {test for test in self._covered.cpu_s
                  if test.partition("::")[0] in files and test not in covering}  # fmt: skip
        chosen, left_s = [], self._arguments.budget
        following = [*mutant.covering[FIRST:], *self._covered.fastest_first(beside)]
        for test in following:
            left_s -= self._covered.cpu_s[test]
            if left_s < 0:
                break
            chosen.append(test)
        mutant.not_run = len(mutant.covering[FIRST:]) - len(covering.intersection(chosen))
        return sorted(chosen, key=lambda test: (test.partition("::")[0], self._covered.cpu_s[test]))

    def _job(self, mutant: Mutant, tests: list[str]) -> child.Job:
        folder = self._scratch / f"{mutant.number}-{len(tests)}"
        expected_s = sum(self._covered.cpu_s[test] for test in tests)
        function = partial(
            _try, mutant.module_name, mutant.text(), tests, self._arguments.root, folder
        )
        return child.Job(function, 20 + 3 * expected_s, folder / "log.txt")

    def _check_killers(self, mutants: list[Mutant]) -> None:
        """Take back what a test has killed that fails without a mutant, too."""
        killers = sorted(
            {mutant.killer for mutant in mutants if mutant.killer in self._covered.cpu_s}
        )
        folder = self._scratch / "killers"
        function = partial(run_tests, killers, self._arguments.root, folder, go_on=True)
        job = child.Job(function, 3600, folder / "log.txt")
        ((_, ended),) = child.in_children([("killers", job)], 1) if killers else [(None, None)]
        for mutant in mutants:
            if ended and mutant.killer in (ended.result or {"failed": killers})["failed"]:
                mutant.status = "unclear"


def _try(module: str, text: bytes, tests: list[str], root: Path, folder: Path) -> dict[str, Any]:
    install(module, text, folder)
    return run_tests(tests, root, folder)


def _judge(mutant: Mutant, ended: child.Ended) -> None:
    if ended.result is None:
        mutant.status = "timed out" if ended.timed_out else "killed"
        mutant.killer = None if ended.timed_out else "the process died"
        return
    mutant.run += ended.result["run"]
    mutant.status = "survived"
    if ended.result["failed"]:
        mutant.status, mutant.killer = "killed", ended.result["failed"][0]


if __name__ == "__main__":
    main()
