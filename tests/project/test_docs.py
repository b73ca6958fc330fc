"""The documentation: its commands are words that the program takes, and its pages are there."""

from __future__ import annotations

import ast
import re
import runpy
import shlex
import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.main import get_command

from tests.support.browser import open_page
from tests.support.places import ROOT
from vrcomfort.cli.app import COMMANDS, app

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
PROSE = runpy.run_path(str(ROOT / "scripts" / "prose.py"))


def blocks(page: Path, language: str) -> Iterator[str]:
    """Yield the code blocks of a language on a page."""
    for found in BLOCK.finditer(page.read_text("utf-8")):
        if found[1] == language:
            yield found[2]


def command_lines(page: Path) -> Iterator[list[str]]:
    """Yield the words of each line of a page's shell blocks that calls the program."""
    for block in blocks(page, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            for ends in ("|", ">", "&&"):
                words = words[: words.index(ends)] if ends in words else words
            if words[:1] == ["vrcomfort"]:
                yield words[1:]


def test_every_command_of_a_page_has_options_that_are_there() -> None:
    commands = get_command(app)
    for page in PAGES:
        for words in command_lines(page):
            if words[0].startswith("-"):
                continue
            assert words[0] in COMMANDS, (page.name, words)
            command = commands.get_command(None, words[0])
            context = typer.Context(command, info_name=words[0])
            command.make_parser(context).parse_args(args=list(words[1:]))


def test_a_misspelt_option_would_be_found() -> None:
    command = get_command(app).get_command(None, "report")
    with pytest.raises(Exception, match="--plam"):
        command.make_parser(typer.Context(command)).parse_args(args=["x", "--plam", "y"])


def test_python_of_pages_can_be_read() -> None:
    for page in PAGES:
        for text in blocks(page, "python"):
            ast.parse(text, page.name)


def test_pages_that_are_named_in_the_package_are_there() -> None:
    named = {
        name or other
        for file in (ROOT / "vrcomfort").rglob("*.py")
        for name, other in re.findall(
            r"\bdocs/([a-z_]+)\.md|vrcomfort docs ([a-z_]+)", file.read_text("utf-8")
        )
    }
    assert "tutorial" in named
    assert {name for name in named if not (ROOT / "docs" / f"{name}.md").is_file()} == set()


def test_printed_text_names_no_file_that_only_the_repository_has() -> None:
    """Not everybody has it: pages are opened by `vrcomfort docs`.

    Headers of pages in the repository may name the scripts that write them.
    """
    written = ("protocol/reference.py", "records/schema.py")
    named = re.compile(r"\b(docs|examples|scenes|bench|analysis)/\w+\.\w")
    modules = {
        file: text
        for file in sorted((ROOT / "vrcomfort").rglob("*.py"))
        if not file.as_posix().endswith(written) and named.search(text := file.read_text("utf-8"))
    }
    assert modules, "comments and docstrings name some"
    found = [
        f"{file.relative_to(ROOT)}, line {text.lineno}: {text.value}"
        for file, module in modules.items()
        for text in _printed(ast.parse(module), "cli" in file.parts)
        if named.search(text.value)
    ]
    assert found == []


def _printed(tree: ast.Module, is_command: bool) -> Iterator[ast.Constant]:
    """Yield the texts of a module; docstrings where they are the help of commands."""
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        if node.body and isinstance(node.body[0], ast.Expr)
        if not (is_command and isinstance(node, ast.FunctionDef))
    } | {
        id(line.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef)
        for line in node.body
        if isinstance(line, ast.Expr)
    }
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
        if is_text and id(node) not in docstrings:
            yield node


def test_the_page_of_commands_is_that_of_the_program() -> None:
    written = runpy.run_path(str(ROOT / "scripts" / "command_reference.py"))["page"]()
    page = ROOT / "docs" / "commands.md"
    assert page.read_text("utf-8") == written, "run python scripts/command_reference.py"


def test_the_readme_is_short() -> None:
    text = BLOCK.sub("", (ROOT / "README.md").read_text("utf-8"))
    assert len(re.sub(r"\]\([^)]*\)", "]", text).split()) <= 500


GENERATED = {"commands.md", "data_dictionary.md", "licences.md", "protocol_reference.md"}
"""Pages that scripts write, whose sentences stand in the code."""


def prose(page: Path) -> Any:
    return PROSE["prose_of"](page.read_text("utf-8"))


def test_the_documentation_is_short() -> None:
    words = {page.name: prose(page).words for page in PAGES if page.name not in GENERATED}
    assert sum(words.values()) <= 35_000
    assert {name: count for name, count in words.items() if count > 1500} == {}


def test_sentences_are_short() -> None:
    for page in (*PAGES, ROOT / "CONVENTIONS.md"):
        if page.name in GENERATED:
            continue
        found = prose(page)
        assert statistics.median(found.lengths or [0]) <= 17, page.name
        assert [each for each in found.sentences if PROSE["count"](each) > PROSE["LONGEST"]] == []


def test_words_and_sentences_are_counted_without_code_and_tables() -> None:
    found = PROSE["prose_of"](
        "# A title\n\nOne `vrcomfort run x` here, e.g. this. And (a [second](x.md#y) one)! "
        "3.5 m is\nfar.\n- an item\n- **another**: it. Ends\n"
        "\n| a | b |\n|---|---|\n| no | no |\n\n"
        "```sh\nno words here\n```\n<!-- none -->\n![no](x.png)\n"
    )
    assert found.headings == ("A title",)
    assert found.lengths == [5, 4, 4, 2, 2, 1]
    assert found.words == 20


def test_the_readmes_protocol_has_no_fault(run, tmp_path: Path) -> None:
    (text,) = blocks(ROOT / "README.md", "toml")
    (tmp_path / "lens_study.toml").write_text(text, encoding="utf-8")
    code, _, _ = run("design", tmp_path / "lens_study.toml", "--participants", 4)
    assert code == 0


def test_list_names_what_is_shipped(run) -> None:
    for kind, known in {"scenes": "temple", "effects": "vignette", "tasks": "aiming"}.items():
        code, out, _ = run("list", kind)
        assert code == 0
        name, title = next(line for line in out.splitlines() if line.startswith(known)).split(
            maxsplit=1
        )
        assert name == known
        assert title.strip()


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(out)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr  # a warning is an error
    return out


@pytest.mark.slow
def test_the_site_has_all_pages_and_asks_nobody_else_for_anything(site: Path) -> None:
    pages = {each.stem for each in (ROOT / "docs").glob("*.md")}
    assert pages - {each.stem for each in site.glob("*.html")} == set()
    elsewhere = re.compile(r'<(?:script|link|img)[^>]*(?:src|href)="?https?://(?!\S*canonical)')
    assert [page.name for page in site.glob("*.html") if elsewhere.search(page.read_text())] == []


@pytest.mark.slow
@pytest.mark.browser
def test_the_site_is_searched_from_a_file(site: Path, browser: str) -> None:
    page = site / "find.html"
    page.write_text('<meta http-equiv="refresh" content="0; url=index.html?q=Wilcoxon">')
    opened = open_page(browser, page)
    results = re.findall(r'href="([^"]*)" class="md-search-result__link"', opened.dom)
    assert any("statistics.html" in each for each in results)
    assert opened.console == ()
