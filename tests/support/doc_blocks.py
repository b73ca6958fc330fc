"""The code blocks of the documentation, and what their commands need to run in a test."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from tests.support.places import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
FENCED = re.compile(r"^( *)```(\w*)\n(.*?)^\1```", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block: its page, language and text, and its number among those of the page."""

    page: str
    language: str
    number: int
    text: str

    def __str__(self) -> str:
        return f"{self.page.removesuffix('.md')}-{self.number}"

    @property
    def commands(self) -> list[str]:
        """Return its lines, continued ones joined."""
        lines = self.text.replace("\\\n", " ").splitlines()
        return [line.strip() for line in lines if line.strip()]


def blocks(*languages: str) -> Iterator[Block]:
    """Yield the blocks of some languages, page by page."""
    for page in PAGES:
        for number, found in enumerate(FENCED.finditer(page.read_text("utf-8")), 1):
            if found[2] in languages:
                text = re.sub(rf"^{found[1]}", "", found[3], flags=re.MULTILINE)
                yield Block(page.name, found[2], number, text)


SHORT = "--exposure-s 0.1 --size 16x20 --refresh-hz 10"
SHORTER = (
    (r"(vrcomfort run .*)--headset openxr", r"\1--headset playback"),
    (r"(vrcomfort run .*)", rf"\1 --respondent simulated {SHORT}"),
    (r"(vrcomfort run .*)--participant P01", r"\1--participant P90"),  # P01 has been there
    (r"--participants 2 --exposure-s 1 --refresh-hz 30", "--participants 1"),
    (r"(vrcomfort simulate .*)", rf"\1 {SHORT}"),
    (r"(vrcomfort report (?!.*--list-plans).*)", r"\1 --figures none"),
    (r"(vrcomfort check (?!.*--no-draw).*)", r"\1 --no-draw"),
    (r"--participants 8:60", "--participants 8:16:4"),
    (r"(vrcomfort power .*)", r"\1 --studies 100"),
    (r"(vrcomfort preflight .*)", r"\1 --headset playback --seconds 0.1 --size 16x20"),
    (r"(vrcomfort play .*)", r"\1 --size 16x20"),
    (r"--from-s 65 --to-s 70", "--from-s 0 --to-s 300"),
)
"""What shortens a command, or puts the playback headset in the place of a real one."""

ELSEWHERE = {
    r"make ": "the gate runs them",
    r"pip install ": "tests/project/test_installation.py compares the names with pyproject.toml",
    r".* --cluster ": "tests/recordings/test_recordings.py, with a cluster of its own",
    r"Rscript ": "tests/report/test_reproduce.py",
    r".* --console": "tests/console/test_cli.py; it waits for an operator",
    r"scripts/in_runtime.sh ": "tests/headset/openxr/test_monado.py, in a runtime",
    r"python -m bench": "minutes; tests/project/test_bench.py",
    r".venv/bin/python -m torture": "an hour; tests/project/test_torture.py",
    r"vrcomfort tradeoff ": "minutes to hours; tests/tradeoff/test_command.py",
}
"""Commands that other tests run, or that nothing can shorten."""


def shortened(command: str) -> str:
    """Return a command without its comment, as a test runs it."""
    command = re.sub(r"\s+# .*", "", command)
    for long, short in SHORTER:
        command = re.sub(long, short, command)
    return command
