"""Every test, protocol, plan, instrument and scene that the page of sources names is there."""

from __future__ import annotations

import re

import pytest

from tests.support.places import ROOT
from vrcomfort.resources import data_folder

PAGE = (ROOT / "docs" / "sources.md").read_text(encoding="utf-8")


def named() -> list[tuple[str, str]]:
    """Return (file, test) of each; a test without a file belongs to the file named before it."""
    rows = "\n".join(line for line in PAGE.splitlines() if line.startswith("|"))
    found, file = [], ""
    for place, test in re.findall(r"`([\w/]*test_\w+\.py)?(?:::(test_\w+))?`", rows):
        file = place or file
        if place or test:
            found.append((file, test))
    return found


def rows() -> list[str]:
    """Return the rows of all tables, without their heads."""
    lines = PAGE.splitlines()
    is_rule = [bool(re.fullmatch(r"\|[-|]+\|", line)) for line in [*lines, ""]]
    return [
        line
        for number, line in enumerate(lines)
        if line.startswith("|") and not is_rule[number] and not is_rule[number + 1]
    ]


def commands() -> list[str]:
    """Return the commands with arguments that rows name, each once."""
    found = re.findall(r"`((?:vrcomfort|python -m bench) [a-z-]+ [^`]*)`", "\n".join(rows()))
    return [each for each in dict.fromkeys(found) if "NAME" not in each]


NOT_SHOWN = r"not shown: (?:hardware|not published)"
TESTED = ("python -m bench", "vrcomfort tradeoff", "vrcomfort check", "vrcomfort simulate")
"""These have tests of their own, of every shipped protocol."""


def test_every_row_says_what_shows_it():
    assert len(rows()) > 140
    test = r"`(?:::)?[\w/]*test_\w+"
    shown = rf"{test}|`(?:vrcomfort|python -m bench) [^`]+`|{NOT_SHOWN}"
    assert [row for row in rows() if not re.search(shown, row.rpartition(" | ")[2])] == []


@pytest.mark.slow
@pytest.mark.parametrize("command", [each for each in commands() if not each.startswith(TESTED)])
def test_commands_of_rows_run(run, tmp_path, monkeypatch, command):
    (tmp_path / "scenes").symlink_to(data_folder("scenes"))
    monkeypatch.chdir(tmp_path)
    code, _, err = run(*command.replace("--reference 96", "--reference 4").split()[1:])
    assert code == 0, err


def test_every_test_that_is_named_is_there():
    assert len(named()) > 90
    for file, test in named():
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert not test or re.search(rf"^def {test}\b", text, re.M), f"{file}::{test}"


@pytest.mark.parametrize(
    ("pattern", "folder"),
    [
        (r"vrcomfort design (\w+)", "protocols"),
        (r"^\| `(\w+)`[,|` \w]*\|", "protocols"),
        (r"plan `(\w+)`", "analysis"),
        (r"scenes? `(\w+)`", "scenes"),
        (r"instrument = \"(\w+)\"", "instruments"),
    ],
)
def test_what_is_named_ships(pattern, folder):
    names = re.findall(pattern, PAGE, re.M)
    assert names
    for name in names:
        assert (data_folder(folder) / f"{name}.toml").exists(), name


def test_every_shipped_protocol_of_a_study_has_a_row():
    studies = PAGE.partition("## The studies")[2].partition("\n## ")[0]
    shipped = {file.stem for file in data_folder("protocols").glob("*.toml")} - {"smoke"}
    assert shipped <= set(re.findall(r"`(\w+)`", studies))
