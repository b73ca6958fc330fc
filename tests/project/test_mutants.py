"""`make mutants` finds what tests do not notice, and nothing else; the checkout stays as it is."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mutants.coverage_map import MARKS, parts
from mutants.operators import sites
from tests.support.places import ROOT

TEST = "tests/test_calc.py::test_"
CALC = '''\
"""A toy."""

LIMIT = 3


def clip(value: int) -> int:
    """Return a value that is at most LIMIT."""
    if value > LIMIT:
        return LIMIT
    return value


def wait(count: int) -> int:
    waited = 0
    for _ in range(count):
        waited += 1
    return waited


def unused(value: int) -> int:
    return value + 1
'''
TESTS = """\
import subprocess
import sys

import pytest

from toy.calc import clip, wait


@pytest.fixture(scope="module")
def waited():
    return wait(2)


def test_below_the_limit():
    assert clip(1) == 1


def test_above_the_limit_in_a_program():
    clip(9)
    said = subprocess.run([sys.executable, "-c", "from toy.calc import clip; print(clip(9))"],
                          capture_output=True, text=True, check=True)
    assert said.stdout == "3\\n"


def test_without_using_what_is_set_up(waited):
    pass


def test_what_another_has_set_up(waited):
    assert waited == 2


def test_that_fails_anyway():
    assert clip(1) == 2
"""


def test_a_place_is_named_and_replaced_exactly() -> None:
    source = 'def f(a: int, b=1):\n    """1 < 2."""\n    return f"{a + 1}" if a < b else g(ä, b)\n'
    text = source.encode()
    made = {(site.operator, site.mutate(text).decode().splitlines()[-1].strip())
            for site in sites(text)}  # fmt: skip
    assert made == {
        ("return", "return None"),
        ("boundary", 'return f"{a + 1}" if a <= b else g(ä, b)'),
        ("comparison", 'return f"{a + 1}" if a >= b else g(ä, b)'),
        ("swapped", 'return f"{a + 1}" if a < b else g(b, ä)'),
    }


@pytest.mark.parametrize(
    ("statement", "operators"),
    [
        ("x = a and not b", {"and/or", "not"}),
        ("x = a - 2", {"arithmetic", "constant"}),
        ("x.y = -a", {"dropped", "arithmetic"}),
        ("raise a", {"dropped"}),
        ("a(min(b))", {"dropped", "comparison"}),
        ("if a: b()", {"not", "dropped"}),
        ("x: list[1] = a", set()),
        ("return None", set()),
    ],
)
def test_each_statement_has_its_operators(statement: str, operators: set[str]) -> None:
    text = f"def f():\n    {statement}\n".encode()
    found = sites(text)
    assert {site.operator for site in found} == operators
    for site in found:
        assert ast.dump(ast.parse(site.mutate(text))) != ast.dump(ast.parse(text))


def test_checkouts_of_the_same_code_have_maps_of_their_own(tmp_path: Path) -> None:
    """Maps name files by their whole path: that of another checkout would cover no line."""
    folders = set()
    for checkout in ("one", "two"):
        for name, text in (("toy/calc.py", CALC), ("tests/test_calc.py", TESTS)):
            file = tmp_path / checkout / name
            file.parent.mkdir(parents=True)
            file.write_text(text, "utf-8")
        root = tmp_path / checkout
        folders |= {part.folder for part in parts(root, "toy", [root / "tests"], MARKS)}
    assert len(folders) == 2


@pytest.mark.slow
def test_a_toy_package_is_mutated_from_outside(tmp_path: Path) -> None:
    toy, report = tmp_path / "toy/calc.py", tmp_path / "mutants.json"
    for file, text in ((toy, CALC), (tmp_path / "tests/test_calc.py", TESTS)):
        file.parent.mkdir()
        file.write_text(text, "utf-8")

    def run(*more: str) -> dict[str, tuple[str, str | None]]:
        words = ["--root", tmp_path, "--package", "toy", "--count", "9", "--out", tmp_path, *more]
        subprocess.run(
            [sys.executable, "-m", "mutants", *map(str, words)],
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join([str(ROOT), str(tmp_path)]),
                "XDG_CACHE_HOME": str(tmp_path / "cache"),
            },
            cwd=tmp_path,
            check=True,
            capture_output=True,
        )
        found = json.loads(report.read_text("utf-8"))
        assert found["left_out"] == [f"{TEST}that_fails_anyway"]
        return {each["place"]: (each["diff"][-1], each["killer"]) for each in found["mutants"]}

    found = run("--seed", "3")
    assert toy.read_text("utf-8") == CALC
    assert found == {  # one in each line of a function that a test covers
        "toy/calc.py:8": ("+    if value >= LIMIT:", None),  # equivalent
        "toy/calc.py:9": ("+        return None", f"{TEST}above_the_limit_in_a_program"),
        "toy/calc.py:10": ("+    return None", f"{TEST}below_the_limit"),
        "toy/calc.py:14": ("+    waited = 1", f"{TEST}what_another_has_set_up"),
        "toy/calc.py:16": ("+        waited += 0", f"{TEST}what_another_has_set_up"),
        "toy/calc.py:17": ("+    return None", f"{TEST}what_another_has_set_up"),
    }
    tried = json.loads(report.read_text("utf-8"))
    tried["mutants"] = [each for each in tried["mutants"] if each["place"].endswith((":8", ":14"))]
    report.write_text(json.dumps(tried), "utf-8")
    toy.write_text("# moved\n" + CALC.replace("    if value >", "    if 1 + value >"), "utf-8")
    again = run("--again", str(report))
    assert again == {"toy/calc.py:15": found["toy/calc.py:14"]}, "the other's code has changed"


def test_what_never_ends_is_ended(tmp_path: Path) -> None:
    program = f"""\
from pathlib import Path
from mutants.child import Job, in_children
def forever():
    while True: pass
jobs = {{"ends": lambda: 7, "never": forever, "dies": lambda: 1 / 0}}
jobs = [(name, Job(each, 0.1, Path({str(tmp_path)!r}) / name)) for name, each in jobs.items()]
print({{name: (end.result, end.timed_out) for name, end in in_children(jobs, 3)}})
"""
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    ended = {"ends": (7, False), "never": (None, True), "dies": (None, False)}
    assert ast.literal_eval(done.stdout) == ended
