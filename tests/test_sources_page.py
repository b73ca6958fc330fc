"""Every test, protocol, plan, instrument and scene that the page of sources names is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from vrcomfort.resources import data_folder

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "sources.md").read_text(encoding="utf-8")


def named() -> list[tuple[str, str]]:
    """Return (file, test) of each; a test without a file belongs to the file named before it."""
    rows = "\n".join(line for line in PAGE.splitlines() if line.startswith("|"))
    found, file = [], ""
    for place, test in re.findall(r"`(test_\w+\.py)?(?:::(test_\w+))?`", rows):
        file = place or file
        if place or test:
            found.append((file, test))
    return found


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
